# SPDX-License-Identifier: LGPL-3.0-or-later
"""report.html of a calibration: values, what the data fix, the targets with data and fit, sd by the number of
points."""
import html
import os

import numpy as np

from grus.calibrate.regression import TOO_FAR
from grus.figures import picture, plain, plt, table as html_table
from grus.files.writing import write_whole


def target_plot(target, values, fit, checked):
    fig, ax = plt.subplots(figsize=(6, 4))
    for row in values:
        ax.plot(target.x, row, color="0.8", lw=0.6, zorder=0)
    ax.errorbar(target.x, target.values, target.error, fmt="ko", ms=3, lw=0.8, label="data")
    ax.plot(target.x, fit, "C0-", lw=1.5, label="fit")
    if checked is not None:
        ax.plot(target.x, checked, "C1--", lw=1.2, label="run at the best point")
    if target.log or target.kind == "grading":
        ax.set_xscale("log")
        plain(ax.xaxis)
    t = target.table
    label = {"grading": ("diameter (m)", "passing"), "quantiles": ("share of grains", t.get("quantity", ""))}
    ax.set(xlabel=label.get(target.kind, (t.get("x", ""), ""))[0],
           ylabel=label.get(target.kind, ("", t.get("y", t.get("quantity", ""))))[1], title=target.name)
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


def write(title, out, summary, parameters, targets, evaluation, result, draws=None):
    body = html_table(["parameter", "value", "sd, of range", "verdict"],
                      [[p.key, p.text(u, s["sd_of_range"]), f"{100 * s['sd_of_range']:.1f} %", s["verdict"]]
                       for p, u, s in zip(parameters, result.x, summary["parameters"])])
    body += "<p>" + html.escape(
        f"{summary['points']} points, {summary['failed_points']} of them with a run that became unstable. A value is "
        "identified where its standard deviation is below 10 % of "
        "its range, weak to 15 %; beyond, the data say little more than the range did.") + "</p>"
    body += "".join(f"<p><strong>{html.escape(line)}</strong></p>" for line in said_of_runs(summary))
    names = [p.name for p in parameters]
    body += "<h2>Correlations</h2>" + html_table([""] + names, [[n] + [f"{c:+.2f}" for c in row]
                                                                for n, row in zip(names, summary["correlation"])])
    if summary["checked_by_runs"]:
        c = summary["checked_by_runs"]
        body += "<h2>Runs one standard deviation to either side</h2>" + html_table(
            ["parameter", "below", "sum of squares", "above", "sum of squares"], [[
                s["name"], f"{s['at'][0]:.4g}", f"{s['sum_of_squares'][0]:.4g}", f"{s['at'][1]:.4g}",
                f"{s['sum_of_squares'][1]:.4g}"
            ] for s in c["sides"]])
        body += f"<p>At the best point {c['best']:.4g}.</p>"
    if draws is not None:
        body += "<h2>Posterior on the fitted surface</h2>" + html_table(
            ["parameter", "median", "middle 68 %", "middle 95 %"],
            [[q["key"], f"{q['median']:.4g}"] + [f"{q[m][0]:.4g} … {q[m][1]:.4g}" for m in ("middle_68", "middle_95")]
             for q in summary["posterior"]["parameters"]])
        body += picture(posterior_plot(draws, parameters), out, "posterior")
    body += "<h2>Targets</h2>" + html_table(
        ["target", "kind", "points", "misfit (rms, in standard deviations)"],
        [[t["name"], t["kind"], t["points"], f"{t['rms_in_standard_deviations']:.2f}"] for t in summary["targets"]])
    at = 0
    checked = summary["checked_by_runs"]["values"] if summary["checked_by_runs"] else None
    for k, t in enumerate(targets):
        part = slice(at, at + len(t.values))
        at = part.stop
        if len(t.values) > 1:
            body += picture(
                target_plot(t, [r["values"][part] for r in evaluation.rows], result.fitted[part],
                            checked[part] if checked else None), out, f"target_{k}")
    fig, ax = plt.subplots(figsize=(6, 4))
    for k, name in enumerate(names):
        ax.plot([n for n, _, _ in result.history], [100 * s[k] for _, _, s in result.history], "o-", ms=3, label=name)
    ax.axhline(10, color="0.6", ls=":")
    ax.set(xlabel="points", ylabel="standard deviation (% of range)", title="What more runs bring")
    ax.legend(fontsize=8)
    body += picture(fig, out, "sd_by_points")
    fig, ax = plt.subplots(figsize=(4.5, 4))
    image = ax.imshow(np.array(summary["correlation"]), vmin=-1, vmax=1, cmap="RdBu")
    ax.set_xticks(range(len(names)), names, rotation=45, ha="right", fontsize=8)
    ax.set_yticks(range(len(names)), names, fontsize=8)
    fig.colorbar(image, ax=ax)
    body += picture(fig, out, "correlation")
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>
<style>body{{font:15px/1.5 sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#222}}
table{{border-collapse:collapse;margin:1em 0}}
td,th{{border:1px solid #ccc;padding:.3em .8em;text-align:left}}
th{{background:#f2f0ea}}img{{max-width:100%;margin:.3em}}</style>
<h1>{html.escape(title)}</h1>{body}</html>"""
    write_whole(os.path.join(out, "report.html"), page)
