# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads tables that people bring: CSV files of a spreadsheet or an instrument. A table is read as the numbers that its
author meant, in SI, or it is refused in one line with file, line and column.

Separator: tab, semicolon, comma or spaces. Decimal mark: point, or comma where the comma does not part the columns. The
first line holds the names of the columns; a name may carry a unit, "strength [MPa]", "passing (%)", "time / ms"."""
import csv
import difflib
import math
import re
import typing

from grus.files.texts import BadData, text_of

UNITS = {
    "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12, "N/mm2": 1e6, "N/mm^2": 1e6, "bar": 1e5, "%": 0.01,
    "-": 1.0, "1": 1.0, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "s": 1.0,
    "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "min": 60.0, "h": 3600.0, "N": 1.0, "mN": 1e-3, "kN": 1e3,
    "MN": 1e6, "kg": 1.0, "g": 1e-3, "J": 1.0, "mJ": 1e-3, "kJ": 1e3, "1/s": 1.0
}
KINDS = {
    "Pa": "Pa kPa MPa GPa TPa N/mm2 N/mm^2 bar".split(), "m": "m cm mm um µm μm nm".split(),
    "s": "s ms us µs μs min h".split(), "N": "N mN kN MN".split(), "kg": "kg g".split(), "J": "J mJ kJ".split(),
    "1_s": ["1/s"], "1": ["%", "-", "1"]
}
AFTER_UNDERSCORE = [u for u in UNITS if u not in ("1", "-", "min")]  # these are numbers and the least of something
OTHER_NAMES = {"error": ["error", "errors", "err", "std", "stdev", "std_dev", "stddev", "sd", "sem", "uncertainty",
                         "deviation", "standard_deviation", "standard_error"]}
least_stress = 1e4  # Pa; what people measure and do not give a unit is larger, or in another unit
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
COMMA_NUMBER = re.compile(r"[-+]?(\d+,?\d*|,\d+)([eE][-+]?\d+)?")


def lines_of(path):
    """(number, text) of the lines that are neither empty nor a comment, and the separator if a line "sep=;" names
    it."""
    found, told = [], None
    for number, line in enumerate(text_of(path).splitlines(), 1):
        plain = line.strip()
        if re.fullmatch(r"sep=.", plain) and not found:
            told = plain[4]
        elif plain and not plain.startswith("#"):
            found.append((number, line))
    return found, told


def kind_of(name):
    """Of what a quantity of Grus is: the SI unit that its name ends with, "1" where it ends with none."""
    return next((si for si in sorted(KINDS, key=len, reverse=True) if name.endswith("_" + si)), "1")


def fields_of(path, lines, separator):
    if separator == " ":
        return [(n, line.split()) for n, line in lines]
    rows = []
    for number, line in lines:
        try:
            row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
        except csv.Error as e:
            raise BadData(f"{path}:{number}: not a line of a table: {e}") from None
        rows.append((number, [c.strip() for c in row]))
    while rows and all(len(r) > 1 and not r[-1] for _, r in rows):  # each line ends with a separator
        rows = [(n, r[:-1]) for n, r in rows]
    return rows


def is_number(text, decimal_comma=False):
    return bool((COMMA_NUMBER if decimal_comma else NUMBER).fullmatch(text))


def separator_of(path, lines, told):
    head = lines[0][1]
    if told:
        return told
    for mark in ("\t", ";"):
        if mark in head or all(mark in line for _, line in lines[1:]):
            return mark
    # A comma in every line of numbers under one name without a comma is a decimal mark.
    if "," not in head and all(COMMA_NUMBER.fullmatch(line.strip()) for _, line in lines[1:]):
        return ";"
    if "," in head or any("," in line for _, line in lines[1:]):
        return ","
    if len(lines[1][1].split()) == len(head.split()) > 1:
        return " "
    return ","


def name_and_unit(head):
    """A column's name, and its unit if it carries one."""
    for pattern in (r"(.*?)\s*\[(.*)\]", r"(.*?)\s*\(([^()]*)\)", r"(.*\S)\s+/\s+(\S+)", r"(.*\S)\s+in\s+(\S+)"):
        m = re.fullmatch(pattern, head)
        if m and m[1].strip():
            return m[1].strip(), m[2].strip()
    return head, None


class Place(typing.NamedTuple):
    """Where a column is, and its unit if it carries one."""
    at: int
    unit: str | None


class Table:
    """Names of columns with their units, and rows of texts by line."""

    def __init__(self, path):
        self.path = path
        lines, told = lines_of(path)
        if len(lines) < 2:
            raise BadData(f"{path}: no rows" if lines else f"{path}: is empty")
        rows = fields_of(path, lines, separator_of(path, lines, told))
        (self.head_line, head), self.rows = rows[0], rows[1:]
        for number, row in self.rows:
            if len(row) != len(head):
                hint = ("; where ',' is the decimal mark, ';' must part the columns"
                        if len(row) > len(head) and "," in dict(lines)[number] else "")
                raise BadData(
                    f"{path}:{number}: {len(row)} values under {len(head)} name{'s' if len(head) != 1 else ''}{hint}")
        if all(is_number(h) or is_number(h, True) for h in head):
            raise BadData(f"{path}:{self.head_line}: the columns have no names: put a line of names first")
        self.head = [h.strip("'\" ") for h in head]
        self.named = [name_and_unit(h) for h in self.head]
        for before, h in zip(self.head, self.head[1:]):
            if h in UNITS and not (h == "min" and "max" in self.head):
                raise BadData(f"{path}:{self.head_line}: column '{h}' has the name of a unit: "
                              f"write the unit in brackets, '{before} [{h}]'")
        cells = [(f"{path}:{n}: column '{h}'", c) for n, row in self.rows for h, c in zip(self.head, row)]
        with_comma = [(where, c) for where, c in cells if "," in c and is_number(c, True)]
        with_point = [(where, c) for where, c in cells if "." in c and is_number(c)]
        self.decimal_comma = bool(with_comma)
        if with_comma and with_point:  # one of them marks thousands, in whatever column
            (where, c), (_, other) = with_point[0], with_comma[0]
            raise BadData(f"{where}: '{c}' has a point, '{other}' a comma: write one decimal mark and no mark of "
                          "thousands")
        if with_comma and all(re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}", c) for _, c in with_comma):
            where, c = with_comma[0]
            raise BadData(f"{where}: '{c}' may be a decimal comma or a mark of thousands: write a decimal point")

    def place(self, name):
        """Where the column of a name is, or None; the name is met exactly, or with a unit in brackets or after
        an underscore, which takes the place of its ending."""
        found, exact = [], name in self.head and kind_of(name) != "1"
        for k, (plain, unit) in enumerate(self.named):
            if unit is None and self.head[k] != name and not exact:
                at = next((u for u in AFTER_UNDERSCORE if plain.endswith("_" + u)), None)
                stem = plain[:-len(at) - 1] if at else ""
                alone = stem if name in ("value", "error") or at not in KINDS else ""  # sigma_Pa is a name, of no sigma
                if stem and name in (alone, *(f"{stem}_{si}" for si, units in KINDS.items() if at in units)):
                    plain, unit = stem, at
            endings = ["_" + si for si, units in KINDS.items() if unit in units]
            if name == self.head[k] or name == plain or (endings and name == plain + endings[0]):
                found.append(Place(k, unit))
        if len(found) > 1:
            raise BadData(f"{self.path}:{self.head_line}: two columns are called '{name}'")
        return found[0] if found else None

    def needed(self, name):
        place = self.place(name)
        if place is None:
            near = difflib.get_close_matches(name, self.head, 1, 0.6)
            hint = f" (did you mean '{near[0]}'?)" if near else ""
            have = ", ".join(f"'{h}'" for h in self.head)
            raise BadData(f"{self.path}:{self.head_line}: no column is called '{name}'{hint}; there are {have}")
        return place

    def forbid_near(self, name, beside):
        """Refuses a column that is nearly called as an optional one that is not there: it would be left out unheard."""
        if self.place(name) is not None:
            return
        asked = [place.at for place in map(self.place, beside) if place]
        others = OTHER_NAMES.get(name, [name])
        of = [s for n in beside for s in (n.lower(), n.removesuffix("_" + kind_of(n)).lower())]
        others = {t for o in others for t in (o, *(f"{n}_{o}" for n in of), *(f"{o}_{n}" for n in of))}
        units = {u.lower() for u in AFTER_UNDERSCORE}
        for k, (plain, _) in enumerate(self.named):
            plain = re.sub(r"\W+", "_", plain.lower()).strip("_")
            stem, _, last = plain.rpartition("_")
            near = (plain in others or (stem in others and last in units) or plain.startswith(name + "_")
                    or difflib.get_close_matches(plain, [name], 1, 0.8))
            if near and k not in asked:
                raise BadData(f"{self.path}:{self.head_line}: column '{self.head[k]}': did you mean '{name}'?")

    def called(self, place):
        return f"{self.path}:{self.head_line}: column '{self.head[place.at]}'"

    def scale(self, place, quantity):
        """What turns a column into SI; its unit must be one of what `quantity`, a name that ends with its unit, is."""
        if place.unit is None:
            return 1.0
        if place.unit not in UNITS:
            raise BadData(f"{self.called(place)}: unit '{place.unit}' is not known")
        if place.unit not in KINDS[kind_of(quantity)]:
            raise BadData(f"{self.called(place)}: '{place.unit}' is no unit of {quantity}")
        return UNITS[place.unit]

    def check_stress(self, place, quantity, values):
        """Refuses stresses of no strength at all whose unit nobody has told: they are hardly in Pa."""
        head, largest = self.head[place.at], max(map(abs, values), default=0)
        if kind_of(quantity) != "Pa" or place.unit or kind_of(head) == "Pa" or not 0 < largest < least_stress:
            return
        raise BadData(f"{self.called(place)}: without a unit its largest value would be {largest:g} Pa: give the unit "
                      f"in the head: '{head} (MPa)', or '{head} (Pa)' if that is meant")

    def numbers(self, place, quantity, of_error=False):
        """A column in SI; `of_error`: standard deviations, which may be small."""
        scale, values = self.scale(place, quantity), []
        for line, row in self.rows:
            text = row[place.at]
            if self.decimal_comma and is_number(text, True):
                text = text.replace(",", ".")
            if not is_number(text):
                raise BadData(f"{self.path}:{line}: column '{self.head[place.at]}': "
                              + (f"{text!r} is no number" if text else "no value"))
            value = scale * float(text)
            if not math.isfinite(value):
                raise BadData(f"{self.path}:{line}: column '{self.head[place.at]}': {text!r} is not finite")
            values.append(value)
        if not of_error:
            self.check_stress(place, quantity, values)
        return values


def read_columns(path, names, optional=(), quantity=None):
    """Columns of a file by their names, in SI, as lists; of `optional` names None where there is no such column.
    These and the last of `names` are of `quantity`, or of what the last name says."""
    table, quantity = Table(path), quantity or names[-1]
    for name in optional:
        table.forbid_near(name, names)
    needed, others = [table.needed(n) for n in names], [table.place(n) for n in optional]
    for place in others:
        if place is not None and needed[-1].unit and not place.unit:
            raise BadData(f"{table.called(place)} needs its unit, as '{table.head[needed[-1].at]}' has one")
    return [*(table.numbers(p, q) for p, q in zip(needed, [*names[:-1], quantity])),
            *(None if p is None else table.numbers(p, quantity, of_error=True) for p in others)]


class Columns:
    """All columns of a file by their names, in SI, each read when it is asked for. `quantities`: what a column is of,
    where its name does not say so."""

    def __init__(self, path, quantities=None):
        self.table, self.quantities = Table(path), quantities or {}

    def __getitem__(self, name):
        return self.table.numbers(self.table.needed(name), self.quantities.get(name, name))


def range_text(values, name):
    """The least and the largest, in a unit that people read: of what ends with _Pa or _m."""
    low, high = min(values), max(values)
    size = max(abs(low), abs(high))
    for ending, units in (("_Pa", ("GPa", "MPa", "kPa", "Pa")), ("_m", ("m", "mm", "µm"))):
        if name.endswith(ending):
            unit = next((u for u in units if size >= UNITS[u]), units[-1])
            return f"{low / UNITS[unit]:.4g} … {high / UNITS[unit]:.4g} {unit}"
    return f"{low:.4g} … {high:.4g}"
