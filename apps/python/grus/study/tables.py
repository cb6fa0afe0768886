# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the kinds of tables of a study share (grus.study.kinds)."""
import hashlib
import json
from dataclasses import dataclass
from typing import NamedTuple

from grus.errors import InputError
from grus.results import read_run
from grus.runs.cases import scene_of


@dataclass
class Reading:
    """What a kind may need while it reads its tables: the study's file and folder, its [study], its named cases."""
    path: str
    folder: str
    common: dict
    cases: list

    def named(self, where, names):
        """Refuses names of no case."""
        for name in names:
            if name not in [c["name"] for c in self.cases]:
                raise InputError(f"{where}: no case is called '{name}'")


class Shown(NamedTuple):
    """What a kind adds to study.txt and to report.html, and whether all that it claims holds."""
    text: str = ""
    body: str = ""
    passed: bool = True


@dataclass
class Done:
    """What has run: the named cases with all their seeds (`runs`), by name; of others what there is (`by_seed`). `out`:
    the study's results folder; `lost`: (name, seed) of what has failed."""
    out: str
    common: dict
    runner: object
    cases: list
    lost: set

    def __post_init__(self):
        self.labels = {c["name"]: c["label"] for c in self.cases}
        self.runs = {c["name"]: list(self.by_seed(c).values()) for c in self.cases}

    def by_seed(self, case):
        return {str(s): read_run(self.runner.folder(case, s)) for s in case["seeds"]
                if (case["name"], str(s)) not in self.lost}


def asked(name, quantity, over="axial_strain"):
    """(name of a case, columns of history.csv, dotted keys of summary.json) that a quantity needs."""
    if "." in quantity:
        return name, set(), {quantity}
    return name, {quantity} | ({over} if over else set()), set()


def shared_by_cases(where, table, reading):
    """What all cases of a table run, and the settings that they have in common."""
    common = reading.common
    base = {**scene_of(where, table.get("scene", common.get("scene")), reading.folder),
            "seeds": table.get("seeds", common.get("seeds", [None]))}
    return base, {**common.get("set", {}), **table.get("set", {})}


def unnamed_case(base, fixed, settings):
    """A case called by what it runs: the same settings run once, whoever asks for them."""
    whole = {**fixed, **settings}
    name = hashlib.sha256(json.dumps([base["scene"], whole], sort_keys=True).encode()).hexdigest()[:12]
    return {"name": name, "label": ", ".join(f"{key}={v}" for key, v in settings.items()), **base, "set": whole}
