# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests of several stages: their text, their runs, their rows; and columns of spheres, whose stress is known."""
import math
import os
import sys

from scene_tools import SOFT_SAND, history, need, pressed_cell, run, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
E, NU, RADIUS = 10e9, 0.2, 1e-3
LATTICE = SOFT_SAND + """
[packing]
kind = "simple-cubic"
radius = { distribution = "constant", mean = "1 mm" }
layers = [2, 2, 2]
[boundary]
kind = "periodic"
"""
CELL = pressed_cell(0.6, 0.1)
BOX = pressed_cell(0.5, 0.1).partition("[boundary]")[0] + """
[boundary]
kind = "walls"
friction = 0
"""


def stage(kind, **keys):
    text = lambda v: "{ " + ", ".join(f"{k} = {text(x)}" for k, x in v.items()) + " }" if isinstance(v, dict) else (
        f'"{v}"' if isinstance(v, str) else str(v))
    return f'[[stage]]\nkind = "{kind}"\n' + "".join(f"{k} = {text(v)}\n" for k, v in keys.items())


def numbers(folder):
    return [{k: float(v) for k, v in row.items()} for row in history(folder)]


def go(tmp, name, text, *options, status=0, begin=()):
    write(tmp, text, name + ".toml")
    folder = os.path.join(tmp, name)
    r = run(rve, os.path.join(tmp, name + ".toml"), "-o", folder, "--quiet", "--threads", "1", *options)
    need(r.returncode == status, f"{name}: exit {r.returncode}: {r.stderr.strip()[-300:]}")
    return folder, r


def of_stage(rows, number):
    return [r for r in rows if r["stage"] == number]


def lattice_stress(strain):
    """Columns of spheres, one on the other, on squares of 2 R: Hertz's force over (2 R)^2."""
    modulus = E / (2 * (1 - NU**2))
    return 4 / 3 * modulus * math.sqrt(RADIUS / 2) * (2 * RADIUS * strain)**1.5 / (2 * RADIUS)**2
