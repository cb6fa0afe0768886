# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of grains that split in flight and of fresh faces, by what is conserved; shapes that are known."""
import os

import numpy as np

from scene_tools import shipped
from values_crushing import SAND

R, RHO = 0.3e-3, 2650.0
MASS = 4 / 3 * np.pi * R**3 * RHO
DRIFT, AT = np.array([3.0, -7.0, 5.0]), np.array([1.0, 0.5, -0.25])


def in_flight(values):
    """Two hard grains crush a third between them, all far from the origin and drifting: fines take what grains lose."""
    body = lambda material, x, v: (f"[[grain]]\nradius = {R}\nmaterial = \"{material}\"\n"
                                   f"position = {(AT + [x, 0, 0]).tolist()}\n"
                                   f"velocity = {(DRIFT + [v, 0, 0]).tolist()}\n"
                                   "orientation = [0.996194698092, 0.054012260453, 0.067950908311, 0.007840489421]\n")
    text = SAND.replace("damping = 0.2", "damping = 0") + """
[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "100 MPa", m = 20.56 }
max_generations = 1
[material.steel]
density = 2650
youngs_modulus = "60 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0
""" + body("sand", 0, 0) + body("steel", -2.001 * R, 60) + body("steel", 2.001 * R, -60) + """
[loading]
kind = "free"
duration = "20 us"
[output]
frames = 2
"""
    run = values.run("rve", "in_flight", text)
    now, fines = run.frames()[-1].grains(), run.told["fines"]
    mass = 4 / 3 * np.pi * now["radius"]**3 * RHO
    whole, carried = 3 * MASS * DRIFT, mass @ now["velocity"]
    values.same("rve.summary:fines.mass_kg", fines["mass_kg"], 3 * MASS - mass.sum(), 1e-4)
    scale = np.abs(whole - carried).max()
    values.same("rve.summary:fines.momentum_kg_m_s", fines["momentum_kg_m_s"], whole - carried, 1e-3, 1e-3 * scale)
    # About an origin so far off that spins, which frames do not show, are less than 1e-3 of it.
    arms = np.cross(now["centre"], now["velocity"])
    lost = np.cross(AT, whole) - mass @ arms
    values.same("rve.summary:fines.angular_momentum_kg_m2_s", fines["angular_momentum_kg_m2_s"], lost, 5e-3,
                5e-3 * np.abs(lost).max())


def fresh_faces(values):
    """Bonds of fresh faces begin with energy that nothing held before: what the balance has too much without it."""
    with open(os.path.join(shipped, "polycrystal_disc.toml")) as f:
        text = f.read()
    run = values.run("rve", "fresh_faces", text, "output.frames=0", "packing.cells=12", "loading.strain_rate=8",
                     "loading.final_strain=4e-4", "material.rock.fracture.fracture_energy=20",
                     "material.rock.fracture.toughness=0.02e6")
    c, last, told = run.columns, run.last, run.told
    taken = sum(last[f"{k}_J"] for k in ("kinetic", "elastic", "friction", "damping", "fracture", "handed"))
    put = taken - last["work_J"]
    values.same("rve.summary:errors.put_in_by_splits", told["errors"]["put_in_by_splits"],
                put / max(np.abs(c["work_J"]).max(), last["kinetic_J"] + last["elastic_J"]), 0.05)
    values.same("rve.summary:energy.split_elastic_J", -told["energy"]["split_elastic_J"], put, 0.05)


def blades(values):
    """Ellipsoids of known axes: a blade is as much longer than wide as it is wider than thick."""
    axes = {"blade": (4, 2, 1), "rod": (4, 2, 1.6), "disc": (4, 3, 1), "equant": (4, 3, 2.5)}
    text = SAND + "".join(f"""[[grain]]
shape = "polyellipsoid"
semi_axes = {(1e-4 * np.repeat(a, 2)).tolist()}
position = [{1e-2 * k}, 0, 0]
""" for k, a in enumerate(axes.values())) + """
[loading]
kind = "free"
duration = "10 us"
[output]
grading = true
"""
    run = values.run("rve", "blades", text)
    volume = np.array([np.prod(a) for a in axes.values()])
    for name, v in zip(axes, volume):
        values.same(f"rve.columns:zingg_{name}", run.columns[f"zingg_{name}"], v / volume.sum(), 1e-6)
    ratios = np.array([(b / a, c / b) for a, b, c in axes.values()])
    for k, name in enumerate(("elongation", "flatness")):
        values.same(f"rve.columns:{name}", run.last[name], (volume * ratios[:, k]).sum() / volume.sum(), 1e-6)


def held(values):
    for check in (in_flight, fresh_faces, blades):
        check(values)
