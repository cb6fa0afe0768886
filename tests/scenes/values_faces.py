# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of bonded faces: which of them are bonded, which soften too soon, how bursts are spread, what rubs."""
import itertools

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.spatial import cKDTree

from values_bonded import BAR, ROCK
from values_tools import table


def prisms(values):
    """Hexagonal prisms that stand on each other: a bond is too coarse where its length is more than 2 E G / s^2, s
    being 1 / 0.95 of its tension: some room is left to soften in."""
    tension, energy = 6e6 / 0.95, 60
    limit = 2 * 10e9 * energy / tension**2  # of the distance of two centres
    for part, count in ((0.99, 0), (1.01, 1)):
        run = values.run("rve", f"prisms{count}", ROCK.replace("18 MPa", "1 MPa") + f"""
[packing]
kind = "prisms"
box = [{2.2 * limit}, {2.2 * limit}, {2 * part * limit}]
side = {0.5 * limit}
thickness = {part * limit}
[loading]
kind = "free"
duration = "1 us"
[output]
frames = 1
""")
        cut = run.told["cells"]
        # Sides lie sqrt(3) / 2 of the limit apart: the faces between the two layers alone may be too coarse.
        values.same("rve.summary:cells.too_coarse_for_energy", cut["too_coarse_for_energy"],
                    0 if count == 0 else cut["cells"] / 2)


def shared_faces(bodies, edges=None):
    """(body, body, image of it) -> corners that they have in common, three and more, each pair once; `edges`: columns
    of a periodic cell."""
    ways = [(0, 0, 0)] if edges is None else list(itertools.product((-1, 0, 1), repeat=3))
    copies = [body + (edges @ way if edges is not None else 0) for way in ways for body in bodies]
    own, all_ = (np.repeat(np.arange(len(x)), [len(b) for b in x]) for x in (bodies, copies))
    at, found = np.concatenate(bodies), {}
    for a, near in enumerate(cKDTree(np.concatenate(copies)).query_ball_point(at, 1e-9)):
        for b in near:
            image, other = divmod(all_[b], len(bodies))
            if own[a] < other:
                found.setdefault((own[a], other, image), []).append(at[a])
    return {pair: np.array(corners) for pair, corners in found.items() if len(corners) > 2}


def smallest(values):
    """Faces too small for a bond, among those that the cells' corners show."""
    run = values.run("rve", "smallest", ROCK + BAR.format(cells=700, seed=1, ms=1e-4, us=1e-1).replace(
        "frames = 21", "frames = 1"), "packing.relax=0")
    cut, cells = run.told["cells"], run.frames()[0].grains()
    faces = shared_faces(cells["points"])
    values.same("rve.summary:cells.unbonded_faces", cut["unbonded_faces"], len(faces) - cut["bonds_start"])
    size = sorted(np.ptp(corners, 0).max() for corners in faces.values())
    values.same("rve.summary:cells.bonds_start", cut["bonds_start"], (np.array(size) > 4e-7).sum(), 2e-3)


def bursts(values):
    """The exponent of a power law by the largest likelihood, and its error by how sharp that is."""
    run = values.run("rve", "bursts", ROCK + BAR.format(cells=40, seed=2, ms=0.3, us=15).replace('"1 us"', '"4 us"'),
                     "clamp.1.velocity=[0, 0, 0.3]", "output.frames=0")
    sizes, told = table(run.path("bursts.csv"))["bonds"], run.told["bursts"]
    s = np.arange(1, sizes.max() + 1)
    likelihood = lambda a: -a * np.log(sizes).sum() - len(sizes) * np.log((s**-a).sum())
    best = minimize_scalar(lambda a: -likelihood(a), bounds=(-5, 15), method="bounded", options={"xatol": 1e-9}).x
    d = 1e-3
    bent = (2 * likelihood(best) - likelihood(best - d) - likelihood(best + d)) / d**2
    values.same("rve.summary:bursts.exponent", told["exponent"], best, 1e-4)
    values.same("rve.summary:bursts.exponent_error", told["exponent_error"], bent**-0.5, 1e-3)
    values.same("rve.summary:bursts.count", told["count"], len(sizes))
    values.same("rve.summary:bursts.largest", told["largest"], sizes.max())


def rubbing(values):
    """Two prisms slide on each other under pressure and give way: until their face breaks nothing else rubs."""
    run = values.run("rve", "rubbing", ROCK + """
[packing]
kind = "prisms"
box = ["2.2 mm", "2.2 mm", "1 mm"]
side = "1 mm"
thickness = "0.5 mm"
[[clamp]]
where = "z=min"
[[clamp]]
where = "z=max"
velocity = ["60 mm/s", 0, "-4 mm/s"]
[loading]
kind = "free"
duration = "0.4 ms"
[output]
history_interval = "3 us"
""", "material.rock.bond.friction_angle=0", "material.rock.bond.shear_energy=40")
    c, told = run.columns, run.told["energy"]
    whole = (c["bonds"] == 1) & (c["bond_friction_J"] > 0)
    values.balance(run, "friction_J", "fracture_J")
    for name in ("bond_friction_J", "handed_J", "energy_unexplained_J"):
        values.same(f"rve.summary:energy.{name}", told[name], run.last[name])
    values.same("rve.columns:bond_friction_J", c["bond_friction_J"][whole], c["friction_J"][whole], 1e-9)


def held(values):
    for check in (prisms, smallest, bursts, rubbing):
        check(values)
