#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/tutorial.md as a user takes it: its files are written, its commands run, one after the other: tutorial.py
BUILD"""
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from scene_tools import faults, history, need

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
text = open(os.path.join(source, "docs", "tutorial.md")).read()
environment = {**os.environ, "PATH": os.path.join(build, "bin") + os.pathsep + os.environ["PATH"]}


def run(line, folder):
    if line.startswith("gmsh ") and shutil.which("gmsh") is None:  # as the page says
        shutil.copy(os.path.join(source, "meshes", "pile.msh"), folder)
        return
    r = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=1000)
    need(r.returncode == 0, f"{line}: exit {r.returncode} {r.stdout[-300:]} {r.stderr[-300:]}")
    if line.startswith("grus "):
        need(r.stderr == "", f"{line}: says {r.stderr}")


with tempfile.TemporaryDirectory() as folder:
    for kind, name, block in re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```", text, re.S | re.M):
        if kind == "sh":
            for line in block.splitlines():
                run(line, folder)
        else:
            need(name != "", f"a block without a name: {block[:40]}")
            open(os.path.join(folder, name), "w").write(block)
    at = lambda *parts: os.path.join(folder, *parts)
    need(
        open(at("pile.geo")).read() == open(os.path.join(source, "meshes", "pile.geo")).read(),
        "meshes/pile.geo is another mesh than the tutorial's")
    count = lambda path: re.search(r"\$Nodes\n\d+ (\d+)", open(path).read())[1]
    need(count(at("pile.msh")) == count(os.path.join(source, "meshes", "pile.msh")), "meshes/pile.msh has other nodes")
    for name in ("sand", "cell", "pile"):
        need(json.load(open(at(name, "summary.json")))["status"] == 0, f"{name} has not ended well")
    told = [int(n) for n in re.search(r"says that (\d+) grains have become (\d+), by (\d+) breakages", text).groups()]
    last = history(at("sand"))[-1]
    found = [int(history(at("sand"))[0]["grains"]), int(last["grains"]), int(last["breakages"])]
    need(all(abs(a - b) <= 0.05 * b for a, b in zip(told, found)), f"the page says {told} grains, the run {found}")
    # The page's sieve: half of the mass or so is finer than 0.48 mm before the test, and more after it.
    passing = {}
    for row in csv.DictReader(open(at("sand", "grading.csv"))):
        passing.setdefault(float(row["strain"]), []).append((float(row["diameter_m"]), float(row["passing"])))
    share = lambda strain: max(p for d, p in passing[strain] if d <= 0.5e-3)
    first, last = min(passing), max(passing)
    need(
        abs(share(first) - 0.55) < 0.06 and share(last) > share(first) + 0.02,
        f"passing 0.5 mm: {share(first)}, then {share(last)}")
    told = [float(x) for x in re.search(r"it says (\d+) MPa ± (\d+)", text).groups()]
    found = json.load(open(at("strength", "calibration.json")))["parameters"][0]
    need(
        found["verdict"] == "identified" and abs(found["value"] - told[0]) < 0.1 * told[1]
        and abs(found["sd"] - told[1]) < 0.2 * told[1], f"the page says {told} MPa, the program {found}")
    need(f"compressive_strength={told[0]:g} MPa" in text, "the cell's strength is not the calibrated one")
    rows = history(at("pile"))
    force = [-float(r["reaction_head_y_N"]) for r in rows]
    need(
        abs(float(rows[-1]["moved_head_y_m"]) + 6e-3) < 1e-9 and force[-1] > 1.3 * abs(force[0])
        and float(rows[-1]["breakages"]) > 0,
        f"the pile: {force[0]} N to {force[-1]} N, {rows[-1]['breakages']} breakages")
    need(os.path.getsize(at("report.html")) > 200000 and os.path.exists(at("sand", "report.html")), "no report")
print(f"tutorial: {len(faults)} faults")
sys.exit(1 if faults else 0)
