# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[precision]]: error against run time. What settings cost, how far their results are from a reference, and what the
scatter over seeds leaves open; precision.csv, a table and a plot each."""
import html
import itertools
import math
import os
import sys

from grus.errors import InputError
from grus.figures import picture, plain, plt, table as html_table
from grus.files.tables import Columns
from grus.files.texts import one_line, text_table
from grus.files.writing import write_csv
from grus.runs.schema import AT, MEASURE, POSITIVE, SEEDS, SETTINGS, TEXT, tables
from grus.study.numbers import cost, energy_error, finished, measured, statuses, unfinished_mark
from grus.study.statistics import difference, interval, mean, power_law
from grus.study.tables import Shown, shared_by_cases, unnamed_case
from grus.study.words import describe, percent, short

NAME = "precision"
SCHEMA = tables({
    "name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "label": TEXT, "quantity": TEXT, "measure": MEASURE,
    "vary": {"type": "object", "minProperties": 1, "additionalProperties": {"type": "array", "minItems": 1}},
    "reference": {"type": ["string", "number", "object"]}, "at": AT, "over": TEXT, "paired": {"type": "boolean"},
    "order": {"type": "boolean"}, "scale": POSITIVE
}, ("name", "vary", "quantity"))
TARGETS = (0.1, 0.01, 0.001)
WORDS = ("Error: how far the mean over the seeds is from the reference, of the reference; its 95 % interval is what "
         "the seeds leave open of it. Scatter of the mean: the same of the value itself. Front: no other setting is "
         "both cheaper and nearer. “For 1 %”: the cheapest setting whose error is below that, its interval added.")
COLUMNS = ["error", "signed", "interval", "scatter", "seeds", "status", "value", "cpu", "wall", "grain_steps", "rves",
           "energy"]


def read(given, reading):
    return [entry for k, table in enumerate(given) for entry in read_one(k, table, reading)]


def read_one(k, table, reading):
    """Entries of one [[precision]]: one for each position of `at`. Each carries its cases: the settings, then the
    reference."""
    where, folder = f"{reading.path}: precision {table.get('name', k)}", reading.folder
    how = table.get("measure", "at")
    if how == "at" and "at" not in table:
        raise InputError(f"{where}: needs 'at', or a measure (peak, last, area)")
    reference = table.get("reference", "finest")
    if isinstance(reference, str) and reference != "finest":
        raise InputError(f"{where}: reference: \"finest\", a number, a table of settings, or {{ file = \"...\" }}")
    if isinstance(reference, dict) and "file" in reference:
        try:
            known_reference({**table, "at": 0.0}, folder)
        except (OSError, TypeError) as e:
            raise InputError(f"{where}: reference: cannot read {reference['file']!r}: {e}") from None
        except ValueError as e:
            raise InputError(f"{where}: reference: {e}") from None
    base, fixed = shared_by_cases(where, table, reading)
    reference = reference_settings(table)
    rows = [s for s in settings(table) if s != reference]
    if not rows:
        raise InputError(f"{where}: nothing to compare with the reference")
    table = {**table, "folder": folder, "rows": [(s, unnamed_case(base, fixed, s)) for s in rows],
             "reference_case": unnamed_case(base, fixed, reference) if reference is not None else None}
    if how != "at" or not isinstance(table["at"], list):
        return [table]
    return [{**table, "at": at, "name": f"{table['name']}, at {at:g}"} for at in table["at"]]


def cases(entry):
    return [case for _, case in entry["rows"]] + ([entry["reference_case"]] if entry["reference_case"] else [])


def asks(entry, _common):
    columns = {entry["quantity"]}
    if entry.get("measure", "at") in ("at", "area"):
        columns.add(entry.get("over", "axial_strain"))
    return [(case["name"], columns, set()) for case in cases(entry)]


def settings(entry):
    """The combinations of the varied keys, first key slowest."""
    keys = list(entry["vary"])
    return [dict(zip(keys, values)) for values in itertools.product(*(entry["vary"][k] for k in keys))]


def reference_settings(entry):
    """Settings of the reference runs; None if the reference is known."""
    reference = entry.get("reference", "finest")
    if reference == "finest":
        return settings(entry)[-1]
    return reference if isinstance(reference, dict) and "file" not in reference else None


def known_reference(entry, folder):
    reference = entry["reference"]
    if not isinstance(reference, dict):
        return float(reference)
    column = reference.get("column", entry["quantity"])
    columns = Columns(os.path.join(folder, reference["file"]), {column: entry["quantity"]})
    return measured(columns, {**entry, "quantity": column})


def pareto(points):
    """Indices of the (cost, error) pairs that no other beats in both, by cost."""
    front, best = [], math.inf
    for k in sorted(range(len(points)), key=lambda k: points[k]):
        if points[k][1] < best:
            front.append(k)
            best = points[k][1]
    return front


def bound(row):
    """What the error may be: the bias and what its interval leaves open."""
    return row["error"] + (0 if math.isnan(row["interval"]) else row["interval"])


def sound(row):
    """Every run got to its end, and as far as is asked."""
    return row["status"] == "0"


def recommended(rows):
    """For each target the cheapest row whose error, interval included, is below; None where none is."""
    found = {}
    for target in TARGETS:
        good = [r for r in rows if sound(r) and bound(r) <= target]
        found[target] = min(good, key=lambda r: r["cpu"]) if good else None
    return found


def judge(entry, table, reference_runs, folder, stopped=None):
    """Rows of a study: `table` is a list of (settings, runs by seed). Errors are relative to the reference. Runs
    that did not finish are left out, and told: of the table, or `stopped`, a list for each of its rows."""
    paired = reference_runs is not None and entry.get("paired", True)
    reference = [measured(r["columns"], entry)
                 for r in reference_runs] if reference_runs is not None else [known_reference(entry, folder)]
    scale = entry.get("scale", abs(mean(reference)) or 1.0)
    rows = []
    for k, (values, some) in enumerate(table):
        runs = [*some, *(stopped[k] if stopped else [])]
        good = [r for r in runs if finished(r)]
        found = [measured(r["columns"], entry) for r in good]
        off, half = difference(found, reference, paired)
        costs = [cost(r) for r in good or runs]
        row = {
            "settings": values, "value": mean(found), "error": abs(off) / scale, "signed": off / scale,
            "interval": half / scale, "scatter": interval(found)[1] / scale, "seeds": len(good),
            "energy": max(energy_error(r) for r in good or runs),
            "status": statuses(runs)
        }
        for name in costs[0]:
            row[name] = mean([c[name] for c in costs])
        if math.isnan(row["error"]):
            row["error"] = math.inf
            row["status"] += " (not reached)" if good else ""
        row["status"] += unfinished_mark(runs)
        rows.append(row)
    result = {
        "rows": rows, "reference": mean(reference),
        "front": pareto([(r["cpu"], bound(r) if sound(r) else math.inf) for r in rows]),
        "recommended": recommended(rows), "order": None
    }
    keys = list(entry["vary"])
    if len(keys) == 1 and entry.get("order", True) and all(isinstance(v, (int, float)) for v in entry["vary"][keys[0]]):
        clear = [
            r for r in rows
            if sound(r) and math.isfinite(r["error"]) and (math.isnan(r["interval"]) or r["error"] > r["interval"])
        ]
        result["order"] = power_law([(r["settings"][keys[0]], r["error"]) for r in clear])
    return result


def judged(entry, done):
    """(entry, what its runs say) of the runs that are there; None where nothing is left to compare."""
    c = entry["reference_case"]
    every = {k["name"]: done.by_seed(k) for k in cases(entry)}
    found = {name: {seed: r for seed, r in by_seed.items() if finished(r)} for name, by_seed in every.items()}
    stopped = {name: [r for seed, r in by_seed.items() if seed not in found[name]] for name, by_seed in every.items()}
    # Runs that failed are left out; where seeds are compared one by one, the others of their seed too.
    paired = c is not None and entry.get("paired", True)
    common_seeds = set.intersection(*(set(r) for r in found.values() if r)) if paired and any(found.values()) else None
    kept = {
        name: [r for seed, r in by_seed.items() if not paired or seed in (common_seeds or ())]
        for name, by_seed in found.items()
    }
    rows = [(s, k["name"]) for s, k in entry["rows"] if kept[k["name"]] or stopped[k["name"]]]
    if not any(kept[name] for _, name in rows) or (c and not kept[c["name"]]):
        return None
    return entry, judge(entry, [(s, kept[name]) for s, name in rows], kept[c["name"]] if c else None, entry["folder"],
                        [stopped[name] for _, name in rows])


def setting_text(values):
    return ", ".join(f"{k.split('.')[-1]} {short(v)}" for k, v in values.items())


def signed(row):
    """The error with its sign: too much, or too little."""
    if not math.isfinite(row["error"]) or row["error"] == 0:
        return percent(row["error"])
    return f"{100 * row['signed']:+.2g} %"


def plot(entry, result):
    fig, ax = plt.subplots(figsize=(7, 4.6))
    rows = [r for r in result["rows"] if math.isfinite(r["error"])]
    least = min([r["error"] for r in rows if r["error"] > 0], default=1e-16)
    for r in rows:
        y, half = 100 * max(r["error"], 0.1 * least), r["interval"]
        bars = None if math.isnan(half) else [[min(100 * half, 0.999 * y)], [100 * half]]
        ax.errorbar(r["cpu"], y, yerr=bars, fmt="o", ms=4, color="C0", ecolor="0.7", capsize=2)
    front = [result["rows"][k] for k in result["front"] if math.isfinite(bound(result["rows"][k]))]
    if not rows:
        ax.text(0.5, 0.5, "no run got that far", transform=ax.transAxes, ha="center")
        return fig
    edge = [100 * max(bound(r), 0.1 * least) for r in front]
    ax.step([r["cpu"] for r in front], edge, where="post", color="C3", lw=1.2, label="Pareto front (error + interval)")
    middle = math.sqrt(min(r["cpu"] for r in rows) * max(r["cpu"] for r in rows))
    for r, y in zip(front, edge):  # inside the axes, whatever side the point is on
        late = r["cpu"] > middle
        ax.annotate(setting_text(r["settings"]), (r["cpu"], y), fontsize=6, xytext=(-4 if late else 4, 4),
                    textcoords="offset points", ha="right" if late else "left")
    ax.margins(0.08, 0.12)
    ax.set(xscale="log", yscale="log", xlabel="CPU time of a run (s)",
           ylabel="error (%), bars: 95 % interval over seeds", title=entry["name"])
    plain(ax.xaxis), plain(ax.yaxis)
    ax.legend(fontsize=8)
    return fig


def reference_text(entry):
    values = reference_settings(entry)
    return "known" if values is None else setting_text(values)


def show(entries, done):
    studies = []
    for entry in entries:
        result = judged(entry, done)
        if result:
            studies.append(result)
        else:
            print(f"grus-study: {one_line(entry['name'])}: no run is left to compare", file=sys.stderr)
    if not studies:
        return Shown()
    lines = [["study", "settings", *COLUMNS]]
    for entry, r in ((entry, r) for entry, result in studies for r in result["rows"]):
        values = [repr(r[c]) if isinstance(r[c], float) else r[c] for c in COLUMNS]
        lines.append([entry["name"], setting_text(r["settings"]), *values])
    write_csv(os.path.join(done.out, "precision.csv"), lines)
    text, body = "", f"<p>{WORDS}</p>"
    for number, (entry, result) in enumerate(studies):
        added = show_one(entry, result)
        text += added.text
        body += added.body + picture(plot(entry, result), done.out, f"precision_{number}")
    return Shown(text, body)


def show_one(entry, result):
    head = [setting_text({k: "" for k in entry["vary"]}), "value", "error", "95 % interval", "scatter of the mean",
            "seeds", "CPU s", "wall s", "grain-steps", "RVEs", "energy error", "status", "front"]
    rows = [[
        ", ".join(short(v) for v in r["settings"].values()), f"{r['value']:.6g}",
        signed(r),
        percent(r["interval"]),
        percent(r["scatter"]), r["seeds"], f"{r['cpu']:.3g}", f"{r['wall']:.3g}", f"{r['grain_steps']:.3g}",
        f"{r['rves']:g}",
        percent(r["energy"]), r["status"], "*" if k in result["front"] else ""
    ] for k, r in enumerate(result["rows"])]
    lines = [f"{describe(entry)}; reference {result['reference']:.6g} ({entry.get('label', reference_text(entry))})"]
    if result["order"]:
        order, error = result["order"]
        lines.append(f"observed order in {list(entry['vary'])[0]}: {order:.2f} ± {error:.2g}")
    for target, r in result["recommended"].items():
        best = f"{setting_text(r['settings'])} ({r['cpu']:.3g} s)" if r else "none of these"
        lines.append(f"for {100 * target:g} %: {best}")
    said = "<br>".join(map(html.escape, lines))
    return Shown(f"\n{entry['name']}\n" + "\n".join(lines) + "\n" + text_table(head, rows),
                 f"<h2>{html.escape(entry['name'])}</h2><p>{said}</p>" + html_table(head, rows))
