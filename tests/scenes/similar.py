#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Similarity of crushing samples: grains, box, limit and inertia twice as large, at half the rate, and strengths of the
grains they stand for (loading.scale): strains, stresses, void ratios and events are the same. similar.py BIN"""
import csv
import json
import os
import subprocess
import sys
import tempfile

binaries = os.path.abspath(sys.argv[1])
SCENE = """[material.coke]
density = 1000
youngs_modulus = "0.858 GPa"
poissons_ratio = 0.3
friction = 0.4
damping = 0.05
[material.coke.fracture]
model = "apollonian-14"
contact_strength = {{ strength = "300 MPa", area = "angle", angle = "20 deg" }}
scatter = {{ variation = 1, reference_diameter = "2 mm", size_exponent = 1.5 }}
smallest_radius = {limit}
[packing]
kind = "random"
box = [{diameter}, {diameter}, {height}]
radius = {{ distribution = "uniform", min = "2.2 mm", max = "4.4 mm" }}
void_ratio = 0.8
[boundary]
kind = "cylinder"
friction = 0
[loading]
kind = "oedometric-stress"
strain_rate = {rate}
final_stress = "2 MPa"
max_strain = 0.25
scale = {scale}
[numerics]
inertia = {{ scaled_below = {inertia} }}
max_overlap = 4
[output]
history_interval = 0.005
"""
faults = 0


def history(folder, name, scale):
    scene = os.path.join(folder, name + ".toml")
    with open(scene, "w") as f:
        f.write(
            SCENE.format(scale=scale, limit=1.2e-3 * scale, diameter=0.04 * scale, height=0.03 * scale, rate=24 / scale,
                         inertia=4.4e-3 * scale))
    out = os.path.join(folder, name)
    done = subprocess.run([os.path.join(binaries, "grus-rve"), scene, "-o", out, "--threads", "1", "--quiet"],
                          capture_output=True, text=True, timeout=280)
    if done.returncode:
        sys.exit(f"FAULT {name}: {done.stderr}")
    with open(os.path.join(out, "history.csv")) as f:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]


with tempfile.TemporaryDirectory() as folder:
    one, two = (history(folder, f"times{scale}", scale) for scale in (1, 2))
    # Factors of two are exact, and draws the same: until twenty grains have broken, chaos has not raised what round-off
    # differs by.
    rows = next(k for k, row in enumerate(one) if row["breakages"] >= 20) + 1
    print(
        f"{rows} rows to {one[rows - 1]['breakages']:.0f} events, the first in row "
        f"{next(k for k, row in enumerate(one) if row['breakages'] > 0)}"
    )
    for k in ("axial_strain", "axial_stress_Pa", "void_ratio_all", "k0", "inertial_number", "breakages", "grains"):
        for row in range(1, rows):
            if abs(one[row][k] - two[row][k]) > 1e-6 * abs(one[row][k]):
                faults += 1
                print(f"FAULT row {row}: {k} {one[row][k]} and {two[row][k]}")
    for k, power in (("time_s", 1), ("work_J", 3), ("mass_lost_kg", 3)):
        if abs(two[rows - 1][k] / one[rows - 1][k] / 2**power - 1) > 1e-6:
            faults += 1
            print(f"FAULT {k} {one[rows - 1][k]} and {two[rows - 1][k]}")
    # What the devices took and put in is told, of the work.
    with open(os.path.join(folder, "times2", "summary.json")) as f:
        told = json.load(f)["errors"]
    last = two[-1]
    if abs(told["scaled_inertia"] - last["inertia_J"] /
           last["work_J"]) > 1e-6 or not 0 < told["local_damping"] < last["damping_J"] / last["work_J"] * (1 + 1e-6):
        faults += 1
        print(f"FAULT devices {told}, work {last['work_J']}, inertia {last['inertia_J']}, damping {last['damping_J']}")
print("similar:", faults, "faults")
sys.exit(faults > 0)
