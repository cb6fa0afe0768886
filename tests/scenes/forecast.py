#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What --check tells of the steps and the time of a run is so: forecast.py BIN"""
import os
import re
import sys
import tempfile

import scene_tools
from scene_tools import faults, need, run, shipped, write

rve = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-rve")
BALLS = """
[material.s]
density = 2650
{contact}
friction = 0.3
damping = 0.2
[packing]
kind = "simple-cubic"
layers = [4, 4, 4]
radius = {{ distribution = "constant", mean = "1 mm" }}
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
strain_rate = 20
final_strain = 0.02
"""


def short(tmp):
    """Steps and seconds that --check tells are those of the run: of a short test, to a percent."""
    spring = 'contact = "linear-modulus"\ncontact_modulus = "50 MPa"\nshear_ratio = 0.5'
    hertz, short = 'youngs_modulus = "1 GPa"\npoissons_ratio = 0.2', ("--set", "loading.final_strain=0.03")
    with open(os.path.join(shipped, "single_grain.toml")) as f:
        grain = f.read()
    for name, scene, more in (("fixed", BALLS.format(contact=hertz), ("--set", "numerics.time_step=1e-6")),
                              ("linear", BALLS.format(contact=spring), ()), ("hertz", BALLS.format(contact=hertz), ()),
                              ("grain", grain, (*short, "--set", "output.frames=0"))):
        out, path = os.path.join(tmp, name), write(tmp, scene, name + ".toml")
        ran = run(rve, path, "-o", out, "--threads", "1", *more)
        need(ran.returncode == 0, f"{name}: {ran.stderr}")
        r = run(rve, path, "--check", "--threads", "1", *more)
        told = re.search(r"steps about (\S+) .*\n  run time about .* s \(the whole test was gone through\)", r.stdout)
        ratio = scene_tools.summary(out)["counts"]["steps"] / float(told[1]) if told else 0
        need(0.99 < ratio < 1.01, f"{name}: {ratio} times the steps that --check tells: {r.stdout} {r.stderr}")
        first = re.search(r"steps (at least about|about) (\S+) ", ran.stdout)
        need(first and (first[1] == "about") == (name == "fixed"), f"{name}: the run says {first}")


def longer(tmp):
    """Stages, at first with 900 times the mass, then by what that took: the range that is told holds the run."""
    loops = os.path.join(shipped, "oedometer_loops.toml")
    out, fewer = os.path.join(tmp, "loops"), ("--set", "output.frames=0")
    r = run(rve, loops, "--check", *fewer)
    told = re.search(
        r"steps (\S+) to (\S+) .*\n  run time (.*) to (.*) \((.*) rehearsed with grains (\S+) times as heavy", r.stdout)
    ran = run(rve, loops, "-o", out, "--quiet", *fewer)
    need(told and ran.returncode == 0, f"loops: {r.stdout} {r.stderr} {ran.stderr}")
    if told:
        made = scene_tools.summary(out)["counts"]["steps"]
        need(float(told[1]) < made < float(told[2]) <= 4.2 * float(told[1]) and 2 < float(told[6]) < 901,
             f"loops: {made} steps, {told[0]}")


with tempfile.TemporaryDirectory() as tmp:
    short(tmp)
    longer(tmp)
print("FAULTS" if faults else "what is told beforehand is so")
sys.exit(1 if faults else 0)
