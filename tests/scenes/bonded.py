#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bonded polyhedra through the programs: bonded.py BIN"""
import json
import os
import sys
import tempfile

import scene_tools
from scene_tools import faults, history, need, run, shipped

binaries = os.path.abspath(sys.argv[1])
rve, bvp = scene_tools.program(binaries, "grus-rve"), scene_tools.program(binaries, "grus-bvp")
YOUNGS, POISSON = 20e9, 0.2
CONFINED, LATERAL = YOUNGS * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)), POISSON / (1 - POISSON)


def numbers(out):
    return [{k: float(v) for k, v in row.items()} for row in history(out)]


def cell(tmp):
    """A periodic cell has the moduli that its scene asks for, and tells its work."""
    out = os.path.join(tmp, "cell")
    r = run(rve, os.path.join(shipped, "rock_cell.toml"), "-o", out, "--quiet", "--set", "loading.final_strain=0.001")
    need(r.returncode == 0, f"cell: {r.stderr}")
    last = numbers(out)[-1]
    modulus, lateral = last["axial_stress_Pa"] / last["axial_strain"], last["stress_xx_Pa"] / last["stress_zz_Pa"]
    # The table of moduli is of 512 cells: 1.5 % for another mesh, and as much for one of 125.
    need(abs(modulus / CONFINED - 1) < 0.03, f"cell: {modulus / 1e9:.2f} GPa instead of {CONFINED / 1e9:.2f}")
    need(abs(lateral - LATERAL) < 0.02, f"cell: lateral ratio {lateral:.3f} instead of {LATERAL:.3f}")
    need(
        abs(last["energy_error"]) < 1e-6 and last["bonds_damaged"] == 0,
        f"cell: energy error {last['energy_error']}, {last['bonds_damaged']} bonds damaged")
    need(abs(last["bond_J"] / last["work_J"] - 1) < 1e-3, "cell: its work is not in its bonds")
    return modulus


def disc(tmp):
    """A disc between platens splits into two halves and little else; the same on two threads."""
    texts = []
    for threads in ("1", "2"):
        out = os.path.join(tmp, "disc" + threads)
        r = run(rve, os.path.join(shipped, "brazilian_disc.toml"), "-o", out, "--quiet", "--threads", threads, "--set",
                "packing.cells=300", "--set", "loading.strain_rate=2", "--set", "output.frames=1")
        need(r.returncode == 0, f"disc: {r.stderr}")
        texts.append(open(os.path.join(out, "history.csv")).read())
    need(texts[0] == texts[1], "disc: one thread and two differ")
    rows, sizes = numbers(out), json.load(open(os.path.join(out, "summary.json")))["cells"]["fragments"]
    peak = max(x["nominal_stress_Pa"] for x in rows)
    # Half of what a face bears for brittle bonds (independent assembly: 0.45 to 0.54), all of it for ductile ones.
    need(0.45 * 6e6 < peak < 6e6, f"disc: nominal tension {peak / 1e6:.2f} MPa of 6 MPa")
    need(sizes[0] < 0.65 * 300 and sizes[1] > 0.25 * 300 and sizes[0] + sizes[1] > 0.75 * 300,
         f"disc: fragments {sizes}")
    need(rows[-1]["nominal_stress_Pa"] < 0.5 * peak, "disc: it still bears the load")
    need(
        max(abs(x["energy_error"]) for x in rows) < 0.01,
        f"disc: energy error {max(abs(x['energy_error']) for x in rows)}")
    need(rows[-1]["bonds"] + rows[-1]["bonds_broken"] == rows[0]["bonds"], "disc: bonds are lost silently")
    # Before anything breaks the work of the platens is in cells, bonds and damping.
    told(out, rows, peak)
    whole = [x for x in rows if x["bonds_damaged"] == 0][-1]
    need(
        abs(whole["load_N"] * whole["displacement_m"] / (2 * whole["work_J"]) - 1) < 0.1,
        "disc: work is not half of load times way while all is elastic")


def told(out, rows, peak):
    """What the report says of a disc: a stack of energies in which each is once, nominal stress, broken bonds."""
    sys.path.insert(0, os.path.join(binaries, "..", "python"))
    from grus.report.rve_plots import stacked
    start = json.load(open(os.path.join(out, "summary.json")))["energy"]["start_J"]
    parts = stacked({k: [x[k] for x in rows] for k in rows[0]})
    for x in rows:
        top, put_in = sum(x[p] for p in parts), x["work_J"] + start
        need(
            abs(top - put_in) <= 1.01 * abs(x["energy_error"]) * max(put_in, top) + 1e-9 * top,
            f"disc: the stack of energies is {top} J of {put_in} J")
    r = run(scene_tools.program(binaries, "grus-report"), out)
    need(
        f"{rows[-1]['bonds_broken']:.0f} bonds" in r.stdout and f"{peak / 1e6:.4g} MPa" in r.stdout
        and " 0 grains" not in r.stdout, f"disc: the report says {r.stdout}")


def block(tmp, modulus):
    """The same cell at the points of a block: the same modulus."""
    out = os.path.join(tmp, "block")
    r = run(bvp, os.path.join(shipped, "rock_block.toml"), "-o", out, "--quiet")
    need(r.returncode == 0, f"block: {r.stderr}")
    last = numbers(out)[-1]
    need(
        abs(last["mean_stress_zz_Pa"] / last["mean_strain_zz"] / modulus - 1) < 0.005,
        f"block: {last['mean_stress_zz_Pa'] / last['mean_strain_zz'] / 1e9:.3f} GPa, its cell {modulus / 1e9:.3f}")
    devices = json.load(open(os.path.join(out, "summary.json")))["errors"]["devices"]
    need(devices["bond_damping_of_cells"] == 0, f"block: devices {devices} without dashpots")
    r = run(bvp, os.path.join(shipped, "rock_block.toml"), "-o", out, "--quiet", "--force", "--set",
            "rve.set=['material.rock.bond.damping=0.2']", "--set", "solve.increments=1")
    need(r.returncode == 0, f"block with dashpots: {r.stderr}")
    devices = json.load(open(os.path.join(out, "summary.json")))["errors"]["devices"]
    need(0 < devices["bond_damping_of_cells"] < 0.5, f"block with dashpots: devices {devices}")
    # Torn in four increments the work of the stresses is not told by its rows, and that is said.
    torn = "material.rock.bond={modulus=2e10, criterion='parallel', tension=6e6, shear=18e6, damping=0.3}"
    r = run(bvp, os.path.join(shipped, "rock_block.toml"), "-o", out, "--quiet", "--force",
            "--set", "boundary.0.displacement=['free', 'free', '0.02 mm']", "--set",
            f"rve.set=['packing.cells=64', 'packing.box=[4e-3, 4e-3, 4e-3]', \"{torn}\"]")
    need(r.returncode == 0, f"torn block: {r.stderr}")
    told = json.load(open(os.path.join(out, "summary.json")))
    off = [n for n in told["notes"] if "balance of energy is off" in n]
    need(abs(numbers(out)[-1]["energy_error"]) > 0.05 and len(off) == 1, f"torn block: notes {told['notes']}")


def beam(tmp):
    """Cells are torn at the points of a notched beam: the tip's stress has had its peak, the beam softens, forces and
    works balance."""
    out = os.path.join(tmp, "beam")
    r = run(bvp, os.path.join(shipped, "rock_beam.toml"), "-o", out, "--quiet", "--threads", "2", "--set",
            "boundary.1.displacement=['free', '-0.024 mm']", "--set", "solve.increments=6")
    need(r.returncode == 0, f"beam: {r.stderr}")
    rows = numbers(out)
    last, tip = rows[-1], [x["probe_tip_stress_xx_Pa"] for x in rows]
    need(5.5e6 < max(tip) < 7.5e6 and tip[-1] < 0.8 * max(tip), f"beam: stress at the tip {tip}, bonds bear 6 MPa")
    stiffness = [x["reaction_support_y_N"] / -x["moved_load_y_m"] for x in rows]
    need(stiffness[-1] < 0.8 * stiffness[0], f"beam: {stiffness[-1] / stiffness[0]:.2f} of its first stiffness is left")
    need(
        abs(last["reaction_support_y_N"] + last["reaction_load_y_N"]) < 5e-3 * last["reaction_support_y_N"],
        "beam: load and support differ")
    regions = last["macro_internal_J"] - last["rve_work_J"]
    stresses, load = last["macro_work_J"], last["macro_external_J"]
    need(abs(last["rve_work_J"] / (stresses - regions) - 1) < 0.05, "beam: the cells' work is not the stresses'")
    need(abs(last["energy_error"]) < 0.05, f"beam: energy error {last['energy_error']}")
    need(abs(load / stresses - 1) < 0.01, f"beam: the load does {load} J, the stresses {stresses} J")


def angular(tmp):
    """Angular grains without bonds: on one thread and two the same; their shape is told."""
    test = [
        "--quiet", "--set", "packing.box=[6e-3, 6e-3, 6e-3]", "--set", "preparation.pressure=2e5", "--set",
        "loading.confining_pressure=2e5", "--set", "loading.strain_rate=60", "--set", "loading.final_strain=0.06"
    ]
    texts, shape = [], {}
    for name, more in (("1", []), ("2", []),
                       ("round", ["--set", "packing.hulls.relax=30", "--set", "packing.hulls.aspect=[1, 1, 1]"])):
        out = os.path.join(tmp, "angular" + name)
        r = run(rve, os.path.join(shipped, "angular_rve.toml"), "-o", out, "--threads", name if name == "2" else "1",
                *test, *more)
        need(r.returncode == 0, f"angular {name}: {r.stderr}")
        texts.append(open(os.path.join(out, "history.csv")).read())
        rows, told = numbers(out), json.load(open(os.path.join(out, "summary.json")))
        need(
            max(abs(x["energy_error"]) for x in rows) < 2e-3,
            f"angular {name}: energy error {max(abs(x['energy_error']) for x in rows)}")
        need(told["counts"]["bonds_broken"] == 0 and "cells" not in told, f"angular {name}: bonds where there are none")
        volume = told["mass"]["grains_kg"] / 2650
        need(abs(volume / 0.14 / 6e-3**3 - 1) < 1e-6, f"angular {name}: {volume / 6e-3**3:.4f} of the box is solid")
        need(
            abs(rows[0]["sphericity"] - told["shape"]["sphericity"]) < 1e-8
            and abs(rows[0]["angularity"] - told["shape"]["angularity"]) < 1e-8,
            f"angular {name}: history and summary differ")
        shape[name] = told["shape"]
    need(texts[0] == texts[1], "angular: one thread and two differ")
    need(shape["round"]["angularity"] < 0.8 * shape["1"]["angularity"], f"angular: {shape}")
    need(shape["round"]["sphericity"] > shape["1"]["sphericity"] + 0.05, f"angular: {shape}")


def angular_block(tmp):
    """The same grains at the points of a block."""
    out = os.path.join(tmp, "angular_block")
    scene = os.path.join(tmp, "angular_cell.toml")
    with open(os.path.join(shipped, "angular_rve.toml")) as f:
        text = f.read()
    with open(scene, "w") as f:
        f.write(text.replace("8 mm", "6 mm"))
    r = run(bvp, os.path.join(shipped, "rock_block.toml"), "-o", out, "--quiet", "--threads", "2", "--set",
            f"rve.scene='{scene}'", "--set", "boundary.0.displacement=['free', 'free', '-0.2 mm']")
    need(r.returncode == 0, f"angular block: {r.stderr}")
    last = numbers(out)[-1]
    need(
        abs(last["mean_strain_zz"] + 0.01) < 1e-9 and -1e6 < last["mean_stress_zz_Pa"] < -1.5e5,
        f"angular block: {last['mean_strain_zz']}, {last['mean_stress_zz_Pa']}")


with tempfile.TemporaryDirectory() as folder:
    angular(folder)
    if bvp:
        angular_block(folder)
    found = cell(folder)
    disc(folder)
    if bvp:
        block(folder, found)
        beam(folder)
print("bonded:", len(faults), "faults")
sys.exit(bool(faults))
