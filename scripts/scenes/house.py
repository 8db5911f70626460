"""A house of many rooms: light gets through a few doors and no farther."""

import math

from scenes.glb import Glb
from scenes.shapes import box, join

ROOM = 4.0  # m, from wall to wall
HEIGHT = 2.8
WALL = 0.12
DOOR_WIDTH, DOOR_HEIGHT = 1.0, 2.1
PAINTS = [(0.75, 0.72, 0.66), (0.7, 0.45, 0.35), (0.4, 0.55, 0.7), (0.55, 0.65, 0.4)]


def wall_along_x(x, z, door):
    """Wall of one room's length from (x, z) on, about the plane z; with a door in its middle."""
    z0, z1 = z - WALL / 2, z + WALL / 2
    if not door:
        return box((x, 0, z0), (x + ROOM, HEIGHT, z1))
    left = x + (ROOM - DOOR_WIDTH) / 2
    right = left + DOOR_WIDTH
    return join([box((x, 0, z0), (left, HEIGHT, z1)), box((right, 0, z0), (x + ROOM, HEIGHT, z1)),
                 box((left, DOOR_HEIGHT, z0), (right, HEIGHT, z1))])


def turned(shape):
    """x and z exchanged, fronts kept."""
    shape.positions = shape.positions[:, [2, 1, 0]]
    shape.normals = shape.normals[:, [2, 1, 0]]
    shape.triangles = shape.triangles[:, [0, 2, 1]]
    return shape


def house(rooms=12):
    """rooms x rooms rooms with doors between all neighbours, a table in each, closed outside."""
    glb = Glb(f"house of {rooms} x {rooms} rooms")
    side = rooms * ROOM
    shell = box((0, 0, 0), (side, HEIGHT, side)).flipped()
    walls = [turned(wall_along_x(j * ROOM, i * ROOM, door=True))
             for i in range(1, rooms) for j in range(rooms)]
    walls += [wall_along_x(j * ROOM, i * ROOM, door=True)
              for i in range(1, rooms) for j in range(rooms)]
    glb.node("shell", mesh=glb.mesh("shell", [(shell, glb.material("shell", (0.6, 0.58, 0.55)))]))
    paints = [glb.material(f"paint {k}", paint) for k, paint in enumerate(PAINTS)]
    parts = [(join(walls[k::len(PAINTS)]), paints[k]) for k in range(len(PAINTS))]
    glb.node("walls", mesh=glb.mesh("walls", parts))
    tables = [box((ROOM * (i + 0.55), 0, ROOM * (j + 0.2)), (ROOM * (i + 0.85), 0.75,
                                                           ROOM * (j + 0.4)))
              for i in range(rooms) for j in range(rooms)]
    glb.node("tables", mesh=glb.mesh("tables", [(join(tables), glb.material("wood",
                                                                            (0.45, 0.3, 0.2)))]))
    eye = (ROOM * (rooms // 2 + 0.1), 1.6, ROOM * (rooms // 2 + 0.9))
    glb.camera("camera", eye, (eye[0] + 3.0, 1.2, eye[2] - 3.0), math.radians(65), 4 / 3)
    glb.point_light("lamp", (eye[0] + 1.2, 2.2, eye[2] - 1.0), (12.0, 11.0, 10.0))
    return glb
