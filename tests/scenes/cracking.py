#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grains that break by peridynamics through the programs: cracking.py BIN"""
import json
import os
import sys
import tempfile

from scipy.spatial import ConvexHull

import scene_tools
from scene_tools import faults, history, need, run, shipped
from values_tools import Frame

binaries = os.path.abspath(sys.argv[1])
rve = scene_tools.program(binaries, "grus-rve")
OEDOMETER = os.path.join(shipped, "zhu2019", "oedometer_60.toml")
COUNTS = ("pd_tests", "pd_holds", "pd_cracks", "pd_stalled")


def numbers(out):
    return [{k: float(v) for k, v in row.items()} for row in history(out)]


def oedometer(tmp):
    """Some sixty grains in an oedometer: they are tested, hold or crack; mass and energy are kept, and one thread and
    two write the same."""
    texts = []
    for threads in ("2", "1"):
        out = os.path.join(tmp, "threads" + threads)
        r = run(rve, OEDOMETER, "-o", out, "--quiet", "--threads", threads, "--set", "loading.final_stress=5 MPa")
        need(r.returncode == 0, f"oedometer: {r.stderr}")
        texts.append(open(os.path.join(out, "history.csv")).read())
    need(texts[0] == texts[1], "oedometer: one thread and two differ")
    rows, told = numbers(out), json.load(open(os.path.join(out, "summary.json")))
    last = rows[-1]
    need(last["pd_cracks"] == last["breakages"] >= 5, f"oedometer: {last['breakages']} breakages")
    need(last["grains"] - rows[0]["grains"] >= last["breakages"], "oedometer: fewer pieces than cracks make")
    need(last["pd_tests"] == last["pd_holds"] + last["pd_cracks"] + last["pd_stalled"], f"oedometer: {last}")
    need(last["pd_holds"] > 0 and last["pd_stalled"] < 0.35 * last["pd_tests"], "oedometer: tests")
    need(all(b[k] >= a[k] for a, b in zip(rows, rows[1:]) for k in COUNTS), "oedometer: counts fall")
    need(abs(told["mass"]["lost_kg"]) < 1e-12 * told["mass"]["start_kg"], f"oedometer: {told['mass']}")
    worst = max(abs(x["energy_error"]) for x in rows)
    need(worst < 1e-2, f"oedometer: energy error {worst}")
    need(last["fragment_area_m2"] > 0 and last["bond_energy_J"] > 0, "oedometer: area and energy of bonds")


def between_platens(tmp):
    """A grain on a face between platens breaks near the strength of the paper's; the area of its pieces' fresh faces is
    what their surfaces have more than the grain's, and its bonds have given up one to six times the toughness of it."""
    out = os.path.join(tmp, "platens")
    r = run(rve, os.path.join(shipped, "zhu2019", "grain.toml"), "-o", out, "--quiet", "--set",
            "material.sand.fracture.points=500", "--set", "loading.final_strain=0.0058", "--set",
            "loading.strain_rate=1 1/s")
    need(r.returncode == 0, f"platens: {r.stderr}")
    rows = numbers(out)
    last, first = rows[-1], next((k for k, x in enumerate(rows) if x["breakages"] > 0), len(rows) - 1)
    need(last["pd_cracks"] == last["breakages"] > 0, f"platens: {last}")
    force = rows[first - 1]["axial_stress_Pa"] * (2e-3 * 0.951489973) ** 2
    need(150 < force < 260, f"platens: {force} N")
    with open(os.path.join(out, "grains.hdf.series")) as f:
        frames = [Frame(os.path.join(out, x["name"])).grains()["points"] for x in json.load(f)["files"]]
    surface = [sum(ConvexHull(points).area for points in frame) for frame in (frames[0], frames[-1])]
    need(len(frames[-1]) == last["grains"] > 1, f"platens: {len(frames[-1])} grains in the frame")
    fresh = last["fragment_area_m2"]
    need(abs(2 * fresh / (surface[1] - surface[0]) - 1) < 1e-3, f"platens: {surface}, fresh {fresh}")
    need(1 < last["bond_energy_J"] / (30 * fresh) < 6, f"platens: {last['bond_energy_J']} J of {fresh} m^2")


def sizes(tmp):
    """Griffith's law is a fall of strength with the square root of the diameter, told otherwise, and with Weibull's
    one that is added to its own; where two lengths could be meant, the scene is refused."""
    material = "material.sand.fracture."
    same = {"none": (["reference_diameter=1.5e-3", "weibull="],
                     ["weibull=", "scatter={variation=0,size_exponent=0.5,reference_diameter=1.5e-3}"]),
            "weibull": ([], ["weibull.size_exponent=1.467741935483871"])}
    for name, (griffith, plain) in same.items():
        texts = []
        for k, sets in enumerate((["size_law=griffith", *griffith], plain, griffith)):
            out = os.path.join(tmp, f"size_{name}_{k}")
            told = [x for s in sets + ["platen_strength=5e6"] if not s.startswith("reference") or k == 0
                    for x in ("--set", material + s)]
            r = run(rve, OEDOMETER, "-o", out, "--quiet", *told, "--set", "loading.final_stress=1 MPa")
            need(r.returncode == 0, f"sizes: {name} {k}: {r.stderr}")
            texts.append(open(os.path.join(out, "history.csv")).read())
        need(texts[0] == texts[1], f"sizes: {name}: Griffith's law and its exponent differ")
        need(texts[0] != texts[2], f"sizes: {name}: Griffith's law changes nothing")
    for sets, words in (("reference_diameter=1e-3", "twice weibull.reference_radius"),
                        ("weibull=", "reference_diameter")):
        r = run(rve, OEDOMETER, "--check", "--set", material + "size_law=griffith", "--set", material + sets)
        need(r.returncode == 2 and words in r.stderr and r.stderr.count("\n") == 1, f"sizes: {sets}: {r.stderr}")


def without(tmp):
    """A scene that does not name the model has no column of it."""
    out = os.path.join(tmp, "without")
    r = run(rve, OEDOMETER, "-o", out, "--quiet", "--set", "material.sand.fracture=", "--set",
            "loading.max_strain=1e-4")
    need(r.returncode in (0, 3), f"without: {r.stderr}")
    names = set(numbers(out)[0])
    need(not names & {*COUNTS, "fragment_area_m2", "bond_energy_J"}, f"without: {sorted(names)}")


with tempfile.TemporaryDirectory() as folder:
    between_platens(folder)
    oedometer(folder)
    sizes(folder)
    without(folder)
print("cracking:", len(faults), "faults")
sys.exit(bool(faults))
