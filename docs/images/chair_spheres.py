#!/usr/bin/env python3
"""Draws the README's picture: an asset at rest and deformed, with the spheres of one level.

    python3 docs/images/chair_spheres.py target/chair.bdt docs/images/chair-spheres.png

Needs numpy and matplotlib. Reads the file by SPEC.md; colours are R'/R, dark red from 1.44 on
(three times the volume, as in the paper's Figure 4), dark blue where a sphere did not grow.
"""
import struct
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle

LEVEL = 2


def read(path):
    data = open(path, "rb").read()
    _, vertices, triangles, modes, nodes, _, sections = struct.unpack_from("<i24x6I", data, 36)
    table = 128 + 32 * modes
    found = {}
    for i in range(sections):
        kind, _, offset, length, _, _ = struct.unpack_from("<4sIQQII", data, table + 32 * i)
        found[kind.decode()] = (offset, length)

    def array(kind, dtype):
        offset, length = found[kind]
        return np.frombuffer(data, dtype, length // np.dtype(dtype).itemsize, offset)

    record = np.dtype(
        [("child", "<u4"), ("slot", "<u4"), ("row", "<u4"), ("list", "<u4"), ("modes", "<u2"),
         ("inner", "u1"), ("leaf", "u1"), ("counts", "u1", 8), ("level", "u1"), ("exponents", "i1", 3)]
    )
    return {
        "range": np.frombuffer(data, "<f4", 8 * modes, 128).reshape(modes, 8)[:, 1],
        "nodes": array("NODE", record),
        "rows": array("ROWS", "<f4").reshape(-1, 8),
        "limit": np.frombuffer(data, "<f4", 8 * modes, 128).reshape(modes, 8)[:, 0],
        "lists": array("LIST", "<u2"),
        "triangles": array("TRIS", "<u4").reshape(triangles, 4)[:, :3],
        "p": array("VERT", "<f4").reshape(vertices, 3),
        "u": array("DISP", "<f4").reshape(vertices, modes, 3),
    }


def spheres(asset, q):
    """Centre, R and R' of every sphere of the level at q (docs/guarantees.md, without slack)."""
    out = []
    for node in asset["nodes"]:
        if node["level"] != LEVEL:
            continue
        row = asset["rows"][node["row"] :]
        c, r = row[0:3].copy(), row[3]
        s, cross = np.zeros(8), np.zeros(8)
        for k, j in enumerate(asset["lists"][node["list"] : node["list"] + node["modes"]]):
            # Three rows' bytes are six of 16 bits, of which the fourth has no signs.
            m = row[4 + 3 * k : 7 + 3 * k].view("<i2").reshape(6, 8)
            centre, growth, b = np.exp2(node["exponents"].astype(float)) * abs(q[j]) / asset["limit"][j]
            c += m[0:3] * centre * np.sign(q[j])
            s += m[3].view("<u2") * growth
            cross += (m[4] if q[j] > 0 else m[5]) * b
        grown = np.sqrt(np.maximum(r * r + 2 * cross + s * s, 0))
        for lane in range(8):
            if (node["inner"] | node["leaf"]) >> lane & 1:
                out.append((c[:, lane], r[lane], grown[lane]))
    return out


def draw(axes, asset, q, title):
    p = asset["p"] + np.einsum("imk,m->ik", asset["u"], q)
    angle = np.radians(35)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    tilt = np.radians(18)
    view = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]) @ turn
    seen = p @ view.T
    corners = seen[asset["triangles"]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    light = np.abs(normal @ np.array([0.3, 0.6, 0.74])) / np.where(length > 0, length, 1)
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    shade = 0.45 + 0.5 * light[order, None] * np.ones(3)
    axes.add_collection(PolyCollection(corners[order][:, :, :2], facecolors=shade, edgecolors=shade, linewidths=0.2))
    colours = plt.get_cmap("jet")
    for c, r, grown in spheres(asset, q):
        x, y, _ = view @ c
        growth = np.clip((grown / r - 1) / 0.44, 0, 1) if r > 0 else 0
        axes.add_patch(Circle((x, y), grown, facecolor=colours(growth) [:3] + (0.06,), edgecolor=colours(growth)[:3] + (0.55,), linewidth=0.6))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")
    axes.set_title(title, fontsize=11)


def main():
    asset = read(sys.argv[1])
    modes = len(asset["range"])
    q = np.zeros(modes)
    figure, axes = plt.subplots(1, 3, figsize=(12, 4.8))
    draw(axes[0], asset, q, "at rest")
    bent = q.copy()
    bent[0] = 2 * asset["range"][0]
    draw(axes[1], asset, bent, "first mode")
    mixed = q.copy()
    mixed[: min(4, modes)] = [1.5, -1.5, 1.5, 1.0][: min(4, modes)] * asset["range"][: min(4, modes)]
    draw(axes[2], asset, mixed, "four modes")
    scale = plt.cm.ScalarMappable(plt.Normalize(1, 1.44), "jet")
    figure.colorbar(scale, ax=axes, fraction=0.015, pad=0.01, label="R' / R")
    figure.savefig(sys.argv[2], dpi=110, bbox_inches="tight")


main()
