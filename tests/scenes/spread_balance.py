#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A macro problem that is spread is cut anew while it runs, where ranks wait for one: it is balanced then, and tells
the same bytes as without: spread_balance.py BIN [whole]."""
import collections
import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from spread_tools import BLOCK, command, same, whole

from scene_tools import faults, need, run, summary, write

# A column that is held in its middle: its upper half is pressed at first, its lower half then. What the grains are told
# is averaged over less than an element, so that one half does little in a step while the other is pressed. Starts
# differ by depth: ranks get points whose start they have not had.
MOVES = '[[boundary]]\nname = "{}"\nwhere = "{}"\ndisplacement = [0, 0, "{} mm"]\nhistory = {}\n'
PRESSED = """gravity = [0, 0, -9.81]
initial_stress = { k0 = 1, surcharge = "100 kPa", tolerance = 0.002 }
""" + (BLOCK[:BLOCK.index("[[boundary]]")] + MOVES.format("bottom", "z=min", 0.1, "[[0, 0], [0.5, 0], [1, 1]]") +
       MOVES.format("middle", "z>0.049 and z<0.051", 0, "[[0, 0], [1, 1]]") +
       MOVES.format("top", "z=max", -0.1, "[[0, 0], [0.5, 1], [1, 1]]") +
       BLOCK[BLOCK.index('[[boundary]]\nname = "left"'):]).replace("cells = [2, 2, 3]", "cells = [1, 1, 16]").replace(
           "variants = 2", "variants = 1").replace('length = "20 mm"', 'length = "4 mm"').replace(
               "crossings = 8", "crossings = 30").replace("strain_per_step = 1e-5", "strain_per_step = 2e-7").replace(
                   'where = "z<0.02"', 'where = "z>0.097"')
TIGHT = "rve.set=['packing.box=[0.027, 0.027, 0.027]', 'numerics.max_overlap=0.025']"
EVEN = (("even", 2, "mesh.box.cells=[2,2,4]", "region=", "boundary.1.displacement=[0,0,-1e-4]", "solve.crossings=20"),
        ("whole elements", 3, "mesh.box.cells=[1,1,4]", "region=", "boundary.1.displacement=[0,0,-1e-4]",
         "solve.crossings=40"))
LOOK = 50   # steps
BESIDE = 5  # DEM steps that the rest of an answer counts as


def work(out, ranks):
    """Work of each rank from look to look, whole ones only: DEM steps, and what an answer takes beside them."""
    of = collections.defaultdict(lambda: [0] * ranks)
    with open(os.path.join(out, "costs.csv")) as file:
        for c in csv.DictReader(file):
            of[int(c["sweep"]) // LOOK][int(c["rank"])] += int(c["steps"]) + BESIDE
    return [of[k] for k in sorted(of)][:-1]


def fullness(loads):
    return max(loads) * len(loads) / sum(loads)


def cuts_of(log):
    return [line for line in open(log).read().split("\n") if "cut anew" in line] if os.path.exists(log) else []


def uneven(tmp, scene):
    """On some ranks: the same bytes as on one, and never for more than 300 steps has one of them more than 1.15 times
    the mean to do."""
    one = os.path.join(tmp, "pressed_1")
    r = run(*command(1, scene, one))
    need(r.returncode == 0 and "mesh_cuts" not in summary(one)["counts"],
         f"pressed, 1 rank: exit {r.returncode} {r.stderr[-300:]}")
    for ranks in (2, 3) if whole else (2,):
        out, log = os.path.join(tmp, f"pressed_{ranks}"), os.path.join(tmp, f"pressed_{ranks}.log")
        r = run(*command(ranks, scene, out, more=["--log", log]))
        need(r.returncode == 0, f"pressed, {ranks} ranks: exit {r.returncode} {r.stderr[-300:]}")
        same(f"pressed, {ranks} ranks", one, out)
        told, loads = summary(out), work(out, ranks)
        for name in ("dem_steps", "rves_advanced", "rves", "material_sweeps"):
            need(told["counts"][name] == summary(one)["counts"][name], f"pressed, {ranks} ranks: another {name}")
        need(told["errors"]["regularisation"] == summary(one)["errors"]["regularisation"],
             f"pressed, {ranks} ranks: another average")
        full = [fullness(each) for each in loads]
        longest = max(len(looks) for looks in "".join("x" if f > 1.15 else " " for f in full).split(" "))
        need(max(full) > 1.4 and longest <= 300 // LOOK, f"pressed, {ranks} ranks: fullest {full} times the mean")
        need(1 < told["counts"]["mesh_cuts"] == len(cuts_of(log)) <= 6, f"pressed, {ranks} ranks: {cuts_of(log)}")
        all_in_all = sum(map(max, loads)) / sum(sum(each) / ranks for each in loads)
        need(abs(told["imbalance"] / all_in_all - 1) < 1e-12, f"imbalance {told['imbalance']}, of costs {all_in_all}")


def stopped(tmp, scene):
    """Asked to stop right after the last cut; gone on with on the same number of ranks and on others."""
    cuts = len(cuts_of(os.path.join(tmp, "pressed_2.log")))
    out, log = os.path.join(tmp, "stopped"), os.path.join(tmp, "stopped.log")
    p = subprocess.Popen(command(2, scene, out, more=["--log", log]), stdout=subprocess.DEVNULL,
                         stderr=subprocess.DEVNULL)
    while p.poll() is None and len(cuts_of(log)) < cuts:
        time.sleep(0.002)
    for rank in run("pgrep", "-P", str(p.pid)).stdout.split()[:1]:
        os.kill(int(rank), signal.SIGTERM)
    need(p.wait(60) == 130 and len(cuts_of(log)) == cuts, f"stopped after a cut: exit {p.returncode}, {cuts_of(log)}")
    for ranks in (2, 3) if whole else (2,):
        again = os.path.join(tmp, f"stopped_{ranks}")
        shutil.copytree(out, again)
        r = run(*command(ranks, scene, again, more=["--resume"]))
        need(r.returncode == 0, f"stopped after a cut, gone on with on {ranks}: exit {r.returncode} {r.stderr[-300:]}")
        same(f"stopped after a cut, gone on with on {ranks}", os.path.join(tmp, "pressed_1"), again)
        first = fullness(work(again, ranks)[0])
        need(first < 1.25 or ranks == 3, f"stopped after a cut, gone on with on {ranks}: fullest {first} of the mean")


def gives_up(tmp, scene):
    """An RVE that has changed its rank and then cannot go on: called by its number over the mesh, as on one rank. On
    four it is the second's: those of the first have the same numbers there."""
    said = []
    for ranks in (1, 4):
        out, log = os.path.join(tmp, f"tight_{ranks}"), os.path.join(tmp, f"tight_{ranks}.log")
        r = run(*command(ranks, scene, out, TIGHT, more=["--log", log]), timeout=120)
        said.append([line for line in r.stderr.split("\n") if line.startswith(scene)])
        need(r.returncode == 3 and bool(cuts_of(log)) == (ranks == 4),
             f"gives up on {ranks} ranks: exit {r.returncode}, {cuts_of(log)}, {r.stderr[-300:]!r}")
    need(len(said[0]) == 1 and said[0] == said[1] and "RVE of point" in said[0][0], f"gives up: {said}")


def even(tmp):
    """Ranks that have much the same to do, and those that whole elements keep apart: noise makes no cut."""
    scene = write(tmp, BLOCK, "even.toml")
    for name, ranks, *settings in EVEN if whole else EVEN[:1]:
        out = os.path.join(tmp, f"even_{ranks}")
        r = run(*command(ranks, scene, out, *settings))
        need(r.returncode == 0, f"{name}: exit {r.returncode} {r.stderr[-300:]}")
        full = [fullness(each) for each in work(out, ranks)]
        cuts = summary(out)["counts"]["mesh_cuts"]
        need(len(full) > 1 and cuts == 0, f"{name}: {cuts} cuts, {full}")


with tempfile.TemporaryDirectory() as tmp:
    pressed = write(tmp, PRESSED, "pressed.toml")
    uneven(tmp, pressed)
    stopped(tmp, pressed)
    gives_up(tmp, pressed)
    even(tmp)
sys.exit(1 if faults else 0)
