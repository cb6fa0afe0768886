# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far a run is, by its scene and the rows that it has written; how far a study is, by its runs."""
import math
import os
import re

from grus.commands.words import VALUED
from grus.files.tables import UNITS
from grus.files.texts import toml_of
from grus.runs.programs import scene_in
from grus.runs.scene import put


def scene_of(process):
    """The scene that a process runs, as its command line changes it; {} where it cannot be read."""
    words = process.words
    at = next((k for k, word in enumerate(words) if os.path.basename(word).startswith("grus")), 0)
    arguments = words[at + 1:]
    try:
        table = toml_of(os.path.join(process.folder, scene_in(arguments, VALUED)))
    except (OSError, ValueError, RecursionError):
        return {}
    for before, change in zip(arguments, arguments[1:]):
        if before == "--set":
            put(table, *change.partition("=")[::2])
    return table


def quantity(value):
    """A number with or without its unit, in SI; NaN for what is none."""
    if isinstance(value, (int, float)):
        return float(value)
    found = re.fullmatch(r"\s*([-+0-9.eE]+)\s*(\S+)?\s*", value) if isinstance(value, str) else None
    try:
        return float(found[1]) * UNITS[found[2] or "1"]
    except (TypeError, ValueError, KeyError):
        return math.nan


def done_of(scene, columns):
    """The part of a run that is done, 0 to 1; None where its scene does not tell."""
    rows = len(columns.get("time_s", ()))
    if not rows or not scene:
        return None
    last = {name: column[-1] for name, column in columns.items()}
    if "mesh" in scene:  # of other problems than dynamic ones time_s is the load factor
        solve = scene.get("solve", {})
        end = quantity(solve.get("duration")) if solve.get("kind") == "explicit-dynamic" else 1.0
        return part(last["time_s"], end)
    loading = scene.get("loading", {})
    parts = [part(last["time_s"], quantity(loading.get("duration"))),
             part(abs(last.get("axial_strain", math.nan)), quantity(loading.get("final_strain"))),
             part(last.get("axial_stress_Pa", math.nan), quantity(loading.get("final_stress")))]
    known = [p for p in parts if p is not None]
    return max(known) if known else None


def part(value, whole):
    found = value / whole if whole else math.nan
    return min(1.0, max(0.0, found)) if math.isfinite(found) else None


def left_of(done, since):
    """Seconds that are left if the rest goes as fast as what is done; None where that is not known."""
    return since * (1 - done) / done if done and since > 0 else None
