#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests of several stages, as grus-rve runs them, against closed forms, balances and themselves: stages.py BIN"""
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from stage_tools import BOX, CELL, LATTICE, RADIUS, go, lattice_stress, numbers, of_stage, rve, stage

from scene_tools import faults, need, summary


def lattice(tmp):
    """Loaded, unloaded, reloaded and cycled, columns of spheres follow Hertz's law; every end is met where it is asked;
    what the boundary has done is what the stresses say."""
    slow = {"strain_rate": 0.5}
    text = LATTICE + stage("compress", name="load", until={"stress": 1e6}, **slow)
    text += stage("unload", until={"stress": 0.4e6}, **slow) + stage("reload", **slow)
    text += stage("cyclic", stress_amplitude=0.2e6, cycles=3, lateral="fixed", rows=8, **slow)
    text += stage("cyclic", strain_amplitude=1e-4, cycles=2, lateral="fixed", rows=4, **slow)
    text += stage("relax", until={"time": 2e-5}, rows=2) + stage("compress", until={"strain": 1e-3}, rows=4, **slow)
    ramp = 1e8  # Pa/s
    text += stage("compress", stress_rate=ramp, until={"stress": 9e6, "strain": 5e-4}, strain_rate=5, rows=10)
    folder, _ = go(tmp, "lattice", text)
    rows, told = numbers(folder), summary(folder)["stages"]
    ends = ["stress", "stress", "stress", "cycles", "cycles", "time", "strain", "strain"]
    need([s["ended_by"] for s in told] == ends, f"ended by {told}")
    need([s["name"] for s in told][:3] == ["load", "unload", "reload"], "names of stages")
    for k, s in enumerate(told):
        own, before = of_stage(rows, k + 1), [r for r in rows if r["stage"] < k + 1] or rows[:1]
        need(len(own) - (k == 0) == s["rows"] and abs(s["ended_s"] - own[-1]["time_s"]) < 1e-9 * s["ended_s"]
             and abs(s["began_s"] - before[-1]["time_s"]) < 1e-9 * s["ended_s"] and
             abs(s["strain"] - own[-1]["axial_strain"] + before[-1]["axial_strain"]) < 1e-9
             and abs(s["work_J"] - own[-1]["work_J"]) < 1e-9 * s["work_J"] and
             abs(s["axial_stress_Pa"] / own[-1]["axial_stress_Pa"] - 1) < 1e-8, f"summary of stage {k + 1}: {s}")
    need([r["stage"] for r in rows] == sorted(r["stage"] for r in rows), "rows out of order")
    # Waves: in sixteen spheres of 10 GPa at 0.5/s a few parts in ten thousand of 1 MPa.
    for r in rows[1:]:
        need(abs(r["axial_stress_Pa"] - lattice_stress(r["axial_strain"])) < 1e-3 * 1e6,
             f"stage {r['stage']}: {r['axial_stress_Pa']} Pa at {r['axial_strain']}")
    # The unloading modulus: the secant between two rows is Hertz's between their strains.
    down = of_stage(rows, 2)
    a, b = down[2], down[-3]
    strain = a["axial_strain"], b["axial_strain"]
    secant = (a["axial_stress_Pa"] - b["axial_stress_Pa"]) / (strain[0] - strain[1])
    exact = (lattice_stress(strain[0]) - lattice_stress(strain[1])) / (strain[0] - strain[1])
    need(abs(secant / exact - 1) < 2e-3, f"unloading modulus {secant}, Hertz has {exact}")
    need(len(down) == 25, f"{len(down)} rows of an unloading")
    # Stresses that end a stage are met within a step.
    for number, asked in ((1, 1e6), (2, 0.4e6), (3, 1e6)):
        last = of_stage(rows, number)[-1]["axial_stress_Pa"]
        need(abs(last / asked - 1) < 1e-3, f"stage {number} ends at {last} Pa, asked {asked}")
    # Three cycles of 0.2 MPa: six turns, within a step of the amplitude, and back to where they began.
    middle, swing = of_stage(rows, 3)[-1]["axial_stress_Pa"], of_stage(rows, 4)
    turns = [r["axial_stress_Pa"] for r, after in zip(swing, swing[1:]) if r["cycle"] != after["cycle"]]
    need(len(turns) == 6, f"{len(turns)} turns of three cycles")
    for k, turn in enumerate(turns):
        need(abs(turn - middle - (0.2e6 if k % 2 == 0 else -0.2e6)) < 2e2, f"turn {k} at {turn}")
    need(abs(swing[-1]["axial_stress_Pa"] - middle) < 2e2 and swing[-1]["cycle"] == 3, f"the last cycle: {swing[-1]}")
    need(len(swing) == 7 * 8, f"{len(swing)} rows of seven halves of cycles")
    # Two cycles of strain turn where they are asked, but for round-off.
    swing = of_stage(rows, 5)
    begin = of_stage(rows, 4)[-1]["axial_strain"]
    far = [r["axial_strain"] - begin for r in swing]
    need(abs(max(far) - 1e-4) < 1e-12 and abs(min(far) + 1e-4) < 1e-12 and abs(far[-1]) < 1e-12,
         f"strains of cycles: {min(far)} to {max(far)}, {far[-1]}")
    need(len(swing) == 5 * 4, f"{len(swing)} rows of five halves of cycles")
    need(abs(of_stage(rows, 6)[-1]["time_s"] - of_stage(rows, 5)[-1]["time_s"] - 2e-5) < 1e-15, "a stage of 20 us")
    # A ramp of stress is followed from where the stage begins, until the axis has gone its way, of 25 steps at most.
    first, ramped = of_stage(rows, 7)[-1], of_stage(rows, 8)
    for r in ramped[2:]:
        asked = first["axial_stress_Pa"] + ramp * (r["time_s"] - first["time_s"])
        need(abs(r["axial_stress_Pa"] / asked - 1) < 2e-3, f"a ramp of stress: {r['axial_stress_Pa']} of {asked} Pa")
    way = ramped[-1]["axial_strain"] - first["axial_strain"]
    need(5e-4 <= way < 5.1e-4, f"way of a ramp of stress: {way}")
    # The ledger goes on: its work is that of the stresses, by the trapezoid of the rows.
    area_length = (4 * RADIUS)**3
    work = sum(0.5 * (p["axial_stress_Pa"] + q["axial_stress_Pa"]) * (q["axial_strain"] - p["axial_strain"])
               for p, q in zip(rows, rows[1:])) * area_length
    need(abs(rows[-1]["work_J"] / work - 1) < 0.01, f"work {rows[-1]['work_J']} J, of the stresses {work} J")
    need(max(abs(r["energy_error"]) for r in rows) < 1e-3, f"energy error {max(abs(r['energy_error']) for r in rows)}")


def servo(tmp):
    """Stresses are met and held to 0.1 %; the volume is kept; the grains' friction is the stage's own."""
    slow = {"strain_rate": 1}
    text = CELL + stage("compress", name="isotropic", axis="all", until={"stress": 1e6}, friction=0.2, strain_rate=5)
    text += stage("hold", until={"unbalanced_force": 2e-3}, max_time=5e-3)
    text += stage("shear", lateral_stress=1.05e6, until={"strain": 0.004}, **slow)
    text += stage("unload", lateral="held", until={"deviator": 1e5}, **slow)
    text += stage("shear", lateral="volume", until={"strain": 0.004}, **slow)
    folder, _ = go(tmp, "servo", text)
    rows, told = numbers(folder), summary(folder)
    ends = [s["ended_by"] for s in told["stages"]]
    need(ends == ["stress", "unbalanced_force", "strain", "deviator", "strain"], f"ended by {ends}")
    stress = lambda r: [-r[f"stress_{k}{k}_Pa"] for k in "xyz"]
    need(20 <= len(of_stage(rows, 1)) <= 30, f"{len(of_stage(rows, 1))} rows of 25 to one stress of all axes")
    last = stress(of_stage(rows, 1)[-1])
    need(max(abs(s / 1e6 - 1) for s in last) < 1.001e-3, f"isotropic stress: {last}")
    for r in of_stage(rows, 2):
        need(max(abs(s / a - 1) for s, a in zip(stress(r), last)) < 2e-3, f"held: {stress(r)} of {last}")
    off = [max(abs(s / 1.05e6 - 1) for s in stress(r)[:2]) for r in of_stage(rows, 3)[3:]]
    need(sum(off) / len(off) < 1e-3, f"lateral stress: off by {sum(off) / len(off)} on average, {max(off)} at worst")
    q = of_stage(rows, 4)[-1]
    deviator = stress(q)[2] - 0.5 * (stress(q)[0] + stress(q)[1])
    need(abs(deviator / 1e5 - 1) < 0.02, f"deviator {deviator} of 1e5 Pa")
    ratios = [r["void_ratio"] for r in of_stage(rows, 5)] + [q["void_ratio"]]
    need(max(ratios) - min(ratios) < 2e-6, f"void ratio from {min(ratios)} to {max(ratios)} at a constant volume")
    need(abs(of_stage(rows, 5)[-1]["axial_strain"] - q["axial_strain"] - 0.004) < 1e-9, "strain of an undrained shear")
    need(all(math.isnan(r["lateral_stress_error"]) for r in of_stage(rows, 5)), "an error of stresses that none holds")
    need(max(abs(r["energy_error"]) for r in rows) < 2e-3, "energy of the cell")
    # What springs held goes to friction at once where there is no friction any more: a part of what is stored.
    folder, _ = go(tmp, "eased", CELL + stage("relax", friction=0, until={"time": 2e-5}, rows=1) +
                   stage("shear", until={"strain": 0.001}, **slow))
    held = of_stage(numbers(folder), 1)
    need(numbers(folder)[-1]["friction_J"] > 1.1 * held[-1]["friction_J"], "friction in the stage after that")
    need(held[-1]["friction_J"] > 1e-3 * held[0]["elastic_J"], f"springs gave {held[-1]['friction_J']} J")
    need(abs(held[-1]["energy_error"]) < 5e-4, f"energy as springs let go: {held[-1]['energy_error']}")
    need(told["errors"]["lateral_stress"]["mean"] < 2e-3, f"{told['errors']['lateral_stress']}")


def deposit(tmp):
    """Grains that have come to rest weigh on the floor; a lid then compresses them, without friction at first."""
    text = BOX + stage("deposit", gravity=[0, 0, -9.81], damping=0.5, until={"unbalanced_force": 0.02}, max_time=0.2)
    text += stage("compress", friction=0, strain_rate=10, until={"stress": 1e5}, rows=10)
    text += stage("unload", strain_rate=10, until={"stress": 2e4}, gravity=[0, 0, 0], rows=10)
    text += stage("compress", strain_rate=10, until={"void_ratio": 0.8}, rows=5)
    text += stage("relax", until={"time": 1e-4}, rows=1)
    text += "[output]\nwall_forces = true\n"
    folder, _ = go(tmp, "deposit", text)
    turned = BOX + stage("deposit", gravity=[0, 0, -200], until={"time": 2e-3}, rows=1)
    turned += stage("deposit", gravity=[0, 0, 200], damping=0.5, until={"time": 0.04}, rows=1)
    rising = numbers(go(tmp, "turned", turned)[0])[-1]
    need(abs(rising["stress_front_Pa"] * 36e-6 / (200 * rising["mass_kg"]) - 1) < 0.1, f"gravity that turned: {rising}")
    rows, told = numbers(folder), summary(folder)["stages"]
    ends = ["unbalanced_force", "stress", "stress", "void_ratio", "time"]
    need([s["ended_by"] for s in told] == ends, f"ends: {told}")
    rest = of_stage(rows, 1)[-1]
    weight = rest["mass_kg"] * 9.81
    # What is left unbalanced is 2 % of the mean force of a contact, of each grain.
    need(abs(rest["stress_back_Pa"] * 36e-6 / weight - 1) < 0.05,
         f"the floor bears {rest['stress_back_Pa'] * 36e-6} N of {weight} N")
    sides = [f"{axis}{side}" for axis in "xyz" for side in ("min", "max")]
    whole = [sum(rest[f"force_{side}_{axis}_N"] for side in sides) for axis in "xyz"]
    need(all(abs(f / weight - e) < 0.03 for f, e in zip(whole, (0, 0, -1))), f"all sides bear {whole} N of {weight} N")
    lid = of_stage(rows, 2)[-1]
    need(abs(lid["force_zmax_z_N"] / (lid["stress_front_Pa"] * 36e-6) - 1) < 1e-6 and lid["force_xmin_x_N"] < 0,
         f"the lid: {lid['force_zmax_z_N']} N, {lid['stress_front_Pa']} Pa; a side {lid['force_xmin_x_N']} N")
    need(rows[-1]["void_ratio"] == rows[-2]["void_ratio"], "walls that move on in a stage that stands")
    need(abs(rows[-1]["void_ratio"] - 0.8) < 1e-3, f"void ratio {rows[-1]['void_ratio']}")
    need(max(abs(r["energy_error"]) for r in rows) < 5e-3, f"{max(abs(r['energy_error']) for r in rows)}")
    spent = [r["friction_J"] for r in of_stage(rows, 2)]
    need(spent[-1] - spent[1] < 1e-12, f"friction without friction: {spent[-1] - spent[1]} J")


def plane(tmp):
    """Sheared to and fro in a plane, a cell keeps its volume, and ends where it is asked."""
    text = CELL + stage("shear", plane="xz", strain_rate=5, until={"strain": 0.02}, rows=10)
    text += stage("shear", plane="xz", strain_rate=-5, until={"stress": 0}, rows=10)
    text += stage("relax", until={"unbalanced_force": 1e-2}, max_time=1e-2, rows=4)
    folder, _ = go(tmp, "plane", text)
    rows = numbers(folder)
    ratios = [r["void_ratio"] for r in rows]
    need(max(ratios) - min(ratios) < 1e-9, f"void ratio {min(ratios)} to {max(ratios)}")
    there = of_stage(rows, 1)[-1]
    need(abs(there["strain_xz"] - 0.01) < 1e-8, f"strain_xz {there['strain_xz']}")
    need(there["stress_xz_Pa"] > 1e5 and abs(of_stage(rows, 2)[-1]["stress_xz_Pa"]) < 0.02 * there["stress_xz_Pa"],
         f"shear stress {there['stress_xz_Pa']} Pa, then {of_stage(rows, 2)[-1]['stress_xz_Pa']} Pa")


def extremes(tmp):
    """Stages of no length have one row each; ends that are never met are told; ten thousand cycles are counted."""
    text = LATTICE + stage("compress", strain_rate=1, until={"strain": 0})
    text += stage("compress", strain_rate=1, until={"stress": 2e5}, rows=3)
    text += stage("unload", strain_rate=1, until={"stress": 3e5})
    folder, _ = go(tmp, "nothing", text + stage("relax", until={"time": 0}))
    rows = numbers(folder)
    need([r["stage"] for r in rows] == [1, 1, 2, 2, 2, 3, 4], f"rows of no length: {[r['stage'] for r in rows]}")
    need(rows[1]["time_s"] == 0 and rows[-1]["time_s"] == rows[-3]["time_s"], "stages of no length take time")
    told = [n.split(" has no length: its end (")[0] for n in summary(folder)["notes"] if "has no length" in n]
    need(told == ["stage 1 (compress)", "stage 3 (unload)", "stage 4 (relax)"], f"told of no length: {told}")
    folder, r = go(tmp, "never", LATTICE + stage("compress", strain_rate=1, until={"strain": 1e-4}) +
                   stage("unload", strain_rate=1, until={"stress": -1e5}, max_strain=0.01), status=3)
    need('stage 2 ("unload") has not met its end, a stress in Pa of -1e+05 (it is' in r.stderr
         and "by a strain of 0.01 (max_strain)" in r.stderr and r.stderr.count("\n") == 1, f"never met: {r.stderr}")
    need(len(summary(folder)["stages"]) == 1 and summary(folder)["status"] == 3, "summary of a stage that failed")
    fallen = CELL + stage("shear", strain_rate=5, until={"strain": 0.02}, rows=2)
    fallen += stage("hold", friction=0, until={"time": 1}, max_strain=0.01, rows=2)
    _, r = go(tmp, "fallen", fallen, status=3)
    need('stage 2 ("hold") has not met its end' in r.stderr and "by a strain of 0.01 (max_strain)" in r.stderr,
         f"a sample that falls while its stress is held: {r.stderr}")
    _, r = go(tmp, "late", LATTICE + stage("relax", until={"void_ratio": 0.5}, max_time=1e-5), status=3)
    need("by a time of 1e-05 s (max_time" in r.stderr, f"late: {r.stderr}")
    text = LATTICE + stage("compress", strain_rate=10, until={"strain": 1e-3})
    folder, _ = go(tmp, "many", text + stage("cyclic", strain_rate=10, strain_amplitude=1e-5, cycles=10000,
                                             lateral="fixed", rows=1))
    rows = numbers(folder)
    need(rows[-1]["cycle"] == 10000 and len(of_stage(rows, 2)) == 20001,
         f"{rows[-1]['cycle']} cycles, {len(rows)} rows")
    need(abs(rows[-1]["axial_strain"] - 1e-3) < 1e-11, f"strain after 10000 cycles: {rows[-1]['axial_strain']}")


def killed(tmp):
    """Killed and interrupted anywhere, between stages too, and resumed with other threads: the same bytes."""
    text = CELL + stage("compress", axis="all", until={"stress": 7e5}, strain_rate=5, rows=5)
    for _ in range(3):
        text += stage("shear", until={"deviator": 3e5}, strain_rate=3, rows=4)
        text += stage("unload", lateral="held", until={"strain": 5e-4}, strain_rate=3, rows=2, friction=0.3)
    text += stage("cyclic", deviator_amplitude=1e5, cycles=2, strain_rate=3, rows=3) + "[output]\nframes = 4\n"
    text += "gradings = 3\ncheckpoint_interval = 0.02\n"
    began = time.monotonic()
    folder, _ = go(tmp, "whole", text)
    whole = time.monotonic() - began
    scene, part = os.path.join(tmp, "whole.toml"), os.path.join(tmp, "part")
    seed = random.randrange(1 << 30)
    chance, kills, k = random.Random(seed), 0, 0
    resume = []
    while True:
        p = subprocess.Popen([rve, scene, "-o", part, "--quiet", "--threads", str(1 + k % 2), *(resume or ["--force"])],
                             stderr=subprocess.PIPE, text=True)
        k += 1
        try:
            p.wait(whole * (0.1 + 0.15 * chance.random()) if kills < 12 else 300)
        except subprocess.TimeoutExpired:
            p.send_signal(signal.SIGKILL if k % 2 else signal.SIGINT)
            p.wait()
            kills += 1
            time.sleep(0.05)
        else:
            need(p.returncode in (0, 130), f"resumed: exit {p.returncode} {p.stderr.read()}")
            if p.returncode != 130 and (kills >= 3 or k >= 40):
                break
            if p.returncode == 0:  # it was not killed often enough: the machine had more to do as the whole was timed
                shutil.rmtree(part)
                kills, whole = 0, 0.5 * whole
        resume = ["--resume"] if os.path.exists(os.path.join(part, "checkpoint.h5")) else []
    need(kills >= 3, f"killed {kills} times only")
    for name in ("history.csv", "grading.csv", "grains.hdf.series"):
        need(
            open(os.path.join(folder, name)).read() == open(os.path.join(part, name)).read(),
            f"{name} differs after kill and resume (seed {seed})")
    need(summary(folder)["stages"] == summary(part)["stages"], f"stages differ after kill and resume (seed {seed})")


def going_on(tmp):
    """A finished run goes on: with more stages, or to a larger strain, in the rows of a run that knew it before; what
    has begun may not change. A run that starts from its last state finds that state, with clock and ledger at zero."""
    first = CELL + stage("compress", strain_rate=5, until={"stress": 8e5}, rows=5)
    more = first + stage("unload", strain_rate=5, until={"stress": 6e5}, rows=3)
    whole, _ = go(tmp, "knew", more)
    folder, _ = go(tmp, "went", first)
    go(tmp, "went", more, "--resume")
    need(open(os.path.join(whole, "history.csv")).read() == open(os.path.join(folder, "history.csv")).read(),
         "a stage that was added is not the one that was known before")
    need(summary(folder)["status"] == 0 and len(summary(folder)["stages"]) == 2, "summary of a run that went on")
    # Stages that bring columns of their own: rows that are there get them.
    longer = more + stage("shear", strain_rate=5, until={"strain": 2e-4}, rows=2)
    longer += stage("cyclic", strain_rate=5, strain_amplitude=1e-4, cycles=1, rows=1)
    whole_longer, _ = go(tmp, "knew_longer", longer)
    went_longer, _ = go(tmp, "went_longer", first)
    go(tmp, "went_longer", longer, "--resume")
    knew, went = (open(os.path.join(f, "history.csv")).read() for f in (whole_longer, went_longer))
    need(knew == went, "stages that brought columns of their own")
    _, r = go(tmp, "went", more.replace("8e5", "9e5").replace("800000.0", "900000.0"), "--resume", status=2)
    need("stage[0].until.stress was 8" in r.stderr, f"a stage that has begun: {r.stderr}")
    go(tmp, "went", more, "--resume")  # nothing is left to do
    need(open(os.path.join(whole, "history.csv")).read() == open(os.path.join(folder, "history.csv")).read(), "twice")

    strained = lambda final: CELL + '[loading]\nkind = "uniaxial-strain"\nstrain_rate = 0.5\n' + (
        f"final_strain = {final}\n[output]\nhistory_interval = 0.0005\nlast_state = true\n")
    whole, _ = go(tmp, "far", strained(0.004))
    folder, _ = go(tmp, "further", strained(0.002))
    go(tmp, "further", strained(0.004), "--resume")
    a, b = numbers(whole), numbers(folder)
    need(len(a) == len(b) == 9, f"{len(a)} and {len(b)} rows to a larger strain")
    for p, q in zip(a, b):
        need(abs(p["axial_strain"] - q["axial_strain"]) < 1e-12 and
             abs(p["axial_stress_Pa"] - q["axial_stress_Pa"]) < 1e-6 * p["axial_stress_Pa"], f"{p} {q}")
    _, r = go(tmp, "further", strained(0.003), "--resume", status=2)
    need("loading.final_strain was 0.004, is 0.003" in r.stderr, f"less far: {r.stderr}")

    text = CELL[:CELL.index("[preparation]")]
    text += stage("relax", until={"time": 0}) + stage("hold", until={"time": 1e-5}, rows=2)
    folder, _ = go(tmp, "after", 'start = "further"\n' + text)
    last, rows = b[-1], numbers(folder)
    need(rows[0]["time_s"] == 0 and rows[0]["work_J"] == 0 and abs(rows[0]["axial_strain"]) < 1e-12,
         f"the clock: {rows[0]}")
    for name in ("void_ratio", "stress_xx_Pa", "stress_zz_Pa", "coordination"):
        # Dashpots of a cell that stands carry nothing: 2 % at 5/s.
        need(abs(rows[0][name] / last[name] - 1) < 4e-3, f"{name}: {last[name]} at the end, {rows[0][name]} after it")
    need(max(abs(r["energy_error"]) for r in rows) < 1e-3, "energy of a run from another's end")
    smooth = text.replace("friction = 0.5", "friction = 0.3")  # the new run's own, from its first step on
    eased, _ = go(tmp, "smoother", 'start = "further"\n' + smooth)
    need(numbers(eased)[-1]["coordination"] != rows[-1]["coordination"], "friction of the new run")
    _, r = go(tmp, "other", 'start = "further"\n' + text.replace("0.6 mm", "0.61 mm"), status=2)
    need("radius.max was 0.0006, is 0.00061; set it back, or leave start out" in r.stderr
         and r.stderr.count("\n") == 1, f"other: {r.stderr}")
    _, r = go(tmp, "none", 'start = "nowhere"\n' + text, status=2)
    need('start: "nowhere" holds no checkpoint.h5' in r.stderr and r.stderr.count("\n") == 1, f"nowhere: {r.stderr}")
    _, r = go(tmp, "further", 'start = "further"\n' + text, status=2)
    need("is the results folder, too" in r.stderr and numbers(os.path.join(tmp, "further")) == b, f"itself: {r.stderr}")
    rolls = text.replace("friction = 0.5", "friction = 0.5\nrolling_friction = 0.1")
    _, r = go(tmp, "rolls", 'start = "further"\n' + rolls, status=2)
    need("rolling_friction was 0.0, is 0.1; set it back" in r.stderr and "friction was 0.5" not in r.stderr,
         f"another law: {r.stderr}")
    go(tmp, "unkept", strained(0.002).replace("last_state = true", "last_state = false\ncheckpoint_interval = 1e-6"))
    _, r = go(tmp, "unkept_start", 'start = "unkept"\n' + text, status=2)
    need("has not kept its last state" in r.stderr and r.stderr.count("\n") == 1, f"a checkpoint midway: {r.stderr}")
    # A run that was stopped midway is told of, one that failed is refused.
    short = stage("compress", strain_rate=5, until={"stress": 1e10}, max_strain=1e-3, rows=5)
    failed, _ = go(tmp, "failed", CELL + short + "[output]\ncheckpoint_interval = 1e-6\n", status=3)
    _, r = go(tmp, "late_start", 'start = "failed"\n' + text, status=2)
    need("holds a run that failed (status 3)" in r.stderr and r.stderr.count("\n") == 1, f"failed: {r.stderr}")
    os.remove(os.path.join(failed, "summary.json"))  # as of one that was killed
    late, _ = go(tmp, "late_start", 'start = "failed"\n' + text)
    noted = [any("has not finished" in note for note in summary(f)["notes"]) for f in (late, folder)]
    need(noted == [True, False], f"stopped midway: {summary(late)['notes']}")


with tempfile.TemporaryDirectory() as folder:
    for case in (lattice, servo, deposit, plane, extremes, killed, going_on):
        if len(sys.argv) < 3 or case.__name__ in sys.argv[2:]:
            case(folder)
print(f"stages: {len(faults)} faults")
sys.exit(1 if faults else 0)
