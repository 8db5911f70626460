"""The Cornell box by its published measurements (Cornell University Program of Computer Graphics),
1 unit = 1 m, and two small boxes for tests."""

import math

import numpy as np

from scenes.glb import Glb
from scenes.shapes import box, join, quad, sphere

MILLIMETRES_TO_BOX_METRES = 0.01  # published numbers are millimetres; the box becomes 5.5 m wide
WIDTH = 556.0

# Published reflectance spectra, integrated to linear RGB.
WHITE = (0.725, 0.71, 0.68)
RED = (0.63, 0.065, 0.05)
GREEN = (0.14, 0.45, 0.091)

FLOOR = [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]
CEILING = [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]
BACK_WALL = [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]
RIGHT_WALL = [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]
LEFT_WALL = [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]
SHORT_BLOCK = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
TALL_BLOCK = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]
CAMERA = (278, 273, -800)
CAMERA_FOV = 2.0 * math.atan(0.0125 / 0.035)  # film 0.025 wide, focal length 0.035
LAMP = (278, 500, 279.5)  # below the published lamp's centre


def to_metres(p):
    """The published box looks along +z; glTF cameras look along -z. Half a turn about y."""
    return ((WIDTH - p[0]) * MILLIMETRES_TO_BOX_METRES, p[1] * MILLIMETRES_TO_BOX_METRES,
            -p[2] * MILLIMETRES_TO_BOX_METRES)


def facing(points, inside):
    """Quad of published points, front towards `inside`."""
    shape = quad(*[to_metres(p) for p in points])
    middle = shape.positions.mean(axis=0)
    return shape if np.dot(shape.normals[0], np.subtract(inside, middle)) > 0 else shape.flipped()


def block(top):
    """Five faces over the published top; fronts outwards."""
    centre = np.mean([to_metres(p) for p in top], axis=0)
    centre[1] /= 2
    faces = [top] + [[a, b, (b[0], 0, b[2]), (a[0], 0, a[2])] for a, b in zip(top, top[1:] + top[:1])]
    return join([facing(face, inside=centre).flipped() for face in faces])


def cornell():
    glb = Glb("Cornell box, published measurements")
    white, red, green = (glb.material(name, rgb) for name, rgb in
                         (("white", WHITE), ("red", RED), ("green", GREEN)))
    middle = to_metres((278, 274.4, 279.6))
    room = join([facing(f, middle) for f in (FLOOR, CEILING, BACK_WALL)])
    for name, shape, material in (("white walls", room, white),
                                  ("red wall", facing(LEFT_WALL, middle), red),
                                  ("green wall", facing(RIGHT_WALL, middle), green),
                                  ("short block", block(SHORT_BLOCK), white),
                                  ("tall block", block(TALL_BLOCK), white)):
        glb.node(name, mesh=glb.mesh(name, [(shape, material)]))
    glb.camera("camera", to_metres(CAMERA), to_metres((278, 273, 0)), CAMERA_FOV, 1.0)
    glb.point_light("lamp", to_metres(LAMP), (18.0, 15.0, 10.0))
    return glb


def closed_box(albedo=0.5):
    """Cube of side 2 m about the origin, seen from inside: a furnace."""
    glb = Glb("closed box")
    glb.node("box", mesh=glb.mesh("box", [(box((-1, -1, -1), (1, 1, 1)).flipped(),
                                           glb.material("grey", (albedo,) * 3))]))
    glb.camera("camera", (0.0, 0.0, 0.6), (0.0, 0.0, -1.0), math.radians(60), 1.0)
    glb.point_light("lamp", (0.2, 0.3, 0.1), (5.0, 5.0, 5.0))
    return glb


def large_room(triangles=1_000_000):
    """Closed room of side 4 m in which a sphere of about that many triangles stands."""
    glb = Glb("large room")
    rings = max(3, round(math.sqrt(triangles / 4)))
    ball = sphere(0.8, 2 * rings, rings).dropped_slivers()
    parts = [(box((-2, -2, -2), (2, 2, 2)).flipped(), glb.material("grey", (0.5,) * 3)),
             (ball, glb.material("red", (0.6, 0.2, 0.1)))]
    glb.node("room", mesh=glb.mesh("room", parts))
    glb.camera("camera", (0.0, 0.5, 1.8), (0.0, 0.0, -1.0), math.radians(60), 1.0)
    return glb


def checker(size, squares, even, odd):
    y, x = np.mgrid[0:size, 0:size] * squares // size
    return np.where(((x + y) % 2)[..., None], odd, even).astype(np.uint8)


def leaves(size):
    """Round leaves with nothing between them; alpha in steps, as painted foliage has."""
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 4
    distance = np.hypot(x % 1 - 0.5, y % 1 - 0.5)
    image = np.zeros((size, size, 4), np.uint8)
    image[..., :3] = (60, 120, 40)
    image[..., 3] = np.clip((0.45 - distance) * 10 * 255, 0, 255) // 16 * 16
    return image


def textured_room():
    """Closed room 4 x 3 x 4 m with a checkered floor and a card of leaves cut out by alpha."""
    glb = Glb("room with textures and an alpha mask")
    floor = glb.material("checker", (1.0, 1.0, 1.0), glb.texture(
        checker(32, 8, (200, 190, 170, 255), (70, 60, 60, 255))))
    foliage = glb.material("leaves", (1.0, 1.0, 1.0), glb.texture(leaves(64)), alpha_cutoff=0.5,
                           double_sided=True)
    plaster = glb.material("plaster", (0.7, 0.7, 0.72))
    walls = box((-2, 0, -2), (2, 3, 2)).flipped()
    walls.triangles = walls.triangles[[k for k in range(12) if k not in (10, 11)]]  # no floor
    ground = quad((-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2),
                  uvs=[(0, 0), (2, 0), (2, 2), (0, 2)])
    card = quad((-0.8, 0.3, -0.5), (0.8, 0.3, -0.3), (0.8, 1.9, -0.3), (-0.8, 1.9, -0.5),
                uvs=[(0, 1), (1, 1), (1, 0), (0, 0)])
    for name, shape, material in (("walls", walls, plaster), ("floor", ground, floor),
                                  ("foliage", card, foliage)):
        glb.node(name, mesh=glb.mesh(name, [(shape, material)]))
    glb.camera("camera", (0.6, 1.5, 1.8), (0.0, 1.0, -1.0), math.radians(60), 4 / 3)
    glb.point_light("lamp", (0.8, 2.4, 0.6), (8.0, 7.5, 7.0))
    return glb
