#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""A report in a browser: values under the pointer, zoom, the width of a phone, nothing asked of elsewhere:
report_hover.py BIN"""
import html
import json
import os
import re
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(sys.argv[1], "..", "python"), os.path.join(here, "..", "tools")]
import browser  # noqa: E402
from grus import figures  # noqa: E402

from made_up import near  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def curves(ax):
    ax.plot([0.0, 1.0, 2.0, 4.0], [0.0, 10.0, 20.0, 40.0], label="a")
    ax.plot([0.0, 4.0], [30.0, float("nan")], label="_b")
    ax.set(title="T", xlabel="x", ylabel="y", xlim=(0, 5), ylim=(0, 50))
    other = ax.twinx()
    other.semilogy([4.0], [100.0], "o", label="c <right>")
    other.set_ylim(1, 1e4)


def told():
    """What a figure tells its script: the place of its axes, their limits, its curves."""
    text = figures.figure(curves)
    data = json.loads(html.unescape(re.search(r'data-plot="(.*?)"', text)[1]))
    series = data.pop("series")
    near([series[0]["x"], series[0]["y"]], [0, 1, 2, 4, 0, 10, 20, 40], "a curve")
    need([s["label"] for s in series] == ["a", "", "c <right>"] and series[1]["x"] == [0] and
         (series[2]["limits"], series[2]["log"]) == ([1, 1e4], True), f"others: {series[1:]}")
    near([data["x"], data["y"]], [0, 5, 0, 50], "limits")
    # The frame that matplotlib draws is where the data say it is.
    import base64
    svg = base64.b64decode(re.search(r'base64,([^"]+)', text)[1]).decode()
    frame = [float(v) for v in re.findall(r"[\d.]+", re.search(r'id="patch_2">\s*<path d="([^"]*)"', svg)[1])]
    left, top, right, bottom = data["box"]
    near([min(frame[::2]), max(frame[::2]), min(frame[1::2]), max(frame[1::2])], [left, right, top, bottom],
         "its frame", 0, 0.02)
    near(re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups(), re.search(
        r'viewBox="0 0 ([\d.]+) ([\d.]+)"', text).groups(), "its size", 0, 0.02)
    many = figures.figure(lambda ax: ax.plot(range(1000), range(1000)))
    many = json.loads(html.unescape(re.search(r'data-plot="(.*?)"', many)[1]))["series"][0]["x"]
    need(len(many) == 250 and many[-1] == 999, f"{len(many)} points of a curve")
    picture = figures.figure(lambda ax: (ax.plot([1, 2]), ax.set_axis_off()))
    need('"series": []' in html.unescape(picture) and "[0, 0, 0, 0]" in picture, "values of a picture")
    return data["box"]


POINT = """(async () => {
  const f = document.querySelector("figure"), s = f.querySelector("svg"), m = s.getScreenCTM()
  const p = new DOMPoint(%s, %s).matrixTransform(m)
  s.dispatchEvent(new PointerEvent("pointermove", {clientX: p.x, clientY: p.y}))
  const t = s.querySelector(".told")
  return [t.getAttribute("visibility"), t.textContent]
})()"""
DOUBLE = """(() => {
  const s = document.querySelector("figure svg"), r = s.getBoundingClientRect()
  s.dispatchEvent(new MouseEvent("dblclick", {clientX: r.x + r.width / 2, clientY: r.y + r.height / 2}))
  return s.getAttribute("viewBox").split(" ").map(Number)
})()"""


def seen(folder, box):
    left, top, right, bottom = box
    at = lambda x, y: (left + (right - left) * x / 5, bottom - (bottom - top) * y / 50)
    path = os.path.join(folder, "page.html")
    wide = figures.table([f"column {k}" for k in range(12)], [["value " * 3] * 12])
    with open(path, "w") as f:
        f.write(figures.page("a_long_name_of_a_run_" * 6, wide + '<div class="plots">' + figures.figure(curves)
                             + "</div>", style="", script=figures.ZOOM))
    b = browser.Browser(os.path.join(folder, "profile"))
    try:
        b.width(1200)
        b.open("file://" + path)
        need(b.errors == [] and [r for r in b.requests if not r.startswith(("file://" + path, "data:"))] == [],
             f"{b.errors} {b.requests}")
        for (x, y), wanted in (((1.9, 19), "a: 2, 20"), ((0.1, 29), "0, 30"), ((4, 26), "c <right>: 4, 100"),
                               ((4, 38), "a: 4, 40")):
            found = b.ask(POINT % at(x, y))
            need(found == ["visible", wanted], f"at {x}, {y}: {found}")
        need(b.ask(POINT % (left - 9, top))[0] == "hidden", "beside the axes")
        whole = b.ask('document.querySelector("figure svg").getAttribute("viewBox").split(" ").map(Number)')
        close = b.ask(DOUBLE)
        middle = lambda v: [v[0] + v[2] / 2, v[1] + v[3] / 2]
        near([close[2:], middle(close)], [0.4 * whole[2], 0.4 * whole[3], *middle(whole)], "zoomed", 1e-2)
        need(b.ask(POINT % at(2, 21))[1] == "a: 2, 20", "values where it is zoomed")
        near(b.ask(DOUBLE), whole, "all again")
        need(b.ask('(document.querySelector("figure button").click(), document.querySelector("figure").className)') ==
             "large", "larger")
        b.width(360, phone=True)
        need(b.ask("document.documentElement.scrollWidth") <= 360, "wider than a phone: "
             f"{b.ask('document.documentElement.scrollWidth')}")
        need(300 < b.ask('document.querySelector("figure svg").getBoundingClientRect().width') <= 360, "a figure on it")
    finally:
        b.close()


box = told()
if browser.found() is None:
    print("report_hover: without Chromium the page was not opened (./bootstrap test installs it)")
    sys.exit(1 if faults else 77)
with tempfile.TemporaryDirectory() as place:
    seen(place, box)
print(f"report_hover: {len(faults)} faults")
sys.exit(bool(faults))
