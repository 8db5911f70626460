#!/usr/bin/python3
"""Draws error against cost: plot_sweeps.py results/sweeps.csv indirect results/sweeps_indirect.png

The error is indirect or direct_median. Needs matplotlib (scripts/setup --dev).
"""
import csv
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
from pareto import front

# Axis in the CSV, name and style in the picture.
AXES = {
    "directions": ("directions", "C0-o"),
    "d1": ("d1, depth basis", "C1-s"),
    "d2": ("d2, light basis", "C2-^"),
    "samples": ("samples", "C3-D"),
    "photons": ("photons instead of gather", "C4-v"),
    "example_lights": ("example lights", "C5-P"),
    "compression": ("compression tolerance", "C6-X"),
    "bits": ("16 bits", "C7-*"),
    "together": ("several settings at once", "C8p"),
}
COSTS = {"cpu_seconds": ("CPU seconds of the bake", 1.0), "bytes": ("package, MB", 1e6)}
ERRORS = {
    "indirect": "indirect error, pooled, %",
    "direct_median": "direct error, median over lights, %",
}
TEXTS = ("scene", "axis", "value", "settings")


def read(path):
    """Rows of each scene."""
    scenes = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            row = {k: v if k in TEXTS else float(v) for k, v in row.items()}
            scenes.setdefault(row["scene"], []).append(row)
    return scenes


def setting(row, key):
    return dict(pair.split("=") for pair in row["settings"].split())[key]


def draw(axes, rows, cost, error):
    """One scene: the sweeps through the defaults, and what no other row undercuts."""
    scale = COSTS[cost][1]
    default = next(row for row in rows if row["axis"] == "default")
    for axis, (label, style) in AXES.items():
        swept = [row for row in rows if row["axis"] == axis]
        if not swept:
            continue
        if axis not in ("photons", "together"):  # the others go through the defaults
            swept.append(default | {"value": setting(default, swept[0]["settings"].split("=")[0])})
        swept.sort(key=lambda row: float(row["value"] or 0))
        # Bars: noise of the difference to the defaults, the same lights and references in both.
        axes.errorbar(
            [row[cost] / scale for row in swept], [100 * row[error] for row in swept],
            yerr=[100 * row[f"{error}_gap_error"] for row in swept], fmt=style, label=label,
            markersize=4, linewidth=0.8, elinewidth=0.6)
    best = front([row for row in rows if row[error] > 0.0], cost, error)
    axes.plot([row[cost] / scale for row in best], [100 * row[error] for row in best], "k-",
              linewidth=5, alpha=0.18, zorder=0, label="Pareto front")
    axes.plot(default[cost] / scale, 100 * default[error], "k*", markersize=13, zorder=5,
              label="defaults")
    axes.set(xscale="log", yscale="log")
    for ticks in (axes.xaxis, axes.yaxis):
        ticks.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ticks.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        ticks.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major", color="0.9")


def main():
    path, error, picture = sys.argv[1:]
    scenes = read(path)
    figure, grid = plt.subplots(
        len(COSTS), len(scenes), figsize=(3.5 * len(scenes), 7.2), squeeze=False, sharey="col")
    for column, (scene, rows) in enumerate(scenes.items()):
        for line, cost in enumerate(COSTS):
            draw(grid[line][column], rows, cost, error)
            grid[line][column].set_xlabel(COSTS[cost][0])
        grid[0][column].set_title(f"{scene}, {rows[0]['samples']:.0f} samples", fontsize=10)
    for row in grid:
        row[0].set_ylabel(ERRORS[error])
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=5, fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.savefig(picture, dpi=90)


if __name__ == "__main__":
    main()
