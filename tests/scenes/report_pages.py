#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the figures and the page of grus-report say, word by word, and which results it refuses: report_pages.py BIN"""
import base64
import json
import math
import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus import figures  # noqa: E402
from grus.figures import plt  # noqa: E402
from grus.report import bvp_plots, command, rve_plots  # noqa: E402

import made_up  # noqa: E402
from scene_tools import faults, need  # noqa: E402

E = [0.0, 0.1, 0.2]
SAMPLE = {
    "axial_strain": E, "time_s": [0.0, 1.0, 2.0], "axial_stress_Pa": [0.0, 1e6, 2e6], "grains": [10.0, 12.0, 14.0],
    "mean_pressure_Pa": [0.0, 5e5, 1e6], "void_ratio": [0.7, 0.6, 0.5], "breakages": [0.0, 2.0, 4.0],
    "energy_error": [0.0, -1e-3, 2e-3], "unbalanced_force": [0.0, 0.2, 0.02], "inertial_number": [0.0, 1e-4, 1e-3],
    "work_J": [0.0, 1.0, 2.0], "elastic_J": [0.0, 0.5, 1.0], "kinetic_J": [0.0] * 3, "friction_J": [0.0, 0.5, 1.0],
    "damping_J": [0.0] * 3, "fracture_J": [0.0] * 3, "split_J": [0.0] * 3, "strain_xx": [0.0] * 3,
    "strain_yy": [0.0] * 3, "strain_zz": [0.0, -0.1, -0.2],
    **{f"stress_{k}_Pa": [0.0, -a, -2 * a] for k, a in zip(("xx", "yy", "zz", "yz", "xz", "xy"),
                                                           (3e5, 3e5, 1e6, 0.0, 0.0, 0.0))}
}
ROWS = [{"diameter_m": d, "passing": p, "grains": g, "coordination": 4.0, "generation": 1.0, "elongation": 0.8,
         "flatness": 0.6} for d, p, g in ((1e-3, 0.2, 1), (2e-3, 1.0, 7))]
MACRO = {
    "increment": [0, 1, 2], "time_s": [0.0, 0.5, 1.0], "newton_iterations": [0, 3, 4], "residual": [0.0, 1e-3, 1e-4],
    "breakages": [0.0, 1.0, 5.0], "energy_error": [0.0, 0.01, -0.02], "worst_rve_energy_error": [0.0, 1e-3, 2e-3],
    "moved_top_z_m": [0.0, -1e-4, -2e-4], "reaction_top_z_N": [0.0, -5.0, -9.0], "p_Pa": [0.0, 1e6, 2e6],
    "q_Pa": [0.0, 1e6, 3e6], "strain_volumetric": [0.0, 0.01, 0.02], "macro_external_J": [0.0, 1.0, 2.0],
    "macro_internal_J": [0.0, 1.0, 2.0],
    **{f"mean_{what}": [0.0, -v, -2 * v] for what, v in (
        ("strain_xx", 0.0), ("strain_yy", 0.0), ("strain_zz", 0.01), ("stress_xx_Pa", 1e6), ("stress_yy_Pa", 1e6),
        ("stress_zz_Pa", 3e6))}
}


def said(ax):
    """Of axes: title, names and limits of both, their scales."""
    limits = [tuple(round(v, 9) for v in f()) for f in (ax.get_xlim, ax.get_ylim)]
    return {"title": ax.get_title(), "x": ax.get_xlabel(), "y": ax.get_ylabel(), "from": [v[0] for v in limits],
            "limits": limits, "scales": (ax.get_xscale(), ax.get_yscale()),
            "legend": [t.get_text() for t in ax.get_legend().get_texts()] if ax.get_legend() else [],
            "ticks": [axis.get_major_formatter()(20.0, 0) for axis in (ax.xaxis, ax.yaxis)],
            "whole": ["MaxNLocator" in type(axis.get_major_locator()).__name__ and
                      axis.get_major_locator()._integer for axis in (ax.xaxis, ax.yaxis)]}


def all_of(plots):
    """What each figure that plots() makes says: lists of its axes."""
    def read(draw, more):
        fig, ax = plt.subplots()
        draw(ax)
        axes = [said(a) for a in fig.axes]
        plt.close(fig)
        return axes + [more]
    return made_up.all_drawn(plots, read)


def check(found, what, **wanted):
    for key, value in wanted.items():
        need(found[key] == value, f"{what}: {key} is {found[key]}, not {value}")


def of_samples():
    run = lambda kind, **more: ("r", {**SAMPLE, **more}, {"scene": {"loading": {"kind": kind}}, "folder": "nowhere"})
    (stress, _), (void, _), (rest, _) = all_of(lambda: rve_plots.overlays([run("uniaxial-strain")]))
    strain = "axial strain (compression)"
    check(stress, "stress", x=strain, y="axial stress (MPa)", legend=["r"])
    check(void, "void", x="axial stress (MPa)", y="void ratio", scales=("log", "linear"), legend=["r"])
    need(void["ticks"][0] == "20", f"plain numbers of a logarithmic axis: {void['ticks']}")
    check(rest, "rest", x=strain, y="K0, lateral over axial stress", title="Lateral stress at rest, K0", legend=["r"])
    need(rest["limits"][1][0] == 0 and stress["limits"][0][0] < 0, f"K0 from 0: {rest['limits']}")
    (_, _), (q, _), (path, _), (phi, _), (volume, _) = all_of(lambda: rve_plots.overlays([run("constant-p")]))
    check(q, "q", x=strain, y="deviator q (MPa)", title="Deviator and strain", legend=["r"])
    check(phi, "phi", x=strain, y="mobilised friction angle (degrees)", legend=["r"])
    need(phi["limits"][1][0] == 0, f"friction from 0: {phi['limits']}")
    check(path, "path", x="mean pressure p (MPa)", y="deviator q (MPa)", legend=["r"])
    need([v[0] for v in path["limits"]] == [0, 0], f"a stress path from 0: {path['limits']}")
    check(volume, "volume", x=strain, y="volume strain (%, compression)", legend=["r"])
    (grain, _), = all_of(lambda: rve_plots.overlays([run("platens")]))
    check(grain, "grain", x=strain, y="force over the square of the height (MPa)", legend=["r"])
    two = [run("triaxial"), ("s", *run("velocity-gradient")[1:])]
    need([p[0]["legend"] for p in all_of(lambda: rve_plots.overlays(two))] == [["r", "s"]] * 5, "both of two runs")
    both = [run("platens"), run("triaxial"), run("isotropic-stress")]
    need([p[0]["title"] for p in all_of(lambda: rve_plots.overlays(both))] ==
         ["Stress and strain (compression positive)", "Single grains between platens",
          "Void ratio against the logarithm of the mean pressure", "Deviator and strain", "Stress path",
          "Mobilised friction", "Volume strain"], "plots of many kinds")
    full = ("r", {**SAMPLE, "void_ratio": [-0.1, 0.0, 0.0]}, run("triaxial")[2])
    need(len(all_of(lambda: rve_plots.overlays([full]))) == 1, "no void ratio, no volume strain")
    graded = ("r", SAMPLE, {**run("oedometric-stress")[2], "grading": {0.0: ROWS, 0.1: ROWS, 0.2: ROWS}})
    sizes = all_of(lambda: rve_plots.overlays([graded]))[-1][0]
    diameter = "equivalent diameter (mm)"
    check(sizes, "sizes", title="Gradings, first and last state (fines included)", x=diameter, y="passing by mass (%)",
          scales=("log", "linear"), legend=["r, strain 0", "r, strain 0.2"])
    need(sizes["limits"][1] == (0, 100) and sizes["ticks"][0] == "20", f"of gradings: {sizes['limits']}")
    energy, broken, states, means, trust = (p[0] for p in all_of(lambda: rve_plots.of_run(graded)))
    check(energy, "energy", x=strain, y="energy (J)", legend=["elastic", "friction", "work in"])
    check(broken, "broken", x=strain, y="number", whole=[False, True], legend=["grains", "breakages",
                                                                                "void ratio (right)"])
    check(states, "states", x=diameter, y="passing by mass (%)", scales=("log", "linear"),
          legend=["strain 0", "strain 0.1", "strain 0.2"])
    need(states["limits"][1] == (0, 100) and states["ticks"][0] == "20", f"of states: {states['limits']}")
    check(means, "means", x=diameter, y="mean of a size class", scales=("log", "linear"),
          legend=["coordination", "generation", "elongation (right)", "flatness (right)"])
    check(trust, "trust", x=strain, y="relative", scales=("linear", "log"),
          legend=["|energy error|", "unbalanced force", "inertial number"])
    need(trust["limits"][1] == (1e-4, 1.0) and trust["ticks"][1] == "20", f"decades of errors: {trust}")
    bonds = {"bonds": [9.0] * 3, "bonds_broken": [0.0, 1.0, 2.0], "fragments": [1.0, 1.0, 2.0]}
    for more, x, y in (({}, strain, "axial stress (MPa)"),
                       ({"nominal_stress_Pa": [0.0, 2e3, 1e3], "displacement_m": E}, "displacement (mm)",
                        "nominal stress (kPa)")):
        load, right, _ = all_of(lambda: rve_plots.of_run(run("rollers", **bonds, **more, breakages=[0.0] * 3)))[1]
        check(load, "load", x=x, y=y, title="r: load and damage")
        check(right, "damage", y="number", whole=[False, True])
        need(load["legend"] == ["stress", "bonds broken (right)", "fragments (right)"], f"legend of damage: {load}")
    still = ("r", {**SAMPLE, "axial_strain": [0.0] * 3}, run("free")[2])
    need(all_of(lambda: rve_plots.of_run(still))[0][0]["x"] == "time (s)", "against the time")
    with tempfile.TemporaryDirectory() as folder:
        for sizes, shown in ((4, True), (3, False)):
            with open(os.path.join(folder, "bursts.csv"), "w") as f:
                f.write("bonds\n" + "1\n" * sizes)
            for told in (True, False):
                about = {"folder": folder, **({"bursts": {}} if told else {})}
                last = all_of(lambda: rve_plots.of_run(("r", SAMPLE, about)))[-2][0]
                need((last["title"] == "r: bursts") == (shown and told), f"bursts of {sizes}, {told}: {last['title']}")
                if shown and told:
                    check(last, "bursts", x="bonds broken in a burst", y="share of bursts as large or larger",
                          scales=("log", "log"), ticks=["20", "20"])
    near_zero = [float(v) for v in (0.0, -1.0, 1.0)]
    stress = {f"stress_{k}_Pa": near_zero for k in ("xx", "yy", "zz")}
    found = rve_plots.lateral(("r", stress, {}))
    need(math.isnan(found[0]) and found[1] == 1 and math.isnan(found[2]), f"K0 where nothing presses: {found}")


def of_problems():
    shown = [p[0] for p in all_of(lambda: bvp_plots.of_run(("n", MACRO, {"folder": "nowhere"})))]
    strain = "displacement of top, z (mm)"
    names = [("displacement of the boundary (mm)", "reaction, along the displacement (N)"), (strain, "stress (MPa)"),
             ("mean pressure p (MPa)", "deviator q (MPa)"), (strain, "volume strain (%, compression)"),
             (strain, "number, all RVEs"), (strain, "energy (J)"), ("increment", "Newton iterations"),
             (strain, "relative")]
    need([(a["x"], a["y"]) for a in shown] == names, f"axes of a macro problem: {[(a['x'], a['y']) for a in shown]}")
    need([a["legend"] for a in shown] == [
        ["top, z"], ["stress xx", "stress yy", "stress zz"], [], [], ["breakages"], ["external", "internal"],
        ["Newton iterations", "residual (right)"], ["energy error", "worst rve energy error"]
    ], f"legends: {[a['legend'] for a in shown]}")
    need(shown[4]["whole"] == [False, True] and shown[6]["whole"] == [True, True], "whole numbers")
    need(shown[7]["scales"] == ("linear", "log") and shown[7]["limits"][1] == (1e-3, 0.1), f"trust: {shown[7]}")
    right = all_of(lambda: bvp_plots.of_run(("n", MACRO, {"folder": "nowhere"})))[6][1]
    need(right["y"] == "relative residual" and right["scales"][1] == "log" and right["limits"][1] == (1e-4, 0.01),
         f"residuals: {right}")
    own = {**MACRO, **{f"grains_stress_{k}_Pa": E for k in ("xx", "yy", "zz")}}
    need("stress, of the grains" in all_of(lambda: bvp_plots.of_run(("n", own, {"folder": "nowhere"})))[1][0]["title"],
         "whose stress it is")
    one = {k: v[:1] for k, v in MACRO.items()}
    titles = [p[0]["title"] for p in all_of(lambda: bvp_plots.of_run(("n", one, {"folder": "nowhere"})))]
    need(titles == ["n: stress, mean (compression positive)", "n: macro energy, largest error 0.00 %",
                    "n: convergence", "n: how far to trust it"], f"of one row: {titles}")
    moving = {**MACRO, "macro_kinetic_J": E, "probe_a_strain_zz": E, "bonds_broken": [0, 0, 0]}
    shown = [p[0] for p in all_of(lambda: bvp_plots.of_run(("n", moving, {"folder": "nowhere"})))]
    need([a["x"] for a in shown[1:]] == ["time (µs)"] * 5 and shown[4]["y"] == "strain zz (µm/m, compression)"
         and shown[4]["legend"] == ["a"], f"of dynamics: {[(a['x'], a['y']) for a in shown]}")
    aside = {**{k: v for k, v in moving.items() if not k.startswith("probe")}, "probe_a_strain_xx": E}
    titles = [p[0]["title"] for p in all_of(lambda: bvp_plots.of_run(("n", aside, {"folder": "nowhere"})))]
    need(not any("probes" in t for t in titles), f"probes that say nothing along the load: {titles}")
    need(shown[2]["legend"] == ["breakages"], f"what has not broken: {shown[2]['legend']}")
    # A boundary that hardly moves one way and goes far the other: its way is that of the largest.
    back = {"moved_top_z_m": [0.0, 1e-5, -2e-4], "reaction_top_z_N": [0.0, -5.0, -9.0]}
    need([p[0] for p in bvp_plots.pushed(back)] == ["top"], "the way of the largest displacement")
    need(bvp_plots.pushed({"moved_a_x_m": [0.0], "reaction_a_x_N": [1.0]}) == [], "what does not move does not push")
    need(bvp_plots.pushed({"moved_a_x_m": [1e-9], "reaction_a_x_N": [-1.0]}) == [], "what is pulled along")
    need(not bvp_plots.dynamic({"load_rate": []}), "a load that rests")


def of_figures():
    need(plt.rcParams["text.parse_math"] is False, "names are read as formulas")
    text = figures.figure(lambda ax: ax.plot([0, 1], [1, 2], label="a <$x$>"))
    need(plt.get_fignums() == [], "a figure stays open")
    picture = base64.b64decode(re.search(r"base64,([^\"]+)", text)[1]).decode()
    need("a &lt;$x$&gt; from 1 to 2" in text and picture.rstrip().endswith("</svg>"), f"a figure: {text[:200]}")
    need("<dc:date>" not in picture and picture == base64.b64decode(re.search(
        r"base64,([^\"]+)", figures.figure(lambda ax: ax.plot([0, 1], [1, 2], label="a <$x$>")))[1]).decode(),
        "the same figure is another file")
    size = [float(v) for v in re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', picture).groups()]
    need(1.3 < size[0] / size[1] < 2.1 and 380 < size[0] < 620, f"the size of a figure: {size}")
    high = base64.b64decode(re.search(r"base64,([^\"]+)", figures.figure(lambda ax: None, height=6.0))[1]).decode()
    need(float(re.search(r'height="([\d.]+)pt"', high)[1]) > 1.2 * size[1], "a height that is asked for")
    sizes = []
    figures.figure(lambda ax: sizes.append(tuple(ax.figure.get_size_inches())) or ax.set_axis_off())
    need(sizes == [(7.4, 4.2)], f"inches: {sizes}")
    grids = []
    for off in (False, True):
        fig_of = lambda ax: (grids.append(ax), off and ax.set_axis_off())
        figures.figure(fig_of)
    lines = [any(line.get_visible() for line in ax.get_xgridlines()) for ax in grids]
    need(lines == [True, False], f"a grid behind curves, not behind pictures: {lines}")
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(2):
            fig, ax = plt.subplots()
            ax.set(title='T "q"', xlabel="x")
            told = figures.picture(fig, folder, "one")
        with open(os.path.join(folder, "plots", "one.png"), "rb") as f:
            kept = f.read()
        need(base64.b64decode(re.search(r"base64,([^\"]+)", told)[1]) == kept and kept[:4] == b"\x89PNG"
             and 'alt="T &quot;q&quot;; values against x"' in told and plt.get_fignums() == [], f"{told[:120]}")
    fig, ax = plt.subplots()
    ax.semilogx([1, 9], [0, 1])
    figures.plain(ax.xaxis)
    minor = ax.xaxis.get_minor_formatter()
    need([minor(v, 0) for v in (1, 2, 5, 7)] == ["", "2", "5", ""], "2 and 5 between powers of ten")
    ax.set_xlim(1, 111)
    need(minor(2, 0) == "", "over many decades: powers alone")
    ax.set_xlim(1, 109)
    need(minor(20, 0) == "20", "room for them")
    ax.cla()
    figures.logarithmic(ax, {"log": True})
    need((ax.get_xscale(), ax.get_yscale()) == ("linear", "log") and ax.yaxis.get_major_formatter()(0.5, 0) == "0.5",
         "the other axis")
    ax.cla()
    figures.decades(ax, [[0.0, -1.0, math.nan]])
    need(ax.get_yscale() == "linear", "nothing that a logarithm has")
    figures.decades(ax, [[1e-3, 1.0]])
    need(ax.get_ylim() == (1e-3, 10.0) and ax.yaxis.get_major_formatter()(0.01, 0) == "0.01", f"{ax.get_ylim()}")
    figures.legend(ax)
    need(ax.get_legend() is None, "a legend of nothing")
    for k in range(6):
        ax.plot([0, 1], [k, 2 * k + 0.12345], label=f"c{k}")
    ax.plot([0], [7], label="point")
    ax.plot([0, 1], [7, 8], label="c0")
    figures.legend(ax)
    need(ax.get_legend()._bbox_to_anchor.x0 > ax.bbox.x1, "a legend that covers curves")
    at = ax.get_legend()._bbox_to_anchor.x0
    figures.legend(ax, ax.twinx())
    need(ax.get_legend()._bbox_to_anchor.x0 > at, "a legend that covers the axis to the right")
    need(figures.alt_text([ax]) == "figure; curves: c0, c1, c2, c3, c4, c5, point; c0 from 0 to 0.1235; "
         "c1 from 1 to 2.123; c2 from 2 to 4.123; c3 from 3 to 6.123", f"{figures.alt_text([ax])}")
    ax.set_axis_off(), ax.set_xlabel("x")
    need("against" not in figures.alt_text([ax]), "axes that are off are told of")
    plt.close("all")
    text = figures.page("t", "BODY", style="STYLE", script="SCRIPT")
    need(text.startswith("<!doctype html>") and [text.index(s) for s in ("STYLE", "BODY", "SCRIPT", "</html>")] ==
         sorted(text.index(s) for s in ("STYLE", "BODY", "SCRIPT", "</html>")), "a page")


def write(folder, columns, summary, **more):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "history.csv"), "w") as f:
        f.write(",".join(columns) + "\n" + "".join(
            ",".join(repr(float(v[k])) for v in columns.values()) + "\n" for k in range(3)))
    for name, text in {"summary.json": None if summary is None else json.dumps(summary), **more}.items():
        if text is not None:
            with open(os.path.join(folder, name), "w") as f:
                f.write(text)
    return folder


def of_pages(tmp):
    made_up.unpainted()
    good = write(os.path.join(tmp, "good"), SAMPLE, {"title": "A <title>", "notes": "no list"})
    call = lambda *arguments: made_up.command(command.main, *arguments)
    status, said_, errors = call(good)
    page = os.path.join(good, "report.html")
    need((status, errors) == (0, "") and said_.endswith(f"report: {page}\n") and "0.200 strain" in said_, said_)
    with open(page) as f:
        text = f.read()
    need("Notes" not in text and "good: A &lt;title&gt;" in text and "grading" not in text and "folder" not in text
         and figures.ZOOM in text and "<title>Grus report</title>" in text, "a report without notes")
    need(text.count("<h2>") == 3, f"{text.count('<h2>')} sections")
    running = write(os.path.join(tmp, "running"), SAMPLE, None)
    need("it runs still" in call(running)[1], "a run without a summary")
    # What cannot be read, and where the page cannot be: one line each, exit 2, nothing written.
    lacks = {k: v for k, v in SAMPLE.items() if k != "void_ratio"}
    macro = {k: v for k, v in MACRO.items() if k != "mean_strain_xx"}
    os.makedirs(os.path.join(tmp, "study", "runs"))
    for name, arguments, words in (
            ("lacks", [write(os.path.join(tmp, "lacks"), lacks, {})], "no column void_ratio"),
            ("macro", [write(os.path.join(tmp, "macro"), macro, {})], "no column mean_strain_xx"),
            ("counts", [write(os.path.join(tmp, "counts"), SAMPLE, {"counts": []})], "not a summary of Grus"),
            ("seconds", [write(os.path.join(tmp, "seconds"), SAMPLE, {"seconds": 1})], "not a summary of Grus"),
            ("graded", [write(os.path.join(tmp, "graded"), SAMPLE, {}, **{"grading.csv": "strain\nx\n"})],
             "not a grading of Grus"),
            ("study", [os.path.join(tmp, "study")], "which has its own report.html"),
            ("none", [tmp], "name a results folder of grus-rve or grus-bvp"),
            ("folder", [good, "-o", tmp], "cannot write: is a folder"),
            ("nowhere", [good, "-o", os.path.join(tmp, "no", "page.html")], "cannot write: No such file")):
        status, said_, errors = call(*arguments)
        need(status == 2 and words in errors and errors.count("\n") == 1 and errors.startswith("grus-report: "),
             f"{name}: exit {status}, {errors}")
        need(("study" in errors) == (name == "study"), f"{name}: {errors}")
        need(not os.path.exists(os.path.join(arguments[0], "report.html")) or arguments[0] == good, f"{name}: a page")
    # A report takes the place of a report alone, --force of what no run has written.
    scene, text = os.path.join(tmp, "scene.toml"), "a scene"
    for target in (scene, os.path.join(good, "report.html")):
        with open(target, "w") as f:
            f.write(text)
        status, _, errors = call(good, "-o", target)
        need(status == 2 and "is there already; use another -o FILE, or --force" in errors
             and open(target).read() == text, f"over {target}: {errors}")
    need(call(good)[0] == 2 and call(good, "--force")[0] == 0 and call(good)[0] == 0, "a report in its folder, again")
    need(call(good, "-o", scene, "--force")[0] == 0 and "<h1>Grus report" in open(scene).read(), "--force")
    history = os.path.join(good, "history.csv")
    status, _, errors = call(good, "-o", history, "--force")
    need(status == 2 and "is a file of a run" in errors and open(history).read().startswith("axial_strain"),
         f"over a history: {errors}")
    need(call(write(os.path.join(tmp, "mixed"), MACRO, {}, **{"grading.csv": "x"}))[0] == 0, "no grading")
    broken, before = rve_plots.overlays, os.environ.pop("GRUS_DEBUG", None)
    rve_plots.overlays = lambda runs: 1 / 0
    status, _, errors = call(good)
    need(status == 1 and "ZeroDivisionError" in errors and errors.count("\n") == 1, f"a fault of its own: {errors}")
    os.environ["GRUS_DEBUG"] = "1"
    try:
        call(good)
        need(False, "the whole story is not told")
    except ZeroDivisionError:
        del os.environ["GRUS_DEBUG"]
    rve_plots.overlays = broken
    if before:
        os.environ["GRUS_DEBUG"] = before
    need(command.section("a<", []) == "" and command.section("a<", ["P", "Q"]) ==
         '<h2>a&lt;</h2><div class="plots">PQ</div>', "a section")
    need(command.notes_of([("n", {}, {"notes": ["a", 1]}), ("m", {}, {})]) ==
         "<h2>Notes</h2><ul><li>n: a</li><li>n: 1</li></ul>", "notes")
    sheared = {"scene": {"loading": {"kind": "constant-p"}}}
    facts = command.facts(("n", {**SAMPLE, "q_Pa": [0.0, 7e6, 1e6]}, sheared))
    need((facts["stress"], facts["largest q"], facts["ending"], facts["wall"], facts["steps"]) ==
         ("2 MPa", "7 MPa", "", "nan s", "nan"), f"{facts}")
    facts = command.facts(("n", {**MACRO, **{k: MACRO[k][:1] for k in ("energy_error",)}}, {}))
    need(facts["energy error"] == "0.00 %", f"an error of the first row alone: {facts}")


of_samples()
of_problems()
of_figures()
with tempfile.TemporaryDirectory() as place:
    of_pages(place)
print(f"report_pages: {len(faults)} faults")
sys.exit(bool(faults))
