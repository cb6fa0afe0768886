# SPDX-License-Identifier: LGPL-3.0-or-later
"""grus-report DIR [DIR...] [-o FILE]: one self-contained report.html with tables, plots and pictures from result
folders."""
import argparse
import csv
import html
import json
import math
import os
import sys

from grus._version import __version__
from grus.errors import InputError
from grus.figures import ZOOM, page, table, unit_of
from grus.files.folders import REPORT, note_result, refuse_overwrite
from grus.files.texts import one_line, text_table
from grus.files.writing import write_whole
from grus.report import bvp_plots, rve_plots
from grus.results import read_grading, read_history, read_summary

HEAD = "Grus report"
TITLE = f"<title>{HEAD}</title>"  # by which a report is known


class CannotWrite(Exception):
    """The report has no place; its text is one line."""


def is_bvp(run):
    return "increment" in run[1]


def facts(run):
    """Of the table: what a run came to."""
    name, c, s = run
    counts, seconds = s.get("counts", {}), s.get("seconds", {})
    if is_bvp(run):
        axis = bvp_plots.loaded_axis(c, s)
        load, stress = max(map(abs, c[f"mean_strain_{axis}"])), -min(c[f"mean_stress_{axis}_Pa"])
        error, wall = max(map(abs, c["energy_error"][1:] or c["energy_error"])), seconds.get("solve_wall", math.nan)
    else:
        name_of, told = ("nominal_stress_Pa", "peak_stress_Pa") if "nominal_stress_Pa" in c else (
            "axial_stress_Pa", "peak_axial_stress_Pa")
        load = max(map(abs, c["axial_strain"]))
        stress = max([*c[name_of], s.get("results", {}).get(told, -math.inf)])  # between rows, where grains break
        error, wall = max(map(abs, c["energy_error"])), seconds.get("loading_wall", math.nan)
    much, unit = unit_of([stress])
    q = {}
    if not is_bvp(run) and "q_Pa" in c and rve_plots.sheared(run):
        apart, unit_q = unit_of(c["q_Pa"])
        q = {"largest q": f"{max(c['q_Pa']) / apart + 0.0:.4g} {unit_q}"}
    steps = counts.get("steps", counts.get("dem_steps", math.nan))
    return {
        "run": name, "ending": s.get("ending", ""), "load": f"{load:.3f} strain",
        "stress": f"{stress / much + 0.0:.4g} {unit}", **q, "broken": broken(c), "energy error": f"{100 * error:.2f} %",
        "wall": f"{wall:.1f} s", "steps": f"{steps:.3g}", **start_of(run)
    }


def start_of(run):
    """Of a sample: void ratio where the test begins, relative density where the scene tells its limits."""
    _, c, s = run
    scene = s.get("scene", {})
    e = s.get("sample", {}).get("void_ratio", c["void_ratio"][0] if "void_ratio" in c else 0)
    if not e > 0 or is_bvp(run) or scene.get("loading", {}).get("kind") == "platens":
        return {}
    limits = {**scene.get("packing", {}), **scene.get("preparation", {})}
    low, high = (limits.get(f"void_ratio_{k}", math.nan) for k in ("min", "max"))
    dense = {"Dr at start": f"{100 * (high - e) / (high - low):.0f} %"} if low < high else {}
    return {"e at start": f"{e:.4f}", **dense}


def broken(c):
    """What has broken: grains, and bonds where there are any."""
    texts = [f"{c['breakages'][-1]:.0f} grains"] if c["breakages"][-1] > 0 or "bonds" not in c else []
    if "bonds" in c or c.get("bonds_broken", [0])[-1] > 0:
        texts.append(f"{c['bonds_broken'][-1]:.0f} bonds")
    return ", ".join(texts)


RVE_COLUMNS = ("time_s", "axial_strain", "axial_stress_Pa", "grains", "breakages", "void_ratio", "energy_error",
               "unbalanced_force", "inertial_number", "elastic_J", "kinetic_J", "friction_J", "damping_J", "fracture_J",
               "split_J", "work_J")
BVP_COLUMNS = ("increment", "time_s", "newton_iterations", "residual", "breakages", "worst_rve_energy_error",
               *(f"mean_{q}" for ij in ("xx", "yy", "zz") for q in (f"strain_{ij}", f"stress_{ij}_Pa")))


def read_result(folder):
    """Name, columns and summary of a result folder. Throws OSError, ValueError where it is none."""
    if not os.path.isdir(folder):
        raise ValueError(f"{folder}: no such folder")
    if not os.path.exists(os.path.join(folder, "history.csv")):
        raise ValueError(f"{folder}: no history.csv in it: name a results folder of grus-rve or grus-bvp" +
                         ("; this one is of a study, which has its own report.html" if os.path.
                          isdir(os.path.join(folder, "runs")) else ""))
    columns = read_history(folder)
    path = os.path.join(folder, "summary.json")
    summary = {"ending": "no summary.json: it runs still, or was killed"}
    if os.path.exists(path):
        summary = read_summary(folder)
    if not all(isinstance(summary.get(k, {}), dict) for k in ("counts", "seconds")):
        raise ValueError(f"{path}: not a summary of Grus")
    missing = [c for c in (BVP_COLUMNS if "increment" in columns else RVE_COLUMNS) if c not in columns]
    if missing:
        raise ValueError(f"{os.path.join(folder, 'history.csv')}: no column {missing[0]}: not a history of Grus")
    try:
        summary["grading"] = read_grading(folder, summary.get("files")) if "increment" not in columns else {}
    except (ValueError, KeyError, TypeError, csv.Error) as e:
        raise ValueError(f"{os.path.join(folder, 'grading.csv')}: not a grading of Grus ({e})") from None
    summary["folder"] = folder
    return os.path.basename(os.path.abspath(folder)), columns, summary


def main():
    parser = argparse.ArgumentParser(prog="grus-report", description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="result folders of grus-rve or grus-bvp")
    parser.add_argument("-o", metavar="FILE", help="output (default: report.html in the first folder)")
    parser.add_argument("--force", action="store_true",
                        help="write over FILE whatever it is, unless a run has written it")
    parser.add_argument("--version", action="version", version=f"grus-report {__version__}")
    args = parser.parse_args()
    try:
        runs = [read_result(folder) for folder in args.folders]
    except OSError as e:
        print(one_line(f"grus-report: {e.filename}: {e.strerror}"), file=sys.stderr)
        return 2
    except ValueError as e:
        print(one_line(f"grus-report: {e}"), file=sys.stderr)
        return 2
    try:
        refuse_place(args.o or os.path.join(args.folders[0], REPORT), args.force)
        return write(runs, args)
    except CannotWrite as e:
        print(one_line(f"grus-report: {e}"), file=sys.stderr)
        return 2
    except Exception as e:  # one line for the user; the whole story for who asks
        if os.environ.get("GRUS_DEBUG"):
            raise
        print(one_line(f"grus-report: {type(e).__name__}: {e} (GRUS_DEBUG=1 shows where)"), file=sys.stderr)
        return 1


def section(title, plots):
    return f"<h2>{html.escape(title)}</h2><div class=\"plots\">{''.join(plots)}</div>" if plots else ""


def plots_of(runs):
    """What runs have in common, then each alone: of macro problems first."""
    rve, bvp = [r for r in runs if not is_bvp(r)], [r for r in runs if is_bvp(r)]
    body = section("Side by side", rve_plots.overlays(rve)) if rve else ""
    body += "".join(section(run[0], bvp_plots.of_run(run)) for run in bvp)
    return body + "".join(section(run[0], rve_plots.of_run(run)) for run in rve)


def notes_of(runs):
    told = [(name, note) for name, _, s in runs if isinstance(s.get("notes"), list) for note in s["notes"]]
    items = "".join(f"<li>{html.escape(name)}: {html.escape(str(note))}</li>" for name, note in told)
    return f"<h2>Notes</h2><ul>{items}</ul>" if told else ""


def scenes_of(runs):
    """summary.json of each run, to be unfolded; without what the report has read beside it."""
    body = "<h2>Scenes and figures of each run</h2>"
    for name, _, s in runs:
        told = json.dumps({key: v for key, v in s.items() if key not in ("grading", "folder")}, indent=1)
        head = f"{html.escape(name)}: {html.escape(str(s.get('title', '')))}"
        body += f"<details><summary>{head}</summary><pre>{html.escape(told)}</pre></details>"
    return body


def refuse_place(path, force):
    """Where a report cannot be: over anything but a report, without force."""
    if os.path.isdir(path):
        raise CannotWrite(f"{path}: cannot write: is a folder")
    try:
        with open(path, "rb") as f:
            own = TITLE.encode() in f.read(400)
    except OSError:
        own = False
    try:
        refuse_overwrite(path, force or own)
    except InputError as e:
        raise CannotWrite(str(e)) from None


def write(runs, args):
    rows = [facts(r) for r in runs]
    head = list(dict.fromkeys(key for r in rows for key in r))
    rows = [[r.get(key, "") for key in head] for r in rows]
    body = table(head, rows) + notes_of(runs) + plots_of(runs) + scenes_of(runs)
    print(text_table(head, rows), end="")
    path = args.o or os.path.join(args.folders[0], REPORT)
    if not args.o:
        note_result(args.folders[0], REPORT)
    try:
        write_whole(path, page(HEAD, body, style="", script=ZOOM))
    except OSError as e:
        raise CannotWrite(f"{path}: cannot write: {e.strerror}") from None
    print(f"report: {path}")
    return 0
