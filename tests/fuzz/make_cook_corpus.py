#!/usr/bin/env python3
"""Writes the seeds of two fuzzers. corpus/cook has small models in the format of cook_input.h, each as an input for each kind
of asset. corpus/cook_import has models in file formats, after a byte that names the format (see cook_import.cpp)."""
import base64
import json
import pathlib
import random
import struct


def box(lower, upper):
    corners = [[(lower, upper)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def bracket():
    outline = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]
    points = [[x, y, z] for z in (0, 1) for x, y in outline]
    cap = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    triangles = [(a, c, b) for a, b, c in cap] + [(a + 6, b + 6, c + 6) for a, b, c in cap]
    for i in range(6):
        j = (i + 1) % 6
        triangles += [(i, j, j + 6), (i, j + 6, i + 6)]
    return points, triangles


def hollow():
    points, triangles = box((-2, -2, -2), (2, 2, 2))
    inner, faces = box((-1, -1, -1), (1, 1, 1))
    return points + inner, triangles + [(a + 8, c + 8, b + 8) for a, b, c in faces]


def grid():
    points = [[x, ((x * 7 + z * 3) % 5) / 5, z] for z in range(6) for x in range(6)]
    triangles = []
    for z in range(5):
        for x in range(5):
            a = z * 6 + x
            triangles += [(a, a + 7, a + 1), (a, a + 6, a + 7)]
    return points, triangles


def cloud():
    chance = random.Random(7)
    points = [[chance.uniform(-2, 2) for _ in range(3)] for _ in range(40)]
    return points, [tuple(chance.sample(range(40), 3)) for _ in range(60)]


FLAT = ([[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]], [(0, 2, 1), (1, 2, 3)])


def encode(kind, flags, points, triangles, corners=60, parts=5, deviation=(10, 10), spacing=0):
    head = bytes([kind, flags, corners, parts, *deviation, spacing, len(points)])
    if flags & 1:
        body = b"".join(struct.pack("<3f", *p) for p in points)
    else:
        body = b"".join(struct.pack("<3h", *(round(v * 1024) for v in p)) for p in points)
    return head + body + bytes(i for t in triangles for i in t)


folder = pathlib.Path(__file__).parent / "corpus" / "cook"
folder.mkdir(parents=True, exist_ok=True)
models = {"box": box((-1, -1, -1), (1, 1, 1)), "bracket": bracket(), "hollow": hollow(), "grid": grid(),
          "cloud": cloud(), "flat": FLAT, "thin": box((0, 0, 0), (1, 0.002, 1)), "nothing": ([], [])}
for name, (points, triangles) in models.items():
    for kind, word in enumerate(("hull", "convex", "mesh", "height")):
        (folder / f"{name}-{word}").write_bytes(encode(kind, 0, points, triangles, spacing=5 if kind == 3 else 0))
points, triangles = models["bracket"]
(folder / "floats").write_bytes(encode(1, 1, points, triangles))
(folder / "not-a-number").write_bytes(encode(0, 1, points[:-1] + [[float("nan"), 0, 0]], triangles))
(folder / "infinite").write_bytes(encode(2, 1, points[:-1] + [[float("inf"), 0, 0]], triangles))
(folder / "wild-index").write_bytes(encode(2, 2, points, triangles + [(200, 1, 2)]))
(folder / "huge").write_bytes(encode(2, 4, points, triangles))
(folder / "two-sided").write_bytes(encode(2, 8, *FLAT))
(folder / "z-up").write_bytes(encode(3, 16, *models["grid"], spacing=4))
(folder / "four-corners").write_bytes(encode(0, 0, *models["cloud"], corners=0))

# ---- files ----
folder = pathlib.Path(__file__).parent / "corpus" / "cook_import"
folder.mkdir(parents=True, exist_ok=True)
points, triangles = models["bracket"]


def text(lines):
    return "".join(line + "\n" for line in lines).encode()


def numbers(values):
    return " ".join(f"{v:g}" for v in values)


def stl_text():
    facets = [["facet normal 0 0 0", "outer loop", *(f"vertex {numbers(points[i])}" for i in t), "endloop", "endfacet"]
              for t in triangles]
    return text(["solid bracket", *(line for facet in facets for line in facet), "endsolid bracket"])


def stl_binary():
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for i in t for v in points[i]), 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


def ply(binary):
    head = ["ply", f"format {'binary_little_endian' if binary else 'ascii'} 1.0", f"element vertex {len(points)}",
            "property float x", "property float y", "property float z", f"element face {len(triangles)}",
            "property list uchar int vertex_indices", "end_header"]
    if not binary:
        return text([*head, *map(numbers, points), *("3 " + numbers(t) for t in triangles)])
    return (text(head) + b"".join(struct.pack("<3f", *p) for p in points)
            + b"".join(struct.pack("<B3i", 3, *t) for t in triangles))


def obj():
    return text([*("v " + numbers(p) for p in points), "g bracket",
                 *("f " + numbers(i + 1 for i in t) for t in triangles), "l 1 2", "f 1 2 3 4"])


def off():
    return text(["OFF", f"{len(points)} {len(triangles)} 0", *map(numbers, points),
                 *("3 " + numbers(t) for t in triangles)])


def gltf(embedded):
    blob = (b"".join(struct.pack("<3H", *t) for t in triangles) + b"".join(struct.pack("<3f", *p) for p in points))
    start = 6 * len(triangles)
    buffer = {"byteLength": len(blob)}
    if embedded:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [0, 1, 0], "rotation": [0, 0.6, 0, 0.8]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 1}, "indices": 0}]}],
            "accessors": [{"bufferView": 0, "componentType": 5123, "count": 3 * len(triangles), "type": "SCALAR"},
                          {"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC3",
                           "min": [0, 0, 0], "max": [2, 3, 1]}],
            "bufferViews": [{"buffer": 0, "byteLength": start},
                            {"buffer": 0, "byteOffset": start, "byteLength": len(blob) - start}],
            "buffers": [buffer]}
    words = json.dumps(tree, separators=(",", ":")).encode()
    if embedded:
        return words
    words += b" " * (-len(words) % 4)
    blob += bytes(-len(blob) % 4)
    chunks = struct.pack("<II", len(words), 0x4E4F534A) + words + struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


FBX = """; FBX 7.4.0 project file
FBXHeaderExtension:  {
    FBXVersion: 7400
}
Objects:  {
    Geometry: 1, "Geometry::m", "Mesh" {
        Vertices: *12 {
            a: 0,0,0,1,0,0,0,1,0,0,0,1
        }
        PolygonVertexIndex: *12 {
            a: 0,2,-2,0,1,-4,0,3,-3,1,2,-4
        }
    }
    Model: 2, "Model::m", "Mesh" {
    }
}
Connections:  {
    C: "OO",2,0
    C: "OO",1,2
}
"""
files = {"stl-text": (0, stl_text()), "stl-binary": (0, stl_binary()), "ply-text": (1, ply(False)),
         "ply-binary": (1, ply(True)), "obj": (2, obj()), "gltf": (3, gltf(True)), "glb": (4, gltf(False)),
         "fbx": (5, FBX.encode()), "off": (6, off())}
for name, (kind, content) in files.items():
    (folder / name).write_bytes(bytes([kind]) + content)
