# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time: what settings cost, how far their results are from a reference, and what the scatter over
seeds leaves open. Numbers only; precision_report.py writes them."""
import itertools
import math
import os

from scipy import stats

from grus.files.tables import Columns

TARGETS = (0.1, 0.01, 0.001)


def position(columns, name, x, over="axial_strain"):
    """Column where another reaches x, linear between rows; NaN where the run does not reach it."""
    xs, ys = columns[over], columns[name]
    for k in range(1, len(xs)):
        if xs[k] > xs[k - 1] and xs[k - 1] <= x <= xs[k] + 1e-9 * abs(xs[k]):
            return ys[k - 1] + (x - xs[k - 1]) / (xs[k] - xs[k - 1]) * (ys[k] - ys[k - 1])
    return math.nan


def measured(columns, entry):
    """The quantity of a run: at a position, its peak, its area, or its last value."""
    name, over, how = entry["quantity"], entry.get("over", "axial_strain"), entry.get("measure", "at")
    if how == "at":
        return position(columns, name, entry["at"], over)
    y = columns[name]
    if how == "peak":
        return max(y)
    if how == "last":
        return y[-1]
    x = columns[over]
    return sum(0.5 * (y[k] + y[k - 1]) * (x[k] - x[k - 1]) for k in range(1, len(x)))


def student(confidence, freedom):
    """Two-sided quantile of Student's t."""
    return float(stats.t.ppf(0.5 * (1 + confidence), freedom))


def mean(v):
    return sum(v) / len(v) if v else math.nan


def deviation(v):
    m = mean(v)
    return math.sqrt(sum((x - m) ** 2 for x in v) / (len(v) - 1)) if len(v) > 1 else 0.0


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


def pareto(points):
    """Indices of the (cost, error) pairs that no other beats in both, by cost."""
    front, best = [], math.inf
    for k in sorted(range(len(points)), key=lambda k: points[k]):
        if points[k][1] < best:
            front.append(k)
            best = points[k][1]
    return front


def power_law(points):
    """Exponent of y = c x^n by least squares in logs, and its standard error; None for fewer than two places."""
    points = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    if len({x for x, _ in points}) < 2:
        return None
    fit = stats.linregress(*zip(*points))
    return fit.slope, fit.stderr


def bound(row):
    """What the error may be: the bias and what its interval leaves open."""
    return row["error"] + (0 if math.isnan(row["interval"]) else row["interval"])


def recommended(rows):
    """For each target the cheapest row whose error, interval included, is below; None where none is."""
    found = {}
    for target in TARGETS:
        good = [r for r in rows if r["status"] == "0" and bound(r) <= target]
        found[target] = min(good, key=lambda r: r["cpu"]) if good else None
    return found


def settings(entry):
    """The combinations of the varied keys, first key slowest."""
    keys = list(entry["vary"])
    return [dict(zip(keys, values)) for values in itertools.product(*(entry["vary"][k] for k in keys))]


def reference_settings(entry):
    """Settings of the reference runs; None if the reference is known."""
    reference = entry.get("reference", "finest")
    if reference == "finest":
        return settings(entry)[-1]
    return reference if isinstance(reference, dict) and "file" not in reference else None


def known_reference(entry, folder):
    reference = entry["reference"]
    if not isinstance(reference, dict):
        return float(reference)
    column = reference.get("column", entry["quantity"])
    columns = Columns(os.path.join(folder, reference["file"]), {column: entry["quantity"]})
    return measured(columns, {**entry, "quantity": column})


def cost(run):
    seconds, counts = run["summary"]["seconds"], run["summary"]["counts"]
    return {"cpu": seconds.get("cpu", seconds.get("cpu_rank0", math.nan)),
            "wall": sum(v for k, v in seconds.items() if k in ("loading_wall", "solve_wall")),
            "grain_steps": counts.get("grain_steps", counts.get("dem_steps", 0) * counts.get("grains_a_point", 0)),
            "rves": counts.get("rves_advanced", 0)}


def energy_error(run):
    errors = run["summary"]["errors"]
    return errors.get("worst_energy_error", errors.get("worst_rve_energy_error", math.nan))


def judge(entry, table, reference_runs, folder):
    """Rows of a study: `table` is a list of (settings, runs by seed). Errors are relative to the reference."""
    paired = reference_runs is not None and entry.get("paired", True)
    reference = [measured(r["columns"], entry)
                 for r in reference_runs] if reference_runs is not None else [known_reference(entry, folder)]
    scale = entry.get("scale", abs(mean(reference)) or 1.0)
    rows = []
    for values, runs in table:
        found = [measured(r["columns"], entry) for r in runs]
        off, half = difference(found, reference, paired)
        costs = [cost(r) for r in runs]
        row = {
            "settings": values, "value": mean(found), "error": abs(off) / scale, "signed": off / scale,
            "interval": half / scale, "scatter": interval(found)[1] / scale, "seeds": len(runs),
            "energy": max(energy_error(r) for r in runs),
            "status": ",".join(sorted({str(r["summary"]["status"]) for r in runs}))
        }
        for name in costs[0]:
            row[name] = mean([c[name] for c in costs])
        if math.isnan(row["error"]):
            row["error"], row["status"] = math.inf, row["status"] + " (not reached)"
        rows.append(row)
    result = {
        "rows": rows, "reference": mean(reference), "front": pareto([(r["cpu"], bound(r)) for r in rows]),
        "recommended": recommended(rows), "order": None
    }
    keys = list(entry["vary"])
    if len(keys) == 1 and entry.get("order", True) and all(isinstance(v, (int, float)) for v in entry["vary"][keys[0]]):
        clear = [
            r for r in rows if math.isfinite(r["error"]) and (math.isnan(r["interval"]) or r["error"] > r["interval"])
        ]
        result["order"] = power_law([(r["settings"][keys[0]], r["error"]) for r in clear])
    return result
