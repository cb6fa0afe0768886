# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[sweep]] of a study: a quantity against a key of the scene, with what the seeds leave open: table, sweep.csv, plot."""
import html
import math
import os

import grus_precision as precision
from grus_precision_report import describe, percent, short
from grus_results import write_csv
from grus_study_report import html_table, logarithmic, of_summary, picture, plt, text_table

COLUMNS = ["sweep", "key", "value", "position", "mean", "interval", "sd", "change", "change_interval", "seeds", "status", "cpu_s"]


def found(run, entry):
    """The quantity of a run: a key of summary.json, or a column as [[precision]] takes it."""
    return of_summary(run, entry["quantity"]) if "." in entry["quantity"] else precision.measured(run["columns"], entry)


def judge(entry, table):
    """Rows of a sweep: `table` is a list of (value of the key, {seed: run}). Changes are signed, relative to the first value's mean;
    seed by seed where both have the same seeds."""
    rows, first = [], None
    for value, runs in table:
        by_seed = {seed: found(run, entry) for seed, run in runs.items()}
        reached = {seed: v for seed, v in by_seed.items() if not math.isnan(v)}
        first = reached if first is None else first
        common = sorted(set(reached) & set(first))
        base = precision.mean(list(first.values()))
        middle, half = precision.interval(list(reached.values()))
        off, open_ = precision.interval([reached[s] - first[s] for s in common])
        scale = abs(base) or 1.0
        rows.append({"value": value, "mean": middle, "interval": half, "sd": precision.deviation(list(reached.values())), "found": list(reached.values()), "change": off / scale,
                     "change_interval": open_ / scale if len(common) > 1 else math.nan, "seeds": len(reached), "cpu_s": precision.mean([precision.cost(r)["cpu"] for r in runs.values()]),
                     "status": ",".join(sorted({str(r["summary"]["status"]) for r in runs.values()})) + ("" if len(reached) == len(by_seed) else f" ({len(by_seed) - len(reached)} not reached)")})
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
        ax.errorbar(x, [scale * r["mean"] for r in rows], yerr=bars, fmt="o-", ms=4, lw=1.2, capsize=3, color=f"C{k}", label=place(part))
        for position, r in zip(x, rows):
            ax.plot([position] * len(r["found"]), [scale * v for v in r["found"]], ".", ms=3, color=f"C{k}", alpha=0.5)
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
                rows.append([short(r["value"]), place(part), f"{r['mean']:.6g}", "-" if math.isnan(r["interval"]) else f"{r['interval']:.3g}", signed(r["change"]), percent(r["change_interval"]), r["seeds"],
                             r["status"], f"{r['cpu_s']:.3g}"])
                lines.append([entry["name"], entry["key"], r["value"], place(part)] + [r[c] for c in COLUMNS[4:]])
        text += f"\n{entry['name']}\n" + text_table(head, rows)
        body += f"<h2>{html.escape(entry['name'])}</h2>" + html_table(head, rows) + picture(plot(entry, judged), out, f"sweep_{number}")
    write_csv(os.path.join(out, "sweep.csv"), [COLUMNS] + lines)
    return text, body


def signed(x):
    return "-" if math.isnan(x) else f"{100 * x:+.2g} %"
