# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads a calibration: parameters with their ranges and scales, targets with their data, and the runs that they
need."""
import hashlib
import json
import math
import os
import re

from grus.calibrate import schema
from grus.calibrate.targets import Target
from grus.errors import InputError
from grus.files.tables import KINDS, UNITS
from grus.files.texts import BadData
from grus.runs.cases import read_checked, scene_of


class Parameter:
    """A scene key between bounds; 0 … 1 is its range, in its logarithm with scale = "log"."""

    def __init__(self, where, table):
        self.key, self.name = table["key"], table.get("name", table["key"].rsplit(".", 1)[-1])
        (self.low, unit), (self.high, other) = (self.split(where, table[k]) for k in ("min", "max"))
        if unit != other:
            if not any(unit in kind and other in kind for kind in KINDS.values()):
                raise InputError(f"{where}: min and max are in different units ('{unit}', '{other}')")
            self.high = float(f"{self.high * UNITS[other] / UNITS[unit]:.12g}")
        self.unit, self.log = unit, table.get("scale", "linear") == "log"
        if not self.low < self.high:
            raise InputError(f"{where}: min must be below max")
        if self.log and self.low <= 0:
            raise InputError(f"{where}: scale = \"log\" needs min above 0")

    def split(self, where, value):
        if not isinstance(value, str):
            return float(value), ""
        m = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*", value)
        if not m:
            raise InputError(f"{where}: {value!r} is no number with a unit")
        return float(m[1]), m[2] or ""

    def number(self, u):
        u = min(1.0, max(0.0, float(u)))
        return self.low * (self.high / self.low) ** u if self.log else self.low + (self.high - self.low) * u

    def setting(self, u):
        value = float(f"{self.number(u):.10g}")
        return f"{value!r} {self.unit}" if self.unit else value

    def text(self, u, sd):
        """Value ± standard deviation (a factor, with scale = "log")."""
        unit = f" {self.unit}" if self.unit else ""
        if self.log:
            return f"{self.number(u):.4g}{unit} ×/÷ {math.exp(sd * math.log(self.high / self.low)):.3g}"
        return f"{self.number(u):.4g} ± {sd * (self.high - self.low):.2g}{unit}"

    def deviation(self, u, sd):
        """In the parameter's own unit, to first order."""
        return sd * (self.number(u) * math.log(self.high / self.low) if self.log else self.high - self.low)


def read_calibration(path):
    whole = read_checked(path, schema.fault)
    table, folder = whole["calibrate"], os.path.dirname(os.path.abspath(path))
    parameters = [Parameter(f"{path}: parameter {p['key']}", p) for p in table["parameters"]]
    for kind, names in (("parameters", [p.name for p in parameters]),
                        ("targets", [t["name"] for t in table["targets"]])):
        if len(set(names)) < len(names):
            raise InputError(f"{path}: two {kind} share a name; give 'name'")
    targets, runs = [], {}
    for t in table["targets"]:
        where = f"{path}: target {t['name']}"
        t = dict(t)
        if isinstance(t.get("at"), str):
            m = re.fullmatch(r"\s*(\S+)\s*(Pa|kPa|MPa|GPa)\s*", t["at"])
            try:
                t["at_stress"] = float(m[1]) * UNITS[m[2]]
            except (TypeError, ValueError):
                raise InputError(f"{where}: at: {t['at']!r} is neither a strain nor a stress with its unit") from None
            if t.get("kind") != "grading":
                raise InputError(f"{where}: at: a stress is for gradings; give a strain")
        try:
            target = Target(t, folder)
        except BadData as e:
            raise InputError(f"{where}: {e}") from None
        base = scene_of(where, t.get("scene", table.get("scene")), folder)
        settings, seeds = {**table.get("set", {}), **t.get("set", {})}, t.get("seeds", table.get("seeds", [None]))
        name = hashlib.sha256(json.dumps([base["scene"], settings, seeds], sort_keys=True).encode()).hexdigest()[:8]
        runs.setdefault(name, {
            **base, "name": name, "label": os.path.basename(base["scene"]), "set": settings, "seeds": seeds,
            "targets": []
        })["targets"].append(target)
        target.run = name
        targets.append(target)
    return whole, table, parameters, targets, list(runs.values())


def case_at(run, parameters, x):
    """The runs of one scene at a parameter point, as grus-study's runner takes them."""
    settings = {**run["set"], **{p.key: p.setting(u) for p, u in zip(parameters, x)}}
    name = run["name"] + "_" + hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12]
    return {**run, "name": name, "set": settings}
