#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/stages.md as a user takes it: its scenes, which are the shipped ones, run, and show what the page says:
recipes.py BUILD"""
import os
import re
import subprocess
import sys
import tempfile

from scene_tools import faults, history, need, shipped, summary

build = os.path.abspath(sys.argv[1])
text = open(os.path.join(shipped, "..", "..", "docs", "stages.md")).read()
environment = {**os.environ, "PATH": os.path.join(build, "bin") + os.pathsep + os.environ["PATH"]}


def rows_of(folder):
    return [{k: float(v) for k, v in row.items()} for row in history(folder)]


def slope(rows):
    """Modulus (Pa) between the ends of some rows."""
    first, last = rows[0], rows[-1]
    return (last["axial_stress_Pa"] - first["axial_stress_Pa"]) / (last["axial_strain"] - first["axial_strain"])


def told(pattern):
    found = re.search(pattern, text)
    need(found is not None, f"the page does not say {pattern}")
    return [float(x) for x in found.groups()] if found else []


def oedometer(folder):
    rows = rows_of(folder)
    stage = lambda k: [r for r in rows if r["stage"] == k]
    up, down = slope(stage(4)[-6:]), slope(stage(4)[-1:] + stage(5)[:5])
    said = told(r"modulus of (\d+) MPa, the first of the way down (\d+) MPa")
    need(all(abs(1e6 * s / x - 1) < 0.02 for s, x in zip(said, (up, down))), f"moduli {up}, {down} Pa; said {said}")
    for k, asked in ((1, 1e6), (2, 0.2e6), (3, 1e6), (4, 4e6), (5, 0.8e6), (6, 4e6)):
        end = stage(k)[-1]["axial_stress_Pa"]
        need(abs(end / asked - 1) < 2e-3, f"stage {k}: {end} Pa")
    need(abs(rows[-1]["energy_error"]) < 1e-3, f"energy error {rows[-1]['energy_error']}")
    asked, told_of = 0.79 - 0.4 * (0.79 - 0.58), summary(folder)["preparation"]
    need(abs(rows[0]["void_ratio"] - asked) < 0.003 and abs(told_of["asked_void_ratio"] - asked) < 1e-12, f"{told_of}")


def cyclic(folder):
    rows, ends = rows_of(folder), summary(folder)["stages"]
    need([s["ended_by"] for s in ends] == ["unbalanced_force", "strain"], f"{ends}")
    first, least, cycles = told(r"from (\d+) kPa to ([\d.]+) kPa; after ([\d.]+) cycles")
    last = rows[-1]
    need(last["cycle"] == cycles, f"{last['cycle']} cycles, said {cycles}")
    lowest = min(r["p_Pa"] for r in rows)
    need(abs(lowest / 1e3 - least) < 0.5 and abs(rows[0]["p_Pa"] / 1e3 - first) < 0.5,
         f"mean stress from {rows[0]['p_Pa']} down to {lowest} Pa, said {first} and {least} kPa")
    ratios = [r["void_ratio"] for r in rows if r["stage"] == 2]
    need(max(ratios) - min(ratios) < 1e-5, f"volume: {min(ratios)} to {max(ratios)}")


with tempfile.TemporaryDirectory() as tmp:
    for kind, name, block in re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```", text, re.S | re.M):
        if kind == "toml":
            need(block == open(os.path.join(shipped, name)).read(), f"{name} of the page is not the shipped one")
            open(os.path.join(tmp, name), "w").write(block)
        for line in block.splitlines() if kind == "sh" else ():
            r = subprocess.run(["bash", "-c", line], cwd=tmp, env=environment, capture_output=True, text=True)
            need(r.returncode == 0 and r.stderr == "", f"{line}: exit {r.returncode} {r.stderr[-300:]}")
    oedometer(os.path.join(tmp, "oedometer_loops"))
    cyclic(os.path.join(tmp, "cyclic_triaxial"))
print(f"recipes: {len(faults)} faults")
sys.exit(1 if faults else 0)
