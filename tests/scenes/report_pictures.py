#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What grus-report makes of frames, against bodies, strains and light that are known: report_pictures.py BIN"""
import math
import os
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.figures import plt  # noqa: E402
from grus.report import pictures, rve_plots  # noqa: E402

import made_up  # noqa: E402
from made_up import drawn  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def near(found, wanted, what, tolerance=1e-12, floor=1e-12):
    made_up.near(found, wanted, what, tolerance, floor)


def bodies():
    """Pictures: what is outside, what strains, where it is lit and seen."""
    cube = np.array([[x, y, z] for z in (0, 1, 2) for y in (0, 1) for x in (0, 1)], float)
    order = np.array([0, 1, 3, 2, 4, 5, 7, 6])  # of a hexahedron, VTK's
    faces = pictures.outside([order, order + 4], [12, 12])
    need(len(faces) == 10 and not any(set(map(int, f)) == {4, 5, 6, 7} for _, f in faces)
         and [k for k, _ in faces].count(0) == 5, f"{len(faces)} faces of two hexahedra")
    for cell, corners in faces:
        x = cube[corners]
        out = np.cross(x[1] - x[0], x[2] - x[0]) @ (x.mean(0) - cube[order + 4 * cell].mean(0))
        need(out > 0, f"face {corners} looks inside")
    tetrahedron = pictures.outside([np.array([0, 1, 2, 4])], [10])
    for _, corners in tetrahedron:
        x = cube[corners]
        need(np.cross(x[1] - x[0], x[2] - x[0]) @ (x.mean(0) - cube[[0, 1, 2, 4]].mean(0)) > 0, "a tetrahedron's face")
    need(len(tetrahedron) == 4 and len(pictures.outside([[0, 1, 2], [0, 1, 3, 2]], [5, 9])) == 2, "kinds of cells")
    gradient = np.array([[0.1, 0.3, 0.0], [0.0, -0.2, 0.05], [0.1, 0.0, 0.02]])
    green = 0.5 * ((np.eye(3) + gradient).T @ (np.eye(3) + gradient) - np.eye(3))
    green -= np.trace(green) / 3 * np.eye(3)
    near(pictures.shear(cube, cube @ gradient.T + 7, [order, order + 4]), [math.sqrt(2 / 3 * (green**2).sum())] * 2,
         "shear strain", 1e-9)
    c, s = math.cos(0.7), math.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    near(pictures.shear(cube, cube @ (turn - np.eye(3)).T, [order]), [0], "of a turn", floor=1e-12)
    view = pictures.view(30, 40)
    near(view @ view.T, np.eye(3), "a turned view")
    a, e = np.radians([30, 40])
    near(view[2], [math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)], "towards who looks")
    need(np.linalg.det(view) > 0.99 and abs(view[0, 2]) < 1e-12 and view[1, 2] > 0, "the way up")
    octahedron = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    corners = np.array([[i, 2 + j, 4 + k] if (i + j + k) % 2 == 0 else [2 + j, i, 4 + k]
                        for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    signs = np.array([octahedron[f].sum(0) for f in corners]) / math.sqrt(3)
    near(pictures.corner_normals(octahedron, corners, False), np.repeat(signs[:, None], 3, 1), "normals of faces")
    near(pictures.corner_normals(octahedron, corners, True), octahedron[corners], "normals of a smooth surface")
    # Two squares over one another, seen from above: the upper one hides the lower, each is lit as it lies.
    square = lambda z, half: [[[-half, -half, z], [half, -half, z], [half, half, z]],
                              [[-half, -half, z], [half, half, z], [-half, half, z]]]
    triangles = np.array(square(0.0, 1.0) + square(1.0, 0.5))
    normals, owner = np.zeros((4, 3, 3)) + [0, 0, 1], np.array([0, 0, 1, 1])
    colours = np.array([[1.0, 0, 0, 1], [0, 1.0, 0, 1]])
    for turned, upper in ((np.arange(4), 1), (np.array([2, 3, 0, 1]), 1)):
        image = pictures.painted(triangles[turned], normals[turned], owner[turned], colours, np.eye(3), pixels=101)
        middle, rim = image[len(image) // 2, len(image) // 2], image[len(image) // 2, len(image) // 8]
        light = 0.35 + 0.65 * 0.77
        near(middle, [0, light, 0, 1], "the square above", 1e-3)
        near(rim, [light, 0, 0, 1], "the square below", 1e-3)
    need(image[0, 0, 3] == 0 and (image[..., 3] > 0).mean() > 0.7, "beside both")
    turned = np.concatenate([triangles[:2], triangles[2:, ::-1]])
    back = pictures.painted(turned, normals, owner, colours, np.eye(3), 101)
    near(back[len(back) // 2, len(back) // 2], [light, 0, 0, 1], "a square that looks away", 1e-3)
    frame = {"id": np.array([4, 4, 9, 9, 7, 7]), "radius": 1e-3 * np.array([1, 1, 3, 3, 2, 2.0])}
    ids, found, how, (_, norm, label) = pictures.coloured(frame)
    need(list(ids) == [4, 7, 9] and how == "by size" and (norm.vmin, norm.vmax) == (1, 3), f"{ids} {how}")
    ids, found, how, key = pictures.coloured({**frame, "generation": np.array([0, 0, 2, 2, 0, 0])})
    need(how == "by generation" and [text for text, _ in key] == ["whole grains", "broken 2 times"]
         and (found[0] == found[1]).all() and (found[2] == key[1][1]).all(), f"{how} {key}")
    many = {"id": np.arange(42), "radius": np.ones(42), "fragment": np.array([0] * 20 + [1] * 20 + [2, 3])}
    ids, found, how, key = pictures.coloured(many)
    need(how.startswith("by fragment") and (found[40:] == (0.6, 0.6, 0.6, 1)).all() and (found[0] != found[20]).any(),
         "fragments")


def frames(folder):
    """The last of the frames is drawn, displaced, with the fields that it has."""
    os.makedirs(os.path.join(folder, "macro"))
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], float)
    for number, stretch in ((11, 0.5), (2, 0.0), (3, 0.0), (10, 0.0), (1, 0.0), (0, 0.0)):
        with h5py.File(os.path.join(folder, "macro", f"macro_{number:05d}.hdf"), "w") as f:
            grid = f.create_group("VTKHDF")
            grid["Points"], grid["Connectivity"] = points, np.array([0, 1, 2, 3, 1, 4, 5, 2])
            grid["Offsets"], grid["Types"] = np.array([0, 4, 8]), np.array([9, 9])
            grid["CellData/void_ratio"] = np.array([0.5, 0.6])
            grid["CellData/broken_fraction"] = np.zeros(2)
            grid["PointData/displacement_m"] = points * [stretch, 0, 0]
    for draw, values, name in zip(pictures.macro(folder, "n"), ([2 / 3 * 0.625] * 2, [0.5, 0.6]), ("shear", "void")):
        fig, ax = plt.subplots()
        draw(ax)
        near(ax.collections[0].get_array(), values, f"{name} of the mesh", 1e-9)
        near(ax.collections[0].get_paths()[1].vertices[:4, 0], [1500, 3000, 3000, 1500], "a displaced cell in mm")
        plt.close(fig)
    need(len(pictures.macro(folder, "n")) == 2 and pictures.macro("nowhere", "n") == []
         and pictures.grains("nowhere", "n") is None, "fields that say something")
    # Two grains, each an octahedron, and the outline's lines, which are none: seen from the side they look as they are.
    corners = np.array([[i, 2 + j, 4 + k] if (i + j + k) % 2 == 0 else [2 + j, i, 4 + k]
                        for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    body = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    os.makedirs(os.path.join(folder, "grains"))
    with h5py.File(os.path.join(folder, "grains", "grains_00000.hdf"), "w") as f:
        grid = f.create_group("VTKHDF")
        grid["Points"] = np.concatenate([body, 0.5 * body + [3, 0, 0]])
        grid["Connectivity"] = np.concatenate([[0, 6], corners.ravel(), 6 + corners.ravel()])
        grid["Offsets"], grid["Types"] = np.concatenate([[0, 2], 2 + 3 * np.arange(1, 17)]), np.array([3] + [5] * 16)
        grid["CellData/id"] = np.array([math.nan] + [8.0] * 8 + [5.0] * 8)
        grid["CellData/radius"] = np.array([math.nan] + [2e-3] * 8 + [1e-3] * 8)
    given, before = [], pictures.painted
    pictures.painted = lambda *arguments, **more: given.append(arguments) or before(*arguments, **more)
    curves, texts, fig = drawn(pictures.grains(folder, "n"))
    pictures.painted = before
    triangles, normals, owner, colours, turn = given[0]
    near([triangles[:8].mean((0, 1)), triangles[8:].mean((0, 1))], [[0, 0, 0], [3, 0, 0]], "triangles of two grains")
    near([np.ptp(t.reshape(-1, 3), 0) for t in (triangles[:8], triangles[8:])], [[2] * 3, [1] * 3], "their sizes")
    need(list(owner) == [1] * 8 + [0] * 8 and len(colours) == 2, f"whose they are: {owner}")
    need(texts == ["n: 2 grains in the last frame, by size", "equivalent radius (mm)"], f"its texts: {texts}")
    near(turn, pictures.view(), "how they are seen")
    near(np.linalg.norm(normals, axis=2), np.ones((16, 3)), "their normals")
    with open(os.path.join(folder, "bursts.csv"), "w") as f:
        f.write("bonds,time_s\n3,1\n0,2\n5,3\n")
    need(rve_plots.burst_sizes(folder) == [3, 5] and rve_plots.burst_sizes("nowhere") == [], "bursts.csv")


def cracks(folder):
    """Grains that cracked: damage on the half behind the cut, pieces pulled apart by a quarter of what parts them."""
    os.makedirs(os.path.join(folder, "lattice"))
    points = 1e-3 * np.array([[x, y, z] for x in range(4) for y in (0, 1) for z in (0, 1)], float)
    piece, damage = (points[:, 0] > 1.5e-3).astype(int), np.arange(16) / 16
    apart = pictures.pulled(points, piece)
    near(apart[piece == 1].mean(0) - apart[piece == 0].mean(0), [2.5e-3, 0, 0], "pieces pulled apart", floor=1e-15)
    near(apart.mean(0), points.mean(0), "the middle of all", 1e-9)
    need(pictures.cracked(folder, "n") == [] == pictures.cracked("nowhere", "n"), "no grain has cracked")
    for number in range(6):
        with h5py.File(os.path.join(folder, "lattice", f"lattice_{number:05d}.hdf"), "w") as f:
            grid = f.create_group("VTKHDF")
            grid["Points"], grid["Connectivity"], grid["Offsets"] = points, np.arange(16), np.arange(17)
            grid["Types"], grid["PointData/damage"], grid["PointData/piece"] = np.ones(16, int), damage, piece
    with open(os.path.join(folder, "lattice.hdf.series"), "w") as f:
        f.write('{"files": [{"name": "lattice/lattice_00000.hdf", "time": 0.25}]}')
    draws = pictures.cracked(folder, "n")
    need(len(draws) == 4, f"{len(draws)} of six grains are drawn")
    _, texts, _ = drawn(draws[0])
    need("n: a grain that cracked at 0.25 s, damage and pieces of 16 points" in texts, f"its texts: {texts}")
    fig, ax = plt.subplots()
    draws[0](ax)
    place = (points - points.mean(0)) @ pictures.view().T
    need([t.get_text() for t in ax.get_legend().get_texts()] == ["piece 1: 50 %", "piece 2: 50 %"], "legend")
    need(set(np.asarray(ax.collections[0].get_array())) == set(damage[place[:, 2] <= 0]), "damage behind the cut")
    plt.close(fig)


bodies()
with tempfile.TemporaryDirectory() as tmp:
    frames(os.path.join(tmp, "frames"))
    cracks(os.path.join(tmp, "cracks"))
print(f"report_pictures: {len(faults)} faults")
sys.exit(bool(faults))
