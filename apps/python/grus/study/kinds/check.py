# SPDX-License-Identifier: LGPL-3.0-or-later
"""[[check]]: a claim, held against what the runs say."""
import math

from grus.errors import InputError
from grus.figures import table as html_table
from grus.files.texts import text_table
from grus.runs.censored import mean_of
from grus.runs.schema import NAMES, NUMBER, POSITIVE, STRAINS, TEXT, tables
from grus.study.numbers import found, unfinished_text
from grus.study.statistics import mean
from grus.study.tables import Shown, asked

NAME = "check"
HOW_FAR = ("results.final_time_s",)  # a claim on it may be of runs that do not finish
SCHEMA = tables({
    "claim": TEXT, "greater": {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
    "factor": NUMBER, "at": STRAINS, "case": TEXT, "cases": NAMES, "near": {"type": "number", "not": {"const": 0}},
    "tolerance": POSITIVE, "between": {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2},
    "below": NUMBER, "quantity": TEXT
}, ("claim",))


def read(given, reading):
    for t in given:
        where = f"{reading.path}: check '{t['claim']}'"
        if ("greater" in t) == ("case" in t or "cases" in t):
            raise InputError(f"{where}: needs either greater, or case or cases")
        if "greater" not in t and not ("below" in t or "between" in t or ("near" in t and "tolerance" in t)):
            raise InputError(f"{where}: needs near with tolerance, between or below")
        refuse_impossible(where, t)
        reading.named(where, [*t.get("cases", []), *t.get("greater", []), *([t["case"]] if "case" in t else [])])
    return given


def refuse_impossible(where, t):
    """What no run could meet, or what nobody would look at."""
    ways = [key for key in ("greater", "near", "between", "below") if key in t]
    if len(ways) > 1:
        raise InputError(f"{where}: {ways[0]} and {ways[1]} are two claims: give one each its [[check]]")
    for key, of in (("tolerance", "near"), ("factor", "greater")):
        if key in t and of not in t:
            raise InputError(f"{where}: {key} is of {of}, which is not there; leave it out")
    if "between" in t and t["between"][0] > t["between"][1]:
        raise InputError(f"{where}: between: {t['between'][0]:g} is above {t['between'][1]:g}; the lower one is first")
    if t.get("below", 0) < 0:
        raise InputError(f"{where}: below: {t['below']:g}: is of a size without its sign, which is never below 0")
    if "at" in t and "." in t.get("quantity", ""):
        raise InputError(f"{where}: at is of a column; '{t['quantity']}' is of the whole run: leave at out")


def cases(_entry):
    return []


def asks(entry, _common):
    return [asked(name, entry.get("quantity", "axial_stress_Pa"))
            for name in entry.get("greater", entry.get("cases", [entry.get("case")]))]


def check_of(check, runs):
    """(passed, text) of a claim."""
    quantity = check.get("quantity", "axial_stress_Pa")
    names = check.get("greater", check.get("cases", [check.get("case")]))
    stopped = unfinished_text([r for name in names for r in runs[name]])
    if stopped and quantity not in HOW_FAR:
        return False, stopped
    if "greater" in check:
        high, low = check["greater"]
        texts, ok = [], True
        for strain in check.get("at", [None]):
            _, a, beyond = mean_of(found(runs[high], quantity, strain))  # here a lower bound is enough
            b, _, unbroken = mean_of(found(runs[low], quantity, strain))
            ok = ok and a > check.get("factor", 1.0) * b
            where = "" if strain is None else f" at {strain:g}"
            texts.append(f"{'> ' if beyond else ''}{a:.4g} / {b:.4g} = {a / b if b else math.inf:.3g}{where}" +
                         (f" ({beyond + unbroken} not broken)" if beyond + unbroken else ""))
        return ok, f"{high} / {low}: " + "; ".join(texts)
    pairs = [x for name in check.get("cases", [check.get("case")]) for strain in check.get("at", [None])
             for x in found(runs[name], quantity, strain)]
    v = [x for x, _ in pairs if not math.isnan(x)]
    if len(v) < len(pairs):  # what is not known cannot hold
        unbroken = mean_of(pairs)[2]
        why = f": {unbroken} grains did not break" if unbroken else ""
        return False, f"{len(pairs) - len(v)} of {len(pairs)} values are not there{why}"
    if "near" in check:
        worst = max(abs(x / check["near"] - 1) for x in v)
        return worst <= check["tolerance"], f"{mean(v):.5g} against {check['near']:g}: {100 * worst:.2f} % off at worst"
    if "between" in check:
        low, high = check["between"]
        return all(low <= x <= high for x in v), f"{min(v):.4g} … {max(v):.4g}, asked {low:g} … {high:g}"
    return all(abs(x) <= check["below"] for x in v), f"at most {max(map(abs, v)):.3g}, asked {check['below']:g}"


def show(entries, done):
    passed, rows = True, []
    for check in entries:
        ok, detail = check_of(check, done.runs)
        passed = passed and ok
        rows.append(["holds" if ok else "DOES NOT HOLD", check["claim"], detail])
    if not rows:
        return Shown()
    head = ["", "claim", "measured"]
    return Shown("\n" + text_table(head, rows), "<h2>Claims</h2>" + html_table(head, rows), passed)
