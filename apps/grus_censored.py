# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quantiles of a sample of which some members are only known to be larger than something: grains that did not break in a test.
Kaplan and Meier (1958), the middle of each step of the distribution; without such members the places are (k - 1/2) / n."""
import numpy as np


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
