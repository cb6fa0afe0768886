#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What runs of grus-rve and grus-bvp print is what they write: said.py BIN

The lines of a run against its history.csv and summary.json: the set-up once, how far it is, how it ended, the notes; of
a run that goes on where it goes on from; its log. Seconds alone are not compared.
"""
import json
import os
import re
import sys
import tempfile

import scene_tools
from scene_tools import BRITTLE, ROCK, faults, history, need, run, shipped, write

binaries = os.path.abspath(sys.argv[1])
rve, bvp = (scene_tools.program(binaries, name) for name in ("grus-rve", "grus-bvp"))
SECONDS = r"(?:\d+\.\d s|\d+ min \d\d s|\d+ h \d\d min)"
TIMED = r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d  "
BLOCK = """
title = "Block"
[mesh]
box = { size = [1, 1, 2], cells = [1, 1, 2] }
[[region]]
where = "z>0"
material = "elastic"
youngs_modulus = 1e9
poissons_ratio = 0.2
density = 2000
[[boundary]]
name = "foot"
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
name = "head"
where = "z=max"
displacement = [0, 0, -0.002]
"""


def results(out):
    with open(os.path.join(out, "summary.json")) as f:
        return json.load(f), history(out)


def ended(said, wanted, what):
    """The last line but for notes, of which the seconds may be any."""
    line = [x for x in said.splitlines() if not x.startswith("  note: ")][-1]
    form = re.escape(wanted).replace("SECONDS", SECONDS)
    need(re.fullmatch(form, line), f"{what}: it ends with {line!r}, not with {wanted!r}")


def rve_line(name, summary, rows, peak="", broken=None):
    counts, mass = summary["counts"], summary["mass"]
    broken = broken or f"{counts['breakages']} grains"
    return (f"{name}: t {summary['results']['final_time_s']:.5g} s{peak}, {counts['grains_start']} -> "
            f"{counts['grains']} grains, {broken} broken, mass lost {100 * mass['lost_kg'] / mass['start_kg']:.2f} %, "
            f"worst energy error {100 * summary['errors']['worst_energy_error']:.2f} %, {counts['steps']} steps in "
            "SECONDS ")


def crushed(tmp):
    """A grain that breaks: every line of its rows, the peak, what it has lost; the same in its log."""
    scene = os.path.join(shipped, "single_grain.toml")
    out, log = os.path.join(tmp, "grain"), os.path.join(tmp, "log.txt")
    r = run(rve, scene, "-o", out, "--threads", "1", "--log", log, "--set", "loading.final_strain=0.1", "--set",
            "output.frames=0")
    summary, rows = results(out)
    found = summary["results"]
    need(r.returncode == 0 and found["peak_before_breakage_Pa"] > 0, f"a grain: exit {r.returncode} {r.stderr}")
    lines = r.stdout.splitlines()
    need(lines[0] == "Single-grain crushing between platens" and r.stdout.count("mean diameter 0.0006 m") == 1,
         f"its set-up: {lines[:3]}")
    form = (TIMED + r" *(\d+) %  t (\S+) s  strain (\S+)  stress (\S+) MPa  grains (\d+)  broken (\d+) grains"
            r"(?:, \d+ bonds)?  energy error (\S+) %  \S+ steps/s  ETA (?:\?|" + SECONDS + ")")
    told = [re.fullmatch(form, x) for x in lines]
    told = [[float(v) for v in x.groups()] for x in told if x]
    need(len(told) >= 18 and told[-1][4] > 1, f"a line each twentieth: {len(told)} of {len(lines)}")
    column = {k: [float(x[k]) for x in rows] for k in rows[0]}
    for part, time, strain, stress, grains, broken, error in told:  # stress and error are those of the last row
        row = max(k for k, at in enumerate(column["time_s"]) if at <= time * 1.0005)
        near = [abs(column["axial_stress_Pa"][k] / 1e6 - stress) <= 6e-3 * abs(stress) and
                abs(100 * column["energy_error"][k] - error) < 0.0051 for k in (max(row - 1, 0), row)]
        need(any(near) and abs(strain - 100 * time) < 2e-4 and abs(part - 1000 * strain) < 1 and
             column["grains"][row] <= grains <= column["grains"][min(row + 1, len(rows) - 1)] and
             column["breakages"][row] <= broken <= column["breakages"][min(row + 1, len(rows) - 1)],
             f"at {time} s: {part} % {strain} {stress} MPa {grains} {broken} {error} %: row {row}")
    peak = (f", peak stress {found['peak_axial_stress_Pa'] / 1e6:.4g} MPa "
            f"({found['peak_before_breakage_Pa'] / 1e6:.4g} before the first breakage)")
    counts = summary["counts"]
    both = f"{counts['breakages']} grains and {counts['bonds_broken']} bonds"
    ended(r.stdout, rve_line("finished", summary, rows, peak, both) + f"({out})", "a grain")
    with open(log) as f:
        kept = f.read().splitlines()
    need(all(re.match(TIMED, x) for x in kept) and [re.sub(TIMED, "", x, count=1) for x in kept] ==
         [re.sub("^" + TIMED, "", x) for x in lines], f"its log: {kept[:4]} {kept[-2:]}")


def gone_on(tmp):
    """A run that goes on says from where, and not what it is like; a quiet one says nothing at all."""
    scene = write(tmp, 'title = "Fall"\n[material.g]\ndensity = 2500\nyoungs_modulus = 1e7\n[[grain]]\nradius = 0.005\n'
                  "position = [0, 0, 0.02]\n[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n[loading]\n"
                  "kind = \"free\"\n"
                  "duration = 0.02\ngravity = [0, 0, -9.81]\n[output]\nlast_state = true\n")
    out = os.path.join(tmp, "fall")
    r = run(rve, scene, "-o", out)
    summary, rows = results(out)
    ended(r.stdout, rve_line("finished", summary, rows) + f"({out})", "a fall")
    need("stress" not in r.stdout, f"a fall has no stress: {r.stdout}")
    r = run(rve, scene, "-o", out, "--resume", "--set", "loading.duration=0.04")
    summary, rows = results(out)
    need(r.stdout.startswith("Fall\n  going on from t = 0.02 s, 1 grains\n") and "mean diameter" not in r.stdout
         and r.returncode == 0, f"gone on: {r.stdout}")
    ended(r.stdout, rve_line("finished", summary, rows) + f"({out})", "gone on")
    need(float(rows[-1]["time_s"]) == 0.04 and len(rows) > 300, f"gone on to {rows[-1]['time_s']}")
    r = run(rve, scene, "-o", out, "--force", "--quiet")
    need((r.returncode, r.stdout, r.stderr) == (0, "", ""), f"--quiet: {r}")
    before = os.listdir(out)
    r = run(rve, scene, "-o", os.path.join(tmp, "none"), "--check")
    need(r.returncode == 0 and r.stdout.count("mean diameter 0.01 m") == 1 and "run time about" in r.stdout
         and not os.path.exists(os.path.join(tmp, "none")) and before == os.listdir(out), f"--check: {r.stdout}")
    cells = write(tmp, ROCK + BRITTLE + '[packing]\nkind = "voronoi"\nbox = [0.004, 0.004, 0.008]\ncells = 30\n'
                  '[loading]\nkind = "platens"\nspeed = 0.5\nfinal_strain = 0.02\n[output]\nframes = 0\n')
    out = os.path.join(tmp, "cells")
    r = run(rve, cells, "-o", out, "--threads", "1")
    summary, rows = results(out)
    need(summary["counts"]["bonds_broken"] > 0, f"cells that do not break: {r.stdout} {r.stderr}")
    peak = f", peak nominal stress {summary['results']['peak_stress_Pa'] / 1e6:.4g} MPa"
    ended(r.stdout, rve_line("finished", summary, rows, peak, f"{summary['counts']['bonds_broken']} bonds") +
          f"({out})", "cells")


def problems(tmp):
    """Macro problems, by each solver: set-up, end, what stands in the summary and what does not."""
    for name, solve, least in (
            ("still", 'kind = "quasi-static"\nincrements = 3', 3),
            ("fast", 'kind = "explicit-dynamic"\nduration = 0.01', 10),
            ("slow", 'kind = "explicit-quasi-static"', 10)):
        scene, out = write(tmp, BLOCK + f"[solve]\n{solve}\n[output]\nframes = 3\n"), os.path.join(tmp, name)
        checked = run(bvp, scene, "-o", out, "--check", "--threads", "1")
        need(checked.returncode == 0 and not os.path.exists(out), f"{name}: --check: {checked.stdout} {checked.stderr}")
        r = run(bvp, scene, "-o", out, "--threads", "1")
        summary, rows = results(out)
        need(r.returncode == 0 and len(rows) >= least, f"{name}: exit {r.returncode} {r.stderr}, {len(rows)} rows")
        need(r.stdout.startswith(checked.stdout) and r.stdout.count("Gauss points 16   with grains 0") == 1
             and "prepared" not in r.stdout, f"{name}: set-up {r.stdout[:300]}")
        last = {k: float(v) for k, v in rows[-1].items()}
        stress = f"mean stress zz {last['mean_stress_zz_Pa'] / 1e6:.4g} MPa, 0 breakages"
        counts = summary["counts"]
        line = {"still": f"finished: load factor 1, mean strain zz {last['mean_strain_zz']:.4f}, {stress}, "
                         f"{counts['newton_iterations']} Newton iterations, {counts['cutbacks']} cutbacks, "
                         f"{counts['material_sweeps']} material sweeps, 0 DEM steps in SECONDS ({out})",
                "fast": f"finished: 0.01 s, {stress}, 0 DEM steps in SECONDS ({out})",
                "slow": f"finished: 100 % of the load, {stress}, 0 DEM steps in SECONDS ({out})"}[name]
        ended(r.stdout, line, name)
        errors = summary["errors"]
        need("devices" not in errors and "rve_work_J" not in errors and "unit_cell" not in summary, f"{name}: {errors}")
        need(abs(errors["last_energy_error"] / last["energy_error"] - 1) < 1e-9
             and ("worst_residual" in errors) == (name != "fast")
             and ("last_correction" in errors) == (name == "still") and "last_worst_unbalanced_force" not in errors,
             f"{name}: {errors}")
        if name == "still":
            worst = max(float(x["residual"]) for x in rows)
            iterations = sum(int(x["newton_iterations"]) for x in rows)
            need(abs(errors["worst_residual"] / worst - 1) < 1e-9 and counts["newton_iterations"] == iterations,
                 f"{errors} {counts}")
        need(summary["last_row"] == {k: float(v) for k, v in rows[-1].items()} or all(
            abs(summary["last_row"][k] - last[k]) <= 1e-9 * abs(last[k]) for k in last), f"{name}: last row")
        need(abs(errors["hill_mandel"]) < 0.01 and summary["ending"] == "finished" and summary["status"] == 0,
             f"{name}: {errors}")
        frames = sorted(os.listdir(os.path.join(out, "macro")))
        need(frames == [f"macro_{k:05}.hdf" for k in range(3)], f"{name}: frames {frames}")
    torn = write(tmp, BLOCK.replace("-0.002", "-6") + '[solve]\nkind = "quasi-static"\nmax_cutbacks = 0\n')
    r = run(bvp, torn, "-o", os.path.join(tmp, "torn"))
    at = re.match(re.escape(f"{torn}: load factor ") + r"(\S+): ", r.stderr)
    need(r.returncode == 3 and at and r.stderr.count("\n") == 1 and f"\nstopped: load factor {at[1]}, " in r.stdout and
         r.stderr.endswith("; more solve.increments, tighter rve.unbalanced_force or a larger unit cell may help, "
                           "or explicit-quasi-static\n"),
         f"{r}")


with tempfile.TemporaryDirectory() as folder:
    for check in (crushed, gone_on, problems):
        check(folder)
print(f"said: {len(faults)} faults")
sys.exit(bool(faults))
