#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes as Gmsh writes them, oddities included: taken for what they mean, with a note, or refused: meshes.py BIN"""
import json
import os
import subprocess
import sys
import tempfile

import scene_tools
from scene_tools import faults, need, run, write

binaries = os.path.abspath(sys.argv[1])
bvp, rve = (scene_tools.program(binaries, name) for name in ("grus-bvp", "grus-rve"))
NODES = {1: (0, 0), 2: (1, 0), 3: (2, 0), 4: (0, 1), 5: (1, 1), 6: (2, 1)}
FACETS = [("bottom", (1, 2)), ("bottom", (2, 3)), ("top", (4, 5)), ("top", (5, 6)), ("left", (1, 4)), ("right", (3, 6))]
CELLS = [("rock", (1, 2, 5, 4)), ("rock", (2, 3, 6, 5))]
TAGS = {"bottom": 1, "top": 2, "left": 3, "right": 4, "rock": 10, "other": 11}
MODULUS, POISSON, MOVED = 1e9, 0.25, 1e-6
FORCE = -2 * MODULUS * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON)) * MOVED  # of uniaxial strain, 2 m wide


def msh2(nodes=None, facets=FACETS, cells=CELLS, names=None):
    nodes, names = nodes or NODES, names or TAGS
    elements = [f"1 2 {TAGS[g]} 1 " + " ".join(map(str, n)) for g, n in facets] + [f"{3 if len(n) == 4 else 2} 2 "
            f"{TAGS[g]} 1 " + " ".join(map(str, n)) for g, n in cells]
    return ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n%s\n$EndPhysicalNames\n"
            "$Nodes\n%d\n%s\n$EndNodes\n$Elements\n%d\n%s\n$EndElements\n" % (
        len(names), "\n".join(f"{2 if t > 9 else 1} {t} \"{g}\"" for g, t in names.items()), len(nodes),
                "\n".join(f"{n} {x} {y} 0" for n, (x, y) in nodes.items()),
        len(elements), "\n".join(f"{k + 1} {e}" for k, e in enumerate(elements))))


def msh4(groups, partitioned=False):
    """`groups`: physical tags of the entities 1 (bottom, in halves: 1 and 2), 3 top, 4 left, 5 right, 6 surface."""
    entity = lambda d, n: f"{n} " + (f"{d} {n} 1 1 " if partitioned
            else "") + f"0 0 0 2 1 0 {len(groups[n])} " + "".join(f"{t} " for t in groups[n]) + "0"
    curves, surface = "\n".join(entity(1, n) for n in (1, 2, 3, 4, 5)), entity(2, 6)
    named = "$PhysicalNames\n%d\n%s\n$EndPhysicalNames\n" % (len(TAGS), "\n".join(f"{2 if t > 9 else 1} {t} \"{g}\""
            for g, t in TAGS.items()))
    head = "$PartitionedEntities\n1\n0\n0 5 1 0\n" if partitioned else "$Entities\n0 5 1 0\n"
    nodes = "$Nodes\n1 6 1 6\n2 6 0 6\n" + "".join(f"{n}\n" for n in NODES) + "".join(f"{x} {y} 0\n" for x,
            y in NODES.values()) + "$EndNodes\n"
    elements = ("$Elements\n6 8 1 8\n1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3\n1 3 1 2\n3 4 5\n4 5 6\n"
                "1 4 1 1\n5 1 4\n1 5 1 1\n6 3 6\n2 6 3 2\n7 1 2 5 4\n8 2 3 6 5\n$EndElements\n")
    entities = head + curves + "\n" + surface + "\n$End" + head.split()[0][1:] + "\n"
    return "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + named + entities + nodes + elements


def solve(tmp, text, bottom='"bottom"', top='"top"', sides=('"left"', '"right"'), region='tag = "rock"',
        top_does=f'displacement = ["free", -{MOVED}]'):
    with open(os.path.join(tmp, "m.msh"), "w") as f:
        f.write(text)
    scene, out = os.path.join(tmp, "m.toml"), os.path.join(tmp, "out")
    held = lambda tag, name, does: f"[[boundary]]\nname = \"{name}\"\ntag = {tag}\n{does}\n"
    with open(scene, "w") as f:
        f.write(f"[mesh]\nfile = \"m.msh\"\ndimension = \"plane-strain\"\n[[region]]\n{region}\nmaterial = "
                f"\"elastic\"\nyoungs_modulus = {MODULUS}\npoissons_ratio = {POISSON}\n" +
                held(bottom, "bottom", 'displacement = ["free", 0]') + held(top, "top", top_does) + "".join(held(s,
                        f"side{k}", 'displacement = [0, "free"]') for k, s in enumerate(sides)) +
                "[solve]\nkind = \"quasi-static\"\nincrements = 1\ntolerance = 1e-9\n")
    r = run(bvp, scene, "-o", out, "--force")
    summary = json.load(open(os.path.join(out, "summary.json"))) if r.returncode == 0 else {}
    return r, summary, summary.get("last_row", {}).get("reaction_top_y_N", 0.0)


def taken(tmp, what, text, *notes, force=FORCE, reaction="top", **how):
    """Read with the force of the closed form; the notes, and no others, in console, --check and summary."""
    r, summary, _ = solve(tmp, text, **how)
    found = summary.get("last_row", {}).get(f"reaction_{reaction}_y_N", 0.0)
    need(r.returncode == 0 and (force is None or abs(found / force - 1) < 1e-5),
            f"{what}: exit {r.returncode} {r.stderr.strip()}, {found} N, by hand {force} N")
    checked = run(bvp, os.path.join(tmp, "m.toml"), "--check").stdout
    notes = ("mesh.file is read in metres, as mesh.unit is not given: it measures 2 x ", *notes)
    for where, said in (("run", r.stdout.count("note: ")), ("--check", checked.count("note: ")),
                        ("summary", len(summary.get("notes", [])))):
        need(said == len(notes), f"{what}: {said} notes in {where}, not {len(notes)}: {r.stdout}")
    for note in notes:
        need(note in r.stdout and note in checked and note in str(summary.get("notes")),
                f"{what}: no {note!r} in {r.stdout} {checked} {summary.get('notes')}")


def refused(tmp, what, text, expected, **how):
    r, _, _ = solve(tmp, text, **how)
    need(r.returncode == 2 and r.stderr.count("\n") == 1 and expected in r.stderr,
            f"{what}: exit {r.returncode} {r.stderr!r}, not {expected!r}")


def meshes(tmp):
    taken(tmp, "as it is", msh2())
    refused(tmp, "an element in two groups", msh2(cells=CELLS + [("other", (1, 2, 5, 4))]),
            'elements 7 and 9 are one element, in the physical groups "rock" and "other"')
    refused(tmp, "the same, 4.1", msh4({1: [1], 2: [1], 3: [2], 4: [3], 5: [4], 6: [10, 11]}),
            'in the physical groups "rock" and "other"')
    taken(tmp, "an element twice", msh2(cells=CELLS + [("rock", (5, 4, 1, 2))]),
          "1 of the elements stand in the file again")
    whole = {1: [1], 2: [1], 3: [2], 4: [3], 5: [4], 6: [10]}
    taken(tmp, "4.1", msh4(whole))
    taken(tmp, "negative tags", msh4({**whole, 2: [-1], 3: [-2], 6: [-10]}))
    taken(tmp, "partitioned entities", msh4(whole, partitioned=True))
    taken(tmp, "a facet in two groups", msh4({**whole, 2: [1, 4], 1: [4, 1]}))
    taken(tmp, "tags by number", msh2(), bottom="1", top="2", sides=("3", "4"), region="tag = 10")
    # One name for two groups: both. The load on half of the top would be half as large.
    two = [("left", n) if n == (1, 2) else (g, n) for g, n in FACETS if g != "left"]
    text = msh2(facets=two).replace('1 3 "left"', '1 3 "bottom"')
    taken(tmp, "one name, two groups", text, reaction="bottom", force=2e3, sides=('"right"',),
            top_does='pressure = "1 kPa"')
    # Two bodies; a body that hangs on a node in a side; a tagged line between two elements.
    apart = {**NODES, 7: (1, 0), 8: (1, 1)}
    parted = dict(nodes=apart, facets=[(g, tuple({2: 7, 5: 8}.get(k, k) for k in n)) if 3 in n or 6 in n else (g, n)
            for g, n in FACETS], cells=[CELLS[0], ("rock", (7, 3, 6, 8))])
    taken(tmp, "two parts", msh2(**parted), "2 parts share no node", "2 nodes lie where another one lies (the first: "
            "2 and 7)",
          force=-2 * MODULUS / (1 - POISSON**2) * MOVED)  # each is free at the gap
    hung = {**NODES, 7: (1, 0.5)}
    taken(tmp, "a hanging node", msh2(nodes=hung, facets=FACETS, cells=[("rock", (1, 2, 5)), ("rock", (1, 5, 4)),
            ("rock", (2, 3, 7)), ("rock", (3, 6, 7)), ("rock", (6, 5, 7))]),
          "1 nodes lie on sides of elements that do not have them (the first: 7)", force=None)
    taken(tmp, "a line inside", msh2(facets=FACETS + [("top", (2, 5))]),
            'boundary[1]: of the 3 elements of physical group "top" 1 lie between two elements: nothing acts there')
    refused(tmp, "three elements at one side", msh2(nodes={**NODES, 7: (1.5, 2)}, cells=[("rock", (1, 2, 5)),
            ("rock", (1, 5, 4)), ("rock", (2, 3, 5)), ("rock", (2, 6, 5)), ("rock", (3, 6, 5))]),
            "more than two elements share the side with nodes")
    refused(tmp, "no format", msh2().split("$EndMeshFormat\n")[1], "before $MeshFormat")
    refused(tmp, "a node that is not there", msh2(cells=[CELLS[0], ("rock", (2, 3, 6, 77))]),
            "element 8 (quadrilateral) names node 77, which is not there")


def sizes(tmp):
    """The mesh's sides are told, with the unit; a mesh in millimetres that is read in metres is asked about."""
    large = {n: (1000 * x, 1000 * y) for n, (x, y) in NODES.items()}
    for nodes, unit, sides, asked in ((large, "", "2000 x 1000 m", True), (large, 'unit = "1 mm"', "2 x 1 m", False),
                                      (NODES, "", "2 x 1 m", False)):
        solve(tmp, msh2(nodes=nodes))
        with open(os.path.join(tmp, "m.toml")) as f:
            scene = write(tmp, f.read().replace('file = "m.msh"\n', f'file = "m.msh"\n{unit}\n'))
        said = run(bvp, scene, "--check").stdout
        need(f"mesh {sides}   elements 2" in said, f"{sides} {unit}: {said}")
        need((f"measures {sides}: in metres?" in said) == asked, f"{sides} {unit}: {said}")
        need((f"mesh.unit is not given: it measures {sides}" in said) == (not unit), f"{sides} {unit}: {said}")
    with open(os.path.join(tmp, "m.msh"), "w", encoding="utf-8-sig") as f:
        f.write(msh2())
    need(run(bvp, os.path.join(tmp, "m.toml"), "--check").returncode == 0, "a mesh with a byte order mark")


def internal(tmp):
    """The table of keys is held against the reader in tests alone: scenes beyond what they cover run all the same."""
    free = {k: v for k, v in os.environ.items() if k != "GRUS_CHECK_KEYS"}
    scene = os.path.join(tmp, "clusters.toml")
    with open(scene, "w") as f:
        f.write("[material.rock]\ndensity = 2500.0\ncontact = \"overlap\"\nfoundation = \"1e13 "
                "Pa/m\"\n[material.rock.bond]\nmodulus = \"20 GPa\"\ntension = \"6 MPa\"\ncohesion = \"18 "
                "MPa\"\nfracture_energy = \"20 J/m^2\"\nbetween = \"3 MPa\"\n"
                "[packing]\nkind = \"voronoi\"\nbox = [\"9 mm\", \"9 mm\", \"9 mm\"]\ncells = 60\nrelax = 1\ngrains "
                        "= \"clusters\"\nclusters = 40\n[boundary]\nkind = \"open\"\n[loading]\nkind = "
                        "\"free\"\nduration = 1e-6\n")
    for environment in (free, {**free,
            "GRUS_CHECK_KEYS": "1"}):  # and the table is right: with the tests' eyes open, too
        r = subprocess.run([rve, scene, "--check"], capture_output=True, text=True, env=environment)
        need(r.returncode == 0, f"40 clusters: exit {r.returncode} {r.stderr}")


with tempfile.TemporaryDirectory() as folder:
    if bvp:
        meshes(folder)
        sizes(folder)
    internal(folder)
print(f"meshes: {len(faults)} faults")
sys.exit(1 if faults else 0)
