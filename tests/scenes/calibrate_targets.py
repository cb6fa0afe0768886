#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What grus-calibrate reads of files and of runs: curves, kinks, each kind of target with its covariance, parameters
and their units, by hand. calibrate_targets.py BIN"""
import math
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.calibrate import posterior, reader  # noqa: E402
from grus.calibrate.targets import Target, along, kink  # noqa: E402
from grus.errors import InputError  # noqa: E402
from grus.files.texts import BadData  # noqa: E402

import made_up  # noqa: E402
from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402

nan = math.nan


def refused(kind, words, work):
    try:
        work()
        need(False, f"not refused: {words}")
    except kind as e:
        need(words in str(e), f"{e} does not say {words}")


def curves():
    x = np.array([1.0, 3.0, 2.0, 3.0, 10.0, 40.0])  # falls on the way: only where it is first reached counts
    at = [1.0, 2.0, 5.0, 20.0, 40.0]
    near(along(x, np.log(x), at, True), np.log(at), "ln x in the logarithm of x")
    near(along(x, 2 * x + 1, at), 2 * np.array(at) + 1, "a line")
    near(along([0.0, 1.0, 3.0], [5.0, 1.0, 2.0], [2.0], True), [1 + math.log(2) / math.log(3)], "beside a 0")
    near(along(x, [1.0, 3.0, 7.0, 8.0, nan, 40.0], [2.0, 21.5]), [2, 21.5], "beside a row without a number")
    near(along(x, x, [0.9, 40.1]), [nan, nan], "beyond both ends")
    near(along([nan], [nan], [1.0]), [nan], "no row at all")
    bent = lambda x, at, below, above: below * x + (above - below) * np.maximum(0, x - at)
    for at in (0.15, 0.5, 0.9):  # it is sought at 181 places, of which these are some
        x = np.linspace(0, 1, 41)
        near(kink(x, bent(x, at, -0.1, -0.9), log=False), at, "a kink", 1e-9)
        stress = np.exp(5 * x)
        found = math.log(kink(stress, 0.8 + bent(x, at, -0.1, -0.9))) / 5
        need(abs(found - at) < 0.9 / 360 + 1e-9, f"a kink in the logarithm, at {at}: {found}")
    beyond = [kink(x, bent(x, at, -0.1, -0.9), log=False) for at in (0.02, 0.98)]
    near(beyond, [0.05, 0.95], "kinks beyond the rim", 1e-9)
    back = np.concatenate([stress[:20], stress[10:20], stress[20:]])  # unloaded and loaded again
    void = bent(np.log(back) / 5, 0.9, -0.1, -0.9) + np.concatenate([np.zeros(20), np.full(10, 7.0), np.zeros(21)])
    need(abs(math.log(kink(back, void)) / 5 - 0.9) < 0.003, "a kink beside unloading")
    need(math.isnan(kink([1, 2, 3, 4, 5], [1, 2, 3, 4, 5])), "a kink of five rows")


def data_of_targets(folder):
    def target(text="", **table):
        with open(os.path.join(folder, "d.csv"), "w") as f:
            f.write(text)
        return Target({"name": "t", **({"data": "d.csv"} if text else {}), **table}, folder)

    t = target("x,y\n1,10\n2,30\n", x="x", y="y", weight=3, specimens=5)
    near((t.x, t.values, t.error, t.weight, t.specimens), ([1, 2], [10, 30], [0.4, 0.4], [1.5, 1.5], [5, 5]), "a curve")
    t = target("x,y,error\n1,10,2\n2,30,4\n", x="x", y="y", error=9.0)
    near(t.error, [2, 4], "errors that the file has")
    near(target("x,y\n1,10\n2,30\n", x="x", y="y", error=9.0).error, [9, 9], "one error for all")
    t = target("value (Pa)\n5\n3\n11\n", kind="quantiles", quantity="results.peak_axial_stress_Pa")
    near((t.values, t.x, t.weight, t.specimens), ([3, 5, 11], [1 / 6, 0.5, 5 / 6], [1 / 3] * 3, [0] * 3), "quantiles")
    t = target(kind="value", quantity="q", value=-4.0)
    near((t.values, t.error, t.weight), ([-4], [0.08], [1]), "a value")
    near(target(kind="value", quantity="q", value=0.0).error, [0.02], "a value of 0")
    near(target("x,y\n1,-5\n2,-5\n", x="x", y="y").error, [0.1, 0.1], "a curve that does not change")
    for text, table, words in (("x,y\n0,1\n1,2\n", {"x": "x", "y": "y", "x_scale": "log"}, "x must be above 0"),
                               ("diameter_m,passing\n1,1.1\n", {"kind": "grading", "at": 0}, "between 0 and 1"),
                               ("diameter_m,passing\n0,1\n", {"kind": "grading", "at": 0}, "diameter_m above 0"),
                               ("x,y,error\n1,2,0\n", {"x": "x", "y": "y"}, "standard deviations are above 0")):
        refused(BadData, words, lambda: target(text, **table))
    of = lambda **table: target(**{"quantity": "q", "value": 1.0, **table}).columns()
    need([of(kind="value"), of(kind="value", at=0.1), of(kind="peak"), of(kind="yield"), of(kind="value",
                                                                                             quantity="a.b")] ==
         [{"q"}, {"q", "axial_strain"}, {"q"}, {"axial_stress_Pa", "void_ratio"}, set()], "columns of targets")
    answers_of_runs(target)


def answers_of_runs(target):
    """(values, covariance of one run, seeds) of runs with known numbers."""
    key = "results.peak_before_breakage_Pa"
    runs = [made_up.run(y=v, z=10.0 + v, results={"peak_before_breakage_Pa": v, "k": v}) for v in (1.0, 4.0, 7.0, 2.0,
                                                                                                11.0)]
    # The median of 1 2 4 7 11; without each in turn 5.5, 5.5, 4.5, 3, 3: four times their squares about 4.3.
    median = target("value (Pa)\n5\n", kind="quantiles", quantity=key)
    values, between, n = median.answer(runs)
    near((values, between, n), ([4], [4 * 6.3], 5), "covariance of a median of 5")
    need(median.told == {"runs": 5, "stronger_than": 0, "still_rising": 0}, f"{median.told}")
    # The least and the largest of three; without each in turn 4 7, 1 7, 1 4 at the sixth and the five sixths.
    pair = target("value (Pa)\n1\n2\n3\n", kind="quantiles", quantity=key).answer(runs[:3])
    parts = np.array([np.interp([1 / 6, 0.5, 5 / 6], [0.25, 0.75], v) for v in ([4, 7], [1, 7], [1, 4])])
    near(pair[0], [1, 4, 7], "three quantiles of three")
    near(pair[1], 6 * np.cov(parts.T, bias=True), "their covariance")
    near(median.answer(runs[:2])[1], [[0]], "a jackknife of two")
    broke_not = made_up.run(breakages=[0.0] * 3, results={"peak_axial_stress_Pa": 6.0})
    values, between, _ = median.answer([*runs[:2], broke_not])
    near((values[0], median.told["stronger_than"]), (4, 1), "a median beside one that did not break")
    near(between, 6 * np.var([6.0, 6.0, 2.5]), "its covariance")  # without 1, 4 and the bound
    # Runs that say nothing stand aside: without each of four the medians of two, or of one, beside them.
    dumb = [made_up.run(breakages=[0.0, 0.0, 1.0]) for _ in range(2)]
    for known, without in ((runs[:2], [2.5, 2.5, 4, 1]), (runs[:1], [1, 1, 1])):
        values, between, n = median.answer([*dumb, *known])
        near((values[0], n, between), (np.mean([r["columns"]["y"][-1] for r in known]), 2 + len(known),
                                       (n - 1) * n * np.var(without)), "a median beside runs that say nothing")
    near(median.answer(dumb)[:2], ([nan], [[0]]), "runs that say nothing")
    value = target(kind="value", quantity="y", value=1.0, at=0.5)
    near(value.answer(runs)[0], [2.5], "mean of a value")
    near(value.answer(runs)[1], [[np.var([1, 4, 7, 2, 11], ddof=1) / 4]], "its variance from run to run")
    short = made_up.run(axial_strain=[0.0, 0.1, 0.2], y=9.0)
    near(value.answer([*runs[:2], short])[0], [1.25], "a mean without what is not reached")
    near(value.answer([*runs[:2], short])[1], [[2 * 0.75**2 / 2]], "its variance")
    near(value.answer([short])[0], [nan], "what no run reaches")
    near(target(kind="value", quantity="results.k", value=1.0).answer(runs[:2])[0], [2.5], "a key of summary.json")
    near(target(kind="value", quantity="y", value=1.0).answer(runs[:2])[0], [2.5], "a column at the end")
    curve = target("y,z\n0.5,1\n1,2\n", x="y", y="z")
    values, between, _ = curve.answer([made_up.run(y=2.0, z=6.0), made_up.run(y=2.0, z=[0.0, 4.0, 9.0])])
    near((values, *between), ([1.75, 3.5], [0.125, 0.25], [0.25, 0.5]), "a curve and its covariance")
    peak = target(kind="peak", quantity="y", value=1.0)
    near(peak.answer([made_up.run(y=[0.0, 8.0, nan]), made_up.run(y=[0.0, 1.0, 4.0])])[0], [6], "peaks")
    need(peak.told["still_rising"] == 1, f"peaks that are the last row: {peak.told}")
    x = np.linspace(0, 1, 41)
    rows = {"axial_stress_Pa": np.exp(5 * x), "void_ratio": 0.8 - 0.1 * x - 0.8 * np.maximum(0, x - 0.5)}
    bent = made_up.run(**rows)
    near(target(kind="yield", value=1.0).answer([bent])[0], [math.exp(2.5)], "a yield point", 0.013)
    straight = made_up.run(p=x, e=rows["void_ratio"])
    near(target(kind="yield", value=1.0, x="p", y="e", x_scale="linear").answer([straight])[0], [0.5],
         "a yield point of other columns, without the logarithm", 0.006)
    # Halfway in the logarithm of the diameter between two classes, and a quarter between two states.
    state = lambda *passing: [{"diameter_m": d, "passing": p} for d, p in zip((4e-4, 1e-4, 0.0), (*passing, 0.0))]
    graded = made_up.run(grading={0.8: state(1.0, 0.6), 0.0: state(0.9, 0.1)}, axial_stress_Pa=100.0)
    sieve = "diameter_m,passing\n2e-4,0.5\n4e-4,0.9\n1e-5,0.1\n"
    for at in ({"at": 0.2}, {"at": "20 Pa", "at_stress": 20.0}):
        found = target(sieve, kind="grading", **at).answer([graded])[0]
        near(found, [0.75 * 0.5 + 0.25 * 0.8, 0.75 * 0.9 + 0.25, 0.75 * 0.1 + 0.25 * 0.6], f"a grading at {at}")
    near(target(sieve, kind="grading", at=0.9).answer([graded])[0], [nan] * 3, "a grading beyond the last state")
    near(target(sieve, kind="grading", at=0.1).answer([made_up.run()])[0], [nan] * 3, "a run without gradings")


def parameters():
    make = lambda low, high, **more: reader.Parameter("here", {"key": "a.b.c", "min": low, "max": high, **more})
    line, log = make(2, 6), make("10 GPa", "0.04 TPa", scale="log")
    near([line.number(u) for u in (-1, 0, 0.25, 1, 2)], [2, 2, 3, 6, 6], "a range")
    near([log.number(u) for u in (0, 0.5, 1)], [10, 20, 40], "a range in its logarithm")
    need((line.name, line.unit, log.unit, log.setting(0.5), line.setting(0.25)) ==
         ("c", "", "GPa", "20.0 GPa", 3.0), f"{log.setting(0.5)} {line.setting(0.25)}")
    for p in (line, log):  # to first order: against differences
        h = 1e-5
        near(p.deviation(0.3, 0.1), 0.1 * (p.number(0.3 + h) - p.number(0.3 - h)) / (2 * h), "deviation", 1e-8)
    need((line.text(0.25, 0.1), log.text(0.5, 0.1)) == ("3 ± 0.4", f"20 GPa ×/÷ {4**0.1:.3g}"), log.text(0.5, 0.1))
    for low, high, more, said in ((1, 1, {}, "min must be below max"), (0, 1, {"scale": "log"}, "min above 0"),
                                  ("1 m", "2 s", {}, "different units"), ("x", 1, {}, "no number")):
        refused(InputError, said, lambda: make(low, high, **more))
    walkers()
    draws = np.column_stack([np.linspace(0, 1, 1001), np.linspace(0, 1, 1001) ** 2])
    rows = posterior.table(draws, [line, log])
    near([rows[0]["median"], *rows[0]["middle_68"], *rows[0]["middle_95"]], [4, 2.64, 5.36, 2.1, 5.9],
         "quantiles of draws", 1e-9)
    near([rows[1]["median"], *rows[1]["middle_68"]], [10 * 4**u for u in (0.25, 0.16**2, 0.84**2)],
         "quantiles of draws in the logarithm", 1e-9)


def walkers():
    """Where a sampler's walkers start, and what it is asked to sample: a sampler in emcee's place hears it."""
    heard = {}

    class Sampler:
        def __init__(self, walkers, p, density):
            heard.update(walkers=walkers, p=p, density=density)

        def run_mcmc(self, start, steps):
            heard.update(start=start, steps=steps)

        def get_autocorr_time(self, discard, **_):
            return np.array([2.0, 4.0])

        def get_chain(self, discard, flat):
            return np.full((heard["steps"] - discard, 2), 0.5)

    before, posterior.sampler = posterior.sampler, lambda: type("", (), {"EnsembleSampler": Sampler})
    slope, noise = np.array([[2.0, 1.0], [0.5, -1.0]]), np.array([[0.04, 0.01], [0.01, 0.09]])
    for sd, cut in ((0.01, 0.01), (5.0, 0.2)):  # a spread of a fifth of the range at most
        result = type("", (), {"x": np.array([0.5, 0.0]), "covariance": sd**2 * np.eye(2), "noise": noise,
                               "surface": type("", (), {"at": lambda self, x: slope @ x})()})
        draws, worth = posterior.posterior(result, type("", (), {"values": np.array([1.0, 0.2])}))
        start = heard["start"]
        need((heard["walkers"], heard["p"], start.shape) == (32, 2, (32, 2)), f"{heard}")
        need(0.6 * cut < start[:, 0].std() < 1.2 * cut and start.min() > 1e-6 and start.max() < 1 - 1e-6
             and len(set(start[:, 1])) == 32, f"where walkers start: {start}")
        near((len(draws), worth), (posterior.STEPS - posterior.REST, len(draws) / 4), "draws, and what they are worth")
        at = np.array([0.3, 0.6])
        rest = slope @ at - [1.0, 0.2]
        near(heard["density"](at), -0.5 * rest @ np.linalg.solve(noise, rest), "density", 1e-9)
        need([heard["density"](np.array(x)) for x in ([-1e-9, 0.5], [0.5, 1 + 1e-9])] == [-math.inf] * 2, "beyond")
        need(all(math.isfinite(heard["density"](np.array(x))) for x in ([0.0, 1.0], [1.0, 0.0])), "at the bounds")
    posterior.sampler = before


curves()
with tempfile.TemporaryDirectory() as place:
    data_of_targets(place)
parameters()
print(f"calibrate_targets: {len(faults)} faults")
sys.exit(bool(faults))
