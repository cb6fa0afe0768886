# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[plot]]: curves of cases with the band of their seeds, or gradings."""
import math

from grus.errors import InputError
from grus.figures import logarithmic, picture, plain, plt
from grus.runs.schema import NAMES, NUMBER, POSITIVE, TEXT, WORD, tables
from grus.study.numbers import position
from grus.study.statistics import mean
from grus.study.tables import Shown, asked

NAME = "plot"
BOUNDS = {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}
CORRIDOR = tables({"label": TEXT, "points": {"type": "array", "minItems": 2, "items": BOUNDS}}, ("label", "points"))
SCHEMA = tables({
    "name": WORD, "title": TEXT, "kind": {"enum": ["history", "grading"]}, "x": TEXT, "y": TEXT, "cases": NAMES,
    "scale": NUMBER, "x_scale": NUMBER, "xlabel": TEXT, "ylabel": TEXT, "y_max": POSITIVE, "log": {"type": "boolean"},
    "log_x": {"type": "boolean"}, "passing": {"type": "boolean"}, "corridor": CORRIDOR
}, ("name", "cases"))


def read(given, reading):
    for t in given:
        where = f"{reading.path}: plot '{t['name']}'"
        if t.get("kind") != "grading" and "y" not in t:
            raise InputError(f"{where}: needs 'y'")
        reading.named(where, t["cases"])
    return given


def cases(_entry):
    return []


def asks(entry, _common):
    over = None if "x" in entry else "axial_strain"
    return [asked(name, entry[axis], over) for name in entry["cases"] for axis in ("x", "y") if axis in entry]


def band(x_grid, runs, column, scale):
    """x, and there mean, least and largest over runs; where all of them get."""
    rows = [[scale * position(r["columns"], column, x) for x in x_grid] for r in runs]
    keep = [k for k in range(len(x_grid)) if all(not math.isnan(r[k]) for r in rows)]
    x = [x_grid[k] for k in keep]
    return x, *([of([r[k] for r in rows]) for k in keep] for of in (mean, min, max))


def history_plot(ax, plot, labels, runs):
    for c in plot.get("corridor", []):
        x = [p[0] for p in c["points"]]
        ax.fill_between(x, [p[1] for p in c["points"]], [p[2] for p in c["points"]], color="0.8", label=c["label"],
                        zorder=0)
    scale, column = plot.get("scale", 1.0), plot["y"]
    for name in plot["cases"]:
        if "x" in plot:
            color = None
            for r in runs[name]:  # seeds in one colour
                line, = ax.plot([v * plot.get("x_scale", 1.0) for v in r["columns"][plot["x"]]],
                                [scale * v for v in r["columns"][column]], lw=1.2, color=color,
                                label=labels[name] if r is runs[name][0] else None)
                color = line.get_color()
            continue
        last = max(max(r["columns"]["axial_strain"]) for r in runs[name])
        x, middle, low, high = band([last * k / 200 for k in range(201)], runs[name], column, scale)
        line, = ax.plot(x, middle, lw=1.5,
                        label=f"{labels[name]} ({len(runs[name])} seed{'s' if len(runs[name]) > 1 else ''})")
        if len(runs[name]) > 1:
            ax.fill_between(x, low, high, color=line.get_color(), alpha=0.25)
    logarithmic(ax, plot)
    if "y_max" in plot:
        ax.set_ylim(0, plot["y_max"])
    ax.set(xlabel=plot.get("xlabel", "axial strain"), ylabel=plot.get("ylabel", column))
    ax.legend(fontsize=8)


def grading_plot(ax, plot, labels, runs):
    for name in plot["cases"]:
        states = runs[name][0]["grading"]
        for k, (strain, rows) in enumerate(states.items()):
            total = sum(r["mass_kg"] for r in rows)
            if plot.get("passing", True):
                y = [100 * r["passing"] for r in rows]
            else:
                y = [100 * r["mass_kg"] / total if total > 0 else math.nan for r in rows]
            colour = plt.cm.viridis(k / max(1, len(states) - 1))
            ax.semilogx([1e3 * r["diameter_m"] for r in rows], y, color=colour,
                        label=f"{labels[name]}, strain {strain:.2f}")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)",
           ylabel="passing by mass (%)" if plot.get("passing", True) else "mass in class (%)")
    ax.legend(fontsize=7)


def show(entries, done):
    body = ""
    for plot in entries:
        fig, ax = plt.subplots(figsize=(7, 4.6))
        (grading_plot if plot.get("kind") == "grading" else history_plot)(ax, plot, done.labels, done.runs)
        ax.set_title(plot.get("title", plot["name"]), fontsize=10)
        body += picture(fig, done.out, plot["name"])
    return Shown(body=body)
