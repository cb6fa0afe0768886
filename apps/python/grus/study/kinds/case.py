# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[case]]: a scene with settings, seeds and a name; a row of the table."""
import math
import os

from grus.errors import InputError
from grus.figures import table as html_table
from grus.files.texts import text_table
from grus.files.writing import write_csv
from grus.runs.cases import scene_of
from grus.runs.censored import BOUNDS, mean_of
from grus.runs.schema import SEEDS, SETTINGS, TEXT, WORD, tables
from grus.study.numbers import cell_text, cost, energy_error, found
from grus.study.statistics import deviation, mean
from grus.study.tables import Shown, asked

NAME = "case"
SCHEMA = tables({"name": WORD, "label": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS}, ("name",))


def read(given, reading):
    common, entries = reading.common, []
    for c in given:
        scene = scene_of(f"{reading.path}: case {c['name']}", c.get("scene", common.get("scene")), reading.folder)
        entries.append({"name": c["name"], "label": c.get("label", c["name"]), **scene,
                        "set": {**common.get("set", {}), **c.get("set", {})},
                        "seeds": c.get("seeds", common.get("seeds", [None]))})
    if len({c["name"].lower() for c in entries}) < len(entries):  # some file systems do not tell capitals apart
        raise InputError(f"{reading.path}: two cases share a name (capitals do not count)")
    return entries


def cases(entry):
    return [entry]


def asks(entry, common):
    return [asked(entry["name"], quantity) for quantity in quantities_of(common)]


def quantities_of(common):
    return common.get("quantities", ["axial_stress_Pa"])


def row_of(case, runs, strains, quantities):
    """A case's row as people read it, and as numbers of study.csv."""
    cells, numbers, least = [], [], {}
    for q in quantities:
        for strain in strains:
            pairs = found(runs, q, strain)
            values = [x for x, _ in pairs]
            cells.append(cell_text(pairs))
            numbers += [mean(values), deviation(values)]
            least.update({q: list(mean_of(pairs)[1:])} if q in BOUNDS else {})
    status = ",".join(sorted({str(r["summary"]["status"]) for r in runs}))
    counts = [r["summary"]["counts"] for r in runs]

    def last(name):
        return mean([r["columns"][name][-1] if name in r["columns"] else math.nan for r in runs])

    tail = [last("grains"), last("breakages"), 100 * max(energy_error(r) for r in runs),
            mean([c.get("steps", c.get("dem_steps", 0)) for c in counts]), mean([cost(r)["cpu"] for r in runs])]
    shown = [f"{tail[0]:.0f}", f"{tail[1]:.0f}", f"{tail[2]:.2f}", f"{tail[3]:.3g}", f"{tail[4]:.1f}"]
    bounds = [x for q in quantities if q in BOUNDS for x in least[q]]
    return ([case["label"], len(runs), status, *cells, *shown],
            [case["name"], len(runs), status, *numbers, *tail, *bounds])


def show(entries, done):
    strains, quantities = done.common.get("at", [0.1, 0.2]), quantities_of(done.common)
    places = [(q, e) for q in quantities for e in strains]
    head = ["case", "seeds", "status", *(q if "." in q else f"{q} at {e:g}" for q, e in places),
            "grains", "breakages", "energy error %", "steps", "CPU s"]
    names = ["case", "seeds", "status", *(f"{k}_{q}_at_{e:g}" for q, e in places for k in ("mean", "sd")),
             "grains", "breakages", "worst_energy_error_percent", "steps", "cpu_s",
             *(f"{k}_{q}" for q in quantities if q in BOUNDS for k in ("at_least", "not_broken"))]
    rows = [row_of(c, done.runs[c["name"]], strains, quantities) for c in entries]
    write_csv(os.path.join(done.out, "study.csv"), [names, *(numbers for _, numbers in rows)])
    if not rows:
        return Shown()
    cells = [shown for shown, _ in rows]
    return Shown("\n" + text_table(head, cells), html_table(head, cells))
