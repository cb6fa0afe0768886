#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus.bands against closed forms: shear strain of known deformations, and bands of a known width across meshes:
bands.py BUILD"""
import math
import os
import sys
import types

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import grus  # noqa: E402
from grus.bands import shear_band, shear_strain  # noqa: E402

import scene_tools  # noqa: E402
from scene_tools import faults, need  # noqa: E402

CORNERS = {9: ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)), 10: ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
           12: ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
           5: ((0, 0, 0), (1, 0, 0), (0, 1, 0))}


def frame(kind, counts, size, moved):
    """A frame as grus-bvp writes it: a grid of elements, each with corners of its own. Where simplices are asked each
    brick gives one, so that they do not fill it."""
    cells = np.stack(np.meshgrid(*(range(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    steps = np.array(size) / np.maximum(counts, 1)
    points = ((cells[:, None] + np.array(CORNERS[kind])) * steps).reshape(-1, 3)
    return types.SimpleNamespace(path="f", points=points.astype(np.float32), types=np.full(len(cells), kind, np.uint8),
                                 connectivity=np.arange(len(points)),
                                 at_points={"displacement_m": np.array([moved(x) for x in points], np.float32)})


def of(kind, first, last, counts=(4, 3, 2), size=(0.4, 0.3, 0.2)):
    """Frames of a body that is taken from one deformation gradient to another, and has been moved before."""
    away = np.array([0.1, -0.2, 0])
    return [frame(kind, counts, size, lambda x, f=f: (np.array(f) - np.eye(3)) @ x + away) for f in (first, last)]


def strains():
    """Of simple shear g: principal stretches are k and 1/k with k - 1/k = g, so that the strain is 2 asinh(g/2); of
    uniaxial compression to c: log(1/c) sqrt(4/3); none of a turn or of a change of volume."""
    one = np.eye(3)
    g, c, angle = 0.3, 0.9, 0.7
    sheared = one + g * np.outer([1, 0, 0], [0, 1, 0])
    turned = np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])
    for kind, counts, size in ((9, (4, 3, 1), (0.4, 0.3, 0)), (5, (4, 3, 1), (0.4, 0.3, 0)),
                               (10, (4, 3, 2), (0.4, 0.3, 0.2)), (12, (4, 3, 2), (0.4, 0.3, 0.2))):
        tell = lambda a, b: shear_strain(*of(kind, a, b, counts, size))
        shape = counts[0] * counts[1] * counts[2]
        found = tell(one, sheared)
        need(found.shape == (shape,), f"{kind}: {found.shape} elements")
        need(abs(found - 2 * math.asinh(g / 2)).max() < 1e-6, f"{kind}: simple shear {found}")
        # from a turned and squeezed state on: what came before does not count
        before = turned @ np.diag([1.1, 0.8, 1.0])
        found = tell(before, turned @ sheared @ turned.T @ before)
        need(abs(found - 2 * math.asinh(g / 2)).max() < 1e-6, f"{kind}: sheared from another state {found}")
        found = tell(one, turned @ np.diag([1, c, 1]))
        need(abs(found - math.sqrt(4 / 3) * math.log(1 / c)).max() < 1e-6, f"{kind}: compressed {found}")
    found = shear_strain(*of(12, one, 1.2 * turned))
    need(found.max() < 1e-3, f"a turn and a change of volume: {found.max()}")  # single precision: sqrt(1e-7)


def bands():
    """A band with the profile 1 / cosh^2(d / w) is 2 w acosh(sqrt 2) wide at half of its height. Elements of h widen it
    by some h^2 / (2 w^2), the level beside it narrows it by a hundredth or two."""
    size, w, centre = (0.05, 0.1, 0), 5e-3, np.array([0.025, 0.05, 0])
    still = lambda x: np.zeros(3)
    width = 2 * w * math.acosh(math.sqrt(2))
    for n, allowed in ((48, 0.04), (20, 0.12)):
        for angle in (57, 131):
            along = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0])
            across = np.array([-along[1], along[0], 0])
            moved = lambda x: 1e-3 * math.tanh((x - centre) @ across / w) * along
            b = shear_band(frame(9, (n, 2 * n, 1), size, still), frame(9, (n, 2 * n, 1), size, moved))
            need(abs(b.width / width - 1) < allowed, f"{n}, {angle}: a width of {b.width}, not {width}")
            need(abs(b.angle - angle) < 3, f"{n}: an angle of {b.angle}, not {angle}")
            need(abs(b.peak / 0.2 - 1) < allowed + 0.02, f"{n}, {angle}: a peak of {b.peak}, not 0.2")
    # the same in a body that shears by half of it anyway, with one element in a corner that shears most of all
    even = lambda x: moved(x) + 0.1 * ((x - centre) @ across) * along
    after = frame(9, (n, 2 * n, 1), size, even)
    after.at_points["displacement_m"][2:4, 0] += 2e-3
    b = shear_band(frame(9, (n, 2 * n, 1), size, still), after)
    need(abs(b.width / width - 1) < allowed and abs(b.angle - angle) < 3, f"in a body that shears: {b}, not {width}")
    # a layer of two of ten rows of unequal shear: (2 + 8 r)^2 / (10 (2 + 8 r^2)) of the body takes part
    r = 0.1
    rows = np.concatenate([[0], np.cumsum([r, r, r, r, 1, 1, r, r, r, r])])
    layer = lambda x: np.array([0.01 * np.interp(x[1], np.arange(11), rows), 0, 0])
    part = (2 + 8 * r)**2 / (10 * (2 + 8 * r * r))
    b = shear_band(frame(9, (3, 10, 1), (3, 10, 0), still), frame(9, (3, 10, 1), (3, 10, 0), layer))
    need(abs(b.fraction - part) < 1e-3 and b.angle in (0, 179) and 1.5 < b.width < 3.5, f"a layer: {b}, not {part}")
    b = shear_band(frame(12, (3, 10, 2), (3, 10, 2), still), frame(12, (3, 10, 2), (3, 10, 2), layer))
    need(abs(b.fraction - part) < 1e-3 and np.isnan([b.width, b.angle, b.peak]).all(), f"in three dimensions: {b}")
    b = shear_band(*of(9, np.eye(3), np.diag([1, 0.9, 1]), (4, 3, 1), (0.4, 0.3, 0)))
    need(abs(b.fraction - 1) < 1e-6 and np.isnan(b.width), f"an even strain: {b}")
    b = shear_band(*of(9, np.eye(3), np.eye(3), (4, 3, 1), (0.4, 0.3, 0)))
    need(b.fraction == 1 and np.isnan(b.width), f"nothing moved: {b}")


def refusals():
    a, b = of(9, np.eye(3), np.eye(3), (4, 3, 1), (0.4, 0.3, 0))
    other = of(9, np.eye(3), np.eye(3), (3, 3, 1), (0.4, 0.3, 0))[0]
    scene_tools.refused("another mesh", lambda: shear_band(a, other), grus.InputError)
    run = types.SimpleNamespace(macro=lambda number: a)
    scene_tools.refused("between two frames", lambda: grus.Results.shear_band(run, 3, 3), grus.InputError)
    b.at_points = {}
    scene_tools.refused("not a frame of a macro problem", lambda: shear_band(a, b), grus.InputError)
    a.types[0] = 5
    scene_tools.refused("of the kinds [5, 9]", lambda: shear_band(a, a), grus.InputError)


strains()
bands()
refusals()
print(f"bands: {len(faults)} faults")
sys.exit(bool(faults))
