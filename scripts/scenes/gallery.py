"""The gallery: a closed hall of 10 x 6 x 3 m with a barrel vault, an apse, two alcoves, columns,
benches, tables, a shelf and sculptures.

Where two surfaces meet without common vertices they pass through one another by a few centimetres:
then no ray slips between them, and no two faces lie in one plane.
"""

import math

import numpy as np

from scenes.glb import Glb
from scenes.shapes import (Opening, box, grid, join, lathe, quad, reveal, sphere, torus_knot,
                           wall)

WEST, EAST, SOUTH, NORTH = -4.8, 4.0, 3.0, -1.5  # the hall's walls: x, x, z, z
NORTH_BACK, ALCOVE_END = -1.8, -3.0  # the alcoves lie behind the north wall
SPRING, RISE = 2.5, 0.75  # of the vault
SUNK = -0.04  # walls go below the floor, furniture stands in it
OVER = 0.05  # how far a surface passes through another

COLOURS = {  # linear albedo
    "stone floor": (0.42, 0.38, 0.33), "plaster": (0.76, 0.74, 0.69), "vault": (0.80, 0.79, 0.76),
    "red alcove": (0.62, 0.09, 0.06), "blue alcove": (0.07, 0.30, 0.52), "ochre": (0.68, 0.45, 0.12),
    "apse": (0.72, 0.58, 0.28), "marble": (0.82, 0.82, 0.80), "oak": (0.36, 0.20, 0.10),
    "bronze": (0.40, 0.26, 0.12), "green glaze": (0.10, 0.42, 0.20), "clay": (0.60, 0.26, 0.14),
    "canvas": (0.16, 0.10, 0.38), }


def vault():
    """Segmental barrel vault along x; the end walls close it."""
    half = (SOUTH - NORTH) / 2
    middle = (SOUTH + NORTH) / 2
    radius = (half * half + RISE * RISE) / (2 * RISE)
    height = SPRING + RISE - radius
    reach = math.asin((half + OVER) / radius)
    angles = [reach * (1 - 2 * k / 40) for k in range(41)]
    xs = np.linspace(WEST - 2 * OVER, EAST + 2 * OVER, 9)
    points = [[(x, height + radius * math.cos(a), middle + radius * math.sin(a)) for x in xs]
              for a in angles]
    normals = [[(0.0, -math.cos(a), -math.sin(a)) for _ in xs] for a in angles]
    return grid(points, normals)


def north_openings():
    return [Opening(-3.0, -1.6, 1.95), Opening(0.3, 1.7, 1.45, arch_segments=20)]


def north_wall():
    """Both faces of the wall before the alcoves, and the depth of its openings."""
    front = lambda s, y: (s, y, NORTH)
    back = lambda s, y: (s, y, NORTH_BACK)
    openings = north_openings()
    left, right = WEST - OVER, EAST + OVER
    return join([wall(left, right, SUNK, SPRING + OVER, openings, front),
                 wall(left, right, SUNK, SPRING + OVER, openings, back).flipped()] +
                [reveal(o, SUNK, [p.spring for p in openings], front, back) for o in openings])


def alcove(left, right, ceiling):
    """Three walls and a ceiling behind the north wall."""
    z0, z1, high = ALCOVE_END, NORTH_BACK + OVER, ceiling + OVER
    return join([
        quad((left - OVER, SUNK, z0), (right + OVER, SUNK, z0), (right + OVER, high, z0),
             (left - OVER, high, z0)),
        quad((left, SUNK, z1), (left, SUNK, z0 - OVER), (left, high, z0 - OVER), (left, high, z1)),
        quad((right, SUNK, z0 - OVER), (right, SUNK, z1), (right, high, z1),
             (right, high, z0 - OVER)),
        quad((left - OVER, ceiling, z0 - OVER), (right + OVER, ceiling, z0 - OVER),
             (right + OVER, ceiling, z1), (left - OVER, ceiling, z1)),
    ])


APSE_RADIUS, APSE_SPRING, APSE_SEGMENTS = 0.95, 1.5, 24
APSE_MIDDLE = (SOUTH + NORTH) / 2


def east_wall():
    """The wall with the apse's arch. Seen from the hall, s grows with z."""
    opening = Opening(APSE_MIDDLE - APSE_RADIUS, APSE_MIDDLE + APSE_RADIUS, APSE_SPRING,
                      APSE_SEGMENTS)
    return wall(NORTH - OVER, SOUTH + OVER, SUNK, SPRING + RISE + OVER, [opening],
                lambda s, y: (EAST, y, s))


def apse():
    """Half a cylinder and a quarter of a sphere behind the arch, sharing the arch's vertices."""
    around = [math.pi * k / APSE_SEGMENTS for k in range(APSE_SEGMENTS + 1)]
    # Cylinder: from the arch's left jamb round to its right one.
    rim = [(EAST + APSE_RADIUS * math.sin(a), APSE_MIDDLE - APSE_RADIUS * math.cos(a)) for a in around]
    inward = [(-math.sin(a), 0.0, math.cos(a)) for a in around]
    cylinder = grid([[(x, y, z) for x, z in rim] for y in (SUNK, APSE_SPRING)], [inward, inward])
    # Semi-dome: arches that fold from the wall's arch (0) to the cylinder's rim (90 degrees).
    rows = 12
    points, normals = [], []
    for row in range(rows + 1):
        tilt = math.pi / 2 * row / rows
        directions = [(math.sin(a) * math.sin(tilt), math.sin(a) * math.cos(tilt), -math.cos(a))
                      for a in around]
        points.append([(EAST + APSE_RADIUS * x, APSE_SPRING + APSE_RADIUS * y,
                        APSE_MIDDLE + APSE_RADIUS * z) for x, y, z in directions])
        normals.append([(-x, -y, -z) for x, y, z in directions])
    return join([cylinder, grid(points, normals)])


def west_wall():
    """The wall with the door, which stands 0.2 m deep. Seen from the hall, s grows against z."""
    front = lambda s, y: (WEST, y, -s)
    back = lambda s, y: (WEST - 0.2, y, -s)
    door = Opening(-2.75, -1.75, 2.1)
    return join([wall(-SOUTH - OVER, -NORTH + OVER, SUNK, SPRING + RISE + OVER, [door], front),
                 reveal(door, SUNK, [], front, back)])


def column(height):
    """Attic base, shaft with entasis, capital; the square plinth and abacus come as boxes."""
    base = [(0.205, 0.08), (0.215, 0.10), (0.215, 0.12), (0.205, 0.14), (0.18, 0.155), (0.175, 0.18),
            (0.185, 0.195), (0.185, 0.215), (0.155, 0.235)]
    shaft = [(0.150 - 0.028 * t ** 1.8, 0.25 + t * (height - 0.55)) for t in np.linspace(0, 1, 7)]
    top = height - 0.3
    capital = [(0.140, top + 0.03), (0.140, top + 0.055), (0.124, top + 0.07), (0.128, top + 0.12),
               (0.155, top + 0.16), (0.195, top + 0.21), (0.20, top + 0.245)]
    profile = base + shaft + capital
    turned = lathe(profile, 32, creases=(len(base), len(base) + len(shaft) - 1))
    return join([turned, box((-0.22, SUNK, -0.22), (0.22, 0.085, 0.22)),
                 box((-0.215, height - 0.06, -0.215), (0.215, height + 0.02, 0.215))])


def slab_on_legs(length, depth, height, thickness, leg):
    """Bench or table: a slab on four legs that stand in the floor and end inside the slab."""
    x, z = length / 2 - 1.5 * leg, depth / 2 - 1.2 * leg
    legs = [box((sx * x - leg / 2, SUNK / 2, sz * z - leg / 2),
                (sx * x + leg / 2, height - thickness / 2, sz * z + leg / 2))
            for sx in (-1, 1) for sz in (-1, 1)]
    return join([box((-length / 2, height - thickness, -depth / 2), (length / 2, height, depth / 2))]
                + legs)


def shelf():
    """Two uprights and four boards, open at the front and below."""
    boards = [box((-0.61, y, -0.15), (0.61, y + 0.03, 0.15)) for y in (0.18, 0.6, 1.02, 1.44)]
    sides = [box((s * 0.6 - 0.02, SUNK / 2, -0.16), (s * 0.6 + 0.02, 1.55, 0.16)) for s in (-1, 1)]
    return join(boards + sides)


def books():
    """A row of books on two of the boards."""
    row, x, k = [], -0.52, 0
    while x < 0.3:
        width, tall = 0.035 + 0.012 * (k % 3), 0.24 + 0.025 * (k * 7 % 4)
        level = 0.63 if k % 2 else 1.05
        row.append(box((x, level - 0.005, -0.10), (x + width, level + tall, 0.06 + 0.01 * (k % 4))))
        x, k = x + width + 0.012, k + 1
    return join(row)


def vase():
    profile = [(0.055, -0.01), (0.09, 0.03), (0.125, 0.10), (0.135, 0.17), (0.115, 0.25),
               (0.07, 0.31), (0.05, 0.35), (0.055, 0.38), (0.075, 0.41), (0.066, 0.412), (0.045, 0.38),
               (0.04, 0.34), (0.0, 0.33)]
    return lathe(profile, 28, creases=(8, 9))


def picture(width, height):
    """A frame and its canvas, hung on a wall at z = 0."""
    bar, depth, lap = 0.06, 0.05, 0.005
    w, h = width / 2, height / 2
    bars = [box((-w - bar, s - bar / 2, -0.02), (w + bar, s + bar / 2, depth))
            for s in (-h - bar / 2, h + bar / 2)]
    bars += [box((s - bar / 2 + lap, -h - lap, -0.03), (s + bar / 2 - lap, h + lap, depth - lap))
             for s in (-w - bar / 2, w + bar / 2)]
    edge = 0.02  # of the canvas under the frame
    canvas = quad((-w - edge, -h - edge, edge), (w + edge, -h - edge, edge),
                  (w + edge, h + edge, edge), (-w - edge, h + edge, edge))
    return join(bars), canvas


def building(glb, paint):
    """Everything that encloses the air."""
    x0, x1, z0, z1 = WEST - 0.3, EAST + APSE_RADIUS + OVER, ALCOVE_END - OVER, SOUTH + OVER
    floor = quad((x0, 0, z1), (x1, 0, z1), (x1, 0, z0), (x0, 0, z0))
    south = quad((EAST + OVER, SUNK, SOUTH), (WEST - OVER, SUNK, SOUTH),
                 (WEST - OVER, SPRING + OVER, SOUTH), (EAST + OVER, SPRING + OVER, SOUTH))
    door = quad((WEST - 0.15, SUNK, 2.8), (WEST - 0.15, SUNK, 1.7), (WEST - 0.15, 2.15, 1.7),
                (WEST - 0.15, 2.15, 2.8))
    for name, shape, colour in (
            ("floor", floor, "stone floor"), ("vault", vault(), "vault"),
            ("north wall", north_wall(), "plaster"), ("south wall", south, "plaster"),
            ("west wall", west_wall(), "ochre"), ("east wall", east_wall(), "plaster"),
            ("apse", apse(), "apse"), ("door", door, "oak"),
            ("red alcove", alcove(-4.0, -0.9, 2.4), "red alcove"),
            ("blue alcove", alcove(-0.5, 3.4, 2.45), "blue alcove")):
        glb.node(name, mesh=glb.mesh(name, [(shape, paint[colour])]))
    beam = join([box((WEST - OVER, 2.6, z - 0.16), (EAST + OVER, 3.1, z + 0.16)) for z in ROWS])
    cornice = join([box((WEST - OVER, 2.38, NORTH - 0.03), (EAST + OVER, 2.46, NORTH + 0.08)),
                    box((WEST - OVER, 2.38, SOUTH - 0.08), (EAST + OVER, 2.46, SOUTH + 0.03))])
    glb.node("beams", mesh=glb.mesh("beams", [(beam, paint["plaster"])]))
    glb.node("cornice", mesh=glb.mesh("cornice", [(cornice, paint["marble"])]))
    shaft = glb.mesh("column", [(column(2.6), paint["marble"])])
    for z in ROWS:
        for x in COLUMNS:
            glb.node(f"column {x:+.2f} {z:+.2f}", mesh=shaft, translation=[x, 0.0, z])


ROWS = (-0.75, 2.25)  # z of the two rows of columns
COLUMNS = (-3.95, -0.65, 2.65)  # their x
QUARTER_TURN = [0.0, round(math.sqrt(0.5), 7), 0.0, round(math.sqrt(0.5), 7)]  # about y
HALF_TURN = [0.0, 1.0, 0.0, 0.0]


def furniture(glb, paint):
    bench = glb.mesh("bench", [(slab_on_legs(1.4, 0.42, 0.46, 0.06, 0.07), paint["oak"])])
    for k, (x, z, turn) in enumerate([(-2.3, 2.62, None), (1.0, 2.62, None), (-1.9, 0.75, None),
                                      (2.3, -2.65, None), (-4.42, 0.3, QUARTER_TURN)]):
        turned = {"rotation": turn} if turn else {}
        glb.node(f"bench {k + 1}", mesh=bench, translation=[x, 0.0, z], **turned)
    table = glb.mesh("table", [(slab_on_legs(1.5, 0.7, 0.74, 0.05, 0.06), paint["oak"])])
    glb.node("table in the hall", mesh=table, translation=[0.75, 0.0, 0.75])
    glb.node("table in the red alcove", mesh=table, translation=[-2.3, 0.0, -2.55])
    glb.node("shelf", mesh=glb.mesh("shelf", [(shelf(), paint["oak"]), (books(), paint["clay"])]),
             translation=[0.45, 0.0, -2.8])
    frame, canvas = picture(1.1, 0.75)
    for name, colour, place in (
            ("picture south west", "canvas", {"translation": [-2.3, 1.55, SOUTH], "rotation": HALF_TURN}),
            ("picture south east", "clay", {"translation": [1.0, 1.55, SOUTH], "rotation": HALF_TURN}),
            ("picture west", "green glaze", {"translation": [WEST, 1.55, 0.3],
                                             "rotation": QUARTER_TURN})):
        mesh = glb.mesh(name, [(frame, paint["bronze"]), (canvas, paint[colour])])
        glb.node(name, mesh=mesh, **place)


def sculptures(glb, paint):
    pedestal = glb.mesh("pedestal", [(box((-0.24, SUNK / 2, -0.24), (0.24, 0.9, 0.24)),
                                      paint["marble"])])
    for k, (x, z) in enumerate([(4.2, 0.75), (-3.5, -2.5), (3.0, 0.0)]):
        glb.node(f"pedestal {k + 1}", mesh=pedestal, translation=[x, 0.0, z])
    knot = torus_knot(2, 3, 0.25, 0.06, 120, 12)
    glb.node("knot", mesh=glb.mesh("knot", [(knot, paint["bronze"])]), translation=[4.2, 1.11, 0.75])
    ball = sphere(1.0, 32, 20)
    white, green = (glb.mesh(name, [(ball, paint[colour])]) for name, colour in
                    (("marble ball", "marble"), ("green ball", "green glaze")))
    for name, mesh, place, scale in (
            ("ball on the floor", white, (-1.0, 0.3, 1.75), (0.31, 0.31, 0.31)),
            ("ball on the pedestal", green, (3.0, 1.09, 0.0), (0.2, 0.2, 0.2)),
            ("egg", white, (-3.5, 1.14, -2.5), (0.17, 0.25, 0.17))):
        glb.node(name, mesh=mesh, translation=list(place), scale=list(scale))
    for name, colour, place in (("vase", "clay", (0.45, 0.74, 0.65)),
                                ("small vase", "green glaze", (-2.6, 0.74, -2.55))):
        mesh = glb.mesh(name, [(vase(), paint[colour])])
        glb.node(name, mesh=mesh, translation=list(place))


def gallery():
    glb = Glb("gallery")
    paint = {name: glb.material(name, rgb) for name, rgb in COLOURS.items()}
    building(glb, paint)
    furniture(glb, paint)
    sculptures(glb, paint)
    glb.camera("camera", (-3.4, 1.7, 2.2), (0.6, 1.1, -1.35), math.radians(62), 4 / 3)
    glb.point_light("hall lamp", (-1.2, 2.0, 0.6), (9.0, 8.2, 7.0))
    glb.point_light("blue alcove lamp", (1.6, 1.7, -2.3), (3.0, 2.8, 2.4))
    return glb
