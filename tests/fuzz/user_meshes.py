# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of Gmsh, formats 2.2 and 4.1: a bar of two layers, pressed between rollers, whose force has a closed form."""
import itertools
import json
import os
import shutil
import subprocess

PROGRAM = "grus-bvp"  # which a build of the DEM alone has not
HARMLESS = ("format 4.1", "nodes renumbered", "elements renumbered", "tags renumbered", "groups renamed",
        "windows line ends", "sections of other programs", "byte order mark",
            "elements reordered", "nodes reordered", "sections reordered", "negative tags", "unused nodes",
                    "millimetres", "exponents", "cells turned over", "facets twice", "cell twice",
            "tag by number", "more tags", "triangles")
SPOILED = ("cell in two groups", "node twice", "node missing", "binary", "cut short", "count wrong", "not a number",
        "second order", "no names", "decimal comma", "flat cell", "no format")
WAYS = HARMLESS + SPOILED
turns = itertools.count()  # every second mesh is spoiled
spoil = itertools.cycle(SPOILED)  # in turn: each comes up, however few the cases
decks = {False: [], True: []}  # harmless ways for meshes that are not, and are, spoiled: all are dealt, then all again
WIDTH, HEIGHTS, MODULI, POISSON, MOVED = 0.2, (0.1, 0.3), (1e9, 3e9), 0.25, 1e-7


class Case:
    def __init__(self, folder, binaries, did, means, must_read, must_refuse):
        self.folder, self.binaries, self.did, self.means = folder, binaries, did, means
        self.must_read, self.must_refuse, self.name = must_read, must_refuse, "/mesh."  # .msh, or .toml

    def read(self):
        scene, out = os.path.join(self.folder, "mesh.toml"), os.path.join(self.folder, "out")
        shutil.rmtree(out, ignore_errors=True)
        alone = {**os.environ, "OMPI_MCA_ess_singleton_isolated": "1"}  # MPI without a daemon each
        r = subprocess.run([os.path.join(self.binaries, "grus-bvp"), scene, "-o", out, "--quiet", "--threads", "1"],
                           capture_output=True, text=True, timeout=60, env=alone)
        if r.returncode == 2:
            return ("refused", r.stderr) if not os.path.exists(out) else ("left a folder", r.stderr)
        if r.returncode != 0:
            return f"exit {r.returncode}", r.stderr
        with open(os.path.join(out, "summary.json")) as f:
            last = json.load(f)["last_row"]
        force = last["reaction_top_y_N"]
        # The strain is 2.5e-7 and the residual falls to 1e-9: beyond that the closed form is not to be expected.
        return "read", [self.means[0] if abs(force / self.means[0] - 1) < 1e-5 else force]


def grid(rng, triangles):
    """Nodes (x, y), cells with a layer, facets with a group."""
    columns, rows = rng.randint(1, 3), (rng.randint(1, 2), rng.randint(1, 3))
    heights = [0.0]
    for height, count in zip(HEIGHTS, rows):
        heights += [heights[-1] + height * (k + 1) / count for k in range(count)]
    nodes = [(WIDTH * i / columns, y) for y in heights for i in range(columns + 1)]
    at = lambda i, j: j * (columns + 1) + i
    cells, facets = [], []
    for j in range(len(heights) - 1):
        layer = "lower" if j < rows[0] else "upper"
        for i in range(columns):
            quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
            cells += [(layer, quad)] if not triangles else [(layer, quad[:3]), (layer, [quad[0], quad[2], quad[3]])]
        facets += [("left", [at(0, j), at(0, j + 1)]), ("right", [at(columns, j), at(columns, j + 1)])]
    for i in range(columns):
        facets += [("bottom", [at(i, 0), at(i + 1, 0)]), ("top", [at(i, len(heights) - 1), at(i + 1,
                len(heights) - 1)])]
    return nodes, cells, facets


def deal(rng, deck):
    if not deck:
        deck += rng.sample(HARMLESS, len(HARMLESS))
    return deck.pop()


def draw(rng, folder, binaries):
    spoiling = next(turns) % 2 == 1
    did = [deal(rng, decks[spoiling]) for _ in range(rng.randint(2, 5))]
    did = list(dict.fromkeys(did)) + ([next(spoil)] if spoiling else [])
    has = lambda way: way in did
    if has("no names") and has("tag by number"):
        did.remove("tag by number")
    nodes, cells, facets = grid(rng, has("triangles"))
    new = has("format 4.1")
    # One name, "sides", for two groups.
    names = {"bottom": "bottom", "top": "top", "left": "sides", "right": "sides", "lower": "lower", "upper": "upper"}
    if has("groups renamed"):
        names = {k: v + " of the bar" if v != "top" else "Oberkante ü" for k, v in names.items()}
    tags = {g: k + 1 for k, g in enumerate(names)}
    if has("tags renumbered"):
        tags = dict(zip(tags, rng.sample(range(1, 100000), len(tags))))
    scale = 1e3 if has("millimetres") else 1
    points = [[scale * x, scale * y, 0.0] for x, y in nodes]
    if has("unused nodes"):
        points.append([scale * 7, scale * 9, 3.0])
    if has("flat cell"):
        corner = cells[0][1]
        points[corner[2]] = [0.5 * (a + b) for a, b in zip(points[corner[0]], points[corner[1]])]
        if not has("triangles"):
            points[corner[3]] = [0.3 * a + 0.7 * b for a, b in zip(points[corner[0]], points[corner[1]])]
    number = list(range(1, len(points) + 1))
    if has("nodes renumbered"):
        number = rng.sample(range(1, 9 * len(points)), len(points))
    if has("cells turned over"):
        cells = [(g, c[1:] + c[:1]) if rng.random() < 0.5 else (g, c[::-1]) for g, c in cells]
    if has("facets twice"):
        facets = facets + facets[:2]
    if has("cell twice"):
        cells = cells + cells[-1:]
    if has("cell in two groups"):
        cells = cells + [("upper" if cells[0][0] == "lower" else "lower", cells[0][1])]
    order = list(range(len(points)))
    if has("nodes reordered"):
        rng.shuffle(order)
    dropped = cells[0][1][0] if has("node missing") else -1
    listed = [k for k in order if k != dropped] + (order[:1] if has("node twice") else [])
    real = (lambda v: f"{v:.16e}") if has("exponents") else repr
    of_node = lambda k: " ".join(map(real, points[k]))
    elements = [(1, g, c) for g, c in facets] + [(2, g, c) for g, c in cells]
    if has("elements reordered"):
        rng.shuffle(elements)
    kinds = {2: "1", 3: "2", 4: "3"}
    count = list(range(1, len(elements) + 1))
    if has("elements renumbered"):
        count = rng.sample(range(1, 9 * len(count)), len(count))
    sign = {g: -1 if has("negative tags") and rng.random() < 0.5 else 1 for g in tags}
    dimension = {g: 2 if g in ("lower", "upper") else 1 for g in tags}
    kind = lambda c: "9" if has("second order") and len(c) > 2 else kinds[len(c)]
    sections = {}
    sections["PhysicalNames"] = [str(len(tags))] + [f'{dimension[g]} {tags[g]} "{names[g]}"' for g in tags]
    if new:
        entity = {g: k + 3 for k, g in enumerate(tags)}
        of = lambda d: [g for g in tags if dimension[g] == d]
        sections["Entities"] = [f"0 {len(of(1))} {len(of(2))} 0"]
        sections["Entities"] += [f"{entity[g]} 0 0 0 1 1 0 1 {sign[g] * tags[g]} 0" for g in of(1) + of(2)]
        half = max(1, len(listed) // 2)
        blocks = [listed[:half], listed[half:]] if listed[half:] else [listed]
        sections["Nodes"] = [f"{len(blocks)} {len(listed)} 1 {max(number)}"]
        for b in blocks:
            sections["Nodes"] += [f"2 {entity['lower']} 0 {len(b)}"] + [str(number[k]) for k in b] + [of_node(k)
                    for k in b]
        sections["Elements"] = [f"{len(elements)} {len(elements)} 1 {max(count)}"]
        for n, (d, g, c) in zip(count, elements):
            sections["Elements"] += [f"{d} {entity[g]} {kind(c)} 1", f"{n} " + " ".join(str(number[k]) for k in c)]
    else:
        more = " 2 1 1" if has("more tags") else ""
        sections["Nodes"] = [str(len(listed))] + [f"{number[k]} {of_node(k)}" for k in listed]
        sections["Elements"] = [str(len(elements))] + [
            f"{n} {kind(c)} {5 if more else 2} {sign[g] * tags[g]} 1{more} " + " ".join(str(number[k]) for k in c)
                    for n, (d, g, c) in zip(count, elements)]
    if has("no names"):
        del sections["PhysicalNames"]
    if has("sections of other programs"):
        sections["Comments"] = ["made by hand: 3 $Nodes"]
        sections["Periodic"] = ["1", "0 1 2", "1", "1 2"]
    if has("count wrong"):
        head = sections["Nodes"][0].split()
        sections["Nodes"][0] = " ".join([str(int(head[0]) + rng.choice((-1, 1)))] + head[1:])
    if has("not a number"):
        sections["Nodes"][-1] = sections["Nodes"][-1].rsplit(" ", 1)[0] + " nan"
    if has("decimal comma"):
        sections["Nodes"] = sections["Nodes"][:-1] + [sections["Nodes"][-1].replace(".", ",")]
    titles = list(sections)
    if has("sections reordered"):
        rng.shuffle(titles)
    lines = [] if has("no format") else ["$MeshFormat", f"{'4.1' if new else '2.2'} {int(has('binary'))} 8",
            "$EndMeshFormat"]
    for title in titles:
        lines += ["$" + title, *sections[title], "$End" + title]
    if has("cut short"):
        lines = lines[:-2]
    text = ("\r\n" if has("windows line ends") else "\n").join(lines) + "\n"
    with open(os.path.join(folder, "mesh.msh"), "wb") as f:
        f.write((b"\xef\xbb\xbf" if has("byte order mark") else b"") + text.encode())
    tag = lambda g: str(tags[g]) if has("tag by number") else f'"{names[g]}"'
    sides = ["left", "right"] if has("tag by number") else ["left"]
    held = lambda g, name, u: f"[[boundary]]\nname = \"{name}\"\ntag = {tag(g)}\ndisplacement = {u}\n"
    with open(os.path.join(folder, "mesh.toml"), "w") as f:
        f.write("[mesh]\nfile = \"mesh.msh\"\ndimension = \"plane-strain\"\n" + ("unit = \"1 mm\"\n"
                if has("millimetres") else "") +
                "".join(f"[[region]]\ntag = {tag(g)}\nmaterial = \"elastic\"\nyoungs_modulus = {E}\npoissons_ratio = "
                        f"{POISSON}\n" for g, E in zip(("lower", "upper"), MODULI)) +
                held("bottom", "bottom", '["free", 0]') + held("top", "top", f'["free", -{MOVED}]') +
                "".join(held(g, g, '[0, "free"]') for g in sides) + "[solve]\nkind = \"quasi-static\"\nincrements = "
                        "1\ntolerance = 1e-9\n")
    constrained = [E * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) for E in MODULI]
    force = -WIDTH * MOVED / sum(h / m for h, m in zip(HEIGHTS, constrained))
    spoiled = [w for w in did if w in SPOILED]
    return Case(folder, binaries, did, [force], not spoiled, bool(spoiled))
