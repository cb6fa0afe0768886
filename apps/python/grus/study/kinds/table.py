# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[table]]: what runs came to beside a reference, in the words of a paper's table of parameters."""
import math

from grus.figures import table as html_table
from grus.files.texts import text_table
from grus.runs.schema import NAMES, TEXT, WORD, tables
from grus.study.numbers import position
from grus.study.tables import Shown, asked

NAME = "table"
SCHEMA = tables({"name": WORD, "title": TEXT, "reference": TEXT, "cases": NAMES}, ("name", "reference", "cases"))


def read(given, reading):
    for t in given:
        reading.named(f"{reading.path}: table '{t['name']}'", [*t["cases"], t["reference"]])
    return given


def cases(_entry):
    return []


def asks(entry, _common):
    return [asked(name, quantity) for name in [*entry["cases"], entry["reference"]]
            for quantity in ("axial_stress_Pa", "breakages", "time_step_s")]


def result_of(run, reference):
    """What a run of a parameter sweep came to, in the words of the paper's Table 1."""
    if run["summary"]["status"] == 3:
        return "unstable: " + run["summary"]["ending"]
    if run["columns"]["breakages"][-1] == 0:
        return "never broken"
    last = min(run["columns"]["axial_strain"][-1], reference["columns"]["axial_strain"][-1])
    grid = [last * k / 200 for k in range(1, 200)]
    a, b = [[position(r["columns"], "axial_stress_Pa", x) for x in grid] for r in (run, reference)]
    norm = math.sqrt(sum(y * y for y in b))
    off = math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b))) / norm if norm > 0 else math.nan
    word = "good, same result" if off < 0.05 else "good, slightly different" if off < 0.2 else "broken, different path"
    return f"{word} ({100 * off:.1f} %)"


def show(entries, done):
    text = body = ""
    for t in entries:
        reference, rows = done.runs[t["reference"]][0], []
        for name in t["cases"]:
            run = done.runs[name][0]
            steps, columns = run["columns"]["time_step_s"], run["columns"]
            rows.append([done.labels[name], f"{min(steps):.2g} … {max(steps):.2g}",
                         f"{max(columns['axial_stress_Pa']) / 1e6:.3g}", f"{columns['breakages'][-1]:.0f}",
                         result_of(run, reference)])
        head = [t.get("title", t["name"]), "time steps used (s)", "peak stress (MPa)", "breakages", "result"]
        text += "\n" + text_table(head, rows)
        body += html_table(head, rows)
    return Shown(text, body)
