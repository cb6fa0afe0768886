#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the energy of bonds goes in whole runs, what devices take of it, and a run that is killed while it softens:
ledgers.py BIN"""
import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

import h5py

import scene_tools
from scene_tools import faults, history, need, run, shipped, summary

rve = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-rve")
TENSION = os.path.join(shipped, "rock_tension.toml")
SMALL = ("packing.cells=54", "output.frames=0", "numerics.safety=0.6")


def command(scene, out, *settings):
    return [rve, scene, "-o", out, "--quiet", "--threads", "1", *[a for s in settings for a in ("--set", s)]]


def test(tmp, name, scene, *settings):
    out = os.path.join(tmp, name)
    r = run(*command(scene, out, *settings))
    need(r.returncode == 0, f"{name}: exit {r.returncode} {r.stderr}")
    return [{k: float(v) for k, v in row.items()} for row in history(out)], summary(out)


def devices(tmp):
    """What local damping and dashpots took before the peak, by the rows of history.csv; a word where it is much."""
    # A stress wave at first, so that devices have something to take; both kinds, of different sizes.
    for name, speed, damping, dashpots, most in (("slow", 0.015, 0.1, 0.02, 0.05), ("fast", 3, 0.7, 0.3, 1)):
        time_of = f"loading.duration={15e-6 / speed}"
        rows, told = test(tmp, name, TENSION, *SMALL, f"clamp.1.velocity=[0, 0, {speed}]", time_of,
                          f"material.rock.damping={damping}", f"material.rock.bond.damping={dashpots}")
        peak = max(range(len(rows)), key=lambda k: rows[k]["nominal_stress_Pa"])
        at, errors = rows[peak], told["errors"]
        need(10 < peak < len(rows) - 10, f"{name}: the peak is row {peak}")
        bonds, grains = at["bond_damping_J"] / at["work_J"], (at["damping_J"] - at["bond_damping_J"]) / at["work_J"]
        kinetic = max(x["kinetic_J"] for x in rows[1:peak + 1]) / at["work_J"]
        need(
            min(bonds, grains, kinetic) > 0 and abs(bonds / grains - 1) > 0.05,
            f"{name}: nothing to tell apart: {bonds}, {grains}")
        for key, expected in (("local_damping_before_peak", grains), ("bond_damping_before_peak", bonds),
                              ("devices_before_peak", grains + bonds), ("kinetic_before_peak", kinetic),
                              ("bond_damping", rows[-1]["bond_damping_J"] / rows[-1]["work_J"])):
            need(abs(errors[key] / expected - 1) < 1e-6, f"{name}: {key} {errors[key]}, by the rows {expected}")
        noted = [n for n in told.get("notes", []) if "before the peak" in n]
        need((grains + bonds > 0.05) == (most == 1) and len(noted) == (most == 1),
             f"{name}: {grains + bonds} taken, notes {noted}")
    # A cell that is drawn has its peak where the tension is largest; what rings after it has torn is no peak.
    drawn = "loading={kind='velocity-gradient', velocity_gradient=[[0, 0, 0], [0, 0, 0], [0, 0, %s]], duration=1e-4}"
    brittle = "material.rock.bond={modulus=2e10, criterion='parallel', tension='6 MPa', shear='18 MPa', damping=0.02}"
    for name, scene, *settings in (("drawn", "rock_beam_cell.toml", drawn % 50),
                                   ("torn", "rock_cell.toml", drawn % 10, brittle, "packing.cells=64",
                                    "packing.box=[4e-3, 4e-3, 4e-3]", "numerics.safety=0.6")):
        rows, told = test(tmp, name, os.path.join(shipped, scene), *settings)
        at = min(rows, key=lambda x: x["axial_stress_Pa"])
        torn = at is not rows[-1] and rows[-1]["bonds_broken"] > 0 and max(x["axial_stress_Pa"] for x in rows) > 0
        need(torn == (name == "torn"), f"{name}: {at} of {rows[-1]}")
        taken = at["damping_J"] / max(abs(x["work_J"]) for x in rows[:rows.index(at) + 1])
        need(0 < taken and abs(told["errors"]["devices_before_peak"] / taken - 1) < 0.02,
             f"{name}: {told['errors']}, {taken} taken")
        need(told["errors"]["devices_before_peak"] < 0.05 or name == "drawn", f"{name}: {told['errors']}")
    # Dead loads have no peak: nothing is told of it.
    load = ["clamp=[{where='z=min'}]", "load=[{where='z=max', force=[0, 0, 400], ramp=2e-4}]", "loading.duration=3e-4"]
    rows, told = test(tmp, "load", TENSION, *SMALL, *load)
    need(rows[-1]["bonds_broken"] > 0 and "devices_before_peak" not in told["errors"], f"load: {told['errors']}")
    need(not [n for n in told.get("notes", []) if "before the peak" in n], f"load: {told['notes']}")
    # A run that is shorter than 20 steps knows no energy error, and says so.
    rows, told = test(tmp, "short", TENSION, *SMALL, "numerics.time_step=1e-9", "loading.duration=1e-8",
                      "output.history_interval=1e-8")
    need([n for n in told["notes"] if "shorter than 20 steps" in n], f"short: {told.get('notes')}")


def kinds(tmp):
    """Of each kind of bond: what it has taken never falls, the ledger closes, and what broke has taken what is known
    otherwise."""
    bond = "material.rock.bond={{modulus='20 GPa', poissons_ratio=0.2, {0}}}"
    slow = (*SMALL, "numerics.safety=0.2", "loading.duration=3.5e-4")
    whole = ("material.rock.bond.tension=1e12", "material.rock.bond.cohesion=1e12",
             "material.rock.bond.fracture_energy=1e20")
    runs = {
        "cohesive": test(tmp, "cohesive", TENSION, *SMALL),
        "parallel": test(tmp, "parallel", TENSION, *slow,
                         bond.format("criterion='parallel', tension='6 MPa', shear='18 MPa'")),
        "strain-sum": test(tmp, "strain", TENSION, *slow, bond.format("criterion='strain-sum', strain=3e-4")),
        # A single crystal between two clamps, cut across: its halves are held by the fresh faces.
        "cleavage": test(
            tmp, "cleavage", TENSION, *slow, "numerics.safety=0.1", "packing.cells=1", "packing.box=[6e-3, 6e-3, 1e-3]",
            "loading.duration=4e-5", "output.bursts=", *whole,
            "material.rock.fracture={model='cleavage', toughness='0.1 MPa m^0.5', flaw='0.1 mm', planes=[[0, 0, 1]], "
            "crystal={axis=[0, 0, 1], angles=['0 deg']}, max_generations=1}"),
        "springs": test(tmp, "springs", os.path.join(shipped, "single_grain.toml"), "output.frames=0",
                        "loading.final_strain=0.1"),
    }
    for name, (rows, told) in runs.items():
        taken = [x["fracture_J"] for x in rows]
        need(taken[-1] > 0 and all(b >= a for a, b in zip(taken, taken[1:])),
             f"{name}: what fracture has taken falls: {taken[-1]}")
        need(rows[-1]["bonds_broken"] > 0, f"{name}: nothing has broken")
        worst = max(abs(x["energy_error"]) for x in rows)
        need(worst < 0.01, f"{name}: energy error {worst}")
    for name in ("parallel",
                 "strain-sum"):  # brittle: half of the work until then was held, and most of it is taken as they part
        rows = runs[name][0]
        need(rows[-1]["fracture_J"] > 0.3 * rows[-1]["work_J"],
             f"{name}: {rows[-1]['fracture_J']} J of {rows[-1]['work_J']}")
    rows, told = runs["cohesive"]  # nearly all of the work: what has parted, and some damage beside it
    area = told["energy"]["fracture_area_m2"]
    need(rows[-1]["fracture_J"] > 15 * area > 15 * 30e-6, f"cohesive: {rows[-1]['fracture_J']} J, G A {15 * area}")
    need(
        abs(runs["cleavage"][0][-1]["fracture_J"] / (0.1e6**2 * (1 - 0.2**2) / 20e9 * 36e-6) - 1) < 1e-6,
        f"cleavage: {runs['cleavage'][0][-1]['fracture_J']} J")
    energy = runs["springs"][1]["energy"]
    grain = (1.77e6)**2 * (1 - 0.17**2) / 60e9 * energy["fracture_area_m2"]
    need(
        abs((energy["fracture_J"] + energy["fracture_left_in_springs_J"]) / grain - 1) < 1e-6,
        f"springs: {energy}, G A {grain}")


def rows_kept(folder):
    """How many rows the checkpoint of a run has; 0 while there is none."""
    with contextlib.suppress(OSError), h5py.File(os.path.join(folder, "checkpoint.h5")) as f:
        return json.loads(f["about"][:].tobytes())["rows"]
    return 0


def killed(tmp):
    """Killed while it softens and gone on with: the same bits as a run that nobody disturbed, errors and bursts too."""
    settings = ("packing.cells=128", "output.frames=0", "numerics.safety=0.3", "output.checkpoint_interval=0.02",
                "clamp.1.velocity=[0, 0, 0.06]", "loading.duration=2.5e-4")
    rows, exact = test(tmp, "whole", TENSION, *settings)
    soft = [k for k, x in enumerate(rows) if x["bonds_damaged"] > 0 and x["bonds_broken"] < rows[-1]["bonds_broken"]]
    need(len(soft) > 50, f"killed: softens in {len(soft)} rows")
    if not soft:
        return
    # By the row of its checkpoint and not by a clock. It goes on to where the next one is written, so more than once.
    for part in (0.2, 0, 0.4):
        out = os.path.join(tmp, f"killed{part}")
        with subprocess.Popen(command(TENSION, out, *settings), stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as p:
            while p.poll() is None and rows_kept(out) <= soft[0] + part * len(soft):
                time.sleep(0.002)
            p.send_signal(signal.SIGKILL)
        if p.returncode != -signal.SIGKILL:
            continue
        r = run(*[a for a in command(TENSION, out, *settings) if a != "--quiet"], "--resume")
        need(r.returncode == 0, f"killed: resumed, exit {r.returncode} {r.stderr}")
        on = re.search(r"going on from t = (\S+) s", r.stdout)
        if on and rows[soft[0]]["time_s"] < float(on[1]) < rows[soft[-1]]["time_s"]:
            break
    else:
        need(False, "killed: never in the middle of softening")
        return
    for name in ("history.csv", "bursts.csv"):
        with open(os.path.join(tmp, "whole", name), "rb") as a, open(os.path.join(out, name), "rb") as b:
            need(a.read() == b.read(), f"killed: {name} differs")
    again = summary(out)
    for key in ("errors", "energy", "results", "counts", "bursts", "cells"):
        need(again[key] == exact[key], f"killed: {key} {again[key]} instead of {exact[key]}")


HALVES = """[material.sand]
density = 2650
youngs_modulus = "60 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "100 MPa", m = 20.56 }
smallest_radius = "0.1 mm"
[packing]
kind = "random"
box = ["1.7 mm", "1.7 mm", "1.7 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.5
[boundary]
kind = "periodic"
[preparation]
pressure = "100 kPa"
friction = 0.2
[loading]
kind = "uniaxial-strain"
strain_rate = "20 1/s"
final_strain = 0.07
[numerics]
inertia = { step = "400 ns" }
"""


def halves(tmp):
    scene = os.path.join(tmp, "halves.toml")
    with open(scene, "w") as f:
        f.write(HALVES)
    return scene


def thrown(tmp):
    """Fragments that fly off into others in steps many times as long as their own: what gets mass gets no energy."""
    scene = halves(tmp)
    broken = 0
    for seed in (1, 2, 3):
        rows, told = test(tmp, f"halves{seed}", scene, f"seed={seed}")
        broken += rows[-1]["breakages"]
        energy = max(abs(x["energy_error"]) for x in rows)
        need(energy < 0.02, f"halves of seed {seed}: energy error {energy}")
        need(max(x["inertia_J"] for x in rows) < 1e-3 * rows[-1]["work_J"], f"halves of seed {seed}: given energy")
        need(told["inertia"]["added_mass"]["worst"] > 1 and [n for n in told["notes"] if "of the solids (worst" in n],
             f"halves of seed {seed}: {told['inertia']}, {told['notes']}")
    need(broken > 20, f"halves: {broken} broke")


def stopped(tmp):
    """Stopped between two rows: energies and stress are of that moment, not some of it and some of the last row. Of a
    run that failed all are of its last row."""
    scene = halves(tmp)
    out = os.path.join(tmp, "stopped")
    with subprocess.Popen(command(scene, out, "loading.final_strain=0.3", "output.history_interval=0.3",
                                  "output.checkpoint_interval=0.1"), stderr=subprocess.DEVNULL) as p:
        while p.poll() is None and not os.path.exists(os.path.join(out, "checkpoint.h5")):
            time.sleep(0.01)
        p.send_signal(signal.SIGINT)
    told, rows = summary(out), list(history(out))
    need(p.returncode == 130 and len(rows) == 1, f"stopped: exit {p.returncode}, {len(rows)} rows")
    energy, results = told["energy"], told["results"]
    need(energy["work_J"] > 2 * energy["start_J"] and abs(energy["energy_error"]) < 0.02, f"stopped: {energy}")
    need(results["peak_axial_stress_Pa"] >= results["final_axial_stress_Pa"] > 2 * float(rows[0]["axial_stress_Pa"]),
         f"stopped: {results}")
    out = os.path.join(tmp, "failed")
    r = run(*command(scene, out, "numerics.max_overlap=0.01"))
    last, told = list(history(out))[-1], summary(out)
    need(r.returncode == 3 and float(last["work_J"]) > 0, f"failed: exit {r.returncode} {r.stderr}, {last}")
    for name in ("work_J", "kinetic_J", "elastic_J", "friction_J", "damping_J", "energy_error"):
        need(abs(told["energy"][name] - float(last[name])) <= 1e-8 * abs(float(last[name])),
             f"failed: {name} {told['energy'][name]}, {last[name]} in the last row")


with tempfile.TemporaryDirectory() as folder:
    for check in (devices, kinds, killed, thrown, stopped):
        check(folder)
print("ledgers:", len(faults), "faults")
sys.exit(bool(faults))
