#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Flat ellipsoids and angular hulls that are packed as densely as asked, in a cell and between walls, and boxes that
are compressed before a test: packed.py BIN"""
import os
import re
import sys
import tempfile

import numpy as np

from scene_tools import faults, history, need, run, summary, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
PACKED = """
seed = 2
[material.sand]
density = 2650
@material@
friction = 0.5
restitution = 0.5
[packing]
kind = "random"
box = [@box@, @box@, @box@]
radius = { distribution = "uniform", min = "0.25 mm", max = "0.35 mm" }
@shape@
[boundary]
kind = "@bounds@"
[loading]
kind = "free"
duration = "20 us"
"""
HERTZ, HULLS = 'youngs_modulus = "60 GPa"', 'contact = "overlap"\nyoungs_modulus = "2 GPa"'
FLAT = 'mixture = [{ material = "sand", share = 1, aspect = [1, 0.8, 0.5] }]\n'
BOX = """
[material.sand]
density = 2650
youngs_modulus = "10 GPa"
friction = 0.5
restitution = 0.5
damping = 0.2
[packing]
kind = "random"
box = ["3 mm", "3 mm", "3 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.28 mm" }
solid_fraction = 0.55
[boundary]
kind = "walls"
[preparation]
pressure = "200 kPa"
@asked@
[loading]
"""
TRIAXIAL = """kind = "triaxial"
strain_rate = 5
confining_pressure = "200 kPa"
final_strain = 0.0002
"""


def go(tmp, name, text, *options, status=0):
    folder = os.path.join(tmp, name)
    r = run(rve, write(tmp, text, name + ".toml"), "-o", folder, "--threads", "1", *options)
    need(r.returncode == status, f"{name}: exit {r.returncode}: {r.stderr.strip()[-300:]}")
    return folder, r


def dense(tmp, name, bounds, fraction, material, shape, box="3.2e-3"):
    """As dense as asked, and nothing presses: what is left moves no grain and lets no contact bear."""
    text = PACKED.replace("@bounds@", bounds).replace("@box@", box).replace("@material@", material)
    folder, _ = go(tmp, name, text.replace("@shape@", shape + f"solid_fraction = {fraction}"))
    rows, told = history(folder), summary(folder)
    need(abs(1 / (1 + float(rows[0]["void_ratio"])) - fraction) < 1e-9, f"{name}: solid fraction")
    pressed = max(abs(float(r["mean_pressure_Pa"])) for r in rows)
    need(pressed < 1e3, f"{name}: grains press each other by {pressed} Pa")
    need(told["errors"]["packing_overlap"] < 6e-3, f"{name}: {told['errors']['packing_overlap']}")


def boxes(tmp):
    """Compressed to a pressure by all of its walls, at a void ratio that is asked."""
    ends = []
    for friction in (0, 1):
        folder, _ = go(tmp, f"friction{friction}", BOX.replace("@asked@", f"friction = {friction}") + TRIAXIAL)
        told, first = summary(folder)["preparation"], history(folder)[0]
        for k in "xyz":
            got = -float(first[f"wall_stress_{k}{k}_Pa"])
            need(abs(got / 2e5 - 1) < 0.03, f"friction {friction}: the {k} walls press by {got} Pa")
        need(np.allclose(told["stress_Pa"], [-float(first[f"wall_stress_{k}{k}_Pa"]) for k in "xyz"], rtol=1e-6), told)
        ends.append(told["void_ratio"])
    need(ends[1] > ends[0] + 0.02, f"void ratios from {ends[0]} to {ends[1]}: nothing to search between")
    asked = 0.5 * (ends[0] + ends[1])
    folder, r = go(tmp, "asked", BOX.replace("@asked@", f"void_ratio = {asked:.4f}") + TRIAXIAL)
    first = float(history(folder)[0]["void_ratio"])
    need(abs(first - asked) < 0.0031, f"asked {asked}, found {first}")
    need(f"void ratio {first:.4f}" in r.stdout, f"the console tells no void ratio of {first}: {r.stdout[:300]}")
    _, r = go(tmp, "beyond", BOX.replace("@asked@", "void_ratio = 0.3") + TRIAXIAL, status=2)
    found = re.search(r"is not reached at 0.2 MPa: .*leaves ([\d.]+) to ([\d.]+)", r.stderr)
    need(found and np.allclose([float(x) for x in found.groups()], ends, atol=6e-4), f"{ends}: {r.stderr}")
    # A side goes its own way in the test alone: the volume falls by its area times its way.
    side = '[[wall]]\nside = "zmax"\nvelocity = [0, 0, "-0.02 m/s"]\n'
    folder, _ = go(tmp, "side", BOX.replace("@asked@", "friction = 0.2") + 'kind = "free"\nduration = "1 ms"\n' + side)
    e = [1 + float(row["void_ratio"]) for row in history(folder)]
    told = summary(folder)
    height = 0.02 * 1e-3 / (1 - e[-1] / e[0])
    need(2.5e-3 < height < 3e-3, f"the side went as if the box were {height} m high")
    need(abs(told["preparation"]["void_ratio"] - e[0] + 1) < 1e-9, "the side moved before the test")


def again(tmp):
    """Spheres that are exported are read again, with their box: the same sample."""
    pressed = BOX.replace("@asked@", "friction = 0.2")
    folder, _ = go(tmp, "first", pressed + 'kind = "free"\nduration = "20 us"\n[output]\nframes = 2\n')
    r = run(os.path.join(os.path.dirname(rve), "grus"), "export", folder, "-o", os.path.join(tmp, "again.txt"))
    need(r.returncode == 0, f"export: {r.stderr}")
    other, _ = go(tmp, "again", pressed[:pressed.index("[packing]")] + """[packing]
kind = "file"
path = "again.txt"
material = "sand"
[boundary]
kind = "walls"
[loading]
kind = "free"
duration = "1 us"
""")
    was, now = history(folder)[-1], history(other)[0]
    need(was["grains"] == now["grains"] and abs(float(now["void_ratio"]) / float(was["void_ratio"]) - 1) < 1e-5,
         f"another sample: {was['void_ratio']}, {now['void_ratio']}")


with tempfile.TemporaryDirectory() as tmp:
    again(tmp)
    dense(tmp, "flat", "periodic", 0.62, HERTZ, FLAT)
    dense(tmp, "flat_walls", "walls", 0.58, HERTZ, FLAT)
    dense(tmp, "angular", "periodic", 0.6, HULLS, "hulls = { relax = 0 }\n")
    text = PACKED.replace("@bounds@", "periodic").replace("@box@", "3.2e-3").replace("@material@", HERTZ)
    _, r = go(tmp, "jammed", text.replace("@shape@", FLAT + "solid_fraction = 0.73"), status=2)
    found = re.search(r"0.73: the densest random packing found of these grains in this box is (0.\d+);", r.stderr)
    need(found and 0.66 < float(found[1]) < 0.73, r.stderr)
    if found:  # what it says can be had
        dense(tmp, "told", "periodic", float(found[1]), HERTZ, FLAT)
    _, r = go(tmp, "aligned", text.replace("@shape@", FLAT + 'solid_fraction = 0.5\norientation = "aligned"'), status=2)
    need("the densest random packing found" in r.stderr, r.stderr)
    boxes(tmp)
print(f"packed: {len(faults)} faults")
sys.exit(1 if faults else 0)
