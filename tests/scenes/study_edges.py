#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands that run cases do at the edges: limits that are met exactly, texts, times, signals, faults of
files. study_edges.py BIN"""
import argparse
import contextlib
import io
import math
import os
import signal
import sys
import tempfile
import time
from types import SimpleNamespace

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.errors import InputError  # noqa: E402
from grus.figures import plt  # noqa: E402
from grus.runs import cases, command, interrupts, kept, places, programs, schema  # noqa: E402
from grus.study import numbers, statistics, tables, words  # noqa: E402
from grus.study.kinds import case, check, fit, plot, precision, sweep, table  # noqa: E402

import made_up  # noqa: E402
import scene_tools  # noqa: E402
from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def refused(work, words, kind=InputError):
    scene_tools.refused(words, work, kind)


def limits():
    """What is just met holds, for claims, targets, clear errors and places."""
    c = {"axial_strain": [0.0, 0.0, 0.1, 0.1, 0.2], "y": [5.0, 1.0, 2.0, 7.0, 9.0]}
    near([numbers.position(c, "y", x) for x in (0.0, 0.1, 0.15)], [1, 2, 8], "where the strain rests")
    runs = {"a": [made_up.run(y=1.0)], "b": [made_up.run(y=1.0)], "zero": [made_up.run(y=0.0)]}
    of = {"claim": "c", "quantity": "y", "case": "a"}
    for claim, wanted in (({"near": 0.5, "tolerance": 1.0}, True), ({"between": [1.0, 1.0]}, True),
                          ({"below": 1.0}, True), ({"case": "zero", "below": 0}, True)):
        need(check.check_of({**of, **claim}, runs)[0] == wanted, f"{claim} is just met")
    said = check.check_of({"claim": "c", "quantity": "y", "greater": ["a", "zero"]}, runs)
    need(said == (True, "a / zero: 1 / 0 = inf"), f"over nothing: {said}")
    need(not check.check_of({"claim": "c", "quantity": "y", "greater": ["a", "b"]}, runs)[0], "equal is not greater")
    grains = {name: [made_up.run(breakages=[0.0, 0.0, broken], results={
        "peak_axial_stress_Pa": 9.0, **({"peak_before_breakage_Pa": 4.0} if broken else {})})]
        for name, broken in (("whole", 0.0), ("broken", 1.0))}
    claim = {"claim": "c", "quantity": "results.peak_before_breakage_Pa"}
    for more, wanted in (({"greater": ["whole", "broken"]}, (True, "whole / broken: > 9 / 4 = 2.25 (1 not broken)")),
                         ({"greater": ["broken", "whole"]}, (False, "broken / whole: 4 / nan = nan (1 not broken)")),
                         ({"cases": ["broken", "whole"], "below": 99},
                          (False, "1 of 2 values are not there: 1 grains did not break")),
                         ({"case": "broken", "at": [0.1], "below": 99}, (True, "at most 4, asked 99"))):
        found = check.check_of({**claim, **more}, grains)
        need(found == wanted, f"{more}: {found}")
    short_run = {"a": [made_up.run(axial_strain=[0.0, 0.1, 0.2], y=1.0)]}
    found = check.check_of({**of, "at": [0.5], "below": 9}, short_run)
    need(found == (False, "1 of 1 values are not there"), f"what no run reaches: {found}")
    need([check.asks({**of, **m}, {}) for m in ({}, {"cases": ["x", "z"]}, {"greater": ["u", "v"]})] == [
        [("a", {"y", "axial_strain"}, set())], [(n, {"y", "axial_strain"}, set()) for n in "xz"],
        [(n, {"y", "axial_strain"}, set()) for n in "uv"]], "what claims ask for")
    row = {"status": "0", "error": 0.1, "interval": 0.0, "cpu": 1.0}
    need(precision.recommended([row])[0.1] is row and precision.recommended([row])[0.01] is None, "a target just met")
    need(precision.recommended([{**row, "status": "3"}])[0.1] is None, "an unstable run is recommended")
    cheap = {**row, "cpu": 0.5}
    need(precision.recommended([row, cheap])[0.1] is cheap, "the cheapest")
    need(precision.pareto([(1.0, 2.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.5)]) == [1, 3], "a front")
    entry = {"name": "p", "quantity": "y", "at": 1.0, "vary": {"h": [0.4, 0.2, 0.1]}, "reference": 1.0}
    one = lambda v: [made_up.run(y=v)]
    result = precision.judge(entry, [({"h": 0.4}, one(1.16)), ({"h": 0.2}, one(1.04)), ({"h": 0.1}, one(1.01))], None,
                             ".")
    near([r["signed"] for r in result["rows"]], [0.16, 0.04, 0.01], "errors against a number", 1e-9)
    near(result["order"][0], 2, "the order of single runs", 1e-9)
    need(precision.judge({**entry, "order": False}, [({"h": 0.4}, one(2.0)), ({"h": 0.2}, one(3.0))], None,
                         ".")["order"] is None, "an order that nobody asked for")
    need(precision.judge({**entry, "reference": 0.0}, [({"h": 0.4}, one(3.0))], None, ".")["rows"][0]["error"] == 3,
         "relative to nothing")
    lost = precision.judge(entry, [({"h": 0.4}, [made_up.run(axial_strain=[0.0, 0.1, 0.2], y=1.0)])], None, ".")
    need(lost["rows"][0]["status"] == "0 (not reached)" and lost["rows"][0]["error"] == math.inf
         and lost["order"] is None, f"what is not reached: {lost}")
    equal = precision.judge({**entry, "paired": False}, [({"h": 0.4}, one(2.0) + one(2.0)),
                                                         ({"h": 0.2}, one(1.5) + one(1.5))], one(1.0) + one(1.0), ".")
    near(equal["order"][0], 1, "errors whose intervals are nothing are clear", 1e-9)
    near([precision.bound({"error": 1.0, "interval": x}) for x in (math.nan, 0.5)], [1, 1.5], "what an error may be")
    zero = sweep.judge({"quantity": "y", "at": 1.0}, [("a", {"1": made_up.run(y=0.0)}),
                                                      ("b", {"1": made_up.run(y=3.0)})])[1]
    need(zero["change"] == 3, "a change of nothing")
    need(precision.signed({"error": 0.0, "signed": 0.0}) == "0 %" and
         precision.signed({"error": math.inf, "signed": math.inf}) == "not reached" and
         precision.signed({"error": 0.5, "signed": -0.5}) == "-50 %", "signs of errors")
    flat = made_up.run(axial_stress_Pa=[0.0] * 3)
    need(table.result_of(made_up.run(axial_stress_Pa=1.0), flat) == "broken, different path (nan %)", "beside nothing")
    base = made_up.run(axial_stress_Pa=[0.0, 1.0, 0.0])
    need(table.result_of(made_up.run(axial_stress_Pa=[0.0, 1.0, 0.5]), base).startswith("broken, different path (35."),
         f"off in the last part: {table.result_of(made_up.run(axial_stress_Pa=[0.0, 1.0, 0.5]), base)}")
    need(statistics.difference([3.0], [1.0], False)[0] == 2 and math.isnan(statistics.difference([3.0], [1.0], True)[1])
         and statistics.power_law([(1.0, 0.0), (2.0, 1.0)]) is None, "few values")
    need([words.percent(-0.5), words.short("x"), words.short(True)] == ["-50 %", "x", "True"], "words")


def told():
    """Axes, legends and labels of a study's plots; rows of its tables."""
    fig, ax = plt.subplots()
    runs = {"a": [made_up.run(y=2.0)], "b": [made_up.run(y=3.0), made_up.run(y=4.0)]}
    corridor = [{"label": "measured", "points": [[0.0, 1.0, 2.0], [1.0, 3.0, 5.0]]}]
    plot.history_plot(ax, {"y": "y", "cases": ["a", "b"], "corridor": corridor, "log_x": True}, {"a": "A", "b": "B"},
                      runs)
    need([t.get_text() for t in ax.get_legend().get_texts()] == ["measured", "A (1 seed)", "B (2 seeds)"], "a legend")
    need((ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale()) == ("axial strain", "y", "log"), "names of axes")
    corner = ax.collections[0].get_paths()[0].vertices
    need({tuple(v) for v in corner} == {(0, 1), (0, 2), (1, 3), (1, 5)}, f"a corridor: {corner}")
    need(len(ax.collections) == 2 and len(ax.get_lines()[0].get_xdata()) == 201, "a band of two seeds alone")
    ax.cla()
    plot.history_plot(ax, {"y": "y", "x": "t", "cases": ["a"], "xlabel": "X", "ylabel": "Y"}, {"a": "A"},
                      {"a": [made_up.run(y=2.0, t=1.0)]})
    need((ax.get_xlabel(), ax.get_ylabel()) == ("X", "Y") and ax.get_ylim()[1] < 3, "names that are asked for")
    ax.cla()
    sieve = lambda mass: [{"diameter_m": 1e-3, "passing": 0.5, "mass_kg": mass}]
    for passing, name in ((True, "passing by mass (%)"), (False, "mass in class (%)")):
        plot.grading_plot(ax, {"cases": ["a"], "passing": passing}, {"a": "A"},
                          {"a": [made_up.run(grading={0.0: sieve(0.0), 0.25: sieve(2.0)})]})
        need((ax.get_xlabel(), ax.get_ylabel()) == ("equivalent diameter (mm)", name), f"a grading: {ax.get_ylabel()}")
        need(ax.xaxis.get_major_formatter()(20.0, 0) == "20" and [line.get_label() for line in ax.get_lines()[-2:]] ==
             ["A, strain 0.00", "A, strain 0.25"], "its states")
    near(ax.get_lines()[-2].get_ydata(), [math.nan], "a class of no mass")
    need(ax.get_lines()[-1].get_color() != ax.get_lines()[-2].get_color(), "colours of states")
    plt.close(fig)
    law = {"name": "law", "cases": ["a"], "x": "results.d", "quantity": "y", "at": [0.5, 1.0], "expected": 2}
    of = {"a": [made_up.run(y=v, results={"d": d})
                for d, v in ((1.0, 3.0), (4.0, 12.0), (2.0, 6.0), (-1.0, 1.0), (3.0, -1.0))]}
    ax, = fit.law_plot(law, of).axes
    need((ax.get_title(), ax.get_xlabel(), ax.get_ylabel(), ax.xaxis.get_major_formatter()(20.0, 0),
          ax.yaxis.get_major_formatter()(20.0, 0)) == ("law", "results.d", "y", "20", "20"), "a law's axes")
    need([t.get_text() for t in ax.get_legend().get_texts()] == ["strain 0.5", "exponent 1.00", "expected 2",
                                                                "strain 1", "exponent 1.00"], "a law's legend")
    points, fitted, expected = ax.get_lines()[3:]
    near((points.get_xdata(), points.get_ydata()), ([1, 2, 4], [3, 6, 12]), "its points", 1e-9)
    near((fitted.get_xdata(), fitted.get_ydata()), ([1, 4], [3, 12]), "its line", 1e-9)
    near(expected.get_ydata(), [6 / 4, 6 * 4], "the expected one through the middle", 1e-9)
    plt.close("all")
    need(not fit.law_plot({**law, "cases": ["b"]}, {"b": of["a"][:1]}).axes[0].get_lines(), "a law of one point")
    entry = {"name": "sweep", "key": "k", "quantity": "y", "at": 1.0, "scale": 10.0, "log": True}
    two = {"1": made_up.run(y=1.0), "2": made_up.run(y=3.0)}
    rows = sweep.judge(entry, [("x", two), ("z", {"1": made_up.run(y=4.0)})])
    ax, = sweep.plot(entry, [(entry, rows)]).axes
    need((ax.get_title(), ax.get_xlabel(), ax.get_ylabel(), ax.get_yscale()) == ("sweep", "k", "y", "log"), "a sweep")
    need([t.get_text() for t in ax.get_xticklabels()] == ["x", "z"] and ax.get_legend().get_texts()[0].get_text() ==
         "y at axial_strain 1", "names of values")
    near([line.get_ydata() for line in ax.get_lines()][0], [20, 40], "its means")
    near(sorted(v for line in ax.get_lines()[-4:] for v in line.get_ydata()), [10, 30, 40], "its seeds")
    bars = ax.collections[0].get_segments()
    near([s[1][1] - s[0][1] for s in bars], [2 * 10 * rows[0]["interval"], 0], "its bars", 1e-9)
    wide = [{"settings": {"h": h}, "error": e, "signed": e, "interval": i, "cpu": c, "status": "0"}
            for h, e, i, c in ((1, 0.1, 0.05, 1.0), (2, 0.0, math.nan, 4.0), (3, math.inf, math.nan, 9.0))]
    ax, = precision.plot({"name": "work"}, {"rows": wide, "front": [0, 1, 2]}).axes
    need((ax.get_title(), ax.get_xlabel(), ax.get_xscale(), ax.get_yscale()) ==
         ("work", "CPU time of a run (s)", "log", "log") and "error (%)" in ax.get_ylabel(), "work and precision")
    step = next(line for line in ax.get_lines() if line.get_label().startswith("Pareto"))
    near((step.get_xdata(), step.get_ydata()), ([1, 4], [15, 1]), "the front: an error of 0 a tenth of the least", 1e-9)
    need([t.get_text() for t in ax.texts] == ["h 1", "h 2"], "what the front is of")
    bar = ax.collections[0].get_segments()[0]
    near((bar[0][1], bar[1][1]), (5, 15), "a bar", 1e-9)
    ax, = precision.plot({"name": "n"}, {"rows": wide[2:], "front": []}).axes
    need([t.get_text() for t in ax.texts] == ["no run got that far"], "a plot of nothing")
    plt.close("all")
    need(precision.reference_text({"vary": {"a.h": [1, 2]}}) == "h 2" and
         precision.reference_text({"vary": {"h": [1]}, "reference": 3.0}) == "known", "what is referred to")
    with tempfile.TemporaryDirectory() as out:
        shown = case.show([], SimpleNamespace(common={}, runs={}, out=out))
        need(case.quantities_of({}) == ["axial_stress_Pa"] and shown.text == "", "a study without cases")


def schemas():
    """What a study's tables need: two values to sweep, a key that varies; which of several runs a table tells of."""
    entry = {"name": "s", "key": "k", "values": [1, 2], "quantity": "y"}
    need(schema.fault([entry], sweep.SCHEMA) is None and "too short" in schema.fault([{**entry, "values": [1]}],
                                                                                    sweep.SCHEMA), "values of a sweep")
    entry = {"name": "p", "vary": {"h": [1]}, "quantity": "y"}
    need(schema.fault([entry], precision.SCHEMA) is None and schema.fault([{**entry, "vary": {}}], precision.SCHEMA) and
         schema.fault([{**entry, "vary": {"h": []}}], precision.SCHEMA) and
         schema.fault([{**entry, "scale": 0}], precision.SCHEMA), "what varies")
    claim = {"claim": "c", "greater": ["a", "b"]}
    need(schema.fault([claim], check.SCHEMA) is None and schema.fault([{**claim, "greater": ["a"]}], check.SCHEMA) and
         schema.fault([{**claim, "greater": ["a"] * 3}], check.SCHEMA) and schema.fault(
             [{**claim, "between": [1]}], check.SCHEMA) and schema.fault([{**claim, "between": [1] * 3}], check.SCHEMA)
         and schema.fault([{**claim, "near": 0}], check.SCHEMA) and schema.fault([{**claim, "cases": []}],
          check.SCHEMA),
         "claims of two")
    curve = {"name": "p", "cases": ["a"], "corridor": [{"label": "l", "points": [[0, 1, 2], [1, 2, 3]]}]}
    said = [schema.fault("x" * n, {k: v}) for n, k, v in ((297, "type", "number"), (298, "type", "number"),
                                                          (284, "minLength", 400), (285, "minLength", 400))]
    need(said == ["'" + "x" * 297 + "': must be a number", "'" + "x" * 59 + " …: must be a number",
                  "'" + "x" * 284 + "' is too short", "must be minLength 400"], f"long messages: {said}")
    need(schema.fault([curve], plot.SCHEMA) is None and schema.fault([{**curve, "y_max": 0}], plot.SCHEMA), "plots")
    for points in ([[0, 1, 2]], [[0, 1], [1, 2]], [[0, 1, 2, 3], [1, 2, 3, 4]]):
        curve["corridor"][0]["points"] = points
        need(schema.fault([curve], plot.SCHEMA), f"a corridor of {points}")
    need(schema.fault({"w": "a" * 80}, schema.table({"w": schema.WORD})) is None and
         schema.fault({"w": "a" * 81}, schema.table({"w": schema.WORD})) and
         schema.fault({"w": ".a"}, schema.table({"w": schema.WORD})) and
         schema.fault({"w": "a" * 1001}, schema.table({"w": schema.TEXT})) and
         schema.fault({"w": []}, schema.table({"w": schema.SEEDS})), "words, texts and seeds")
    first, other = (made_up.run(axial_stress_Pa=v, time_step_s=t) for v, t in ((3e6, [4e-6] * 3), (9e6, [1e-6] * 3)))
    shown = table.show([{"name": "t", "title": "T", "reference": "a", "cases": ["a"]}],
                       SimpleNamespace(runs={"a": [first, other]}, labels={"a": "A"}))
    need(shown.text.splitlines()[-1].split()[:5] == "A 4e-06 … 4e-06 3".split()
        and shown.text.splitlines()[1].startswith(
        "T"), f"of several runs the first: {shown.text}")
    paid = numbers.cost({"summary": {"seconds": {}, "counts": {}}})
    need(math.isnan(paid.pop("cpu")) and paid == {"wall": 0, "grain_steps": 0, "rves": 0}, f"what nobody told: {paid}")
    need(math.isnan(numbers.energy_error({"summary": {"errors": {}}})), "an error that nobody told")


def texts(tmp):
    """Values as --set takes them, places in files, kinds of faults, times."""
    for value, text in ((True, "true"), (False, "false"), ("a b", '"a b"'), ("", ""), ({"a": 1, "b": ["x", 2.5]},
                                                                                      '{a = 1, b = ["x", 2.5]}'),
                        ([1, [2]], "[1, [2]]"), (0.1, "0.1"), (7, "7")):
        need(cases.toml_value(value) == text, f"{value!r} as {cases.toml_value(value)}")
    path = os.path.join(tmp, "s.toml")
    with open(path, "w") as f:
        f.write('# "peek"\ntitle = "t"\n[[case]]\nname = "a"  # "peek"\nset = { x = \'peek\' }\n[fit]\nx = ["peek"]\n')
    need(places.place_of(path, "peek") == f"{path}:5: case.x" and places.place_of(path, "none") == path and
         places.place_of(path, "t") == f"{path}:2: title", f"places: {places.place_of(path, 'peek')}")
    need(places.hint("peek", ["peak", "none"]) == " (did you mean 'peak'?)" and places.hint("peek", ["xyz"]) == "",
         "hints")
    refused(lambda: cases.read_checked(os.path.join(tmp, "none.toml"), lambda t: None), "no such file")
    refused(lambda: cases.read_checked(path, lambda t: "a fault"), f"{path}: a fault")
    need(cases.read_checked(path, lambda t: None)["title"] == "t", "a file without a fault")
    with open(os.path.join(tmp, "bad.toml"), "w") as f:
        f.write("a = ")
    refused(lambda: cases.read_checked(f.name, lambda t: None), f.name)
    refused(lambda: cases.scene_of("here", None, tmp), "here: needs a scene")
    refused(lambda: cases.scene_of("here", "none.toml", tmp), "no such scene file")
    refused(lambda: cases.scene_of("here", "bad.toml", tmp), "bad.toml")
    with open(os.path.join(tmp, "mesh.toml"), "w") as f:
        f.write("[mesh]\n")
    need(cases.scene_of("w", "x/../mesh.toml", tmp) == {"scene": f.name, "program": "grus-bvp"} and
         cases.scene_of("w", "s.toml", tmp)["program"] == "grus-rve", "scenes and their programs")
    kind = schema.table({"w": schema.WORD, "n": schema.POSITIVE, "e": schema.MEASURE, "t": schema.tables(
        {"a": schema.NUMBER}, ("a",)), "v": schema.NAMES}, ("w",))
    for data, fault in (({"w": "a.b"}, None), ({"w": "a", "x": 1}, "unknown key 'x' (known: e, n, t, v, w)"),
                        ({}, "needs 'w'"), ({"w": "a/b"}, "w: 'a/b': must be a word of letters"),
                        ({"w": "a", "e": "no"}, "e: 'no' is none of at, peak, last, area"),
                        ({"w": "a", "t": [{"a": 1}, {}]}, "t[1]: needs 'a'"), ({"x": 1}, "unknown key 'x'"),
                        ({"w": "a", "t": [{"a": "x"}]}, "t[0].a: 'x': must be a number"),
                        ({"w": "a", "n": 0}, "n: 0 is less than or equal to the minimum of 0"),
                        ({"w": "a", "v": [1] * 200}, "v[0]: 1: must be a text"), ({"w": []}, "w: []: must be a text")):
        found = schema.fault(data, kind)
        need(found == fault if fault is None else str(found).startswith(fault), f"{data}: {found}")
    need([command.duration_text(s) for s in (119, 120, 7199, 7200, 9000)] ==
         ["119 s", "2 min", "120 min", "2.0 h", "2.5 h"], "times as they are said")
    for text, seconds in (("2 h", 7200), ("90 min", 5400), (" 1.5e1 s ", 15), ("7", 7), ("500 ms", 0.5)):
        near(interrupts.duration(text), seconds, text)
    for text in ("0", "-1 s", "1 day", "x", "inf", "", "1e400"):
        refused(lambda: interrupts.duration(text), "expected a time above 0", argparse.ArgumentTypeError)
    need(programs.program_of({"mesh": 1}) == "grus-bvp" and programs.program_of({}) == "grus-rve", "programs")
    refused(lambda: programs.found("grus-none"), "grus-none: not found", InputError)
    need(os.path.basename(programs.found("grus-rve")) == "grus-rve" and programs.folder() == programs.beside() and
         os.access(os.path.join(programs.beside(), "grus-rve"), os.X_OK), "where programs are")
    base, fixed = tables.shared_by_cases("w", {"set": {"a": 1, "c": 3}}, SimpleNamespace(
        common={"scene": "s.toml", "seeds": [5], "set": {"a": 0, "b": 2}}, folder=tmp))
    need(base["seeds"] == [5] and fixed == {"a": 1, "b": 2, "c": 3}, f"settings in common: {base} {fixed}")
    made = tables.unnamed_case(base, fixed, {"d": 4})
    need(made["set"] == {**fixed, "d": 4} and made["label"] == "d=4" and len(made["name"]) == 12 and
         made["name"] == tables.unnamed_case(base, {**fixed, "d": 4}, {})["name"] !=
         tables.unnamed_case(base, fixed, {"d": 5})["name"], f"a case by its settings: {made}")
    need(tables.asked("n", "q") == ("n", {"q", "axial_strain"}, set()) and tables.asked("n", "q", None) ==
         ("n", {"q"}, set()) and tables.asked("n", "a.q") == ("n", set(), {"a.q"}), "what a quantity needs")


def files(tmp):
    """Which files a run may read: what its texts name, and what these name; not what they only look like."""
    for name, text in (("a.toml", 'x = ["b.toml", "m.msh"]\ny = { z = "far/p.txt" }\nk = "set=c.csv"\n'),
                       ("b.toml", 'back = "a.toml"\nd = "d.txt"\n'), ("bad.toml", "x = "), ("m.msh", ""), ("c.csv", ""),
                       ("d.txt", "e.txt"), ("e.txt", ""), ("far/p.txt", ""), ("s.txt", "")):
        os.makedirs(os.path.dirname(os.path.join(tmp, name)), exist_ok=True)
        with open(os.path.join(tmp, name), "w") as f:
            f.write(text)
    found = kept.files_read(os.path.join(tmp, "a.toml"), {"n": "s.txt", "more": "x" * 2000, "nul": "a\0b"})
    need(found == sorted(os.path.join(tmp, n) for n in ("a.toml", "b.toml", "c.csv", "d.txt", "far/p.txt", "m.msh",
                                                        "s.txt")), f"files of a scene: {found}")
    need(kept.files_read(os.path.join(tmp, "bad.toml"), {}) == [os.path.join(tmp, "bad.toml")], "a file that is bad")
    only = {}
    for name in ("summary.json", "history.csv", "grading.csv", None):
        folder = os.path.join(tmp, f"only_{name}")
        os.makedirs(folder)
        if name:
            with open(os.path.join(folder, name), "w") as f:
                f.write("same")
        only[name] = kept.digest_of(folder)
    need(len(set(only.values())) == 4, "which file of a run is there")
    need(kept.text_of(os.path.join(tmp, "none")) is None and kept.text_of(os.path.join(tmp, "d.txt")) == "e.txt",
         "texts of files")


def times():
    """When a tool ends by itself, what it hears, and what it hands on."""
    asked, ignored = [], signal.getsignal(signal.SIGHUP)
    begun, timer, clock = interrupts.BEGAN, signal.setitimer, time.monotonic
    signal.setitimer, time.monotonic, interrupts.BEGAN = lambda _, s: asked.append(s), lambda: 103.0, 100.0
    alarm = signal.getsignal(signal.SIGALRM)
    try:
        for seconds in (1.0, 4.0, 10.0, 200.0, 10000.0):
            interrupts.end_after(seconds)
        near(asked, [1e-3, 0.2, 6.0, 193.0, 9937.0], "2 % of the time before its end, a second to a minute")
        try:
            signal.getsignal(signal.SIGALRM)(0, None)
            need(False, "the end of the time is not told")
        except interrupts.OutOfTime:
            pass
        heard = []
        process = lambda begun, n: SimpleNamespace(begun=begun, send_signal=lambda s: heard.append((n, s)))
        interrupts.hand_on([process(100.9, 1), process(101.5, 2), SimpleNamespace(send_signal=heard.append)])
        signal.getsignal(signal.SIGUSR1)(signal.SIGUSR1, None), signal.getsignal(signal.SIGUSR2)(signal.SIGUSR2, None)
        need(heard == [(1, signal.SIGUSR1), (1, signal.SIGUSR2)], f"who hears of a wish: {heard}")
    finally:
        signal.setitimer, time.monotonic, interrupts.BEGAN = timer, clock, begun
        signal.signal(signal.SIGALRM, alarm)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    interrupts.raise_again()
    need(signal.getsignal(signal.SIGHUP) == signal.SIG_IGN and all(
        signal.getsignal(s) == signal.default_int_handler for s in (signal.SIGINT, signal.SIGTERM)), "nohup stays")
    interrupts.end_at_once("tool")
    reads, writes = os.pipe()
    child = os.fork()
    if child == 0:
        os.dup2(writes, 2), signal.getsignal(signal.SIGTERM)(0, None), os._exit(0)
    os.close(writes)
    with os.fdopen(reads) as said:
        need(said.read() == "tool: interrupted, nothing was written\n"
             and os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 130, "an early end")
    signal.getsignal(signal.SIGUSR1)(0, None)
    interrupts.raise_again(), signal.signal(signal.SIGHUP, ignored)


def ends(tmp):
    """Exit statuses of a command by what its work raises, and its log."""
    log = os.path.join(tmp, "log")
    args = lambda **more: SimpleNamespace(**{"log": None, "max_time": None, "scene": "S", **more})

    def status(work, **more):
        errors, out, before = io.StringIO(), io.StringIO(), (sys.stdout, sys.stderr)
        try:
            with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(out):
                found = command.status_of("tool", args(**more), work, "stopped")
        finally:
            sys.stdout, sys.stderr = before
        return found, errors.getvalue()

    def raises(e):
        def work(_):
            raise e
        return work
    for error, wanted in ((InputError("a\nb"), (2, "tool: a b\n")), (InputError("bad"), (2, "tool: bad\n")),
                          (command.Lacking("none"), (1, "tool: S: none\n")),
                          (KeyboardInterrupt(), (130, "tool: stopped\n")),
                          (interrupts.OutOfTime(),
                           (75, "tool: out of time: finished runs are kept; the same command goes on\n")),
                          (ZeroDivisionError("x"), (1, "tool: S: ZeroDivisionError: x (GRUS_DEBUG=1 shows where)\n"))):
        need(status(raises(error)) == wanted, f"{error!r}: {status(raises(error))}")
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    need(status(lambda _: 7) == (7, "") and signal.getsignal(signal.SIGTERM) == signal.default_int_handler,
         "a status of its own; signals are heard")
    os.environ["GRUS_DEBUG"] = "1"
    try:
        status(raises(ZeroDivisionError()))
        need(False, "the whole story is not told")
    except ZeroDivisionError:
        pass
    del os.environ["GRUS_DEBUG"]
    need(status(lambda _: print("one\ntwo") or 0, log=log)[0] == 0, "a log")
    need(status(lambda _: print("three") or 0, log=log)[0] == 0, "a log that goes on")
    with open(log) as f:
        lines = f.read().splitlines()
    need([line[21:] for line in lines] == ["one", "two", "three"] and all(
        interrupts.LINE_OF_LOG.match(line.encode()) for line in lines), f"the log: {lines}")
    with open(os.path.join(tmp, "other"), "w") as f:
        f.write("2026-01-01 not a log of anybody\n")
    text = f"tool: --log: {f.name}: is there and is not a log of Grus: name another file\n"
    need(status(lambda _: 0, log=f.name) == (2, text), "a file that is no log")
    need(status(lambda _: 0, log=tmp)[1].startswith(f"tool: --log: {tmp}: cannot write: "), "a folder as a log")
    open(os.path.join(tmp, "empty"), "w").close()
    need(status(lambda _: 0, log=os.path.join(tmp, "empty"))[0] == 0, "an empty file may become a log")
    asked, timer = [], interrupts.end_after
    interrupts.end_after = asked.append
    need(status(lambda _: 0, max_time=50.0)[0] == 0 and status(lambda _: 0)[0] == 0 and asked == [50.0], "its time")
    interrupts.end_after = timer


made_up.unpainted()
limits()
told()
schemas()
times()
for of in (texts, files, ends):
    with tempfile.TemporaryDirectory() as place:
        of(place)
print(f"study_edges: {len(faults)} faults")
sys.exit(1 if faults else 0)
