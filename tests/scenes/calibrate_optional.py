#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What grus-calibrate does with packages that not everybody has, 77 (skipped) where they are not there:
calibrate_optional.py posterior|pounders BIN"""
import csv
import importlib.util
import json
import math
import os
import sys
import tempfile
from types import SimpleNamespace

import numpy as np

import made_up
from scene_tools import faults, need

case = sys.argv[1]
package = {"posterior": "emcee", "pounders": "petsc4py"}[case]
if importlib.util.find_spec(package) is None:
    print(f"SKIPPED, nothing was tested: there is no {package}; install python3-{package} (./bootstrap test)")
    sys.exit(77)
place = tempfile.TemporaryDirectory()
programs = made_up.installation(os.path.join(place.name, "place"), os.path.abspath(sys.argv[2]))
from grus.calibrate import regression  # noqa: E402
from grus.calibrate.command import main  # noqa: E402

CALIBRATION = """[calibrate]
scene = "known.toml"
seeds = [1, 2]
seed_key = "seed"
parameters = [ { key = "a", min = 80, max = 120 }, { key = "b", min = 0, max = 100 } ]
targets = [ { name = "curve", data = "curve.csv", x = "axial_strain", y = "axial_stress_Pa", error = 0.2 } ]
"""


def calibrated(**more):
    """calibration.json of a line with a bend, a = 104 and b = 42 behind c times the mean of two seeds."""
    folder = os.path.join(place.name, "files")
    os.makedirs(folder, exist_ok=True)
    strains = [0.05, 0.1, 0.15, 0.2]
    curve = "axial_strain,axial_stress_Pa [Pa]\n" + "".join(f"{e},{104 * e + 42 * e * e + 0.03!r}\n" for e in strains)
    for name, text in (("known.toml", "[made_up]\nc = 0.02\nrows = 20\n"), ("curve.csv", curve),
                       ("c.toml", CALIBRATION + "".join(f"{k} = {v}\n" for k, v in more.items()))):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
    made_up.unpainted()
    out = os.path.join(folder, "out")
    status, said, errors = made_up.command(main, os.path.join(folder, "c.toml"), "-o", out, "--quiet")
    need(status == 0, f"exit {status} {said} {errors}")
    with open(os.path.join(out, "calibration.json")) as f:
        return json.load(f), out


def case_posterior():
    """Draws on a surface that is a plane: a normal of known covariance; where its range ends, one cut off; and what the
    command says of them."""
    from grus.calibrate import posterior
    slope = np.array([[2.0, 1.0], [0.5, -1.0], [1.0, 0.0]])
    noise = 0.03**2 * np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 2.0]])
    known = np.linalg.inv(slope.T @ np.linalg.solve(noise, slope))
    surface = SimpleNamespace(at=lambda x: slope @ x)
    steps, rest = posterior.STEPS, posterior.REST
    for truth in (np.array([0.4, 0.6]), np.array([0.0, 0.6])):
        result = SimpleNamespace(x=truth, covariance=known, surface=surface, noise=noise)
        data = regression.Data(slope @ truth, np.zeros(3), np.array([1.0, 99.0, 1.0]), np.zeros(3))
        draws, worth = posterior.posterior(result, data)
        need(draws.shape == (32 * (steps - rest), 2) and 500 < worth < 0.2 * len(draws),
             f"{worth} independent draws of {draws.shape}")
        sd, four = np.sqrt(np.diag(known)), 4 / math.sqrt(worth)  # four deviations of a mean of so many
        if truth[0] > 0:
            need((np.abs(draws.mean(0) - truth) < four * sd).all(), f"mean {draws.mean(0)} instead of {truth}")
            need(np.abs((np.cov(draws.T) - known) / np.outer(sd, sd)).max() < 1.5 * four,
                 f"covariance {np.cov(draws.T)} instead of {known}")
        else:  # half a normal in the first: mean sqrt(2 / pi)
            need(draws.min() >= 0 and draws.max() <= 1, "draws beyond the range")
            need(abs(draws[:, 0].mean() / sd[0] - math.sqrt(2 / math.pi)) < four,
                 f"at a bound: mean {draws[:, 0].mean() / sd[0]} deviations")
    posterior.STEPS, posterior.REST = 60, 20
    few = [posterior.posterior(result, data, seed)[0] for seed in (1, 1, 2)]
    need((few[0] == few[1]).all() and (few[0] != few[2]).any(), "the same seed draws anew, or another the same")
    wide = SimpleNamespace(x=np.full(9, 0.5), covariance=np.eye(9), noise=np.full((1, 1), 0.01),
                           surface=SimpleNamespace(at=lambda x: x[:1]))
    draws = posterior.posterior(wide, regression.Data(np.array([0.5]), None, None, None))[0]
    need(draws.shape == (36 * 40, 9) and draws.min() >= 0 and draws.max() <= 1, f"nine parameters: {draws.shape}")
    posterior.STEPS, posterior.REST = 400, 100
    found, out = calibrated(budget=24, check="false", posterior="true")
    said = found["posterior"]
    need(said["draws"] == 32 * 300 and 100 < said["independent"] < said["draws"], f"{said}")
    with open(os.path.join(out, "posterior.csv"), newline="") as f:
        head, *rows = csv.reader(f)
    rows = np.array(rows, float)
    need(head == ["a", "b"] and len(rows) == 960, f"posterior.csv: {len(rows)} draws of {head}")
    for k, (p, q) in enumerate(zip(found["parameters"], said["parameters"])):
        own = rows[:, k]
        need(p["key"] == q["key"] and abs(q["median"] - np.median(own)) < 0.3 * own.std()
             and abs(q["median"] - p["value"]) < p["sd"] and abs(own.std() / p["sd"] - 1) < 0.5,
             f"{q} beside {p}, in posterior.csv {np.median(own)} +- {own.std()}")
        for share, (low, high) in ((0.68, q["middle_68"]), (0.95, q["middle_95"])):
            need(abs(((low <= own) & (own <= high)).mean() - share) < 0.05, f"middle {share}: {low} … {high}")


def case_pounders():
    """Where nothing is drawn all parameters come back; bounds are kept, and the number of points."""
    from grus.calibrate.pounders import pounders
    along = np.linspace(0, 1, 20)
    model = lambda x: np.concatenate([np.exp(-3 * x[0] * along) * (1 + 0.5 * x[1]), [x[1] * (1 + 0.3 * x[0]),
                                                                                    x[2] * (1 + 0.2 * x[1])]])
    calls, told = [], []

    def evaluate(points):
        calls.extend(points)
        return [regression.Answer(model(x), np.zeros((22, 22)), np.ones(22)) for x in points]

    for truth in (np.array([0.37, 0.62, 0.55]), np.array([0.37, 0.62, 1.05])):
        calls.clear(), told.clear()
        data = regression.Data(model(truth), np.full(22, 0.001), np.ones(22), np.zeros(22))
        result = pounders(evaluate, 3, data, 40, told.append)
        need(told == [result] and len(calls) <= 41 and result.history[-1][0] == len(calls)
             and all((0 <= x).all() and (x <= 1).all() for x in calls), f"asked {len(calls)} times")
        sd = np.sqrt(np.diag(result.covariance))
        need((sd[:2] < 0.02).all() and (sd > 0).all(), f"deviations of {sd}")
        if truth[2] < 1:
            need(np.abs(result.x / truth - 1).max() < 0.005, f"{result.x} instead of {truth}")
            need(np.abs(result.fitted - data.values).max() < 0.005 and np.abs(result.misfit).max() < 3, "the fit")
        else:
            need(result.x[2] > 0.999 and result.misfit[-1] < -5, f"beyond a bound: {result.x}, {result.misfit}")
    # One number that two deviations of another outweigh: what is heavier is met.
    line = lambda points: [regression.Answer(np.array([x[0], x[0]]), np.zeros((2, 2)), np.ones(2)) for x in points]
    for weight, error, wanted in (((1, 1), (1, 1), 0.5), ((3, 1), (1, 1), 0.35), ((1, 1), (1, 2), 0.32)):
        data = regression.Data(np.array([0.2, 0.8]), np.array(error, float), np.array(weight, float), np.zeros(2))
        found = pounders(line, 1, data, 30, lambda r: None).x[0]
        need(abs(found - wanted) < 1e-3, f"weights {weight}, errors {error}: {found} instead of {wanted}")
    found, _ = calibrated(budget=60, method='"pounders"')
    a, b = found["parameters"]
    need(found["method"] == "pounders" and abs(a["value"] / 104 - 1) < 5e-3 and abs(b["value"] / 42 - 1) < 5e-2
         and found["points"] <= 31, f"{a} {b}")


globals()[f"case_{case}"]()
place.cleanup()
print(f"calibrate {case}: {len(faults)} faults")
sys.exit(bool(faults))
