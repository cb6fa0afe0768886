#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What each key does to the curve: plots.py BIN [sand|rock]. Runs the scenes that grus-rve --new writes, one key
changed at a time, and draws them into images/; grey: three seeds of the scene as it is. Some minutes of one core."""
import csv
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

BIN = os.path.abspath(sys.argv[1])
IMAGES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "images")
SAND, ROCK = "material.sand.", "material.rock."
STRENGTH = SAND + "fracture.hoek_brown.compressive_strength"
# Scene, what is set for all, x and y (column, factor, label), logarithmic in x, panels: key and its other values.
OEDOMETER = ("oedometer", [STRENGTH + '="150 MPa"', 'loading.final_stress="60 MPa"', 'output.frames=0'],
             ("axial_stress_Pa", 1e-6, "axial stress (MPa)"), ("void_ratio", 1, "void ratio"), True,
             [(STRENGTH, ['"75 MPa"', '"300 MPa"']), (SAND + "fracture.weibull.modulus", ["1.5", "8"]),
              ("preparation.friction", ["0.02", "0.5"])])
TRIAXIAL = ("triaxial", ['packing.box=["3.6 mm", "3.6 mm", "3.6 mm"]', 'output.frames=0'],
            ("axial_strain", 100, "axial strain (%)"), ("axial_stress_Pa", 1e-6, "axial stress (MPa)"), False,
            [(SAND + "friction", ["0.2", "0.8"]), (SAND + "rolling_friction", ["0.1", "0.3"]),
             (SAND + "youngs_modulus", ['"10 GPa"', '"100 GPa"'])])
BONDED = ("bonded", ["loading.final_strain=0.006", "output.frames=0"],
          ("axial_strain", 100, "axial strain (%)"), ("nominal_stress_Pa", 1e-6, "axial stress (MPa)"), False,
          [(ROCK + "bond.modulus", ['"10 GPa"', '"40 GPa"']), (ROCK + "bond.tension", ['"3 MPa"', '"12 MPa"']),
           (ROCK + "bond.cohesion", ['"9 MPa"', '"27 MPa"']),
           (ROCK + "bond.fracture_energy", ['"5 J/m^2"', '"60 J/m^2"']),
           (ROCK + "bond.friction_angle", ['"0 deg"', '"45 deg"']), ("packing.cells", ["60", "500"])])


def run(folder, scene, name, settings):
    out = os.path.join(folder, name)
    told = subprocess.run([f"{BIN}/grus-rve", os.path.join(folder, scene + ".toml"), "-o", out, "--quiet",
                           "--threads", "1", *(part for s in settings for part in ("--set", s))],
                          capture_output=True, text=True)
    if told.returncode not in (0, 3):
        sys.exit(f"{name}: {told.stderr}")
    with open(os.path.join(out, "history.csv"), newline="") as f:
        return list(csv.DictReader(f))


def draw(axis, rows, x, y, **style):
    axis.plot([float(r[x[0]]) * x[1] for r in rows], [float(r[y[0]]) * y[1] for r in rows], **style)


def rows_of_panels(folder, pool, axes, scene, common, x, y, log, panels):
    """Draws the panels of one scene; prints the largest y of each curve, or the last where it falls with x."""
    subprocess.run([f"{BIN}/grus-rve", "--new", scene], cwd=folder, check=True, capture_output=True)
    jobs = {(None, f"{n}"): pool.submit(run, folder, scene, f"{scene}_{n}", [*common, f"packing.seed={n}"])
            for n in (1, 2, 3)}
    for k, (key, values) in enumerate(panels):
        for n, value in enumerate(values):
            jobs[key, value] = pool.submit(run, folder, scene, f"{scene}_{k}_{n}", [*common, f"{key}={value}"])
    done = {of: job.result() for of, job in jobs.items()}
    for of, rows in done.items():
        last = [float(r[y[0]]) * y[1] for r in rows]
        print(scene, *of, f"largest {max(last):.4g}, last {last[-1]:.4g}")
    for axis, (key, values) in zip(axes, panels):
        for seed in ("1", "2", "3"):
            draw(axis, done[None, seed], x, y, color="0.6", lw=2.2 if seed == "1" else 1,
                 label="as it is, 3 seeds" if seed == "1" else None)
        for value, colour in zip(values, ("tab:blue", "tab:red")):
            draw(axis, done[key, value], x, y, color=colour, lw=1.4, label=value.strip('"'))
        axis.set_title(".".join(key.split(".")[2 if key.startswith("material") else 0:]), fontsize=10)
        axis.set_xlabel(x[2]), axis.set_ylabel(y[2]), axis.grid(alpha=0.3), axis.legend(fontsize=8)
        if log:
            axis.set_xscale("log")


def figure(name, *scenes):
    picture, axes = plt.subplots(2, 3, figsize=(11, 6.8))
    axes = list(axes.flat)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(1) as pool:
        for scene in scenes:
            rows_of_panels(folder, pool, axes, *scene)
            axes = axes[len(scene[-1]):]
    picture.tight_layout()
    os.makedirs(IMAGES, exist_ok=True)
    picture.savefig(os.path.join(IMAGES, name + ".png"), dpi=100)


asked = sys.argv[2:] or ["sand", "rock"]
if "sand" in asked:
    figure("sand_keys", OEDOMETER, TRIAXIAL)
if "rock" in asked:
    figure("rock_keys", BONDED)
