#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the plots of studies and calibrations show, what their pages say, and which of their files are refused:
study_pages.py BIN"""
import math
import os
import re
import sys
import tempfile
import tomllib
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.calibrate import command, reader, report, schema  # noqa: E402
from grus.errors import InputError  # noqa: E402
from grus.figures import plt  # noqa: E402
from grus.runs import schema as known  # noqa: E402
from grus.study.kinds import check, fit, plot, precision, sweep  # noqa: E402
from grus.study.reader import read_study  # noqa: E402

import made_up  # noqa: E402
import scene_tools  # noqa: E402
from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402

nan = math.nan


def lines(ax):
    """Label -> (x, y) of curves that have one, and (x, y) of those that have none."""
    named = {v.get_label(): (v.get_xdata(), v.get_ydata()) for v in ax.get_lines()}
    return ({k: v for k, v in named.items() if not k.startswith("_")},
            [(v.get_xdata(), v.get_ydata()) for v in ax.get_lines() if v.get_label().startswith("_")])


def bars_of(ax):
    """(x, y, lower end, upper end) of error bars."""
    found = []
    for c in ax.containers:
        (x, y), ends = c.lines[0].get_data(), c.lines[2][0].get_segments() if c.lines[2] else []
        found += [(*p, *(e[:, 1] if len(e) else (nan, nan))) for p, e in zip(zip(x, y), ends or [[]] * len(x))]
    return found


def studies(folder):
    row = lambda h, cpu, error, half, **more: {"settings": {"a.h": h}, "cpu": cpu, "error": error, "interval": half,
                                               **more}
    rows = [row(0.4, 1.0, 0.1, 0.02), row(0.2, 4.0, 0.01, nan), row(0.1, 9.0, 0.02, 0.5), row(0.05, 9.0, math.inf, nan)]
    fig = precision.plot({"name": "P"}, {"rows": rows, "front": [0, 1]})
    need([axis.get_major_formatter()(0.01, 0) for axis in (fig.axes[0].xaxis, fig.axes[0].yaxis)] == 2 * ["0.01"],
         "numbers of a logarithmic axis")
    ax, = fig.axes
    near(bars_of(ax), [(1, 10, 8, 12), (4, 1, nan, nan), (9, 2, 0.002, 52)], "errors and their bars", 1e-9)
    near(lines(ax)[0]["Pareto front (error + interval)"], ([1, 4], [12, 1]), "the front", 1e-9)
    need([t.get_text() for t in ax.texts] == ["h 0.4", "h 0.2"] and (ax.get_xscale(), ax.get_yscale()) ==
         ("log", "log"), f"settings on the front: {[t.get_text() for t in ax.texts]}")
    need([t.get_ha() for t in ax.texts] == ["left", "right"], "settings on the front stand inside the axes")
    ax, = precision.plot({"name": "P"}, {"rows": rows[3:], "front": []}).axes
    need([t.get_text() for t in ax.texts] == ["no run got that far"], "a plot of nothing")
    ax, = precision.plot({"name": "P"}, {"rows": [rows[0], row(0.1, 2.0, 0.0, nan)], "front": [0, 1]}).axes
    near(bars_of(ax)[1][:2], (2, 1), "no error at all, a decade below the least", 1e-9)
    of = {n: [made_up.run(y=5 * d**3, results={"d": d}) for d in v] for n, v in {"a": [1.0, 2.0], "b": [4.0]}.items()}
    law = {"name": "l", "cases": ["a", "b"], "x": "results.d", "quantity": "y", "at": [0.5, 1.0], "expected": 2}
    ax, = fit.law_plot(law, of).axes
    named = lines(ax)[0]
    near((named["strain 0.5"], named["strain 1"]), (([1, 2, 4], [2.5, 20, 160]), ([1, 2, 4], [5, 40, 320])), "points")
    drawn = [v.get_ydata() for v in ax.get_lines() if len(v.get_xdata()) == 2]
    near(drawn, [[2.5, 160], [20 / 4, 20 * 4], [5, 320], [40 / 4, 40 * 4]], "laws through the middle", 1e-9)
    need({"exponent 3.00", "expected 2"} < set(named), f"names of laws: {set(named)}")
    judged = lambda value, mean, half, found, larger: {"value": value, "mean": mean, "interval": half, "found": found,
                                                       "larger": larger}
    rows = [judged(1, 3.0, 0.5, [2.0, 4.0], []), judged(2, nan, nan, [5.0], [7.0])]
    entry = {"name": "S", "key": "k", "quantity": "y", "at": 1.0, "scale": 10.0, "log_x": True}
    ax, = sweep.plot(entry, [(entry, rows)]).axes
    near(bars_of(ax), [(1, 30, 25, 35), (2, nan, nan, nan)], "means and intervals of a sweep", 1e-9)
    dots = [(v.get_xdata(), v.get_ydata()) for v in ax.get_lines() if v.get_marker() in (".", "^")]
    near(dots, [([1, 1], [20, 40]), ([], []), ([2], [50]), ([2], [70])], "its seeds, and what is stronger")
    need(ax.get_xscale() == "log" and ax.get_xlabel() == "k" and ax.get_ylabel() == "y", "its axes")
    words = [judged("x", 3.0, nan, [3.0], []), judged("y", 4.0, nan, [4.0], [])]
    ax, = sweep.plot({**entry, "log_x": False}, [(entry, words)]).axes
    need([t.get_text() for t in ax.get_xticklabels()] == ["x", "y"] and list(ax.get_xticks()) == [0, 1], "words")
    fig, ax = plt.subplots()
    corridor = {"label": "C", "points": [[0.0, 1.0, 2.0], [0.5, 2.0, 5.0]]}
    plot.history_plot(ax, {"y": "y", "cases": ["a"], "corridor": [corridor], "log": True}, {"a": "A"}, of)
    body, band = ([c.get_paths()[0].vertices for c in ax.collections])
    need({tuple(p) for p in body} == {(0, 1), (0.5, 2), (0.5, 5), (0, 2)}, f"a corridor: {body}")
    near([band[:, 1].min(), band[:, 1].max(), band[:, 0].max()], [0, 40, 1], "a band from the least to the largest")
    need(ax.get_yscale() == "log" and ax.get_xlabel() == "axial strain" and ax.get_ylabel() == "y", "axes of a plot")
    ax.cla()
    plot.history_plot(ax, {"y": "y", "cases": ["b"], "xlabel": "X", "ylabel": "Y"}, {"b": "B"}, of)
    need(not ax.collections and lines(ax)[0].keys() == {"B (1 seed)"} and (ax.get_xlabel(), ax.get_ylabel()) ==
         ("X", "Y"), "one seed has no band")
    sieve = {0.1: [{"diameter_m": 1e-3, "passing": 1.0, "mass_kg": 0.0}]}
    ax.cla()
    for passing, label in ((True, "passing by mass (%)"), (False, "mass in class (%)")):
        plot.grading_plot(ax, {"cases": ["a"], "passing": passing}, {"a": "A"}, {"a": [made_up.run(grading=sieve)]})
        need(ax.get_ylabel() == label, f"a grading: {ax.get_ylabel()}")
    plt.close("all")


def calibrations(folder):
    target = lambda name, kind, x, values, **more: SimpleNamespace(
        name=name, kind=kind, x=np.array(x), values=np.array(values), error=np.full(len(x), 0.5), log=False,
        table={"x": "X", "y": "Y", "quantity": "Q"} | more)
    curve, sieve = target("c", "curve", [1.0, 2.0], [5.0, 6.0]), target("s", "grading", [1e-3, 2e-3], [0.1, 0.9])
    value = target("v", "value", [0.0], [7.0])
    ax, = report.target_plot(curve, [np.array([3.0, 4.0])], np.array([5.1, 6.1]), np.array([5.2, nan])).axes
    named, others = lines(ax)
    near((named["fit"], named["run at the best point"]), (([1, 2], [5.1, 6.1]), ([1, 2], [5.2, nan])), "fit and run")
    near(others[0], ([1, 2], [3, 4]), "what was tried")
    near(bars_of(ax), [(1, 5, 4.5, 5.5), (2, 6, 5.5, 6.5)], "data with their errors")
    need((ax.get_xscale(), ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("linear", "X", "Y", "c"), "its axes")
    ax, = report.target_plot(sieve, [], sieve.values, None).axes
    need((ax.get_xscale(), ax.get_xlabel(), ax.get_ylabel()) == ("log", "diameter (mm)", "passing")
         and "run at the best point" not in lines(ax)[0], "a grading")
    ax, = report.target_plot(target("q", "quantiles", [0.5], [1.0]), [], np.ones(1), None).axes
    need((ax.get_xlabel(), ax.get_ylabel()) == ("share of grains", "Q"), "quantiles")
    seen, before = [], report.target_plot
    report.target_plot = lambda *given: seen.append(given) or plt.subplots()[0]
    rows = [{"values": np.arange(5.0)}]
    made_up.unpainted()
    body = report.target_plots(folder, [curve, value, sieve], rows, np.arange(10.0, 15), [20.0, 21.0, 22.0, 23.0, 24.0])
    report.target_plots(folder, [curve], rows, np.arange(10.0, 12), None)
    report.target_plot = before
    near([v[1:] for v in seen[:2]], [([k, k + 1], [10 + k, 11 + k], [20 + k, 21 + k]) for k in (0, 3)], "their parts")
    need(seen[2][3] is None and body.count("<img") == 2, "targets of one point have no plot")
    history = [(8, None, np.array([0.3, 0.2])), (16, None, np.array([0.1, 0.05]))]
    ax, = report.deviations_plot(history, ["a", "b"]).axes
    near(list(lines(ax)[0].values()), [([8, 16], [30, 10]), ([8, 16], [20, 5])], "deviations by points")
    near(lines(ax)[1][0][1], [10, 10], "where a value is identified")
    ax = report.correlation_plot([[1, -0.5], [-0.5, 1]], ["a", "b"]).axes[0]
    near(ax.images[0].get_array(), [[1, -0.5], [-0.5, 1]], "correlations")
    need([t.get_text() for t in ax.get_yticklabels()] == ["a", "b"] and ax.images[0].get_clim() == (-1, 1), "its names")
    parameters = [reader.Parameter("", {"key": f"k.{n}", "min": 0, "max": top}) for n, top in (("a", 1), ("b", 10))]
    draws = np.column_stack([np.linspace(0, 1, 200), np.linspace(0, 1, 200) ** 2])
    (hist, hidden), (pair, other) = np.reshape(report.posterior_plot(draws, parameters).axes, (2, 2))
    near(lines(pair)[1][0], (draws[::10, 0], 10 * draws[::10, 1]), "a pair of parameters")
    near((sum(p.get_height() for p in other.patches), other.get_xlim()[1] > 9), (20, 1), "draws of one")
    need(not hidden.axison and hist.axison and pair.get_xlabel() == "a" and pair.get_ylabel() == "b", "its axes")
    plt.close("all")
    text = lambda body: re.sub(r"\s+", " ", re.sub("<[^>]*>", " ", body)).strip()
    need(text(report.correlations({"correlation": [[1, -0.5], [-0.5, 1]]}, ["a", "b"])) ==
         "Correlations a b a +1.00 -0.50 b -0.50 +1.00 Near +1 or -1 the data hardly tell the two apart: one makes up "
         "for the other.", "a table of correlations")
    need(report.correlations({"correlation": [[1]]}, ["a"]) == "", "one parameter has no correlation")
    sides = [{"name": "a", "at": [1.0, 2.0], "sum_of_squares": [3.0, 4.0]}]
    shown = text(report.neighbours({"sides": sides, "best": 0.5}, {"a": "GPa"}))
    beside = "a (GPa) 1 3 2 4 Sum of squares: of what the runs are off the data, over the data's deviations; smaller "
    need(shown.endswith(beside + "is better. At the best point 0.5."), f"runs beside the best point: {shown}")
    found = [{"key": "k", "median": 1.5, "middle_68": [1.0, 2.0], "middle_95": [0.5, 3.0]}]
    need(text(report.posterior_table(found)).endswith("k 1.5 1 … 2 0.5 … 3"), "a table of the posterior")
    of = {"name": "t", "kind": "curve", "points": 3, "rms_in_standard_deviations": 1.234, "stronger_than": 0,
          "still_rising": 0}
    need("t curve 3 1.23 Some 1 is" in text(report.misfits([of])), "a table of misfits")
    summary = {"points": 9, "failed_points": 2, "refused_points": 0, "targets": [of],
               "parameters": [{"sd_of_range": 0.1, "verdict": "weak"}, {"sd_of_range": 0.05, "verdict": "identified"}]}
    shown = text(report.values_table(summary, parameters, SimpleNamespace(x=[0.5, 0.2])))
    need("k.a 0.5 ± 0.1 0.0 … 1.0 10.0 % weak k.b 2 ± 0.5 0.0 … 10.0 5.0 % identified 9 points, 2 of them" in shown,
         f"values: {shown}")
    # A scene with its values, whatever tables it has: it is read as what it was.
    scene = os.path.join(folder, "nested.toml")
    with open(scene, "w") as f:
        f.write('title = "a \\"b\\""\n[empty]\n[m.s]\nx = 1\ny = [1, "2 m"]\nz = { u = 1.5 }\n[m.s.deep]\nv = true\n'
                '[[wall]]\nat = 1\n[[wall]]\nat = 2\n[gone]\nk = 1\n')
    run = {"scene": scene, "set": {"m.t": {"w": 2}, "gone": "", "wall.1.at": 7, "new.deep.key": 3.5}}
    text = command.best_scene(run, [reader.Parameter("", {"key": "m.s.x", "min": "2 m", "max": "4 m"})], [0.25])
    need(tomllib.loads(text) == {"title": 'a "b"', "empty": {}, "m": {
        "s": {"x": "2.5 m", "y": [1, "2 m"], "z": {"u": 1.5}, "deep": {"v": True}}, "t": {"w": 2}},
        "wall": [{"at": 1}, {"at": 7}], "new": {"deep": {"key": 3.5}}}, f"best.toml: {text}")


STUDY = '[study]\nscene = "s.toml"\nset = { a = 1 }\nquantities = ["y", "results.k"]\n[[case]]\nname = "one"\n'


def refusals(folder):
    """Each rule of a file, by a file that breaks it and one that does not; and what a study asks of its runs."""
    def write(text, name="study.toml"):
        with open(os.path.join(folder, name), "w") as f:
            f.write(text)
        return f.name
    write("", "s.toml"), write("[mesh]\n", "m.toml"), write("t,y\n0,1\n1,3\n", "r.csv")
    claim = '[[check]]\nclaim = "c"\n'
    vary = '[[precision]]\nname = "p"\nquantity = "y"\nvary = { b = [1, 2] }\n'
    swept = '[[sweep]]\nname = "w"\nkey = "b"\nvalues = [1, 2]\n'
    for text, said in (
            (claim + 'case = "one"\nbelow = 1\n', None), (claim + 'case = "one"\nbetween = [0, 1]\n', None),
            (claim + 'cases = ["one"]\nnear = 1\ntolerance = 1\n', None), (claim + 'greater = ["one", "one"]\n', None),
            (claim + "below = 1\n", "needs either greater"), (claim + 'case = "one"\n', "needs near with tolerance"),
            (claim + 'case = "one"\ngreater = ["one", "one"]\n', "needs either greater"),
            (claim + 'case = "one"\nnear = 1\n', "needs near with tolerance"),
            (claim + 'case = "one"\nnear = 0\ntolerance = 1\n', "check[0].near"),
            (claim + 'case = "two"\nbelow = 1\n', "no case is called 'two'"),
            (claim + 'cases = ["two"]\nbelow = 1\n', "'two'"), (claim + 'greater = ["one", "two"]\n', "'two'"),
            ('[[case]]\nname = "ONE"\n', "two cases share a name"), ('[[case]]\nname = "a/b"\n', "must be a word"),
            ('[[case]]\nname = "b"\nscene = "none.toml"\n', "no such scene file"),
            ('[[fit]]\nname = "f"\ncases = ["x"]\nx = "d"\nquantity = "y"\nat = [1]\n', "'x'"),
            ('[[plot]]\nname = "f"\ncases = ["one"]\n', "needs 'y'"), ('[[plot]]\nname = "f"\ny = "y"\ncases = ["x"]\n',
                                                                      "'x'"),
            ('[[plot]]\nname = "f"\nkind = "grading"\ncases = ["one"]\n', None),
            ('[[table]]\nname = "f"\nreference = "x"\ncases = ["one"]\n', "'x'"),
            ('[[table]]\nname = "f"\nreference = "one"\ncases = ["x"]\n', "'x'"),
            (vary, "needs 'at'"), (vary + "at = 1\n", None), (vary + 'measure = "peak"\n', None),
            (vary + 'at = 1\nreference = "best"\n', "reference"), (vary + "at = 1\nreference = 3\n", None),
            (vary + 'at = 1\nreference = { file = "r.csv" }\nover = "t"\n', None),
            (vary + 'at = 1\nreference = { file = "n.csv" }\n', "n.csv"),
            (vary + 'at = 1\nreference = { file = "r.csv", column = "q" }\nover = "t"\n', "'q'"),
            (vary.replace("[1, 2]", "[1]") + "at = 1\n", "nothing to compare"),
            (swept + 'quantity = "y"\n', "needs 'at'"), (swept + 'quantity = "y"\nmeasure = "last"\n', None),
            (swept + 'quantity = "results.k"\n', None), (swept + 'quantity = "y"\nat = [1, 2]\n', None)):
        path = write(STUDY + text)
        try:
            read_study(path)
            need(said is None, f"accepted: {text}")
        except InputError as e:
            need(said and said in str(e) and "\n" not in str(e), f"{text}: {e}")
    two = '[[case]]\nname = "two"\nscene = "m.toml"\nset = { b = 2 }\nseeds = [5, 6]\n'
    study = read_study(write(STUDY + two + claim +
                             'greater = ["one", "two"]\nquantity = "q"\n[[plot]]\nname = "p"\nx = "u"\ny = "v"\n'
                             'cases = ["two"]\n[[fit]]\nname = "f"\ncases = ["one"]\nx = "counts.n"\nquantity = "w"\n'
                             'at = [1]\n' + vary + 'at = [0.1, 0.2]\nover = "t"\nset = { c = 3 }\n' + swept +
                             'quantity = "z"\nmeasure = "peak"\n'))
    one, two = study.named
    need((one["set"], one["seeds"], one["program"], two["set"], two["seeds"], two["program"], two["label"]) ==
         ({"a": 1}, [None], "grus-rve", {"a": 1, "b": 2}, [5, 6], "grus-bvp", "two"), f"cases: {one} {two}")
    wanted = study.wanted()
    need(wanted["one"] == ({"y", "axial_strain", "q", "w"}, {"results.k", "counts.n"})
         and wanted["two"] == ({"y", "axial_strain", "q", "u", "v"}, {"results.k"}), f"asked: {wanted}")
    others = [(c["label"], c["set"], wanted[c["name"]]) for c in study.cases() if c not in study.named]
    need(others == [("b=1", {"a": 1, "c": 3, "b": 1}, ({"y", "t"}, set())),
                    ("b=2", {"a": 1, "c": 3, "b": 2}, ({"y", "t"}, set()))] * 2
         + [("b=1", {"a": 1, "b": 1}, ({"z"}, set())), ("b=2", {"a": 1, "b": 2}, ({"z"}, set()))], f"others: {others}")
    for target, said in (('kind = "curve"', "needs 'data'"), ('data = "d"\nx = "x"', "needs 'y'"),
                         ('kind = "grading"\ndata = "d"', "needs 'at'"),
                         ('kind = "value"\nvalue = 1', "needs 'quantity'"),
                         ('kind = "yield"', "needs 'value'"), ('kind = "sum"', "none of"), ("weight = 0", "weight")):
        text = '[calibrate]\nparameters = [{ key = "k", min = 0, max = 1 }]\n[[calibrate.targets]]\nname = "t"\n'
        text += target
        need(said in (schema.fault(tomllib.loads(text)) or ""), f"{target}: {schema.fault(tomllib.loads(text))}")


def claims():
    """What no run could meet, and numbers that are none."""
    reading = SimpleNamespace(path="s.toml", named=lambda where, names: None)
    given = {"claim": "c", "case": "a"}
    for more, said in (({"near": 1.0, "tolerance": 0.1, "below": 2.0}, "near and below are two claims"),
                        ({"between": [0, 1], "below": 2.0}, "between and below are two claims"),
                        ({"below": 1.0, "tolerance": 0.1}, "tolerance is of near"),
                        ({"below": 1.0, "factor": 2.0}, "factor is of greater"),
                        ({"between": [2, 1]}, "between: 2 is above 1"), ({"below": -1.0}, "below: -1"),
                        ({"below": 1.0, "at": [0.1], "quantity": "results.k"}, "at is of a column")):
        scene_tools.refused(said, lambda: check.read([{**given, **more}], reading), InputError)
    check.read([{**given, "between": [1, 1]}, {**given, "below": 0}, {**given, "near": -1.0, "tolerance": 0.1}],
               reading)
    for text, said in (({"near": math.nan}, "check[0].near: must be a finite number"),
                        ({"between": [0.0, math.inf]}, "check[0].between[1]: must be a finite number"),
                        ({"near": 1.0}, None)):
        need(known.fault({"check": [{"claim": "c", **text}]}, {"type": "object"}) == said, f"{text}")
    need(known.fault({"study": {"set": {"a": math.inf}}}, {}) is None, "a scene's own value, which the program judges")


claims()
with tempfile.TemporaryDirectory() as tmp:
    studies(tmp)
    calibrations(tmp)
    refusals(tmp)
print(f"study_pages: {len(faults)} faults")
sys.exit(1 if faults else 0)
