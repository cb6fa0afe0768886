#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What grus-report draws and tells of results, number by number, by hand: report_numbers.py BIN"""
import json
import math
import os
import sys
import tempfile

import numpy as np
from matplotlib.transforms import Bbox

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus import figures  # noqa: E402
from grus.figures import plt  # noqa: E402
from grus.report import bvp_plots, command, rve_plots  # noqa: E402

import made_up  # noqa: E402
from made_up import drawn  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def near(found, wanted, what, tolerance=1e-12, floor=1e-12):
    made_up.near(found, wanted, what, tolerance, floor)


def drawn_of(plots):
    """The same of what makes several figures, in their order: figure(draw) is what they end in."""
    return made_up.all_drawn(plots, lambda draw, _: drawn(draw))


def sample():
    """Columns of a grus-rve run: a stretch along z, with made-up energies."""
    e = np.array([0.0, 0.1, 0.2])
    c = {"axial_strain": e, "time_s": 2 * e, "strain_xx": 0.5 * e, "strain_yy": 0.25 * e, "strain_zz": -e,
         "axial_stress_Pa": 1e7 * e, "mean_pressure_Pa": 5e6 * e, "void_ratio": 0.7 - e, "grains": 10 + 20 * e,
         "breakages": 20 * e, "energy_error": -0.1 * e, "unbalanced_force": 0.01 + e, "inertial_number": 0 * e,
         "work_J": 10 * e, "elastic_J": 6 * e, "kinetic_J": 0 * e, "friction_J": 3 * e, "damping_J": -e,
         "fracture_J": 2 * e, "bond_J": 5 * e, "split_J": e}
    stress = {"xx": -2.0, "yy": -4.0, "zz": -9.0, "yz": 1.0, "xz": -2.0, "xy": 3.0}
    return {k: list(v) for k, v in {**c, **{f"stress_{k}_Pa": 1e6 * v * e for k, v in stress.items()}}.items()}, stress


def staged(c, titles, of_an_oedometer, of_all_sides):
    """What a test in stages is told by its strains and columns; where it goes back, sums are drawn over the time."""
    e = np.array(c["axial_strain"])
    of = lambda *kinds, **more: ("r", {**c, **more}, {"scene": {"stage": [{"kind": k} for k in kinds]}})
    still = {"strain_xx": 0 * e, "strain_yy": 1e-8 * e}
    need(titles([of("compress", "unload", **still)]) == of_an_oedometer, "an oedometer in stages")
    need(titles([of("compress", **{**still, "strain_yy": 1e-5 * e})]) == of_all_sides, "a side that gives way")
    q = {"q_Pa": [0.0, 1e6, 3e6]}
    need("Stress path" in titles([of("compress", "shear", **q)]), "a test in stages that shears")
    need("Stress path" not in titles([of("compress", **still, **q)]), "an oedometer has a q, and is not sheared")
    along_x = ("r", {**c, "strain_zz": 0 * e, "strain_yy": 0 * e},
               {"scene": {"stage": [{"axis": "all"}, {"axis": "x"}]}})
    need(rve_plots.axis_of(along_x) == "x" and rve_plots.oedometric(along_x), "along x")
    need(not rve_plots.oedometric(of("compress", **still, axial_strain=0 * e)), "nothing is strained")
    back = lambda x: rve_plots.onward(("r", {**c, "axial_strain": x}, {}))[1]
    need([back(x) for x in ([0, 0.1, 0.2], [0, 0.2, 0.1], [0, -0.1, -0.2], [0, 0.2, 0.197])] ==
         ["axial strain (compression)", "time (s)", "axial strain (compression)", "axial strain (compression)"],
         "where the strain goes back by more than a fiftieth: the time")
    told = command.facts(("n", {**c, **q}, {"scene": {"stage": [{"kind": "shear"}]}}))
    need((told["stress"], told["largest q"]) == ("2 MPa", "3 MPa"), f"stress and q: {told}")
    need("largest q" not in command.facts(of("compress", **still, **q)), "q of an oedometer")
    known = {"scene": {"preparation": {"void_ratio_min": 0.5, "void_ratio_max": 0.9}}}
    need(command.start_of(("n", c, known))["Dr at start"] == "50 %", "limits told by the preparation")
    need([rve_plots.told(v) for v in (1.1e-16, 0.0, 0.25)] == ["0", "0", "0.25"], "round-off of a start")


def samples():
    c, stress = sample()
    e = np.array(c["axial_strain"])
    summary = {"scene": {"loading": {"kind": "triaxial", "axis": "z"}}, "folder": "nowhere"}
    run = ("name", c, summary)
    tensor = np.array([[-2, 3, -2], [3, -4, 1], [-2, 1, -9.0]]) * 1e6
    deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
    near(rve_plots.deviator(c), np.sqrt(1.5 * (deviator**2).sum()) * e, "deviator")
    near(rve_plots.volume(c), [1 - np.linalg.det(np.diag([1 + 0.5 * x, 1 + 0.25 * x, 1 - x])) for x in e], "volume")
    near(rve_plots.lateral(run), [math.nan, 3 / 9, 3 / 9], "lateral over axial stress")
    near(rve_plots.lateral(("n", c, {"scene": {"loading": {"axis": "x"}}})), [math.nan, 6.5 / 2, 6.5 / 2], "along x")
    near(rve_plots.along(run)[0], e, "against the strain")
    still = ("still", {**c, "axial_strain": [0.0] * 3}, summary)
    need(rve_plots.along(still) == (c["time_s"], "time (s)"), "without a strain against the time")
    need(rve_plots.stacked(c) == ["elastic_J", "friction_J", "fracture_J", "split_J"], f"{rve_plots.stacked(c)}")
    fig, ax = plt.subplots()
    rve_plots.energy(ax, run)
    tops = [area.get_paths()[0].vertices[:, 1].max() for area in ax.collections]
    near(tops, [1.2, 1.8, 2.2, 2.4], "the stack of energies")
    near(ax.get_lines()[0].get_ydata(), c["work_J"], "work in")
    plt.close(fig)
    curves, texts, _ = drawn(rve_plots.trust, run)
    need(set(curves) == {"|energy error|", "unbalanced force"}, f"what is 0 is drawn: {set(curves)}")
    near(curves["|energy error|"][1], [0.01, 0.02], "energy error, from the second row")
    curves, texts, _ = drawn(rve_plots.breakage, run)
    near([curves[k][1] for k in ("grains", "breakages", "void ratio (right)")],
         [c["grains"], c["breakages"], c["void_ratio"]], "breakage")
    grain = ("n", c, {"scene": {"loading": {"kind": "platens"}}})
    need("void ratio (right)" not in drawn(rve_plots.breakage, grain)[0], "a void ratio of one grain")
    bonded = {**c, "bonds": [5.0] * 3, "bonds_broken": [0.0, 1.0, 4.0], "fragments": [1.0, 1.0, 3.0]}
    curves, texts, _ = drawn(rve_plots.damage, ("n", bonded, summary))
    near([curves["stress"][1], curves["bonds broken (right)"][1], curves["fragments (right)"][1]],
         [10 * e, bonded["bonds_broken"], bonded["fragments"]], "damage")
    disc = {**bonded, "nominal_stress_Pa": [0.0, 3e6, 1e6], "displacement_m": [0.0, 1e-3, 2e-3]}
    curves, texts, _ = drawn(rve_plots.damage, ("n", disc, summary))
    near(curves["stress"], [[0, 1, 2], [0, 3, 1]], "a load over a way")
    curves, _, _ = drawn(rve_plots.bursts, "n", [3.0, 1.0, 2.0, 2.0])
    near(list(curves.values())[0], [[1, 2, 2, 3], [1, 0.75, 0.5, 0.25]], "bursts at least as large")
    rows = lambda p: [{"diameter_m": d, "passing": x, "grains": g, "coordination": 4.0, "generation": 1.0,
                       "elongation": 0.8, "flatness": 0.6} for d, x, g in zip((1e-3, 2e-3), (p, 1.0), (0, 7))]
    states = {0.0: rows(0.1), 0.1: rows(0.2), 0.2: rows(0.3)}
    curves, _, _ = drawn(rve_plots.gradings, [("n", c, {"grading": states})])
    need({k: v[1].tolist() if hasattr(v[1], "tolist") else list(v[1]) for k, v in curves.items()} ==
         {"n, strain 0": [10, 100], "n, strain 0.2": [30, 100]}, f"gradings, first and last: {curves}")
    curves, _, _ = drawn(rve_plots.grading_states, "n", states)
    near([v for v in curves.values()], [[[1, 2], [100 * p, 100]] for p in (0.1, 0.2, 0.3)], "all gradings", floor=1e-9)
    curves, _, _ = drawn(rve_plots.by_size, "n", states)
    need({k: (list(x), list(y)) for k, (x, y) in curves.items()} ==
         {"coordination": ([2], [4]), "generation": ([2], [1]), "elongation (right)": ([2], [0.8]),
          "flatness (right)": ([2], [0.6])}, f"means by size: {curves}")
    titles = lambda runs: [texts[0] for _, texts, _ in drawn_of(lambda: rve_plots.overlays(runs))]
    of = lambda kind, **more: ("r", {**c, **more}, {"scene": {"loading": {"kind": kind}}})
    void, rest = "Void ratio against the logarithm of the ", "Lateral stress at rest, K0"
    strain = "Stress and strain (compression positive)"
    for runs, wanted in (([of("triaxial")], [strain, "Deviator and strain", "Stress path", "Mobilised friction",
                                                  "Volume strain"]),
                         ([of("uniaxial-strain")], [strain, void + "axial stress", rest]),
                         ([of("isotropic-stress")], [strain, void + "mean pressure"]),
                         ([of("rollers")], [strain]), ([still], []),
                         ([of("platens")], ["Single grains between platens"]),
                         ([of("platens", bonds=[1])], [strain])):
        need(titles(runs) == wanted, f"plots of {runs[0][2]}: {titles(runs)}")
    sheared = drawn_of(lambda: rve_plots.overlays([of("triaxial")]))
    near(sheared[0][0]["r"], [e, 10 * e], "stress and strain")
    near(sheared[1][0]["r"], [e, np.array(rve_plots.deviator(c)) / 1e6], "deviator over the strain")
    near(sheared[2][0]["r"], [5 * e, np.array(rve_plots.deviator(c)) / 1e6], "stress path")
    near(sheared[4][0]["r"], [e, 100 * np.array(rve_plots.volume(c))], "volume strain")
    # Principal stresses of 1 and 3 and a turn of 30 degrees about y: sin phi = 2 / 4, whatever the turn.
    turn = np.array([[3**0.5 / 2, 0, 0.5], [0, 1, 0], [-0.5, 0, 3**0.5 / 2]])
    turned = -1e5 * turn @ np.diag([1.0, 2.0, 3.0]) @ turn.T
    at = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "yz": (1, 2), "xz": (0, 2), "xy": (0, 1)}
    pressed = {f"stress_{k}_Pa": [0.0, turned[ij], -turned[ij], 1e-3 * turned[ij]] for k, ij in at.items()}
    near(rve_plots.mobilised(pressed), [math.nan, 30, math.nan, math.nan], "friction that is mobilised", 1e-9)
    near(sheared[3][0]["r"], [e, rve_plots.mobilised(c)], "friction over the strain")
    # Runs of 42, 1, 0.2 and 300 MPa: what would be flat beside the others has axes of its own, with its unit.
    scaled = [("r%g" % m, {**c, "axial_stress_Pa": [0.0, m * 1e6, 0.5e6 * m]}, summary) for m in (42, 1, 0.2, 300)]
    shown = drawn_of(lambda: rve_plots.stress_plots("T", scaled, False))
    need([(list(curves), texts[2]) for curves, texts, _ in shown] == [
        (["r42", "r300"], "axial stress (MPa)"), (["r1", "r0.2"], "axial stress (MPa)")], f"by scale: {shown}")
    near(shown[1][0]["r0.2"][1], [0, 0.2, 0.1], "the smallest")
    near([u for u, _ in map(figures.unit_of, ([0.0], [5e8, math.nan], [999.0, -2e3], [2e9], [3.0], [0.5]))],
         [1e6, 1e6, 1e3, 1e9, 1, 1], "units")
    need(figures.by_scale([8.0, 1.0, 64.1], abs) == [[8.0, 1.0], [64.1]] and
         figures.by_scale([1.0, 7.0, 49.0], abs) == [[1.0], [7.0, 49.0]], "just within a factor of eight")
    pressed = drawn_of(lambda: rve_plots.overlays([of("uniaxial-strain")]))
    near(pressed[1][0]["r"], [10 * e[1:], (0.7 - e)[1:]], "void ratio where there is a stress")
    near(pressed[2][0]["r"], [e, [math.nan, 1 / 3, 1 / 3]], "stress at rest")
    pressed = drawn_of(lambda: rve_plots.overlays([of("uniaxial-strain", mean_pressure_Pa=[1.0, 5e3, 1e6],
                                                      axial_stress_Pa=[1.0, 5e3, 2e6])]))
    near(pressed[1][0]["r"], [[0.005, 2], [0.6, 0.5]], "void ratio above 1e-4 of the largest stress", 1e-9)
    near(pressed[2][0]["r"][1], [math.nan, math.nan, 1 / 3], "stress at rest above a hundredth of it")
    pressed = drawn_of(lambda: rve_plots.overlays([of("isotropic-stress")]))
    near(pressed[1][0]["r"], [5 * e[1:], (0.7 - e)[1:]], "of all sides over the mean pressure")
    staged(c, titles, [strain, void + "axial stress", rest], [strain, void + "mean pressure"])
    graded = ("n", c, {**summary, "grading": {0.1: rows(0.2)}})
    shown = [texts[0] for _, texts, _ in drawn_of(lambda: rve_plots.of_run(graded))]
    need(shown == ["n: where the work went", "n: breakage", "n: grading, fines included",
                   "n: means by size, last state", "n: how far to trust it"], f"plots of a run: {shown}")
    shown = [texts[0] for _, texts, _ in drawn_of(lambda: rve_plots.of_run(("n", {**bonded, "breakages": [0] * 3},
                                                                            summary)))]
    need(shown == ["n: where the work went", "n: load and damage", "n: how far to trust it"], f"of bonds: {shown}")


def problem(**more):
    """Columns of a grus-bvp run: pushed by the top, against a side that gives way."""
    e = np.array([0.0, 0.01, 0.03])
    c = {"increment": [0, 1, 2], "time_s": e, "newton_iterations": [0, 3, 4], "residual": [0.0, 1e-4, -1e-3],
         "breakages": [0.0, 0.0, 5.0], "energy_error": [9.0, 0.01, -0.02], "worst_rve_energy_error": [0.0, 1e-3, 2e-3],
         "moved_top_z_m": -1e-3 * e, "reaction_top_z_N": [-1.0, -500.0, -900.0], "moved_side_x_m": 1e-4 * e,
         "reaction_side_x_N": -300 * e, "moved_small_y_m": 1e-4 * e, "reaction_small_y_N": 1e2 * e,
         "moved_fixed_x_m": 0 * e, "reaction_fixed_x_N": 1e3 + e}
    for k, strain, stress in (("xx", 0.02, -1e6), ("yy", 0.0, -2e6), ("zz", -0.01, -5e6)):
        c |= {f"mean_strain_{k}": strain * e / 0.03, f"mean_stress_{k}_Pa": stress * e / 0.03}
    return {k: list(v) for k, v in (c | more).items()}


def problems():
    c = problem()
    need(bvp_plots.loaded_axis(c, {}) == "zz", "the axis whose stress changes most")
    need(bvp_plots.along(c, {})[1] == "displacement of top, z (mm)", "against the way of what pushes")
    near(bvp_plots.along(c, {})[0], [0, 0.01, 0.03], "its way, millimetres")
    moved = {"scene": {"boundary": [{"name": "small", "displacement": ["free", 2e-3, 0.0]}, {"name": "side"},
                                    {"name": "top", "displacement": ["free", "free", 0.0]}]}}
    need(bvp_plots.along(c, moved)[1] == "displacement of small, y (mm)" and bvp_plots.loaded_axis(c, moved) == "yy",
         "what the scene moves goes before what pushes most")
    moved["scene"]["boundary"][2]["displacement"][2] = -1e-3
    need(bvp_plots.driven(c, moved["scene"])[:2] == ("top", "z"), "of two the one that goes farthest")
    calm = {k: v for k, v in c.items() if not k.startswith("moved_")}
    need(bvp_plots.along(calm, {})[1] == "mean strain zz (compression)", "where nothing pushes")
    near(bvp_plots.along(calm, {})[0], [0, 0.01 / 3, 0.01], "the mean strain along it")
    dynamic = problem(macro_kinetic_J=[0, 1, 2])
    near(bvp_plots.along(dynamic, {})[0], [0, 1e4, 3e4], "microseconds")
    need(bvp_plots.dynamic(dynamic) and not bvp_plots.dynamic(problem(macro_kinetic_J=[0], load_rate=[0])), "dynamics")
    found = bvp_plots.pushed(c)
    need([p[:2] for p in found] == [("top", "z")], f"what pushes: {[p[:2] for p in found]}")
    near(found[0][2:], [c["moved_top_z_m"], c["reaction_top_z_N"]], "its way and its force")
    for name, force, wanted in (("small", 50.0, ["top", "small"]), ("small", 40.0, ["top"]), ("side", 8e3, ["top"]),
                                ("top", 500.0, ["top"])):
        way = {"small": "y", "side": "x", "top": "z"}[name]  # a twentieth of the largest; against its way; too late
        force = [0.0, -force, 0.0] if name == "side" else [force, 0.0, -900.0] if name == "top" else [0.0, 0.0, force]
        shown = bvp_plots.pushed(problem(**{f"reaction_{name}_{way}_N": force}))
        need([p[0] for p in shown] == wanted, f"{name} pushes by {force}: {[p[0] for p in shown]}")
    both = bvp_plots.pushed(problem(reaction_small_y_N=[0.0, 100.0, 2000.0]))
    need([p[0] for p in both] == ["small", "top"], f"the strongest first: {both}")
    need(bvp_plots.pushed({}) == [], "nothing pushes")
    curves, texts, _ = drawn(bvp_plots.reaction, "n", found)
    near(curves["top, z"], [[0, 0.01, 0.03], [1, 500, 900]], "reaction along the way")
    curves, texts, _ = drawn(bvp_plots.stress, "n", c, {})
    near(curves["stress zz"], [bvp_plots.along(c, {})[0], [0, 5 / 3, 5]], "stress")
    own = problem(**{f"grains_stress_{k}_Pa": [0.0, -1e6, -7e6] for k in ("xx", "yy", "zz")})
    near(drawn(bvp_plots.stress, "n", own, {})[0]["stress xx"][1], [0, 1, 7], "stress of the grains")
    curves, texts, _ = drawn(bvp_plots.energies, "n", {**dynamic, "macro_external_J": [0, 3, 5]}, {})
    near([curves["external"][1], curves["kinetic"][1]], [[0, 3, 5], [0, 1, 2]], "macro energies")
    need("largest error 2.00 %" in texts[0], f"energies: {texts[0]}")
    probe = {**dynamic, "probe_a_strain_zz": [0.0, -1e-6, -4e-6], "probe_a_strain_xx": [0.0, 1.0, 1.0]}
    curves, texts, _ = drawn(bvp_plots.gauges, "n", probe, {})
    need(set(curves) == {"a"} and list(curves["a"][1]) == [0, 1, 4], f"gauges: {curves}")
    fig, ax = plt.subplots()
    bvp_plots.convergence(ax, "n", c)
    need([p.get_height() for p in ax.patches] == [0, 3, 4], "Newton iterations")
    near(fig.axes[1].get_lines()[0].get_ydata(), [math.nan, 1e-4, 1e-3], "residuals")
    plt.close(fig)
    curves, _, _ = drawn(bvp_plots.balance, "n", c, {})
    near([curves["energy error"], curves["worst rve energy error"]],
         [[bvp_plots.along(c, {})[0][1:], v] for v in ([0.01, 0.02], [1e-3, 2e-3])], "trust, from the second row")
    more = problem(p_Pa=[0.0, 1e6, 3e6], q_Pa=[0.0, 2e6, 5e6], strain_volumetric=[0.0, 0.01, 0.02])
    shown = drawn_of(lambda: bvp_plots.of_run(("n", more, {"folder": "nowhere"})))
    titles = [texts[0] for _, texts, _ in shown]
    need(titles == ["n: reaction and displacement", "n: stress, mean (compression positive)",
                    "n: stress path of the means", "n: volume strain", "n: breakage", "n: convergence",
                    "n: how far to trust it"], f"plots of a macro problem: {titles}")
    near([list(shown[2][0].values())[0], list(shown[3][0].values())[0]],
         [[[0, 1, 3], [0, 2, 5]], [bvp_plots.along(c, {})[0], [0, 1, 2]]], "stress path, volume strain")
    near(shown[4][0]["breakages"][1], [0, 0, 5], "breakages")
    calm = {**c, "breakages": [0.0] * 3}
    shown = [texts[0] for _, texts, _ in drawn_of(lambda: bvp_plots.of_run(("n", calm, {"folder": "nowhere"})))]
    need(not any("breakage" in s or "stress path" in s for s in shown), f"where nothing breaks: {shown}")
    moving = {**probe, "macro_external_J": [0, 3, 5], "breakages": [0.0] * 3, "bonds_broken": [0, 1, 2],
              "p_Pa": more["p_Pa"], "q_Pa": more["q_Pa"]}
    shown = drawn_of(lambda: bvp_plots.of_run(("n", moving, {"folder": "nowhere"})))
    need([texts[0].split(": ")[1].split(",")[0] for _, texts, _ in shown] ==
         ["reaction and displacement", "stress", "breakage", "macro energy", "probes", "how far to trust it"],
         f"plots of a dynamic problem: {[texts[0] for _, texts, _ in shown]}")
    need(list(shown[2][0]) == ["bonds broken"], f"breakage of bonds alone: {list(shown[2][0])}")


def tables(folder):
    """What the table tells of a run, and which folders are none."""
    c, _ = sample()
    summary = {"ending": "finished", "counts": {"steps": 12345}, "seconds": {"loading_wall": 2.34}}
    told = command.facts(("n", c, summary))
    need(told == {"run": "n", "ending": "finished", "load": "0.200 strain", "stress": "2 MPa", "broken": "4 grains",
                  "energy error": "2.00 %", "wall": "2.3 s", "steps": "1.23e+04", "e at start": "0.7000"}, f"{told}")
    known = {"sample": {"void_ratio": 0.65}, "scene": {"packing": {"void_ratio_min": 0.5, "void_ratio_max": 0.9}}}
    need(command.start_of(("n", c, known)) == {"e at start": "0.6500", "Dr at start": "62 %"}, "relative density")
    need(command.start_of(("n", c, {"scene": {"loading": {"kind": "platens"}}})) == {} ==
         command.start_of(("n", problem(), {})), "what is no sample")
    told = command.facts(("n", {**c, "nominal_stress_Pa": [0, 3e6, 1e6]}, summary))
    need(told["stress"] == "3 MPa", "nominal stress")
    told = command.facts(("n", problem(), {"counts": {"dem_steps": 7}, "seconds": {"solve_wall": 1.0}}))
    need((told["load"], told["stress"], told["energy error"], told["wall"], told["steps"]) ==
         ("0.010 strain", "5 MPa", "2.00 %", "1.0 s", "7"), f"{told}")
    of = lambda **more: command.broken({"breakages": [0.0, 3.0], **more})
    need([of(), of(bonds=[9], bonds_broken=[0, 4]), of(breakages=[0.0], bonds=[9], bonds_broken=[0, 4]),
          of(breakages=[0.0]), of(breakages=[0.0], bonds=[9], bonds_broken=[0]), of(bonds_broken=[2])] ==
         ["3 grains", "3 grains, 4 bonds", "4 bonds", "0 grains", "0 bonds", "3 grains, 2 bonds"], "what has broken")
    for columns, kind in ((c, "rve"), (problem(), "bvp")):
        place = os.path.join(folder, kind)
        os.makedirs(place)
        names = list({**dict.fromkeys(command.RVE_COLUMNS if kind == "rve" else command.BVP_COLUMNS), **columns})
        with open(os.path.join(place, "history.csv"), "w") as f:
            f.write(",".join(names) + "\n" + "".join(
                ",".join(str(columns.get(n, [0] * 3)[k]) for n in names) + "\n" for k in range(3)))
        with open(os.path.join(place, "summary.json"), "w") as f:
            json.dump({**summary, "title": "T", "notes": ["a <note>"]}, f)
    with open(os.path.join(folder, "rve", "grading.csv"), "w") as f:
        f.write("strain,diameter_m,passing\n0.1,1e-3,1\n")
    name, columns, found = command.read_result(os.path.join(folder, "rve"))
    need(name == "rve" and columns["work_J"] == c["work_J"] and found["folder"].endswith("rve") and found["grading"] ==
         {0.1: [{"strain": 0.1, "diameter_m": 1e-3, "passing": 1.0}]}, f"a folder that is read: {found}")
    need(command.read_result(os.path.join(folder, "bvp"))[2]["grading"] == {}, "a macro problem with a grading")
    os.remove(os.path.join(folder, "rve", "grading.csv"))
    made_up.unpainted()
    page = os.path.join(folder, "page.html")
    status, said, errors = made_up.command(command.main, os.path.join(folder, "rve"), os.path.join(folder, "bvp"),
                                           "-o", page)
    need(status == 0 and said.splitlines()[-1] == f"report: {page}", f"exit {status} {said} {errors}")
    with open(page) as f:
        text = f.read()
    need(text.index("Side by side") < text.index("<h2>bvp") < text.index("<h2>rve") and "rve: a &lt;note&gt;" in text
         and text.count("<details>") == 2, "the order of a report, notes, scenes")
    for name, words in (("nowhere", "no such folder"), (".", "no history.csv")):
        status, said, errors = made_up.command(command.main, os.path.join(folder, name))
        need(status == 2 and words in errors and errors.count("\n") == 1, f"{name}: exit {status} {errors}")
    with open(os.path.join(folder, "rve", "history.csv"), "a") as f:
        f.write("1,2\n")
    status, said, errors = made_up.command(command.main, os.path.join(folder, "rve"))
    need(status == 2 and "line 5 has 2 values" in errors, f"a damaged history: exit {status} {errors}")


def hover():
    """What plots.js is told of a figure: where its axes lie, limits, scales, curves; of many points some, the last."""
    fig, ax = plt.subplots(figsize=(4, 3))
    ax.set_position([0.25, 0.2, 0.5, 0.6])
    ax.plot([0, 1 / 3, math.nan, 2], [1, 2e6 / 3, 5, math.inf], label="a")
    ax.plot(range(601), range(601), label="_many")
    ax.plot([math.nan], [1], label="none")
    ax.set(xlim=(0, 700), ylim=(1, 900), yscale="log")
    right = ax.twinx()
    right.plot([1, 2], [3, 4], label="b")
    right.set_ylim(-2, 6)
    told = figures.values([ax, right], Bbox([[0.5, 0.25], [3.5, 2.75]]))
    # Inches: the axes are 1 to 3 wide and 0.6 to 2.4 high; from the picture's upper left, in points.
    near(told["box"], [36, 72 * 0.35, 72 * 2.5, 72 * 2.15], "the axes' place", 1e-3)
    need((told["x"], told["y"], told["log_x"], told["log"]) == ([0, 700], [1, 900], False, True), f"limits: {told}")
    a, many, b = told["series"]
    need(a == {"label": "a", "x": [0, 0.33333], "y": [1, 666670]}, f"a curve: {a}")
    need(many["label"] == "" and many["x"] == list(range(0, 601, 3)) == many["y"] and "log" not in many, f"{many}")
    need(b == {"label": "b", "x": [1, 2], "y": [3, 4], "limits": [-2, 6], "log": False}, f"a second axis: {b}")
    ax.plot(range(300), range(300), label="few")
    need(len(figures.values([ax], Bbox([[0, 0], [1, 1]]))["series"][-1]["x"]) == 300, "points that are few enough")
    ax.set_axis_off()
    told = figures.values([ax], Bbox([[0, 0], [1, 1]]))
    need(told["box"] == [0, 0, 0, 0] and not told["series"], "a picture without axes")
    plt.close(fig)


def axes():
    """Axes and texts that all figures share."""
    near(figures.positive([1.0, -2.0, 0.0]), [1, 2, math.nan], "for a logarithmic axis")
    fig, ax = plt.subplots()
    figures.decades(ax, [[3e-4, 0.0], [0.02, math.inf, math.nan]])
    need(ax.get_yscale() == "log", "decades")
    near(ax.get_ylim(), [1e-4, 0.1], "limits by decades")
    figures.decades(ax, [[1e-30, 5.0]])
    near(ax.get_ylim(), [1e-11, 10], "twelve decades at most", 1e-9, 0)
    ax.cla()
    figures.logarithmic(ax, {"log_x": True})
    need((ax.get_xscale(), ax.get_yscale()) == ("log", "linear"), "the axis that is asked for")
    ax.cla()
    ax.plot([0, 1], [2, 5], label="a"), ax.plot([0, 1], [0, 0], label="_hidden")
    ax.set(title="T", xlabel="x", ylabel="y")
    need(figures.alt_text([ax]) == "T; y against x; curves: a; a from 2 to 5", f"{figures.alt_text([ax])}")
    legend = (figures.legend(ax), ax.get_legend())[1]
    need([x.get_text() for x in legend.get_texts()] == ["a"] and legend.get_texts()[0].get_fontsize() == 8, "a legend")
    figures.legend(ax, size=5)
    need(ax.get_legend().get_texts()[0].get_fontsize() == 5, "a legend's size")
    plt.close(fig)
    hover()
    cells = "<tr><th>a&lt;</th></tr><tr><td>1</td></tr>"
    need(figures.table(["a<"], [[1]]) == f'<div class="wide"><table>{cells}</table></div>'
         and "<title>a &amp; b</title>" in figures.page("a & b", ""), "texts of pages")


samples()
problems()
axes()
with tempfile.TemporaryDirectory() as tmp:
    tables(tmp)
print(f"report_numbers: {len(faults)} faults")
sys.exit(bool(faults))
