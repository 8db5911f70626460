"""Writes a glTF 2.0 binary whose bytes depend on its content alone."""

import json
import math
import struct
import zlib

import numpy as np

FLOAT, UINT16, UINT32 = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
CANDELA_PER_WATT = 683.0  # glTF lights are photometric; everything here is given in W/sr


def png(rgba):
    """PNG bytes of an array height x width x 4 of uint8."""
    height, width, _ = rgba.shape
    rows = b"".join(b"\0" + rgba[y].tobytes() for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    # Stored, not deflated: the bytes then do not depend on the zlib version.
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", stored_zlib(rows)) +
            chunk(b"IEND", b""))


def stored_zlib(data):
    """A zlib stream of stored blocks."""
    out = [b"\x78\x01"]
    blocks = [data[i:i + 65535] for i in range(0, len(data), 65535)] or [b""]
    for i, block in enumerate(blocks):
        last = i == len(blocks) - 1
        out.append(struct.pack("<BHH", last, len(block), len(block) ^ 0xFFFF) + block)
    out.append(struct.pack(">I", zlib.adler32(data)))
    return b"".join(out)


def look_at(eye, target):
    """Quaternion (x, y, z, w) that turns a camera, which looks along -z, from eye to target."""
    back = np.subtract(eye, target)
    back = back / np.linalg.norm(back)
    right = np.cross([0.0, 1.0, 0.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    m = np.column_stack([right, up, back])
    # Shepperd's method, picking the largest divisor for accuracy.
    squares = [1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
               1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]]
    k = int(np.argmax(squares))
    s = 2.0 * math.sqrt(squares[k])
    w, x, y, z = [
        (s / 4, (m[2, 1] - m[1, 2]) / s, (m[0, 2] - m[2, 0]) / s, (m[1, 0] - m[0, 1]) / s),
        ((m[2, 1] - m[1, 2]) / s, s / 4, (m[0, 1] + m[1, 0]) / s, (m[0, 2] + m[2, 0]) / s),
        ((m[0, 2] - m[2, 0]) / s, (m[0, 1] + m[1, 0]) / s, s / 4, (m[1, 2] + m[2, 1]) / s),
        ((m[1, 0] - m[0, 1]) / s, (m[0, 2] + m[2, 0]) / s, (m[1, 2] + m[2, 1]) / s, s / 4)][k]
    return [round(float(v), 7) for v in (x, y, z, w)]


class Glb:
    """Collects materials, meshes, nodes, lights and cameras."""

    def __init__(self, title):
        self.data = bytearray()
        self.json = {
            "asset": {"version": "2.0", "generator": "prtbake scripts/make_scenes.py",
                      "extras": {"title": title}},
            "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": [],
        }

    def _add(self, key, value):
        items = self.json.setdefault(key, [])
        items.append(value)
        return len(items) - 1

    def _view(self, data, target=None):
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.data += data
        return self._add("bufferViews", view)

    def _accessor(self, array, component, kind, target, bounds=False):
        accessor = {"bufferView": self._view(array.tobytes(), target), "componentType": component,
                    "count": len(array), "type": kind}
        if bounds:
            accessor["min"] = [float(v) for v in array.min(axis=0)]
            accessor["max"] = [float(v) for v in array.max(axis=0)]
        return self._add("accessors", accessor)

    def texture(self, rgba):
        image = self._add("images", {"bufferView": self._view(png(rgba)), "mimeType": "image/png"})
        return self._add("textures", {"source": image, "sampler": self._add("samplers", {})})

    def material(self, name, rgb, texture=None, alpha_cutoff=None, double_sided=False):
        pbr = {"baseColorFactor": [float(c) for c in rgb] + [1.0], "metallicFactor": 0.0,
               "roughnessFactor": 1.0}
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if alpha_cutoff is not None:
            material.update(alphaMode="MASK", alphaCutoff=alpha_cutoff)
        if double_sided:
            material["doubleSided"] = True
        return self._add("materials", material)

    def mesh(self, name, parts):
        """`parts`: list of (shape, material number); one primitive each."""
        primitives = []
        for shape, material in parts:
            attributes = {"POSITION": self._accessor(shape.positions.astype("<f4"), FLOAT, "VEC3",
                                                     ARRAY_BUFFER, bounds=True),
                          "NORMAL": self._accessor(shape.normals.astype("<f4"), FLOAT, "VEC3",
                                                   ARRAY_BUFFER)}
            if shape.uvs is not None:
                attributes["TEXCOORD_0"] = self._accessor(shape.uvs.astype("<f4"), FLOAT, "VEC2",
                                                          ARRAY_BUFFER)
            small = len(shape.positions) < 65535
            indices = shape.triangles.reshape(-1).astype("<u2" if small else "<u4")
            primitives.append({
                "attributes": attributes,
                "indices": self._accessor(indices, UINT16 if small else UINT32, "SCALAR",
                                          ELEMENT_ARRAY_BUFFER),
                "material": material})
        return self._add("meshes", {"name": name, "primitives": primitives})

    def node(self, name, **properties):
        """Adds a root node; properties as glTF names them (mesh, translation, rotation, ...)."""
        number = self._add("nodes", {"name": name, **properties})
        self.json["scenes"][0]["nodes"].append(number)
        return number

    def camera(self, name, eye, target, vertical_fov, aspect):
        camera = {"type": "perspective", "name": name,
                  "perspective": {"yfov": round(vertical_fov, 7), "aspectRatio": aspect,
                                  "znear": 0.01, "zfar": 100.0}}
        self.node(name, camera=self._add("cameras", camera), translation=list(eye),
                  rotation=look_at(eye, target))

    def point_light(self, name, position, watts_per_steradian):
        """Radiant intensity per colour channel, W/sr."""
        strongest = max(watts_per_steradian)
        light = {"type": "point", "name": name,
                 "color": [round(w / strongest, 6) for w in watts_per_steradian],
                 "intensity": round(strongest * CANDELA_PER_WATT, 3)}
        extension = "KHR_lights_punctual"
        lights = self.json.setdefault("extensions", {}).setdefault(extension, {"lights": []})
        lights["lights"].append(light)
        if extension not in self.json.setdefault("extensionsUsed", []):
            self.json["extensionsUsed"].append(extension)
        self.node(name, translation=list(position),
                  extensions={extension: {"light": len(lights["lights"]) - 1}})

    def triangles(self):
        """Triangles in the scene, every instance counted."""
        counts = [sum(self.json["accessors"][p["indices"]]["count"] // 3 for p in mesh["primitives"])
                  for mesh in self.json["meshes"]]
        return sum(counts[node["mesh"]] for node in self.json["nodes"] if "mesh" in node)

    def bytes(self):
        binary = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        self.json["buffers"] = [{"byteLength": len(binary)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        return (struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(binary)) +
                struct.pack("<I4s", len(text), b"JSON") + text +
                struct.pack("<I4s", len(binary), b"BIN\0") + binary)
