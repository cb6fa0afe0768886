#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every number that a run tells has a test of its value: values.py BIN

Names of numbers are those that runs show (columns, keys of summaries, fields of frames, other tables) and those that
stand where the programs write them. Each is held here against something independent (values_*.py), or values.toml says
which line of which other test does it.
"""
import os
import re
import sys
import tempfile
import tomllib

from scene_tools import faults, here, need

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(sys.argv[1])), "python"))
from grus.files import summary_keys  # noqa: E402

import values_bonded  # noqa: E402
import values_cells  # noqa: E402
import values_cells_alone  # noqa: E402
import values_crushing  # noqa: E402
import values_devices  # noqa: E402
import values_faces  # noqa: E402
import values_grains  # noqa: E402
import values_increments  # noqa: E402
import values_inertia  # noqa: E402
import values_macro  # noqa: E402
import values_packings  # noqa: E402
import values_samples  # noqa: E402
import values_splits  # noqa: E402
import values_steps  # noqa: E402
from values_tools import Values  # noqa: E402

root = os.path.join(here, "..", "..")


def source(*names):
    with open(os.path.join(root, *names)) as f:
        return f.read()


def written(fem):
    """Names that stand in the sources that write them: of families (walls, boundaries, parts) what is between."""
    names = set()
    for program in ("rve", "bvp") if fem else ("rve",):
        table = source("apps", program, "columns.cpp").partition("> table{")[2]
        names |= {f"{program}.columns:{k}" for k in re.findall(r'^    \{"([^"]+)",', table, re.M) if k.strip("{}")}
        names |= {f"{program}.summary:{k}" for k in summary_keys.keys_of(program)}
    grains, _, rest = source("dem", "io", "frames.cpp").partition("void write_contacts")
    contacts, _, lattice = rest.partition("void write_lattice")
    for what, text in (("grains", grains), ("contacts", contacts), ("lattice", lattice)):
        names |= {f"rve.{what}:{k}" for k in re.findall(r'(?:field\(|fields\[)"(\w+)"', text)}
    if fem:
        names |= {f"bvp.macro:{k}" for k in re.findall(r'fields\["(\w+)"\]', source("apps", "bvp", "output.cpp"))}
        probes = source("apps", "bvp", "probes.cpp")
        for array in re.findall(r"(?:point_facts|means|grading_facts)\[\] = \{([^}]+)\}", probes):
            names |= {f"bvp.columns:probe_{{}}_{k}" for k in re.findall(r'"(\w+)"', array)}
    return names


def general(name):
    """Of walls, grains and boundaries that a scene names one stands for all."""
    name = re.sub(r"(?<=:wall)\d+|(?<=:g)\d+(?=_)", "{}", name)
    name = re.sub(r"(?<=:reaction_)\w+(?=_[xyz]_N)|(?<=:moved_)\w+(?=_[xyz]_m)", "{}", name)
    return re.sub(r"(?<=:probe_)[a-z]+(?=_)", "{}", name)


def same_family(family, name):
    """`{}` is any part of a name, `*` all below it."""
    return re.fullmatch(re.escape(family).replace(r"\{\}", r"[\w{}]+").replace(r"\.\*", r"(?:\.\w+)*"), name)


def reasons_of(tables):
    return {f"{kind}:{name}": why for kind, names in tables.items() for name, why in names.items()}


def main(folder, binaries):
    fem = os.path.exists(os.path.join(binaries, "grus-bvp"))
    values = Values(binaries, folder)
    of_bvp = (values_macro, values_increments, values_cells, values_cells_alone, values_devices, values_steps)
    for module in (values_grains, values_samples, values_crushing, values_splits, values_bonded, values_faces,
                   values_packings, values_inertia, *(of_bvp if fem else ())):
        module.held(values)
    with open(os.path.join(here, "values.toml"), "rb") as f:
        tables = tomllib.load(f)
    names_of = lambda part: {f"{kind}:{name}" for both, names in tables.pop(part).items() for name in names
                             for kind in ([both] if both[:4] != "both" else [p + both[4:] for p in ("rve", "bvp")])}
    plain, argued = names_of("plain"), reasons_of(tables.pop("argued"))
    elsewhere = reasons_of(tables)
    if not fem:
        plain = {k for k in plain if k[:3] != "bvp"}
        elsewhere, argued = ({k: by for k, by in of.items() if k[:3] != "bvp"} for of in (elsewhere, argued))
    held, told = {general(k) for k in values.held}, {general(k) for k in values.told}
    known, inside = held | plain | set(argued) | set(elsewhere), written(fem)
    for name in sorted(told | inside):
        need(any(same_family(name, k) for k in known), f"{name}: no test holds its value against anything")
    for name in sorted(set(argued) | set(elsewhere)):
        need(name not in held, f"{name}: is held here, too")
        need(name in told or any(same_family(k, name) for k in inside), f"{name}: nothing tells that")
    for name, (file, line) in elsewhere.items():
        need(len(line) > 12 and line in source("tests", file), f"{name}: tests/{file} has no line {line!r}")
    for name, why in argued.items():
        need(len(why) > 40, f"{name}: why is it not held?")
    for name in held - told:
        need(False, f"{name}: no run tells what is held")
    print(f"{len(held)} held here, {len(elsewhere)} elsewhere, {len(argued)} argued")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        main(place, os.path.abspath(sys.argv[1]))
    print(f"values: {len(faults)} faults")
    sys.exit(1 if faults else 0)
