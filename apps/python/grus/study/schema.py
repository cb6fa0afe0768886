# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a study file may hold: keys, types and ranges, checked before anything runs or is written."""
from grus.runs.schema import AT, MEASURE, NAMES, NUMBER, POSITIVE, SEEDS, SETTINGS, STRAINS, TEXT, WORD, table, tables

CORRIDOR = tables(
    {
        "label": TEXT, "points": {
            "type": "array", "minItems": 2, "items": {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3}
        }
    }, ("label", "points"))

STUDY = table({
    "title": TEXT, "study": table(
        {"scene": TEXT, "seeds": SEEDS, "seed_key": TEXT, "set": SETTINGS, "at": STRAINS, "quantities": NAMES}),
    "case": tables({"name": WORD, "label": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS}, ("name", )),
    "plot": tables(
        {
            "name": WORD, "title": TEXT, "kind": {"enum": ["history", "grading"]}, "x": TEXT, "y": TEXT, "cases": NAMES,
            "scale": NUMBER, "x_scale": NUMBER, "xlabel": TEXT, "ylabel": TEXT, "y_max": POSITIVE, "log": {
                "type": "boolean"
            }, "log_x": {"type": "boolean"}, "passing": {"type": "boolean"}, "corridor": CORRIDOR
        }, ("name", "cases")), "check": tables(
            {
                "claim": TEXT, "greater": {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
                "factor": NUMBER, "at": STRAINS, "case": TEXT, "cases": NAMES, "near": {
                    "type": "number", "not": {"const": 0}
                }, "tolerance": POSITIVE, "between": {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2
                                                      }, "below": NUMBER, "quantity": TEXT
            }, ("claim", )), "table": tables({"name": WORD, "title": TEXT, "reference": TEXT, "cases": NAMES},
                                             ("name", "reference", "cases")),
    "fit": tables({"name": TEXT, "cases": NAMES, "x": TEXT, "quantity": TEXT, "at": STRAINS, "expected": NUMBER},
                  ("name", "cases", "x", "quantity", "at")),
    "precision": tables(
        {
            "name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "vary": {
                "type": "object", "minProperties": 1, "additionalProperties": {"type": "array", "minItems": 1}
            }, "reference": {"type": ["string", "number", "object"]}, "quantity": TEXT, "measure": MEASURE, "at": AT,
            "over": TEXT, "paired": {"type": "boolean"}, "label": TEXT, "order": {"type": "boolean"}, "scale": POSITIVE
        }, ("name", "vary", "quantity")),
    "sweep": tables(
        {
            "name": TEXT, "scene": TEXT, "set": SETTINGS, "seeds": SEEDS, "key": TEXT,
            "values": {"type": "array", "minItems": 2}, "quantity": TEXT, "measure": MEASURE, "at": AT, "over": TEXT,
            "scale": NUMBER, "log": {"type": "boolean"}, "log_x": {"type": "boolean"}, "xlabel": TEXT, "ylabel": TEXT
        }, ("name", "key", "values", "quantity")),
})
