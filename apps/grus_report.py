#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-report DIR [DIR...] [-o FILE]: one self-contained report.html with plots from result folders."""
import argparse
import base64
import csv
import html
import io
import json
import math
import os
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    matplotlib.rcParams["text.parse_math"] = False  # names are the user's, not formulas
except ImportError:
    sys.exit("grus-report: needs matplotlib (Debian: python3-matplotlib)")

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import grus_cells_report  # noqa: E402
from grus_results import VERSION, one_line, plain, read_grading, read_history, write_whole  # noqa: E402


def grading_curves(ax, name, states):
    for k, (strain, rows) in enumerate(states.items()):
        ax.semilogx([1e3 * r["diameter_m"] for r in rows], [100 * r["passing"] for r in rows], color=plt.cm.viridis(k / max(1, len(states) - 1)),
                    label=f"strain {strain:.3g}")
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)", ylabel="passing by mass (%)", title=f"{name}: grading, fines included")
    ax.legend(fontsize=7)


def by_size(ax, name, states):
    rows = [r for r in list(states.values())[-1] if r["grains"] > 0]
    d = [1e3 * r["diameter_m"] for r in rows]
    for key, scale in (("coordination", 1), ("generation", 1), ("elongation", 10), ("flatness", 10)):
        ax.semilogx(d, [scale * r[key] for r in rows], marker=".", label=key + (" × 10" if scale > 1 else ""))
    plain(ax.xaxis)
    ax.set(xlabel="equivalent diameter (mm)", title=f"{name}: means by size, last state")
    ax.legend(fontsize=7)


def figure(draw, width=6.4):
    fig, ax = plt.subplots(figsize=(width, 4.0), dpi=110)
    draw(ax)
    ax.grid(alpha=0.3)
    fig.tight_layout()
    data = io.BytesIO()
    fig.savefig(data, format="png")
    plt.close(fig)
    return f'<img src="data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}">'


def line(ax, x, y, label=None, **style):
    ax.plot(x, y, label=label, **style)


def rve_plots(runs):
    """Runs of grus-rve: (name, columns, summary)."""
    plots = []
    strain_runs = [r for r in runs if max(map(abs, r[1]["axial_strain"])) > 0]
    if strain_runs:
        def stress(ax):
            for name, c, _ in strain_runs:
                line(ax, c["axial_strain"], [v / 1e6 for v in c["axial_stress_Pa"]], name)
            ax.set(xlabel="axial strain", ylabel="axial stress (MPa)", title="Stress and strain (compression positive)")
            ax.legend()
        plots.append(figure(stress))
    for name, c, summary in runs:
        x = c["axial_strain"] if max(map(abs, c["axial_strain"])) > 0 else c["time_s"]
        xlabel = "axial strain" if x is c["axial_strain"] else "time (s)"

        def energy(ax):
            total = [0.0] * len(x)
            parts = ["elastic_J", "kinetic_J", "friction_J", "damping_J", "fracture_J", "split_J"]
            bottom = total
            for part in parts:
                top = [a + max(b, 0.0) for a, b in zip(bottom, c[part])]
                ax.fill_between(x, bottom, top, label=part[:-2], alpha=0.8)
                bottom = top
            ax.plot(x, c["work_J"], "k--", label="work in")
            ax.set(xlabel=xlabel, ylabel="energy (J)", title=f"{name}: where the work went")
            ax.legend(fontsize=8)
        plots.append(figure(energy))
        if c["breakages"][-1] > 0:
            def broken(ax):
                ax.plot(x, c["grains"], label="grains")
                ax.plot(x, c["breakages"], label="breakages")
                ax.set(xlabel=xlabel, ylabel="count", title=f"{name}: breakage")
                other = ax.twinx()
                other.plot(x, c["void_ratio"], "C2", label="void ratio")
                other.set_ylabel("void ratio")
                ax.legend(loc="upper left")
                other.legend(loc="lower right")
            plots.append(figure(broken))

        if "bonds" in c:
            plots.append(figure(grus_cells_report.load_plot(name, c)))
            shown = grus_cells_report.picture(summary["folder"])
            if shown:
                plots.append(figure(shown))

        grading = summary.pop("grading")
        if grading:
            plots.append(figure(lambda ax: grading_curves(ax, name, grading)))
            plots.append(figure(lambda ax: by_size(ax, name, grading)))

        def quality(ax):
            ax.semilogy(x, [max(abs(v), 1e-8) for v in c["energy_error"]], label="|energy error|")
            ax.semilogy(x, [max(v, 1e-8) for v in c["unbalanced_force"]], label="unbalanced force")
            ax.semilogy(x, [max(v, 1e-8) for v in c["inertial_number"]], label="inertial number")
            ax.set(xlabel=xlabel, title=f"{name}: how far to trust it")
            ax.legend(fontsize=8)
        plots.append(figure(quality))
    return plots


def loaded_axis(c):
    """The axis that is strained most: yy in two dimensions, zz in three."""
    return max(("xx", "yy", "zz"), key=lambda k: max(map(abs, c[f"mean_strain_{k}"])))


def bvp_plots(runs):
    plots = []
    for name, c, _ in runs:
        dynamic = "macro_kinetic_J" in c
        axis = loaded_axis(c)
        along = [1e6 * t for t in c["time_s"]] if dynamic else [-v for v in c[f"mean_strain_{axis}"]]
        label = "time (µs)" if dynamic else f"mean strain {axis}, compression"

        def stress(ax):
            head = "grains_stress" if "grains_stress_xx_Pa" in c else "mean_stress"
            for k in ("xx", "yy", "zz"):
                line(ax, along, [-v / 1e6 for v in c[f"{head}_{k}_Pa"]], f"mean stress {k}", marker=None if dynamic else "o", ms=3)
            where = " of the grains" if head.startswith("grains") else ""
            ax.set(xlabel=label, ylabel="stress (MPa)", title=f"{name}: stress{where} (compression positive)")
            ax.legend()
        plots.append(figure(stress))

        def breaks(ax):
            line(ax, along, c["breakages"], "breakages", marker=None if dynamic else "o", ms=3)
            ax.set(xlabel=label, ylabel="breakages in all RVEs", title=f"{name}: breakage")
        plots.append(figure(breaks))

        if dynamic:
            def energy(ax):
                for k in ("external", "internal", "kinetic", "viscous"):
                    line(ax, along, c[f"macro_{k}_J"], k)
                ax.set(xlabel=label, ylabel="energy (J)", title=f"{name}: macro energy, largest error {100 * max(map(abs, c['macro_energy_error'][5:] or [0])):.2f} %")
                ax.legend()
            plots.append(figure(energy))

            def gauges(ax):
                for k in [k for k in c if k.startswith("probe_") and k.endswith(f"_strain_{axis}")]:
                    line(ax, along, [-1e6 * v for v in c[k]], k[6:-10])
                ax.set(xlabel=label, ylabel=f"strain {axis} (µm/m, compression)", title=f"{name}: probes")
                ax.legend()
            if any(k.startswith("probe_") for k in c):
                plots.append(figure(gauges))
            continue

        def newton(ax):
            ax.bar(c["increment"], c["newton_iterations"], label="Newton iterations")
            ax.set(xlabel="increment", ylabel="Newton iterations", title=f"{name}: convergence")
            other = ax.twinx()
            other.semilogy(c["increment"], [max(v, 1e-12) for v in c["residual"]], "C3.-", label="residual")
            other.set_ylabel("relative residual")
        plots.append(figure(newton))
    return plots


def table(runs):
    rows = []
    for name, c, s in runs:
        counts = s.get("counts", {})
        seconds = s.get("seconds", {})
        if "increment" in c:
            facts = {"status": s.get("ending", ""), "load": f"{max(map(abs, c[f'mean_strain_{loaded_axis(c)}'])):.3f} strain",
                     "stress": f"{-min(c[f'mean_stress_{loaded_axis(c)}_Pa']) / 1e6:.4g} MPa", "breakages": f"{c['breakages'][-1]:.0f}",
                     "energy error": f"{100 * c['worst_rve_energy_error'][-1]:.2f} %", "wall": f"{seconds.get('solve_wall', math.nan):.1f} s"}
        else:
            facts = {"status": s.get("ending", ""), "load": f"{max(map(abs, c['axial_strain'])):.3f} strain",
                     "stress": f"{max(c['axial_stress_Pa']) / 1e6:.4g} MPa", "breakages": f"{c['breakages'][-1]:.0f}",
                     "energy error": f"{100 * max(map(abs, c['energy_error'])):.2f} %", "wall": f"{seconds.get('loading_wall', math.nan):.1f} s"}
        facts["steps"] = f"{counts.get('steps', counts.get('dem_steps', 0)):.3g}"
        rows.append((name, facts))
    head = ["run"] + list(rows[0][1])
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(v))}</td>" for v in [name] + list(facts.values())) + "</tr>" for name, facts in rows)
    text = [head] + [[name] + list(facts.values()) for name, facts in rows]
    widths = [max(len(str(r[i])) for r in text) for i in range(len(head))]
    for r in text:
        print("  ".join(str(v).ljust(w) for v, w in zip(r, widths)))
    return "<table><tr>" + "".join(f"<th>{h}</th>" for h in head) + f"</tr>{body}</table>"


RVE_COLUMNS = ("time_s", "axial_strain", "axial_stress_Pa", "grains", "breakages", "void_ratio", "energy_error", "unbalanced_force", "inertial_number",
               "elastic_J", "kinetic_J", "friction_J", "damping_J", "fracture_J", "split_J", "work_J")
BVP_COLUMNS = ("increment", "time_s", "newton_iterations", "residual", "breakages", "worst_rve_energy_error", *(f"mean_{q}" for ij in ("xx", "yy", "zz") for q in (f"strain_{ij}", f"stress_{ij}_Pa")))


def read_result(folder):
    """Name, columns and summary of a result folder. Throws OSError, ValueError where it is none."""
    columns = read_history(folder)
    path = os.path.join(folder, "summary.json")
    with open(path) as f:
        try:
            summary = json.load(f)
        except (ValueError, RecursionError) as e:
            raise ValueError(f"{path}: not JSON: {e}") from None
    if not isinstance(summary, dict) or not all(isinstance(summary.get(k, {}), dict) for k in ("counts", "seconds")):
        raise ValueError(f"{path}: not a summary of Grus")
    missing = [c for c in (BVP_COLUMNS if "increment" in columns else RVE_COLUMNS) if c not in columns]
    if missing:
        raise ValueError(f"{os.path.join(folder, 'history.csv')}: no column {missing[0]}: not a history of Grus")
    try:
        summary["grading"] = read_grading(folder) if "increment" not in columns else {}
    except (ValueError, KeyError, TypeError, csv.Error) as e:
        raise ValueError(f"{os.path.join(folder, 'grading.csv')}: not a grading of Grus ({e})") from None
    summary["folder"] = folder
    return os.path.basename(os.path.abspath(folder)), columns, summary


def main():
    parser = argparse.ArgumentParser(prog="grus-report", description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="result folders of grus-rve or grus-bvp")
    parser.add_argument("-o", metavar="FILE", help="output (default: report.html in the first folder)")
    parser.add_argument("--version", action="version", version=f"grus-report {VERSION}")
    args = parser.parse_args()
    try:
        runs = [read_result(folder) for folder in args.folders]
    except (OSError, ValueError) as e:
        print(one_line(f"grus-report: {e}"), file=sys.stderr)
        return 2
    try:
        return write(runs, args)
    except Exception as e:  # one line for the user; the whole story for who asks
        if os.environ.get("GRUS_DEBUG"):
            raise
        print(one_line(f"grus-report: {type(e).__name__}: {e} (GRUS_DEBUG=1 shows where)"), file=sys.stderr)
        return 1


def write(runs, args):
    rve = [r for r in runs if "increment" not in r[1]]
    bvp = [r for r in runs if "increment" in r[1]]
    plots = (bvp_plots(bvp) if bvp else []) + (rve_plots(rve) if rve else [])
    for _, _, summary in runs:
        summary.pop("grading", None)
        summary.pop("folder")
    scenes = "".join(f"<details><summary>{html.escape(n)}: {html.escape(str(s.get('title', '')))}</summary><pre>{html.escape(json.dumps(s, indent=1))}</pre></details>"
                     for n, _, s in runs)
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>Grus report</title>
<style>body{{font:15px/1.5 sans-serif;max-width:1460px;margin:2em auto;padding:0 1em;color:#222}}table{{border-collapse:collapse;margin:1em 0}}
td,th{{border:1px solid #ccc;padding:.3em .8em;text-align:left}}th{{background:#f2f0ea}}img{{max-width:100%;margin:.3em}}pre{{background:#f7f7f7;padding:1em;overflow:auto}}</style>
<h1>Grus report</h1>{table(runs)}{"".join(plots)}<h2>Scenes and figures of each run</h2>{scenes}</html>"""
    path = args.o or os.path.join(args.folders[0], "report.html")
    write_whole(path, page)
    print(f"report: {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
