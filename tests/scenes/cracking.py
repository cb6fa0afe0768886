#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grains that break by peridynamics through the programs: cracking.py BIN"""
import json
import os
import random
import sys
import tempfile
import time

import numpy as np
from scipy.spatial import ConvexHull, cKDTree

sys.path.insert(0, os.path.join(os.path.abspath(sys.argv[1]), "..", "python"))
from grus.frames import Frame as Points, frames  # noqa: E402

import scene_tools  # noqa: E402
from scene_tools import faults, history, kill_at_random, need, run, shipped  # noqa: E402
from values_tools import Frame  # noqa: E402

binaries = os.path.abspath(sys.argv[1])
rve = scene_tools.program(binaries, "grus-rve")
OEDOMETER = os.path.join(shipped, "zhu2019", "oedometer_60.toml")
COUNTS = ("pd_tests", "pd_holds", "pd_cracks", "pd_stalled")


def numbers(out):
    return [{k: float(v) for k, v in row.items()} for row in history(out)]


def bodies(out):
    """Corners of each grain's triangles, frame by frame."""
    return [Frame(path).grains()["points"] for path, _ in frames(out, "grains")]


def written(out):
    """Bytes of the rows and of the points of cracked grains."""
    lattice = os.path.join(out, "lattice")
    names = ["history.csv", "lattice.hdf.series", *(os.path.join("lattice", x) for x in sorted(os.listdir(lattice)))]
    return {name: open(os.path.join(out, name), "rb").read() for name in names}


def oedometer(tmp):
    """Some sixty grains in an oedometer: they are tested, hold or crack; mass and energy are kept; one thread and two
    write the same, and so does a run that is killed time and again."""
    settings = [a for s in ("loading.final_stress=5 MPa", "output.lattice=4", "output.checkpoint_interval=0.3")
                for a in ("--set", s)]
    for threads in ("2", "1"):
        out, begin = os.path.join(tmp, "threads" + threads), time.time()
        r = run(rve, OEDOMETER, "-o", out, "--quiet", "--threads", threads, *settings)
        need(r.returncode == 0, f"oedometer: {r.stderr}")
    need(written(out) == written(os.path.join(tmp, "threads2")), "oedometer: one thread and two differ")
    need(len(written(out)) == 6, "oedometer: points of four grains")
    # Killed wherever it is, in the midst of tests as well, and gone on with another number of threads.
    part, within, seed = os.path.join(tmp, "part"), 0.15 * (time.time() - begin), random.randrange(1 << 30)
    kept = os.path.join(part, "checkpoint.h5")
    command = [rve, OEDOMETER, "-o", part, "--quiet", *settings]
    killed = kill_at_random(lambda k: [*command, "--threads", str(1 + k % 2)] + (["--resume"] if k else []),
                            lambda: os.path.exists(kept), 5, random.Random(seed), within)
    need(killed >= 3, f"oedometer: killed {killed} times before the end (seed {seed})")
    r = run(*command, "--threads", "2", "--resume")
    need(r.returncode == 0, f"oedometer: resumed: {r.stderr}")
    need(written(part) == written(out), f"oedometer: killed and resumed it differs (seed {seed})")
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
            "material.sand.fracture.points=500", "--set", "loading.final_strain=0.0055", "--set",
            "loading.strain_rate=1 1/s", "--set", "output.lattice=2")
    need(r.returncode == 0, f"platens: {r.stderr}")
    rows = numbers(out)
    last, first = rows[-1], next((k for k, x in enumerate(rows) if x["breakages"] > 0), len(rows) - 1)
    need(last["pd_cracks"] == last["breakages"] > 0, f"platens: {last}")
    force = rows[first - 1]["axial_stress_Pa"] * (2e-3 * 0.951489973) ** 2
    need(150 < force < 260, f"platens: {force} N")
    shown = bodies(out)
    surface = [sum(ConvexHull(points).area for points in frame) for frame in (shown[0], shown[-1])]
    need(len(shown[-1]) == last["grains"] > 1, f"platens: {len(shown[-1])} grains in the frame")
    fresh = last["fragment_area_m2"]
    need(abs(2 * fresh / (surface[1] - surface[0]) - 1) < 1e-3, f"platens: {surface}, fresh {fresh}")
    need(1 < last["bond_energy_J"] / (30 * fresh) < 6, f"platens: {last['bond_energy_J']} J of {fresh} m^2")


def points(tmp):
    """output.lattice: a grain that cracked, point by point, where it was: in it, as many points of each piece as that
    is large, dilations by the displacements of whole neighbours, no bond of theirs beyond the critical stretch."""
    out = os.path.join(tmp, "platens")  # with output.lattice = 2
    names = os.listdir(os.path.join(out, "lattice"))
    need(names == ["lattice_00000.hdf"], f"points: {names}")
    seen = frames(out, "lattice")
    rows = numbers(out)
    after = next(k for k, row in enumerate(rows) if row["pd_cracks"] > 0)
    need(len(seen) == 1 and rows[after - 1]["time_s"] < seen[0][1] <= rows[after]["time_s"], f"points: {seen}")
    frame = Points(*seen[0])
    x, u = frame.points.astype(float), frame.at_points["displacement_m"].astype(float)
    damage, theta, piece = (frame.at_points[k].astype(float) for k in ("damage", "dilation", "piece"))
    need(set(frame.types) == {1} and len(x) == len(frame.types) == len(piece), "points: vertices")
    grains = bodies(out)
    hull = ConvexHull(grains[0][0])
    beyond = (x @ hull.equations[:, :3].T + hull.equations[:, 3]).max()
    need(beyond < 1e-5 and len(x) > 450, f"points: one of {len(x)} lies {beyond} m beyond its grain")
    volume = sorted((ConvexHull(p).volume for p in grains[-1]), reverse=True)
    share = [n / len(x) for n in np.bincount(piece.astype(int))]
    need(len(share) == len(volume) and np.allclose(share, np.array(volume) / hull.volume, atol=0.1),
         f"points: shares {share} of pieces of {volume} m^3")
    spacing = 2e-3 * (np.pi / 6 / 500) ** (1 / 3)
    first, second = cKDTree(x).query_pairs(3.01 * spacing, output_type="ndarray").T  # bare, of three spacings
    way, moved = x[second] - x[first], u[second] - u[first]
    length = np.linalg.norm(way, axis=1)
    stretch = (way * moved).sum(1) / length**2
    both = lambda values: sum(np.bincount(k, values, len(x)) for k in (first, second))
    own = 3 * both(length**2 * stretch) / both(length**2)
    whole = damage == 0
    need(whole.sum() > 10 and np.allclose(theta[whole], own[whole], rtol=1e-3, atol=1e-3 * np.abs(theta[whole]).max()),
         "points: dilations")
    k, mu = 1e11 / 3 / (1 - 0.3), 1e11 / 2 / 1.15
    critical = np.sqrt(30 / ((3 * mu + 0.75**4 * (k - 5 * mu / 3)) * 3 * spacing))
    longest = stretch[whole[first] | whole[second]].max()
    need(0.5 < longest / critical < 1.001, f"points: a whole bond is stretched by {longest}, of {critical}")
    lost = both((stretch > 1.001 * critical).astype(float)) / both(np.ones(len(first)))
    need((damage > lost - 1e-6).all() and damage.max() < 1 and damage.mean() < 3 * lost.mean() + 0.05,
         f"points: damage {damage.mean()} in the mean, of bonds too long {lost.mean()}")


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
    need(numbers(os.path.join(tmp, "size_none_0"))[-1]["pd_cracks"] > 0, "without: nothing has cracked")
    need(not os.path.exists(os.path.join(tmp, "size_none_0", "lattice")), "points that nobody asked for")


with tempfile.TemporaryDirectory() as folder:
    between_platens(folder)
    points(folder)
    oedometer(folder)
    sizes(folder)
    without(folder)
print("cracking:", len(faults), "faults")
sys.exit(bool(faults))
