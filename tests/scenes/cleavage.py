#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grains that cleave through the programs: cleavage.py BIN"""
import json
import os
import sys
import tempfile

import scene_tools
from scene_tools import faults, history, need, run, shipped

binaries = os.path.abspath(sys.argv[1])
rve, bvp = scene_tools.program(binaries, "grus-rve"), scene_tools.program(binaries, "grus-bvp")
SMALL = ["packing.box=[5.5e-3, 5.5e-3, 5.5e-3]", "loading.strain_rate=60", "loading.final_strain=0.12"]


def settings(values):
    return [a for v in values for a in ("--set", v)]


def numbers(out):
    return [{k: float(v) for k, v in row.items()} for row in history(out)]


def crush(tmp):
    """Angular grains in an oedometer cleave the same on one thread and two; masses and energies are kept; tougher ones
    hold."""
    texts, last = [], {}
    for name, threads, more in (("one", "1", []), ("two", "2", []),
                                ("tough", "2", ["material.sand.fracture.toughness=1e6"])):
        out = os.path.join(tmp, "crush" + name)
        r = run(rve, os.path.join(shipped, "angular_crush.toml"), "-o", out, "--quiet", "--threads", threads,
                *settings(SMALL + more))
        need(r.returncode == 0, f"crush {name}: {r.stderr}")
        texts.append(open(os.path.join(out, "history.csv")).read())
        rows, told = numbers(out), json.load(open(os.path.join(out, "summary.json")))
        last[name] = rows[-1]
        need(
            max(abs(x["energy_error"]) for x in rows) < 2e-3,
            f"crush {name}: energy error {max(abs(x['energy_error']) for x in rows)}")
        need(abs(told["mass"]["lost_kg"]) < 1e-12 * told["mass"]["start_kg"], f"crush {name}: {told['mass']}")
        need(rows[-1]["grains"] == rows[0]["grains"] + rows[-1]["breakages"],
             f"crush {name}: grains are not what cuts made")
    need(texts[0] == texts[1], "crush: one thread and two differ")
    need(last["one"]["breakages"] >= 5 and last["one"]["fracture_J"] > 0, f"crush: {last['one']['breakages']} cuts")
    need(last["tough"]["breakages"] == 0 and last["tough"]["axial_stress_Pa"] > last["one"]["axial_stress_Pa"],
         "crush: tough grains cleave, or bear less")


def gate(tmp):
    """Only grains whose mean stress is tensile enough may cleave: none does in compression."""
    out = os.path.join(tmp, "gate")
    r = run(rve, os.path.join(shipped, "angular_crush.toml"), "-o", out, "--quiet", "--threads", "2",
            *settings(SMALL + ["material.sand.fracture.hydrostatic_gate=0.0"]))
    need(r.returncode == 0, f"gate: {r.stderr}")
    need(numbers(out)[-1]["breakages"] == 0, f"gate: {numbers(out)[-1]['breakages']} cuts")


def disc(tmp):
    """Crystals of a disc are cut the more, the less tough they are against the bonds between them; the disc bears
    less."""
    cuts, peak = [], []
    for toughness in (0.05e6, 0.1e6, 1e6):
        out = os.path.join(tmp, f"disc{toughness}")
        r = run(
            rve, os.path.join(shipped, "polycrystal_disc.toml"), "-o", out, "--quiet", "--threads", "2",
            *settings([
                f"material.rock.fracture.toughness={toughness}", "packing.cells=150", "loading.strain_rate=4",
                "loading.final_strain=0.0012", "output.frames=0"
            ]))
        need(r.returncode == 0, f"disc {toughness}: {r.stderr}")
        rows = numbers(out)
        cuts.append(rows[-1]["breakages"]), peak.append(max(x["nominal_stress_Pa"] for x in rows))
        need(
            max(abs(x["energy_error"]) for x in rows) < 5e-3,
            f"disc {toughness}: energy error {max(abs(x['energy_error']) for x in rows)}")
    need(cuts[0] > cuts[1] > 20 and cuts[2] == 0, f"disc: cuts {cuts}")
    need(peak[0] < peak[1] < peak[2], f"disc: nominal tensions {peak}")


def fresh_faces(tmp):
    """What fresh faces put in is told beyond a twentieth of the work; bursts end where a run goes bad."""
    few = ["output.frames=0", "packing.cells=12", "loading.strain_rate=8", "loading.final_strain=4e-4",
           "material.rock.fracture.fracture_energy=20"]
    for toughness, noted in ((0.02e6, True), (1e6, False)):
        out = os.path.join(tmp, f"few{toughness}")
        r = run(rve, os.path.join(shipped, "polycrystal_disc.toml"), "-o", out, "--threads", "1",
                *settings([*few, f"material.rock.fracture.toughness={toughness}"]))
        told = json.load(open(os.path.join(out, "summary.json")))
        put, work = -told["energy"]["split_elastic_J"], told["energy"]["work_J"]
        share = told["errors"].get("put_in_by_splits", 0)
        need(r.returncode == 0 and (put > 0.05 * work) == noted and 0.8 * put <= share * work <= 1.01 * put,
             f"fresh faces, {toughness}: {put} of {work} J, told {share} {r.stderr}")
        need(all(("splits put" in text) == noted for text in (r.stdout, str(told.get("notes")))),
             f"fresh faces, {toughness}: {r.stdout} {told.get('notes')}")
    out = os.path.join(tmp, "bad")
    r = run(rve, os.path.join(shipped, "polycrystal_disc.toml"), "-o", out, "--quiet", "--threads", "1",
            *settings(["output.frames=0", "packing.cells=80", "loading.strain_rate=8",
                       "numerics.max_energy_error=1e-3", "output.history_interval=1e-5", 'output.bursts="1 us"']))
    told, rows = json.load(open(os.path.join(out, "summary.json"))), numbers(out)
    with open(os.path.join(out, "bursts.csv")) as f:
        bursts = [int(line.split(",")[1]) for line in f.readlines()[1:]]
    listed = sum(bursts)
    need(r.returncode == 3 and listed == rows[-1]["bonds_broken"] < told["counts"]["bonds_broken"],
         f"bursts of a bad end: {listed}, {rows[-1]['bonds_broken']} in the last row, {told['counts']} {r.stderr}")
    need(told["bursts"]["count"] == len(bursts), f"bursts of a bad end: {told['bursts']}")


def block(tmp):
    """The same grains are crushed at the points of a block, with a trial state and a committed one."""
    scene = os.path.join(tmp, "crush_cell.toml")
    with open(os.path.join(shipped, "angular_crush.toml")) as f:
        text = f.read()
    with open(scene, "w") as f:
        f.write(text.replace("8 mm", "5.5 mm"))
    out = os.path.join(tmp, "crush_block")
    r = run(bvp, os.path.join(shipped, "rock_block.toml"), "-o", out, "--quiet", "--threads", "2", "--set",
            f"rve.scene='{scene}'", "--set", "boundary.0.displacement=['free', 'free', '-1.6 mm']", "--set",
            "solve.increments=8", timeout=300)
    need(r.returncode == 0, f"block: {r.stderr}")
    rows = numbers(out)
    need(rows[-1]["breakages"] > 0 and rows[-1]["mean_stress_zz_Pa"] < -1e6,
         f"block: {rows[-1]['breakages']} cuts at {rows[-1]['mean_stress_zz_Pa']}")


def thesis(tmp):
    """Saleme (2016): its study can run; a beam cracks from below between the inner rollers; prisms that lie flush on
    each other land."""
    r = run(scene_tools.program(binaries, "grus-study"), os.path.join(shipped, "saleme2016", "all.toml"), "--check")
    need(r.returncode == 0, f"study: {r.stderr}")
    out = os.path.join(tmp, "bending")
    r = run(rve, os.path.join(shipped, "saleme2016", "bending.toml"), "-o", out, "--quiet", "--set", "output.frames=0")
    need(r.returncode == 0, f"bending: {r.stderr}")
    bursts = json.load(open(os.path.join(out, "summary.json")))["bursts"]
    need(bursts["first"]["y_m"] < 1e-3 and 5.5e-3 < bursts["first"]["x_m"] < 14.5e-3 and bursts["last"]["y_m"] > 2.4e-3,
         f"bending: {bursts['first']}, {bursts['last']}")
    out = os.path.join(tmp, "stack")
    r = run(rve, os.path.join(shipped, "saleme2016", "drop.toml"), "-o", out, "--quiet",
            *settings(["packing.box=[1.1e-3, 1.3e-3, 3e-3]", "loading.duration=0.11", "output.frames=0"]))
    need(r.returncode == 0, f"stack: {r.stderr}")
    need(
        max(abs(x["energy_error"]) for x in numbers(out)) < 0.02 and numbers(out)[-1]["damping_J"] > 0, "stack: energy")


with tempfile.TemporaryDirectory() as folder:
    thesis(folder)
    crush(folder)
    gate(folder)
    disc(folder)
    fresh_faces(folder)
    if bvp:
        block(folder)
print("cleavage:", len(faults), "faults")
sys.exit(bool(faults))
