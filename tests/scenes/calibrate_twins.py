#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-calibrate on twins: data that the program itself has made with known values. calibrate_twins.py smooth|triaxial
BIN"""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

case, binaries = sys.argv[1], os.path.abspath(sys.argv[2])
faults = []

CUBIC = """title = "Simple-cubic cell of spheres that do not slide, compressed and sheared"
[material.sand]
density = "2650 kg/m^3"
youngs_modulus = "400 MPa"
poissons_ratio = 0.2
friction = 50
restitution = 0.5
damping = 0.5
[packing]
kind = "simple-cubic"
radius = { distribution = "constant", mean = "0.5 mm" }
layers = [3, 3, 3]
[boundary]
kind = "periodic"
[loading]
kind = "velocity-gradient"
velocity_gradient = [[-1, 0, 1], [0, -1, 0], [0, 0, -1]]
duration = "2 ms"
[output]
history_interval = "0.04 ms"
"""

TRIAXIAL = """title = "Triaxial test of a periodic cell of some 135 spheres"
[material.sand]
density = "2650 kg/m^3"
youngs_modulus = "400 MPa"
poissons_ratio = 0.2
friction = 0.35
restitution = 0.5
damping = 0.3
[packing]
kind = "random"
box = ["5 mm", "5 mm", "5 mm"]
radius = { distribution = "uniform", min = "0.35 mm", max = "0.65 mm" }
solid_fraction = 0.6
[boundary]
kind = "periodic"
[preparation]
pressure = "200 kPa"
friction = 0.1
[loading]
kind = "triaxial"
axis = "z"
strain_rate = "5 1/s"
confining_pressure = "200 kPa"
final_strain = 0.05
[output]
history_interval = 0.0002
"""


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


def rows_of(scene, out, *settings):
    r = subprocess.run([os.path.join(binaries, "grus-rve"), scene, "-o", out, "--quiet"] +
                       [a for s in settings for a in ("--set", s)], capture_output=True, text=True)
    need(r.returncode == 0, r.stderr)
    with open(os.path.join(out, "history.csv"), newline="") as f:
        return [{k: float(v) if v else math.nan for k, v in row.items()} for row in csv.DictReader(f)]


def data(path, x, y, points):
    with open(path, "w") as f:
        f.write(f"{x},{y}\n" + "".join(f"{a!r},{b!r}\n" for a, b in points))


def calibrated(tmp, text):
    path, out = os.path.join(tmp, "calibration.toml"), os.path.join(tmp, "out")
    with open(path, "w") as f:
        f.write(text)
    r = subprocess.run([os.path.join(binaries, "grus-calibrate"), path, "-o", out, "--quiet"], capture_output=True,
                       text=True)
    need(r.returncode == 0, f"grus-calibrate: exit {r.returncode} {r.stderr}")
    print(r.stdout.strip())
    with open(os.path.join(out, "calibration.json")) as f:
        return {p["key"].split(".")[-1]: p for p in json.load(f)["parameters"]}


def smooth(tmp):
    """Hertz along z gives E / (1 - nu^2), Mindlin across it their ratio: both back to half a per cent, by POUNDERS."""
    scene = os.path.join(tmp, "cubic.toml")
    with open(scene, "w") as f:
        f.write(CUBIC)
    rows = rows_of(scene, os.path.join(tmp, "data"))[10::5]
    for quantity in ("stress_zz_Pa", "stress_xz_Pa"):
        data(os.path.join(tmp, quantity + ".csv"), "time_s", quantity, [(r["time_s"], r[quantity]) for r in rows])
    found = calibrated(tmp, """[calibrate]
scene = "cubic.toml"
method = "pounders"
budget = 40
seeds = [1]
seed_key = "numerics.estimate_every"
parameters = [
  { key = "material.sand.youngs_modulus", min = "200 MPa", max = "900 MPa", scale = "log" },
  { key = "material.sand.poissons_ratio", min = 0.05, max = 0.45 } ]
targets = [
  { name = "axial", data = "stress_zz_Pa.csv", x = "time_s", y = "stress_zz_Pa", error = 100 },
  { name = "shear", data = "stress_xz_Pa.csv", x = "time_s", y = "stress_xz_Pa", error = 100 } ]
""")
    for key, truth in (("youngs_modulus", 400.0), ("poissons_ratio", 0.2)):
        need(
            abs(found[key]["value"] / truth - 1) < 0.005 and found[key]["verdict"] == "identified",
            f"{key}: {found[key]['value']} of {truth}, {found[key]['verdict']}")


def triaxial(tmp):
    """E and friction from three specimens, by eight others: within two deviations, and a tenth of the range."""
    scene = os.path.join(tmp, "triaxial.toml")
    with open(scene, "w") as f:
        f.write(TRIAXIAL)
    specimens = [rows_of(scene, os.path.join(tmp, f"data{seed}"), f"packing.seed={seed}") for seed in (11, 12, 13)]
    for quantity in ("axial_stress_Pa", "void_ratio"):
        means = [(s, sum(min(rows, key=lambda r: abs(r["axial_strain"] - s))[quantity] for rows in specimens) / 3)
                 for s in (0.004 * k for k in range(1, 13))]
        data(os.path.join(tmp, quantity + ".csv"), "axial_strain", quantity, means)
    found = calibrated(
        tmp, """[calibrate]
scene = "triaxial.toml"
budget = 200
seeds = [1, 2, 3, 4, 5, 6, 7, 8]
parameters = [
  { key = "material.sand.youngs_modulus", min = "100 MPa", max = "1600 MPa", scale = "log" },
  { key = "material.sand.friction", min = 0.1, max = 0.8 } ]
targets = [
  { name = "stress", data = "axial_stress_Pa.csv", x = "axial_strain", y = "axial_stress_Pa", error = 2e3, \
specimens = 3 },
  { name = "void ratio", data = "void_ratio.csv", x = "axial_strain", y = "void_ratio", error = 1e-3, specimens = 3 } ]
""")
    for key, truth, place in (("youngs_modulus", 400.0, lambda v: math.log(v / 100) / math.log(16)),
                              ("friction", 0.35, lambda v: (v - 0.1) / 0.7)):
        p = found[key]
        off = abs(place(p["value"]) - place(truth))
        need(p["verdict"] == "identified" and off < 2 * p["sd_of_range"] and off < 0.1,
             f"{key}: {p['value']} +- {p['sd']} of {truth}, {p['verdict']}")


with tempfile.TemporaryDirectory() as tmp:
    {"smooth": smooth, "triaxial": triaxial}[case](tmp)
print(f"calibrate {case}: {len(faults)} faults")
sys.exit(bool(faults))
