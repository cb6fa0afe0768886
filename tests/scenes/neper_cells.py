# SPDX-License-Identifier: LGPL-3.0-or-later
"""Voronoi cells of a box in the format of Neper's tessellations, by SciPy: what `neper -T -n N -domain "cube(a,b,c)"`
writes."""
import numpy as np
from scipy.spatial import Voronoi


def cells_of(seeds, size):
    """(vertices, faces of each cell): each face a pair of the cell beyond it (-1: none) and its corners in turn. Seeds
    mirrored at the sides of the box make cells that end there."""
    n, all_ = len(seeds), [seeds]
    for k in range(3):
        for side in (0, size[k]):
            mirrored = seeds.copy()
            mirrored[:, k] = 2 * side - mirrored[:, k]
            all_.append(mirrored)
    mesh = Voronoi(np.concatenate(all_))
    faces = [[] for _ in range(n)]
    for (a, b), corners in zip(mesh.ridge_points, mesh.ridge_vertices):
        for own, other in ((a, b), (b, a)):
            if own < n:
                faces[own].append((int(other) if other < n else -1, corners))
    return mesh.vertices, faces


def write(path, size, count, seed=1, rounds=2):
    """Cells whose seeds were moved to the middle of their corners some times; returns the seeds."""
    seeds = np.random.default_rng(seed).random((count, 3)) * size
    for _ in range(rounds):
        x, faces = cells_of(seeds, size)
        seeds = np.array([x[sorted({v for _, f in own for v in f})].mean(0) for own in faces])
    x, faces = cells_of(seeds, size)
    used = sorted({v for own in faces for _, f in own for v in f})
    number = {v: k + 1 for k, v in enumerate(used)}
    told, polyhedra, between = [], [], {}
    for i, own in enumerate(faces):
        signed = []
        for other, corners in own:
            if 0 <= other < i:
                signed.append(-between[other, i])
                continue
            told.append(f" {len(told) + 1} {len(corners)} {' '.join(str(number[v]) for v in corners)}\n {len(corners)}"
                        f"{' 1' * len(corners)}\n 0 0 0 0\n 0 0 0 0 0\n")
            between[i, other] = len(told)
            signed.append(len(told))
        polyhedra.append(f" {i + 1} {len(signed)} {' '.join(map(str, signed))}\n")
    three = lambda p: " ".join(f"{v:.12f}" for v in p)
    with open(path, "w") as f:
        f.write(f"***tess\n **format\n   3.4\n **general\n   3 standard\n **cell\n  {count}\n  *seed\n")
        f.writelines(f" {i + 1} {three(s)} 0.000000000000\n" for i, s in enumerate(seeds))
        f.write(f" **vertex\n {len(used)}\n")
        f.writelines(f" {number[v]} {three(x[v])} 0\n" for v in used)
        f.write(f" **edge\n 1\n 1 1 2 0\n **face\n {len(told)}\n{''.join(told)}")
        f.write(f" **polyhedron\n {count}\n{''.join(polyhedra)}***end\n")
    return seeds
