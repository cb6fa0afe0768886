# SPDX-License-Identifier: LGPL-3.0-or-later
"""Packings that other programs wrote: a line a grain, x y z radius in metres."""
import itertools
import json
import math
import os
import shutil
import subprocess

WAYS = ("order", "comments", "windows line ends", "tabs", "exponents", "empty lines",
        "byte order mark", "utf-16", "millimetres", "grain twice", "negative radius", "beyond the box", "decimal comma",
        "line of names", "a number missing", "not a number")
HARMLESS = WAYS[:8]
spoil = itertools.cycle(WAYS[8:])  # in turn
SCENE = """[material.s]
density = 2650
youngs_modulus = "1 GPa"
poissons_ratio = 0.2
friction = 0.5
restitution = 0.5
[packing]
kind = "file"
path = "packing.txt"
box = ["4 mm", "4 mm", "4 mm"]
[boundary]
kind = "walls"
[loading]
kind = "free"
duration = 1e-6
"""


class Case:
    def __init__(self, folder, binaries, did, means, must_read, must_refuse):
        self.folder, self.binaries, self.did, self.means = folder, binaries, did, means
        self.must_read, self.must_refuse, self.name = must_read, must_refuse, "packing.txt"

    def read(self):
        scene, out = os.path.join(self.folder, "packing.toml"), os.path.join(self.folder, "out")
        shutil.rmtree(out, ignore_errors=True)
        r = subprocess.run([os.path.join(self.binaries, "grus-rve"), scene, "-o", out, "--quiet", "--threads", "1"],
                           capture_output=True, text=True, timeout=60)
        if r.returncode == 2:
            return ("refused", r.stderr) if not os.path.exists(out) else ("left a folder", r.stderr)
        if r.returncode != 0:
            return f"exit {r.returncode}", r.stderr
        with open(os.path.join(out, "summary.json")) as f:
            summary = json.load(f)
        with open(os.path.join(out, "history.csv")) as f:
            head, *rows = [line.rstrip("\n").split(",") for line in f]
        return "read", [float(summary["counts"]["grains"]), float(rows[-1][head.index("mass_kg")])]


def draw(rng, folder, binaries):
    grains = [(x + 0.01 * rng.random(), y, z, 0.3 + 0.15 * rng.random()) for x in (0.6, 1.7, 2.8)
              for y in (0.6, 1.7, 2.8) for z in (0.7, 1.8)]
    grains = [tuple(1e-3 * v for v in g) for g in rng.sample(grains, rng.randint(3, len(grains)))]
    did = rng.sample(HARMLESS, rng.randint(1, 3)) + ([next(spoil)] if rng.random() < 0.5 else [])
    if "order" in did:
        rng.shuffle(grains)
    means = [float(len(grains)), sum(2650 * 4 / 3 * math.pi * g[3] ** 3 for g in grains)]
    written = [list(g) for g in grains]
    if "millimetres" in did:
        written = [[1e3 * v for v in g] for g in written]
    if "grain twice" in did:
        written.append(list(written[0]))
    if "negative radius" in did:
        written[-1][3] *= -1
    if "beyond the box" in did:
        written[-1][0] += 4e-3
    form = "{:.17e}" if "exponents" in did else "{:.17g}"
    lines = [("\t" if "tabs" in did else " ").join(form.format(v) for v in g) for g in written]
    if "decimal comma" in did:
        lines = [line.replace(".", ",") for line in lines]
    if "a number missing" in did:
        lines[-1] = lines[-1].rsplit("\t" if "tabs" in did else " ", 1)[0]
    if "not a number" in did:
        lines[-1] = lines[-1].rsplit("\t" if "tabs" in did else " ", 1)[0] + " nan"
    if "line of names" in did:
        lines.insert(0, "x y z radius")
    if "comments" in did:
        lines.insert(len(lines) // 2, "# half of them")
    if "empty lines" in did:
        lines.insert(1, "")
    encoding = "utf-16" if "utf-16" in did else "utf-8-sig" if "byte order mark" in did else "utf-8"
    with open(os.path.join(folder, "packing.txt"), "w", newline="", encoding=encoding) as f:
        f.write(("\r\n" if "windows line ends" in did else "\n").join(lines) + "\n")
    with open(os.path.join(folder, "packing.toml"), "w") as f:
        f.write(SCENE)
    spoiled = [w for w in did if w in WAYS[8:]]
    return Case(folder, binaries, did, means, not spoiled, bool(spoiled))
