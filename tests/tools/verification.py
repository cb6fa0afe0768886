#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of docs/verification.md, from what there is: verification.py BUILD [--check | --write] [--found TABLE]

Counts the tests that CTest knows in a full build, the faults of mutants.toml and who found them when the whole table
was last run (faults_found.csv, kept from a table that mutants.py --report has written: --found), the faults drawn at
random (random_faults.csv, kept by random_faults.py --record), and how many numbers and keys other tests hold. Prints
the page's part; --check: exit 1 where the page has another one, --write: puts it there.
"""
import argparse
import csv
import glob
import json
import os
import subprocess
import sys
import tomllib

here = os.path.dirname(os.path.abspath(__file__))
root = os.path.normpath(os.path.join(here, "..", ".."))
PAGE = os.path.join(root, "docs", "verification.md")
BEGIN, END = "## Figures\n", "\n## "
FOUND, DRAWN = os.path.join(here, "faults_found.csv"), os.path.join(here, "random_faults.csv")
LABELS = {"unit": "one function or rule", "physics": "a few grains to a sample", "fem": "finite elements, with RVEs",
          "scene": "whole programs", "style": "what the sources look like", "validation": "hours, not by default"}
ROOMS = {"dem": "grains", "fem": "finite elements", "coupling": "RVEs of points", "apps": "programs: scenes, output",
         "python": "Python package"}


def rows_of(path):
    if not os.path.exists(path):
        return []
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def toml_of(*names):
    with open(os.path.join(root, *names), "rb") as f:
        return tomllib.load(f)


def table(head, rows):
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (head, ["---"] * len(head), *rows)) + "\n"


def labels_of(test):
    return next((p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"), [])


def of_tests(build):
    told = json.loads(subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True,
                                     text=True, check=True).stdout)["tests"]
    by = {label: sum(label in labels_of(t) for t in told) for label in LABELS}
    rows = [[f"`{label}`", what, by[label]] for label, what in LABELS.items()]
    return table(["label", "of what", "tests"], [*rows, ["all", "", len(told)]])


def room_of(fault):
    file = fault["places"][0]["file"] if "places" in fault else fault["file"]
    return "python" if file.endswith(".py") else file.partition("/")[0]


def of_faults():
    """By rooms: how many there are; of these equivalent, run with the whole table, and found then."""
    faults = toml_of("tests", "tools", "mutants.toml")["mutant"]
    found = {r["fault"]: r["found"] for r in rows_of(FOUND)}
    rows = []
    for room, what in ROOMS.items():
        own = [f for f in faults if room_of(f) == room]
        real = [f["name"] for f in own if "equivalent" not in f]
        run = [found[name] for name in real if name in found]
        rows.append([f"`{room}`" if room != "python" else "`apps/python`", what, len(own), len(own) - len(real),
                     len(run), len(run) - run.count("")])
    sums = [sum(row[k] for row in rows) for k in range(2, 6)]
    lives = sorted(name for name, by in found.items() if by == "" and name in {f["name"] for f in faults})
    text = table(["room", "", "faults", "equivalent", "in the last whole run", "found then"],
                 [*rows, ["all", "", *sums]])
    if sums[2] < sums[0] - sums[1]:
        text += "\nFaults that were not in the last whole run are newer, or it was stopped before them.\n"
    if lives:
        text += "\nNo test found:\n\n" + "".join(f"- {fault}\n" for fault in lives)
    return text


def of_random():
    rows = [[f"`{r['group']}`", r["seed"], r["drawn"], r["found"], f"{100 * int(r['found']) / int(r['drawn']):.0f} %"]
            for r in rows_of(DRAWN)]
    return table(["modules", "seed", "drawn", "found", "share"], rows)


def of_numbers():
    values, keys = toml_of("tests", "scenes", "values.toml"), toml_of("tests", "scenes", "keys.toml")
    argued = sum(len(names) for names in values.pop("argued").values())
    plain = sum(len(names) for names in values.pop("plain").values())
    elsewhere = sum(len(names) for names in values.values())
    rows = sum(len(own) for tables in keys["rows"].values() for own in tables.values())
    refused = len(glob.glob(os.path.join(root, "tests", "scenes", "refused", "*.toml")))
    return (f"The test `scenes_values` checks every number that runs tell, but for {elsewhere} that other tests "
            f"check, {argued} for which there is no independent number (each with its reason), and {plain} words and "
            f"clock times. `scenes_keys` moves scene keys off their values {rows} times; of "
            f"{len(keys['elsewhere'])} keys other tests see the effect. {refused} scenes must be refused.\n")


def figures(build):
    return (f"{BEGIN}\nTests by label. `tests/tools/verification.py` counts all figures here, and a test compares.\n\n"
            f"{of_tests(build)}\n{of_numbers()}\nFaults of the table, by room (`mutants.toml`):\n\n{of_faults()}\n"
            "Faults drawn at random after the tests were written (`random_faults.py`: comparisons, signs, numbers, "
            "statements; what only looks otherwise is left out). The first five rows are modules of the Python "
            "package. Those of all rooms have faults of C++, too (`drawn_faults.py`), 49 to 11 of Python:\n\n"
            f"{of_random()}")


def keep_found(path, unfinished):
    """From the table of a whole run, | room | fault | found by |, those that are still in mutants.toml."""
    with open(path) as f:
        cells = [[c.strip() for c in line.strip().strip("|").split("|")] for line in f.read().splitlines()[2:]]
    names = {m["name"] for m in toml_of("tests", "tools", "mutants.toml")["mutant"]}
    missed = names - {fault for _, fault, _ in cells}
    if missed and not unfinished:
        sys.exit(f"{path}: is of no whole run: {len(missed)} faults of the table were not run, such as {min(missed)}")
    with open(FOUND, "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["fault", "found"])
        for _, fault, by in cells:
            if fault in names and not by.startswith("equivalent"):
                out.writerow([fault, "" if by == "**lives**" else by])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--found", metavar="TABLE", help="keep this table as that of the last whole run")
    parser.add_argument("--unfinished", action="store_true", help="that run was stopped before its end")
    options = parser.parse_args()
    if options.found:
        keep_found(options.found, options.unfinished)
    made = figures(os.path.abspath(options.build))
    with open(PAGE) as f:
        page = f.read()
    begin = page.find(BEGIN)
    end = page.find(END, begin + len(BEGIN)) + 1 if begin >= 0 else -1
    held = page[begin:end].rstrip("\n") == made.rstrip("\n") if begin >= 0 else False
    if options.write:
        with open(PAGE, "w") as f:
            f.write(page[:begin] + made.rstrip("\n") + "\n\n" + page[end:])
    elif options.check:
        print("verification: the page holds the figures" if held else
              f"docs/verification.md holds other figures (verification.py BUILD --write puts these there):\n{made}")
        sys.exit(0 if held else 1)
    else:
        print(made)


if __name__ == "__main__":
    main()
