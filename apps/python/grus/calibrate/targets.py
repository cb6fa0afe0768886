# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a calibration is to meet: a curve, a sieve grading, the quantiles of a number of grains, a value, a peak, a
yield point. Each turns the runs of one parameter point (one a seed) into numbers beside the data."""
import math
import os

import numpy as np

from grus.files.tables import range_text, read_columns
from grus.files.texts import BadData
from grus.runs.censored import quantiles, strength_of


def along(x, y, at, log=False):
    """y where x first reaches each of `at`; NaN where it does not. x may fall on the way: the envelope counts."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = np.isfinite(x) & np.isfinite(y) & ((x > 0) if log else True)
    x, y, at = x[good], y[good], np.asarray(at, float)
    if not len(x):
        return np.full(len(at), math.nan)
    high = np.maximum.accumulate(x)
    first = np.concatenate([[True], high[1:] > high[:-1]])
    x, y = high[first], y[first]
    f = np.log if log else np.asarray
    return np.where((at >= x[0]) & (at <= x[-1]), np.interp(f(at), f(x), y), math.nan)


def kink(x, y, log=True):
    """x at which two straight lines through y meet that fit it best: where a sample begins to yield."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    high = np.maximum.accumulate(np.where(np.isfinite(x), x, -math.inf))
    keep = np.concatenate([[True], high[1:] > high[:-1]]) & np.isfinite(y) & ((x > 0) if log else True)
    x, y = x[keep], y[keep]
    if len(x) < 6:
        return math.nan
    u = np.log(x) if log else x
    best = (math.inf, math.nan)
    for c in np.linspace(u[0] + 0.05 * (u[-1] - u[0]), u[-1] - 0.05 * (u[-1] - u[0]), 181):
        a = np.column_stack([np.ones_like(u), u, np.maximum(0, u - c)])
        rest = y - a @ np.linalg.lstsq(a, y, rcond=None)[0]
        best = min(best, (float(rest @ rest), c))
    return float(math.exp(best[1]) if log else best[1])


def columns_of(path, names, quantity=None):
    return [None if c is None else np.array(c) for c in read_columns(path, names, ["error"], quantity)]


class Target:
    """`table`: as the scene has it, checked; `folder`: where its files are."""

    def __init__(self, table, folder):
        self.name, self.kind, self.table = table["name"], table.get("kind", "curve"), table
        self.log = table.get("x_scale", "linear") == "log"
        path = os.path.join(folder, table["data"]) if "data" in table else None
        told = None
        if self.kind == "curve":
            self.x, self.values, told = columns_of(path, [table["x"], table["y"]])
            if self.log and (self.x <= 0).any():
                raise BadData(f"{path}: {table['x']} must be above 0 with x_scale = \"log\"")
        elif self.kind == "grading":
            self.x, self.values, told = columns_of(path, ["diameter_m", "passing"])
            if ((self.values < 0) | (self.values > 1)).any() or (self.x <= 0).any():
                raise BadData(f"{path}: diameter_m above 0 and passing between 0 and 1 are expected")
        elif self.kind == "quantiles":
            self.values, told = columns_of(path, [table.get("column", "value")], table["quantity"])
            self.values = np.sort(self.values)
            self.x = (np.arange(len(self.values)) + 0.5) / len(self.values)
        else:
            self.values, self.x = np.array([float(table["value"])]), np.array([0.0])
        if told is not None and not (told > 0).all():
            raise BadData(f"{path}: column 'error': standard deviations are above 0")
        self.told = None  # what the runs of the last point have said, besides numbers
        spread = float(np.ptp(self.values)) or float(np.abs(self.values).max()) or 1.0
        self.error = told if told is not None else np.full(len(self.values), float(table.get("error", 0.02 * spread)))
        self.weight = np.full(len(self.values), table.get("weight", 1.0) / len(self.values))
        self.specimens = np.full(len(self.values), float(table.get("specimens", 0)))

    def describe(self):
        """What was read, for people to compare with their data."""
        t, n = self.table, len(self.values)
        text = f"{n} value{'s' if n > 1 else ''}"
        if self.kind in ("curve", "grading"):
            x, y = (t["x"], t["y"]) if self.kind == "curve" else ("diameter_m", "passing")
            return f"{text}, {x} {range_text(self.x, x)}, {y} {range_text(self.values, y)}"
        return f"{text}, {range_text(self.values, t.get('quantity', t.get('x', 'axial_stress_Pa')))}"

    def columns(self):
        """Of history.csv that it needs."""
        t = self.table
        if self.kind in ("curve", "yield"):
            return {t.get("x", "axial_stress_Pa"), t.get("y", "void_ratio")}
        if self.kind == "grading":
            return {"axial_strain", "axial_stress_Pa"}
        return {q for q in (t["quantity"],) if "." not in q} | ({"axial_strain"} if "at" in t else set())

    def keys(self):
        """Of summary.json that it needs."""
        return {q for q in (self.table.get("quantity", ""),) if "." in q}

    def of_run(self, run):
        """Its numbers of one run (not of quantiles)."""
        c, t = run["columns"], self.table
        if self.kind == "curve":
            return along(c[t["x"]], c[t["y"]], self.x, self.log)
        if self.kind == "yield":
            return np.array(
                [kink(c[t.get("x", "axial_stress_Pa")], c[t.get("y", "void_ratio")],
                      t.get("x_scale", "log") == "log")])
        if self.kind == "grading":
            return self.passing(run)
        if self.kind == "peak":
            y = np.asarray(c[t["quantity"]], float)
            self.told["still_rising"] += int(np.nanargmax(y) == len(y) - 1)
            return np.array([np.nanmax(y)])
        if "at" in t:
            return along(c["axial_strain"], c[t["quantity"]], [t["at"]])
        value, bound = strength_of(run, t["quantity"])
        self.told["stronger_than"] += int(not math.isnan(bound))
        return np.array([bound if math.isnan(value) else value])  # the mean is at least that

    def passing(self, run):
        states = sorted((strain, rows) for strain, rows in run["grading"].items())
        if not states:
            return np.full(len(self.x), math.nan)
        at = self.table["at_stress"] if "at_stress" in self.table else None
        strain = along(run["columns"]["axial_stress_Pa"], run["columns"]["axial_strain"],
                       [at])[0] if at is not None else self.table["at"]
        strains = np.array([s for s, _ in states])
        if not strains[0] - 1e-9 <= strain <= strains[-1] + 1e-9:
            return np.full(len(self.x), math.nan)
        curves = [
            np.interp(np.log(self.x),
                      *zip(*sorted((math.log(r["diameter_m"]), r["passing"]) for r in rows if r["diameter_m"] > 0)))
            for _, rows in states
        ]
        return np.array([np.interp(strain, strains, [curve[k] for curve in curves]) for k in range(len(self.x))])

    def answer(self, runs):
        """(values, covariance of one run from seed to seed, seeds)."""
        n = len(runs)
        self.told = {"runs": n, "stronger_than": 0, "still_rising": 0}
        if self.kind == "quantiles":
            found, bounds = np.array([strength_of(r, self.table["quantity"]) for r in runs]).T
            larger = ~np.isnan(bounds)  # these have no value
            useful = larger | ~np.isnan(found)
            self.told["stronger_than"] = int(larger.sum())

            def of(kept):
                return quantiles(found[kept & ~np.isnan(found)], bounds[kept & larger], self.x)

            every = np.ones(n, bool)
            if not useful.any():
                return np.full(len(self.x), math.nan), np.zeros((len(self.x),) * 2), n
            whole = of(every)
            without = [of(np.arange(n) != k) for k in range(n)] if n > 2 and useful.sum() > 1 else [whole] * n
            return whole, np.cov(np.array(without).T, bias=True).reshape(len(self.x), -1) * (n - 1) * n, n
        each = np.array([self.of_run(r) for r in runs])
        known = np.isfinite(each)
        with np.errstate(invalid="ignore"):
            mean = np.where(known.any(axis=0), np.nansum(each, axis=0) / np.maximum(known.sum(axis=0), 1), math.nan)
        rest = np.where(known, each - mean, 0.0)
        return mean, rest.T @ rest / max(1, n - 1), n
