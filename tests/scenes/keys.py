#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every key of a scene changes a result: keys.py BIN

keys.toml: scenes, and rows of a key with another value. A run with the other value must not be refused, and must end
otherwise than the run without: another history, other files, another ending. Of companions that a run takes without
the key the effect is not the key's: then they stand in both. Keys of apps/scene/keys.txt, and keys that the records of
the runs show, must be in a row, each by its whole path.
"""
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor

from scene_tools import faults, here, need

binaries = os.path.abspath(sys.argv[1])
fem = os.path.exists(os.path.join(binaries, "grus-bvp"))
sys.path.insert(0, os.path.join(here, "..", "fuzz"))
sys.path.insert(0, os.path.join(binaries, "..", "python"))
from grus.files import summary_keys  # noqa: E402

import bases  # noqa: E402
import hull_bases  # noqa: E402

with open(os.path.join(here, "keys.toml"), "rb") as f:
    DATA = tomllib.load(f)
KINDS = ("rve", "bvp") if fem else ("rve",)
SCENES = {name: (kind, scene) for kind in KINDS for name, scene in DATA[kind].items()}
FUZZ = {"PACKING": bases.PACKING, "MESH": bases.MESH, **bases.RVE, **hull_bases.RVE, **bases.BVP}
PIECES = {
    **DATA["pieces"], "rock": hull_bases.ROCK, "cohesive": hull_bases.COHESIVE,
    **{f"fuzz.{name}": text for name, text in FUZZ.items()}
}
ELSEWHERE = DATA["elsewhere"]
REFUSED = (2, "timeout")
# Keys that say which others there are.
CHOICES = ("kind", "model", "criterion", "contact", "distribution", "dimension", "shape", "control", "area", "grains",
           "rigid", "span")


def text_of(pieces):
    """The text that pieces make: named ones, scenes, or texts of their own."""
    return "".join(PIECES.get(p) or (text_of(SCENES[p][1]["of"]) if p in SCENES else p) for p in pieces)


def rows():
    """(scene, key, other value, companions...)"""
    return [(scene, f"{table}.{key}" if table else key, *rest) for scene, tables in DATA["rows"].items()
            if scene in SCENES for table, keys in tables.items() for key, *rest in keys]


def outcome(folder, result):
    """What a run leaves, but for clocks: ending, files, tables."""
    left = {
        "exit": result.returncode,
        "error": re.sub(r"time [0-9.e+-]+", "", result.stderr)[-200:] if result.returncode else ""
    }
    for path in sorted(glob.glob(os.path.join(folder, "**"), recursive=True)):
        name = os.path.relpath(path, folder)
        if name.endswith((".csv", ".series")):
            text = open(path).read()
            if name == "history.csv" and "wall_s" in text.split("\n", 1)[0].split(","):
                at = text.split("\n", 1)[0].split(",").index("wall_s")
                text = "\n".join(",".join(v for k, v in enumerate(line.split(",")) if k != at)
                                 for line in text.split("\n"))
            left[name] = "there" if name == "costs.csv" else text
        elif not name.endswith((".json", ".h5")):
            left[name] = "there"
    summary = os.path.join(folder, "summary.json")
    if os.path.exists(summary):
        s = json.load(open(summary))
        left["title"], left["counts"], left["record"] = s.get("title"), s.get("counts"), s
    return left


def paths(record, at=""):
    for key, value in record.items() if isinstance(record, dict) else enumerate(record):
        path = f"{at}.{key}" if at else str(key)
        if isinstance(value, dict) or (isinstance(value, list) and value and isinstance(value[0], dict)):
            yield from paths(value, path)
        else:
            yield path


def summary_paths(summary, at=""):
    """Dotted keys of what summary.json tells; lists are values."""
    for key, value in summary.items():
        if isinstance(value, dict) and value and key not in ("scene", "unit_cell", "last_row"):
            yield from summary_paths(value, f"{at}{key}.")
        else:
            yield f"{at}{key}" + ("." if key in ("scene", "unit_cell", "last_row") else "")


def general(path):
    return re.sub(r"\.\d+\b", "", re.sub(r"^material\.\w+", "material.*", path))


def larger(value):
    """Numbers that are a tenth larger; nothing of words."""
    try:
        numbers = json.loads(str(value))
    except ValueError:
        return None
    if isinstance(numbers, list) and all(isinstance(x, (int, float)) for x in numbers):
        return [1.1 * x for x in numbers]
    return type(numbers)(round(1.1 * numbers, 12)) if type(numbers) in (int, float) else None


def main(tmp):
    for name, pieces in {**DATA["files"],
                         **{f"{name}.toml": scene["of"] for name, (_, scene) in SCENES.items()}}.items():
        with open(os.path.join(tmp, name), "w") as f:
            f.write(text_of(pieces))

    def run(scene, *sets):
        folder, (kind, about) = os.path.join(tempfile.mkdtemp(dir=tmp), "out"), SCENES[scene]
        changes = dict(s.split("=", 1) for s in (*about.get("set", []), *sets))  # of two of a key the last holds
        command = [
            os.path.join(binaries, f"grus-{kind}"),
            os.path.join(tmp, scene + ".toml"), "-o", folder, "--quiet", "--threads", "1"
        ]
        command += [a for key, value in changes.items() for a in ("--set", f"{key}={value}")]
        try:
            return outcome(folder, subprocess.run(command, capture_output=True, text=True, timeout=300))
        except subprocess.TimeoutExpired:
            return {"exit": "timeout"}

    table = rows()
    with ThreadPoolExecutor(4) as pool:
        scenes = sorted({row[0] for row in table})
        plain = dict(zip(scenes, pool.map(run, scenes)))
        for scene in scenes:
            need(plain[scene]["exit"] == 0, f"{scene}: exit {plain[scene]['exit']} {plain[scene].get('error')}")
        # Companions alone are not the key: where there are any, the run to compare with has them too if it can.
        others = list(pool.map(lambda row: run(row[0], *row[3:], f"{row[1]}={row[2]}"), table))
        without = list(pool.map(lambda row: run(row[0], *row[3:]) if len(row) > 3 else plain[row[0]], table))
    strip = lambda o: {k: v for k, v in o.items() if k != "record"}
    for row, other, base in zip(table, others, without):
        need(other["exit"] not in REFUSED, f"{row[0]}: {row[1]} = {row[2]} is refused: {other.get('error', 'timeout')}")
        if base["exit"] in REFUSED:  # companions that cannot be without the key
            base = plain[row[0]]
            if more := larger(row[2]):
                base = run(row[0], *row[3:], f"{row[1]}={more}")
                need(base["exit"] not in REFUSED,
                     f"{row[0]}: {row[1]} = {more} is refused: {base.get('error', 'timeout')}")
            else:  # it says which keys there are, or stands where another stood
                need(row[1].rpartition(".")[2] in CHOICES or all(c.endswith("=") for c in row[3:]),
                     f"{row[0]}: {row[1]}: companions {row[3:]} are refused without")
        need(strip(other) != strip(base), f"{row[0]}: {row[1]} = {row[2]} changes nothing")
    covered = {general(row[1]) for row in table} | set(ELSEWHERE)
    for scene in scenes:
        for path in paths(plain[scene].get("record", {}).get("scene", {})):
            need(
                general(path) in covered or general(path).rsplit(".", 1)[0] in covered,
                f"{path} (scene {scene}) is in no row of the table")
    for scene, left in [*plain.items(), *((row[0], other) for row, other in zip(table, others))]:
        for path in summary_paths(left.get("record", {})):
            need(summary_keys.known(path, SCENES[scene][0]),
                 f"summary.json of {scene} has {path}, which summary_keys.txt lacks")
    with open(os.path.join(here, "..", "..", "apps", "scene", "keys.txt")) as f:
        known = [[part.strip() for part in line.split("|")] for line in f]
    for kind in KINDS:  # what a program reads is what it tells of its keys
        said = subprocess.run([os.path.join(binaries, f"grus-{kind}"), "--keys"], capture_output=True, text=True).stdout
        told = {general(line.strip("[]").replace("[]", "")) for line in said.splitlines() if line[:1] not in ("", " ")}
        read = {
            general(row[1]).replace("packing.parents.", "packing.")
            for row in table if SCENES[row[0]][0] == kind
        }
        missing = {key for key in read for k in (key, key.partition(".")[0]) if k not in told}
        need(len(read) > 60 and not missing, f"grus-{kind} --keys lacks {sorted(missing)}")
    for path, kind, *_ in known:
        if kind in ("table", "tables", "table or tables") or general(path.replace("[]", "")) in covered:
            continue
        need(not fem, f"{path} is in no row of the table")
    print(f"{len(table)} keys and values")


with tempfile.TemporaryDirectory() as folder:
    main(folder)
print(f"keys: {len(faults)} faults")
sys.exit(1 if faults else 0)
