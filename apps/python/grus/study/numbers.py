# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of a run: of a column of history.csv where it is asked for, or of summary.json by a dotted name; what it
cost."""
import math

from grus.runs.censored import mean_of, strength_of
from grus.study.statistics import deviation


def finished(run):
    """Whether it got to its end: what another one tells is cut short, or wrong, and is evidence of nothing."""
    return run["summary"].get("status") == 0


def statuses(runs):
    """The statuses of runs as a table tells them."""
    return ",".join(sorted({str(r["summary"]["status"]) for r in runs}))


def unfinished_mark(runs):
    """What a table adds to them where runs are left out of its means."""
    count = sum(not finished(r) for r in runs)
    return f" ({count} not finished)" if count else ""


def unfinished_text(runs):
    """How many of some runs did not get to their end, and with what status."""
    stopped = [r for r in runs if not finished(r)]
    if not stopped:
        return ""
    kinds = ", ".join(sorted({str(r["summary"].get("status")) for r in stopped}))
    return f"{len(stopped)} of {len(runs)} runs did not finish (status {kinds})"


def position(columns, name, x, over="axial_strain"):
    """Column where another first reaches x, rising or falling, linear between rows; NaN where the run does not reach
    it."""
    xs, ys = columns[over], columns[name]
    for k in range(1, len(xs)):
        step = xs[k] - xs[k - 1]
        past = x - xs[k] if step > 0 else xs[k] - x
        if step != 0 and (x - xs[k - 1]) * step >= 0 and past <= 1e-9 * abs(xs[k]):
            return ys[k - 1] + (x - xs[k - 1]) / step * (ys[k] - ys[k - 1])
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


def of_summary(run, path):
    """A number of summary.json; NaN where it has none, as a grain that did not break has no strength."""
    return strength_of(run, path)[0]


def found(runs, quantity, place=None, over="axial_strain"):
    """(value, bound) of each run at a place, a value of the column `over`; without one, at the end. Where a run has no
    value, it may be known to be above the bound."""
    if "." in quantity:
        return [strength_of(r, quantity) for r in runs]
    columns = [r["columns"] for r in runs]
    return [(c[quantity][-1] if place is None else position(c, quantity, place, over), math.nan) for c in columns]


def cell_text(pairs):
    """Mean and scatter over runs; a lower bound of the mean where grains did not break."""
    middle, least, unbroken = mean_of(pairs)
    if unbroken:
        return f"{'-' if math.isnan(least) else f'> {least:.4g}'} ({unbroken} of {len(pairs)} not broken)"
    scatter = f" ± {deviation([v for v, _ in pairs]):.2g}" if len(pairs) > 1 else ""
    return "-" if math.isnan(middle) else f"{middle:.4g}{scatter}"


def cost(run):
    seconds, counts = run["summary"]["seconds"], run["summary"]["counts"]
    return {"cpu": seconds.get("cpu", seconds.get("cpu_rank0", math.nan)),
            "wall": sum(v for k, v in seconds.items() if k in ("loading_wall", "solve_wall")),
            "grain_steps": counts.get("grain_steps", counts.get("dem_steps", 0) * counts.get("grains_a_point", 0)),
            "rves": counts.get("rves_advanced", 0)}


def energy_error(run):
    errors = run["summary"]["errors"]
    return errors.get("worst_energy_error", errors.get("worst_rve_energy_error", math.nan))
