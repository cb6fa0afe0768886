# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads a study: cases, settings, references, and what is asked of each run."""
import hashlib
import json
import os

from grus.runs.cases import Refused, read_checked, scene_of
from grus.runs.schema import fault
from grus.study import precision
from grus.study.schema import STUDY


def read_study(path):
    study = read_checked(path, lambda data: fault(data, STUDY))
    common = study.get("study", {})
    folder = os.path.dirname(os.path.abspath(path))
    cases = []
    for c in study.get("case", []):
        where = f"{path}: case {c['name']}"
        cases.append({
            "name": c["name"], "label": c.get("label", c["name"]), **scene_of(where, c.get(
                "scene", common.get("scene")), folder), "set": {**common.get("set", {}), **c.get("set", {})},
            "seeds": c.get("seeds", common.get("seeds", [None]))
        })
    entries = [e for k, p in enumerate(study.get("precision", [])) for e in read_precision(path, k, p, common, folder)]
    sweeps = [read_sweep(path, s, common, folder) for s in study.get("sweep", [])]
    if not cases and not entries and not sweeps:
        raise Refused(f"{path}: needs at least one [[case]], [[precision]] or [[sweep]]")
    names = [c["name"] for c in cases]
    if len({n.lower() for n in names}) < len(names):  # some file systems do not tell capitals apart
        raise Refused(f"{path}: two cases share a name (capitals do not count)")
    for t in study.get("check", []):
        if ("greater" in t) == ("case" in t or "cases" in t):
            raise Refused(f"{path}: check '{t['claim']}': needs either greater, or case or cases")
        if "greater" not in t and not ("below" in t or "between" in t or ("near" in t and "tolerance" in t)):
            raise Refused(f"{path}: check '{t['claim']}': needs near with tolerance, between or below")
    for t in study.get("plot", []):
        if t.get("kind") != "grading" and "y" not in t:
            raise Refused(f"{path}: plot '{t['name']}': needs 'y'")
    for kind in ("plot", "check", "table", "fit"):
        for t in study.get(kind, []):
            used = list(t.get("cases", [])) + ([t["reference"]] if "reference" in t else []) + list(t.get(
                "greater", []))
            for name in used + ([t["case"]] if "case" in t else []):
                if name not in names:
                    raise Refused(f"{path}: {kind} '{t.get('name', t.get('claim', '?'))}': no case is called '{name}'")
    study["precision"], study["sweep"] = entries, sweeps
    return study, common, cases


def read_precision(path, k, table, common, folder):
    """Entries of one [[precision]]: one for each position of `at`. Each carries its cases: the settings, then the
    reference."""
    where = f"{path}: precision {table.get('name', k)}"
    how = table.get("measure", "at")
    if how == "at" and "at" not in table:
        raise Refused(f"{where}: needs 'at', or a measure (peak, last, area)")
    reference = table.get("reference", "finest")
    if isinstance(reference, str) and reference != "finest":
        raise Refused(f"{where}: reference: \"finest\", a number, a table of settings, or {{ file = \"...\" }}")
    if isinstance(reference, dict) and "file" in reference:
        try:
            precision.known_reference({**table, "at": 0.0}, folder)
        except (OSError, TypeError) as e:
            raise Refused(f"{where}: reference: cannot read {reference['file']!r}: {e}") from None
        except ValueError as e:
            raise Refused(f"{where}: reference: {e}") from None
    base, fixed = shared_by_cases(where, table, common, folder)
    reference = precision.reference_settings(table)
    rows = [s for s in precision.settings(table) if s != reference]
    if not rows:
        raise Refused(f"{where}: nothing to compare with the reference")

    table = {**table, "folder": folder, "rows": [(s, unnamed_case(base, fixed, s)) for s in rows],
             "reference_case": unnamed_case(base, fixed, reference) if reference is not None else None}
    if how != "at" or not isinstance(table["at"], list):
        return [table]
    return [{**table, "at": at, "name": f"{table['name']}, at {at:g}"} for at in table["at"]]


def shared_by_cases(where, table, common, folder):
    """What all cases of a table run, and the settings that they have in common."""
    base = {
        **scene_of(where, table.get("scene", common.get("scene")), folder), "seeds": table.get(
            "seeds", common.get("seeds", [None]))
    }
    return base, {**common.get("set", {}), **table.get("set", {})}


def unnamed_case(base, fixed, settings):
    """A case called by what it runs: the same settings run once, whoever asks for them."""
    whole = {**fixed, **settings}
    name = hashlib.sha256(json.dumps([base["scene"], whole], sort_keys=True).encode()).hexdigest()[:12]
    return {"name": name, "label": ", ".join(f"{key}={v}" for key, v in settings.items()), **base, "set": whole}


def read_sweep(path, table, common, folder):
    """A [[sweep]] with a case for each value of its key."""
    where = f"{path}: sweep {table['name']}"
    if "." not in table["quantity"] and table.get("measure", "at") == "at" and "at" not in table:
        raise Refused(f"{where}: needs 'at', or a measure (peak, last, area), or a quantity of summary.json")
    base, fixed = shared_by_cases(where, table, common, folder)
    return {**table, "rows": [(v, unnamed_case(base, fixed, {table["key"]: v})) for v in table["values"]]}


def wanted(study, common, cases):
    """What is asked of each case: name -> (columns of history.csv, dotted keys of summary.json)."""
    asked = {c["name"]: (set(), set()) for c in cases}

    def ask(name, quantity, over_strain):
        columns, keys = asked[name]
        if "." in quantity:
            keys.add(quantity)
        else:
            columns.update([quantity] + (["axial_strain"] if over_strain else []))

    for c in cases:
        for q in common.get("quantities", ["axial_stress_Pa"]):
            ask(c["name"], q, True)
    for p in study.get("plot", []):
        for name in p["cases"]:
            for q in [p[k] for k in ("x", "y") if k in p]:
                ask(name, q, "x" not in p)
    for t in study.get("table", []):
        for name in t["cases"] + [t["reference"]]:
            for q in ("axial_stress_Pa", "breakages", "time_step_s"):
                ask(name, q, True)
    for f in study.get("fit", []):
        for name in f["cases"]:
            ask(name, f["quantity"], True)
            ask(name, f["x"], True)
    for t in study.get("check", []):
        for name in t.get("greater", t.get("cases", [t.get("case")])):
            ask(name, t.get("quantity", "axial_stress_Pa"), True)
    for e in study["precision"] + study["sweep"]:
        for c in [row[1] for row in e["rows"]] + ([e["reference_case"]] if e.get("reference_case") else []):
            columns, keys = asked.setdefault(c["name"], (set(), set()))
            if "key" in e and "." in e["quantity"]:
                keys.add(e["quantity"])
                continue
            columns.add(e["quantity"])
            if e.get("measure", "at") in ("at", "area"):
                columns.add(e.get("over", "axial_strain"))
    return asked
