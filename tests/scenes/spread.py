#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A macro problem that is spread over ranks (solve.spread): the same bytes on any number of them, killed and resumed on
another number, and failures of one rank that end all: spread.py BIN [whole]. Without it no more runs than it takes."""
import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from spread_failures import failures, no_memory, silent
from spread_tools import BLOCK, command, same, whole

from scene_tools import faults, history, need, run, summary, write


def any_ranks(tmp, scene):
    """1, 3 and 7 ranks, the last of which have next to nothing; and rank 0 alone, but for what grains make of it."""
    for ranks in (1, 2, 3, 7) if whole else (1, 3):
        out = os.path.join(tmp, f"on_{ranks}")
        r = run(*command(ranks, scene, out))
        need(r.returncode == 0, f"{ranks} ranks: exit {r.returncode} {r.stderr[-300:]}")
        need(summary(out)["ranks"] == ranks, f"{ranks} ranks: {summary(out)['ranks']} told")
        costs(out, ranks)
        if ranks > 1:
            same(f"{ranks} ranks", os.path.join(tmp, "on_1"), out)
            kept = [summary(os.path.join(tmp, k))["errors"]["regularisation"] for k in ("on_1", f"on_{ranks}")]
            need(kept[0] == kept[1] and 0 < kept[0]["worst"] < kept[0]["promised"], f"the average: {kept}")
    rows, last = history(os.path.join(tmp, "on_1")), {}
    need(int(rows[-1]["rves"]) == int(rows[-1]["rves_distinct"]) < 96, f"points: {rows[-1]['rves']}")
    r = run(*command(1, scene, os.path.join(tmp, "farm"), "solve.spread=false"))
    need(r.returncode == 0, f"farm: {r.stderr[-300:]}")
    for name, within in (("reaction_top_z_N", 0.02), ("volume_m3", 1e-4), ("macro_external_J", 0.02),
                         ("regularisation_J", 0.1)):
        last = [float(r[-1][name]) for r in (rows, history(os.path.join(tmp, "farm")))]
        need(abs(last[0] / last[1] - 1) < within, f"{name}: {last[0]} spread, {last[1]} on rank 0")


def costs(out, ranks):
    """Each point in each sweep once, by its number over the mesh, on the rank that owns it."""
    with open(os.path.join(out, "costs.csv")) as file:
        rows = list(csv.DictReader(file))
    counts = summary(out)["counts"]
    need(len(rows) == counts["rves_advanced"] and sum(int(c["steps"]) for c in rows) == counts["dem_steps"],
         f"costs.csv on {ranks}: {len(rows)} rows, {counts}")
    need(len({(c["sweep"], c["slot"]) for c in rows}) == len(rows), f"costs.csv on {ranks}: a point twice in a sweep")
    owners = {(c["slot"], c["rank"]) for c in rows}
    one_owner = counts.get("mesh_cuts", 0) > 0 or len(owners) == counts["rves"]
    need(one_owner and len({rank for _, rank in owners}) == ranks,
         f"costs.csv on {ranks}: {len(owners)} owners of {counts['rves']} points")


def more_ranks_than_elements(tmp, scene):
    cells, most = ("[1,1,2]", 4) if whole else ("[1,1,1]", 2)
    for ranks in (1, most):
        out = os.path.join(tmp, f"few_{ranks}")
        r = run(*command(ranks, scene, out, f"mesh.box.cells={cells}", "region=", "boundary.1.displacement=[0,0,-1e-4]",
                         "output.costs=false", "solve.crossings=5"))
        need(r.returncode == 0, f"elements {cells} on {ranks} ranks: exit {r.returncode} {r.stderr[-300:]}")
    same(f"elements {cells} on {most} ranks", os.path.join(tmp, "few_1"), os.path.join(tmp, f"few_{most}"))
    if not whole:
        return
    for ranks in (1, 4):  # two elements with grains, two without
        out = os.path.join(tmp, f"solid_{ranks}")
        r = run(*command(ranks, scene, out, "mesh.box.cells=[1,1,4]", "region.0.where=z<0.051", "solve.crossings=5",
                         "boundary.1.displacement=[0,0,-1e-4]", "probe.0.at=[0.025,0.025,0.06]"))
        need(r.returncode == 0, f"ranks without grains: exit {r.returncode} {r.stderr[-300:]}")
    with open(os.path.join(tmp, "solid_4", "costs.csv")) as file:
        need(len({c["rank"] for c in csv.DictReader(file)}) < 4, "all ranks have grains")
    same("ranks without grains", os.path.join(tmp, "solid_1"), os.path.join(tmp, "solid_4"))


def resumed(tmp, scene):
    """A rank is killed while a checkpoint is written: the job ends, and goes on with another number of ranks. Signals:
    130, and the same."""
    part = os.path.join(tmp, "part")
    often = ("output.checkpoint_interval=0.05", "output.costs=false")
    p = subprocess.Popen(command(3, scene, part, *often), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                         start_new_session=True)
    index = os.path.join(part, "checkpoint.h5")
    rows = os.path.join(part, "history.csv")
    while p.poll() is None and not (os.path.exists(index) and os.path.exists(rows) and history(part)):
        time.sleep(0.05)
    ranks = [int(n) for n in run("pgrep", "-P", str(p.pid)).stdout.split()]
    while p.poll() is None and len({name[0] for name in os.listdir(os.path.join(part, "checkpoint"))}) < 2:
        time.sleep(0.0005)  # shards of the next one are there, beside those that the index names
    if need(p.poll() is None and len(ranks) == 3, f"killed at {p.poll()}, ranks {ranks}"):
        os.kill(ranks[-1], signal.SIGKILL)
    begin = time.time()
    need(p.wait(60) != 0 and time.time() - begin < 30, f"a killed rank: exit {p.returncode}")
    while run("pgrep", "-s", str(p.pid)).stdout and time.time() - begin < 30:
        time.sleep(0.2)
    need(not run("pgrep", "-s", str(p.pid)).stdout, "ranks are left")
    for ranks in (1, 2, 4) if whole else (2,):
        out = os.path.join(tmp, f"again_{ranks}")
        shutil.copytree(part, out)
        r = run(*command(ranks, scene, out, *often, more=["--resume"]))
        need(r.returncode == 0, f"resumed on {ranks}: exit {r.returncode} {r.stderr[-300:]}")
        same(f"killed on 3, resumed on {ranks}", os.path.join(tmp, "on_1"), out)
        sets = {n[0] for n in os.listdir(os.path.join(out, "checkpoint"))}
        need(len(sets) == 1, f"shards of {sets}")
    damaged_shards(tmp, scene, part, often)
    if whole:
        asked_to_stop(tmp, scene, often)


def asked_to_stop(tmp, scene, often):
    """130, and gone on with on another number."""
    out = os.path.join(tmp, "asked")
    p = subprocess.Popen(command(2, scene, out, *often), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while p.poll() is None and not os.path.exists(os.path.join(out, "checkpoint.h5")):
        time.sleep(0.05)
    ranks = [int(n) for n in run("pgrep", "-P", str(p.pid)).stdout.split()]
    os.kill(ranks[-1], signal.SIGTERM)  # one of them is enough
    need(p.wait(60) == 130, f"asked to stop: exit {p.returncode}")
    r = run(*command(3, scene, out, *often, more=["--resume"]))
    need(r.returncode == 0, f"asked to stop, resumed: exit {r.returncode} {r.stderr[-300:]}")
    same("asked to stop on 2, resumed on 3", os.path.join(tmp, "on_1"), out)


def damaged_shards(tmp, scene, part, often):
    """Refused in one line, on any rank. Of the sets that are there the index names one: both are spoiled."""
    names = [n for n in os.listdir(os.path.join(part, "checkpoint")) if n.endswith("00002.h5")]
    need(0 < len(names) <= 2, f"shards of rank 2: {names}")
    wrong = (lambda data: data[:60000] + bytes([data[60000] ^ 1]) + data[60001:], lambda data: data[:len(data) // 2],
             None)
    for spoiled in wrong if whole else wrong[:1]:
        out = os.path.join(tmp, "spoiled")
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(part, out)
        for there in (os.path.join(out, "checkpoint", name) for name in names):
            if spoiled is None:
                os.remove(there)
            else:
                data = open(there, "rb").read()
                open(there, "wb").write(spoiled(data))
        for ranks in (1, 2) if whole else (2,):
            r = run(*command(ranks, scene, out, *often, more=["--resume"]))
            said = [line for line in r.stderr.split("\n") if "checkpoint" in line]
            need(r.returncode == 2 and len(said) == 1,
                 f"damaged shard on {ranks}: exit {r.returncode} {r.stderr[-300:]!r}")


def blow(tmp):
    """Explicit dynamics: the same bytes on 1 rank and on more; close to what rank 0 alone makes."""
    moved = BLOCK.replace('displacement = [0, 0, "-0.3 mm"]',
                          'displacement = [0, 0, "-0.4 mm"]\nhistory = [[0, 0], [4e-4, 1]]')
    head, _ = moved.split("[solve]")
    scene = write(tmp, head + """[solve]
kind = "explicit-dynamic"
spread = true
duration = 1e-3
linear_viscosity = 0.1
max_energy_error = 10
[output]
frames = 3
""", "blow.toml")
    most = 3 if whole else 2
    for ranks in (1, most):
        r = run(*command(ranks, scene, os.path.join(tmp, f"blow_{ranks}")))
        need(r.returncode == 0, f"a blow on {ranks} ranks: exit {r.returncode} {r.stderr[-300:]}")
    same(f"a blow on {most} ranks", os.path.join(tmp, "blow_1"), os.path.join(tmp, f"blow_{most}"))
    if not whole:
        return
    rows = history(os.path.join(tmp, "blow_1"))
    need(float(rows[-1]["macro_viscous_J"]) > 0, "a blow: bulk viscosity takes nothing")
    r = run(*command(1, scene, os.path.join(tmp, "blow_farm"), "solve.spread=false"))
    need(r.returncode == 0, f"a blow, farm: {r.stderr[-300:]}")
    for name in ("macro_external_J", "macro_viscous_J"):
        last = [float(x[-1][name]) for x in (rows, history(os.path.join(tmp, "blow_farm")))]
        need(abs(last[0] / last[1] - 1) < 0.02, f"a blow: {name}: {last[0]} spread, {last[1]} on rank 0")


def newton(tmp):
    """Newton on all ranks: what rank 0 alone finds, to Newton's tolerance; stopped and gone on with another number."""
    head, _ = BLOCK.replace('"-0.3 mm"', '"-0.1 mm"').split("[solve]")
    scene = write(tmp, head.replace("variants = 2", """variants = 2
unbalanced_force = 3e-4
stress_change = 3e-4
adaptivity = { error = 0.002 }""") + """[solve]
kind = "quasi-static"
spread = true
increments = 4
[output]
frames = 2
costs = true
""", "newton.toml")
    on_farm = os.path.join(tmp, "newton_farm")
    r = run(*command(1, scene, on_farm, "solve.spread=false"))
    need(r.returncode == 0, f"Newton on rank 0: exit {r.returncode} {r.stderr[-300:]}")
    for ranks, *settings in ((1,), (2,), (3,), (7,), (3, ITERATIVE)) if whole else ((3, ITERATIVE),):
        out = os.path.join(tmp, f"newton_{ranks}_{len(settings)}")
        r = run(*command(ranks, scene, out, *settings))
        need(r.returncode == 0, f"Newton on {ranks} ranks: exit {r.returncode} {r.stderr[-300:]}")
        costs(out, ranks)
        alike(f"Newton on {ranks} ranks, {settings}", on_farm, out)
        counts = summary(out)["counts"]
        need(bool(settings) == (counts.get("linear_iterations", 0) > 0), f"iterations of the linear solver: {counts}")
        need(counts.get("linear_solves_made_direct", 0) == 0 and any("not to the bit" in n
                                                                    for n in summary(out)["notes"]),
             f"Newton on {ranks} ranks: {counts}, {summary(out)['notes']}")
    out = os.path.join(tmp, "newton_part")
    p = subprocess.Popen(command(3, scene, out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while p.poll() is None and not (os.path.exists(os.path.join(out, "history.csv")) and history(out)):
        time.sleep(0.02)
    for rank in run("pgrep", "-P", str(p.pid)).stdout.split()[-1:]:
        os.kill(int(rank), signal.SIGTERM)  # one of them is enough
    need(p.wait(60) == 130, f"Newton, asked to stop: exit {p.returncode}")
    r = run(*command(2, scene, out, more=["--resume"]))
    need(r.returncode == 0, f"Newton, gone on: exit {r.returncode} {r.stderr[-300:]}")
    alike("Newton, stopped on 3, gone on with 2", on_farm, out)


ITERATIVE = "solve.linear_solver=iterative"


def alike(name, one, other):
    """Rows of two runs of Newton. Both stop at the same iteration, unless a residual lies at its limit to 1e-8: then
    what linear solvers leave, 1e-9, is all, and what grains make of it in four increments."""
    a, b = history(one), history(other)
    need([r["time_s"] for r in a] == [r["time_s"] for r in b], f"{name}: other increments")
    for column in ("reaction_top_z_N", "volume_m3", "macro_external_J", "macro_internal_J", "macro_work_J",
                   "rve_noise"):
        off = max(abs(float(x[column]) - float(y[column])) for x, y in zip(a, b))
        need(off <= 1e-5 * max(abs(float(x[column])) for x in a), f"{name}: {column} off by {off}")
    kept = [(s["counts"]["rves_deferred"], s["errors"]["deferral"]["measured"]) for s in map(summary, (one, other))]
    need(kept[0] == kept[1] and min(kept[0]) > 0, f"{name}: put off, measured {kept}")


with tempfile.TemporaryDirectory() as tmp:
    block = write(tmp, BLOCK)
    any_ranks(tmp, block)
    more_ranks_than_elements(tmp, block)
    resumed(tmp, block)
    blow(tmp)
    newton(tmp)
    failures(tmp, block)
    no_memory(tmp, block)
    silent(tmp, block)
sys.exit(1 if faults else 0)
