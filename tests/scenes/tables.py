#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables that people bring, one by one: numbers worked out by hand, or a line that names file, line and column.
tables.py BIN"""
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.calibrate.targets import Target  # noqa: E402
from grus.files.tables import Table, read_columns  # noqa: E402
from grus.files.texts import BadData  # noqa: E402
from grus.study.kinds.precision import known_reference  # noqa: E402

STRENGTH, faults = "results.peak_before_breakage_Pa", []


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


def taken(folder, text, names, quantity=None):
    """Columns, or the refusal without the file's folder."""
    path = os.path.join(folder, "t.csv")
    with open(path, "w") as f:
        f.write(text)
    try:
        return read_columns(path, names, ["error"], quantity)
    except BadData as e:
        return str(e).replace(folder + os.sep, "")


def tables(folder):
    def read(want, *args):
        found = taken(folder, *args)
        need(found == want, f"{args}: {found}")

    def begins(start, *args):
        found = taken(folder, *args)
        need(str(found).startswith(start), f"{args}: {found}")

    # A point that marks thousands beside decimal commas in another column, which nobody asked for: 1234, not 1.234.
    begins("t.csv:2: column 'value': '1.234'", "value;b\n1.234;2,5\n5.678;3,5\n", ["value"])
    begins("t.csv:3: column 'value': '5.6'", "value;b\n1,5;2\n5.6;3\n", ["value"])
    begins("t.csv:2: column 'value': '1,234' may be", "value\n1,234\n5,678\n", ["value"])
    read([[1.234, 5.67], None], "value\n1,234\n5,67\n", ["value"])
    # A unit of another kind than the quantity.
    begins("t.csv:1: column 'value [mm]'", "value [mm]\n1\n2\n", ["value"], STRENGTH)
    begins("t.csv:1: column 'value [%]'", "value [%]\n1\n2\n", ["value"], STRENGTH)
    curve = ["axial_strain", "axial_stress_Pa"]
    begins("t.csv:1: column 'axial_strain [MPa]'", "axial_strain [MPa],axial_stress_Pa\n1,2\n", curve)
    begins("t.csv:1: column 'error [mm]'", "value [MPa],error [mm]\n1,2\n", ["value"], STRENGTH)
    read([[1e6, 2e6], [3e3, 4e3]], "value [MPa],error [kPa]\n1,3\n2,4\n", ["value"], STRENGTH)
    read([[2.0], None], "strain_rate_1_s [1/s]\n2\n", ["strain_rate_1_s"])
    # A column of errors that is misspelt is not left out unheard.
    begins("t.csv:1: column 'Error': did you mean 'error'", "value,Error\n1,2\n", ["value"])
    begins("t.csv:1: column 'eror': did you mean 'error'", "value,eror\n1,2\n", ["value"])
    read([[1.0], None], "value,mirror\n1,2\n", ["value"])
    # A unit after an underscore, as Grus names its own columns.
    read([[1e6, 2e6], [3e3, 4e3]], "value_MPa,error_kPa\n1,3\n2,4\n", ["value"], STRENGTH)
    read([[5e6], [3.0]], "value,error_Pa\n5e6,3\n", ["value"], STRENGTH)
    read([[0.1], [2e6], [1e5]], "axial_strain;axial_stress_MPa;error_MPa\n0,1;2;0,1\n", curve)
    read([[2.0], None], "strain_rate_1_s\n2\n", ["strain_rate_1_s"])
    begins("t.csv:1: column 'error_mm'", "value,error_mm\n1e6,2\n", ["value"], STRENGTH)
    begins("t.csv:1: two columns are called 'error'", "value,error,error_Pa\n1,2,3\n", ["value"], STRENGTH)
    # Nor is what others call an error.
    for head in ("err", "std", "sd", "SD [MPa]", "std_MPa", "value_sd", "value error", "error_low", "uncertainty"):
        begins(f"t.csv:1: column '{head}': did you mean 'error'", f"value [MPa],{head}\n1,2\n", ["value"])
    begins("t.csv:1: column 'axial_stress_error_MPa'",
           "axial_strain,axial_stress_MPa,axial_stress_error_MPa\n1,2,3\n", curve)
    read([[1.0], None], "sd,value\n1,2\n", ["sd"])
    read([[1.0], [2.0], None], "axial_strain,energy_error,axial_stress_Pa\n1,9,2\n", curve)
    # A unit after a comma is a column of its own, and 72,5 would be two values.
    begins("t.csv:1: column 'MPa' has the name of a unit: write the unit in brackets, 'value [MPa]'",
           "value, MPa\n72,5\n81,0\n", ["value"], STRENGTH)
    begins("t.csv:1: column '%' has", "diameter_m,passing,%\n0.1,72,5\n", ["diameter_m", "passing"])
    read([[1.0], None], "value,min,max\n1,0,2\n", ["value"])
    # Strengths of some pascal are megapascals whose unit nobody told; where one is told, that is it.
    begins("t.csv:1: column 'strength': without a unit its largest value would be 48.3 Pa: give the unit in the head: "
           "'strength (MPa)'", "strength\n12.4\n48.3\n", ["strength"], STRENGTH)
    begins("t.csv:1: column 'mean strength'", "mean strength;error\n9,9;1\n", ["mean strength"], STRENGTH)
    for head, si in (("strength (Pa)", 1), ("strength [Pa]", 1), ("strength / MPa", 1e6), ("strength [kPa]", 1e3)):
        read([[1.5 * si, 48.25 * si], None], f"{head}\n1.5\n48.25\n", ["strength"], STRENGTH)
    read([[0.1], [250.0], [3.0]], "axial_strain,axial_stress_Pa,error\n0.1,250,3\n", curve)
    read([[1.2e7], [5e3]], "strength,error\n1.2e7,5e3\n", ["strength"], STRENGTH)
    read([[0.0, 0.0], None], "strength\n0\n0\n", ["strength"], STRENGTH)
    # Whoever looks for a column leaves the table as it is.
    with open(os.path.join(folder, "m.csv"), "w") as f:
        f.write("value_MPa,error_kPa\n1,3\n")
    table = Table(os.path.join(folder, "m.csv"))
    for name, unit in (("value_Pa", "MPa"), ("value", "MPa"), ("value_MPa", None), ("value_Pa", "MPa")):
        found = table.place(name)
        as_it_was = table.named == [("value_MPa", None), ("error_kPa", None)]
        need(found == (0, unit) and as_it_was, f"{name}: {found} {table.named}")
    begins("t.csv:2: not a line of a table", 'value,b\n"1,2\n', ["value"])
    with open(os.path.join(folder, "r.csv"), "w") as f:
        f.write("axial_strain (%);sigma [MPa]\n0,0;0,0\n2,0;3,0\n")
    entry = {"quantity": "axial_stress_Pa", "at": 0.01, "reference": {"file": "r.csv", "column": "sigma"}}
    need(abs(known_reference(entry, folder) - 1.5e6) < 1e-6, "a reference in MPa under a name of its own")


def run(broke=None, most=0.0, breakages=0):
    results = {"peak_axial_stress_Pa": most, **({} if broke is None else {"peak_before_breakage_Pa": broke})}
    return {"columns": {"breakages": [0, breakages]}, "grading": {}, "summary": {"results": results}}


def strengths(folder):
    with open(os.path.join(folder, "s.csv"), "w") as f:
        f.write("value (Pa)\n10\n20\n30\n")
    quantiles = {"name": "s", "kind": "quantiles", "data": "s.csv", "quantity": STRENGTH}
    # A grain that broke before the first row has no known strength: not 0, nor more than what its fragments bore.
    t = Target(quantiles, folder)
    values, _, _ = t.answer([run(10.0, 12.0, 1), run(20.0, 25.0, 1), run(30.0, 31.0, 1), run(0.0, 500.0, 1)])
    good = np.allclose(values, [10, 20, 30]) and t.told["stronger_than"] == 0
    need(good, f"broken before the first row: {values} {t.told}")
    t = Target(quantiles, folder)
    values, between, _ = t.answer([run(10.0, 12.0, 1), run(0.0, 1.0, 1), run(0.0, 1.0, 1)])
    need(np.allclose(values, 10) and np.isfinite(between).all(), f"one strength of three: {values}")
    # Where nothing broke, what stands for a strength in a summary is none.
    t = Target(quantiles, folder)
    t.answer([run(308.0, 308.0), run(10.0, 12.0, 1)])
    need(t.told["stronger_than"] == 1, f"a strength of a grain that did not break: {t.told}")
    # A mean over grains of which some did not break: at least 35 each, and told; without them it would be 10.
    t = Target({"name": "m", "kind": "value", "quantity": STRENGTH, "value": 1.0}, folder)
    values, _, _ = t.answer([run(10.0, 12.0, 1), run(None, 35.0)])
    good = np.allclose(values, 22.5) and t.told["stronger_than"] == 1
    need(good, f"mean with a grain that did not break: {values} {t.told}")


with tempfile.TemporaryDirectory() as tmp:
    tables(tmp)
    strengths(tmp)
print("tables:", len(faults), "faults")
sys.exit(bool(faults))
