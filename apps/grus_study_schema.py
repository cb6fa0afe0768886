# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a study file may hold: keys, types and ranges, checked before anything runs or is written."""
import jsonschema

WORD = {"type": "string", "pattern": r"^[A-Za-z0-9_+=-][A-Za-z0-9_.+=-]{0,79}$"}  # becomes the name of a folder or a file
TEXT = {"type": "string", "maxLength": 1000}
NUMBER = {"type": "number"}
POSITIVE = {"type": "number", "exclusiveMinimum": 0}
NAMES = {"type": "array", "items": {"type": "string"}, "minItems": 1}
SETTINGS = {"type": "object"}  # of scene keys: the program judges them
SEEDS = {"type": "array", "minItems": 1, "items": {"type": ["integer", "number", "string", "array"]}}
STRAINS = {"type": "array", "items": NUMBER, "minItems": 1}
AT = {"anyOf": [NUMBER, STRAINS]}
MEASURE = {"enum": ["at", "peak", "last", "area"]}


def table(properties, required=()):
    return {"type": "object", "properties": properties, "required": list(required), "additionalProperties": False}


def tables(properties, required=()):
    return {"type": "array", "items": table(properties, required)}


CORRIDOR = tables({"label": TEXT, "points": {"type": "array", "minItems": 2, "items": {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}}}, ("label", "points"))

STUDY = table({
    "title": TEXT,
    "study": table({"scene": TEXT, "seeds": SEEDS, "seed_key": TEXT, "set": SETTINGS, "at": STRAINS, "quantities": NAMES}),
    "case": tables({"name": WORD, "label": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS}, ("name",)),
    "plot": tables({"name": WORD, "title": TEXT, "kind": {"enum": ["history", "grading"]}, "x": TEXT, "y": TEXT, "cases": NAMES, "scale": NUMBER, "x_scale": NUMBER, "xlabel": TEXT, "ylabel": TEXT,
                    "y_max": POSITIVE, "log": {"type": "boolean"}, "log_x": {"type": "boolean"}, "passing": {"type": "boolean"}, "corridor": CORRIDOR}, ("name", "cases")),
    "check": tables({"claim": TEXT, "greater": {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}, "factor": NUMBER, "at": STRAINS, "case": TEXT, "cases": NAMES,
                     "near": {"type": "number", "not": {"const": 0}}, "tolerance": POSITIVE, "between": {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}, "below": NUMBER, "quantity": TEXT}, ("claim",)),
    "table": tables({"name": WORD, "title": TEXT, "reference": TEXT, "cases": NAMES}, ("name", "reference", "cases")),
    "fit": tables({"name": TEXT, "cases": NAMES, "x": TEXT, "quantity": TEXT, "at": STRAINS, "expected": NUMBER}, ("name", "cases", "x", "quantity", "at")),
    "precision": tables({"name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "vary": {"type": "object", "minProperties": 1, "additionalProperties": {"type": "array", "minItems": 1}},
                         "reference": {"type": ["string", "number", "object"]}, "quantity": TEXT, "measure": MEASURE,
                         "at": AT, "over": TEXT, "paired": {"type": "boolean"}, "label": TEXT, "order": {"type": "boolean"}, "scale": POSITIVE}, ("name", "vary", "quantity")),
    "sweep": tables({"name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "key": TEXT, "values": {"type": "array", "minItems": 2}, "quantity": TEXT, "measure": MEASURE, "at": AT, "over": TEXT,
                     "scale": NUMBER, "log": {"type": "boolean"}, "log_x": {"type": "boolean"}, "xlabel": TEXT, "ylabel": TEXT}, ("name", "key", "values", "quantity")),
})


def fault(data, of=None):
    """Where and what the first fault is, in one line; None where there is none."""
    faults = list(jsonschema.Draft7Validator(of or STUDY).iter_errors(data))
    if not faults:
        return None
    misspelt = [f for f in faults if f.validator == "additionalProperties"]  # tells more than the key that is then missing
    found = jsonschema.exceptions.best_match(misspelt or faults)
    place = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in found.absolute_path).lstrip(".")
    if found.validator == "additionalProperties":
        known = sorted(found.schema["properties"])
        what = f"unknown key '{next(k for k in found.instance if k not in known)}' (known: {', '.join(known)})"
    elif found.validator == "pattern":
        what = f"{found.instance!r}: must be a word of letters, digits and _ . + = -: it names a folder or a file"
    elif found.validator == "required":
        what = f"needs '{next(k for k in found.validator_value if k not in found.instance)}'"
    elif found.validator == "enum":
        what = f"{found.instance!r} is none of {', '.join(found.validator_value)}"
    else:
        what = found.message if len(found.message) < 300 else f"must be {found.validator} {found.validator_value}"
    return f"{place}: {what}" if place else what
