# SPDX-License-Identifier: LGPL-3.0-or-later
"""What files of commands may hold: kinds of values, and the first fault in one line."""
import math

import jsonschema

WORD = {"type": "string",
        "pattern": r"^[A-Za-z0-9_+=-][A-Za-z0-9_.+=-]{0,79}$"}  # becomes the name of a folder or a file
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


KINDS = {"object": "a table { key = value }", "array": "a list", "string": "a text", "number": "a number",
         "integer": "a whole number", "boolean": "true or false"}
JUDGED = ("set", "vary", "values", "seeds")  # values of scene keys, which the program judges


def not_finite(data, place=""):
    """Where a number is nan or inf; None where none is."""
    if isinstance(data, float):
        return place if not math.isfinite(data) else None
    parts = (((f".{k}", v) for k, v in data.items() if k not in JUDGED) if isinstance(data, dict) else
             ((f"[{k}]", v) for k, v in enumerate(data)) if isinstance(data, list) else ())
    return next((found for part, v in parts if (found := not_finite(v, place + part)) is not None), None)


def kind_of(of):
    """What a value of this kind is, in words: a number, a list of numbers, a text that is given."""
    if "anyOf" in of:
        return " or ".join(kind_of(one) for one in of["anyOf"])
    if of.get("type") == "array" and of.get("items", {}).get("type") == "number":
        return "a list of numbers"
    if "const" in of:
        return f'"{of["const"]}"'
    return " or ".join(KINDS[kind] for kind in ([of["type"]] if isinstance(of["type"], str) else of["type"]))


def fault(data, of):
    """Where and what the first fault is, in one line; None where there is none."""
    faults = list(jsonschema.Draft7Validator(of).iter_errors(data))
    if not faults:
        place = not_finite(data)
        return None if place is None else f"{place.lstrip('.')}: must be a finite number"
    misspelt = [f for f in faults
                if f.validator == "additionalProperties"]  # tells more than the key that is then missing
    found = jsonschema.exceptions.best_match(misspelt or faults)
    place = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in found.absolute_path).lstrip(".")
    if found.validator == "additionalProperties":
        known = sorted(found.schema["properties"])
        what = f"unknown key '{next(k for k in found.instance if k not in known)}' (known: {', '.join(known)})"
    elif found.validator == "pattern":
        what = f"{found.instance!r}: must be a word of letters, digits and _ . + = -: it names a folder or a file"
    elif found.validator == "required":
        what = f"needs '{next(k for k in found.validator_value if k not in found.instance)}'"
    elif found.validator == "anyOf" and not isinstance(found.instance, list):
        what = f"{found.instance!r}: must be {kind_of(found.schema)}"
    elif found.validator == "type":
        given = repr(found.instance)
        what = f"{given if len(given) < 300 else given[:60] + ' …'}: must be {kind_of(found.schema)}"
    elif found.validator == "enum":
        what = f"{found.instance!r} is none of {', '.join(found.validator_value)}"
    else:
        what = found.message if len(found.message) < 300 else f"must be {found.validator} {found.validator_value}"
    return f"{place}: {what}" if place else what
