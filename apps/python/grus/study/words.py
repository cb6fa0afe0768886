# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers and places as tables of a study say them."""
import math


def short(v):
    return f"{v:.4g}" if isinstance(v, float) else str(v)


def percent(x):
    return "-" if math.isnan(x) else f"{100 * x:.2g} %" if math.isfinite(x) else "not reached"


def describe(entry):
    how = entry.get("measure", "at")
    where = f" at {entry.get('over', 'axial_strain')} {entry['at']:g}" if how == "at" else ""
    return f"{entry['quantity']}{where}" + ("" if how == "at" else f", {how}")
