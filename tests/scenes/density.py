#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A void ratio that a preparation is asked to leave: found within its tolerance, the same however it is asked and by
any threads, refused with the range that there is: density.py BIN"""
import os
import re
import sys
import tempfile

from scene_tools import faults, history, need, pressed_cell, run, summary, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
TOLERANCE = 0.003  # dem/sample/density.hpp
SCENE = pressed_cell(0.55, 0.4) + """@asked@
[loading]
kind = "uniaxial-strain"
strain_rate = 5
final_strain = 0.0002
"""


def go(tmp, name, asked, *options, status=0):
    scene = write(tmp, SCENE.replace("@asked@", asked), name + ".toml")
    folder = os.path.join(tmp, name)
    r = run(rve, scene, "-o", folder, *(options or ("--threads", "1")))
    need(r.returncode == status, f"{name}: exit {r.returncode}: {r.stderr.strip()[-300:]}")
    return folder, r


with tempfile.TemporaryDirectory() as tmp:
    ends = [go(tmp, f"friction{f:g}", "", "--set", f"preparation.friction={f}")[0] for f in (0, 1)]
    limits = [summary(folder)["preparation"]["void_ratio"] for folder in ends]
    need(limits[1] > limits[0] + 0.05, f"void ratios from {limits[0]} to {limits[1]}: nothing to search between")
    asked = limits[0] + 0.4 * (limits[1] - limits[0])
    folder, r = go(tmp, "asked", f"void_ratio = {asked:.4f}")
    told = summary(folder)["preparation"]
    need(abs(told["void_ratio"] - asked) <= TOLERANCE + 1e-4, f"asked {asked}, found {told}")
    first = float(history(folder)[0]["void_ratio"])
    need(abs(first - told["void_ratio"]) < 1e-9, f"the test begins at {first}, told {told['void_ratio']}")
    need(0 < told["friction"] < 1 and told["tries"] >= 3 and abs(told["asked_void_ratio"] - asked) < 1e-4, f"{told}")
    need(f"a friction of {told['friction']:.4g} leaves a void ratio of {told['void_ratio']:.4f}" in r.stdout, r.stdout)
    # What was found is a friction: the same preparation with it leaves the same sample.
    plain, _ = go(tmp, "plain", "", "--set", f"preparation.friction={told['friction']!r}")
    text = lambda folder: open(os.path.join(folder, "history.csv")).read()
    need(text(plain) == text(folder), "the friction that was found leaves another sample")
    loosest, densest = 0.9, 0.6
    relative, _ = go(tmp, "relative",
                     f"relative_density = {(loosest - asked) / (loosest - densest):.12g}\nvoid_ratio_max = {loosest}\n"
                     f"void_ratio_min = {densest}", "--threads", "2")
    need(abs(summary(relative)["preparation"]["void_ratio"] - asked) <= TOLERANCE + 1e-4, "by relative density")
    for wanted in (0.3, 1.5):
        target, r = go(tmp, f"beyond{wanted:g}", f"void_ratio = {wanted}", status=2)
        found = re.search(r"preparation.void_ratio: a void ratio of [\d.]+ is not reached at 0.5 MPa: .*leaves "
                          r"([\d.]+) to ([\d.]+)", r.stderr)
        need(found and r.stderr.count("\n") == 1 and not os.path.exists(target), f"{wanted}: {r.stderr}")
        need(found and all(abs(float(x) - e) < 6e-4 for x, e in zip(found.groups(), limits)),
             f"the range is {limits}, told {r.stderr}")
print(f"density: {len(faults)} faults")
sys.exit(1 if faults else 0)
