#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A tessellation with every section that Neper writes, after the description of its format: two cells of a box parted
by a leaning face; masses, bond and materials by group in closed form; whole and regularised: neper.py BIN"""
import os
import re
import sys
import tempfile

import numpy as np

from scene_tools import faults, need, run, summary, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
SIZE = (2.0, 1.0, 1.5)
CORNERS = np.array([(x, y, z) for z in (0, SIZE[2]) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))] +
                   [(0.6, 0, 0), (1.0, 1, 0), (1.0, 1, SIZE[2]), (0.6, 0, SIZE[2])])
# Loops of faces, from 1, seen from outside of the cell that has them with a plus.
FACES = [(1, 5, 8, 4), (1, 9, 12, 5), (4, 8, 11, 10), (1, 4, 10, 9), (5, 12, 11, 8), (9, 10, 11, 12), (2, 3, 7, 6),
         (9, 2, 6, 12), (10, 11, 7, 3), (9, 10, 3, 2), (12, 6, 7, 11)]
CELLS = [(1, 2, 3, 4, 5, 6), (7, 8, 9, 10, 11, -6)]
SIDES = [("x0", [1]), ("x1", [7]), ("y0", [2, 8]), ("y1", [3, 9]), ("z0", [4, 10]), ("z1", [5, 11])]


def edges_of(loops):
    """All edges once, and each loop's by number, negative where it runs the other way."""
    edges, signed = [], []
    for loop in loops:
        own = []
        for a, b in zip(loop, loop[1:] + loop[:1]):
            if (b, a) in edges:
                own.append(-edges.index((b, a)) - 1)
                continue
            if (a, b) not in edges:
                edges.append((a, b))
            own.append(edges.index((a, b)) + 1)
        signed.append(own)
    return edges, signed


def plane_of(loop, x):
    """d n_x n_y n_z, as Neper has it: n . x = d."""
    a, b, c = (x[v - 1] for v in loop[:3])
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n)
    return " ".join(f"{v:.12f}" for v in (n @ a, *n))


def tess(x, regular=False):
    words = lambda values: " ".join(str(v) for v in values)
    edges, signed = edges_of(FACES)
    out = ["***tess", " **format", "   3.4", " **general", "   3 standard", " **cell", "  2", "  *id", "   1 2"]
    out += ["  *crysym", "   cubic", "  *seed"]
    out += [f"   {k + 1} {s} 0.75 0.000000000000" for k, s in enumerate(("0.300000000000 0.6", "1.280000000000 0.3"))]
    out += ["  *ori", "   rodrigues:active", "   0.919953402851 1.412193625247 -0.358468593221",
            "  -1.381019825878 0.030115972514 -3.318384436434"]
    out += ["  *orispread", "   0.1 0.1 0.1", "   0.1 0.1 0.1", "  *mode", "   1 1", "  *group", "   7 9", "  *lam",
            "   1 1"]
    out += [" **vertex", f" {len(x)}"]
    out += [f"  {k + 1} {words(f'{v:.12f}' for v in p)}     0" for k, p in enumerate(x)]
    out += [" **edge", f" {len(edges)}"] + [f"  {k + 1} {a} {b} 0" for k, (a, b) in enumerate(edges)]
    out += [" **face", f" {len(FACES)}"]
    for k, (loop, own) in enumerate(zip(FACES, signed)):
        state = f"1 {loop[0]} {words(x[loop[0] - 1])}" if regular else "0 0" + 3 * " 0.000000000000"
        out += [f"  {k + 1} {len(loop)} {words(loop)}", f"     {len(own)} {words(own)}", f"    {plane_of(loop, x)}",
                f"     {state}"]
    out += [" **polyhedron", " 2"] + [f"   {k + 1} {len(c)} {words(c)}" for k, c in enumerate(CELLS)]
    out += [" **domain", "  *general", "   cube", "  *vertex", "   8"]
    for k in range(8):
        label = "".join(f"{c}{int(v > 0)}" for c, v in zip("xyz", x[k]))
        out += [f"   {k + 1} {words(f'{v:.12f}' for v in x[k])} {label}", f"      1 {k + 1}"]
    out += ["  *edge", "   1", "   1 2 1 2", "     y0z0", "     1 1", "  *face", f"   {len(SIDES)}"]
    for k, (name, own) in enumerate(SIDES):
        out += [f"   {k + 1} 4 1 2 3 4", "     4 1 2 3 4", "     plane", f"     4 {plane_of(FACES[own[0] - 1], x)}",
                f"     {name}", f"     {len(own)} {words(own)}"]
    out += [" **scale", "  *general", "   1", "  *cellid", "   1 1", "   2 2", "***end", ""]
    return "\n".join(out)


SCENE = """
[material.first]
density = 2500
contact = "overlap"
bond = { modulus = "20 GPa", poissons_ratio = 0, tension = "6 MPa", cohesion = "18 MPa", fracture_energy = 1000 }
[material.second]
density = 5000
contact = "overlap"
bond = { modulus = "20 GPa", poissons_ratio = 0, tension = "6 MPa", cohesion = "18 MPa", fracture_energy = 1000 }
[packing]
kind = "polyhedra"
path = "cells.tess"
unit = "mm"
[[packing.group]]
name = "9"
material = "second"
[loading]
kind = "free"
duration = 1e-6
"""

with tempfile.TemporaryDirectory() as tmp:
    scene = write(tmp, SCENE, "cells.toml")
    write(tmp, tess(CORNERS), "cells.tess")
    r = run(rve, scene, "-o", os.path.join(tmp, "out"))
    need(r.returncode == 0, f"exit {r.returncode}: {r.stderr}")
    told = summary(os.path.join(tmp, "out"))
    volumes = (0.8 * SIZE[2] * 1e-9, 1.2 * SIZE[2] * 1e-9)
    need(abs(told["mass"]["start_kg"] / (2500 * volumes[0] + 5000 * volumes[1]) - 1) < 1e-9, f"{told['mass']}")
    need(told["counts"]["grains_start"] == 2 and told["cells"]["bonds_start"] == 1, f"{told['cells']}")
    # Neper's -reg moves corners: faces that have four of them bend.
    bent = CORNERS.copy()
    bent[9, 0] += 0.02
    write(tmp, tess(bent, regular=True), "cells.tess")
    r = run(rve, scene, "-o", os.path.join(tmp, "bent"))
    said = re.search(r"cells.tess: cell 1: a face of it is bent: .*without -reg", r.stderr)
    need(r.returncode == 2 and said, r.stderr)
    need(r.stderr.count("\n") == 1 and not os.path.exists(os.path.join(tmp, "bent")), r.stderr)
print(f"neper: {len(faults)} faults")
sys.exit(1 if faults else 0)
