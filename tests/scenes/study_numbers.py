#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What grus-study makes of runs, number by number: by hand, or by SciPy and NumPy where these know another way.
study_numbers.py BIN"""
import csv
import math
import os
import sys
import tempfile
from types import SimpleNamespace

import numpy as np
from scipy import stats

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.figures import plt  # noqa: E402
from grus.runs import censored  # noqa: E402
from grus.study import numbers, statistics, words  # noqa: E402
from grus.study.kinds import check, fit, plot, precision, sweep, table  # noqa: E402

import made_up  # noqa: E402
from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def intervals():
    """Half a 95 % interval is where Student's and Welch's tests give a probability of 5 %."""
    a, b, c = [3.0, 4.5, 2.5, 5.0, 4.0], [1.0, 9.0, 2.0], [2.9, 4.1, 2.6, 4.4, 4.2]
    near(statistics.mean(a), np.mean(a), "mean")
    near(statistics.deviation(a), np.std(a, ddof=1), "deviation")
    need(statistics.deviation([3.0]) == 0 and math.isnan(statistics.mean([])), "deviation of one, mean of none")
    need(math.isnan(statistics.deviation([])), "deviation of none")
    for values in (a, b):
        m, half = statistics.interval(values)
        near((m, m + half), (np.mean(values), stats.t.interval(0.95, len(values) - 1, m, stats.sem(values))[1]),
             "interval")
    near(statistics.interval(a, 0.5)[1], stats.sem(a) * stats.t.ppf(0.75, 4), "interval that holds half")
    need(math.isnan(statistics.interval([1.0])[1]), "an interval of one value")
    for x, y in ((a, b), (b, a), (a, c)):  # of unequal sizes and scatters, either way round
        off, half = statistics.difference(x, y, False)
        near(off, np.mean(x) - np.mean(y), "difference of means")
        for edge in (off - half, off + half):
            p = stats.ttest_ind(np.array(x) - edge, y, equal_var=False).pvalue
            near(p, 0.05, f"Welch's probability at the end of the interval of {x} and {y}", 1e-9)
    off, half = statistics.difference(a, c, True)
    near(stats.ttest_rel(np.array(a) - off - half, c).pvalue, 0.05, "Student's probability of pairs", 1e-9)
    off, half = statistics.difference(a, [1.5], False)
    near(stats.ttest_1samp(a, 1.5 + off - half).pvalue, 0.05, "against a number", 1e-9)
    near(off, np.mean(a) - 1.5, "difference from a number")
    off, half = statistics.difference([2.0], b, False)
    need(off == -2 and math.isnan(half), f"one against three: {off} +- {half}")
    near(statistics.difference([2.0, 2.0], [1.0, 1.0, 1.0], False), (1, 0), "what does not scatter")


def laws():
    x, y = [1.0, 2.0, 3.0, 5.0, 8.0], [2.0, 9.0, 17.0, 55.0, 120.0]
    slope, covariance = np.polyfit(np.log(x), np.log(y), 1, cov=True)  # residuals over the freedom left
    near(statistics.power_law(zip(x, y)), (slope[0], math.sqrt(covariance[0, 0])), "power law", 1e-9)
    near(statistics.power_law([*zip(x, y), (0.0, 1.0), (1.0, -1.0)]), statistics.power_law(zip(x, y)),
         "a power law beside what has no logarithm")
    need(statistics.power_law([(2.0, 1.0), (2.0, 3.0)]) is None, "a power law of one place")


def of_runs():
    c = {"axial_strain": [0.0, 0.1, 0.3, 0.2, 0.4], "t": [0.0, 1.0, 2.0, 3.0, 4.0], "y": [1.0, 2.0, 6.0, 9.0, 5.0]}
    for x, wanted in ((0.0, 1.0), (0.05, 1.5), (0.1, 2.0), (0.25, 5.0), (0.3, 6.0), (0.35, 6.0), (0.4, 5.0),
                      (0.4 + 3e-10, 5 - 6e-9), (0.4 + 1e-6, math.nan), (0.41, math.nan), (-0.1, math.nan)):
        near(numbers.position(c, "y", x), wanted, f"y where the strain is first {x}", 1e-9)
    near(numbers.position(c, "y", 2.5, "t"), 7.5, "y at a time")
    c["void_ratio"] = [0.8, 0.7, 0.6, 0.65, 0.5]  # falls; what it passes again counts once
    for x, wanted in ((0.8, 1.0), (0.75, 1.5), (0.7, 2.0), (0.63, 4.8), (0.6, 6.0), (0.55, 9 - 4 * 2 / 3), (0.5, 5.0),
                      (0.5 - 4e-10, 5 - 1.6e-9 / 0.15), (0.49, math.nan), (0.81, math.nan)):
        near(numbers.position(c, "y", x, "void_ratio"), wanted, f"y where the void ratio is first {x}", 1e-8)
    asked = {"quantity": "y", "over": "t", "at": 0.5}
    for how, wanted in (("peak", 9), ("last", 5), ("area", 1.5 + 4 + 7.5 + 7), ("at", 1.5)):
        near(numbers.measured(c, {**asked, "measure": how}), wanted, how)
    near(numbers.measured(c, {"quantity": "y", "measure": "area"}), 0.15 + 0.8 - 0.75 + 1.4, "area over the strain")
    near(numbers.measured(c, {"quantity": "y", "at": 0.05}), 1.5, "at a strain, without a measure")
    runs = [{"columns": c, "summary": {"results": {"k": 7, "deep": {"x": 3}}}}, made_up.run(y=4.0, results={"k": 9})]
    near(numbers.found(runs, "y", 0.2), [(4.0, math.nan), (0.8, math.nan)], "a column at a strain")
    near(numbers.found(runs, "y"), [(5.0, math.nan), (4.0, math.nan)], "a column at the end")
    near(numbers.found(runs, "results.k"), [(7, math.nan), (9, math.nan)], "keys of summary.json")
    near(numbers.of_summary(runs[0], "results.deep.x"), 3, "a key below a key")
    need(math.isnan(numbers.of_summary(runs[0], "results.none")), "a key that is not there")
    near(censored.number_of(runs[0], "deep.x"), math.nan, "half a key")
    near(censored.number_of(runs[0], "y"), 5.0, "a column's last value")
    need(censored.number_of(runs[0], "k") == 7, "a key of results by its last word")
    own = {"columns": {"y": [1.0, 2.0]}, "summary": {"seconds": {"cpu_rank0": 4.0, "solve_wall": 3.0, "else_wall": 9.0},
                                                     "counts": {"dem_steps": 50, "grains_a_point": 7,
                                                                "rves_advanced": 11},
                                                     "errors": {"worst_rve_energy_error": 0.2}}}
    need(numbers.cost(own) == {"cpu": 4.0, "wall": 3.0, "grain_steps": 350, "rves": 11}, f"{numbers.cost(own)}")
    need(numbers.energy_error(own) == 0.2, "energy error of a macro problem")
    paid = numbers.cost(made_up.run(cpu=3.0, energy=0.1, counts={"grain_steps": 5, "dem_steps": 9}))
    need(paid == {"cpu": 3.0, "wall": 6.0, "grain_steps": 5, "rves": 0}, f"cost of a sample: {paid}")
    need(numbers.energy_error(made_up.run(energy=0.1)) == 0.1, "energy error of a sample")
    nan = math.nan
    for pairs, text in (([(1.0, nan), (2.0, nan), (6.0, nan)], "3 ± 2.6"), ([(3.25, nan)], "3.25"),
                        ([(nan, nan), (1.0, nan)], "-"), ([(nan, 8.0), (4.0, nan)], "> 6 (1 of 2 not broken)"),
                        ([(nan, 8.0), (nan, nan)], "- (1 of 2 not broken)")):
        need(numbers.cell_text(pairs) == text, f"{pairs}: {numbers.cell_text(pairs)!r} instead of {text!r}")
    need([words.short(1 / 3), words.short(7), words.percent(nan), words.percent(0.0123), words.percent(math.inf)] ==
         ["0.3333", "7", "-", "1.2 %", "not reached"], "words of numbers")
    need([words.describe({"quantity": "q", "at": 0.1}), words.describe({"quantity": "q", "at": 2, "over": "t"}),
          words.describe({"quantity": "q", "measure": "peak"})] ==
         ["q at axial_strain 0.1", "q at t 2", "q, peak"], "words of places")


def strengths():
    key = "results.peak_before_breakage_Pa"

    def grain(broke, bore, breakages):
        return {"columns": {"breakages": [0.0, breakages]}, "summary": {"results": {
            "peak_axial_stress_Pa": bore, **({} if broke is None else {"peak_before_breakage_Pa": broke})}}}
    for run, wanted in ((grain(5.0, 9.0, 1.0), (5, math.nan)), (grain(None, 9.0, 0.0), (math.nan, 9)),
                        (grain(9.0, 9.0, 0.0), (math.nan, 9)), (grain(0.0, 9.0, 1.0), (math.nan, math.nan))):
        near(censored.strength_of(run, key), wanted, f"strength of {run}")
    near(censored.strength_of(grain(5.0, 9.0, 1.0), "results.peak_axial_stress_Pa"), (9, math.nan), "another number")
    near(censored.mean_of([(1.0, math.nan), (math.nan, 5.0)]), (math.nan, 3, 1), "mean with a bound")
    near(censored.mean_of([(1.0, 7.0), (4.0, math.nan)]), (2.5, 2.5, 0), "mean of known values")
    near(censored.mean_of([(1.0, math.nan), (math.nan, math.nan)]), (math.nan, math.nan, 0), "mean of what is unknown")
    # A grain that bore as much as one broke at was there when that one broke: one of three, then one of one.
    near(censored.places([2.0, 1.0], [1.0])[1], [1 / 6, 1 / 3 + 1 / 3], "a bound that is a value")
    shares = censored.places([1.0, 2.0, 4.0], [9.0])[1]  # each a quarter: in its middle
    near(shares, [1 / 8, 3 / 8, 5 / 8], "shares of known values")
    near(censored.quantiles([4.0, 1.0, 2.0], [9.0], [0.5, 0.63]), [3, 9], "between known values, and beyond the last")
    near(censored.places([2.0, 1.0, 1.0], [])[1], [1 / 6, 0.5, 5 / 6], "two that break together")
    near(censored.quantiles([1.0, 3.0], [], [0.0, 0.25, 0.5, 0.75, 1.0]), [1, 1, 2, 3, 3], "quantiles of two")
    near(censored.quantiles([], [4.0, 2.0], [0.5, 0.9]), [4, 4], "quantiles of none that broke")
    near(censored.quantiles([1.0, 3.0], [2.0], [0.9]), [3], "beyond the last, above all bounds")


def claims():
    """Each kind of claim, as it holds and by a little not."""
    runs = {"low": [made_up.run(y=v, results={"k": 10 * v}) for v in (0.9, 1.1)], "high": [made_up.run(y=1.5)],
            "minus": [made_up.run(y=-2.0)]}
    of = {"claim": "c", "quantity": "y", "case": "low"}
    pair = {"claim": "c", "quantity": "y", "greater": ["high", "low"]}
    for claim, wanted in (
            ({"near": 1.0, "tolerance": 0.11}, True), ({"near": 1.0, "tolerance": 0.05}, False),  # their mean is near
            ({"near": -1.0, "tolerance": 0.5}, False), ({"case": "minus", "near": -2.0, "tolerance": 1e-9}, True),
            ({"between": [0.9, 1.1]}, True), ({"between": [0.95, 1.2]}, False), ({"between": [0.8, 1.0]}, False),
            ({"between": [1.2, 2.0]}, False), ({"below": 1.1}, True), ({"below": 1.05}, False),
            ({"case": "minus", "below": 1.9}, False), ({"case": "minus", "below": 2.0}, True),
            ({"cases": ["low", "high"], "below": 1.4}, False), ({"cases": ["low", "high"], "below": 1.5}, True),
            ({"at": [0.5], "below": 0.55}, True), ({"at": [0.5, 1.0], "below": 0.55}, False),
            ({"quantity": "results.k", "between": [9, 11]}, True), ({"quantity": "results.k", "below": 9}, False)):
        given = {**{k: v for k, v in of.items() if not (k == "case" and "cases" in claim)}, **claim}
        ok, said = check.check_of(given, runs)
        need(ok == wanted, f"{given}: {ok}, {said}")
    for claim, wanted in (({}, True), ({"factor": 1.49}, True), ({"factor": 1.51}, False), ({"factor": 2.0}, False),
                          ({"greater": ["low", "high"]}, False), ({"greater": ["low", "high"], "factor": 0.6}, True),
                          ({"greater": ["low", "low"]}, False), ({"at": [0.5], "factor": 1.49}, True),
                          ({"at": [0.5, 1.0], "factor": 1.51}, False)):
        ok, said = check.check_of({**pair, **claim}, runs)
        need(ok == wanted, f"{claim}: {ok}, {said}")
    # A run that did not finish is evidence of nothing but how far it got.
    cut = {**runs, "low": [*runs["low"], made_up.run(y=1.0, status=3, results={"final_time_s": 1.0})]}
    for claim, of_it in ((of, {"below": 9}), (of, {"near": 1.0, "tolerance": 9}), (of, {"between": [0, 9]}),
                         (pair, {})):
        need(check.check_of({**claim, **of_it}, cut) == (False, f"1 of {4 if claim is pair else 3} runs did not finish "
                                                                "(status 3)"), f"a run that stopped: {of_it}")
    need(check.check_of({"case": "low", "quantity": "results.final_time_s", "below": 2.0}, {"low": cut["low"][2:]})[0],
         "how far a run got that stopped")
    crossing = {"a": [made_up.run(y=[0.0, 5.0, 1.0])], "b": [made_up.run(y=[0.0, 1.0, 5.0])]}
    for names in (["a", "b"], ["b", "a"]):
        need(not check.check_of({**pair, "greater": names, "at": [0.5, 1.0]}, crossing)[0],
             f"{names}: greater at one strain of two")
    for claim, said in (({"near": 1.0, "tolerance": 0.1}, "1 against 1: 10.00 % off at worst"),
                        ({"between": [0, 2]}, "0.9 … 1.1, asked 0 … 2"), ({"below": 3}, "at most 1.1, asked 3")):
        need(check.check_of({**of, **claim}, runs)[1] == said, f"{claim}: {check.check_of({**of, **claim}, runs)[1]!r}")
    said = check.check_of({**pair, "at": [0.5]}, runs)[1]
    need(said == "high / low: 0.75 / 0.5 = 1.5 at 0.5", f"greater: {said!r}")
    entries = [{**of, "below": 2.0}, {**of, "claim": "d", "below": 1.0}, {**of, "claim": "e", "below": 2.0}]
    shown = check.show(entries, SimpleNamespace(runs=runs))
    need([line.split("  ")[0] for line in shown.text.splitlines()[2:]] == ["holds", "DOES NOT HOLD", "holds"]
         and not shown.passed and check.show(entries[::2], SimpleNamespace(runs=runs)).passed, f"{shown}")


def precisions(folder):
    """A table of errors, each number from runs of known values and costs; three seeds, a reference of three."""
    entry = {"name": "p", "quantity": "y", "at": 0.5, "vary": {"h": [0.4, 0.2, 0.1]}}
    runs = lambda values, cpu, **more: [made_up.run(y=2 * v, cpu=cpu + k, energy=0.01 * (k + 1), **more)
                                        for k, v in enumerate(values)]
    reference, coarse, fine = [10.0, 11.0, 15.0], [13.0, 14.5, 18.0], [10.5, 11.0, 14.5]
    rows = [({"h": 0.4}, runs(coarse, 1.0, counts={"grain_steps": 6.0})), ({"h": 0.2}, runs(fine, 3.0))]
    for paired in (True, False):
        result = precision.judge({**entry, "paired": paired}, rows, runs(reference, 9.0), ".")
        for row, values in zip(result["rows"], (coarse, fine)):
            off = np.subtract(values, reference)
            half = (stats.sem(off) * stats.t.ppf(0.975, 2) if paired else
                    statistics.difference(values, reference, False)[1])
            near([row[k] for k in ("value", "signed", "error", "interval", "scatter")],
                 [np.mean(values), off.mean() / 12, abs(off.mean()) / 12, half / 12,
                  stats.sem(values) * stats.t.ppf(0.975, 2) / 12], f"a row of a precision table, paired {paired}")
        first = result["rows"][0]
        need((first["cpu"], first["wall"], first["grain_steps"], first["energy"], first["seeds"], first["status"]) ==
             (2.0, 4.0, 6.0, 0.03, 3, "0") and result["reference"] == 12, f"{result}")
    near([r["error"] for r in precision.judge({**entry, "scale": 4.0}, rows, runs(reference, 9.0), ".")["rows"]],
         [np.mean(np.subtract(coarse, reference)) / 4, 0.0], "errors on a scale")
    # A row of order 2 and one that scatter hides: the order is that of the others.
    clear = lambda h, e: ({"h": h}, runs([12 * (1 + e)] * 3, 1 / h))
    hidden = ({"h": 0.05}, runs([12 * (1 + e) for e in (-0.2, 0.05, 0.45)], 20.0))
    known = {**entry, "reference": 12.0, "vary": {"h": [0.4, 0.2, 0.1, 0.05]}}
    result = precision.judge(known, [clear(0.4, 0.16), clear(0.2, 0.04), clear(0.1, 0.01), hidden], None, ".")
    need(abs(result["order"][0] - 2) < 1e-9, f"an order beside a row that scatter hides: {result['order']}")
    need(result["rows"][3]["error"] > 0.09 and result["rows"][3]["interval"] > result["rows"][3]["error"],
         "that row")
    need(precision.judge({**known, "order": False}, [clear(0.4, 0.16), clear(0.2, 0.04)], None, ".")["order"] is None
         and precision.judge({**known, "vary": {"h": ["a", "b"]}}, [({"h": "a"}, runs([1.0], 1.0))], None,
                             ".")["order"] is None, "an order that nobody asked for, or of words")
    # A cheap row whose interval is wide is not on the front, and not recommended; nor is one that became unstable.
    wide = ({"h": 0.4}, runs([12 * (1 + e) for e in (-0.3, 0.0, 0.3)], 1.0))
    result = precision.judge(known, [wide, clear(0.2, 0.09), clear(0.1, 0.008), clear(0.05, 0.0)], None, ".")
    need(result["front"] == [0, 1, 2, 3] and [result["recommended"][t]["settings"]["h"] for t in (0.1, 0.01, 0.001)] ==
         [0.2, 0.1, 0.05], f"{result['front']} {result['recommended']}")
    result = precision.judge(known, [clear(0.2, 0.09), (wide[0], runs([12 * (1 + e) for e in (-0.3, 0.0, 0.3)], 7.0))],
                             None, ".")
    need(result["front"] == [0], f"a dear row with no error but a wide interval is on the front: {result['front']}")
    lost = precision.judge(known, [({"h": 0.2}, runs([12.0], 1.0, status=3)), ({"h": 0.1}, [made_up.run(y=[0.0] * 3)]),
                                   ({"h": 0.05}, [made_up.run(axial_strain=[0.0, 0.1, 0.2], y=9.0)])], None, ".")
    need([r["status"] for r in lost["rows"]] == ["3 (1 not finished)", "0", "0 (not reached)"]
         and lost["rows"][0]["error"] == math.inf and lost["rows"][0]["seeds"] == 0 and lost["front"] == [1]
         and lost["rows"][2]["error"] == math.inf
         and lost["recommended"][0.1] is None and lost["rows"][1]["error"] == 1, f"{lost}")
    # The others of a seed that has failed are left out where seeds are compared, and only there.
    cases = {n: {"name": n, "label": n, "seeds": [1, 2, 3]} for n in ("coarse", "reference")}
    kept = {"coarse": dict(zip("123", runs([12.0, 20.0, 13.0], 1.0))), "reference": dict(zip("13", runs([10.0, 12.0],
                                                                                                      1.0)))}
    done = SimpleNamespace(by_seed=lambda c: kept[c["name"]], out=folder)
    entry = {**entry, "rows": [({"h": 0.4}, cases["coarse"])], "reference_case": cases["reference"], "folder": "."}
    for paired, value, seeds in ((True, 12.5, 2), (False, 15.0, 3)):
        row = precision.judged({**entry, "paired": paired}, done)[1]["rows"][0]
        near((row["value"], row["seeds"], row["signed"]), (value, seeds, (value - 11) / 11), f"paired {paired}")
    # A run that did not finish is left out as one that failed, but has a row, which is on no front.
    kept["coarse"]["2"]["summary"]["status"] = 3
    for paired, value, seeds, status in ((True, 12.5, 2, "0,3 (1 not finished)"),
                                         (False, 12.5, 2, "0,3 (1 not finished)")):
        result = precision.judged({**entry, "paired": paired}, done)[1]
        row = result["rows"][0]
        need((row["value"], row["seeds"], row["status"], row["cpu"]) == (value, seeds, status, 2.0), f"{row}")
        need(result["recommended"][0.1] is None and result["rows"][0]["status"] != "0", f"{result}")
    kept["coarse"]["2"]["summary"]["status"] = 0
    kept["reference"] = {}
    need(precision.judged(entry, done) is None, "errors against a reference that has failed")
    known = {**entry, "reference_case": None, "reference": 10.0, "vary": {"h": [0.4]}}
    shown = precision.show([known], done)
    with open(os.path.join(folder, "precision.csv"), newline="") as f:
        head, row = csv.reader(f)
    found, half = dict(zip(head, row)), stats.sem([12.0, 20.0, 13.0]) * stats.t.ppf(0.975, 2) / 10
    for name, value in {"error": 0.5, "signed": 0.5, "interval": half, "scatter": half, "seeds": 3, "value": 15.0,
                        "cpu": 2.0, "wall": 4.0, "grain_steps": 0.0, "rves": 0.0, "energy": 0.03}.items():
        need(abs(float(found[name]) - value) < 1e-12, f"precision.csv: {name} = {found[name]}, not {value}")
    need((found["study"], found["settings"], found["status"]) == ("p", "h 0.4", "0"), f"{found}")
    line = f"0.4 15 +50 % {100 * half:.2g} % {100 * half:.2g} % 3 2 4 0 0 3 % 0 *"
    need(shown.text.splitlines()[-1].split() == line.split() and "reference 10 (known)" in shown.text
         and "for 10 %: none of these" in shown.text, f"{shown.text}")
    finest = {"vary": {"a": [1, 2], "b": [3, 4]}}
    need([tuple(s.values()) for s in precision.settings(finest)] == [(1, 3), (1, 4), (2, 3), (2, 4)]
         and precision.reference_settings(finest) == {"a": 2, "b": 4}
         and precision.reference_settings({**finest, "reference": {"a": 9}}) == {"a": 9}
         and precision.reference_settings({**finest, "reference": {"file": "r.csv"}}) is None
         and precision.reference_settings({**finest, "reference": 3.0}) is None, "settings and reference")


def sweeps(folder):
    """Means, changes and intervals of a sweep, with a seed that is missing in one value."""
    entry = {"name": "s", "key": "k", "quantity": "y", "at": 1.0}
    ys = {"a": {"1": 10.0, "2": 20.0, "3": 40.0}, "b": {"1": 12.0, "2": 26.0}, "c": {"4": 7.0, "5": 8.0}}
    rows = [(k, {s: made_up.run(y=y, cpu=y) for s, y in by_seed.items()}) for k, by_seed in ys.items()]
    a, b, c = sweep.judge(entry, rows)
    base = 70 / 3
    near((a["mean"], a["sd"], a["interval"], a["change"], a["change_interval"], a["cpu_s"]),
         (base, np.std([10, 20, 40], ddof=1), stats.sem([10, 20, 40]) * stats.t.ppf(0.975, 2), 0, 0, base), "the first")
    # Changes of the seeds that both have: 2 and 6, relative to the first value's mean.
    near((b["mean"], b["change"], b["change_interval"], b["seeds"]),
         (19, 4 / base, stats.sem([2, 6]) * stats.t.ppf(0.975, 1) / base, 2), "a value with a seed missing")
    near((c["mean"], c["change"], c["change_interval"]), (7.5, math.nan, math.nan), "a value of other seeds")
    one = sweep.judge(entry, [("a", {"1": made_up.run(y=-4.0)}), ("b", {"1": made_up.run(y=-5.0)})])[1]
    near((one["change"], one["interval"], one["change_interval"], one["sd"]), (-0.25, math.nan, math.nan, 0),
         "one seed, negative")
    entry["rows"] = [(k, {"name": k}) for k in ys]
    done = SimpleNamespace(by_seed=lambda case: dict(rows)[case["name"]], out=folder)
    shown = sweep.show([{**entry, "scale": 2.0}], done)
    with open(os.path.join(folder, "sweep.csv"), newline="") as f:
        lines = list(csv.DictReader(f))
    for line, row in zip(lines, (a, b, c)):
        need((line["sweep"], line["key"], line["value"], line["position"], line["status"]) ==
             ("s", "k", row["value"], "y at axial_strain 1", "0"), f"sweep.csv: {line}")
        for name in ("mean", "interval", "sd", "change", "change_interval", "seeds", "cpu_s"):
            near(float(line[name] or "nan"), row[name], f"sweep.csv: {name}")
    need(len(lines) == 3 and "+17 %" in shown.text.splitlines()[4], f"{shown.text}")
    reached = {"1": made_up.run(y=3.0), "2": made_up.run(axial_strain=[0.0, 0.1, 0.2], y=9.0, status=3)}
    row = sweep.judge(entry, [("a", reached)])[0]
    need((row["mean"], row["seeds"], row["status"]) == (3.0, 1, "0,3 (1 not finished)"), f"{row}")
    stopped = {"1": made_up.run(y=3.0), "2": made_up.run(y=9.0, status=3)}  # whatever it got to
    row = sweep.judge(entry, [("a", stopped)])[0]
    need((row["mean"], row["seeds"], row["found"]) == (3.0, 1, [3.0]), f"{row}")
    reached["2"]["summary"]["status"] = 0
    row = sweep.judge(entry, [("a", reached)])[0]
    need((row["mean"], row["seeds"], row["status"]) == (3.0, 1, "0 (1 not reached)"), f"{row}")
    results = ({"peak_before_breakage_Pa": 6.0}, {"peak_axial_stress_Pa": 10.0})
    grains = {str(k): made_up.run(results=r, breakages=[0.0, 0.0, 1.0 - k]) for k, r in enumerate(results)}
    row = sweep.judge({"quantity": "results.peak_before_breakage_Pa"}, [("a", grains)])[0]
    need(row["status"] == "0 (1 of 2 not broken: at least 8)" and row["least"] == 8 and math.isnan(row["mean"])
         and row["larger"] == [10.0] and row["found"] == [6.0], f"{row}")
    need(sweep.numbers([{"value": 1}, {"value": 2.5}]) == ([1, 2.5], None)
         and sweep.numbers([{"value": True}, {"value": 2}]) == ([0, 1], ["True", "2"])
         and sweep.numbers([{"value": "x"}, {"value": "y"}]) == ([0, 1], ["x", "y"]), "places on the axis")
    need([sweep.signed(0.0312), sweep.signed(-0.5), sweep.signed(math.nan)] == ["+3.1 %", "-50 %", "-"], "signs")
    need([p["at"] for p in sweep.parts({"at": [1, 2]})] == [1, 2] and sweep.parts({"at": 3}) == [{"at": 3}], "parts")


def others(folder):
    """Bands of plots, power laws over cases, a paper's table."""
    runs = [made_up.run(y=2.0), made_up.run(y=6.0), made_up.run(y=[0.0, 5.0, 5.0], axial_strain=[0.0, 0.5, 0.6])]
    x, *found = plot.band([0.0, 0.25, 0.5, 0.75], runs, "y", 10.0)
    near(x, [0.0, 0.25, 0.5], "where all seeds get")
    near(found, [[0, 45 / 3, 90 / 3], [0, 5, 10], [0, 25, 50]], "mean, least and largest of seeds")
    fig, ax = plt.subplots()
    plot.history_plot(ax, {"y": "y", "cases": ["a"], "scale": 10.0, "y_max": 99.0}, {"a": "A"}, {"a": runs[:2]})
    line, = ax.get_lines()
    near((line.get_xdata()[[50, 200]], line.get_ydata()[[50, 200]]), ([0.25, 1.0], [10, 40]), "a curve of seeds")
    need(line.get_label() == "A (2 seeds)" and ax.get_ylim() == (0, 99) and len(ax.collections) == 1, "its band")
    ax.cla()
    plot.history_plot(ax, {"x": "axial_strain", "y": "y", "cases": ["a"], "scale": 10.0, "x_scale": 100.0}, {"a": "A"},
                      {"a": runs[:2]})
    near([(v.get_xdata()[1], v.get_ydata()[1]) for v in ax.get_lines()], [(50, 10), (50, 30)], "curves")
    first, second = ax.get_lines()
    need(first.get_label() == "A" and second.get_label().startswith("_") and first.get_color() == second.get_color(),
         "seeds of a case have one name and one colour")
    ax.cla()
    sieve = {0.1: [{"diameter_m": 1e-3, "passing": 0.25, "mass_kg": 2.0}, {"diameter_m": 2e-3, "passing": 1.0,
                                                                           "mass_kg": 6.0}]}
    for passing, wanted in ((True, [25, 100]), (False, [25, 75])):
        plot.grading_plot(ax, {"cases": ["a"], "passing": passing}, {"a": "A"}, {"a": [made_up.run(grading=sieve)]})
        near((ax.get_lines()[-1].get_xdata(), ax.get_lines()[-1].get_ydata()), ([1, 2], wanted), "a grading")
    plt.close(fig)
    law = {"name": "l", "cases": ["a", "b"], "x": "results.d", "quantity": "y", "at": [0.5, 1.0], "expected": 3}
    of = {n: [made_up.run(y=5 * d**3, results={"d": d}) for d in v] for n, v in {"a": [1.0, 2.0], "b": [4.0]}.items()}
    near(fit.points_of(law, 0.5, of), [(1, 2.5), (2, 20), (4, 160)], "points of a power law")
    of["b"].append(made_up.run(y=5.0))
    shown = fit.show([law], SimpleNamespace(runs=of, out=folder))
    need([line.split()[-12:] for line in shown.text.splitlines()[2:]] ==
         [f"l {e} 3.00 ± 0.00 (1 of 4 runs left out) 3".split() for e in ("0.5", "1")], f"{shown.text}")
    shown = fit.show([{**law, "cases": ["b"], "at": [0.5]}], SimpleNamespace(runs={"b": of["b"][:1]}, out=folder))
    need("fewer than two places" in shown.text, f"a law through one point: {shown.text}")
    base = made_up.run(axial_stress_Pa=10.0)
    for run, wanted in ((made_up.run(axial_stress_Pa=10.4), "good, same result (4.0 %)"),
                        (made_up.run(axial_stress_Pa=11.5), "good, slightly different (15.0 %)"),
                        (made_up.run(axial_stress_Pa=12.5), "broken, different path (25.0 %)"),
                        (made_up.run(3, axial_stress_Pa=10.0), "unstable: unstable"),
                        (made_up.run(axial_stress_Pa=10.0, breakages=[0.0] * 3), "never broken"),
                        (made_up.run(axial_stress_Pa=[0.0, 2.5, 5.0], axial_strain=[0.0, 0.25, 0.5]),
                         "good, same result (0.0 %)")):
        need(table.result_of(run, base) == wanted, f"{table.result_of(run, base)!r}, not {wanted!r}")
    steps = made_up.run(axial_stress_Pa=3e6, time_step_s=[4e-6, 2e-6, 3e-6])
    shown = table.show([{"name": "t", "reference": "a", "cases": ["a"]}],
                       SimpleNamespace(runs={"a": [steps]}, labels={"a": "A"}))
    need(shown.text.splitlines()[-1].split() == "A 2e-06 … 4e-06 3 3 good, same result (0.0 %)".split(),
         f"{shown.text}")


intervals()
laws()
of_runs()
strengths()
claims()
with tempfile.TemporaryDirectory() as tmp:
    precisions(tmp)
    sweeps(tmp)
    others(tmp)
print(f"study_numbers: {len(faults)} faults")
sys.exit(1 if faults else 0)
