#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-calibrate: the regression against models with known answers, targets against closed forms, and the command.
calibrate.py BIN"""
import csv
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time

import numpy as np

binaries = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(binaries, "..", "python"))
from grus.calibrate import regression  # noqa: E402
from grus.calibrate.targets import Target, along, kink  # noqa: E402

here = os.path.dirname(os.path.abspath(__file__))
scenes = os.path.abspath(os.path.join(here, "..", "..", "apps", "scenes"))
faults = []


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


POINTS = 20
ALONG = np.linspace(0, 1, POINTS)


def model(x):
    return np.concatenate(
        [np.exp(-3 * x[0] * ALONG) * (1 + 0.5 * x[1]), [x[1] * (1 + 0.3 * x[0]), x[2] * (1 + 0.2 * x[1])]])


def twin(seed, noise=0.03, parameters=3, blind=False, points=40, seeds=3, common=False):
    """Truth and result of one calibration to data that are a mean of three noisy runs; noise along the curve is
    correlated. `common`: seeds have the same noise at all points."""
    rng, size = np.random.default_rng(seed), POINTS + 2

    def noisy(x, generator):
        e = noise * generator.normal(size=size)
        e[:POINTS] = noise * (generator.normal() + generator.normal() * ALONG + 0.3 * generator.normal(size=POINTS))
        return model(x) + e

    truth = rng.uniform(0.2, 0.8, parameters)
    data = regression.Data(np.mean([noisy(truth, rng) for _ in range(3)], axis=0), np.full(size, 0.005),
                           np.concatenate([np.full(POINTS, 1 / POINTS), [1, 1]]), np.full(size, 3.0))

    def evaluate(points):
        answers = []
        for x in points:
            runs = np.array([noisy(x[:3], np.random.default_rng([seed, k]) if common else rng) for k in range(seeds)])
            answers.append(regression.Answer(runs.mean(0), np.cov(runs.T), np.full(size, float(seeds))))
        return answers

    return truth, regression.calibrate(evaluate, parameters + blind, data, points)


def regressions():
    for common in (False, True):
        inside, sds = np.zeros(3), []
        for k in range(20):
            truth, result = twin(k, common=common,
                                 seeds=8 if common else 3)  # fewer would know too little of their own scatter
            sd = np.sqrt(np.diag(result.covariance))
            inside += np.abs(result.x - truth) < sd
            sds.append(sd)
        # 13.7 +- 2.1 of 20 if the deviations are right.
        need((inside >= 10).all() and (inside <= 17).all(
        ), f"noise {'common to all points' if common else 'of its own'}: truth within one deviation in {inside} of 20 "
           "twins"
             )
        need(np.mean(sds) < 0.05, f"deviations of {np.mean(sds, axis=0)} of the range")
    truth, result = twin(1, noise=0.0)
    need(np.abs(result.x - truth).max() < 0.01, f"no noise: {result.x} instead of {truth}")
    # A parameter without effect: not identified, and the others are not moved by it.
    for k in range(4):
        truth, result = twin(k, blind=True)
        sd = np.sqrt(np.diag(result.covariance))
        words = regression.verdicts(result, ["a", "b", "c", "blind"])
        need(words[3].startswith("not identified"), f"a parameter without effect is {words[3]}, sd {sd[3]}")
        need((np.abs(result.x[:3] - truth) < 3.5 * sd[:3]).all() and (sd[:3] < 0.1).all(),
             f"beside it: {result.x[:3]} instead of {truth}, sd {sd[:3]}")
    # Only a product is known: both are weak or worse, and each names the other.
    rng = np.random.default_rng(5)

    def product(points):
        return [
            regression.Answer(
                np.array([x[0] + x[1], 2 * (x[0] + x[1])]) + 0.01 * rng.normal(size=2), 1e-4 * np.eye(2), np.ones(2))
            for x in points
        ]

    result = regression.calibrate(product, 2,
                                  regression.Data(np.array([1.0, 2.0]), np.full(2, 0.01), np.full(2, 0.5), np.zeros(2)),
                                  30)
    words = regression.verdicts(result, ["one", "two"])
    need(
        all("not identified (combination with" in w and "-1.0" in w.replace("-0.9", "-1.0") for w in words)
        and "two" in words[0], f"of a sum: {words}")
    sd = np.sqrt(np.diag(result.covariance))
    need((sd > 0.15).all() and result.covariance[0, 1] < -0.9 * sd[0] * sd[1],
         f"of a sum: covariance {result.covariance.tolist()}")

    # Runs that fail are data: worse than the worst.
    def part(points):
        return [
            regression.Answer(
                np.array([math.nan, x[0]]) if x[0] > 0.6 else np.array([x[0]**2, x[0]]), np.zeros((2, 2)), np.ones(2),
                bool(x[0] > 0.6)) for x in points
        ]

    result = regression.calibrate(
        part, 1, regression.Data(np.array([0.25, 0.5]), np.full(2, 0.001), np.full(2, 0.5), np.zeros(2)), 24)
    need(abs(result.x[0] - 0.5) < 0.01, f"beside failures: {result.x}")


def targets():
    x = np.array([0.0, 1, 2, 1.5, 3, 4])
    need(np.allclose(along(x, 10 * x, [0.5, 2.5, 4]), [5, 25, 40]), "along a staircase")
    need(np.isnan(along(x, x, [5.0])[0]), "beyond the end of a run there is nothing")
    stress = np.geomspace(1, 100, 200)
    void = 0.8 - 0.02 * np.log(stress) - 0.2 * np.maximum(0, np.log(stress / 20))
    need(abs(kink(stress, void) / 20 - 1) < 0.02, f"yield at {kink(stress, void)}")


def kinds(tmp):
    """Each kind of target from runs whose answers are known."""
    strain, grains = np.linspace(0, 0.2, 21), np.geomspace(1e-4, 1e-3, 30)

    def run(k):  # passing = (d / 1 mm)^(2 - 5 strain), k: what a seed adds
        states = {e: [{"diameter_m": d, "passing": (d / 1e-3) ** (2 - 5 * e)} for d in grains] for e in (0.0, 0.1, 0.2)}
        return {
            "columns": {"axial_strain": strain, "axial_stress_Pa": 1e8 * strain + k, "void_ratio": 0.8 - strain},
            "summary": {"results": {"peak_axial_stress_Pa": 10.0 * k}}, "grading": states
        }

    def target(name, text, **table):
        path = os.path.join(tmp, name + ".csv")
        with open(path, "w") as f:
            f.write(text)
        return Target({"name": name, "data": name + ".csv", **table}, tmp)

    runs = [run(k) for k in (1, 2, 3, 4, 5)]
    sieve = target("sieve", "diameter_m,passing\n2e-4,0.1\n5e-4,0.4\n", kind="grading", at=0.1, error=0.03, weight=4)
    values, between, n = sieve.answer(runs)
    need(
        np.allclose(values, [0.2**1.5, 0.5**1.5], rtol=1e-2) and n == 5 and np.allclose(between, 0)
        and (sieve.error == 0.03).all() and sieve.weight.sum() == 4, f"grading {values}")
    at_stress = target("sieve", "diameter_m,passing\n5e-4,0.4\n", kind="grading", at="10 MPa", at_stress=1e7)
    need(abs(at_stress.answer([run(0)])[0][0] - 0.5**1.5) < 0.005, "grading at a stress")
    need(np.isnan(target("sieve", "diameter_m,passing\n5e-4,0.4\n", kind="grading", at=0.3).answer([run(0)])[0][0]),
         "a grading that no run reaches")
    values, between, n = target("grains", "value (Pa)\n30\n10\n50\n20\n40\n", kind="quantiles",
                                quantity="results.peak_axial_stress_Pa").answer(runs)
    need(np.allclose(values, [10, 20, 30, 40, 50]) and n == 5, f"quantiles {values}")
    need(between.shape == (5, 5) and (np.diag(between) > 0).all(), "quantiles of few seeds scatter")
    values, between, _ = target("value", "", kind="value", quantity="axial_stress_Pa", value=1.0, at=0.1,
                                specimens=3).answer(runs)
    need(abs(values[0] - (1e7 + 3)) < 1e-6 and abs(between[0, 0] - 2.5) < 1e-6, f"value {values}, between {between}")
    need(
        target("peak", "", kind="peak", quantity="axial_stress_Pa", value=1.0).answer([run(7)])[0][0] == 2e7 + 7,
        "peak")
    values, _, _ = target("curve", "axial_stress_Pa,void_ratio,error\n5e6,0.7,0.01\n1.5e7,0.6,0.02\n",
                          x="axial_stress_Pa", y="void_ratio").answer([run(0)])
    need(np.allclose(values, [0.75, 0.65], atol=1e-6), f"curve {values}")


def history(folder):
    with open(os.path.join(folder, "history.csv"), newline="") as f:
        return list(csv.DictReader(f))


def command(*arguments, **more):
    return subprocess.run([os.path.join(binaries, "grus-calibrate"), *arguments], capture_output=True, text=True,
                          timeout=280, **more)


SETTINGS = {"output.frames": 0, "loading.final_strain": 0.06, "loading.strain_rate": 1000.0}
TWIN = """[calibrate]
scene = "{scene}"
budget = 32
seeds = [10]
seed_key = "numerics.fracture_every"
set = {{ "output.frames" = 0, "loading.final_strain" = 0.06, "loading.strain_rate" = 1000.0 }}
parameters = [
  {{ key = "material.sand.youngs_modulus", min = "30 GPa", max = "120 GPa", scale = "log" }},
  {{ key = "material.sand.fracture.hoek_brown.compressive_strength", min = "150 MPa", max = "500 MPa" }} ]
targets = [
  {{ name = "rise", data = "curve.csv", x = "axial_strain", y = "axial_stress_Pa", error = 1e5 }},
  {{ name = "strength", kind = "peak", quantity = "axial_stress_Pa", value = {peak}, error = 1e5 }} ]
"""


def commands(tmp):
    scene = os.path.join(scenes, "single_grain.toml")
    r = subprocess.run([os.path.join(binaries, "grus-rve"), scene, "-o",
                        os.path.join(tmp, "data"), "--quiet"] +
                       [a for k, v in SETTINGS.items() for a in ("--set", f"{k}={v}")], capture_output=True, text=True)
    need(r.returncode == 0, r.stderr)
    rows = history(os.path.join(tmp, "data"))
    stress = [float(x["axial_stress_Pa"]) for x in rows]
    peak = stress.index(max(stress))
    with open(os.path.join(tmp, "curve.csv"), "w") as f:
        f.write("axial_strain,axial_stress_Pa\n" + "".join(f"{x['axial_strain']},{x['axial_stress_Pa']}\n"
                                                           for x in rows[4:peak // 2:3]))
    path = os.path.join(tmp, "twin.toml")
    with open(path, "w") as f:
        f.write(TWIN.format(scene=scene, peak=max(stress)))
    # Killed on the way, gone on with; on one core and on two: the same result, and no run twice.
    out = os.path.join(tmp, "killed")
    process = subprocess.Popen([os.path.join(binaries, "grus-calibrate"), path, "-o", out, "--quiet", "--threads", "2"],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    for _ in range(400):
        time.sleep(0.05)
        if len([
                d for d in (os.listdir(os.path.join(out, "runs")) if os.path.isdir(os.path.join(out, "runs")) else [])
                if os.path.isfile(os.path.join(out, "runs", d, "study.key"))
        ]) >= 5:
            break
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    need(not os.path.exists(os.path.join(out, "calibration.json")), "killed too late to be a test")
    kept = {
        d: os.stat(os.path.join(out, "runs", d, "history.csv")).st_mtime_ns
        for d in os.listdir(os.path.join(out, "runs")) if os.path.isfile(os.path.join(out, "runs", d, "study.key"))
    }
    for name, threads in (("killed", "2"), ("one", "1")):
        r = command(path, "-o", os.path.join(tmp, name), "--threads", threads, "--resume")
        need(r.returncode == 0, f"{name}: {r.stderr}")
    for d, when in kept.items():
        need(os.stat(os.path.join(out, "runs", d, "history.csv")).st_mtime_ns == when, f"run {d} was done again")
    read = lambda name: open(os.path.join(tmp, name, "calibration.json")).read()
    need(read("killed") == read("one"), "one core and two, with a kill between, differ")
    found = json.loads(read("one"))
    # Two rows at the peak are 2.5 % of stress apart: it rises as strain^1.5.
    for p, truth, tolerance in zip(found["parameters"], (60.0, 275.0), (0.01, 0.025)):
        need(
            abs(p["value"] / truth - 1) < tolerance and p["verdict"] == "identified",
            f"{p['key']}: {p['value']} ({p['verdict']}) instead of {truth}")
    # Every key that says how to fit changes the result; the runs are there already.
    for key, change in (("batch", ("budget = 32", "budget = 32\nbatch = 5")),
                        ("check", ("budget = 32", "budget = 32\ncheck = false")),
                        ("error", ("error = 1e5 }}},\n", "error = 1e7 }}},\n")),
                        ("weight", ("error = 1e5 }}},\n", "error = 1e5, weight = 50 }}},\n")),
                        ("scale", (', scale = "log"', ""))):
        other = os.path.join(tmp, f"key_{key}.toml")
        text = TWIN.replace(*[c.replace("}}}", "}}") for c in change]).format(scene=scene, peak=max(stress))
        need(text != TWIN.format(scene=scene, peak=max(stress)), f"{key}: nothing changed")
        with open(other, "w") as f:
            f.write(text)
        r = command(other, "-o", os.path.join(tmp, "killed"), "--quiet")
        need(r.returncode == 0 and read("killed") != read("one"),
             f"{key}: exit {r.returncode}, or the same result: {r.stderr}")
    # The scene that it leaves runs as it is.
    r = subprocess.run([
        os.path.join(binaries, "grus-rve"),
        os.path.join(tmp, "one", "best.toml"), "-o",
        os.path.join(tmp, "best"), "--quiet"
    ], capture_output=True, text=True)
    need(r.returncode == 0, f"best.toml: {r.stderr}")
    if r.returncode == 0:
        need(
            abs(max(float(x["axial_stress_Pa"]) for x in history(os.path.join(tmp, "best"))) / max(stress) - 1) < 0.02,
            "best.toml is not what was fitted")
    for what, change, expected in (
            ("unit", ('max = "120 GPa"', 'max = "120 mm"'), "different units"),
            ("order", ('min = "30 GPa"', 'min = "300 GPa"'), "min must be below max"),
            ("key", ("youngs_modulus", "youngs_modulos"), "youngs_modulos"),
            ("data", ("curve.csv", "nowhere.csv"), "cannot read"),
            ("budget", ("budget = 32", "budget = 4"), "need at least"),
            ("column", ('y = "axial_stress_Pa"', 'y = "axial_stress"'), "no column is called 'axial_stress'"),
            ("needs", ('kind = "peak", ', 'kind = "grading", '), "needs 'data'")):
        bad = os.path.join(tmp, f"bad_{what}.toml")
        with open(bad, "w") as f:
            f.write(TWIN.format(scene=scene, peak=1e6).replace(*change))
        r = command(bad, "-o", os.path.join(tmp, "bad"))
        need(r.returncode == 2 and expected in r.stderr and r.stderr.count("\n") == 1,
             f"{what}: exit {r.returncode}: {r.stderr!r}")
    need(not os.path.exists(os.path.join(tmp, "bad")), "a refused calibration left a folder")


regressions()
targets()
with tempfile.TemporaryDirectory() as folder:
    kinds(folder)
    commands(folder)
print("calibrate:", len(faults), "faults")
sys.exit(bool(faults))
