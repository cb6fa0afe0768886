# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of a report: vector pictures with a text that says what they show, legends beside the curves, axes that
fit."""
import base64
import html
import io
import json
import math
import os

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["text.parse_math"] = False  # names are the user's, not formulas
matplotlib.rcParams["svg.hashsalt"] = "grus"  # the same figure, the same file
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import MaxNLocator  # noqa: E402

from grus.files.writing import write_whole  # noqa: E402

STYLE = """body{font:15px/1.5 sans-serif;max-width:1460px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}.wide{overflow-x:auto}
td,th{border:1px solid #ccc;padding:.3em .8em;text-align:left;white-space:nowrap}
th{background:#f2f0ea}pre{background:#f7f7f7;padding:1em;overflow:auto}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,560px),1fr));gap:.6em}
figure{margin:0;position:relative}figure>svg{width:100%;height:auto;touch-action:pan-y}
h1,h2,li,td.text{overflow-wrap:anywhere}
figure.large{grid-column:1/-1}figure>button{position:absolute;right:0;top:0;border:0;background:none;opacity:.5}"""
with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "plots.js"), encoding="utf-8") as f:
    ZOOM = f"""<script>{f.read()}
for (const f of document.querySelectorAll("figure[data-plot]")) {{
  grusPlots.follow(f, JSON.parse(f.dataset.plot))
  const b = f.appendChild(document.createElement("button"))
  b.textContent = "⤢", b.title = "larger", b.onclick = () => f.classList.toggle("large")
}}</script>"""
UNITS = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
POINTS = 300  # of a curve that tells its values


def figure(draw, width=7.4, height=4.2):
    """What draw(ax) draws, as <figure>. The text for who cannot see it comes from title, axes and curves."""
    fig, ax = plt.subplots(figsize=(width, height))
    draw(ax)
    if ax.axison:
        ax.grid(alpha=0.3)
    fig.draw_without_rendering()
    around = fig.get_tightbbox(fig.canvas.get_renderer()).padded(0.1)
    data = io.BytesIO()
    fig.savefig(data, format="svg", bbox_inches=around, dpi=160,
                metadata={"Date": None})  # dpi: of what is painted, not drawn
    text, told = alt_text(fig.axes), json.dumps(values(fig.axes, around))
    plt.close(fig)
    size = f"{72 * around.width:.2f} {72 * around.height:.2f}"
    wide, high = size.split()
    return (f'<figure data-plot="{html.escape(told, quote=True)}"><svg viewBox="0 0 {size}" role="img" '
            f'aria-label="{html.escape(text, quote=True)}"><title>{html.escape(text.partition(";")[0])}</title>'
            f'<image width="{wide}" height="{high}" '
            f'href="data:image/svg+xml;base64,{base64.b64encode(data.getvalue()).decode()}"/></svg></figure>')


def values(axes, around):
    """What plots.js must know of a drawn figure, whose picture is `around` (inches): the place of the axes in it
    (points from its upper left), limits, scales, curves. A second axis has limits of its own."""
    first = axes[0]
    box = first.bbox.transformed(first.figure.dpi_scale_trans.inverted())
    places = [box.x0 - around.x0, around.y1 - box.y1, box.x1 - around.x0, around.y1 - box.y0]
    series = []
    for ax in axes:
        own = {} if ax is first else {"limits": list(ax.get_ylim()), "log": ax.get_yscale() == "log"}
        for line in ax.get_lines() if first.axison else []:
            name = str(line.get_label())
            points = [(float(f"{x:.5g}"), float(f"{y:.5g}")) for x, y in zip(*line.get_data(orig=False))
                      if math.isfinite(x) and math.isfinite(y)]
            points = points[::-max(1, math.ceil(len(points) / POINTS))][::-1]
            if points:
                series.append({"label": "" if name.startswith("_") else name, "x": [p[0] for p in points],
                               "y": [p[1] for p in points], **own})
    return {"box": [round(72 * v, 2) for v in places] if first.axison else [0, 0, 0, 0], "x": list(first.get_xlim()),
            "y": list(first.get_ylim()), "log_x": first.get_xscale() == "log", "log": first.get_yscale() == "log",
            "series": series}


def unit_of(*columns):
    """(how much it is, name) of the unit of stress in which the largest value is 1 to 1000."""
    largest = max((abs(v) for c in columns for v in c if math.isfinite(v)), default=0.0)
    return next((u for u in UNITS if largest >= u[0]), UNITS[1] if largest == 0 else UNITS[-1])


def told_as(name, *columns):
    """(how much its unit is, what people call it): a column or key, in the unit that its values want; the name as it is
    where it tells no unit."""
    plain = name.rsplit(".", 1)[-1]
    stem, _, unit = plain.rpartition("_")
    if not stem:
        return 1.0, plain
    if unit == "Pa":
        much, unit = unit_of(*columns)
    elif unit == "m":
        much, unit = 1e-3, "mm"
    elif unit in ("N", "J", "s", "kg"):
        much = 1.0
    else:
        return 1.0, plain.replace("_", " ")
    return much, f"{stem.replace('_', ' ')} ({unit})"


def by_scale(items, size, factor=8.0):
    """Items in groups whose sizes differ by less than `factor`: what is smaller would be a flat line beside them. In
    the order of the first of each."""
    groups = []
    for item in sorted(items, key=size, reverse=True):
        if not groups or size(groups[-1][0]) > factor * size(item):
            groups.append([])
        groups[-1].append(item)
    place = {id(item): k for k, item in enumerate(items)}
    groups = [sorted(group, key=lambda item: place[id(item)]) for group in groups]
    return sorted(groups, key=lambda group: place[id(group[0])])


def picture(fig, out, name):
    """A figure as <img>, and as plots/`name`.png of a results folder."""
    os.makedirs(os.path.join(out, "plots"), exist_ok=True)
    buffer = io.BytesIO()
    fig.savefig(buffer, format="png", dpi=110, bbox_inches="tight")
    text = alt_text(fig.axes)
    plt.close(fig)
    write_whole(os.path.join(out, "plots", name + ".png"), buffer.getvalue())
    return (f'<img alt="{html.escape(text, quote=True)}" '
            f'src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">')


def alt_text(axes):
    first = axes[0]
    parts = [first.get_title() or "figure"]
    for ax in axes:
        if ax.axison and ax.get_xlabel():
            parts.append(f"{ax.get_ylabel() or 'values'} against {ax.get_xlabel()}")
    names = [label for ax in axes for label in ax.get_legend_handles_labels()[1]]
    if names:
        parts.append("curves: " + ", ".join(dict.fromkeys(names)))
    ends = [
        f"{line.get_label()} from {line.get_ydata()[0]:.4g} to {line.get_ydata()[-1]:.4g}"
        for line in first.get_lines() if len(line.get_ydata()) > 1 and not str(line.get_label()).startswith("_")
    ][:4]
    return "; ".join(parts + ends)


def legend(*axes, size=8):
    """One legend of all axes, to the right of the plot, where it covers nothing."""
    found = [pair for ax in axes for pair in zip(*ax.get_legend_handles_labels())]
    if found:
        axes[0].legend(*zip(*found), fontsize=size, loc="upper left",
                       bbox_to_anchor=(1.16 if len(axes) > 1 else 1.01, 1), borderaxespad=0, frameon=False)


def counts(axis):
    """Whole numbers alone on an axis that counts."""
    axis.set_major_locator(MaxNLocator(integer=True))


def plain(axis):
    """Plain numbers on a logarithmic axis of a plot: mathematics is off there, texts are the user's. Between powers of
    ten 2 and 5 where there is room."""
    def minor(v, _):
        low, high = sorted(axis.get_view_interval())
        return f"{v:g}" if low > 0 and high < 110 * low and f"{v:e}"[0] in "25" else ""
    axis.set_major_formatter(lambda v, _: f"{v:g}")
    axis.set_minor_formatter(minor)


def logarithmic(ax, table):
    """The axes that a table asks for: `log_x`, `log`."""
    for asked, scale, axis in (("log_x", ax.set_xscale, ax.xaxis), ("log", ax.set_yscale, ax.yaxis)):
        if table.get(asked):
            scale("log")
            plain(axis)


def positive(values):
    """For a logarithmic axis: what is 0 is not drawn."""
    return [abs(v) if v != 0 else math.nan for v in values]


def decades(ax, series):
    """Limits of a logarithmic axis: the decades that the values fill, twelve at most."""
    seen = [v for s in series for v in s if v > 0 and math.isfinite(v)]
    if seen:
        ax.set_yscale("log")
        high = math.ceil(math.log10(max(seen)) + 1e-9)
        ax.set_ylim(10.0 ** max(math.floor(math.log10(min(seen))), high - 12), 10.0 ** high)
        plain(ax.yaxis)


def table(head, rows):
    cells = lambda tag, row: "<tr>" + "".join(f"<{tag}>{html.escape(str(v))}</{tag}>" for v in row) + "</tr>"
    return '<div class="wide"><table>' + cells("th", head) + "".join(cells("td", r) for r in rows) + "</table></div>"


def page(title, body, style="img{max-width:100%;margin:.3em}", script=""):
    """A whole page that needs no other file."""
    head = ('<meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">\n'
            f'<title>{html.escape(title)}</title>')
    return (f'<!doctype html><html lang="en">{head}\n<style>{STYLE}{style}</style>\n'
            f"<h1>{html.escape(title)}</h1>{body}{script}</html>")
