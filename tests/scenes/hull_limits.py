#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inertia by step in whole runs of hulls at their limits: hull_limits.py BIN

Needles and plates of 1 : 10, flat balls, sizes of 1 : 100, all grains below the step that is wanted; from a loose
sample through its preparation to the end. The balance closes, no step is shorter than asked, and there are as many
fewer of them."""
import os
import sys
import tempfile

import scene_tools
from scene_tools import faults, history, need, run, summary

rve = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-rve")
ROCK = """[material.rock]
density = 2650
contact = "overlap"
youngs_modulus = "2 GPa"
friction = 0.5
restitution = 0.3
"""
LOOSE = ROCK + """[packing]
kind = "random"
box = [{box}, {box}, {box}]
radius = {{ distribution = "uniform", min = {least}, max = {most} }}
solid_fraction = {dense}
hulls = {{ {hulls} }}
[boundary]
kind = "{bounds}"
[preparation]
pressure = "100 kPa"
friction = 0.2
[loading]
kind = "uniaxial-strain"
strain_rate = "20 1/s"
final_strain = 0.01
[output]
history_interval = 0.002
"""
SLENDER = {"least": 2e-4, "most": 2.5e-4, "bounds": "walls"}
KINDS = {
    "needles": LOOSE.format(box=3.6e-3, dense=0.02, hulls="relax = 3, aspect = [10, 1, 1]", **SLENDER),
    "plates": LOOSE.format(box=2.7e-3, dense=0.05, hulls="relax = 3, aspect = [10, 10, 1]", **SLENDER),
    "flat balls": LOOSE.format(box=5e-3, least=3.5e-4, most=6.5e-4, dense=0.14, bounds="periodic",
                               hulls="balls = 32, aspect = [3, 3, 1]")
}


def ended(tmp, name, scene, *settings):
    """Rows and summary of a run to its end."""
    path, out = os.path.join(tmp, "scene.toml"), os.path.join(tmp, "out")
    with open(path, "w") as f:
        f.write(scene)
    r = run(rve, path, "-o", out, "--quiet", "--force", "--threads", "1", *[a for s in settings for a in ("--set", s)])
    need(r.returncode == 0, f"{name}: exit {r.returncode} {r.stderr}")
    if r.returncode:
        return None, None
    return [{k: float(v) for k, v in row.items() if v} for row in history(out)], summary(out)


def compared(tmp, name, scene, times, *settings):
    """A run at its own step and one at a step so many times as long."""
    rows, own = ended(tmp, name, scene, *settings)
    if not rows:
        return None
    step = times * min(x["time_step_s"] for x in rows)
    name = f"{name}, {times:g} times the own step"
    rows, told = ended(tmp, name, scene, *settings, f"numerics.inertia.step={step}")
    if not rows:
        return None
    energy, least = max(abs(x["energy_error"]) for x in rows), min(x["time_step_s"] for x in rows)
    need(energy < 1e-3, f"{name}: energy error {energy}")
    need(least >= step * (1 - 1e-6), f"{name}: a step of {least / step} of what is asked")
    fewer = own["counts"]["steps"] / told["counts"]["steps"]
    need(fewer > 0.5 * times, f"{name}: {fewer} times fewer steps")
    added = told["inertia"]
    return added


def shapes(tmp):
    """Each at 4 and 20 times its own step: at 20 all grains are below it, and all turn too fast as well."""
    for name, scene in KINDS.items():
        for times in (4, 20):
            added = compared(tmp, name, scene, times)
            if added:
                need(added["added_mass"]["worst"] > 1, f"{name}: {added}")
            if times == 20 and added:
                need(added["heavier_grains"] == 1 and added["slower_grains"] > 0.9, f"{name}: not all: {added}")


def sizes(tmp):
    """A tower of twelve cubes, from 1 mm to 10 um, that its lid presses: the least, on its top, gives way."""
    scene, edges, top, deep = ROCK.replace('youngs_modulus = "2 GPa"', "foundation = 4e12"), [], 0, 1e-10
    for k in range(12):
        edges.append(1e-3 * 0.01**(k / 11))
        top += edges[-1] - deep
        at = [1e-3, 1e-3, top - 0.5 * edges[-1]]
        scene += f'[[grain]]\nshape = "hull"\nbox = {[edges[-1]] * 3}\nposition = {at}\n'
    scene += f"""[boundary]
kind = "walls"
box = [2e-3, 2e-3, {top - deep}]
[loading]
kind = "uniaxial-strain"
strain_rate = 1
final_strain = 1e-4
[output]
history_interval = 1e-5
critical_grain = true
"""
    added = compared(tmp, "sizes of 1 : 100", scene, 10)
    if added:
        need(0 < added["heavier_grains"] < 1, f"sizes: {added}")  # the largest bear the step as they are


with tempfile.TemporaryDirectory() as folder:
    for check in (shapes, sizes):
        check(folder)
print("hull_limits:", len(faults), "faults")
sys.exit(bool(faults))
