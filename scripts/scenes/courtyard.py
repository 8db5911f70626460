"""The courtyard: 12 x 12 m of paving within walls of 4 m, an arcade along the north side, a pillar in
the middle. Only the sky above is open.

Shapes stand in one another by a few centimetres, so that no ray slips between them.
"""

import math

from scenes.glb import Glb
from scenes.shapes import box, lathe, sphere

HALF, HEIGHT, THICK = 6.0, 4.0, 0.4  # of the yard and its walls
SUNK = 0.05  # how far things stand in the ground and walls in one another
ARCADE_FRONT, ARCADE_TOP = -3.6, 2.9  # z of its columns, underside of its roof

COLOURS = {  # linear albedo
    "paving": (0.44, 0.40, 0.34), "lime wash": (0.78, 0.75, 0.68), "terracotta": (0.62, 0.24, 0.13),
    "ochre": (0.70, 0.48, 0.16), "marble": (0.82, 0.82, 0.80), "tiles": (0.42, 0.15, 0.09),
    "oak": (0.36, 0.20, 0.10), "copper green": (0.18, 0.48, 0.38), }


def pillar(radius, height):
    """Base, shaft with entasis, capital."""
    shaft = [(radius * (1.0 - 0.18 * t * t), 0.3 + (height - 0.6) * t)
             for t in (k / 12 for k in range(13))]
    profile = [(1.5 * radius, -SUNK), (1.5 * radius, 0.15), (1.25 * radius, 0.22), *shaft,
               (1.2 * radius, height - 0.2), (1.45 * radius, height - 0.12),
               (1.45 * radius, height), (0.0, height)]
    n = len(profile)
    return lathe(profile, 32, creases=[1, n - 3, n - 2])


def wall(x0, x1, z0, z1):
    return box((x0, -SUNK, z0), (x1, HEIGHT, z1))


def courtyard():
    glb = Glb("courtyard")
    paint = {name: glb.material(name, rgb) for name, rgb in COLOURS.items()}
    out, inner = HALF + THICK, HALF - SUNK

    def place(name, shape, colour, *places):
        mesh = glb.mesh(name, [(shape, paint[colour])])
        for k, at in enumerate(places or [(0.0, 0.0, 0.0)]):
            glb.node(f"{name} {k + 1}" if len(places) > 1 else name, mesh=mesh,
                     translation=list(at))

    place("paving", box((-out, -0.3, -out), (out, 0.0, out)), "paving")
    place("north wall", wall(-out, out, -out, -HALF), "lime wash")
    place("south wall", wall(-out, out, HALF, out), "lime wash")
    place("west wall", wall(-out + SUNK, -HALF, -HALF - SUNK, HALF + SUNK), "terracotta")
    place("east wall", wall(HALF, out - SUNK, -HALF - SUNK, HALF + SUNK), "ochre")
    place("arcade roof", box((-inner - 2 * SUNK, ARCADE_TOP, -inner - 2 * SUNK),
                             (inner + 2 * SUNK, ARCADE_TOP + 0.25, ARCADE_FRONT + 0.5)), "tiles")
    place("column", pillar(0.2, ARCADE_TOP + SUNK), "lime wash",
          *[(x, 0.0, ARCADE_FRONT) for x in (-4.5, -1.5, 1.5, 4.5)])
    place("pillar", pillar(0.42, 3.2), "marble", (0.3, 0.0, 1.0))
    place("pillar's ball", sphere(0.38, 32, 20), "copper green", (0.3, 3.54, 1.0))
    place("bench", box((-1.1, 0.42, -0.25), (1.1, 0.5, 0.25)), "oak", (-3.6, 0.0, 3.2))
    place("bench leg", box((-0.08, -SUNK, -0.2), (0.08, 0.44, 0.2)), "oak",
          (-4.5, 0.0, 3.2), (-2.7, 0.0, 3.2))
    place("ball", sphere(0.5, 32, 20), "marble", (3.4, 0.47, 3.0))
    glb.camera("camera", (-5.0, 2.1, 5.3), (1.0, 1.2, -2.0), math.radians(62), 4 / 3)
    return glb
