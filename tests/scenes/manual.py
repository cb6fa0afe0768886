#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands say of scenes without a run: --keys, --schema, --new: manual.py BIN"""
import copy
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib

import jsonschema

from scene_tools import column, faults, here, history, need, run, shipped

binaries = os.path.abspath(sys.argv[1])
programs = {name: path for name in ("rve", "bvp") if os.path.exists(path := os.path.join(binaries, "grus-" + name))}
sys.path.insert(0, os.path.join(here, "..", "fuzz"))
import bases  # noqa: E402
import hull_bases  # noqa: E402


def rows():
    for line in open(os.path.join(shipped, "..", "scene", "keys.txt")):
        yield dict(
            zip(("path", "type", "unit", "range", "fallback", "words", "example", "meaning"),
                line.rstrip("\n").split(" | ")))


def scenes():
    """(program, name, table) of what is shipped and of what the fuzzer starts from."""
    for path in sorted(
            glob.glob(os.path.join(shipped, "**", "*.toml"), recursive=True) +
            glob.glob(os.path.join(here, "macro", "*.toml"))):
        with open(path, "rb") as f:
            table = tomllib.load(f)
        if not {"study", "calibrate", "precision", "case"} & table.keys():
            yield "bvp" if "mesh" in table else "rve", path, table
    for module in (bases, hull_bases):
        for name, text in vars(module).items():
            if isinstance(text, dict):
                for key, scene in text.items():
                    if isinstance(scene, str) and "[loading]" in scene:
                        yield "rve", key, tomllib.loads(scene)


def part(schema, path):
    """The schema of a key."""
    for word in re.sub(r"\[\]", ".[]", path).split("."):
        for one in schema.get("anyOf", [schema]):
            if one.get("type") in ("object", "array"):
                schema = one
        schema = schema[
            "additionalProperties"] if word == "*" else schema["items"] if word == "[]" else schema["properties"][word]
    return schema


def schemas():
    known = {program: json.loads(run(path, "--schema").stdout) for program, path in programs.items()}
    for schema in known.values():
        jsonschema.Draft7Validator.check_schema(schema)
    seen = 0
    for program, name, table in scenes():
        if program in known:
            wrong = [e.message[:200] for e in jsonschema.Draft7Validator(known[program]).iter_errors(table)]
            need(not wrong, f"schema: {name}: {wrong}")
            seen += 1
    need(seen > 40, f"schema: {seen} scenes")
    with open(os.path.join(shipped, "sand_box.toml"), "rb") as f:
        good = tomllib.load(f)

    def refused(change, words):
        table = copy.deepcopy(good)
        change(table)
        wrong = [e.message for e in jsonschema.Draft7Validator(known["rve"]).iter_errors(table)]
        need(any(words in str(w) for w in wrong), f"schema: {words} not in {wrong}")
    refused(lambda t: t["packing"].update(solid_fractoin=0.5), "solid_fractoin")
    refused(lambda t: t["material"]["sand"].update(frictoin=0.5), "frictoin")
    refused(lambda t: t["packing"].update(solid_fraction=1.5), "1.5")
    refused(lambda t: t["packing"].update(solid_fraction=True), "True")
    refused(lambda t: t["boundary"].update(kind="wall"), "'wall'")
    refused(lambda t: t.update(output={"frames": 2.5}), "2.5")
    for row in rows():
        program = "rve" if any(k["path"] == row["path"] for k in listed["rve"]) else "bvp"
        if row["example"] and program in known:
            value = tomllib.loads("v = " + row["example"])["v"]
            wrong = [
                e.message for e in jsonschema.Draft7Validator(part(known[program], row["path"])).iter_errors(value)
            ]
            need(not wrong, f"{row['path']}: the example {row['example']} does not fit its own row: {wrong}")


listed = {}


def keys():
    table = list(rows())
    need(
        len({r["path"] for r in table}) == len(table) > 300 and all(r["meaning"] for r in table),
        "keys.txt: rows twice, or without a meaning")
    need(all(r["example"] or "table" in r["type"] for r in table),
         f"without an example: {[r['path'] for r in table if not r['example'] and 'table' not in r['type']]}")
    told = ""
    for program, path in programs.items():
        r = run(path, "--keys")
        need(r.returncode == 0, f"--keys: {r.stderr}")
        told += r.stdout
        listed[program] = [
            row for row in table if re.search(r"^\[*" + re.escape(row["path"]) + r"\]*$", r.stdout, re.M)
        ]
    if "bvp" in programs:
        missing = [row["path"] for row in table if not any(row in found for found in listed.values())]
        need(not missing, f"--keys leaves out {missing}")
    r = run(programs["rve"], "--keys", "weibull")
    need(r.returncode == 0 and "fracture.weibull.modulus" in r.stdout and "packing" not in r.stdout,
         f"--keys weibull: {r.stdout}")
    r = run(programs["rve"], "--keys", "no such thing")
    need(r.returncode == 2 and r.stderr.count("\n") == 1, f"--keys of nothing: {r.returncode} {r.stderr!r}")
    r = run(programs["rve"], "--help")
    need(all(word in r.stdout for word in ("--keys", "--schema", "--new")), "--help does not name them")


def problems(tmp, go):
    """Macro problems come with the scene of their RVEs, whose name goes with theirs; nothing is written over."""
    if "bvp" not in programs:
        return
    cell = open(os.path.join(shipped, "sand_rve.toml")).read()
    demo = os.path.join(here, "..", "..", "apps", "python", "demos", "block_dolfinx.py")
    texts = {kind: open(os.path.join(shipped, "new", kind + ".toml")).read() for kind in ("footing", "pile", "biaxial")}
    for kind, text in {**texts, "block-dolfinx": open(demo).read()}.items():
        ending, name = ".py" if kind == "block-dolfinx" else ".toml", f"my {kind}"
        r = go(programs["bvp"], "--new", kind, name + ending)
        changed = re.sub(r'"\.\./(\.\./scenes/)?sand_rve.toml"', f'"{name}_cell.toml"', text)
        need(r.returncode == 0 and open(os.path.join(tmp, name + ending)).read() == changed != text,
             f"--new {kind}: {r.stderr}")
        need(open(os.path.join(tmp, name + "_cell.toml")).read() == cell, f"--new {kind}: its RVE")
        os.remove(os.path.join(tmp, name + ending))
        r = go(programs["bvp"], "--new", kind, name + ending)
        need(r.returncode == 2 and "_cell.toml: is there already" in r.stderr and r.stderr.count("\n") == 1
             and not os.path.exists(os.path.join(tmp, name + ending)), f"--new {kind} over a cell: {r.stderr!r}")
    for kind in texts:
        need(go(programs["bvp"], "--new", kind).returncode == 0, f"--new {kind}")
        r = go(programs["bvp"], kind + ".toml", "--check")
        need(r.returncode == 0 and "run: " in r.stdout, f"--new {kind}: --check: {r.stdout} {r.stderr}")
    r = go(programs["bvp"], "--new", "block-dolfinx", "a.toml")
    need(r.returncode == 2 and "its name ends in .py" in r.stderr, f"--new block-dolfinx as a scene: {r.stderr!r}")
    go(programs["bvp"], "--new", "block-dolfinx")  # its name must not be that of a module that it imports
    r = go("/usr/bin/env", "INCREMENTS=0", f"PYTHONPATH={os.path.join(binaries, '..', 'python')}", "/usr/bin/python3",
           "block-dolfinx.py", "rows")
    need(r.returncode == 0 and os.path.exists(os.path.join(tmp, "rows")), f"--new block-dolfinx: {r.stderr[-300:]}")
    r = go(programs["bvp"], "--new", "pile", 'a".toml')
    need(r.returncode == 2 and r.stderr.count("\n") == 1, f"--new with a quote: {r.stderr!r}")


def new(tmp):
    def go(*command):
        return subprocess.run(command, cwd=tmp, capture_output=True, text=True, timeout=300)
    for kind in ("shpb", "oedometer", "triaxial", "stages", "single-grain", "bonded", "ucs", "brazilian", "bending",
                 "triaxial-rock"):
        r = go(programs["rve"], "--new", kind)
        need(
            r.returncode == 0 and open(os.path.join(tmp, kind + ".toml")).read() == open(
                os.path.join(shipped, "new", kind + ".toml")).read(), f"--new {kind}: {r.stderr}")
        need("compression-positive" in open(os.path.join(tmp, kind + ".toml")).read().split("title")[0],
             f"--new {kind}: its head does not tell signs")
        r = go(programs["rve"], kind + ".toml", "--check")
        told = re.search(r"run time (about .* s|.* s to .*) \(.* (gone through|rehearsed)", r.stdout)
        need(r.returncode == 0 and told,
             f"--new {kind}: --check: {r.stdout} {r.stderr}")
    r = go(programs["rve"], "--new", "shpb")
    need(r.returncode == 2 and "is there already" in r.stderr and r.stderr.count("\n") == 1,
         f"--new twice: {r.returncode} {r.stderr!r}")
    r = go(programs["rve"], "--new", "shpb", "other.toml")
    need(r.returncode == 0 and os.path.exists(os.path.join(tmp, "other.toml")), f"--new with a name: {r.stderr}")
    r = go(programs["rve"], "--new", "shpb", "a 'name")
    need(r.returncode == 0 and os.path.exists(os.path.join(tmp, "a 'name")), f"--new with any name: {r.stderr}")
    need(
        go(programs["rve"], "--new", "nothing").returncode == 2 and go(programs["rve"]).returncode == 2,
        "--new of no kind, or no scene at all")
    problems(tmp, go)
    for kind in ("oedometer", "single-grain"):
        r = go(programs["rve"], kind + ".toml", "--quiet")
        need(r.returncode == 0 and float(history(os.path.join(tmp, kind))[-1]["breakages"]) > 3,
             f"--new {kind}: {r.stderr}")
    r = go(programs["rve"], "bonded.toml", "--quiet")
    need(r.returncode == 0, f"--new bonded: {r.stderr}")
    if r.returncode == 0:
        stress = column(os.path.join(tmp, "bonded"), "nominal_stress_Pa")
        need(column(os.path.join(tmp, "bonded"), "bonds_broken")[-1] > 50 and stress[-1] < 0.8 * max(stress),
             f"--new bonded: a peak of {max(stress)} Pa, {stress[-1]} at the end")
    r = go(os.path.join(binaries, "grus-report"), "oedometer", "single-grain")
    page = open(os.path.join(tmp, "oedometer", "report.html")).read()
    need(
        r.returncode == 0 and page.count("image/svg+xml") >= 12 and 'aria-label="Single grains' in page
        and "Void ratio against" in page and "Gradings, first and last" in page, f"report: {r.stderr}")


def uneven():
    """A side of a box in another unit than the others' is told; sides that differ less are not."""
    for program, scene, key in (("rve", "new/bonded.toml", "packing.box"), ("bvp", "rock_block.toml", "mesh.box.size")):
        for side, told in (("5 m", True), ("4.9 m", False)):
            if program in programs:
                r = run(programs[program], os.path.join(shipped, scene), "--check", "--threads", "1", "--set",
                        f'{key}=["5 mm", "5 mm", "{side}"]')
                need(r.returncode == 0 and ("differ by a factor of 1e+03: has each the unit" in r.stdout) == told,
                     f"{key} of 5 mm and {side}: {r.stdout} {r.stderr}")


with tempfile.TemporaryDirectory() as folder:
    keys()
    schemas()
    new(folder)
    uneven()
print(f"manual: {len(faults)} faults")
sys.exit(1 if faults else 0)
