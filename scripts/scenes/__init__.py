"""Geometry of the committed scenes; scripts/make_scenes.py writes them."""
