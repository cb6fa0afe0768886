# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a calibration file may hold: keys, types and ranges."""
from grus.runs import schema
from grus.runs.schema import NUMBER, POSITIVE, SEEDS, SETTINGS, TEXT, table, tables

VALUE = {"type": ["number", "string"]}
TARGET = {
    "name": TEXT, "kind": {"enum": ["curve", "grading", "quantiles", "value", "peak",
                                    "yield"]}, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "data": TEXT,
    "column": TEXT, "x": TEXT, "y": TEXT, "x_scale": {"enum": ["linear", "log"]}, "quantity": TEXT, "at": VALUE,
    "value": NUMBER, "error": POSITIVE, "weight": POSITIVE, "specimens": POSITIVE
}
PARAMETER = {"key": TEXT, "name": TEXT, "min": VALUE, "max": VALUE, "scale": {"enum": ["linear", "log"]}}
CALIBRATION = table(
    {
        "title": TEXT, "calibrate": table(
            {
                "method": {"enum": ["regression", "pounders"]}, "budget": {
                    "type": "integer", "minimum": 1, "maximum": 100000
                }, "batch": {"type": "integer", "minimum": 2}, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS,
                "seed_key": TEXT, "check": {"type": "boolean"}, "posterior": {"type": "boolean"}, "parameters": {
                    **tables(PARAMETER, ("key", "min", "max")), "minItems": 1, "maxItems": 12
                }, "targets": {**tables(TARGET, ("name",)), "minItems": 1}
            }, ("parameters", "targets"))
    }, ("calibrate",))
NEEDS = {
    "curve": ("data", "x", "y"), "grading": ("data", "at"), "quantiles": ("data", "quantity"),
    "value": ("quantity", "value"), "peak": ("quantity", "value"), "yield": ("value",)
}


def fault(data):
    """Where and what the first fault is, in one line; None where there is none."""
    found = schema.fault(data, CALIBRATION)
    if found:
        return found
    for k, t in enumerate(data["calibrate"]["targets"]):
        for key in NEEDS[t.get("kind", "curve")]:
            if key not in t:
                return (f"calibrate.targets[{k}]: {t['name']}: a target of kind \"{t.get('kind', 'curve')}\" needs "
                        f"'{key}'")
    return None
