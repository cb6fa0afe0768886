# SPDX-License-Identifier: LGPL-3.0-or-later
"""report.html of a calibration: values, what the data fix, the targets with data and fit, sd by the number of
points."""
import html
import os

import numpy as np

from grus.calibrate.regression import TOO_FAR
from grus.figures import counts, page, picture, plain, plt, table as html_table, told_as
from grus.files.writing import write_whole


def target_plot(target, values, fit, checked):
    fig, ax = plt.subplots(figsize=(6, 4))
    (much_x, x_name), (much, y_name) = names_of(target)
    x = target.x / much_x
    for row in values:
        ax.plot(x, row / much, color="0.8", lw=0.6, zorder=0)
    ax.errorbar(x, target.values / much, target.error / much, fmt="ko", ms=3, lw=0.8, label="data")
    ax.plot(x, fit / much, "C0-", lw=1.5, label="fit")
    if checked is not None:
        ax.plot(x, checked / much, "C1--", lw=1.2, label="run at the best point")
    if target.log or target.kind == "grading":
        ax.set_xscale("log")
        plain(ax.xaxis)
    ax.set(xlabel=x_name, ylabel=y_name, title=target.name)
    ax.legend(fontsize=8)
    return fig


def posterior_plot(draws, parameters):
    """Each parameter's draws, and each pair's."""
    p = len(parameters)
    fig, axes = plt.subplots(p, p, figsize=(2.2 * p + 1, 2.2 * p + 1), squeeze=False)
    own = np.array([[q.number(u) for q, u in zip(parameters, x)] for x in draws[::10]])
    for i in range(p):
        for k in range(p):
            ax = axes[i][k]
            if k > i:
                ax.axis("off")
                continue
            if k == i:
                ax.hist(own[:, i], bins=40, color="0.6")
                ax.set_yticks([])
            else:
                ax.plot(own[:, k], own[:, i], ".", ms=1, alpha=0.2, color="C0", rasterized=True)
            if i == p - 1:
                ax.set_xlabel(parameters[k].name, fontsize=8)
            if k == 0:
                ax.set_ylabel(parameters[i].name, fontsize=8)
            ax.tick_params(labelsize=7)
    fig.tight_layout()
    return fig


def said_of_runs(summary):
    """What a reader must know of the runs, a line each."""
    lines = []
    for t in summary["targets"]:
        if t["rms_in_standard_deviations"] > TOO_FAR:
            lines.append(
                f"{t['name']}: the fit is {t['rms_in_standard_deviations']:.1f} standard deviations off the data: the "
                "model, the ranges or the data are not right"
            )
        if t["stronger_than"]:
            lines.append(
                f"{t['name']}: {t['stronger_than']} of {t['runs']} grains did not break: each counts as stronger than "
                "the largest stress it bore"
            )
        if t["still_rising"]:
            lines.append(
                f"{t['name']}: in {t['still_rising']} of {t['runs']} runs the peak is the last row: the test ends "
                "before its peak, raise loading.final_strain"
            )
    if summary["refused_points"]:
        lines.append(
            f"{summary['refused_points']} of {summary['points']} points were refused and count as failed: "
            f"{summary['refusal']}"
        )
    return lines


def values_table(summary, parameters, result):
    rows = [[p.key, p.text(u, s["sd_of_range"]), f"{p.setting(0)} … {p.setting(1)}", f"{100 * s['sd_of_range']:.1f} %",
             s["verdict"]] for p, u, s in zip(parameters, result.x, summary["parameters"])]
    told = (f"{summary['points']} points, {summary['failed_points']} of them with a run that became unstable; a point "
            "is a set of values, which is run with every seed. Behind a value stands one standard deviation: ± what is "
            "added and taken away, ×/÷ what is multiplied and divided by. A value is identified where its standard "
            "deviation is below 10 % of its range, weak to 15 %; beyond, the data say little more than the range did.")
    said = "".join(f"<p><strong>{html.escape(line)}</strong></p>" for line in said_of_runs(summary))
    head = ["parameter", "value", "range given", "sd, of range", "verdict"]
    return html_table(head, rows) + f"<p>{html.escape(told)}</p>" + said


def best_scenes(scenes, folders):
    """Where the answer is: scenes with the values found, and the folders of their runs, if they have been run."""
    code = lambda names: ", ".join(f"<code>{html.escape(n)}</code>" for n in names)
    ran = (f" They have been run: {code(folders)}, beside this report; <code>grus report</code> draws each." if folders
           else "")
    return f"<p>The values found are in {code(scenes)}: scenes that run as they are, by <code>grus run</code>.{ran}</p>"


def correlations(summary, names):
    if len(names) < 2:
        return ""
    rows = [[n] + [f"{c:+.2f}" for c in row] for n, row in zip(names, summary["correlation"])]
    return ("<h2>Correlations</h2>" + html_table([""] + names, rows)
            + "<p>Near +1 or -1 the data hardly tell the two apart: one makes up for the other.</p>")


def neighbours(checked, units):
    """What runs beside the best point gave; `units`: of parameters, by their names."""
    head = ["parameter", "below", "sum of squares", "above", "sum of squares"]
    called = lambda name: f"{name} ({units[name]})" if units.get(name) else name
    rows = [[called(s["name"]), *(f"{v:.4g}" for pair in zip(s["at"], s["sum_of_squares"]) for v in pair)]
            for s in checked["sides"]]
    return ("<h2>Runs one standard deviation to either side</h2>" + html_table(head, rows)
            + f"<p>Sum of squares: of what the runs are off the data, over the data's deviations; smaller is better. "
            f"At the best point {checked['best']:.4g}.</p>")


def posterior_table(found):
    rows = [[q["key"], f"{q['median']:.4g}"] + [f"{q[m][0]:.4g} … {q[m][1]:.4g}" for m in ("middle_68", "middle_95")]
            for q in found]
    head = ["parameter", "median", "middle 68 %", "middle 95 %"]
    return "<h2>Posterior on the fitted surface</h2>" + html_table(head, rows)


def misfits(targets):
    rows = [[t["name"], t["kind"], t["points"], f"{t['rms_in_standard_deviations']:.2f}"] for t in targets]
    return ("<h2>Targets</h2>" + html_table(["target", "kind", "points", "misfit (rms, in standard deviations)"], rows)
            + f"<p>Some 1 is what data, seeds and fit leave open; above {TOO_FAR:g} the model, the ranges or the data "
            "are not right.</p>")


def names_of(target):
    """((unit, name) of its x, (unit, name) of its values) as people read them; no name of x: there is none."""
    t = target.table
    if target.kind == "grading":
        return (1e-3, "diameter (mm)"), (1.0, "passing")
    if target.kind == "quantiles":
        return (1.0, "share of grains"), told_as(t.get("quantity", ""), target.values)
    if target.kind == "yield":
        return (1.0, ""), told_as(t.get("x", "axial_stress_Pa"), target.values)
    of_x = told_as(t.get("x", ""), target.x) if target.kind == "curve" else (1.0, "")
    return of_x, told_as(t.get("y", t.get("quantity", "")), target.values)


def fit_table(target, fit, checked, most=20):
    """Data beside fit, and beside the run at the best point: what differs, in standard deviations of the data. Of more
    than `most` points every second, third ... and the last."""
    (much_x, x_name), (much, y_name) = names_of(target)
    n = len(target.values)
    shown = range(n)[::-max(1, -(-n // most))][::-1]
    head = [x_name or "target", f"{y_name}, data", "standard deviation", "fit", "off by (sd)"]
    head += [] if checked is None else ["run at the best point", "off by (sd)"]
    rows = []
    for k in shown:
        row = [f"{target.x[k] / much_x:.5g}" if x_name else target.name, f"{target.values[k] / much:.5g}",
               f"{target.error[k] / much:.3g}"]
        for found in (fit, checked):
            if found is not None:
                row += [f"{found[k] / much:.5g}", f"{(found[k] - target.values[k]) / target.error[k]:+.2f}"]
        rows.append(row)
    return html_table(head, rows)


def target_plots(out, targets, rows, fitted, checked):
    """Of each target data beside fit, as a table; of those with more than one point a plot, too, with all that was
    tried. `fitted`, `checked`: of all targets."""
    at = 0
    body = ("<p>Fit: what the surface through all runs says at the best point; grey: all that was "
            "tried. Off by: in standard deviations of the data alone.</p>")
    for k, t in enumerate(targets):
        part = slice(at, at + len(t.values))
        at = part.stop
        at_best = np.asarray(checked)[part] if checked else None
        body += f"<h3>{html.escape(t.name)}</h3>"
        if len(t.values) > 1:
            tried = [r["values"][part] for r in rows]
            body += picture(target_plot(t, tried, fitted[part], at_best), out, f"target_{k}")
        body += fit_table(t, fitted[part], at_best)
    return body


def deviations_plot(history, names):
    fig, ax = plt.subplots(figsize=(6, 4))
    for k, name in enumerate(names):
        ax.plot([n for n, _, _ in history], [100 * s[k] for _, _, s in history], "o-", ms=3, label=name)
    ax.axhline(10, color="0.6", ls=":")
    counts(ax.xaxis)
    ax.set(xlabel="points", ylabel="standard deviation (% of range)", title="What more runs bring")
    ax.legend(fontsize=8)
    return fig


def correlation_plot(correlation, names):
    fig, ax = plt.subplots(figsize=(4.5, 4))
    image = ax.imshow(np.array(correlation), vmin=-1, vmax=1, cmap="RdBu")
    ax.set_xticks(range(len(names)), names, rotation=45, ha="right", fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    fig.colorbar(image, ax=ax)
    return fig


def write(title, out, summary, parameters, targets, evaluation, result, best, draws=None):
    """`best`: (names of the best scenes, names of folders of their runs), within `out`."""
    names, checked = [p.name for p in parameters], summary["checked_by_runs"]
    body = values_table(summary, parameters, result) + best_scenes(*best) + correlations(summary, names)
    body += neighbours(checked, {p.name: p.unit for p in parameters}) if checked else ""
    if draws is not None:
        body += posterior_table(summary["posterior"]["parameters"])
        body += picture(posterior_plot(draws, parameters), out, "posterior")
    body += misfits(summary["targets"])
    body += target_plots(out, targets, evaluation.rows, result.fitted, checked["values"] if checked else None)
    body += picture(deviations_plot(result.history, names), out, "sd_by_points")
    if len(names) > 1:
        body += picture(correlation_plot(summary["correlation"], names), out, "correlation")
    write_whole(os.path.join(out, "report.html"), page(title, body))
