# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables, plots and checks of a study. Quantities are columns of history.csv at an axial strain, or keys of
summary.json."""
import html
import math
import os

from grus.figures import STYLE, logarithmic, picture, plain, plt, table as html_table
from grus.files.texts import text_table
from grus.files.writing import write_csv, write_whole
from grus.runs.censored import BOUNDS, mean_of, strength_of
from grus.study import precision_report, sweep as sweep_report
from grus.study.precision import cost, deviation, energy_error, mean, position as at, power_law


def of_summary(run, path):
    """A number of summary.json; NaN where it has none, as a grain that did not break has no strength."""
    return strength_of(run, path)[0]


def found(runs, quantity, strain=None):
    """(value, bound) of each run at a strain; without one, at the end. Where a run has no value, it may be known to be
    above the bound."""
    if "." in quantity:
        return [strength_of(r, quantity) for r in runs]
    columns = [r["columns"] for r in runs]
    return [(c[quantity][-1] if strain is None else at(c, quantity, strain), math.nan) for c in columns]


def cell_text(pairs):
    """Mean and scatter over runs; a lower bound of the mean where grains did not break."""
    middle, least, unbroken = mean_of(pairs)
    if unbroken:
        return f"{'-' if math.isnan(least) else f'> {least:.4g}'} ({unbroken} of {len(pairs)} not broken)"
    scatter = f" ± {deviation([v for v, _ in pairs]):.2g}" if len(pairs) > 1 else ""
    return "-" if math.isnan(middle) else f"{middle:.4g}{scatter}"


def band(x_grid, runs, column, scale):
    rows = [[scale * at(r["columns"], column, x) for x in x_grid] for r in runs]
    keep = [k for k in range(len(x_grid)) if all(not math.isnan(r[k]) for r in rows)]
    x = [x_grid[k] for k in keep]
    return x, [mean([r[k] for r in rows]) for k in keep], [min(r[k] for r in rows)
                                                           for k in keep], [max(r[k] for r in rows) for k in keep]


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
            y = [100 * r["passing"] for r in rows] if plot.get(
                "passing", True) else [100 * r["mass_kg"] / total if total > 0 else math.nan for r in rows]
            ax.semilogx([1e3 * r["diameter_m"] for r in rows], y, color=plt.cm.viridis(k / max(1,
                                                                                               len(states) - 1)),
                        label=f"{labels[name]}, strain {strain:.2f}")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)",
           ylabel="passing by mass (%)" if plot.get("passing", True) else "mass in class (%)")
    ax.legend(fontsize=7)


def check_of(check, runs):
    """(passed, text) of a claim."""
    quantity = check.get("quantity", "axial_stress_Pa")
    if "greater" in check:
        high, low = check["greater"]
        texts, ok = [], True
        for strain in check.get("at", [None]):
            _, a, beyond = mean_of(found(runs[high], quantity, strain))  # here a lower bound is enough
            b, _, unbroken = mean_of(found(runs[low], quantity, strain))
            ok = ok and a > check.get("factor", 1.0) * b
            where = "" if strain is None else f" at {strain:g}"
            texts.append(f"{'> ' if beyond else ''}{a:.4g} / {b:.4g} = {a / b if b else math.inf:.3g}{where}" +
                         (f" ({beyond + unbroken} not broken)" if beyond + unbroken else ""))
        return ok, f"{high} / {low}: " + "; ".join(texts)
    pairs = [x for name in check.get("cases", [check.get("case")]) for strain in check.get("at", [None])
             for x in found(runs[name], quantity, strain)]
    v = [x for x, _ in pairs if not math.isnan(x)]
    if len(v) < len(pairs):  # what is not known cannot hold
        unbroken = mean_of(pairs)[2]
        why = f": {unbroken} grains did not break" if unbroken else ""
        return False, f"{len(pairs) - len(v)} of {len(pairs)} values are not there{why}"
    if "near" in check:
        worst = max(abs(x / check["near"] - 1) for x in v)
        return worst <= check["tolerance"], f"{mean(v):.5g} against {check['near']:g}: {100 * worst:.2f} % off at worst"
    if "between" in check:
        low, high = check["between"]
        return all(low <= x <= high for x in v), f"{min(v):.4g} … {max(v):.4g}, asked {low:g} … {high:g}"
    return all(abs(x) <= check["below"] for x in v), f"at most {max(map(abs, v)):.3g}, asked {check['below']:g}"


def law_plot(fit, labels, runs):
    """Every run as a point, the fitted and the expected power law through the middle of each strain's points."""
    fig, ax = plt.subplots(figsize=(7, 4.6))
    for k, strain in enumerate(fit["at"]):
        points = [(of_summary(r, fit["x"]), at(r["columns"], fit["quantity"], strain)) for name in fit["cases"]
                  for r in runs[name]]
        points = sorted(p for p in points if p[0] > 0 and p[1] > 0)
        law = power_law(points)
        if law is None:
            continue
        exponent, _ = law
        mx, my = (math.exp(mean([math.log(p[j]) for p in points])) for j in (0, 1))
        x = [points[0][0], points[-1][0]]
        ax.loglog([p[0] for p in points], [p[1] for p in points], "o", ms=4, color=f"C{k}", label=f"strain {strain:g}")
        ax.loglog(x, [my * (v / mx) ** exponent for v in x], color=f"C{k}", lw=1.2, label=f"exponent {exponent:.2f}")
        if "expected" in fit:
            ax.loglog(x, [my * (v / mx)**fit["expected"] for v in x], color=f"C{k}", lw=1, ls="--",
                      label=f"expected {fit['expected']:g}" if k == 0 else None)
    plain(ax.xaxis), plain(ax.yaxis)
    ax.set(xlabel=fit["x"], ylabel=fit["quantity"], title=fit["name"])
    ax.legend(fontsize=8)
    return fig


def sweep_result(run, reference):
    """What a run of a parameter sweep came to, in the words of the paper's Table 1."""
    if run["summary"]["status"] == 3:
        return "unstable: " + run["summary"]["ending"]
    if run["columns"]["breakages"][-1] == 0:
        return "never broken"
    last = min(run["columns"]["axial_strain"][-1], reference["columns"]["axial_strain"][-1])
    grid = [last * k / 200 for k in range(1, 200)]
    a, b = [[at(r["columns"], "axial_stress_Pa", x) for x in grid] for r in (run, reference)]
    norm = math.sqrt(sum(y * y for y in b))
    off = math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b))) / norm if norm > 0 else math.nan
    word = "good, same result" if off < 0.05 else "good, slightly different" if off < 0.2 else "broken, different path"
    return f"{word} ({100 * off:.1f} %)"


def write(study, common, cases, runs, studies, sweeps, out, wall, workers):
    labels = {c["name"]: c["label"] for c in cases}
    strains = common.get("at", [0.1, 0.2])
    quantities = common.get("quantities", ["axial_stress_Pa"])
    head = ["case", "seeds", "status"] + [q if "." in q else f"{q} at {e:g}" for q in quantities for e in strains] + \
           ["grains", "breakages", "energy error %", "steps", "CPU s"]
    censored = [q for q in quantities if q in BOUNDS]
    rows, plain = [], []
    for c in cases:
        r = runs[c["name"]]
        cells, numbers, least = [], [], {}
        for q in quantities:
            for e in strains:
                pairs = found(r, q, e)
                v = [x for x, _ in pairs]
                cells.append(cell_text(pairs))
                numbers += [mean(v), deviation(v)]
                least.update({q: list(mean_of(pairs)[1:])} if q in BOUNDS else {})
        status = sorted({str(x["summary"]["status"]) for x in r})
        last = lambda name: mean([x["columns"][name][-1] if name in x["columns"] else math.nan for x in r])
        tail = [
            last("grains"),
            last("breakages"), 100 * max(energy_error(x) for x in r),
            mean([x["summary"]["counts"].get("steps", x["summary"]["counts"].get("dem_steps", 0)) for x in r]),
            mean([cost(x)["cpu"] for x in r])
        ]
        rows.append([c["label"], len(r), ",".join(status)] + cells +
                    [f"{tail[0]:.0f}", f"{tail[1]:.0f}", f"{tail[2]:.2f}", f"{tail[3]:.3g}", f"{tail[4]:.1f}"])
        plain.append([c["name"], len(r), ",".join(status)] + numbers + tail + [x for q in censored for x in least[q]])
    write_csv(os.path.join(out, "study.csv"),
              [["case", "seeds", "status"] +
               [f"{k}_{q}_at_{e:g}" for q in quantities for e in strains
                for k in ("mean", "sd")] + ["grains", "breakages", "worst_energy_error_percent", "steps", "cpu_s"] +
               [f"{k}_{q}" for q in censored for k in ("at_least", "not_broken")]] + plain)
    text = study.get("title",
                     "Study") + f"\n{wall:.0f} s on {workers} cores\n" + ("\n" + text_table(head, rows) if rows else "")
    body = html_table(head, rows) if rows else ""
    if studies:
        added = precision_report.write(studies, out)
        text, body = text + added[0], body + added[1]
    if sweeps:
        added = sweep_report.write(sweeps, out)
        text, body = text + added[0], body + added[1]

    for t in study.get("table", []):
        reference = runs[t["reference"]][0]
        sweep = []
        for name in t["cases"]:
            r = runs[name][0]
            steps = r["columns"]["time_step_s"]
            sweep.append([
                labels[name], f"{min(steps):.2g} … {max(steps):.2g}",
                f"{max(r['columns']['axial_stress_Pa']) / 1e6:.3g}", f"{r['columns']['breakages'][-1]:.0f}",
                sweep_result(r, reference)
            ])
        head_t = [t.get("title", t["name"]), "time steps used (s)", "peak stress (MPa)", "breakages", "result"]
        text += "\n" + text_table(head_t, sweep)
        body += html_table(head_t, sweep)

    fits = []
    for fit in study.get("fit", []):
        body += picture(law_plot(fit, labels, runs), out,
                        "fit_" + "".join(c if c.isalnum() else "_" for c in fit["name"])[:40])
        for strain in fit["at"]:
            points = [(of_summary(r, fit["x"]), at(r["columns"], fit["quantity"], strain)) for name in fit["cases"]
                      for r in runs[name]]
            known = [p for p in points if not any(map(math.isnan, p))]
            law, lost = power_law(known), len(points) - len(known)
            text_of = f"{law[0]:.2f} ± {law[1]:.2f}" if law else "fewer than two places"
            text_of += f" ({lost} of {len(points)} runs left out)" if lost else ""
            fits.append([fit["name"], f"{strain:g}", text_of, fit.get("expected", "")])
    if fits:
        head_f = ["power law", "axial strain", "exponent (standard error)", "expected"]
        text += "\n" + text_table(head_f, fits)
        body += html_table(head_f, fits)

    passed, results = True, []
    for check in study.get("check", []):
        ok, detail = check_of(check, runs)
        passed = passed and ok
        results.append(["holds" if ok else "DOES NOT HOLD", check["claim"], detail])
    if results:
        text += "\n" + text_table(["", "claim", "measured"], results)
        body += "<h2>Claims</h2>" + html_table(["", "claim", "measured"], results)

    for plot in study.get("plot", []):
        fig, ax = plt.subplots(figsize=(7, 4.6))
        (grading_plot if plot.get("kind") == "grading" else history_plot)(ax, plot, labels, runs)
        ax.set_title(plot.get("title", plot["name"]), fontsize=10)
        body += picture(fig, out, plot["name"])
    write_whole(os.path.join(out, "study.txt"), text)
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8">
<title>{html.escape(study.get('title', 'Study'))}</title>
<style>{STYLE}img{{max-width:100%;margin:.3em}}</style>
<h1>{html.escape(study.get('title', 'Study'))}</h1>{body}</html>"""
    write_whole(os.path.join(out, "report.html"), page)
    print(text)
    return passed
