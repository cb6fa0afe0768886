#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the Python package asks of its compiled core, and what it makes of the answers, with a core in its place that
writes down what it hears: logic.py BUILD"""
import itertools
import json
import os
import sys
import types

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(build, "python"), os.path.join(source, "tests", "scenes")]

import numpy as np  # noqa: E402

import scene_tools  # noqa: E402
from scene_tools import faults, need  # noqa: E402

core = types.ModuleType("grus._core")
heard, kept = [], {}


class Cells:
    record, notes, materials, kin = '{"a": {"b": 1}}', ["a note"], ["sand"], 77

    def __init__(self, *asked):
        heard.append(("cells", *asked))

    def prepare(self, variant):
        if variant == self.fails:
            raise InputError("no rest")
        return b"state%d" % variant
    fails = None


class Set:
    distinct = 3

    def __init__(self, cells, prepared, start, response, team):
        heard.append(("set", prepared, start, response, team))
        self.points = len(start)

    def advance(self, wanted, stress, tangent):
        if wanted[0] == 13:
            raise Unstable("point 0: too fast")
        heard.append(("advance", wanted.copy(), None if tangent is None else tangent.size))
        stress[:] = np.arange(stress.size)
        if tangent is not None:
            tangent[:] = -np.arange(tangent.size)

    def commit(self):
        heard.append("commit")

    def facts(self):
        return {"grains": np.full(self.points, 25), "breakages": np.full(self.points, 2),
                "void_ratio": np.full(self.points, 0.61234)}

    def report(self):
        return {"asked": 5, "errors": {"deferral": {"worst": 0.1}}}

    def grains(self, i):
        return {"id": np.arange(i + 1)}

    def contacts(self, i):
        return {"force": np.full(i + 1, 2.0)}

    def cell(self, i):
        return [[i, 0, 0], [0, 1, 0], [0, 0, 1]]

    def bytes(self, i):
        return b"bytes%d" % i

    def restore(self, i, state):
        heard.append(("restore", i, state))

    def parts(self):
        return [b"p0", b"p1"]

    def load(self, mine):
        heard.append(("load", mine))


core.Cells, core.Set, core.usable_cores = Cells, Set, lambda: 6
core.grains_of = lambda state: {"id": np.arange(4), "of": state}
core.contacts_of = lambda state: {"of": state}
core.write_parts = lambda file, about, parts: kept.update({file: (about, list(parts))})
core.read_parts = lambda file: kept[file]
sys.modules["grus._core"] = core
import grus  # noqa: E402
from grus.asked import Lacking  # noqa: E402
from grus.errors import InputError, Unstable  # noqa: E402
from grus.rves import Rve, RveSet  # noqa: E402
from grus.samples import Bond, Grain, Lattice, Material, RandomPacking, Sample, Spheres, Voronoi, _asked  # noqa: E402


def refused(words, work, kind=InputError):
    scene_tools.refused(words, work, kind)


def asked_of(*given, **more):
    heard.clear()
    return RveSet(*given, **more), heard[:]


def sets():
    """How a set is made: scene, changes, variants, threads, settings; and what it answers."""
    rves, said = asked_of("s.toml", 4, threads=2, set=["a=1"], variant=[0, 2, 1, 2], window=30,
                          adaptivity={"share": 1e-3})
    need(said == [("cells", "s.toml", ["a=1"], 3), ("set", [b"state0", b"state1", b"state2"], [0, 2, 1, 2],
                                                   "window = 30\nadaptivity = { share = 0.001 }", 2)], f"{said}")
    need(repr(rves) == "<grus.RveSet of s.toml: 4 points, 3 RVEs>" and len(rves) == 4 and rves.distinct == 3 and
         rves.notes == ["a note"] and rves.materials == ["sand"] and rves.scene["a"]["b"] == 1, repr(rves))
    refused("scene of s.toml: no 'x'", lambda: rves.scene["x"], Lacking)
    for given, more, wanted in (((), {}, ([b"state0"], [0], "", 6)), ((0,), {}, ([b"state0"], [], "", 6)),
                                ((2,), {"variant": np.array([1, 0], np.uint8)}, ([b"state0", b"state1"], [1, 0], "",
                                 6))):
        _, said = asked_of("s.toml", *given, **more)
        need(said[1] == ("set", *wanted), f"{given} {more}: {said}")
    for words, work in (("variant: expected 2 integers from 0", lambda: RveSet("s", 2, variant=[0])),
                        ("variant: expected 2", lambda: RveSet("s", 2, variant=[0, -1])),
                        ("variant: expected 1", lambda: RveSet("s", 1, variant=[0.0])),
                        ("n = -1", lambda: RveSet("s", -1)), ("threads = 0", lambda: RveSet("s", threads=0)),
                        ("set: expected a list", lambda: RveSet("s", set="a=1")), ("comm: expected", lambda: RveSet(
                            "s", comm=3)), ("scene: expected a path", lambda: RveSet(3))):
        refused(words, work)
    n, dF = 4, np.arange(36.0).reshape(4, 3, 3)
    heard.clear()
    stress, tangent = rves.advance(dF)
    need(stress.shape == (4, 6) and tangent.shape == (4, 6, 6) and stress[1, 2] == 8 and tangent[1, 0, 2] == -38 and
         (heard[0][1] == np.arange(36)).all() and heard[0][2] == 144, "an advance")
    S, C = np.zeros(24), np.zeros((4, 36))
    stress, tangent = rves.advance(dF, S, C)
    need(np.shares_memory(stress, S) and np.shares_memory(tangent, C) and S[5] == 5 and C[0, 5] == -5, "in place")
    for off in (False, np.False_):
        need(rves.advance(dF, tangent=off)[1] is None and heard[-1][2] is None, "without a tangent")
    for on in (True, np.True_, None):
        need(rves.advance(dF, tangent=on)[1].shape == (4, 6, 6), "with a tangent")
    room = np.zeros(24 + 144)
    refused("shares memory", lambda: rves.advance(dF, room[:24], room[:144]))
    rves.advance(dF, room[:24], room[24:])
    refused("18 numbers, expected 24", lambda: rves.advance(dF, np.zeros(18)))
    refused("point 0: too fast", lambda: rves.advance(dF + 13), Unstable)
    rves.commit()
    need(heard[-1] == "commit" and rves.facts()["grains"][n - 1] == 25 and rves.report()["asked"] == 5 and
         rves.report()["errors"]["deferral"]["worst"] == 0.1, "facts and reports")
    for what, work in (("facts of an RVE", rves.facts), ("report of a set", rves.report),
                       ("errors of devices that are on", lambda: rves.report()["errors"])):
        refused(f"{what}: no 'none'", lambda: work()["none"], Lacking)
    need(len(rves.grains(3)["id"]) == 4 and len(rves.contacts(2)["force"]) == 3 and rves.cell(2)[0, 0] == 2 and
         isinstance(rves.cell(0), np.ndarray) and rves.get_state(1) == b"bytes1", "points by their numbers")
    for i in (-1, 4):
        refused(f"point {i} of 4", lambda: rves.grains(i), IndexError)
    refused("point: expected", lambda: rves.cell(0.5))
    rves.set_state(3, bytearray(b"x"))
    need(heard[-1] == ("restore", 3, b"x"), "a state that is put back")


def saved():
    """Files: what is written of a set, and who may go on from it."""
    rves = RveSet("s.toml", 4, threads=1)
    rves.save("f.h5")
    about = json.loads(kept["f.h5"][0])
    need(about == {"program": "grus.RveSet", "points": [4], "kin": 77, "parts": [2]} and kept["f.h5"][1] ==
         [b"p0", b"p1"], f"a file: {kept['f.h5']}")
    heard.clear()
    rves.load("f.h5")
    need(heard == [("load", [b"p0", b"p1"])], f"{heard}")
    for change, words in (({"program": "x"}, "f.h5: not written by RveSet.save"), ({"points": [2, 2]},
                          "f.h5: of [2, 2] points on 2 ranks, here [4]"), ({"kin": 1},
                           "of another scene or other settings")):
        kept["f.h5"] = (json.dumps(about | change), [b"p0", b"p1"])
        refused(words, lambda: rves.load("f.h5"))
    refused("path: expected a path", lambda: rves.save(1))


class Comm:
    """A rank of two, whose partner has said all that it says in turn."""

    def __init__(self, rank, *partner):
        self.rank, self.size, self.partner, self.sent = rank, 2, list(partner), []

    def allgather(self, mine):
        other = self.partner.pop(0)
        return [mine, other] if self.rank == 0 else [other, mine]

    def scatter(self, shares):
        return shares[0] if self.rank == 0 else self.partner.pop(0)

    def send(self, part, dest, tag):
        self.sent.append((part, dest, tag))

    def recv(self, source, tag):
        return b"other%d%d" % (source, tag)


def ranks():
    """Two ranks: variants are prepared by turns, an error on one is one on all, parts are written by the first."""
    comm = Comm(0, 2, None, None, {1: b"theirs"}, None)
    heard.clear()
    rves = RveSet("s.toml", 2, threads=1, variant=[0, 1], comm=comm)
    need(heard[0] == ("cells", "s.toml", [], 3) and heard[1][1] == [b"state0", b"theirs", b"state2"] and
         heard[1][2] == [0, 1] and repr(rves) == "<grus.RveSet of s.toml: 2 points, 3 RVEs, rank 0 of 2>",
         f"the first of two ranks: {heard} {rves}")
    comm.partner = [None, 5, 3, None]
    rves.save("two.h5")
    about = json.loads(kept["two.h5"][0])
    need(about["points"] == [2, 5] and about["parts"] == [2, 3] and kept["two.h5"][1] ==
         [b"p0", b"p1"] + [b"other11"] * 3, f"what two ranks save: {kept['two.h5']}")
    comm.partner = [None, 5, None, None]
    heard.clear()
    rves.load("two.h5")
    need(heard == [("load", [b"p0", b"p1"])], f"{heard}")
    comm.partner = [(True, "their fault")]
    refused("rank 1: their fault", rves.commit)
    comm.partner = [(False, "their fault")]
    refused("rank 1: their fault", rves.commit, Unstable)
    second = Comm(1, 0, None, None, {0: b"zero", 2: b"two"}, None)
    heard.clear()
    rves = RveSet("s.toml", 1, threads=1, variant=[2], comm=second)
    need(heard[1][1] == [b"zero", b"state1", b"two"], f"the second rank: {heard}")
    second.partner = [None, 1, 7, None]
    before = dict(kept)
    rves.save("second.h5")
    need(second.sent == [(b"p0", 0, 1), (b"p1", 0, 1)] and kept == before, f"it sends: {second.sent}")
    second.partner = [None, 1, None, [b"a"], None]
    heard.clear()
    rves.load("second.h5")
    need(heard == [("load", [b"a"])], f"{heard}")
    Cells.fails = 1
    told = Comm(1, 1, None, None)
    refused("no rest", lambda: RveSet("s.toml", 1, threads=1, variant=[1], comm=told))
    Cells.fails = None


def one():
    rve = Rve("s.toml", set=["b=2"], window=4)
    need(heard[-2][2:] == (["b=2"], 1) and heard[-1][2:] == ([0], "window = 4", 1), f"one RVE: {heard[-2:]}")
    stress, tangent = rve.advance(np.eye(3))
    need(stress.shape == (6,) and tangent.shape == (6, 6) and rve.advance(np.eye(3), tangent=False)[1] is None,
        "its answer")
    need(repr(rve) == "<grus.Rve of s.toml: 25 grains, 2 breakages, void ratio 0.612>", repr(rve))
    facts = rve.facts()
    need(facts["grains"] == 25 and isinstance(facts["grains"], int) and rve.report()["asked"] == 5, "numbers of one")
    rve.commit(), rve.set_state(b"s"), rve.save("one.h5"), rve.load("one.h5")
    need(heard[-3:] == ["commit", ("restore", 0, b"s"), ("load", [b"p0", b"p1"])] and rve.get_state() == b"bytes0" and
         len(rve.grains()["id"]) == 1 and len(rve.contacts()["force"]) == 1 and rve.cell().shape == (3, 3), "of one")


SAND = Material(name="sand", density=2000, youngs_modulus=1e9, poissons_ratio=0.5, friction=0.3, restitution=1,
 damping=1)
BOND = dict(modulus=1e9, tension=1e6, cohesion=2e6, fracture_energy=10)


def samples():
    """What samples ask for, as plain values, and what they refuse at its limits."""
    heard.clear()
    sample = Sample(SAND, Spheres(spheres=[[0, 0, 0, 1e-3]]), box=[1, 2, 3], seed=7, pressure=1e6)
    asked = heard[0][1]
    need(heard[0][2:] == ("Sample", 1) and asked["seed"] == 7 and asked["box"] == [1, 2, 3] and asked["pressure"] == 1e6
         and asked["friction"] == 0.3 and asked["hulls"] is False and json.loads(asked["record"])["box"] == [1, 2,
          3] and
         "seed" not in json.loads(asked["record"]), f"{asked}")
    need(asked["materials"][0] == {
        "name": "sand", "density": 2000, "youngs_modulus": 1e9, "restitution": 1, "poissons_ratio": 0.5,
         "friction": 0.3, "rolling_friction": 0, "damping": 1, "rotation": True, "bond": None}, f"{asked['materials']}")
    need(sample.state == b"state0" and sample.notes == ["a note"] and sample.grains()["of"] == b"state0" ==
         sample.contacts()["of"] and repr(sample) == "<grus.Sample: 4 grains>", repr(sample))
    rves, said = asked_of(sample, 2, threads=1, variant=[0, 3])
    need(said[0][2:] == ("Sample", 4) and rves._file == "Sample", f"a set of a sample: {said}")
    refused("set: is of scene files", lambda: RveSet(sample, set=["a=1"]))
    plain = lambda grains, box=(1, 1, 1), **more: _asked(more.pop("materials", SAND), grains, box, more.pop("seed", 1),
                                                         more.pop("pressure", None), more.pop("friction", None))
    made = plain(RandomPacking(radius=(1, 2), solid_fraction=0.74, count=3, hulls=0, aspect=(1, 2, 3),
                               parts=[(0, 0.5, (1, 1, 2)), (1, 2, (3, 1, 1))]), friction=0.0)
    need(made["grains"] == {"kind": "random", "radius": (1, 2), "solid_fraction": 0.74, "hulls": 0, "balls": False,
                            "aspect": [1, 2, 3], "count": 3, "turned": True,
                            "parts": [{"material": 0, "share": 0.5, "aspect": [1, 1, 2]},
                                      {"material": 1, "share": 2, "aspect": [3, 1, 1]}]}
         and made["hulls"] is True and made["friction"] == 0 and made["pressure"] is None, f"{made['grains']}")
    one = plain(RandomPacking(radius=1, solid_fraction=0.5))["grains"]
    need(one["radius"] == (1, 1) and one["hulls"] is None and one["count"] == 0, f"{one}")
    made = plain(Lattice(radius=1, layers=(3, 2, 4)), None)["grains"]
    need(made == {"kind": "lattice", "hexagonal": True, "radius": 1, "layers": [3, 2, 4], "turned": True,
        "material": 0},
         f"{made}")
    need(plain(Lattice(radius=1, layers=(1, 1, 1), kind="simple-cubic"), None)["grains"]["hexagonal"] is False, "cubes")
    need(plain(Voronoi(cells=1, relax=0, clusters=2))["grains"] == {
        "kind": "voronoi", "cells": 1, "relax": 0, "clusters": 2, "material": 0} and plain(Voronoi(cells=1))["hulls"],
        "cells")
    ball = Grain(position=(1, 2, 3), radius=2, velocity=(4, 5, 6), spin=(7, 8, 9), orientation=(0, 0, 1.0005, 0))
    egg = Grain(position=(0, 0, 0), semi_axes=(1, 2, 3, 4, 5, 6), material=1)
    listed = plain([ball, egg])["grains"]["grains"]
    need(listed[0] == {"position": [1, 2, 3], "velocity": [4, 5, 6], "spin": [7, 8, 9], "semi_axes": [2] * 6,
        "vertices": None,
                       "orientation": [0, 0, 1.0005, 0], "material": 0} and listed[1]["semi_axes"] == [1, 2, 3, 4, 5, 6]
         and listed[1]["material"] == 1 and plain([ball])["hulls"] is False, f"{listed}")
    hull = Grain(position=(0, 0, 0), vertices=np.eye(3))
    need(plain([hull])["hulls"] is True and plain([hull])["grains"]["grains"][0]["vertices"] == np.eye(3).tolist(),
        "hulls")
    bond = Bond(**BOND, poissons_ratio=0.26)._plain()
    need(bond == {**BOND, "poissons_ratio": 0.26, "shear_energy": 10, "friction_angle": 0, "between": 0, "damping": 0,
                  "weibull": 0} and Bond(**BOND, shear_energy=3)._plain()["shear_energy"] == 3, f"{bond}")
    need(Material(bond=Bond(**BOND))._plain()["bond"]["modulus"] == 1e9, "a material with bonds")
    ball_of = lambda **more: [Grain(**{"position": (0, 0, 0), "radius": 1, **more})]
    sand = lambda **more: lambda: plain(ball_of(), materials=Material(**more))
    for words, work in (
            ("bond.tension: 0: must be finite and above 0", lambda: Bond(**{**BOND, "tension": 0})._plain()),
            ("bond.damping: -1: must be finite and at least 0", lambda: Bond(**BOND, damping=-1)._plain()),
            ("bond.poissons_ratio: 0.27", lambda: Bond(**BOND, poissons_ratio=0.27)._plain()),
            ("material.density: 0: must be finite and above 0", sand(density=0)),
            ("material.friction: -0.1", sand(friction=-0.1)), ("material.friction: inf: must be",
             sand(friction=np.inf)),
            ("material.poissons_ratio: 0.51: must be at most 0.5", sand(poissons_ratio=0.51)),
            ("material.restitution: 1.1: must be at most 1", sand(restitution=1.1)),
            ("material.damping: 1.1: must be at most 1", sand(damping=1.1)),
            ("material.friction: expected a number, given bool True", sand(friction=True)),
            ("material.friction: expected a number, given str", sand(friction="x")),
            ("radius: 1: must be finite and at least 2", lambda: plain(RandomPacking(radius=(2, 1),
             solid_fraction=0.5))),
            ("radius: 0: must", lambda: plain(RandomPacking(radius=0, solid_fraction=0.5))),
            ("solid_fraction: 0.75", lambda: plain(RandomPacking(radius=1, solid_fraction=0.75))),
            ("share: 0: must", lambda: plain(RandomPacking(radius=1, solid_fraction=0.5, parts=[(0, 0, (1, 1, 1))]))),
            ("hulls = -1", lambda: plain(RandomPacking(radius=1, solid_fraction=0.5, hulls=-1))),
            ("kind: 'fcc'", lambda: plain(Lattice(radius=1, layers=(2, 2, 2), kind="fcc"), None)),
            ("needs even numbers", lambda: plain(Lattice(radius=1, layers=(2, 3, 2)), None)),
            ("needs even numbers", lambda: plain(Lattice(radius=1, layers=(2, 2, 3)), None)),
            ("layers: expected three", lambda: plain(Lattice(radius=1, layers=(2, 2)), None)),
            ("layers = 0", lambda: plain(Lattice(radius=1, layers=(0, 2, 2)), None)),
            ("spheres: radii must be above 0", lambda: plain(Spheres(spheres=[[0, 0, 0, 0]]))),
            ("spheres: expected finite numbers of shape (-1, 4)", lambda: plain(Spheres(spheres=[[0, 0, 1]]))),
            ("spheres: expected numbers", lambda: plain(Spheres(spheres="x"))),
            ("position: expected finite numbers of shape (3,)", lambda: plain(ball_of(position=(0, 0, np.nan)))),
            ("a grain has one of radius, semi_axes and vertices, not none", lambda: plain(ball_of(radius=None))),
            ("not ['radius', 'vertices']", lambda: plain(ball_of(vertices=np.eye(3)))),
            ("orientation: must be a unit quaternion", lambda: plain(ball_of(orientation=(0, 0, 0, 1.01)))),
            ("semi_axes: 0: must", lambda: plain(ball_of(radius=None, semi_axes=(1, 1, 1, 1, 1, 0)))),
            ("cells = 0", lambda: plain(Voronoi(cells=0))), ("relax = -1", lambda: plain(Voronoi(cells=1, relax=-1))),
            ("hulls meet hulls alone", lambda: plain([hull, ball])), ("hulls meet", lambda: plain([ball, hull])),
            ("grains: expected RandomPacking", lambda: plain([])), ("grains: expected", lambda: plain([ball, 3])),
            ("materials: expected", lambda: plain([ball], materials=[])),
            ("materials: expected", lambda: plain([ball], materials=[3])), ("box: needs its edges",
             lambda: plain([ball], None)),
            ("box: is that of the lattice", lambda: plain(Lattice(radius=1, layers=(2, 2, 2)))),
            ("box: 0: must", lambda: plain([ball], (1, 0, 1))), ("box: expected finite", lambda: plain([ball], (1, 1))),
            ("pressure: 0: must", lambda: plain([ball], pressure=0)), ("friction: -1", lambda: plain([ball],
             friction=-1)),
            ("seed = -1", lambda: plain([ball], seed=-1))):
        refused(words, work)
    for value, words, how in ((np.inf, "", {}), (-1, " and at least 0.5", {"least": 0.5}),
                              (2, " and above 2", {"least": 2, "above": True})):
        need(scene_tools.refused("x", lambda: grus.samples._number("x", value, **how), InputError) ==
             f"x: {value:g}: must be finite{words}", words)
    # What is not given, and what is just allowed.
    need(Material()._plain() == {
        "name": "material", "density": 2650, "youngs_modulus": 60e9, "restitution": 1, "poissons_ratio": 0.25,
        "friction": 0, "rolling_friction": 0, "damping": 0, "rotation": True, "bond": None}, "a plain material")
    need(Material(rotation=False)._plain()["rotation"] is False and Bond(**BOND)._plain()["poissons_ratio"] == 0.2,
        "bonds")
    need(one == {"kind": "random", "radius": (1, 1), "solid_fraction": 0.5, "hulls": None, "balls": False,
                 "aspect": [1, 1, 1], "count": 0, "turned": True,
                 "parts": [{"material": 0, "share": 1, "aspect": [1, 1, 1]}]},
                  f"a plain packing: {one}")
    spheres = plain(Spheres(spheres=[[-1, -2, -3, 1]]))["grains"]
    need(spheres == {"kind": "spheres", "spheres": [[-1, -2, -3, 1]], "turned": True, "material": 0}, f"{spheres}")
    still = Grain(position=(0, 0, 0), radius=1)._plain()
    need(still["velocity"] == still["spin"] == [0, 0, 0] and still["orientation"] == [0, 0, 0, 1], "a grain at rest")
    need(Voronoi(cells=9)._plain() == {"kind": "voronoi", "cells": 9, "relax": 5, "clusters": 0, "material": 0},
        "cells")
    need([made._plain()["turned"] for made in (Lattice(radius=1, layers=(2, 2, 2), turned=False), Spheres(
        spheres=[[0, 0, 0, 1]], turned=False), RandomPacking(radius=1, solid_fraction=0.5,
         turned=False))] == [False] * 3,
         "grains that are not turned")
    heard.clear()
    Sample(SAND, Spheres(spheres=[[0, 0, 0, 1]]), box=(1, 1, 1))
    need(heard[0][1]["seed"] == 1 and plain([ball], seed=0)["seed"] == 0, "seeds")
    for least in (Lattice(radius=1, layers=(2, 2, 2), material=-1), Spheres(spheres=[[0, 0, 0, 1]], material=-1), Grain(
            position=(0, 0, 0), radius=1, material=-1), Voronoi(cells=1, material=-1), RandomPacking(
                radius=1, solid_fraction=0.5, parts=[(-1, 1, (1, 1, 1))])):
        refused("material = -1", least._plain)
    two = plain([ball], materials=[SAND, Material(friction=0.9)])
    need(len(two["materials"]) == 2 and two["friction"] == 0.3, "friction of the first material")


def names():
    """What the package has, and what it says where it has not."""
    need(set(grus.__all__) <= set(dir(grus)) and grus.Sample is Sample and grus.InputError is InputError, "names")
    refused("module 'grus' has no attribute 'none'", lambda: grus.none, AttributeError)
    need(next(itertools.islice(grus.__version__.split("."), 1)).isdigit(), "a version")


sets()
saved()
ranks()
one()
samples()
names()
print(f"logic: {len(faults)} faults")
sys.exit(bool(faults))
