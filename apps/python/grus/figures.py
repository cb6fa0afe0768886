# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of a report: vector pictures with a text that says what they show, legends beside the curves, axes that
fit."""
import base64
import html
import io
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
figure{margin:0;cursor:zoom-in}figure img{width:100%}
figure.large{grid-column:1/-1;cursor:zoom-out}"""
ZOOM = "<script>document.querySelectorAll('figure').forEach(f=>f.onclick=()=>f.classList.toggle('large'))</script>"


def figure(draw, width=7.4, height=4.2):
    """What draw(ax) draws, as <figure>. The text for who cannot see it comes from title, axes and curves."""
    fig, ax = plt.subplots(figsize=(width, height))
    draw(ax)
    if ax.axison:
        ax.grid(alpha=0.3)
    data = io.BytesIO()
    fig.savefig(data, format="svg", bbox_inches="tight", dpi=160,
                metadata={"Date": None})  # dpi: of what is painted, not drawn
    text = alt_text(fig.axes)
    plt.close(fig)
    return (f'<figure><img alt="{html.escape(text, quote=True)}" '
            f'src="data:image/svg+xml;base64,{base64.b64encode(data.getvalue()).decode()}"></figure>')


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
        return f"{v:g}" if low > 0 and high < 30 * low and f"{v:e}"[0] in "25" else ""
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
    head = ('<meta charset="utf-8"><meta name="viewport" content="width=device-width">\n'
            f'<title>{html.escape(title)}</title>')
    return (f'<!doctype html><html lang="en">{head}\n<style>{STYLE}{style}</style>\n'
            f"<h1>{html.escape(title)}</h1>{body}{script}</html>")
