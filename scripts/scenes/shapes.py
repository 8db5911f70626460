"""Triangle shapes. Winding is counter-clockwise seen from the air in front of a surface.

Coordinates are rounded to 10 micrometres, so that the committed bytes do not depend on the last
digit of a machine's sine, and so that neighbouring shapes share their vertices exactly.
"""

import math

import numpy as np

POSITION_DIGITS = 5
NORMAL_DIGITS = 6


class Shape:
    """positions n x 3 (m), normals n x 3, triangles m x 3, uvs n x 2 or None."""

    def __init__(self, positions, normals, triangles, uvs=None):
        self.positions = np.round(np.asarray(positions, float).reshape(-1, 3), POSITION_DIGITS) + 0.0
        self.normals = np.round(np.asarray(normals, float).reshape(-1, 3), NORMAL_DIGITS) + 0.0
        self.triangles = np.asarray(triangles, np.int64).reshape(-1, 3)
        self.uvs = None if uvs is None else np.asarray(uvs, float).reshape(-1, 2)

    def moved(self, offset):
        return Shape(self.positions + np.asarray(offset, float), self.normals, self.triangles,
                     self.uvs)

    def flipped(self):
        """The same surface, seen from the other side."""
        return Shape(self.positions, -self.normals, self.triangles[:, ::-1], self.uvs)

    def dropped_slivers(self):
        """Without triangles that rounding or a pole has left without area."""
        a, b, c = (self.positions[self.triangles[:, k]] for k in range(3))
        keep = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-9
        return Shape(self.positions, self.normals, self.triangles[keep], self.uvs)


def join(shapes):
    offsets = np.cumsum([0] + [len(s.positions) for s in shapes])
    uvs = None if shapes[0].uvs is None else np.concatenate([s.uvs for s in shapes])
    return Shape(np.concatenate([s.positions for s in shapes]),
                 np.concatenate([s.normals for s in shapes]),
                 np.concatenate([s.triangles + o for s, o in zip(shapes, offsets)]), uvs)


def quad(a, b, c, d, uvs=None):
    """Flat (or folded along a-c) quad, counter-clockwise seen from the front."""
    a, b, c, d = (np.asarray(v, float) for v in (a, b, c, d))
    normal = np.cross(c - a, d - b)
    normal /= np.linalg.norm(normal)
    return Shape([a, b, c, d], [normal] * 4, [[0, 1, 2], [0, 2, 3]], uvs)


def box(low, high):
    """Closed box, outsides front."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return join([
        quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),
        quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),
        quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),
        quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),
        quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),
        quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),
    ])


def grid(points, normals, uvs=None):
    """Triangles over points rows x columns x 3; the front is where the normals point."""
    rows, columns, _ = np.shape(points)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b = index[:-1, :-1], index[:-1, 1:]
    c, d = index[1:, 1:], index[1:, :-1]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2)
    return facing_normals(Shape(points, normals, triangles.reshape(-1, 3), uvs)).dropped_slivers()


def lathe(profile, segments, creases=()):
    """Surface of revolution about the y axis.

    `profile`: (radius, height) from bottom to top, the solid on the axis side. At the profile
    points numbered in `creases` the shading normal is not smooth.
    """
    cuts = [0, *sorted(creases), len(profile) - 1]
    pieces = [_lathe_piece(profile[a:b + 1], segments) for a, b in zip(cuts, cuts[1:])]
    return join(pieces)


def _lathe_piece(profile, segments):
    tangents = np.gradient(np.asarray(profile, float), axis=0)
    angles = [2.0 * math.pi * k / segments for k in range(segments)] + [0.0]
    points, normals = [], []
    for (radius, height), (dr, dh) in zip(profile, tangents):
        length = math.hypot(dr, dh)
        n_radial, n_up = dh / length, -dr / length
        points.append([(radius * math.sin(a), height, radius * math.cos(a)) for a in angles])
        normals.append([(n_radial * math.sin(a), n_up, n_radial * math.cos(a)) for a in angles])
    return grid(points, normals)


def sphere(radius, segments, rings):
    """Sphere about the origin."""
    angles = [math.pi * (k / rings - 0.5) for k in range(rings + 1)]
    around = [2.0 * math.pi * k / segments for k in range(segments)] + [0.0]
    normals = [[(math.cos(t) * math.sin(a), math.sin(t), math.cos(t) * math.cos(a)) for a in around]
               for t in angles]
    normals[0] = [(0.0, -1.0, 0.0)] * len(around)
    normals[-1] = [(0.0, 1.0, 0.0)] * len(around)
    return grid(np.multiply(normals, radius), normals)


def torus_knot(p, q, radius, tube, steps, sides):
    """(p, q) torus knot about the y axis, centred at the origin."""

    def centre(t):
        r = radius * (1.0 + 0.45 * math.cos(q * t))
        return np.array([r * math.cos(p * t), 0.45 * radius * math.sin(q * t) * 1.6,
                         r * math.sin(p * t)])

    points, normals = [], []
    for step in range(steps + 1):
        t = 2.0 * math.pi * (step % steps) / steps
        forward = centre(t + 1e-3) - centre(t - 1e-3)
        forward /= np.linalg.norm(forward)
        outward = centre(t + 1e-3) + centre(t - 1e-3)
        side = np.cross(forward, outward)
        side /= np.linalg.norm(side)
        up = np.cross(side, forward)
        ring = [2.0 * math.pi * (k % sides) / sides for k in range(sides + 1)]
        rim = [math.cos(a) * side + math.sin(a) * up for a in ring]
        points.append([centre(t) + tube * n for n in rim])
        normals.append(rim)
    return grid(points, normals)


def facing_normals(shape):
    """Turns the winding round where it disagrees with the shading normals."""
    a, b, c = (shape.positions[shape.triangles[:, k]] for k in range(3))
    mean_normal = shape.normals[shape.triangles].sum(axis=1)
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), mean_normal) < 0
    triangles = shape.triangles.copy()
    triangles[wrong] = triangles[wrong][:, ::-1]
    return Shape(shape.positions, shape.normals, triangles, shape.uvs)


class Opening:
    """An opening of a wall from the floor up: its upper outline as (s, height) from left to right."""

    def __init__(self, left, right, spring, arch_segments=0):
        self.left, self.right, self.spring = left, right, spring
        radius, middle = (right - left) / 2, (left + right) / 2
        n = max(arch_segments, 1)
        if arch_segments:
            angles = [math.pi * (1 - k / n) for k in range(1, n)]
            inner = [(middle + radius * math.cos(a), spring + radius * math.sin(a)) for a in angles]
        else:
            inner = []
        self.outline = [(left, spring), *inner, (right, spring)]


def wall(left, right, bottom, top, openings, place):
    """A wall with openings. `place(s, y)` puts wall coordinates into space; seen from the front, s
    grows to the right."""
    levels = sorted({o.spring for o in openings} | {top})
    columns, s = [], left
    for opening in openings:
        columns.append(((s, bottom), (opening.left, bottom)))
        columns += zip(opening.outline, opening.outline[1:])
        s = opening.right
    columns.append(((s, bottom), (right, bottom)))
    pieces = [_wall_column(a, b, levels, place) for a, b in columns]
    return join(pieces)


def _wall_column(lower_left, lower_right, levels, place):
    """Triangles between two vertical chains; chains of neighbouring columns have equal vertices, so
    that no ray slips through."""
    (s0, y0), (s1, y1) = lower_left, lower_right
    a = [y0] + [v for v in levels if v > y0]
    b = [y1] + [v for v in levels if v > y1]
    points = [place(s0, y) for y in a] + [place(s1, y) for y in b]
    triangles, i, j = [], 0, 0
    while i < len(a) - 1 or j < len(b) - 1:
        if j == len(b) - 1 or (i < len(a) - 1 and a[i + 1] < b[j + 1]):
            triangles.append([i, len(a) + j, i + 1])
            i += 1
        else:
            triangles.append([i, len(a) + j, len(a) + j + 1])
            j += 1
    p = np.asarray(points, float)
    normal = np.cross(p[triangles[0][1]] - p[triangles[0][0]], p[triangles[0][2]] - p[triangles[0][0]])
    normal /= np.linalg.norm(normal)
    return Shape(p, [normal] * len(p), triangles)


def reveal(opening, bottom, levels, place_front, place_back):
    """The inner faces of an opening between a wall's front and back, seen from the opening.
    `levels`: the springs of all openings of that wall, where its columns have vertices."""
    jamb = [bottom] + sorted({v for v in levels if bottom < v < opening.spring})
    chain = ([(opening.left, y) for y in jamb] + opening.outline +
             [(opening.right, y) for y in reversed(jamb)])
    faces = [quad(place_front(*a), place_back(*a), place_back(*b), place_front(*b))
             for a, b in zip(chain, chain[1:])]
    return join(faces)
