#!/usr/bin/env python3
"""Writes crate.obj, crate.mtl and crate.png: a wooden crate with raised frames, half extents 0.5, y up."""
import random
import struct
import zlib
from pathlib import Path

HERE = Path(__file__).parent
SIZE = 128  # width and height of the texture [pixels]


def write_png(path, rows):
    """Writes `rows`, lists of (r, g, b), as a PNG file."""
    raw = b"".join(b"\0" + bytes(c for pixel in row for c in pixel) for row in rows)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9))
                     + chunk(b"IEND", b""))


def wood():
    """Four vertical planks with grain."""
    random.seed(7)
    plank = SIZE // 4
    tones = [random.uniform(0.88, 1.08) for _ in range(4)]
    grain = [random.uniform(-0.06, 0.06) for _ in range(SIZE)]
    rows = []
    for y in range(SIZE):
        row = []
        for x in range(SIZE):
            shade = tones[x // plank] + grain[x] + random.uniform(-0.025, 0.025)
            if x % plank in (0, plank - 1):
                shade *= 0.55
            row.append(tuple(max(0, min(255, int(c * shade))) for c in (196, 150, 96)))
        rows.append(row)
    return rows


def face(axis, sign):
    """Yields (material, corners of a quad) of one side of the crate: a raised frame, its inner edges, and a sunken panel."""
    def point(u, v, depth):
        p = [0.0, 0.0, 0.0]
        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = sign * depth, u, sign * v
        return tuple(p)

    outer, inner, sunk = 0.5, 0.38, 0.455
    ring = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    for i in range(4):
        a, b = ring[i], ring[(i + 1) % 4]
        yield "frame", [point(a[0] * outer, a[1] * outer, outer), point(b[0] * outer, b[1] * outer, outer),
                        point(b[0] * inner, b[1] * inner, outer), point(a[0] * inner, a[1] * inner, outer)]
        yield "frame", [point(a[0] * inner, a[1] * inner, outer), point(b[0] * inner, b[1] * inner, outer),
                        point(b[0] * inner, b[1] * inner, sunk), point(a[0] * inner, a[1] * inner, sunk)]
    yield "panel", [point(u * inner, v * inner, sunk) for u, v in ring]


def main():
    write_png(HERE / "crate.png", wood())
    (HERE / "crate.mtl").write_text(
        "newmtl frame\nKd 0.56 0.40 0.25\nKs 0 0 0\nNs 12\n\nnewmtl panel\nKd 1 1 1\nKs 0 0 0\nNs 8\nmap_Kd crate.png\n")
    lines = ["# A crate, made by make_crate.py", "mtllib crate.mtl", "vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    quads = [quad for axis in range(3) for sign in (1, -1) for quad in face(axis, sign)]
    for _, quad in quads:
        lines += ["v %.4g %.4g %.4g" % p for p in quad]
    for material in ("frame", "panel"):
        lines.append("usemtl " + material)
        for i, (kind, quad) in enumerate(quads):
            if kind != material:
                continue
            a, b, c = quad[0], quad[1], quad[2]
            u, v = [b[k] - a[k] for k in range(3)], [c[k] - b[k] for k in range(3)]
            n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
            length = sum(x * x for x in n) ** 0.5
            lines.append("vn %.4g %.4g %.4g" % tuple(x / length for x in n))
            lines.append("f " + " ".join(f"{4 * i + k + 1}/{k + 1}/-1" for k in range(4)))
    (HERE / "crate.obj").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
