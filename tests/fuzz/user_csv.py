# SPDX-License-Identifier: LGPL-3.0-or-later
"""Measured data as spreadsheets and instruments write them: curves, sieve gradings, strengths."""
import itertools
import os

WAYS = ("semicolon", "tab", "spaces", "decimal comma", "byte order mark", "utf-16", "windows", "sep line",
        "unit in brackets", "unit after slash", "percent", "columns turned round", "more columns", "quoted", "comments",
        "empty lines", "trailing separator", "no names", "misspelt name", "capitals", "value missing",
        "one value too many", "thousands", "word for a value", "rows twice", "negative", "unknown unit")
STYLES = WAYS[:17]
FAULTS = ("no names", "misspelt name", "capitals", "value missing", "one value too many", "word for a value",
          "unknown unit")
spoil = itertools.cycle(FAULTS)  # in turn
TARGETS = {
    "curve": (("axial_strain", "axial_stress_Pa"), {"kind": "curve", "x": "axial_strain", "y": "axial_stress_Pa"}),
    "grading": (("diameter_m", "passing"), {"kind": "grading", "at": 0.1}),
    "quantiles": (("value",), {"kind": "quantiles", "quantity": "results.peak_before_breakage_Pa"})
}
UNITS = {
    "axial_stress_Pa": (("MPa", 1e6), ("kPa", 1e3), ("GPa", 1e9)), "diameter_m": (("mm", 1e-3), ("µm", 1e-6)),
    "value": (("MPa", 1e6), ("N/mm2", 1e6))
}


class Case:
    def __init__(self, path, table, did, means, must_read, must_refuse):
        self.path, self.table, self.did, self.means = path, table, did, means
        self.must_read, self.must_refuse, self.name = must_read, must_refuse, os.path.basename(path)

    def read(self):
        from grus.calibrate.targets import Target
        from grus.files.texts import BadData
        try:
            t = Target({"name": "t", "data": self.name, **self.table}, os.path.dirname(self.path))
        except BadData as e:
            return "refused", str(e)
        return "read", (list(t.x) if t.kind != "quantiles" else []) + list(t.values)


def draw(rng, folder, _binaries):
    did = rng.sample(STYLES, rng.randint(1, 4)) + ([next(spoil)] if rng.random() < 0.3 else [])
    columns_needed = {"spaces", "value missing"} & set(did)  # which one column cannot have
    kind = rng.choice([k for k in sorted(TARGETS) if len(TARGETS[k][0]) > 1 or not columns_needed])
    names, table = TARGETS[kind]
    count = rng.randint(3, 9)
    rows = [[k + 1 + rng.random() for k in range(count)] for _ in names]
    if kind != "quantiles":
        rows = [sorted(r) for r in rows]
    if kind == "grading":
        rows[1] = [v / 20 for v in rows[1]]
    if kind == "curve":
        rows[0] = [v / 100 for v in rows[0]]
    if kind == "quantiles":
        rows[0] = [1e6 * v for v in rows[0]]  # Pa, and a strength even where no unit is told
    did += [w for w in ("rows twice", "negative", "thousands") if rng.random() < 0.1]
    way = set(did)
    if "spaces" in way and "unknown unit" not in way:  # with these no reader could tell columns
        way -= {"unit in brackets", "unit after slash", "percent", "quoted", "trailing separator", "semicolon", "tab"}
    if "negative" in way and kind == "grading":
        way.discard("negative")
    if "negative" in way:
        rows[-1] = [-v for v in rows[-1]]
    heads, scales = list(names), [1.0] * len(names)
    for k, name in enumerate(names):
        choice = rng.choice(
            UNITS.get(name, (("%", 0.01),) if name in ("axial_strain", "passing") and "percent" in way else
                      ((None, 1.0),)))
        if choice[0] and way & {"unit in brackets", "unit after slash", "percent"}:
            base = name.rsplit("_", 1)[0] if rng.random() < 0.5 and name.endswith(("_Pa", "_m")) else name
            scales[k] = choice[1]
            heads[k] = f"{base} / {choice[0]}" if "unit after slash" in way else f"{base} [{choice[0]}]" if rng.random(
            ) < 0.5 else f"{base} ({choice[0]})"
    if "unknown unit" in way:
        heads[-1] = f"{names[-1]} [psi]"
    if "misspelt name" in way:
        heads[-1] = heads[-1].replace("a", "e", 1)
    if "capitals" in way:
        heads[-1] = heads[-1].upper()
    separator = ";" if "semicolon" in way else "\t" if "tab" in way else "  " if "spaces" in way else ","
    if separator == "  " and (
            way & {"unit in brackets", "unit after slash", "percent", "quoted", "unknown unit", "trailing separator"}
            or len(names) == 1):
        separator, _ = ",", way.discard("spaces")
    comma = "decimal comma" in way
    columns = list(zip(heads, rows, scales))
    if "more columns" in way:
        columns.insert(rng.randint(0, len(columns)), ("specimen", list(range(1, count + 1)), None))
    if "columns turned round" in way:
        columns.reverse()

    def text(v, scale):
        if scale is None:
            return str(v)
        t = f"{v / scale:.12g}"
        if "thousands" in way and 1 <= abs(v / scale) < 1e15:
            t = f"{v / scale * 1e6:,.3f}"
        return f"{t.replace('.', ',')}" if comma and "thousands" not in way else t

    lines = [[h for h, _, _ in columns]] + [[text(r[k], s) for _, r, s in columns] for k in range(count)]
    if "thousands" in way:
        did.append("thousands")
    if "rows twice" in way:
        lines += lines[1:]
        rows = [r + r for r in rows]
    if "no names" in way:
        lines = lines[1:]
    place = [c[0] for c in columns].index(heads[-1])
    victim = len(lines) // 2
    if "word for a value" in way:
        lines[victim][place] = "broken"
    if "value missing" in way and len(columns) == 1:  # an empty line
        way.discard("value missing")
    if "value missing" in way:
        lines[victim][place] = ""
    if "one value too many" in way:
        lines[victim].append("7")
    quote = '"' if "quoted" in way or (comma and separator == "," and rng.random() < 0.5) else ""
    body = [separator.join(f"{quote}{c}{quote}" for c in line) for line in lines]
    if "trailing separator" in way and separator != "  ":
        body = [line + separator for line in body]
    if "comments" in way:
        body.insert(rng.randint(0, 1), "# measured on a Tuesday; by hand")
    if "empty lines" in way:
        body.insert(len(body) - 1, "")
        body.append("")
    if "sep line" in way and separator in ";,":
        body.insert(0, f"sep={separator}")
    whole = ("\r\n" if rng.random() < 0.5 else "\n").join(body) + "\n"
    encodings = {"utf-16": "utf-16", "byte order mark": "utf-8-sig", "windows": "cp1252"}
    encoding = next((encodings[w] for w in encodings if w in way), "utf-8")
    path = os.path.join(folder, "measured.csv")
    with open(path, "wb") as f:
        f.write(whole.encode(encoding))
    bare_comma = comma and separator == "," and not quote
    spoiled = way & set(FAULTS) or ("thousands" in way) or (bare_comma and len(columns) > 1)
    doubtful = spoiled or bare_comma or comma
    if kind == "quantiles":
        means = sorted(rows[0])
    else:
        means = list(rows[0]) + list(rows[1])
    did = [w for w in did if w in way or w == "thousands"]
    return Case(path, table, did, means, not doubtful,
                bool(way & set(FAULTS)) and not ("no names" in way and "thousands" in way))
