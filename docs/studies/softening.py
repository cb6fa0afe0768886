#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Softening with and without a length: softening.py RESULTS [meshes|study|bodies]... [--jobs N]. Runs the biaxial scene
over meshes, lengths, memories and packings, the block and the footing with and without a length, and writes
softening.csv beside this file. Runs that RESULTS holds are not repeated. grus must be importable. Some two hours of a
core in all."""
import argparse
import concurrent.futures
import csv
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import PolyCollection  # noqa: E402

import grus  # noqa: E402
from grus.bands import shear_strain  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = os.path.join(HERE, "..", "..", "apps", "scenes")
SCENE = {"block": "triaxial_block.toml", "footing": "strip_footing.toml"}
HEIGHT = 0.1
BANDS = ((0.045, 0.06), (0.08, 0.095))  # strains between which widths are read
STRESSES = (0.04, 0.06, 0.095)          # each the mean over 0.4 % of strain


def biaxial(cells, box, length, memory=0.002, seed=1, strain=0.1):
    """Settings of the biaxial scene: a dense sample in each RVE, a frame each 0.25 % of strain."""
    rve = [f"packing.box=[{box},{box},{box}]", "numerics.max_overlap=0.3", "preparation.friction=0",
           f"packing.seed={seed}"]
    found = {"mesh.box.cells": list(cells), "rve.set": rve, "output.frames": round(strain / 0.0025) + 1}
    if strain != 0.1:
        found["boundary.1.displacement"] = [0, -strain * HEIGHT]
    if length:
        found |= {"regularisation.length": length, "regularisation.memory": memory}
    return found


def cases():
    """part -> {name: settings}."""
    meshes, study = {}, {}
    for cells in ((16, 32), (12, 24), (8, 16)):
        for length, seed in ((0.003, 1), (0.003, 2), (0, 1)):
            meshes[f"meshes {cells[0]}x{cells[1]} l {1e3 * length:g} seed {seed}"] = biaxial(
                cells, 0.0516, length, seed=seed)
    ways = [(0, 0.002), (0.003, 0.002), (0.0015, 0.002), (0.006, 0.002), (0.003, 0.001), (0.003, 0.004)]
    for length, memory in ways:
        for seed in (1, 2) if (length, memory) in ways[:2] else (1,):  # what else scatters like these
            for cells in ((8, 16), (12, 24)):
                name = f"study {cells[0]}x{cells[1]} l {1e3 * length:g} memory {memory:g} seed {seed}"
                study[name] = biaxial(cells, 0.04, length, memory, seed, 0.08)
    return {"meshes": meshes, "study": study, "bodies": bodies()}


def bodies():
    """The block in three dimensions, and the footing, with and without a length."""
    found = {}
    for cells in ((6, 6, 12), (4, 4, 8)):
        for length in (0.006, 0):
            name = f"block {'x'.join(map(str, cells))} l {1e3 * length:g}"
            found[name] = biaxial(cells, 0.04, length) | {"boundary.1.displacement": [0, 0, -0.08 * HEIGHT],
                                                          "output.frames": 33}
    for length in (0, 0.02, 0.04):
        found[f"footing l {1e3 * length:g}"] = {"regularisation.length": length} if length else {}
    return found


def done(results, name, settings):
    """The run of these settings, made where it is not there; its CPU time in seconds beside it."""
    folder = os.path.join(results, name.replace(" ", "_"))
    try:
        run = grus.load(folder)
        if run.status in (0, 3):  # not of one that was interrupted
            return run
    except grus.InputError:
        pass
    scene = grus.read_scene(os.path.join(SCENES, SCENE.get(name.split()[0], "biaxial_plane_strain.toml")), settings)
    run = grus.run(scene, out=folder, threads=1, check=False, force=True)
    print(f"{name}: {run.summary['ending']}", flush=True)
    return run


def near(x, y, at, half):
    """Mean of y where x is within `half` of `at`."""
    here = np.abs(x - at) <= half
    return float(y[here].mean()) if here.any() else np.nan


def told(run, name):
    """A row of the table: stresses in kPa, widths in mm, parts of the body that shear."""
    if name.startswith("footing"):
        return told_of_footing(run, name)
    axis, area = ("z", 0.0025) if name.startswith("block") else ("y", 0.05)
    strain = np.abs(run[f"moved_top_{axis}_m"]) / HEIGHT
    stress = np.abs(run[f"reaction_top_{axis}_N"]) / area / 1e3
    row = {"case": name, "peak_kPa": stress.max()}
    for at in STRESSES:
        row[f"stress_{100 * at:g}_kPa"] = near(strain, stress, at, 0.002)
    for first, last in BANDS if strain.max() > 0.09 else (*BANDS[:1], (0.065, 0.08)):
        if strain.max() < last - 1e-3:
            continue
        band = run.shear_band(round(first / 0.0025), round(last / 0.0025))
        label = f"{100 * first:g}_{100 * last:g}"
        row |= {f"width_{label}_mm": 1e3 * band.width, f"angle_{label}": band.angle, f"fraction_{label}": band.fraction}
    return row | ending(run)


def told_of_footing(run, name):
    """Both halves of a strip, kN/m, at quarters of its way; the part of the ground that shears in the last tenth."""
    moved, force = np.abs(run["moved_footing_y_m"]), 2e-3 * np.abs(run["reaction_footing_y_N"])
    ways = (0.01, 0.02, 0.03, 0.039)
    row = {"case": name} | {f"force_{1e3 * at:g}_mm_kN": near(moved, force, at, 5e-4) for at in ways}
    return row | {"fraction": run.shear_band(-2).fraction} | ending(run)


def ending(run):
    given = (run["regularisation_J"] / run["macro_external_J"])[-1] if "regularisation_J" in run else 0.0
    return {"energy_error": np.abs(run["energy_error"]).max(), "regularisation_over_work": float(given),
            "given_up": run.summary["counts"]["rves_given_up"],
            "cpu_s": run.summary["seconds"]["cpu_rank0"], "ending": run.summary["ending"]}


def drawn(runs):
    """The shear strain of the second pair of strains, in each element, without a length above and with one below."""
    figure, axes = plt.subplots(2, 3, figsize=(7.2, 8.4), layout="constrained")
    for (name, run), axis in zip(runs.items(), axes.T[::-1, ::-1].flat):
        first, last = (run.macro(round(at / 0.0025)) for at in BANDS[1])
        shape = first.points[first.connectivity].reshape(-1, 4, 3)[:, :, :2] * 1e3
        cells = PolyCollection(shape, array=shear_strain(first, last), cmap="magma_r", edgecolors="face")
        cells.set_clim(0, 0.3)
        axis.add_collection(cells)
        axis.set(xlim=(0, 50), ylim=(0, 100), aspect="equal", xticks=[], yticks=[])
        _, cells_of, _, length, *_ = name.split()
        told_length = f"{length} mm" if length != "0" else "no length"
        axis.set_title(f"{cells_of.replace('x', ' x ')}, {told_length}", fontsize=9)
    figure.colorbar(cells, ax=axes, shrink=0.5, label="shear strain, 8 to 9.5 %")
    figure.savefig(os.path.join(HERE, "..", "images", "softening.png"), dpi=90)


def written(rows, name):
    columns = list(dict.fromkeys(k for row in rows for k in row))
    with open(os.path.join(HERE, name + ".csv"), "w", newline="") as f:
        out = csv.DictWriter(f, columns)
        out.writeheader()
        out.writerows({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results")
    parser.add_argument("parts", nargs="*", choices=[*cases(), []])
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    asked = {name: settings for part, some in cases().items() if part in (options.parts or cases())
             for name, settings in some.items()}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = {name: pool.submit(done, options.results, name, settings) for name, settings in asked.items()}
        runs = {name: job.result() for name, job in jobs.items()}
    rows = [told(run, name) for name, run in runs.items()]
    written(rows, "softening")
    if meshes := {name: run for name, run in runs.items() if name.startswith("meshes") and name.endswith("seed 1")}:
        drawn(meshes)
    for row in rows:
        print(*(f"{k} {v:.4g}" if isinstance(v, float) else f"{v}" for k, v in row.items()), sep="  ")


if __name__ == "__main__":
    main()
