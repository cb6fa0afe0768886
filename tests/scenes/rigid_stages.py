#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stages of grains that do not give way, whole programs against closed forms: BIN"""
import os
import sys
import tempfile

from stage_tools import go, numbers, of_stage, stage

from scene_tools import faults, need, summary

G = 9.81
EDGE, DENSITY, FRICTION = 0.01, 2600, 0.5
MASS = DENSITY * EDGE**3
KEPT = 1e-4 * EDGE * (3 / (4 * 3.141592653589793))**(1 / 3)  # of the radius of the sphere of equal volume


def blocks(*heights, friction=FRICTION):
    """Cubes one above the other on a floor."""
    text = f'[material.s]\ndensity = {DENSITY}\ncontact = "overlap"\nyoungs_modulus = "10 GPa"\n'
    text += f'friction = {friction}\nrestitution = 0.3\n'
    for z in heights:
        text += f'[[grain]]\nshape = "hull"\nbox = [{EDGE}, {EDGE}, {EDGE}]\nposition = [0, 0, {z}]\n'
    text += '[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n'
    return text + '[numerics]\nengine = "implicit"\ncompliance = 0\n'


def deposit(time, gravity=(0, 0, -G)):
    return stage("deposit", gravity=list(gravity), until={"time": time}, rows=4)


def slides(rows, number, time):
    """The block has been pulled aside for `time` at g, and rubs by half of that."""
    exact = 0.5 * MASS * ((1 - FRICTION) * G * time)**2
    last = of_stage(rows, number)[-1]
    need(abs(last["kinetic_J"] / exact - 1) < 2e-3, f"stage {number}: {last['kinetic_J']} J, sliding {exact} J")


def stages(tmp):
    """Stages are as long as asked, however long a step of what rests may be: also after one without gravity, of a run
    that begins in another's last state, and of one that goes on."""
    aside = deposit(0.1, (G, 0, -G))
    head = blocks(EDGE / 2) + deposit(0.05)
    rest = stage("relax", gravity=[0, 0, 0], until={"time": 0.05}, rows=2)
    folder, _ = go(tmp, "in_one", head + rest + aside)
    rows, told = numbers(folder), summary(folder)
    need([round(s["ended_s"], 12) for s in told["stages"]] == [0.05, 0.1, 0.2], f"stages: {told['stages']}")
    need(len(of_stage(rows, 3)) == 4, f"{len(of_stage(rows, 3))} rows of the last stage")
    need(told["counts"]["steps"] < 600, f"{told['counts']['steps']} steps")
    slides(rows, 3, 0.1)
    go(tmp, "going_on", head + rest)
    folder, _ = go(tmp, "going_on", head + rest + aside, "--resume")
    need(open(os.path.join(folder, "history.csv")).read() == open(os.path.join(tmp, "in_one", "history.csv")).read(),
         "a run that went on differs")
    go(tmp, "base", head)
    folder, _ = go(tmp, "started", f'start = "{os.path.join(tmp, "base")}"\n' + blocks(EDGE / 2) + aside)
    slides(numbers(folder), 1, 0.1)


def weightless(tmp):
    """Blocks that rest where nothing pulls take a step a row; those that drift meet when they meet."""
    folder, _ = go(tmp, "still", blocks(EDGE / 2) + stage("relax", gravity=[0, 0, 0], until={"time": 10}, rows=4))
    need(summary(folder)["counts"]["steps"] <= 20, f"{summary(folder)['counts']['steps']} steps of a block at rest")
    text = blocks(2 * EDGE, 4 * EDGE)
    below, _, above = text.rpartition("position")
    text = below + "velocity = [0, 0, -0.1]\nposition" + above
    folder, _ = go(tmp, "meet", text + stage("relax", gravity=[0, 0, 0], until={"time": 0.15}, rows=15))
    rows = numbers(folder)
    one = 0.5 * MASS * 0.1**2
    for r in rows[1:]:  # the gap of an edge is gone after 0.1 s; then both go on together, with half of the energy
        want = one if r["time_s"] < 0.0995 else 0.5 * one if r["time_s"] > 0.1005 else r["kinetic_J"]
        need(abs(r["kinetic_J"] / want - 1) < 1e-6, f"{r['kinetic_J']} J at {r['time_s']} s, not {want}")


def starts(tmp):
    """Stacks whose blocks just touch, and what lies in each other a little, come to rest as deep as contacts keep."""
    for count in (1, 5, 10):
        folder, _ = go(tmp, f"stack_{count}", blocks(*[(0.5 + k) * EDGE for k in range(count)]) + deposit(0.3))
        last = numbers(folder)[-1]
        for k in range(count):
            rest = (0.5 + k) * EDGE - (k + 1) * KEPT  # what is parted at all is parted from half of that on
            need(-0.6 * (k + 1) * KEPT < last[f"g{k}_z_m"] - rest < 1.1 * (k + 1) * KEPT,
                 f"block {k} of {count} at {last[f'g{k}_z_m']}, not {rest}")
        need(last["kinetic_J"] < 1e-8 * count * MASS, f"stack of {count}: {last['kinetic_J']} J")
    for deep in (1e-6, 2e-5, 2e-4):
        folder, _ = go(tmp, f"deep_{deep}", blocks(EDGE / 2 - deep) + deposit(0.1))
        last = numbers(folder)[-1]
        need(-1.6 * KEPT < last["g0_z_m"] - EDGE / 2 < 0, f"{deep} m deep: at {last['g0_z_m']}")
        need(last["kinetic_J"] < 1e-9 * MASS, f"{deep} m deep: {last['kinetic_J']} J")


def heap(tmp):
    """Rough grains that fall into a box: also the steps for which the solver finds no end are taken, and the books
    close."""
    text = blocks(friction=1.5).replace("[[wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n", "")
    text += '[packing]\nkind = "random"\nbox = ["4 mm", "4 mm", "8 mm"]\nhulls = {}\nseed = 2\nsolid_fraction = 0.04\n'
    text += 'radius = { distribution = "uniform", min = "0.4 mm", max = "0.5 mm" }\n[boundary]\nkind = "walls"\n'
    folder, _ = go(tmp, "heap", text + deposit(0.06))
    last = numbers(folder)[-1]
    need(last["time_s"] == 0.06, f"ends at {last['time_s']} s")
    need(max(abs(r["energy_error"]) for r in numbers(folder)) < 1e-9, f"energy error {last['energy_error']}")


with tempfile.TemporaryDirectory() as tmp_:
    for check in (stages, weightless, starts, heap):
        check(tmp_)
print(f"rigid stages: {len(faults)} faults")
sys.exit(1 if faults else 0)
