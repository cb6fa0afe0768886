# SPDX-License-Identifier: LGPL-3.0-or-later
"""Work-precision tables, plots and recommendations of a study."""
import html
import math
import os

from grus.figures import picture, plt, table as html_table
from grus.files.texts import text_table
from grus.files.writing import write_csv
from grus.study import precision

COLUMNS = [
    "error", "signed", "interval", "scatter", "seeds", "status", "value", "cpu", "wall", "grain_steps", "rves", "energy"
]


def short(v):
    return f"{v:.4g}" if isinstance(v, float) else str(v)


def setting_text(values):
    return ", ".join(f"{k.split('.')[-1]} {short(v)}" for k, v in values.items())


def percent(x):
    return "-" if math.isnan(x) else f"{100 * x:.2g} %" if math.isfinite(x) else "not reached"


def signed(row):
    """The error with its sign: too much, or too little."""
    return percent(
        row["error"]) if not math.isfinite(row["error"]) or row["error"] == 0 else f"{100 * row['signed']:+.2g} %"


def plot(entry, result):
    fig, ax = plt.subplots(figsize=(7, 4.6))
    rows = [r for r in result["rows"] if math.isfinite(r["error"])]
    least = min([r["error"] for r in rows if r["error"] > 0], default=1e-16)
    for r in rows:
        y, half = 100 * max(r["error"], 0.1 * least), r["interval"]
        bars = None if math.isnan(half) else [[min(100 * half, 0.999 * y)], [100 * half]]
        ax.errorbar(r["cpu"], y, yerr=bars, fmt="o", ms=4, color="C0", ecolor="0.7", capsize=2)
    front = [result["rows"][k] for k in result["front"] if math.isfinite(precision.bound(result["rows"][k]))]
    if not rows:
        ax.text(0.5, 0.5, "no run got that far", transform=ax.transAxes, ha="center")
        return fig
    edge = [100 * max(precision.bound(r), 0.1 * least) for r in front]
    ax.step([r["cpu"] for r in front], edge, where="post", color="C3", lw=1.2, label="Pareto front (error + interval)")
    middle = math.sqrt(min(r["cpu"] for r in rows) * max(r["cpu"] for r in rows))
    for r, y in zip(front, edge):  # inside the axes, whatever side the point is on
        late = r["cpu"] > middle
        ax.annotate(setting_text(r["settings"]), (r["cpu"], y), fontsize=6, xytext=(-4 if late else 4, 4),
                    textcoords="offset points", ha="right" if late else "left")
    ax.margins(0.08, 0.12)
    ax.set(xscale="log", yscale="log", xlabel="CPU time of a run (s)",
           ylabel="error (%), bars: 95 % interval over seeds", title=entry["name"])
    ax.legend(fontsize=8)
    return fig


def describe(entry):
    how = entry.get("measure", "at")
    where = f" at {entry.get('over', 'axial_strain')} {entry['at']:g}" if how == "at" else ""
    return f"{entry['quantity']}{where}" + ("" if how == "at" else f", {how}")


def write(studies, out):
    """studies: (entry, result) pairs. Text and HTML of all; precision.csv and a plot each."""
    text = body = ""
    lines = [[entry["name"], setting_text(r["settings"])] +
             [repr(r[c]) if isinstance(r[c], float) else r[c] for c in COLUMNS] for entry, result in studies
             for r in result["rows"]]
    write_csv(os.path.join(out, "precision.csv"), [["study", "settings"] + COLUMNS] + lines)
    for number, (entry, result) in enumerate(studies):
        head = [
            setting_text({k: "" for k in entry["vary"]}), "value", "error", "95 % interval", "scatter of the mean",
            "seeds", "CPU s", "wall s", "grain-steps", "RVEs", "energy error", "status", "front"
        ]
        rows = [[
            ", ".join(short(v) for v in r["settings"].values()), f"{r['value']:.6g}",
            signed(r),
            percent(r["interval"]),
            percent(r["scatter"]), r["seeds"], f"{r['cpu']:.3g}", f"{r['wall']:.3g}", f"{r['grain_steps']:.3g}",
            f"{r['rves']:g}",
            percent(r["energy"]), r["status"], "*" if k in result["front"] else ""
        ] for k, r in enumerate(result["rows"])]
        lines = [
            f"{describe(entry)}; reference {result['reference']:.6g} ({entry.get('label', reference_text(entry))})"
        ]
        if result["order"]:
            lines.append(
                f"observed order in {list(entry['vary'])[0]}: {result['order'][0]:.2f} ± {result['order'][1]:.2g}")
        for target, r in result["recommended"].items():
            lines.append(f"for {100 * target:g} %: " +
                         (f"{setting_text(r['settings'])} ({r['cpu']:.3g} s)" if r else "none of these"))
        text += f"\n{entry['name']}\n" + "\n".join(lines) + "\n" + text_table(head, rows)
        body += f"<h2>{html.escape(entry['name'])}</h2><p>" + "<br>".join(map(
            html.escape, lines)) + "</p>" + html_table(head, rows) + picture(plot(entry, result), out,
                                                                             f"precision_{number}")
    return text, body


def reference_text(entry):
    values = precision.reference_settings(entry)
    return "known" if values is None else setting_text(values)
