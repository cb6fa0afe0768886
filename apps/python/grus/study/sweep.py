# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[sweep]] of a study: a quantity against a key of the scene, with what the seeds leave open: table, sweep.csv,
plot."""
import html
import math
import os

from grus.figures import logarithmic, picture, plt, table as html_table
from grus.files.texts import text_table
from grus.files.writing import write_csv
from grus.runs.censored import strength_of
from grus.study import precision
from grus.study.precision_report import describe, percent, short

COLUMNS = [
    "sweep", "key", "value", "position", "mean", "interval", "sd", "change", "change_interval", "seeds", "status",
    "cpu_s"
]


def found(run, entry):
    """(value, bound) of a run: a key of summary.json, or a column as [[precision]] takes it. NaN: no value; it may be
    above the bound."""
    if "." in entry["quantity"]:
        return strength_of(run, entry["quantity"])
    return precision.measured(run["columns"], entry), math.nan


def judge(entry, table):
    """Rows of a sweep: `table` is a list of (value of the key, {seed: run}). Changes are signed, relative to the first
    value's mean; seed by seed where both have the same seeds. Where grains did not break there is a lower bound, not a
    mean."""
    rows, first = [], None
    for value, runs in table:
        by_seed = {seed: found(run, entry) for seed, run in runs.items()}
        reached = {seed: v for seed, (v, _) in by_seed.items() if not math.isnan(v)}
        larger = [bound for v, bound in by_seed.values() if math.isnan(v) and not math.isnan(bound)]
        least = precision.mean(list(reached.values()) + larger)
        lost = len(by_seed) - len(reached) - len(larger)
        known = reached if not larger else {}
        first = known if first is None else first
        common = sorted(set(known) & set(first))
        base = precision.mean(list(first.values()))
        middle, half = precision.interval(list(known.values()))
        off, open_ = precision.interval([known[s] - first[s] for s in common])
        scale = abs(base) or 1.0
        status = ",".join(sorted({str(r["summary"]["status"]) for r in runs.values()}))
        status += f" ({lost} not reached)" if lost else ""
        status += f" ({len(larger)} of {len(by_seed)} not broken: at least {least:.4g})" if larger else ""
        rows.append({"value": value, "mean": middle, "interval": half, "found": list(reached.values()),
                     "larger": larger, "least": least, "change": off / scale,
                     "sd": precision.deviation(list(known.values())) if known else math.nan,
                     "change_interval": open_ / scale if len(common) > 1 else math.nan,
                     "seeds": len(reached), "status": status,
                     "cpu_s": precision.mean([precision.cost(r)["cpu"] for r in runs.values()])})
    return rows


def numbers(rows):
    """Places on the axis, and their names where they are no numbers."""
    values = [r["value"] for r in rows]
    if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values):
        return values, None
    return list(range(len(values))), [str(v) for v in values]


def plot(entry, judged):
    """One line for each position, bars: 95 % interval over seeds, dots: the seeds."""
    fig, ax = plt.subplots(figsize=(7, 4.6))
    for k, (part, rows) in enumerate(judged):
        x, names = numbers(rows)
        scale = entry.get("scale", 1.0)
        bars = [0 if math.isnan(r["interval"]) else scale * r["interval"] for r in rows]
        ax.errorbar(x, [scale * r["mean"] for r in rows], yerr=bars, fmt="o-", ms=4, lw=1.2, capsize=3, color=f"C{k}",
                    label=place(part))
        for position, r in zip(x, rows):
            ax.plot([position] * len(r["found"]), [scale * v for v in r["found"]], ".", ms=3, color=f"C{k}", alpha=0.5)
            beyond = [scale * v for v in r["larger"]]
            ax.plot([position] * len(beyond), beyond, "^", ms=4, color=f"C{k}", alpha=0.5)  # stronger than that
        if names:
            ax.set_xticks(x, names, fontsize=8)
    logarithmic(ax, entry)
    ax.set(xlabel=entry.get("xlabel", entry["key"]), ylabel=entry.get("ylabel", entry["quantity"]), title=entry["name"])
    ax.legend(fontsize=8)
    return fig


def place(part):
    return part["quantity"] if "." in part["quantity"] else describe(part)


def parts(entry):
    """One entry for each position of `at`."""
    return [{**entry, "at": at} for at in entry["at"]] if isinstance(entry.get("at"), list) else [entry]


def write(sweeps, out):
    """sweeps: (entry, [(value, {seed: run})]) pairs. Text and HTML of all; sweep.csv and a plot each."""
    text = body = ""
    lines = []
    for number, (entry, table) in enumerate(sweeps):
        judged = [(part, judge(part, table)) for part in parts(entry)]
        head = [entry["key"], "where", "mean", "95 % interval", "change", "its interval", "seeds", "status", "CPU s"]
        rows = []
        for part, values in judged:
            for r in values:
                middle = f"> {r['least']:.6g}" if r["larger"] else f"{r['mean']:.6g}"
                half = "-" if math.isnan(r["interval"]) else f"{r['interval']:.3g}"
                rows.append([short(r["value"]), place(part), middle, half, signed(r["change"]),
                             percent(r["change_interval"]), r["seeds"], r["status"], f"{r['cpu_s']:.3g}"])
                lines.append([entry["name"], entry["key"], r["value"], place(part)] + [r[c] for c in COLUMNS[4:]])
        text += f"\n{entry['name']}\n" + text_table(head, rows)
        body += f"<h2>{html.escape(entry['name'])}</h2>" + html_table(head, rows) + picture(
            plot(entry, judged), out, f"sweep_{number}")
    write_csv(os.path.join(out, "sweep.csv"), [COLUMNS] + lines)
    return text, body


def signed(x):
    return "-" if math.isnan(x) else f"{100 * x:+.2g} %"
