# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of bonded cells, plates and polyhedra."""
import csv

import numpy as np
from scipy.spatial import ConvexHull

from values_tools import table

SEED = 1

ROCK = """
[material.rock]
density = 2500
contact = "overlap"
friction = 0.5
damping = 0.3
[material.rock.bond]
modulus = "10 GPa"
poissons_ratio = 0
criterion = "cohesive"
tension = "6 MPa"
cohesion = "18 MPa"
fracture_energy = "60 J/m^2"
damping = 0.1
"""
BAR = """
[packing]
kind = "voronoi"
box = ["3 mm", "4 mm", "6 mm"]
cells = {cells}
seed = {seed}
[[clamp]]
where = "z=min"
[[clamp]]
where = "z=max"
velocity = [0, 0, "60 mm/s"]
[loading]
kind = "free"
duration = "{ms} ms"
[output]
history_interval = "{us} us"
frames = 21
bursts = "1 us"
broken_bonds = true
grading = true
"""


def faces(a, b):
    """Points that two polyhedra share."""
    near = np.linalg.norm(a[:, None] - b[None], axis=2).min(1) < 1e-7
    return a[near]


def polygon(points):
    """Area, centroid and normal of points in a plane."""
    middle = points.mean(0)
    normal, _, axes = np.linalg.svd(points - middle)
    flat = (points - middle) @ axes[:2].T
    order = ConvexHull(flat).vertices
    x, y = flat[order].T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    centre = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()]) / (3 * cross.sum())
    return 0.5 * abs(cross.sum()), middle + centre @ axes[:2], axes[2]


def roundness(points):
    hull = ConvexHull(points)
    return np.cbrt(36 * np.pi * hull.volume**2) / hull.area


def one_face(values):
    """Two cells with one face, which softens and breaks: hand counts, and what the face takes."""
    run = values.run("rve", "one_face", ROCK + BAR.format(cells=2, seed=SEED, ms=0.6, us=6))
    rows, told, last = run.columns, run.told, run.last
    cells = run.frames()[0].grains()
    area, middle, normal = polygon(faces(*cells["points"]))
    normal *= np.sign(normal @ (cells["points"][1].mean(0) - cells["points"][0].mean(0)))
    broken = rows["bonds_broken"] > 0
    peak, row = rows["load_N"].argmax(), np.arange(len(broken))
    softens, sure = row > peak, abs(row - peak) > 1
    values.same("rve.columns:bonds", rows["bonds"], 1 - broken)
    values.same("rve.columns:bonds_damaged", rows["bonds_damaged"][sure], (softens & ~broken)[sure])
    values.same("rve.columns:bonds_broken", last["bonds_broken"], 1)
    values.same("rve.columns:fragments", rows["fragments"], 1 + broken)
    values.same("rve.columns:largest_fragment", rows["largest_fragment"], 2 - broken)
    values.same("rve.grains:fragment", run.frames()[-1].grains()["fragment"], [0, 1])
    values.same("rve.columns:fracture_J", last["fracture_J"], 60 * area, 0.02)
    values.same("rve.summary:energy.fracture_J", told["energy"]["fracture_J"], 60 * area, 0.02)
    values.same("rve.summary:energy.fracture_area_m2", told["energy"]["fracture_area_m2"], area, 1e-4)
    values.same("rve.columns:displacement_m", rows["displacement_m"], 0.06 * rows["time_s"], 1e-6, 1e-12)
    values.same("rve.columns:nominal_stress_Pa", rows["nominal_stress_Pa"], rows["load_N"] / 12e-6, 1e-6, 1e-3)
    values.same("rve.columns:load_N", rows["load_N"], -rows["wall1_fz_N"], 1e-6, 1e-9)
    whole = ~softens & ~broken & (rows["time_s"] > 5e-5)  # a network of ratio 0 has its modulus
    held_ = 0.5 * 10e9 * 12e-6 / 6e-3 * rows["displacement_m"]**2
    values.same("rve.columns:bond_J", rows["bond_J"][whole], held_[whole], 0.1)
    values.same("rve.columns:elastic_J", rows["elastic_J"][whole], held_[whole], 0.1)
    values.balance(run, "fracture_J", "damping_J")
    dashpots = last["damping_J"] - told["energy"]["local_damping_J"]
    values.same("rve.columns:bond_damping_J", last["bond_damping_J"], dashpots)
    values.same("rve.summary:errors.bond_damping", told["errors"]["bond_damping"], dashpots / last["work_J"], 1e-3)
    counts, cut = told["counts"], told["cells"]
    values.same("rve.summary:counts.bonds_broken", counts["bonds_broken"], 1)
    values.same("rve.summary:counts.fragments", counts["fragments"], 2)
    values.same("rve.summary:cells.fragments", cut["fragments"], [1, 1])
    values.same("rve.summary:cells.cells", cut["cells"], 2)
    values.same("rve.summary:cells.bonds_start", cut["bonds_start"], 1)
    values.same("rve.summary:results.peak_stress_Pa", told["results"]["peak_stress_Pa"],
                rows["nominal_stress_Pa"].max(), 1e-8)
    values.same("rve.summary:results.peak_stress_is_last", not told["results"]["peak_stress_is_last"], True)
    burst, about = table(run.path("bursts.csv")), told["bursts"]
    first = rows["time_s"][broken][0]
    expected = {"time_s": first, "bonds": 1, "energy_J": 60 * area, "area_m2": area}
    expected |= {f"{k}_m": x for k, x in zip("xyz", middle)}
    for name, value in expected.items():
        values.same(f"rve.bursts:{name}", burst[name], value, 0.05)
        for which in ("first", "last"):
            if name in about[which]:
                values.same(f"rve.summary:bursts.{which}.{name}", about[which][name], value, 0.05)
    with open(run.path("broken_bonds.csv"), newline="") as f:
        one, = csv.DictReader(f)
    values.same("rve.broken_bonds:mode", one.pop("mode") == "tension", True)
    # Stretched along z with as stiff a spring along the face as across it.
    expected |= {"grain_a": 0, "grain_b": 1, "shear_share": 1 - normal[2]**2}
    del expected["bonds"]
    for name, value in expected.items():
        values.same(f"rve.broken_bonds:{name}", float(one[name]), value, 0.05)
    for k in range(3):
        values.same(f"rve.broken_bonds:normal_{'xyz'[k]}", float(one[f"normal_{'xyz'[k]}"]), normal[k], 0.05, 0.02)
    values.same("rve.summary:bursts.count", about["count"], 1)
    values.same("rve.summary:bursts.largest", about["largest"], 1)
    values.same("rve.summary:bursts.window_s", about["window_s"], 1e-6)
    volume = np.array([ConvexHull(p).volume for p in cells["points"]])
    round_ = np.array([roundness(p) for p in cells["points"]])
    values.same("rve.grains:sphericity", cells["sphericity"], round_, 1e-4)
    values.same("rve.grains:radius", cells["radius"], np.cbrt(volume / (4 / 3 * np.pi)), 1e-4)
    values.same("rve.columns:sphericity", rows["sphericity"], (volume * round_).sum() / volume.sum(), 1e-4)
    values.same("rve.summary:shape.sphericity", told["shape"]["sphericity"], (volume * round_).sum() / volume.sum(),
                1e-4)
    mean = (volume * cells["angularity"]).sum() / volume.sum()
    values.same("rve.columns:angularity", rows["angularity"], mean, 1e-4)
    values.same("rve.summary:shape.angularity", told["shape"]["angularity"], mean, 1e-4)


def listed(values):
    """A cube and a tetrahedron with three right angles at a corner."""
    run = values.run("rve", "listed", """
[material.rock]
density = 2500
contact = "overlap"
foundation = "1e12 Pa/m"
[[grain]]
shape = "hull"
box = ["2 mm", "2 mm", "2 mm"]
position = [0, 0, 0]
velocity = [0, 0, 1]
[[grain]]
shape = "hull"
box = ["2 mm", "2 mm", "8 mm"]
position = ["10 mm", 0, 0]
[loading]
kind = "free"
duration = "1 us"
[output]
frames = 1
""")
    shown, shape = run.frames()[0].grains(), run.told["shape"]
    cube, beam = np.cbrt(np.pi / 6), np.cbrt(36 * np.pi * 16) / 18
    values.same("rve.grains:sphericity", shown["sphericity"], [cube, beam], 1e-5)
    values.same("rve.summary:shape.sphericity", shape["sphericity"], (cube + 4 * beam) / 5, 1e-6)
    values.same("rve.grains:angularity", shown["angularity"][0], np.pi / np.sqrt(2), 1e-5)
    values.same("rve.grains:elongation", shown["elongation"], [1, 0.25], 1e-4)
    values.same("rve.grains:flatness", shown["flatness"], [1, 1], 1e-4)
    both = shown["angularity"]
    values.same("rve.summary:shape.angularity", shape["angularity"], (both[0] + 4 * both[1]) / 5, 1e-6)


def plates(values):
    """Mean stress and deviator between plates."""
    run = values.run("rve", "plates", ROCK + """
[packing]
kind = "voronoi"
box = ["4 mm", "4.2 mm", "4.4 mm"]
cells = 30
[boundary]
kind = "walls"
bonded = "normal"
[loading]
kind = "constant-p"
axis = "z"
pressure = "5 MPa"
consolidation = "20 us"
strain_rate = 20
final_strain = 0.001
""")
    c = run.columns
    stress = np.stack([c[f"wall_stress_{k}_Pa"] for k in ("xx", "yy", "zz")])
    strain = np.stack([c[f"strain_{k}"] for k in ("xx", "yy", "zz")])
    off = lambda m: np.sqrt(((m - m.mean(0))**2).sum(0))
    values.same("rve.columns:p_Pa", c["p_Pa"], -stress.mean(0), 1e-6, 1)
    values.same("rve.columns:q_Pa", c["q_Pa"], np.sqrt(1.5) * off(stress), 1e-6, 1)
    values.same("rve.columns:strain_volumetric", c["strain_volumetric"], -strain.sum(0), 1e-6, 1e-9)
    values.same("rve.columns:strain_deviatoric", c["strain_deviatoric"], np.sqrt(2 / 3) * off(strain), 1e-6, 1e-9)


def sticking(values):
    """Two balls that attract: what their contact takes as it snaps off."""
    run = values.run("rve", "sticking", """
[material.sand]
density = 2650
youngs_modulus = "1 GPa"
poissons_ratio = 0.2
contact = "jkr"
work_of_adhesion = "20 J/m^2"
restitution = 1
[[grain]]
radius = "1 mm"
position = [0, 0, 0]
velocity = [0.3, 0, 0]
[[grain]]
radius = "1 mm"
position = ["2.001 mm", 0, 0]
velocity = [-0.3, 0, 0]
[loading]
kind = "free"
duration = "0.1 ms"
[numerics]
safety = 0.02
""")
    values.balance(run, "adhesion_J", "kinetic_J")
    values.same("rve.summary:energy.adhesion_J", run.told["energy"]["adhesion_J"], run.last["adhesion_J"])


def rods(values):
    """Two spheres that are cemented part, and slide: the lines of their bonds that break, by spring and mass."""
    radius, modulus, ratio, strength, density = 1e-3, 40e9, 0.4, 1e6, 2650
    area, stiffness = np.pi * radius**2, modulus / (2 * radius)
    mass = density * 4 / 3 * np.pi * radius**3
    modes = (("tension", "2, 0, 0", stiffness, 2), ("shear", "0, 2, 0", ratio * stiffness, 7))
    for mode, velocity, way, inertia in modes:
        run = values.run("rve", f"rods_{mode}", f"""
[material.rock]
density = {density}
contact = "linear-modulus"
contact_modulus = {modulus}
friction = 0.5
bond = {{ modulus = {modulus}, shear_ratio = {ratio}, tension = {strength}, shear = {strength}, gap = 0.1 }}
[[grain]]
shape = "sphere"
radius = {radius}
position = [0, 0, 0]
[[grain]]
shape = "sphere"
radius = {radius}
position = [{2 * radius}, 0, 0]
velocity = [{velocity}]
[loading]
kind = "free"
duration = 2e-7
[numerics]
time_step = 1e-10
[output]
broken_bonds = true
history_interval = 1e-8
""")
        # Each row of the spring has its masses, and along the plane the turning of both: 2/m, and 2 (1 + 5/2)/m.
        frequency = np.sqrt(way * area * inertia / mass)
        when = np.arcsin(strength / way * frequency / 2) / frequency
        with open(run.path("broken_bonds.csv"), newline="") as f:
            one, = csv.DictReader(f)
        values.same("rve.broken_bonds:mode", one.pop("mode") == mode, True)
        exact = {"time_s": when, "grain_a": 0, "grain_b": 1, "x_m": radius + when, "area_m2": area,
                 "energy_J": strength**2 * area / (2 * way), "shear_share": mode == "shear", "normal_x": 1}
        if mode == "shear":
            exact["x_m"] = radius
        for name, value in exact.items():  # a step is a four-hundredth of the way
            values.same(f"rve.broken_bonds:{name}", float(one[name]), float(value), 5e-3, 1e-9)


def held(values):
    for check in (one_face, listed, plates, sticking, rods):
        check(values)
