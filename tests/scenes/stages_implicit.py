#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests of several stages by solved contacts, against closed forms, explicit steps and themselves: BIN"""
import os
import sys
import tempfile

from stage_tools import BOX, CELL, LATTICE, go, lattice_stress, numbers, of_stage, stage

from scene_tools import faults, need, summary

SOLVED = '[numerics]\nengine = "implicit"\n'
undamped = lambda text: text.replace("damping = 0.3\n", "")


def lattice(tmp):
    """Loaded, unloaded, reloaded and cycled, columns of spheres follow Hertz's law, in few steps; ends are met."""
    slow = {"strain_rate": 0.5}
    text = SOLVED + undamped(LATTICE) + stage("compress", until={"stress": 1e6}, **slow)
    text += stage("unload", until={"stress": 0.4e6}, **slow) + stage("reload", **slow)
    text += stage("cyclic", stress_amplitude=0.2e6, cycles=2, lateral="fixed", rows=8, **slow)
    text += stage("cyclic", strain_amplitude=1e-4, cycles=2, lateral="fixed", rows=4, **slow)
    text += stage("relax", until={"time": 2e-5}, rows=2) + stage("compress", until={"strain": 1e-3}, rows=4, **slow)
    folder, _ = go(tmp, "lattice", text)
    rows, told = numbers(folder), summary(folder)
    ends = [s["ended_by"] for s in told["stages"]]
    need(ends == ["stress", "stress", "stress", "cycles", "cycles", "time", "strain"], f"ended by {ends}")
    for r in rows[1:]:
        need(abs(r["axial_stress_Pa"] - lattice_stress(r["axial_strain"])) < 1e-3 * 1e6,
             f"stage {r['stage']}: {r['axial_stress_Pa']} Pa at {r['axial_strain']}")
    # A step gains a tenth of the stress at most, and the last one before an end is a twentieth of that.
    for number, asked in ((1, 1e6), (2, 0.4e6), (3, 1e6)):
        last = of_stage(rows, number)[-1]["axial_stress_Pa"]
        need(abs(last / asked - 1) < 0.01, f"stage {number} ends at {last} Pa, asked {asked}")
    middle, swing = of_stage(rows, 3)[-1]["axial_stress_Pa"], of_stage(rows, 4)
    turns = [r["axial_stress_Pa"] for r, after in zip(swing, swing[1:]) if r["cycle"] != after["cycle"]]
    need(len(turns) == 4, f"{len(turns)} turns of two cycles")
    for k, turn in enumerate(turns):
        need(abs(turn - middle - (0.2e6 if k % 2 == 0 else -0.2e6)) < 1e4, f"turn {k} at {turn}")
    far = [r["axial_strain"] - swing[-1]["axial_strain"] for r in of_stage(rows, 5)]
    need(abs(max(far) - 1e-4) < 1e-12 and abs(min(far) + 1e-4) < 1e-12 and abs(far[-1]) < 1e-12,
         f"strains of cycles: {min(far)} to {max(far)}, {far[-1]}")
    need(max(abs(r["energy_error"]) for r in rows) < 1e-3, f"energy error {max(abs(r['energy_error']) for r in rows)}")


def cell(tmp):
    """A sand is compressed, held, sheared and unloaded: stresses, void ratio and energy of explicit steps, in a few
    hundredths of their number; resumed at any stage, by any number of threads, the same bytes."""
    text = undamped(CELL) + stage("compress", axis="all", until={"stress": 1e6}, strain_rate=2, friction=0.2)
    text += stage("hold", until={"unbalanced_force": 2e-3}, max_time=5e-2)
    text += stage("shear", lateral_stress=1e6, until={"strain": 0.005}, strain_rate=0.5)
    text += stage("unload", lateral="held", until={"deviator": 1e5}, strain_rate=0.5)
    both = [numbers(go(tmp, name, head + text)[0]) for name, head in (("solved", SOLVED), ("explicit", ""))]
    need(30 * both[0][-1]["steps"] < both[1][-1]["steps"], f"{both[0][-1]['steps']} of {both[1][-1]['steps']} steps")
    deviator = lambda r: r["stress_xx_Pa"] - r["stress_zz_Pa"]
    for number in (1, 2, 3, 4):
        a, b = (of_stage(rows, number)[-1] for rows in both)
        # A step's own error, by which it is chosen, is below 2 % of the contacts' forces.
        need(abs(deviator(a) - deviator(b)) < 2e4, f"deviators of stage {number}: {deviator(a)}, {deviator(b)} Pa")
        need(abs(a["void_ratio"] - b["void_ratio"]) < 1e-4, f"void ratio {a['void_ratio']}, {b['void_ratio']}")
        if number > 2:
            need(abs(a["friction_J"] / b["friction_J"] - 1) < 0.05, f"friction: {a['friction_J']}, {b['friction_J']} J")
    lateral = summary(os.path.join(tmp, "solved"))["errors"]["lateral_stress"]
    need(lateral["mean"] < 2e-3 and lateral["worst"] < 1e-2, f"held stresses: {lateral}")
    worst = max(abs(r["energy_error"]) for r in both[0])
    need(worst < 1e-3, f"energy error {worst}")
    parts = text.split("[[stage]]")
    begun = "[[stage]]".join(parts[:3])
    folder, _ = go(tmp, "begun", SOLVED + begun)
    go(tmp, "begun", SOLVED + text, "--resume")
    need(open(os.path.join(folder, "history.csv")).read() == open(os.path.join(tmp, "solved", "history.csv")).read(),
         "a run that went on by two more stages differs")


def box(tmp):
    """Grains fall, and the floor bears their weight; a lid presses them, sides hold a stress."""
    small = undamped(BOX).replace('["6 mm", "6 mm", "6 mm"]', '["3 mm", "3 mm", "3 mm"]')
    text = small + stage("deposit", gravity=[0, 0, -9.81], until={"unbalanced_force": 1e-3}, max_time=0.5, rows=1)
    text += stage("compress", friction=0, strain_rate=1, until={"stress": 1e5}, rows=10)
    text += stage("compress", axis="all", strain_rate=1, until={"stress": 2e5}, gravity=[0, 0, 0], rows=10)
    text += stage("shear", strain_rate=0.2, lateral_stress=2e5, until={"strain": 2e-3}, rows=10)
    folder, _ = go(tmp, "box", SOLVED + text + "[output]\nwall_forces = true\n")
    rows = numbers(folder)
    rest = of_stage(rows, 1)[-1]
    weight = rest["mass_kg"] * 9.81
    borne = -rest["force_zmin_z_N"] - rest["force_zmax_z_N"]
    need(abs(borne / weight - 1) < 0.01, f"floor and lid bear {borne} N of {weight} N")
    lid = of_stage(rows, 2)
    need(lid[-1]["friction_J"] - lid[1]["friction_J"] < 1e-12, "friction without friction")
    need(abs(lid[-1]["axial_stress_Pa"] / 1e5 - 1) < 0.01, f"the lid presses with {lid[-1]['axial_stress_Pa']} Pa")
    every = of_stage(rows, 3)[-1]
    need(all(abs(every[f"wall_stress_{k}{k}_Pa"] / -2e5 - 1) < 0.002 for k in "xyz"), f"all sides: {every}")
    held = summary(folder)["errors"]["lateral_stress"]
    # A wall closes its gap in a step, in which the others' stress changes by some per cent.
    need(held["mean"] < 0.02 and held["worst"] < 0.05, f"sides that hold a stress: {held}")
    worst = max(abs(r["energy_error"]) for r in rows)
    need(worst < 0.02, f"energy error {worst}")


def plane(tmp):
    """Sheared in a plane, a cell keeps its volume and answers as by explicit steps."""
    text = undamped(CELL) + stage("shear", plane="xz", strain_rate=1, until={"strain": 0.004}, rows=4)
    text += stage("shear", plane="xz", strain_rate=-1, until={"stress": 0}, rows=4)
    both = [numbers(go(tmp, name, head + text)[0]) for name, head in (("turned", SOLVED), ("turned_explicit", ""))]
    for number in (1, 2):
        a, b = (of_stage(rows, number)[-1] for rows in both)
        off = a["stress_xz_Pa"] - b["stress_xz_Pa"]
        need(abs(off) < 4e3, f"shear stress of stage {number}: {a['stress_xz_Pa']}, {b['stress_xz_Pa']} Pa of 2e5")
        need(abs(a["strain_xz"] - b["strain_xz"]) < 2e-5, f"strain_xz {a['strain_xz']}, {b['strain_xz']}")
        need(abs(a["mean_pressure_Pa"] / b["mean_pressure_Pa"] - 1) < 5e-3, f"mean pressure of stage {number}")
    need(30 * both[0][-1]["steps"] < both[1][-1]["steps"], f"{both[0][-1]['steps']} of {both[1][-1]['steps']} steps")


def held(tmp):
    """A step that is held is of the test: its sample is prepared by explicit steps of their own."""
    text = SOLVED + "time_step = 1e-6\n" + undamped(CELL) + stage("shear", until={"strain": 1e-3}, strain_rate=5)
    folder, _ = go(tmp, "held", text)
    need(summary(folder)["counts"]["steps"] == 200, f"{summary(folder)['counts']['steps']} steps of 1 us in 0.2 ms")


def refused(tmp):
    """What such stages do not know, and a rate at which time is real, also where inertia is added."""
    slow = stage("compress", strain_rate=1, until={"stress": 1e6})
    fast = stage("hold", until={"time": 1e-5}) + stage("compress", strain_rate=2000, until={"stress": 1e6})
    for name, text, told in (
            ("damped", SOLVED + undamped(CELL) + slow + "damping = 0.1\n", "stage[0].damping: must be 0"),
            ("balanced", SOLVED + undamped(CELL) + stage("hold", until={"unbalanced_force": 5e-4}, max_time=1),
             "must be at least 0.001"),
            ("fast", SOLVED + undamped(CELL) + fast, "2e+03 1/s at 5e+05 Pa is an inertial number of"),
            ("heavy", '[numerics]\ninertia = { step = "1e-6 s" }\n' + CELL + fast, "leave inertia.step out")):
        _, r = go(tmp, name, text, status=2)
        need(told in r.stderr and r.stderr.count("\n") == 1, f"{name}: {r.stderr}")


with tempfile.TemporaryDirectory() as tmp_:
    for check in (lattice, cell, box, plane, held, refused):
        check(tmp_)
print(f"stages by solved contacts: {len(faults)} faults")
sys.exit(1 if faults else 0)
