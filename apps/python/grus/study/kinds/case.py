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
from grus.study.numbers import cell_text, cost, energy_error, finished, found, statuses, unfinished_mark
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
    return [asked(entry["name"], quantity, over_of(common)) for quantity in quantities_of(common)]


def quantities_of(common):
    return common.get("quantities", ["axial_stress_Pa"])


def over_of(common):
    return common.get("over", "axial_strain")


def places_of(common):
    """(quantity, where: a value of the column `over`, or None, the end; heading, name in study.csv) of each mean. A key
    of summary.json has one value a run."""
    strains, over = common.get("at", [0.1, 0.2]), over_of(common)
    along = "" if over == "axial_strain" else f"{over} "
    places = []
    for q in quantities_of(common):
        if "." in q:
            places.append((q, None, q, q))
        elif strains == "end":
            places.append((q, None, f"{q} at the end", f"{q}_at_end"))
        else:
            places += [(q, e, f"{q} at {along}{e:g}", f"{q}_at_{along.replace(' ', '_')}{e:g}") for e in strains]
    return places


def row_of(case, runs, common):
    """A case's row as people read it, and as numbers of study.csv. Means are of runs that finished."""
    cells, numbers, least = [], [], []
    good = [r for r in runs if finished(r)]
    for q, where, _, _ in places_of(common):
        pairs = found(good, q, where, over_of(common))
        values = [x for x, _ in pairs]
        cells.append(cell_text(pairs))
        numbers += [mean(values), deviation(values)]
        if q in BOUNDS:
            least += mean_of(pairs)[1:]
    status = statuses(runs) + unfinished_mark(runs)
    counts = [r["summary"]["counts"] for r in good]

    def last(name):
        return mean([r["columns"][name][-1] if name in r["columns"] else math.nan for r in good])

    tail = [last("grains"), last("breakages"), 100 * max((energy_error(r) for r in runs), default=math.nan),
            mean([c.get("steps", c.get("dem_steps", 0)) for c in counts]), mean([cost(r)["cpu"] for r in good])]
    shown = ["-" if math.isnan(x) else f"{x:{kind}}" for x, kind in zip(tail, (".0f", ".0f", ".2f", ".3g", ".1f"))]
    return ([case["label"], len(runs), status, *cells, *shown],
            [case["name"], len(runs), status, *numbers, *tail, *least])


def show(entries, done):
    places = places_of(done.common)
    head = ["case", "seeds", "status", *(text for _, _, text, _ in places),
            "grains", "breakages", "energy error %", "steps", "CPU s"]
    names = ["case", "seeds", "status", *(f"{k}_{name}" for _, _, _, name in places for k in ("mean", "sd")),
             "grains", "breakages", "worst_energy_error_percent", "steps", "cpu_s",
             *(f"{k}_{q}" for q, _, _, _ in places if q in BOUNDS for k in ("at_least", "not_broken"))]
    rows = [row_of(c, done.runs[c["name"]], done.common) for c in entries]
    write_csv(os.path.join(done.out, "study.csv"), [names, *(numbers for _, numbers in rows)])
    if not rows:
        return Shown()
    cells = [shown for shown, _ in rows]
    return Shown("\n" + text_table(head, cells), html_table(head, cells))
