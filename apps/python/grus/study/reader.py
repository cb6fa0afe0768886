# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads a study: the entries of each kind of table, what is run, and what is asked of each run."""
import os
from dataclasses import dataclass

from grus.errors import InputError
from grus.runs.cases import read_checked
from grus.runs.schema import NAMES, SEEDS, SETTINGS, STRAINS, TEXT, fault, table
from grus.study.kinds import KINDS
from grus.study.tables import Reading

COMMON = table({"scene": TEXT, "seeds": SEEDS, "seed_key": TEXT, "set": SETTINGS, "over": TEXT, "quantities": NAMES,
                "at": {"anyOf": [STRAINS, {"const": "end"}]}})
STUDY = table({"title": TEXT, "study": COMMON, **{kind.NAME: kind.SCHEMA for kind in KINDS}})


@dataclass
class Study:
    """A study's title, its [study], and the entries of each kind by its name."""
    title: str
    common: dict
    entries: dict

    @property
    def named(self):
        """Its [[case]]s."""
        return self.entries["case"]

    def cases(self):
        """All that is run; two kinds may name the same case."""
        return [case for kind in KINDS for entry in self.entries[kind.NAME] for case in kind.cases(entry)]

    def wanted(self):
        """What is asked of each case: name -> (columns of history.csv, dotted keys of summary.json)."""
        found = {case["name"]: (set(), set()) for case in self.cases()}
        for kind in KINDS:
            for entry in self.entries[kind.NAME]:
                for name, columns, keys in kind.asks(entry, self.common):
                    found[name][0].update(columns)
                    found[name][1].update(keys)
        return found


def read_study(path):
    study = read_checked(path, lambda data: fault(data, STUDY))
    if not any(study.get(kind) for kind in ("case", "precision", "sweep")):
        raise InputError(f"{path}: needs at least one [[case]], [[precision]] or [[sweep]]")
    reading = Reading(path, os.path.dirname(os.path.abspath(path)), study.get("study", {}), [])
    entries = {}
    for kind in KINDS:
        entries[kind.NAME] = kind.read(study.get(kind.NAME, []), reading)
        if kind.NAME == "case":
            reading.cases = entries["case"]
    return Study(study.get("title", "Study"), reading.common, entries)
