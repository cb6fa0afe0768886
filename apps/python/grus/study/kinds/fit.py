# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[fit]]: the power law of a quantity against another, over cases."""
import math

from grus.figures import picture, plain, plt, table as html_table
from grus.files.texts import text_table
from grus.runs.schema import NAMES, NUMBER, STRAINS, TEXT, tables
from grus.study.numbers import finished, of_summary, position
from grus.study.statistics import mean, power_law
from grus.study.tables import Shown, asked

NAME = "fit"
SCHEMA = tables({"name": TEXT, "cases": NAMES, "x": TEXT, "quantity": TEXT, "at": STRAINS, "expected": NUMBER},
                ("name", "cases", "x", "quantity", "at"))


def read(given, reading):
    for t in given:
        reading.named(f"{reading.path}: fit '{t['name']}'", t["cases"])
    return given


def cases(_entry):
    return []


def asks(entry, _common):
    return [asked(name, quantity) for name in entry["cases"] for quantity in (entry["quantity"], entry["x"])]


def points_of(fit, strain, runs):
    """(x, quantity at the strain) of each run; NaN of one that did not finish."""
    return [(of_summary(r, fit["x"]), position(r["columns"], fit["quantity"], strain) if finished(r) else math.nan)
            for name in fit["cases"] for r in runs[name]]


def law_plot(fit, runs):
    """Every run as a point, the fitted and the expected power law through the middle of each strain's points."""
    fig, ax = plt.subplots(figsize=(7, 4.6))
    for k, strain in enumerate(fit["at"]):
        points = sorted(p for p in points_of(fit, strain, runs) if p[0] > 0 and p[1] > 0)
        law = power_law(points)
        if law is None:
            continue
        exponent, _ = law
        mx, my = (math.exp(mean([math.log(p[j]) for p in points])) for j in (0, 1))
        x = [points[0][0], points[-1][0]]
        ax.loglog([p[0] for p in points], [p[1] for p in points], "o", ms=4, color=f"C{k}", label=f"strain {strain:g}")
        ax.loglog(x, [my * (v / mx) ** exponent for v in x], color=f"C{k}", lw=1.2, label=f"exponent {exponent:.2f}")
        if "expected" in fit:
            ax.loglog(x, [my * (v / mx) ** fit["expected"] for v in x], color=f"C{k}", lw=1, ls="--",
                      label=f"expected {fit['expected']:g}" if k == 0 else None)
    plain(ax.xaxis), plain(ax.yaxis)
    ax.set(xlabel=fit["x"], ylabel=fit["quantity"], title=fit["name"])
    ax.legend(fontsize=8)
    return fig


def show(entries, done):
    body, rows = "", []
    for fit in entries:
        file = "fit_" + "".join(c if c.isalnum() else "_" for c in fit["name"])[:40]
        body += picture(law_plot(fit, done.runs), done.out, file)
        for strain in fit["at"]:
            points = points_of(fit, strain, done.runs)
            known = [p for p in points if not any(map(math.isnan, p))]
            law, lost = power_law(known), len(points) - len(known)
            told = f"{law[0]:.2f} ± {law[1]:.2f}" if law else "fewer than two places"
            told += f" ({lost} of {len(points)} runs left out)" if lost else ""
            rows.append([fit["name"], f"{strain:g}", told, fit.get("expected", "")])
    if not rows:
        return Shown()
    head = ["power law", "axial strain", "exponent (standard error)", "expected"]
    return Shown("\n" + text_table(head, rows), body + html_table(head, rows))
