# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[sweep]]: a quantity against a key of the scene, with what the seeds leave open: table, sweep.csv, plot."""
import html
import math
import os

from grus.errors import InputError
from grus.figures import logarithmic, picture, plt, table as html_table
from grus.files.texts import text_table
from grus.files.writing import write_csv
from grus.runs.censored import strength_of
from grus.runs.schema import AT, MEASURE, NUMBER, SEEDS, SETTINGS, TEXT, tables
from grus.study.numbers import cost, finished, measured, statuses, unfinished_mark
from grus.study.statistics import deviation, interval, mean
from grus.study.tables import Shown, shared_by_cases, unnamed_case
from grus.study.words import describe, percent, short

NAME = "sweep"
SCHEMA = tables({
    "name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "key": TEXT, "quantity": TEXT, "measure": MEASURE,
    "values": {"type": "array", "minItems": 2}, "at": AT, "over": TEXT, "scale": NUMBER, "log": {"type": "boolean"},
    "log_x": {"type": "boolean"}, "xlabel": TEXT, "ylabel": TEXT
}, ("name", "key", "values", "quantity"))
COLUMNS = ["sweep", "key", "value", "position", "mean", "interval", "sd", "change", "change_interval", "seeds",
           "status", "cpu_s"]


def read(given, reading):
    return [read_one(table, reading) for table in given]


def read_one(table, reading):
    """A [[sweep]] with a case for each value of its key."""
    where = f"{reading.path}: sweep {table['name']}"
    if "." not in table["quantity"] and table.get("measure", "at") == "at" and "at" not in table:
        raise InputError(f"{where}: needs 'at', or a measure (peak, last, area), or a quantity of summary.json")
    base, fixed = shared_by_cases(where, table, reading)
    return {**table, "rows": [(v, unnamed_case(base, fixed, {table["key"]: v})) for v in table["values"]]}


def cases(entry):
    return [case for _, case in entry["rows"]]


def asks(entry, _common):
    if "." in entry["quantity"]:
        return [(case["name"], set(), {entry["quantity"]}) for case in cases(entry)]
    columns = {entry["quantity"]}
    if entry.get("measure", "at") in ("at", "area"):
        columns.add(entry.get("over", "axial_strain"))
    return [(case["name"], columns, set()) for case in cases(entry)]


def found(run, entry):
    """(value, bound) of a run: a key of summary.json, or a column as [[precision]] takes it. NaN: no value; it may be
    above the bound."""
    if "." in entry["quantity"]:
        return strength_of(run, entry["quantity"])
    return measured(run["columns"], entry), math.nan


def judge(entry, table):
    """Rows of a sweep: `table` is a list of (value of the key, {seed: run}). Changes are signed, relative to the first
    value's mean; seed by seed where both have the same seeds. Where grains did not break there is a lower bound, not a
    mean. Runs that did not finish are left out, and told."""
    rows, first = [], None
    for value, runs in table:
        by_seed = {seed: found(run, entry) for seed, run in runs.items() if finished(run)}
        reached = {seed: v for seed, (v, _) in by_seed.items() if not math.isnan(v)}
        larger = [bound for v, bound in by_seed.values() if math.isnan(v) and not math.isnan(bound)]
        least = mean(list(reached.values()) + larger)
        lost = len(by_seed) - len(reached) - len(larger)
        known = reached if not larger else {}
        first = known if first is None else first
        common = sorted(set(known) & set(first))
        base = mean(list(first.values()))
        middle, half = interval(list(known.values()))
        off, open_ = interval([known[s] - first[s] for s in common])
        scale = abs(base) or 1.0
        status = statuses(runs.values())
        status += f" ({lost} not reached)" if lost else ""
        status += unfinished_mark(runs.values())
        status += f" ({len(larger)} of {len(by_seed)} not broken: at least {least:.4g})" if larger else ""
        rows.append({"value": value, "mean": middle, "interval": half, "found": list(reached.values()),
                     "larger": larger, "least": least, "change": off / scale,
                     "sd": deviation(list(known.values())),
                     "change_interval": open_ / scale if len(common) > 1 else math.nan,
                     "seeds": len(reached), "status": status,
                     "cpu_s": mean([cost(r)["cpu"] for r in runs.values()])})
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


def signed(x):
    return "-" if math.isnan(x) else f"{100 * x:+.2g} %"


def show(entries, done):
    sweeps = []
    for entry in entries:
        table = [(value, done.by_seed(case)) for value, case in entry["rows"]]
        table = [(value, runs) for value, runs in table if runs]
        if table:
            sweeps.append((entry, [(part, judge(part, table)) for part in parts(entry)]))
    if not sweeps:
        return Shown()
    text, body, lines = "", "", []
    for number, (entry, judged) in enumerate(sweeps):
        head = [entry["key"], "where", "mean", "95 % interval", "change", "its interval", "seeds", "status", "CPU s"]
        rows = []
        for part, r in ((part, r) for part, values in judged for r in values):
            middle = f"> {r['least']:.6g}" if r["larger"] else f"{r['mean']:.6g}"
            half = "-" if math.isnan(r["interval"]) else f"{r['interval']:.3g}"
            rows.append([short(r["value"]), place(part), middle, half, signed(r["change"]),
                         percent(r["change_interval"]), r["seeds"], r["status"], f"{r['cpu_s']:.3g}"])
            lines.append([entry["name"], entry["key"], r["value"], place(part), *(r[c] for c in COLUMNS[4:])])
        text += f"\n{entry['name']}\n" + text_table(head, rows)
        body += f"<h2>{html.escape(entry['name'])}</h2>" + html_table(head, rows)
        body += picture(plot(entry, judged), done.out, f"sweep_{number}")
    write_csv(os.path.join(done.out, "sweep.csv"), [COLUMNS, *lines])
    return Shown(text, body)
