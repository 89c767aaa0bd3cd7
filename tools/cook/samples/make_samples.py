#!/usr/bin/env python3
"""Writes the sample models: make_samples.py [FOLDER], by default into the folder of this script. Units are metres, and y is up.
Each surface except the hill is closed.
bracket.fbx is the bracket as assimp exports it; this script does not write it."""
import base64
import json
import math
import pathlib
import struct
import sys


def box(lower, upper):
    corners = [[(lower, upper)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def joined(pieces):
    points, triangles = [], []
    for corners, faces in pieces:
        triangles += [tuple(i + len(points) for i in face) for face in faces]
        points += corners
    return points, triangles


def bracket():
    """An L of 0.8 x 0.6 m, 0.2 m thick and 0.3 m deep."""
    outline = [(0, 0), (0.8, 0), (0.8, 0.2), (0.2, 0.2), (0.2, 0.6), (0, 0.6)]
    count = len(outline)
    points = [[x, y, z] for z in (-0.15, 0.15) for x, y in outline]
    cap = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    triangles = [(a, c, b) for a, b, c in cap] + [(a + count, b + count, c + count) for a, b, c in cap]
    for i in range(count):
        j = (i + 1) % count
        triangles += [(i, j, j + count), (i, j + count, i + count)]
    return points, triangles


def gem():
    """A cut stone with 33 corners."""
    points, triangles = [[0, -0.5, 0]], []
    for radius, y in ((0.5, 0.1), (0.42, 0.25)):
        points += [[radius * math.cos(math.pi * i / 8), y, radius * math.sin(math.pi * i / 8)] for i in range(16)]
    for i in range(16):
        j = (i + 1) % 16
        triangles += [(0, 1 + i, 1 + j), (1 + i, 17 + i, 1 + j), (17 + i, 17 + j, 1 + j)]
    triangles += [(17, 17 + i + 1, 17 + i) for i in range(1, 15)]
    return points, triangles


def chair():
    """Seat, back and four legs: six boxes that touch."""
    legs = [box((x, 0, z), (x + 0.05, 0.45, z + 0.05)) for x in (0, 0.4) for z in (0, 0.4)]
    return joined(legs + [box((0, 0.45, 0), (0.45, 0.5, 0.45)), box((0, 0.5, 0), (0.45, 1, 0.05))])


def hill():
    """A surface of 20 x 20 m with cells of 1 m. It has no gaps when seen from above."""
    side = 21
    points = [[x, 2.5 * math.exp(-((x - 10) ** 2 + (z - 10) ** 2) / 30) + 0.3 * math.sin(x) * math.cos(0.7 * z), z]
              for z in range(side) for x in range(side)]
    triangles = []
    for z in range(side - 1):
        for x in range(side - 1):
            a = z * side + x
            triangles += [(a, a + side + 1, a + 1), (a, a + side, a + side + 1)]
    return points, triangles


def number(v):
    return f"{v:.6g}"


def write_obj(path, points, triangles):
    lines = ["v " + " ".join(map(number, p)) for p in points]
    lines += ["f " + " ".join(str(i + 1) for i in t) for t in triangles]
    path.write_text("\n".join(lines) + "\n")


def write_ply(path, points, triangles):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", "property float x", "property float y",
             "property float z", f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(map(number, p)) for p in points] + ["3 " + " ".join(map(str, t)) for t in triangles]
    path.write_text("\n".join(lines) + "\n")


def write_stl(path, points, triangles):
    lines = ["solid gem"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(map(number, points[i])) for i in t] + ["endloop", "endfacet"]
    path.write_text("\n".join(lines + ["endsolid gem"]) + "\n")


def write_gltf(path, points, triangles):
    corners = b"".join(struct.pack("<3f", *p) for p in points)
    indices = b"".join(struct.pack("<3H", *t) for t in triangles)
    data = base64.b64encode(corners + indices).decode()
    ends = [[pick(p[axis] for p in points) for axis in range(3)] for pick in (min, max)]
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": ends[0], "max": ends[1]},
            {"bufferView": 1, "componentType": 5123, "count": 3 * len(triangles), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": len(corners)},
                        {"buffer": 0, "byteOffset": len(corners), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(corners) + len(indices), "uri": "data:application/octet-stream;base64," + data}],
    }, indent=1) + "\n")


folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
write_obj(folder / "bracket.obj", *bracket())
write_stl(folder / "gem.stl", *gem())
write_gltf(folder / "chair.gltf", *chair())
write_ply(folder / "hill.ply", *hill())
