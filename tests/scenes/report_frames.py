#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""How grus-report shows grains and blocks: seen from where, by whose colours, with which key: report_frames.py BIN"""
import os
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.figures import plt  # noqa: E402
from grus.report import pictures  # noqa: E402

from scene_tools import faults, need  # noqa: E402


def grains_frame(folder, points, cells, **fields):
    """A frame of triangles."""
    os.makedirs(os.path.join(folder, "grains"), exist_ok=True)
    with h5py.File(os.path.join(folder, "grains", "grains_00000.hdf"), "w") as f:
        grid = f.create_group("VTKHDF")
        grid["Points"], grid["Connectivity"] = np.asarray(points, float), np.ravel(cells)
        grid["Offsets"], grid["Types"] = 3 * np.arange(len(cells) + 1), np.full(len(cells), 5)
        for name, values in fields.items():
            grid[f"CellData/{name}"] = values


def of_pictures(tmp):
    """How bodies are seen: plates along their short side, others askew; whose colours, and what the key says."""
    corners = np.array([[i, 2 + j, 4 + k] if (i + j + k) % 2 == 0 else [2 + j, i, 4 + k]
                        for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    body = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    given, before = [], pictures.painted
    pictures.painted = lambda *arguments: given.append(arguments) or np.zeros((2, 2, 4))
    turns = {(1, 1, 1): pictures.view(), (1, 1, 0.24): np.eye(3), (1, 1, 0.26): pictures.view(),
             (0.2, 1, 1): [[0, 1, 0], [0, 0, 1], [1, 0, 0]], (1, 0.2, 1): [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
             (4, 0.2, 1): [[1, 0, 0], [0, 0, 1], [0, -1, 0]], (0.3, 0.29, 9): pictures.view()}
    for k, (size, turn) in enumerate(turns.items()):
        folder = os.path.join(tmp, f"turn{k}")
        hull = {"sphericity": np.ones(8)} if k % 2 else {}
        grains_frame(folder, body * size, corners, id=np.zeros(8), radius=np.ones(8), **hull)
        draw = pictures.grains(folder, "n")
        need(np.array_equal(given[-1][4], turn), f"a body of {size} is seen by {given[-1][4]}")
        normals = given[-1][1]
        smooth = np.linalg.norm(np.ptp(normals, axis=1), axis=1) > 1e-6
        need(smooth.all() if not hull else not smooth.any(), f"normals of {'hulls' if hull else 'smooth grains'}")
    fig, ax = plt.subplots()
    draw(ax)
    need(not ax.axison and ax.images[0].origin == "lower" and len(fig.axes) == 2, "a picture with a colour bar")
    plt.close(fig)
    for most, texts in ((1, ["whole grains", "broken 1 time"]), (3, ["whole grains", "broken 3 times"])):
        folder = os.path.join(tmp, f"key{most}")
        grains_frame(folder, np.concatenate([body, body + 3]), np.concatenate([corners, corners + 6]),
                     id=np.repeat([7, 2], 8), radius=np.ones(16), generation=np.repeat([most, 0], 8))
        draw = pictures.grains(folder, "n")
        colours, owner = given[-1][3], given[-1][2]
        need(list(owner) == [1] * 8 + [0] * 8, "whose triangles")
        fig, ax = plt.subplots()
        draw(ax)
        need([t.get_text() for t in ax.get_legend().get_texts()] == texts and len(fig.axes) == 1, "the key")
        pale, strong = colours[0][:3], colours[1][:3]  # whole grains as sand is, broken ones by their own colour
        need(pale.min() > 0.6 and pale[0] > pale[1] > pale[2] and np.ptp(strong) > 0.3, f"colours {pale} {strong}")
        plt.close(fig)
    pictures.painted = before
    # Light comes from the upper left, and what is turned from it keeps a third.
    corner = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    lit = [pictures.painted(corner, np.array([[n] * 3]), np.zeros(1, int), np.ones((1, 4)), np.eye(3), 50)[10, 10, 0]
           for n in ([-0.4, 0.5, 0.77], [0.4, 0.5, 0.77], [-0.4, -0.5, 0.77], [0.4, -0.5, -0.77])]
    need(lit[0] > 0.99 and lit[0] > lit[1] + 0.15 and lit[0] > lit[2] + 0.15 and abs(lit[3] - 0.35) < 1e-3,
        f"light: {lit}")
    of_colours()
    os.makedirs(os.path.join(tmp, "none", "grains"))
    need(pictures.grains(os.path.join(tmp, "none"), "n") is None, "no frames")
    path = os.path.join(tmp, "none", "grains", "grains_00000.hdf")
    for content in (None, "Points"):
        with h5py.File(path, "w") as f:
            if content:
                f.create_group("VTKHDF")[content] = np.zeros((1, 3))
        try:
            pictures.grains(os.path.join(tmp, "none"), "n")
            need(False, "a damaged frame is drawn")
        except ValueError as e:
            need(path in str(e) and "not a frame of Grus" in str(e), f"{e}")
    grains_frame(os.path.join(tmp, "lines"), body, corners, id=np.zeros(8), radius=np.ones(8))
    with h5py.File(os.path.join(tmp, "lines", "grains", "grains_00000.hdf"), "r+") as f:
        f["VTKHDF/Types"][:] = 3
    need(pictures.grains(os.path.join(tmp, "lines"), "n") is None, "a frame without a triangle")
    blocks(tmp)


def of_colours():
    frame = {"id": np.arange(3), "radius": np.array([1e-3, 1e-3, 1e-3])}
    ids, colours, how, (_, norm, _) = pictures.coloured(frame)
    need((norm.vmin, norm.vmax) == (1.0, 1.5), f"one size has a scale: {norm.vmin} {norm.vmax}")
    ids, colours, how, (_, norm, _) = pictures.coloured({**frame, "radius": np.array([1, 1.1, 1]) / 1e3})
    need(abs(norm.vmax / 1.1 - 1) < 1e-12, "two sizes")
    fragment = np.array([0] * 40 + [1] * 2 + [2] * 3 + [11] * 30)
    many = {"id": np.arange(75), "radius": np.ones(75), "fragment": fragment}
    _, colours, _, key = pictures.coloured(many)
    grey = (colours == (0.6, 0.6, 0.6, 1)).all(1)
    need((grey == (fragment == 1)).all() and key is None, f"grey is a twentieth of the largest: {fragment[grey]}")
    need((colours[0] == plt.cm.tab10(0)).all() and (colours[-1] == plt.cm.tab10(1)).all(), "ten colours in turn")


def blocks(tmp):
    """The mesh in space: what looks away is hidden, what is near is drawn last, what has no value is grey."""
    folder = os.path.join(tmp, "block")
    os.makedirs(os.path.join(folder, "macro"))
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]])
    with h5py.File(os.path.join(folder, "macro", "macro_00000.hdf"), "w") as f:
        grid = f.create_group("VTKHDF")
        grid["Points"], grid["Connectivity"] = np.concatenate([cube, cube + [0, 3, 0]]), np.arange(16)
        grid["Offsets"], grid["Types"] = np.array([0, 8, 16]), np.array([12, 12])
        grid["CellData/void_ratio"] = np.array([0.5, np.nan])
        grid["CellData/broken_fraction"] = np.array([0.25, np.nan])
        grid["PointData/displacement_m"] = np.zeros((16, 3))
    draws = pictures.macro(folder, "n")
    need(len(draws) == 3, f"{len(draws)} fields")
    for draw, label in zip(draws, ("shear strain", "void ratio", "broken grains, share")):
        fig, ax = plt.subplots()
        draw(ax)
        paint = ax.collections[0]
        need(ax.get_title() == f"n: {label} in the last frame, as displaced" and not ax.axison and len(fig.axes) == 2
             and fig.axes[1].get_ylabel() == label and ax.get_aspect() == 1, f"{label}: {ax.get_title()}")
        need(len(paint.get_paths()) == 6, f"{len(paint.get_paths())} faces of two cubes are seen")
        if label == "void ratio":
            owner = np.ma.getmaskarray(paint.get_array())
            need(list(owner) == [True] * 3 + [False] * 3, f"the nearer cube is drawn last: {owner}")
        plt.close(fig)
    with h5py.File(os.path.join(folder, "macro", "macro_00000.hdf"), "r+") as f:
        f["VTKHDF/Types"][:] = 1
    need(pictures.macro(folder, "n") == [], "cells that are no cells")
    for kind, faces in pictures.FACES.items():  # each corner of a solid in three or more, each edge in two faces
        edges = [frozenset((face[i - 1], face[i])) for face in faces for i in range(len(face))]
        count = {5: 1, 9: 1, 10: 2, 12: 2}[kind]
        need(all(edges.count(e) == count for e in edges) and
             sorted({c for face in faces for c in face}) == list(range({5: 3, 9: 4, 10: 4, 12: 8}[kind])),
             f"faces of cells of kind {kind}")


with tempfile.TemporaryDirectory() as place:
    of_pictures(place)
print(f"report_frames: {len(faults)} faults")
sys.exit(bool(faults))
