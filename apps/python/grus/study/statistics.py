# SPDX-License-Identifier: LGPL-3.0-or-later
"""What runs of several seeds say: means, intervals, differences, power laws."""
import math

from scipy import stats


def mean(v):
    return sum(v) / len(v) if v else math.nan


def deviation(v):
    """Of a sample; 0 of one value, NaN of none, as their mean."""
    m = mean(v)
    return math.sqrt(sum((x - m) ** 2 for x in v) / max(1, len(v) - 1)) if v else math.nan


def student(confidence, freedom):
    """Two-sided quantile of Student's t."""
    return float(stats.t.ppf(0.5 * (1 + confidence), freedom))


def interval(values, confidence=0.95):
    """Mean, and half the width of its confidence interval (NaN for one value: nothing is known of its scatter)."""
    n = len(values)
    if n < 2:
        return mean(values), math.nan
    return mean(values), student(confidence, n - 1) * deviation(values) / math.sqrt(n)


def difference(values, reference, paired):
    """Mean of values - reference and half its 95 % interval. Paired: seed by seed; else two samples (Welch)."""
    if len(reference) == 1 and not paired:
        m, half = interval(values)
        return m - reference[0], half
    if paired:
        return interval([a - b for a, b in zip(values, reference)])
    n, k = len(values), len(reference)
    if n < 2 or k < 2:
        return mean(values) - mean(reference), math.nan
    a, b = [deviation(v) ** 2 / len(v) for v in (values, reference)]
    freedom = (a + b) ** 2 / (a * a / (n - 1) + b * b / (k - 1)) if a + b > 0 else n + k - 2
    return mean(values) - mean(reference), student(0.95, freedom) * math.sqrt(a + b)


def power_law(points):
    """Exponent of y = c x^n by least squares in logs, and its standard error; None for fewer than two places."""
    points = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    if len({x for x, _ in points}) < 2:
        return None
    fit = stats.linregress(*zip(*points))
    return fit.slope, fit.stderr
