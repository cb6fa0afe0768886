# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quantiles of a sample of which some members are only known to be larger than something: grains that did not break in
a test. Kaplan and Meier (1958), the middle of each step of the distribution; without such members the places are (k -
1/2) / n. And the numbers of a run that may be of that kind."""
import math

import numpy as np

# A grain that did not break has no strength in summary.json, but it is stronger than what it bore.
BOUNDS = {"results.peak_before_breakage_Pa": "results.peak_axial_stress_Pa"}


def number_of(run, quantity):
    """A column's last value, or a number of summary.json by its dotted name."""
    if quantity in run["columns"]:
        return run["columns"][quantity][-1]
    value = run["summary"]
    for part in quantity.split("."):
        if not isinstance(value, dict) or part not in value:
            results = run["summary"].get("results")
            value = results.get(quantity) if isinstance(results, dict) else None
            break
        value = value[part]
    return float(value) if isinstance(value, (int, float)) else math.nan


def strength_of(run, quantity):
    """(value, bound): a number of a run, NaN where it has none; what it exceeds if that is for want of a breakage.
    A strength of 0 is no strength: the grain broke under no stress along the test's axis."""
    value = number_of(run, quantity)
    if quantity not in BOUNDS:
        return value, math.nan
    breakages = run["columns"].get("breakages", [math.nan])[-1]
    if value == 0 or breakages == 0:
        value = math.nan
    return value, number_of(run, BOUNDS[quantity]) if math.isnan(value) and not breakages > 0 else math.nan


def mean_of(found):
    """(mean, lower bound of it, members known to be larger only) of (value, bound) pairs. The mean is NaN where a
    member's value is not known, the lower bound where nothing is known of a member; both of no members."""
    if not found:
        return math.nan, math.nan, 0
    values, bounds = np.array(found).T
    larger = np.isnan(values) & ~np.isnan(bounds)
    return float(np.mean(values)), float(np.mean(np.where(larger, bounds, values))), int(larger.sum())


def places(values, larger):
    """(sorted values, share of the sample below each): of those known exactly. `larger`: bounds of the others."""
    values, larger = np.sort(np.asarray(values, float)), np.asarray(larger, float)
    left, shares = 1.0, []  # share that is larger than all so far
    for k, v in enumerate(values):
        at_risk = len(values) - k + int((larger >= v).sum())
        shares.append(1 - left * (1 - 0.5 / at_risk))
        left *= 1 - 1 / at_risk
    return values, np.array(shares)


def quantiles(values, larger, at):
    """Values at the shares `at`. Beyond the last known value it is at least that, and at least the largest bound."""
    known, shares = places(values, larger)
    if not len(known):
        return np.full(len(at), max(larger))
    found = np.interp(at, shares, known)
    if len(larger):
        found = np.where(np.asarray(at) > shares[-1], max(known[-1], max(larger)), found)
    return found
