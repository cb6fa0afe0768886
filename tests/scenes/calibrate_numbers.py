#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The regression of grus-calibrate, number by number: by hand, by differences, by unit responses, by how often the
truth is within what it says; and a whole calibration of a program of known answers. calibrate_numbers.py BIN"""
import csv
import io
import json
import math
import os
import re
import sys
import tempfile
import time
import tomllib
from types import SimpleNamespace

import numpy as np
from scipy import stats

import made_up
from made_up import near
from scene_tools import faults, need

tmp = tempfile.TemporaryDirectory()
programs = made_up.installation(os.path.join(tmp.name, "place"), os.path.abspath(sys.argv[1]))
from grus.calibrate import regression  # noqa: E402

nan = math.nan


def surfaces():
    rng = np.random.default_rng(1)
    x, y, weight = rng.uniform(size=(14, 3)), rng.normal(size=(14, 2)), rng.uniform(0.1, 1, 14)
    surface = regression.Surface(x, y, weight, np.array([0.4, 0.5, 0.7]))
    for at in (np.array([0.2, 0.9, 0.3]), surface.centre):
        sides = [(surface.at(at + h) - surface.at(at - h)) / 2e-3 for h in 1e-3 * np.eye(3)]
        near(surface.slope(at), np.array(sides).T, "slopes against differences", 1e-8)
    near(regression.quadratic([[2.0, 5.0]], np.array([1.0, 2.0])), [[1, 1, 3, 1, 3, 9]], "terms of a quadratic")
    plane = regression.Surface(x, (x @ [[1.0, 2.0], [0.0, 3.0], [-4.0, 5.0]]) + [1, 2], weight, np.full(3, 0.5))
    near(plane.at([0.1, 0.2, 0.3]), [1 + 0.1 - 1.2, 2 + 0.2 + 0.6 + 1.5], "a plane", 1e-9)
    need(np.abs(plane.noise).max() < 1e-20, "noise about a plane")
    # The fit is linear in what it fits: of unit noise at one point after the other the squares add up.
    at = np.array([0.2, 0.9, 0.3])
    units = [regression.Surface(x, e[:, None], weight, surface.centre) for e in np.eye(14)]
    near(surface.leverage(at), sum(u.at(at)[0] ** 2 for u in units), "leverage by unit responses", 1e-9)
    slopes = [u.slope(surface.centre)[0] for u in units]
    near(surface.slope_spread(), sum(np.outer(s, s) for s in slopes), "spread of slopes by unit responses", 1e-9)
    # Twelve points for ten terms leave two freedoms, and some of the bends that stay small: what is said of the
    # variance is a square of what is fitted, its mean the sum over units.
    x = rng.uniform(size=(12, 3))
    units = [regression.Surface(x, e[:, None], np.ones(12), np.full(3, 0.5)).noise[0, 0] for e in np.eye(12)]
    need(0.7 < sum(units) < 1.05, f"variance about a surface of ten terms by twelve points: {sum(units)} of it")
    # Points that failed weigh a tenth: as one in ten of the others, where both say something else.
    both = np.repeat([[0.2], [0.5], [0.8]], 11, axis=0)
    failed = np.tile([False] + [True] * 10, 3)
    values = np.where(failed, 3.0, 1.0)[:, None]
    weight = regression.weights_of(both, failed, np.array([0.5]), 0.5)
    near(regression.Surface(both, values, weight, np.array([0.5])).at([0.5]), [2], "beside failures", 1e-9)
    places = np.array([[0.5, 0.6], [0.7, 0.5], [0.5, 0.9], [0.5, 0.5]])
    near(regression.weights_of(places, np.array([False, False, False, True]), np.array([0.5, 0.5]), 0.1),
         [1, math.exp(-2), 1e-3, 0.1], "weights by the distance in boxes")


def answers():
    """What a point without an answer counts as, and what seeds say of each other."""
    answer = lambda values, between=1.0, failed=False: regression.Answer(np.array(values), between * np.eye(2),
                                                                         np.array([4.0, 9.0]), failed)
    y = regression.filled([answer(v) for v in ([1.0, 10.0], [2.0, 20.0], [3.0, 60.0], [9.0, nan], [0.5, nan],
                                               [-5.0, nan], [nan, nan])])
    near(y[:3], [[1, 10], [2, 20], [3, 60]], "known answers")
    need(np.median([1, 2, 3, 9, 0.5, -5]) == 1.5, "the middle of the first")
    # Half again as far from the middle as the worst: above beside what is above, below else.
    near(y[3:, 1], [20 + 60, 20 - 60, 20 - 60, 20 - 60], "unknown ones of the second number")
    near(y[6, 0], 1.5 - 1.5 * 7.5, "a point that says nothing")
    one, mean = regression.between_seeds([answer([1.0, 1.0], 2.0), answer([1.0, 1.0], 4.0), answer([1.0, nan], 50.0),
                                          answer([1.0, 1.0], 90.0, True)])
    near(one, [[3, 0], [0, 3]], "covariance from seed to seed")
    near(mean, [[3 / 4, 0], [0, 3 / 9]], "covariance of means")
    full = regression.Answer(np.ones(2), np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([4.0, 9.0]))
    near(regression.between_seeds([full])[1], [[1 / 4, 0.5 / 6], [0.5 / 6, 1 / 9]], "covariance of two targets' means")
    near(regression.between_seeds([answer([1.0, nan])])[0], np.zeros((2, 2)), "where no point has all numbers")
    m = np.eye(2)
    widened = lambda seeds, points, share: regression.few(m, share * m, seeds, points)
    t = lambda freedom: (stats.t.ppf(stats.norm.cdf(2), freedom) / 2) ** 2
    near([widened(1, 9, 1), widened(2, 9, 1), widened(3, 9, 1), widened(3, 5, 0), widened(3, 5, 0.5), widened(3, 5, 7)],
         [1, t(1), t(2), t(2 * 5), t(2 * 3), t(2)], "what few seeds widen")


def deviations():
    """The covariance of parameters against that of the estimate itself, a matrix times the data."""
    j = np.array([[2.0, 1.0], [0.5, -1.0], [1.0, 0.3]])
    data = regression.Data(np.zeros(3), np.array([0.01, 0.02, 0.03]), np.array([1.0, 0.5, 2.0]),
                           np.array([4.0, 0.0, 1.0]))
    own = 1e-4 * np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 1.0]])
    flat = lambda noise, leverage=0.0, spread=0.0: SimpleNamespace(
        slope=lambda x: j, leverage=lambda x: leverage, noise=noise, slope_spread=lambda: spread * np.eye(2))
    said = lambda surface, mean, seeds=1e9: regression.uncertainty(surface, np.full(2, 0.5), data, own, mean, seeds, 7)
    share, zero = np.array([0.5, 0.0, 1.0]), np.zeros((3, 3))

    def by_hand(noise, lost=0.0):
        w = np.diag(data.weight / np.diag(noise))
        a = j.T @ w @ j - lost * np.eye(2)
        estimate = np.linalg.solve(a, j.T @ w)
        return np.linalg.inv(np.linalg.inv(estimate @ noise @ estimate.T) + 12 * np.eye(2))

    for what, surface, mean, seeds, wanted in (
            ("data and their specimens", flat(zero), zero, 1e9, np.outer(share, share) * own),
            ("means of runs", flat(zero), own / 5, 1e9, np.outer(share, share) * own + own / 5),
            ("means of two seeds", flat(zero), own / 5, 2,
             regression.few(own, own, 2, 7) * (np.outer(share, share) * own + own / 5)),
            ("scatter about the fit", flat(own, 0.3), zero, 1e9, np.outer(share, share) * own + 0.3 * own),
            # What shows about the surface is not common: of twice as much in the means half is.
            ("half of it in common", flat(own, 0.3), 2 * own, 1e9, np.outer(share, share) * own + 1.3 * own),
            ("less in the means than about the fit", flat(own, 0.3), 0.5 * own, 1e9,
             np.outer(share, share) * own + 0.3 * own)):
        covariance, singular, directions, noise = said(surface, mean, seeds)
        near(noise, np.diag(data.error**2) + wanted, f"noise: {what}", 1e-6, 1e-12)
        near(covariance, by_hand(noise), f"covariance: {what}", 1e-5)
    root = np.sqrt(data.weight / np.diag(noise))[:, None] * j
    near((directions.T * singular**2) @ directions, root.T @ root, "sensitivities", 1e-9)
    near(singular, sorted(singular)[::-1], "the strongest first")
    covariance, _, _, noise = said(flat(own, 0.3, 1e-3), zero)  # what noise alone would show of slopes is taken off
    lost = 1e-3 * np.sum(data.weight / np.diag(noise) * np.diag(own))
    near(covariance, by_hand(noise, lost), "covariance where slopes are noisy", 1e-5)
    blind = SimpleNamespace(slope=lambda x: j * [1, 0], leverage=lambda x: 0.0, noise=zero,
                            slope_spread=lambda: np.zeros((2, 2)))
    near(said(blind, zero)[0][1, 1], 1 / 12, "a parameter without effect: even over its range", 1e-6)
    # How often the truth is within two deviations where seeds share their noise: of 60 twins 57; 52 is three sigma off.
    for seeds, points in ((2, 8), (3, 16)):
        rng, inside = np.random.default_rng(seeds), 0
        for _ in range(60):
            common, truth = 0.01 * rng.normal(size=seeds), rng.uniform(0.3, 0.7)

            def evaluate(points, common=common, own=np.cov(common).reshape(1, 1)):
                return [regression.Answer(x + common.mean(), own, np.full(1, float(seeds))) for x in points]

            known = regression.Data(np.array([truth]), np.full(1, 1e-4), np.ones(1), np.zeros(1))
            result = regression.calibrate(evaluate, 1, known, points)
            inside += abs(result.x[0] - truth) < 2 * math.sqrt(result.covariance[0, 0])
        need(inside >= 52, f"{seeds} seeds with common noise at {points} points: {inside} of 60 truths within two")


def fits():
    surface = SimpleNamespace(at=lambda x: np.array([x[0] + x[1], x[0] - x[1]]),
                              slope=lambda x: np.array([[1.0, 1.0], [1.0, -1.0]]))
    best = lambda values, weight=(1.0, 1.0), low=0.0: regression.best_of(
        surface, [np.full(2, 0.5)], np.full(2, low), np.ones(2), regression.Data(np.array(values), None,
                                                                                np.array(weight), None),
        np.array([1.0, 2.0]))
    near(best([0.9, 0.1]), [0.5, 0.4], "the best point of two planes", 1e-6)
    # At the bound x1 = 0.3 the first plane pulls by 3 and the second by 5/4 times their squares: 3 (x + 0.3 - 1) +
    # 5/4 (x - 0.3 - 1) = 0.
    near(best([1.0, 1.0], (3.0, 5.0), 0.3), [(3 * 0.7 + 1.25 * 1.3) / 4.25, 0.3], "the best point at a bound", 1e-6)
    near([regression.smaller(*v) for v in ((0.5, 1.0), (0.1, 0.02), (0.1, 0.045), (0.02, 0.001), (0.02, 0.2))],
         [0.325, 0.065, 0.09, 0.02, 0.1], "boxes that shrink")
    asked = []

    def evaluate(points):
        asked.append(np.array(points))
        return [regression.Answer(np.array([x @ [1.0, 2.0], x[0]]), np.zeros((2, 2)), np.ones(2)) for x in points]

    data = regression.Data(np.array([1.6, 0.4]), np.full(2, 0.01), np.full(2, 0.5), np.zeros(2))
    result = regression.calibrate(evaluate, 2, data, 30)
    need([len(a) for a in asked] == [8, 8, 8, 6] and [n for n, _, _ in result.history] == [8, 16, 24, 30],
         f"batches of {[len(a) for a in asked]}")
    halves = [np.abs(a - c).max() for a, c in zip(asked[1:], [x for _, x, _ in result.history])]
    need(all(a.min() >= 0 and a.max() <= 1 for a in asked) and np.all(np.array(halves) <= [0.325, 0.2113, 0.1374])
         and np.all(np.array(halves) > [0.2, 0.13, 0.085]), f"half boxes of {halves}")
    near(result.x, [0.4, 0.6], "two numbers of two parameters", 1e-4)
    near(result.fitted, data.values, "values of the fit", 1e-4)
    need(np.abs(result.misfit).max() < 0.05 and len({tuple(r) for a in asked for r in a}) == 30, "misfit, other points")
    need(len(regression.calibrate(evaluate, 2, data, 9, batch=3).history) == 2
         and [len(a) for a in asked[4:]] == [8, 1], f"a batch that is asked for: {[len(a) for a in asked[4:]]}")
    asked.clear()
    flat = lambda points: asked.append(points) or [regression.Answer(np.ones(1), np.zeros((1, 1)), np.ones(1))
                                                   for _ in points]
    regression.calibrate(flat, 5, regression.Data(*np.ones((4, 1))), 50)
    need([len(a) for a in asked] == [23, 12, 12, 3], f"batches of five parameters: {[len(a) for a in asked]}")
    off = regression.Data(np.array([1.6, 0.4, 0.8]), np.array([0.01, 0.01, 0.04]), np.full(3, 1e-9), np.zeros(3))
    shifted = lambda points: [regression.Answer(np.append(a.values, 1.0), np.zeros((3, 3)), np.ones(3))
                              for a in evaluate(points)]
    near(regression.calibrate(shifted, 2, off, 12).misfit[2], 5, "deviations of what no parameter moves", 1e-3)
    asked.clear()
    begun, before = [], regression.best_of
    regression.best_of = lambda surface, starts, *more: begun.append(starts) or before(surface, starts, *more)
    uneven = regression.Data(data.values, np.array([0.01, 0.1]), np.array([0.1, 0.9]), data.specimens)
    for seed in (1, 1, 2):
        regression.calibrate(evaluate, 2, uneven, 8, seed=seed)
    regression.best_of = before
    # The first points are Sobol's, shaken; the fit begins at the four that are nearest to the data, and in the middle.
    need((asked[0] == asked[1]).all() and (asked[0] != asked[2]).all() and (asked[0] % 0.125 > 0).all(),
         f"first points: {asked}")
    off = np.column_stack([(asked[0] @ [1.0, 2.0] - 1.6) / 0.01, (asked[0][:, 0] - 0.4) / 0.1])
    order = np.argsort(off**2 @ [0.1, 0.9])[:4]
    near(begun[0], [*asked[0][order], [0.5, 0.5]], "where the fit begins")
    need(len(begun[1]) == 1, "the second fit begins where the first one ended")


def words():
    """Verdicts about their limits, and what can be exchanged."""
    of = lambda sd, **more: regression.verdicts(SimpleNamespace(x=np.full(len(sd), 0.5), covariance=np.diag(sd) ** 2),
                                                [f"p{k}" for k in range(len(sd))], **more)
    need(of(np.array([0.09, 0.099, 0.101, 0.12, 0.149, 0.151, 0.2])) ==
         ["identified"] * 2 + ["weak"] * 3 + ["not identified"] * 2, f"{of(np.array([0.09, 0.12, 0.2]))}")
    need(of(np.array([0.09, 0.12]), off={"t": 3.26}) == [f"{w}; the fit is 3.3 deviations off 't'" for w in
                                                         ("doubtful", "weak")], "verdicts of a bad fit")
    line = np.array([1.0, -2.0, 0.0])  # two of the first are worth one of the second, with the other sign
    covariance = 0.2**2 * np.outer(line, line) + 1e-6 * np.eye(3)
    result = SimpleNamespace(x=np.array([0.5, 0.5, 0.5]), covariance=covariance)
    need(regression.verdicts(result, ["one", "two", "three"]) ==
         ["not identified (combination with two: -2.00 of its range a range)",
          "not identified (combination with one: -0.50 of its range a range)", "identified"],
         f"{regression.verdicts(result, ['one', 'two', 'three'])}")
    result.x = np.array([1e-3, 0.9991, 0.9989])
    found = regression.verdicts(result, ["one", "two", "three"])
    need(["lower bound" in found[0], "upper bound" in found[1], found[2]] == [True, True, "identified"], f"{found}")


SCENE = "[made_up]\na = 1.0\nb = 50.0\nc = 0.02\nrows = 20\n"
CALIBRATION = """title = "Known"
[calibrate]
scene = "known.toml"
budget = 36
seeds = [1, 2]
seed_key = "seed"
set = { graded = 1 }
parameters = [
  { key = "a", name = "slope", min = 80, max = 125, scale = "log" },
  { key = "b", min = 0, max = 100 } ]
targets = [
  { name = "curve", data = "curve.csv", x = "axial_strain", y = "axial_stress_Pa", error = 0.05 },
  { name = "peak", kind = "peak", quantity = "axial_stress_Pa", value = 22.6, error = 0.1, weight = 2 } ]
"""


def commands(folder):
    """A calibration from end to end: every number of calibration.json from those of calibration.csv, of the model and
    of the data."""
    from grus.calibrate.command import main
    made_up.unpainted()

    def write(name, text):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
        return f.name

    model = lambda a, b, e: a * e + b * e * e + 0.02 * 1.5  # the mean of two seeds
    strains, weight = np.array([0.05, 0.1, 0.15]), np.array([1 / 3, 1 / 3, 1 / 3, 2])
    data = np.append(model(100.0, 60.0, strains), 22.6)  # 22.43 would be the peak: the fit lies between
    write("known.toml", SCENE)
    rows = "".join(f"{e},{y!r}\n" for e, y in zip(strains, data.tolist()))
    write("curve.csv", "axial_strain,axial_stress_Pa [Pa]\n" + rows)
    path, out = write("calibration.toml", CALIBRATION), os.path.join(folder, "out")
    status, said, errors = made_up.command(main, path, "--threads=-1")
    need(status == 2 and "--threads" in errors, f"--threads=-1: exit {status} {errors}")
    made_up.calls(programs)
    status, said, errors = made_up.command(main, path, "--check", "--threads", "2")
    asked = {line.split("a=")[1].split()[0] for line in made_up.calls(programs)}
    need(asked == {"80.0", "100.0", "125.0"}, f"what is checked: both ends and the middle: {asked}")
    need(status == 0 and said.splitlines()[:2] == ["a: 80.0 … 125.0 (log)", "b: 0.0 … 100.0"]
         and said.splitlines()[-1] == "18 points, 2 runs each, 108 s to 26 min on 2 cores", f"--check: {said} {errors}")
    status, said, errors = made_up.command(main, path, "-o", out, "--threads", "2")
    need(status == 0 and not errors, f"exit {status} {said} {errors}")
    if status:
        return
    with open(os.path.join(out, "calibration.csv"), newline="") as f:
        head, first, *rows = csv.reader(f)
    need(head == ["slope", "b", "failed", "curve[0]", "curve[1]", "curve[2]", "peak"], f"calibration.csv: {head}")
    near([float(v) for v in first[3:]], data, "the data in calibration.csv", 1e-8)
    table = np.array(rows, float)
    need(len(table) == 18 and (table[:, 2] == 0).all(), f"{len(table)} points of two runs")
    exact = np.array([[*model(a, b, strains), model(a, b, 0.2)] for a, b in table[:, :2]])
    near(table[:, 3:], exact, "answers of points", 1e-7)
    with open(os.path.join(out, "calibration.json")) as f:
        found = json.load(f)
    a, b = (p["value"] for p in found["parameters"])
    ratio = 125 / 80
    error = np.array([0.05, 0.05, 0.05, 0.1])
    cost = lambda values: (weight / error**2 * (values - data) ** 2).sum(axis=-1)
    near(found["checked_by_runs"]["best"], cost(np.array([*model(a, b, strains), model(a, b, 0.2)])), "best", 1e-5)
    near(found["checked_by_runs"]["values"], exact[-5], "values at the best point", 1e-7)
    near(table[-5, :2], [a, b], "the best point is run", 1e-7)
    sides, number = found["checked_by_runs"]["sides"], (lambda u: 80 * ratio**u, lambda u: 100 * u)
    place = (math.log(a / 80) / math.log(ratio), b / 100)
    for k, (p, side) in enumerate(zip(found["parameters"], sides)):
        near(side["at"], [number[k](place[k] + s * p["sd_of_range"]) for s in (-1, 1)], "one deviation away", 1e-7)
        near(table[[14 + 2 * k, 15 + 2 * k], k], side["at"], "is run", 1e-7)
        near(side["sum_of_squares"], cost(exact[[14 + 2 * k, 15 + 2 * k]]), "sums of squares", 1e-6)
        near(p["sd"], p["sd_of_range"] * (a * math.log(ratio), 100)[k], "deviation in its own unit", 1e-9)
    need([(p["key"], p["name"], p["scale"], p["unit"]) for p in found["parameters"]] ==
         [("a", "slope", "log", ""), ("b", "b", "linear", "")], f"{found['parameters']}")
    need((found["method"], found["points"], found["failed_points"], found["refused_points"], found["refusal"]) ==
         ("regression", 18, 0, 0, None), "counts of points")
    best = min(cost(np.array([*model(u, v, strains), model(u, v, 0.2)])) for u in np.linspace(0.98 * a, 1.02 * a, 41)
               for v in np.linspace(b - 5, b + 5, 41))
    need(found["checked_by_runs"]["best"] < best + 1, f"the best point: {found['checked_by_runs']}, {best}")
    curve, peak = found["targets"]
    told = [curve[k] for k in ("name", "kind", "points", "runs", "stronger_than", "still_rising")]
    need(told == ["curve", "curve", 3, 36, 0, 0], f"the curve: {told}")
    need((peak["points"], peak["still_rising"]) == (1, 36), f"the peak: {peak}")
    need("in 36 of 36 runs the peak is the last row" in said, f"peaks at the end are not told: {said}")
    correlation = np.array(found["correlation"])
    near(np.diag(correlation), [1, 1], "a parameter with itself")
    near(correlation[0, 1], correlation[1, 0], "either way round")
    need(correlation[0, 1] < -0.3, f"a slope against a bend: {correlation}")
    last = found["by_points"][-1]
    near((last["points"], *last["values"], *last["sd_of_range"]),
         (13, a, b, *(p["sd_of_range"] for p in found["parameters"])), "by the number of points")
    with open(os.path.join(out, "best.toml"), "rb") as f:
        scene = tomllib.load(f)
    near((scene["a"], scene["b"]), (a, b), "best.toml", 1e-9)
    need(scene["graded"] == 1 and scene["made_up"]["rows"] == 20, f"best.toml: {scene}")
    line = f"a = {a:.5g} (sd {found['parameters'][0]['sd']:.2g}): {found['parameters'][0]['verdict']}"
    need(line in said, f"not told: {line}")
    far = [t["name"] for t in found["targets"] if t["rms_in_standard_deviations"] > 3]
    need(not far and "deviations off" not in line, f"a good fit: {far} {line}")
    # How it ends where runs fail, and where the program refuses values within the ranges.
    for settings, wanted in (("fails = [2]", (1, "known.toml, seed 2: no room")),
                             ("refused_from = 60.0", (2, "scene: a: too large"))):
        bad = write("bad.toml", CALIBRATION.replace("graded = 1", settings))
        status, said, errors = made_up.command(main, bad, "-o", os.path.join(folder, "bad"), "--quiet")
        need(status == wanted[0] and wanted[1] in errors, f"{settings}: exit {status} {said} {errors}")
    short = CALIBRATION.replace("budget = 36", "budget = 10\ncheck = false")
    two = write("two.toml", short.replace("seeds = [1, 2]", "seeds = [1]")
                .replace("weight = 2", "weight = 2, set = { rows = 40 }"))
    status, said, errors = made_up.command(main, two, "-o", os.path.join(folder, "two"), "--quiet")
    left = {}
    for name in os.listdir(os.path.join(folder, "two")):
        if name.startswith("best"):
            with open(os.path.join(folder, "two", name), "rb") as f:
                left[name] = tomllib.load(f)
    need(status == 0 and len(left) == 3 and sum(name.startswith("best_known_") for name in left) == 2
         and sorted(f.get("rows", 0) for f in left.values()) == [0, 0, 40] and "rows" not in left["best.toml"],
         f"scenes of two kinds of runs: {status} {errors} {left}")
    unstable = write("unstable.toml", short.replace("graded = 1", "unstable = [2]"))
    status, said, errors = made_up.command(main, unstable, "-o", os.path.join(folder, "unstable"), "--quiet")
    with open(os.path.join(folder, "unstable", "calibration.json")) as f:
        need(status == 0 and json.load(f)["failed_points"] == 5, f"runs that become unstable: {status} {errors}")


def said():
    from grus.calibrate import report
    from grus.calibrate.command import Evaluation
    evaluation, before, sys.stderr = Evaluation(None, [], [], [], 1, 10, False), sys.stderr, io.StringIO()
    sys.stderr.isatty = lambda: True
    evaluation.start, evaluation.points = time.time() - 8, 3
    evaluation.show(1.0)
    line, sys.stderr = sys.stderr.getvalue(), before
    need(re.fullmatch(r"\r4.0 of 10 points  ETA 1[2-9] s   ", line), f"how far it is: {line!r}")
    target = {"name": "t", "rms_in_standard_deviations": 2.9, "stronger_than": 0, "runs": 9, "still_rising": 0}
    of = lambda refused=0, **more: report.said_of_runs({"targets": [{**target, **more}], "refused_points": refused,
                                                        "points": 7, "refusal": "why"})
    need(of() == [] and "3.1 standard deviations off" in of(rms_in_standard_deviations=3.1)[0]
         and "2 of 9 grains did not break" in of(stronger_than=2)[0] and "in 4 of 9 runs the peak" in
         of(still_rising=4)[0] and of(3) == ["3 of 7 points were refused and count as failed: why"], "what is told")


surfaces()
answers()
deviations()
fits()
words()
said()
with tempfile.TemporaryDirectory() as place:
    commands(place)
tmp.cleanup()
print(f"calibrate_numbers: {len(faults)} faults")
sys.exit(1 if faults else 0)
