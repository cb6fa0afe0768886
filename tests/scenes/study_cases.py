#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table of cases of grus-study, from runs whose numbers are known: study_cases.py BIN"""
import csv
import math
import os
import sys
import tempfile
from types import SimpleNamespace

sys.path.insert(0, os.path.join(sys.argv[1], "..", "python"))
from grus.runs import schema  # noqa: E402
from grus.study import reader  # noqa: E402
from grus.study.kinds import case  # noqa: E402

import made_up  # noqa: E402
from scene_tools import faults, need  # noqa: E402


def table_of_cases(folder):
    """study.csv: every column from runs whose numbers are known."""
    key = "results.peak_before_breakage_Pa"
    graded = [made_up.run(cpu=2.0, energy=0.01, counts={"steps": 10}, y=8.0, results={"peak_before_breakage_Pa": 5.0}),
              made_up.run(0, cpu=4.0, energy=0.03, counts={"dem_steps": 30}, y=16.0, grains=[9.0] * 3,
                          breakages=[0.0, 0.0, 0.0], results={"peak_axial_stress_Pa": 9.0})]
    common = {"quantities": ["y", key], "at": [0.25, 0.5]}
    done = SimpleNamespace(out=folder, common=common, runs={"c": graded})
    shown = case.show([{"name": "c", "label": "A case"}], done)
    with open(os.path.join(folder, "study.csv"), newline="") as f:
        head, row = csv.reader(f)
    found = dict(zip(head, row))
    wanted = {
        "case": "c", "seeds": "2", "status": "0", "mean_y_at_0.25": 3.0, "sd_y_at_0.25": math.sqrt(2),
        "mean_y_at_0.5": 6.0, "sd_y_at_0.5": 2 * math.sqrt(2), f"mean_{key}": "", f"sd_{key}": "",
        "grains": 8.5, "breakages": 1.5, "worst_energy_error_percent": 3.0, "steps": 20.0, "cpu_s": 3.0,
        f"at_least_{key}": 7.0, f"not_broken_{key}": "1"
    }
    need(set(found) == set(wanted), f"columns of study.csv: {set(found) ^ set(wanted)}")
    for name, value in wanted.items():
        good = found[name] == value if isinstance(value, str) else abs(float(found[name]) - value) < 1e-12
        need(good, f"study.csv: {name} = {found[name]}, not {value}")
    need(shown.text.splitlines()[2].split() ==
         "A case 2 0 3 ± 1.4 6 ± 2.8 > 7 (1 of 2 not broken) 8 2 3.00 20 3.0".split(),
         f"study.txt: {shown.text}")
    need(shown.passed and "> 7 (1 of 2 not broken)" in shown.body.replace("&gt;", ">"), "the table in report.html")

    def told(common, runs):
        text = case.show([{"name": "c", "label": "c"}],
                         SimpleNamespace(out=folder, common=common, runs={"c": runs})).text
        with open(os.path.join(folder, "study.csv"), newline="") as f:
            return text.splitlines()[2].split()[1:], dict(zip(*csv.reader(f)))

    # What stopped counts for nothing but its energy error: not for a mean, nor for what a run costs.
    stopped = made_up.run(3, cpu=900.0, energy=0.5, counts={"steps": 9000}, y=800.0, grains=[900.0] * 3)
    words, row = told({**common, "quantities": ["y"]}, [*graded, stopped])
    need(words == "3 0,3 (1 not finished) 3 ± 1.4 6 ± 2.8 8 2 50.00 20 3.0".split(),
         f"beside one that stopped: {words}")
    words, row = told(common, [stopped])
    need(words == "1 3 (1 not finished) - - - - - 50.00 - -".split() and row[f"not_broken_{key}"] == "0" and
         row["mean_y_at_0.5"] == "" == row["sd_y_at_0.5"], f"all stopped: {words} {row}")
    # At the end, and at places of another column.
    ends = {"quantities": ["y", key], "at": "end"}
    words, row = told(ends, graded)
    need(float(row["mean_y_at_end"]) == 12 and words[2:5] == "12 ± 5.7".split(), f"at the end: {words} {row}")
    need(case.asks({"name": "c"}, {**ends, "over": "t"}) == [("c", {"y", "t"}, set()), ("c", set(), {key})],
         "what a table over another column asks for")
    words, row = told({"quantities": ["axial_strain"], "over": "y", "at": [4]}, graded)
    need(abs(float(row["mean_axial_strain_at_y_4"]) - 0.375) < 1e-12, f"where another column is 4: {row}")


def places():
    """Where a table looks: at strains, or at the end; what is neither is told what it must be."""
    said = [schema.fault({"at": at}, reader.COMMON) for at in ([0.1], "end", "e", 0.1)]
    need(said == [None, None, *(f"at: {x}: must be a list of numbers or \"end\"" for x in ("'e'", "0.1"))], f"{said}")
    need(schema.fault({"at": "end"}, schema.table({"at": schema.AT})) ==
         "at: 'end': must be a number or a list of numbers", "places of a claim")


places()
with tempfile.TemporaryDirectory() as tmp:
    table_of_cases(tmp)
print(f"study_cases: {len(faults)} faults")
sys.exit(1 if faults else 0)
