#!/usr/bin/env python3
"""Writes the seeds of corpus/cook: small models in the format of cook_input.h, each cooked in each way."""
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
