#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A void ratio that a preparation is asked to leave: found within its tolerance, the same however it is asked and by
any threads, refused with the range that there is; told of an RVE as of a sample: density.py BIN"""
import os
import re
import sys
import tempfile

from scene_tools import faults, history, need, pressed_cell, program, run, summary, write

rve = os.path.join(os.path.abspath(sys.argv[1]), "grus-rve")
TOLERANCE = 0.003  # dem/sample/density.hpp
SCENE = pressed_cell(0.55, 0.4) + """@asked@
[loading]
kind = "uniaxial-strain"
strain_rate = 5
final_strain = 0.0002
"""
BLOCK = """
[mesh]
box = { size = ["40 mm", "40 mm", "40 mm"], cells = [1, 1, 1] }
[rve]
scene = "asked.toml"
set = ["numerics.safety=0.3"]           # as the cell alone has it
unbalanced_force = 1e-2
stress_change = 1e-2
[solve]
kind = "quasi-static"
increments = 1
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
where = "z=max"
pressure = "0.5 MPa"
displacement = [0, 0, "-4 um"]
"""


def of_problem(tmp, alone, said):
    """The cell of a macro problem is prepared as it is alone, and told alike; a pressure that grows is told, too."""
    bvp = program(os.path.abspath(sys.argv[1]), "grus-bvp")
    if not bvp:
        return
    note = re.search(r"preparation: a friction of .* tried\)", said)[0]
    block, out = write(tmp, BLOCK, "block.toml"), os.path.join(tmp, "block")
    checked = run(bvp, block, "--check", "--threads", "1")
    need(checked.stdout.count("unit cell: " + note) == 1, f"--check: {checked.stdout} {checked.stderr}")
    grows = "so its pressure grows from 0 to 0.5 MPa"
    need(checked.stdout.count(grows) == 1, f"a pressure without history: {checked.stdout}")
    for form in ("constant", "ramp"):
        r = run(bvp, block, "--check", "--threads", "1", "--set", f"boundary.1.history={form}")
        need(r.returncode == 0 and grows not in r.stdout, f"history {form}: {r.stdout} {r.stderr}")
    r = run(bvp, block, "-o", out, "--threads", "1", "--set", "boundary.1.pressure=")
    told = summary(out)["preparation"]
    need(r.returncode == 0 and "unit cell: " + note in r.stdout and grows not in r.stdout, f"{r.stdout} {r.stderr}")
    need(told["friction"] == 2 * [alone["friction"]] and told["tries"] == alone["tries"]
         and told["asked_void_ratio"] == 2 * [alone["asked_void_ratio"]], f"told {told}, alone {alone}")


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
    of_problem(tmp, told, r.stdout)
    # What was found is a friction: the same preparation with it leaves the same sample.
    plain, _ = go(tmp, "plain", "", "--set", f"preparation.friction={told['friction']!r}")
    text = lambda folder: open(os.path.join(folder, "history.csv")).read()
    need(text(plain) == text(folder), "the friction that was found leaves another sample")
    # Frictionless grains rattle on at a long step, which is told as it is; a step of half of that brings them to rest.
    for safety, status in ((0.7, 3), (0.35, 0)):
        _, r = go(tmp, f"rattles{status}", "", "--set", "preparation.friction=0", "--set", f"numerics.safety={safety}",
                  status=status)
        need((r.stderr == "") == (status == 0) and (not status or "0.5 MPa is reached, but the sample does not come to "
             "rest there: grains rattle on, which half of numerics.safety (now 0.7)" in r.stderr), r.stderr)
    _, r = go(tmp, "rattling", "void_ratio = 0.3", "--set", "numerics.safety=0.7", status=2)
    need("friction while compressing from 0.02 to 1 leaves" in r.stderr, f"a search without its end: {r.stderr}")
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
