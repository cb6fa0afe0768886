#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A calibration at the edges: limits that are met exactly, what its report draws and says, which files it refuses, the
scene that it leaves. calibrate_edges.py BIN"""
import contextlib
import io
import math
import os
import re
import sys
import tempfile
import time
import tomllib
from types import SimpleNamespace

import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.calibrate import command, posterior, reader, regression, report, schema, targets  # noqa: E402
from grus.errors import InputError  # noqa: E402
from grus.figures import plt, told_as  # noqa: E402
from grus.files.texts import BadData  # noqa: E402

import made_up  # noqa: E402
import scene_tools  # noqa: E402
from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402

nan = math.nan


def refused(work, words, kind=InputError):
    scene_tools.refused(words, work, kind)


def verdicts():
    of = lambda x, sd, **more: regression.verdicts(SimpleNamespace(
        x=np.array(x), covariance=np.diag(np.array(sd) ** 2)), [f"p{k}" for k in range(len(x))], **more)
    sd = lambda value: math.sqrt(value**2)  # what a root makes of a limit
    need(of([0.5, 0.5], [sd(0.1), sd(0.15)]) == ["identified", "weak"], f"deviations at the limits: {of([.5], [.1])}")
    need(of([1e-3, 1 - 1e-3, 0.5], [0.01] * 3) == ["not identified: at its lower bound",
                                                   "not identified: at its upper bound", "identified"], "bounds")
    # A direction counts as an exchange from three tenths of the other's part, and of its own length, on.
    for part, shown in ((0.29, False), (0.35, True)):
        line = np.array([1.0, part])
        covariance = 0.3**2 * np.outer(line, line) / (line @ line) + 1e-8 * np.eye(2)
        text = regression.verdicts(SimpleNamespace(x=np.full(2, 0.5), covariance=covariance), ["one", "two"])[0]
        need(("combination with two" in text) == shown, f"{part}: {text}")
    near(regression.weights_of(np.array([[0.5], [0.6], [2.0]]), np.zeros(3, bool), np.array([0.5]), 0.1), [1, 1, 1e-3],
         "inside of the box, and far away")
    few = regression.few(np.zeros((1, 1)), np.zeros((1, 1)), 3, 5)
    need(1 < few < regression.few(np.eye(1), np.eye(1), 3, 5), "runs that do not scatter")
    # Slopes that noise alone would show tell nothing, however large it is: even over the range is what is left.
    loud = SimpleNamespace(slope=lambda x: np.eye(2), leverage=lambda x: 0.0, noise=np.eye(2),
                           slope_spread=lambda: 1e3 * np.eye(2))
    data = regression.Data(np.zeros(2), np.full(2, 0.1), np.ones(2), np.zeros(2))
    near(regression.uncertainty(loud, np.full(2, 0.5), data, np.zeros((2, 2)), np.zeros((2, 2)), 1e9, 7)[0],
         np.eye(2) / 12, "a surface of noise", 1e-6)
    y = regression.filled([regression.Answer(np.array(v), None, None) for v in ([2.0, 4.0], [2.0, nan])])
    near(y, [[2, 4], [2, 4]], "nothing to be worse than")


def parameter(low, high, **more):
    return reader.Parameter("here", {"key": "material.sand.k", "min": low, "max": high, **more})


def best(tmp):
    """The scene that is left: tables in tables, lists of tables, settings below them, words and nothing."""
    scene = os.path.join(tmp, "scene.toml")
    with open(scene, "w") as f:
        f.write('title = "t"\nlist = [1, 2]\n[material.sand]\nk = 1\nname = "s"\n[empty]\n[[grain]]\nr = 1\n[[grain]]\n'
                'r = 2\n[loading]\nkind = "x"\ngone = 4\n')
    run = {"scene": scene, "set": {"grain.1.r": 5, "loading.gone": "", "fresh.deep.key": True, "list.1": 7}}
    text = command.best_scene(run, [parameter(1, 3), parameter("1 m", "5 m", name="n")], [0.5, 0.25])
    found = tomllib.loads(text)
    wanted = {"title": "t", "list": [1, 7], "material": {"sand": {"k": "2.0 m", "name": "s"}}, "empty": {},
              "grain": [{"r": 1}, {"r": 5}], "loading": {"kind": "x"}, "fresh": {"deep": {"key": True}}}
    need(found == wanted and text.endswith("\n") and text.count("[[grain]]") == 2 and "[material]" not in text,
         f"the best scene: {text}")
    out = SimpleNamespace(rows=[{"x": [0.5], "values": np.array([1.5, nan, 1 / 3]), "failed": True}])
    both = [SimpleNamespace(name="one", values=[0.0]), SimpleNamespace(name="two", values=[0.0, 0.0])]
    command.write_tables(tmp, [parameter(1, 3)], both, out, SimpleNamespace(values=np.array([1.0, 2.0, 1 / 7])))
    with open(os.path.join(tmp, "calibration.csv")) as f:
        need(f.read().splitlines() == ["k,failed,one,two[0],two[1]", "data,,1,2,0.142857143", "2,1,1.5,,0.333333333"],
             "calibration.csv")
    evaluation = command.Evaluation(None, [], [], [], 1, 10, False)
    for quiet, terminal, shown in ((False, False, ""), (True, True, ""), (False, True, "\r2.5 of 10 points")):
        evaluation.quiet, stream = quiet, io.StringIO()
        stream.isatty = lambda terminal=terminal: terminal
        evaluation.start, evaluation.points = time.time() - 1000, 2
        with contextlib.redirect_stderr(stream):
            evaluation.show(0.5)
        need(stream.getvalue().startswith(shown) and bool(stream.getvalue()) == bool(shown), f"{stream.getvalue()!r}")
    evaluation.points = 20
    with contextlib.redirect_stderr(stream):
        evaluation.show(1.0)
    need("ETA 0 s" in stream.getvalue(), f"beyond its budget: {stream.getvalue()!r}")


CALIBRATION = """[calibrate]
scene = "{scene}"
seeds = [3]
parameters = [ {{ key = "a.k", min = {low}, max = {high} }} ]
targets = [ {targets} ]
"""


def files(tmp):
    """Calibrations that are read, and those that are refused in a line."""
    for name, text in (("scene.toml", ""), ("mesh.toml", "[mesh]\n"), ("d.csv", "x,y\n1,2\n"),
                       ("g.csv", "diameter_m,passing\n1e-3,0.5\n")):
        with open(os.path.join(tmp, name), "w") as f:
            f.write(text)

    def read(*given, scene="scene.toml", low=1, high=2):
        path = os.path.join(tmp, "c.toml")
        with open(path, "w") as f:
            f.write(CALIBRATION.format(scene=scene, low=low, high=high, targets=", ".join(given)))
        return reader.read_calibration(path)
    value = '{ name = "v", kind = "value", quantity = "q", value = 1 }'
    curve = '{ name = "c", data = "d.csv", x = "x", y = "y", set = { z = 1 } }'
    graded = '{ name = "g", kind = "grading", data = "g.csv", at = "2 MPa", seeds = [4, 5], scene = "mesh.toml" }'
    _, table, parameters, found, runs = read(value, curve, graded, value.replace('"v"', '"w"'))
    need([t.name for t in found] == ["v", "c", "g", "w"] and [[t.name for t in r["targets"]] for r in runs] ==
         [["v", "w"], ["c"], ["g"]], f"who shares runs: {[[t.name for t in r['targets']] for r in runs]}")
    need([(r["program"], r["seeds"], r["set"], r["label"]) for r in runs] == [
        ("grus-rve", [3], {}, "scene.toml"), ("grus-rve", [3], {"z": 1}, "scene.toml"),
        ("grus-bvp", [4, 5], {}, "mesh.toml")], "their scenes, seeds and settings")
    near(found[2].table["at_stress"], 2e6, "a stress with its unit")
    case = reader.case_at(runs[1], parameters, [0.5])
    need(case["set"] == {"z": 1, "a.k": 1.5} and case["name"] == reader.case_at(runs[1], parameters, [0.5])["name"] !=
         reader.case_at(runs[1], parameters, [0.6])["name"] and case["name"].startswith(runs[1]["name"] + "_"),
         f"a case: {case['name']}")
    for given, words in (((value, value), "two targets share a name"),
                         ((graded.replace("2 MPa", "2 s"),), "neither a strain nor a stress"),
                         ((graded.replace("2 MPa", "x Pa"),), "neither a strain nor a stress"),
                         ((value.replace("value = 1", 'value = 1, at = "1 Pa"'),), "a stress is for gradings"),
                         ((curve.replace("d.csv", "none.csv"),), "none.csv"),
                         (('{ name = "c", x = "x", y = "y" }',),
                          "calibrate.targets[0]: c: a target of kind \"curve\" needs 'data'"),
                         (('{ name = "q", kind = "peak", quantity = "q" }',), "of kind \"peak\" needs 'value'"),
                         (('{ name = "q", kind = "none" }',), "is none of")):
        refused(lambda: read(*given), words)
    refused(lambda: read(value, scene="none.toml"), "no such scene file")
    refused(lambda: read(value, low='"1 m"', high='"5 Pa"'), "different units")
    near(read(value, low='"1 kPa"', high='"5 MPa"')[2][0].number(1), 5000, "units of one kind")
    need(schema.fault({"calibrate": {"parameters": [], "targets": []}}) is not None and
         set(schema.NEEDS) == set(schema.TARGET["kind"]["enum"]), "what kinds of targets need")
    near([reader.Parameter.split(None, "w", v)[0] for v in ("+1.5e0 x", " .5 x ", "2. x", "-3 x", 7)],
         [1.5, 0.5, 2, -3, 7], "numbers with units")
    for v in ("", "m", "x 1"):
        refused(lambda v=v: reader.Parameter.split(None, "w", v), "is no number with a unit")
    refused(lambda: parameter(0, 1, scale="log"), "min above 0")
    refused(lambda: targets.Target({"name": "g", "kind": "grading", "data": "bad.csv", "at": 0}, tmp), "bad.csv",
            BadData)


def asked(tmp):
    """What is checked before anything runs: how many runs suffice, and what is said of parameters and targets."""
    hearing = []

    class Runner:
        def __init__(self, out, seed_key, bins, wanted):
            self.asked, self.said = wanted, None
            hearing.append((out, seed_key))

        def refusal(self, case):
            hearing.append((case["set"], self.asked[case["name"]]))
            return self.said

        stopped = False

        def ask(self, case, seed, *options, within):
            need(options == ("--check", "--threads", "1") and seed == case["seeds"][0], f"asked for {options}")
            return 0, "  run time 2.0 s to 4.0 s (of it)", ""
    with open(os.path.join(tmp, "scene.toml"), "w"):
        pass
    command.Runner, before, folder = Runner, command.Runner, command.programs.folder
    command.programs.folder = lambda: "bins"

    def check(more="", targets='{ name = "v", kind = "value", quantity = "q", value = 1 }', seeds="[3]", **options):
        path = os.path.join(tmp, "asked.toml")
        with open(path, "w") as f:
            f.write(CALIBRATION.format(scene="scene.toml", low=1, high=3, targets=targets).replace(
                "seeds = [3]", f"seeds = {seeds}\n{more}"))
        hearing.clear()
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            status = command.work(SimpleNamespace(**{"scene": path, "out": None, "threads": 1, "check": True,
                                                     "quiet": False, **options}))
        return status, said.getvalue().splitlines()
    status, lines = check()
    need((status, lines) == (0, ["a.k: 1.0 … 3.0", "v: value, 1 value, 1 … 1",
                                 "90 points, 1 runs each, 3 min to 6 min on 1 core"]), f"{lines}")
    need(hearing[0] == ("asked", "packing.seed") and [h[0]["a.k"] for h in hearing[1:]] == [1, 2, 3] and
         hearing[1][1] == ({"q"}, set()), f"who is asked for what: {hearing}")
    two = '{ name = "v", kind = "value", quantity = "a.b", value = 1 }, { name = "w", kind = "peak", quantity = "q", ' \
          'value = 2, seeds = [1, 2, 3] }'
    status, lines = check('seed_key = "s"', two, out="elsewhere/out")
    need(lines[-1] == "30 points, 4 runs each, 4 min to 8 min on 1 core" and hearing[0] == ("elsewhere/out", "s") and
         len(hearing) == 7 and hearing[1][1] == (set(), {"a.b"}), f"two scenes: {lines} {hearing}")
    for more, seeds, least in (("budget = {}", "[3]", 6), ("budget = {}", "[3, 4]", 12),
                               ("check = false\nbudget = {}", "[3]", 3)):
        need(check(more.format(least), seeds=seeds)[0] == 0, f"{least} runs suffice")
        few = (least - 1) // (2 if "," in seeds else 1)
        refused(lambda: check(more.format(least - 1), seeds=seeds),
                f"budget: {few} points of {seeds.count(',') + 1} seeds; 1 parameters need at least {least} runs")
    for stops in (True, False):
        def refusal(self, case, error=KeyboardInterrupt if stops else OSError):
            raise error
        Runner.refusal = refusal
        Runner.stop = lambda self: hearing.append("stopped")
        try:
            check()
            need(False, "a check that was interrupted goes on")
        except (KeyboardInterrupt, OSError):
            need((hearing[-1] == "stopped") == stops, "who is stopped")
    Runner.refusal = lambda self, case: SimpleNamespace(told=lambda path: f"{path}: no such key")
    refused(check, "asked.toml: no such key")
    Runner.refusal = lambda self, case: None
    need(check('method = "pounders"\nbudget = 1')[0] == 0, "one point after the other")
    command.Runner, command.programs.folder = before, folder


def data_at_limits(tmp):
    """Data that are just allowed: zeros without a logarithm, nothing and all that passes."""
    def of(text, **table):
        with open(os.path.join(tmp, "limits.csv"), "w") as f:
            f.write(text)
        return targets.Target({"name": "t", "data": "limits.csv", **table}, tmp)
    near(of("x,y\n0,1\n-1,2\n", x="x", y="y").x, [0, -1], "places at and below 0")
    near(of("diameter_m,passing\n1e-3,0\n2e-3,1\n", kind="grading", at=0).values, [0, 1], "what passes")
    near(of("x,y\n1,5\n2,5\n", x="x", y="y").error, [0.1, 0.1], "2 % of what does not change")
    near(of("x,y\n1,5\n3,9\n", x="x", y="y").error, [0.08, 0.08], "2 % of the range")
    t = of("x,y\n1,5\n3,9\n", x="x", y="y")
    need(t.describe().startswith("2 values, x 1 … 3, y 5 … 9"), t.describe())
    t = of("diameter_m,passing\n1e-3,0\n2e-3,1\n", kind="grading", at=0)
    need(t.describe() == "2 values, diameter_m 1 … 2 mm, passing 0 … 1" and t.columns() ==
         {"axial_strain", "axial_stress_Pa"}, t.describe())
    n = 5
    runs = [made_up.run(y=1.0 + k) for k in range(n)]
    value = targets.Target({"name": "t", "kind": "value", "quantity": "y", "value": 1.0}, tmp)
    near(value.answer(runs[:1])[1], [[0]], "one run does not scatter")
    near(value.answer(runs)[1], [[2.5]], "five do")
    key = "results.peak_before_breakage_Pa"
    grain = lambda v: made_up.run(breakages=[0.0, 0.0, 1.0], results={"peak_before_breakage_Pa": v})
    strength = of("value (Pa)\n3\n", kind="quantiles", quantity=key)
    near(strength.answer([grain(1.0), grain(5.0), grain(0.0)])[1], [[6 * np.var([1.0, 5.0, 3.0])]],
        "two of three are known")
    near(strength.answer([grain(1.0), grain(0.0), grain(0.0)])[1], [[0]], "one of three")
    states = {0.0: [{"diameter_m": 1e-3, "passing": 0.5}], 0.2: [{"diameter_m": 1e-3, "passing": 0.7}]}
    graded = made_up.run(grading=states)
    for at, wanted in ((0.0, 0.5), (0.2, 0.7), (0.2 + 1e-10, 0.7), (-1e-10, 0.5), (0.21, nan), (-0.01, nan)):
        sieve = of("diameter_m,passing\n1e-3,0.5\n", kind="grading", at=at)
        near(sieve.answer([graded])[0], [wanted], f"a grading at {at}")


def targets_met():
    """Curves and kinks at their ends."""
    near(targets.along([0.0, 1.0], [5.0, 7.0], [0.0, 1.0, 1.0 + 1e-9, -1e-9]), [5, 7, nan, nan], "ends of a curve")
    near(targets.along([0.0, 0.0, 1.0], [5.0, 9.0, 7.0], [0.0]), [5], "the first of two")
    near(targets.along([0.0, 1.0, 4.0], [1.0, 2.0, 6.0], [2.0], True), [4], "in logarithms, without what has none")
    near(targets.along([nan, 1.0], [1.0, nan], [1.0]), [nan], "nothing is known")
    x = np.linspace(0, 1, 5)
    need(math.isnan(targets.kink(x, x, False)) and targets.kink(np.linspace(0, 1, 6), np.ones(6), False) > 0,
         "six points at least")
    text = lambda **table: targets.Target({"name": "t", **table}, ".").describe()
    need(text(kind="value", quantity="q", value=2.0).startswith("1 value, "), "what was read")
    key = lambda **table: targets.Target({"name": "t", "value": 1.0, **table}, ".").keys()
    need(key(kind="value", quantity="a.b") == {"a.b"} and key(kind="peak", quantity="a") == set(), "keys of summaries")


def axes(fig):
    ax = fig.axes[0]
    return ax, (ax.get_title(), ax.get_xlabel(), ax.get_ylabel(), ax.get_xscale())


def drawn():
    """What the report draws: data with bars, fits, what was tried; draws, deviations, correlations."""
    of = lambda kind, log=False, **table: SimpleNamespace(
        name="T", kind=kind, log=log, x=np.array([1.0, 2.0]), values=np.array([3.0, 4.0]), error=np.array([0.5, 1.0]),
        table=table)
    for target, wanted in ((of("curve", x="strain", y="stress"), ("T", "strain", "stress", "linear")),
                           (of("curve", True, x="p", y="e"), ("T", "p", "e", "log")),
                           (of("grading"), ("T", "diameter (mm)", "passing", "log")),
                           (of("quantiles", quantity="a.s_t_Pa"), ("T", "share of grains", "s t (Pa)", "linear"))):
        ax, found = axes(report.target_plot(target, [np.array([1.0, 1.0])], np.array([5.0, 6.0]), np.array([7.0, 8.0])))
        need(found == wanted, f"axes of a target: {found}")
        if found[3] == "log":
            need(ax.xaxis.get_major_formatter()(20.0, 0) == "20", "plain numbers")
        lines = {line.get_label(): list(line.get_ydata()) for line in ax.get_lines()}
        need(lines["fit"] == [5, 6] and lines["run at the best point"] == [7, 8] and [1, 1] in lines.values(),
             f"{lines}")
        near([s[:, 1] for s in ax.collections[0].get_segments()], [[2.5, 3.5], [3, 5]], "bars of the data")
    ax, _ = axes(report.target_plot(of("curve"), [], np.array([5.0, 6.0]), None))
    need([t.get_text() for t in ax.get_legend().get_texts()] == ["fit", "data"], "without a run at the best point")
    plt.close("all")
    two = [parameter(0, 10, name="one"), parameter(0, 100, name="two")]
    draws = np.column_stack([np.linspace(0, 1, 100), np.linspace(1, 0, 100)])
    fig = report.posterior_plot(draws, two)
    places = [[fig.axes[2 * i + k] for k in (0, 1)] for i in (0, 1)]
    cross = places[1][0].get_lines()[0]
    near((cross.get_xdata()[:2], cross.get_ydata()[:2]), ([0, 100 / 99], [100, 100 - 1000 / 99]), "each tenth draw",
         1e-9)
    need(not places[0][1].axison and len(places[0][0].patches) == len(places[1][1].patches) == 40 and
         [a.get_xlabel() for row in places for a in row] == ["", "", "one", "two"] and
         [a.get_ylabel() for row in places for a in row] == ["one", "", "two", ""] and
         list(places[0][0].get_yticks()) == [], "names at the rim")
    near(places[0][0].get_xlim()[1], 10, "in the parameter's unit", 0.2)
    ax, found = axes(report.deviations_plot([(5, None, np.array([0.3, 0.2])), (9, None, np.array([0.1, 0.05]))],
                                            ["one", "two"]))
    need(found[:3] == ("What more runs bring", "points", "standard deviation (% of range)"), f"{found}")
    near([line.get_ydata() for line in ax.get_lines()[:2]], [[30, 10], [20, 5]], "deviations")
    near(ax.get_lines()[2].get_ydata(), [10, 10], "where a value is identified")
    need([line.get_label() for line in ax.get_lines()[:2]] == ["one", "two"], "whose they are")
    fig = report.correlation_plot([[1.0, -0.5], [-0.5, 1.0]], ["one", "two"])
    image = fig.axes[0].images[0]
    near(image.get_array(), [[1, -0.5], [-0.5, 1]], "correlations")
    need(image.get_clim() == (-1, 1) and len(fig.axes) == 2 and
         [t.get_text() for t in fig.axes[0].get_xticklabels()] == ["one", "two"] ==
         [t.get_text() for t in fig.axes[0].get_yticklabels()], "from -1 to 1")
    plt.close("all")


def said():
    target = {"name": "t", "kind": "curve", "points": 3, "rms_in_standard_deviations": 3.0, "stronger_than": 0,
              "runs": 9, "still_rising": 0}
    need(report.said_of_runs({"targets": [target], "refused_points": 0}) == [], "three deviations are near")
    p = parameter(0, 10, name="one")
    summary = {"points": 7, "failed_points": 2, "targets": [target], "refused_points": 0,
               "parameters": [{"sd_of_range": 0.05, "verdict": "identified", "key": "k", "name": "one"}]}
    text = report.values_table(summary, [p], SimpleNamespace(x=[0.5], covariance=np.array([[0.0025]])))
    need("5 ± 0.5" in text and "7 points, 2 of them" in text and "identified" in text and "<td>5.0 %</td>" in text,
         f"{text}")
    need("+0.50" in report.correlations({"correlation": [[1.0, 0.5], [0.5, 1.0]]}, ["a", "b"]), "signs")
    side = {"name": "a", "at": [1.0, 2.0], "sum_of_squares": [3.0, 4.0]}
    text = report.neighbours({"best": 1.23456, "sides": [side]}, {"a": ""})
    need("<td>a</td><td>1</td><td>3</td><td>2</td><td>4</td>" in text and "1.235" in text, f"{text}")
    text = report.posterior_table([{"key": "k", "median": 1.0, "middle_68": [2.0, 3.0], "middle_95": [4.0, 5.0]}])
    need("<td>k</td><td>1</td><td>2 … 3</td><td>4 … 5</td>" in text, f"{text}")
    need("<td>t</td><td>curve</td><td>3</td><td>3.00</td>" in report.misfits([target]), "misfits")
    with tempfile.TemporaryDirectory() as out:
        made = [SimpleNamespace(name=f"t{n}", kind="curve", log=False, values=np.ones(n), x=np.arange(n),
                                error=np.ones(n), table={}) for n in (2, 1, 3)]
        shown, before = [], report.target_plot
        report.target_plot = lambda t, *rest: shown.append((t.name, *rest)) or plt.subplots()[0]
        body = report.target_plots(out, made, [{"values": np.arange(6.0)}], np.arange(6.0), [10, 11, 12, 13, 14, 15])
        report.target_plot = before
        need([(s[0], list(s[1][0]), list(s[2]), list(s[3])) for s in shown] ==
             [("t2", [0, 1], [0, 1], [10, 11]), ("t3", [3, 4, 5], [3, 4, 5], [13, 14, 15])] and
             body.count("<img") == 2 and sorted(os.listdir(os.path.join(out, "plots"))) == ["target_0.png",
                                                                                            "target_2.png"],
             f"targets of more than one point: {shown}")
    of = lambda name, *values: told_as(name, values)
    need([of("axial_stress_Pa", -3e6, 2e3), of("results.peak_q_Pa", 5e3), of("moved_top_z_m", 1.0), of("work_J", 2.0),
          of("void_ratio", 0.5), of("s", 1.0)] == [(1e6, "axial stress (MPa)"), (1e3, "peak q (kPa)"),
                                                   (1e-3, "moved top z (mm)"), (1.0, "work (J)"), (1.0, "void ratio"),
                                                   (1.0, "s")], "columns in the units of people")
    text = report.best_scenes(["best.toml"], ["runs/a@1"])
    need("<code>best.toml</code>" in text and "<code>runs/a@1</code>" in text and
         "have been run" not in report.best_scenes(["best.toml"], []), "where the answer is")
    flat_rows = lambda text: [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in text.split("<tr>")[1:]]
    curve = SimpleNamespace(name="c", kind="curve", table={"x": "e", "y": "s"}, x=np.arange(3.0), values=np.array([
        2.0, 4.0, 8.0]), error=np.array([0.5, 1.0, 2.0]))
    rows = flat_rows(report.fit_table(curve, np.array([2.0, 5.0, 5.0]), np.array([1.0, 4.0, 9.0])))
    need(rows == [["e", "s, data", "standard deviation", "fit", "off by (sd)", "run at the best point", "off by (sd)"],
                  ["0", "2", "0.5", "2", "+0.00", "1", "-2.00"], ["1", "4", "1", "5", "+1.00", "4", "+0.00"],
                  ["2", "8", "2", "5", "-1.50", "9", "+0.50"]], f"target beside fit: {rows}")
    rows = flat_rows(report.fit_table(curve, np.array([2.0, 5.0, 5.0]), None, 2))
    need([r[0] for r in rows] == ["e", "0", "2"] and len(rows[0]) == 5, f"every second: {rows}")
    peak = SimpleNamespace(name="p", kind="peak", table={"quantity": "q_Pa"}, x=np.zeros(1), values=np.array([3e6]),
                           error=np.array([1e5]))
    need(flat_rows(report.fit_table(peak, np.array([2.9e6]), None)) == [
        ["target", "q (MPa), data", "standard deviation", "fit", "off by (sd)"], ["p", "3", "0.1", "2.9", "-1.00"]],
        "a peak")
    need(posterior.STEPS > 2 * posterior.REST, "most of the steps are told of")


made_up.unpainted()
verdicts()
targets_met()
drawn()
said()
for of in (best, files, asked, data_at_limits):
    with tempfile.TemporaryDirectory() as place:
        of(place)
print(f"calibrate_edges: {len(faults)} faults")
sys.exit(1 if faults else 0)
