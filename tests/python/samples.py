#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Samples of Python are those of scene files, byte by byte, and are refused in one line: samples.py BUILD"""
import os
import sys
import tempfile

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import grus  # noqa: E402
from grus import Grain, RandomPacking as Packing, Sample  # noqa: E402

from scene_tools import faults, need  # noqa: E402

SAND = """[material.sand]
density = 2650
youngs_modulus = "60 GPa"
poissons_ratio = 0.2
friction = 0.3
restitution = 0.8
"""
ROCK = """[material.rock]
density = 2000
contact = "overlap"
friction = 0.4
"""
BOND = """[material.rock.bond]
modulus = "5 GPa"
tension = "10 MPa"
cohesion = "20 MPa"
fracture_energy = "50 J/m^2"
"""
sand = grus.Material(name="sand", youngs_modulus=60e9, poissons_ratio=0.2, friction=0.3, restitution=0.8)
rock = grus.Material(name="rock", density=2000, youngs_modulus=8e9, friction=0.4)
bonded = grus.Material(name="rock", density=2000, friction=0.4,
                       bond=grus.Bond(modulus=5e9, tension=10e6, cohesion=20e6, fracture_energy=50))
edge = 2e-3
PRISM = [[0, 0, 0], [edge, 0, 0], [0, edge, 0], [0, 0, edge]]
SIX = (1e-3, 0.9e-3, 0.5e-3, 0.6e-3, 0.7e-3, 0.7e-3)
placed = np.array([[1e-3, 1e-3, 1e-3, 0.5e-3], [3e-3, 3e-3, 3e-3, 0.7e-3], [1e-3, 3e-3, 2e-3, 0.4e-3]])


def spheres(folder):
    np.savetxt(os.path.join(folder, "spheres.txt"), placed, fmt="%.17g")
    return SAND + '[packing]\nkind = "file"\npath = "spheres.txt"\nbox = [4e-3, 4e-3, 4e-3]\nseed = 3\n'


# What is asked of the scene file, and of Python.
PAIRS = {
    "random spheres under pressure": (lambda _: SAND + """[packing]
kind = "random"
box = ["3 mm", "3 mm", "3 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.6
seed = 7
[preparation]
pressure = "1 MPa"
friction = 0.1
""", lambda: grus.Sample(sand, grus.RandomPacking(radius=(0.2e-3, 0.3e-3), solid_fraction=0.6), box=[3e-3] * 3, seed=7,
                         pressure=1e6, friction=0.1)),
    "a mixture": (lambda _: SAND + """[packing]
kind = "random"
box = ["3 mm", "3 mm", "3 mm"]
radius = { distribution = "constant", mean = "0.3 mm" }
solid_fraction = 0.4
mixture = [ { material = "sand", share = 3 }, { material = "sand", share = 1, aspect = [1, 0.8, 0.6] } ]
""", lambda: grus.Sample(sand, grus.RandomPacking(radius=0.3e-3, solid_fraction=0.4,
                                                  parts=[(0, 3, (1, 1, 1)), (0, 1, (1, 0.8, 0.6))]), box=[3e-3] * 3)),
    "a lattice": (lambda _: SAND + """[packing]
kind = "hcp"
radius = { distribution = "constant", mean = "0.5 mm" }
layers = [3, 4, 2]
""", lambda: grus.Sample(sand, grus.Lattice(radius=0.5e-3, layers=(3, 4, 2)))),
    "spheres of a file": (spheres, lambda: grus.Sample(sand, grus.Spheres(spheres=placed), box=[4e-3] * 3, seed=3)),
    "grains one by one": (lambda _: SAND + """[[grain]]
radius = "0.5 mm"
position = ["1 mm", "1 mm", "1 mm"]
velocity = [0.1, 0, 0]
[[grain]]
shape = "polyellipsoid"
semi_axes = [1e-3, 0.9e-3, 0.5e-3, 0.6e-3, 0.7e-3, 0.7e-3]
position = ["3 mm", "3 mm", "3 mm"]
orientation = [0.8, 0.6, 0, 0]
spin = [0, 0, 5]
[boundary]
kind = "periodic"
box = ["6 mm", "6 mm", "6 mm"]
""", lambda: grus.Sample([sand], [grus.Grain(position=(1e-3, 1e-3, 1e-3), radius=0.5e-3, velocity=(0.1, 0, 0)),
                                  grus.Grain(position=(3e-3,) * 3, semi_axes=SIX, orientation=(0.6, 0, 0, 0.8),
                                             spin=(0, 0, 5))], box=[6e-3] * 3)),
    "a hull": (lambda _: ROCK + """youngs_modulus = "8 GPa"
[[grain]]
shape = "hull"
vertices = [[0, 0, 0], ["2 mm", 0, 0], [0, "2 mm", 0], [0, 0, "2 mm"]]
position = ["3 mm", "3 mm", "3 mm"]
[boundary]
kind = "periodic"
box = ["6 mm", "6 mm", "6 mm"]
""", lambda: grus.Sample(rock, [grus.Grain(position=(3e-3,) * 3, vertices=PRISM)], box=[6e-3] * 3)),
    "random hulls": (lambda _: ROCK + """youngs_modulus = "8 GPa"
[packing]
kind = "random"
box = ["4 mm", "4 mm", "4 mm"]
radius = { distribution = "constant", mean = "0.4 mm" }
solid_fraction = 0.18
hulls = { relax = 3, aspect = [1, 1, 0.7] }
""", lambda: grus.Sample(rock, grus.RandomPacking(radius=0.4e-3, solid_fraction=0.18, hulls=3, aspect=(1, 1, 0.7)),
                         box=[4e-3] * 3)),
    "balls of planes": (lambda _: ROCK + """youngs_modulus = "8 GPa"
[packing]
kind = "random"
box = ["4 mm", "4 mm", "4 mm"]
radius = { distribution = "constant", mean = "0.4 mm" }
solid_fraction = 0.18
hulls = { balls = 32, aspect = [1, 0.9, 0.8] }
""", lambda: grus.Sample(rock, grus.RandomPacking(radius=0.4e-3, solid_fraction=0.18, balls=True, aspect=(1, 0.9, 0.8)),
                         box=[4e-3] * 3)),
    "bonded cells": (lambda _: ROCK + BOND + """[packing]
kind = "voronoi"
box = ["4 mm", "4 mm", "4 mm"]
cells = 70
relax = 4
""", lambda: grus.Sample(bonded, grus.Voronoi(cells=70, relax=4), box=[4e-3] * 3)),
}


def compare(folder):
    for name, (scene, sample) in PAIRS.items():
        text = scene(folder)
        path = os.path.join(folder, "cell.toml")
        with open(path, "w") as f:
            f.write(text + ("" if "[boundary]" in text else '[boundary]\nkind = "periodic"\n'))
        of_file, made = grus.RveSet(path, 2, threads=1), sample()
        alone = grus.RveSet(made, 2, threads=1)
        theirs = grus._core.hash_of(grus._core.Cells(path, [], 1).prepare(0))  # every bit but what clocks say
        need(grus._core.hash_of(made.state) == theirs, f"{name}: other bits than the scene file's")
        told = 8  # bytes of the number that says what scene, or what request, a state is of
        costs = "hull" in name or "cells" in name  # measured, part of the bytes
        same = of_file.get_state(0)[told:] == alone.get_state(0)[told:]
        need(same or costs, f"{name}: other bytes than the scene file's")
        ours, others = made.grains(), of_file.grains(0)
        need(all((ours[k] == others[k]).all() for k in others), f"{name}: grains() are others")
        need(made.contacts().keys() == of_file.contacts(0).keys(), f"{name}: contacts()")


def parted(folder):
    """Cells whose bonds have parted slip and press as those of the scene file do."""
    weak = {"tension": 1e5, "cohesion": 1e5, "fracture_energy": 0.01}
    path = os.path.join(folder, "weak.toml")
    with open(path, "w") as f:
        f.write(ROCK + "[material.rock.bond]\nmodulus = 5e9\n" + "".join(f"{k} = {v}\n" for k, v in weak.items()) +
                '[packing]\nkind = "voronoi"\nbox = [4e-3, 4e-3, 4e-3]\ncells = 70\nrelax = 4\n'
                '[boundary]\nkind = "periodic"\n')
    rock_of = grus.Material(name="rock", density=2000, friction=0.4, bond=grus.Bond(modulus=5e9, **weak))
    dF = np.array([[[1, 0, 2e-4], [0, 1, 0], [0, 0, 1 - 1e-4]]])
    stress = []
    for source in (path, grus.Sample(rock_of, grus.Voronoi(cells=70, relax=4), box=[4e-3] * 3)):
        rves = grus.RveSet(source, 1, threads=1, unbalanced_force=0.3, stress_change=0.5)
        intact = len(rves.contacts(0)["a"])
        stress.append(rves.advance(dF, tangent=False)[0][0])
        rves.commit()
        need(len(rves.contacts(0)["a"]) > intact, "no bond has become a contact")
    need((stress[0] == stress[1]).all(), f"stress {stress[1]}, of the scene file {stress[0]}")


def use():
    """A sample loads like a scene: other seeds are other packings, and the same stress comes of the same strain."""
    cell = grus.Sample(sand, grus.RandomPacking(radius=0.25e-3, solid_fraction=0.6), box=[2.5e-3] * 3, pressure=1e6)
    rves = grus.RveSet(cell, 3, threads=1, variant=[0, 1, 0])
    dF = np.tile(np.diag([1, 1, 1 - 1e-3]), (3, 1, 1))
    stress, _ = rves.advance(dF, tangent=False)
    shared = (stress[0] == stress[2]).all() and (stress[0] != stress[1]).any()
    need(shared and stress[0, 2] < -1e6, f"stress {stress[:, 2]}")
    need("grains" in repr(cell) and "Sample" in repr(rves), f"{cell!r} {rves!r}")
    need(rves.scene["grains"]["kind"] == "random", "a set of a sample does not tell what it was asked for")
    ball = grus.Grain(position=(3e-3,) * 3, radius=1e-3, velocity=(1, 2, 3), spin=(4, 5, 6))
    told = grus.Sample(sand, [ball], box=[6e-3] * 3).grains()
    need((told["velocity"] == [[1, 2, 3]]).all() and (told["spin"] == [[4, 5, 6]]).all(), f"how it moves: {told}")


def refused():
    packing = Packing(radius=0.25e-3, solid_fraction=0.6)
    box = [2e-3] * 3
    brittle = grus.Bond(modulus=1e9, tension=1e6, cohesion=1e6, fracture_energy=1, poissons_ratio=0.3)
    for words, work in (
            ("solid_fraction: 0.8", lambda: Sample(sand, Packing(radius=1e-4, solid_fraction=0.8), box=box)),
            ("radius: expected a number", lambda: Sample(sand, Packing(radius="1 mm", solid_fraction=0.5), box=box)),
            ("box: needs", lambda: Sample(sand, packing)),
            ("balls: expected True", lambda: Sample(rock, Packing(radius=1e-4, solid_fraction=0.1, balls=32), box=box)),
            ("aspect: is of",
             lambda: Sample(sand, Packing(radius=1e-4, solid_fraction=0.1, aspect=(1, 1, 2)), box=box)),
            ("aspect: [1.0, 0.0, 1.0]: lengths",
             lambda: Sample(rock, Packing(radius=1e-4, solid_fraction=0.1, balls=True, aspect=(1, 0, 1)), box=box)),
            ("aspect: [1.0, -1.0, 1.0]: lengths",
             lambda: Sample(sand, Packing(radius=1e-4, solid_fraction=0.1, parts=[(0, 1, (1, -1, 1))]), box=box)),
            ("hulls: rounds",
             lambda: Sample(rock, Packing(radius=1e-4, solid_fraction=0.1, hulls=3, balls=True), box=box)),
            ("box", lambda: Sample(sand, packing, box=[1e-3, 0, 1e-3])),
            ("box: is that of the lattice", lambda: Sample(sand, grus.Lattice(radius=1e-3, layers=(2, 2, 2)), box=box)),
            ("even numbers", lambda: Sample(sand, grus.Lattice(radius=1e-3, layers=(2, 3, 2)))),
            ("sand.density", lambda: Sample(grus.Material(name="sand", density=0), packing, box=box)),
            ("poissons_ratio: 0.3", lambda: Sample(grus.Material(bond=brittle), grus.Voronoi(cells=70), box=box)),
            ("materials: expected", lambda: Sample([], packing, box=box)),
            ("grains: expected", lambda: Sample(sand, [], box=box)),
            ("hulls meet hulls alone", lambda: Sample(sand, [Grain(position=(0, 0, 0), radius=1e-4),
                                                            Grain(position=(1e-3, 0, 0), vertices=PRISM)], box=box)),
            ("one of radius", lambda: Sample(sand, [Grain(position=(0, 0, 0))], box=box)),
            ("shape (3,)", lambda: Sample(sand, [Grain(position=(0, 0), radius=1e-4)], box=box)),
            ("material 3: the model has 1",
             lambda: Sample(sand, grus.Spheres(spheres=placed, material=3), box=[4e-3] * 3)),
            ("pressure: 5e+04 MPa is too high", lambda: Sample(sand, packing, box=box, pressure=5e10)),
            ("set: is of scene files", lambda: grus.RveSet(Sample(sand, packing, box=box), set=["seed=2"]))):
        try:
            work()
        except grus.InputError as error:
            need(words in str(error) and "\n" not in str(error), f"'{error}' does not say {words}")
        else:
            need(False, f"accepted: {words}")


with tempfile.TemporaryDirectory() as tmp:
    compare(tmp)
    parted(tmp)
    use()
    refused()
print(f"samples: {len(faults)} faults")
sys.exit(1 if faults else 0)
