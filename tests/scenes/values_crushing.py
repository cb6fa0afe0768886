# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of grains that break, made again from frames and from what else a run has written."""
import os

import numpy as np

from scene_tools import shipped
from values_samples import Network
from values_tools import table

SAND = """
seed = 3
[material.sand]
density = 2650
youngs_modulus = "6 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0.2
"""
SPLIT = """
[material.sand.fracture]
model = "polyellipsoid-split"
hoek_brown = { compressive_strength = "9 MPa", m = 20.56 }
contact_tension = { strength = "30 MPa", critical_contacts = 3 }
weibull = { modulus = 3.1, reference_radius = "0.3 mm" }
cohesive_springs = { toughness = "0.2 MPa m^0.5" }
"""
BOX = """
[packing]
kind = "random"
box = ["2 mm", "2.2 mm", "2.4 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.5
[boundary]
kind = "walls"
friction = 0.1
[loading]
kind = "uniaxial-strain"
axis = "z"
strain_rate = "2000 1/s"
final_strain = 0.08
[numerics]
max_overlap = 3
[output]
history_interval = 0.004
frames = 21
contacts = true
grading = true
"""
BALLS = """
[material.sand.fracture]
model = "apollonian-14"
contact_strength = { strength = "60 MPa", area = "angle", angle = "20 deg" }
scatter = { distribution = "log-normal", variation = 0.5, reference_diameter = "0.6 mm", size_exponent = 1 }
smallest_radius = "0.05 mm"
fines = { dimension = 2.5, smallest = "0.01 mm" }
"""


def diameter(d, m, part, fines):
    """The smallest that `part` of the mass passes, fines being finer than all."""
    order = np.argsort(d)
    return d[order][np.searchsorted(fines + np.cumsum(m[order]), part * (fines + m.sum()))]


def gradings(values, run, first, now):
    """Sizes by mass, and how far the first grading has moved."""
    d, m = [2 * g["radius"] for g in (first, now)], [g["radius"]**3 for g in (first, now)]
    fines = m[0].sum() - m[1].sum()
    last, whole = run.last, m[0].sum()
    for part in (10, 50, 90):
        values.same(f"rve.columns:d{part}_m", last[f"d{part}_m"], diameter(d[1], m[1], part / 100, fines), 1e-5)
    values.same("rve.columns:fines_fraction", last["fines_fraction"], fines / whole, 1e-3)
    # Of fines, up to a tenth of what has broken, the mean of ln(d_ref / d) is ln(d_ref / top) + 1 / (3 - dimension).
    reference = d[0].max()
    logs = [(x * np.log(reference / y)).sum() / whole for x, y in zip(m, d)]
    logs[1] += fines / whole * (np.log(reference / (0.1 * d[0].mean())) + 2.5)
    values.same("rve.columns:breakage_einav", last["breakage_einav"], (logs[1] - logs[0]) / (2.5 - logs[0]), 0.1)
    potential = [(x * np.maximum(0, np.log10(y / 74e-6))).sum() for x, y in zip(m, d)]
    values.same("rve.columns:breakage_hardin", last["breakage_hardin"], 1 - potential[1] / potential[0], 1e-4)


def shapes(values, run, now):
    """Zingg's classes and mean shapes by mass."""
    m, long, flat = now["radius"]**3, now["elongation"], now["flatness"]
    for name, of in (("equant", (long > 2 / 3) & (flat > 2 / 3)), ("disc", (long > 2 / 3) & (flat <= 2 / 3)),
                     ("rod", (long <= 2 / 3) & (flat > 2 / 3)), ("blade", (long <= 2 / 3) & (flat <= 2 / 3))):
        values.same(f"rve.columns:zingg_{name}", run.last[f"zingg_{name}"], m[of].sum() / m.sum(), 1e-4)
    values.same("rve.columns:elongation", run.last["elongation"], (m * long).sum() / m.sum(), 1e-4)
    values.same("rve.columns:flatness", run.last["flatness"], (m * flat).sum() / m.sum(), 1e-4)


def split(values):
    """Polyellipsoids that split."""
    run = values.run("rve", "split", SAND + SPLIT + BOX, "output.gradings=2")
    frames, rows, told = [f.grains() for f in run.frames()], run.columns, run.told
    first, now = frames[0], frames[-1]
    volumes = np.array([4 / 3 * np.pi * (g["radius"]**3).sum() for g in frames])
    box = 2e-3 * 2.2e-3 * 2.4e-3 * (1 - 0.004 * np.arange(21))
    values.same("rve.columns:mass_kg", rows["mass_kg"], 2650 * volumes, 1e-5)
    values.same("rve.columns:mass_lost_kg", rows["mass_lost_kg"], 2650 * (volumes[0] - volumes), 1e-4,
                1e-6 * 2650 * volumes[0])
    values.same("rve.columns:solid_fraction", rows["solid_fraction"], volumes / box, 1e-5)
    values.same("rve.columns:void_ratio", rows["void_ratio"], box / volumes - 1, 1e-5)
    values.same("rve.columns:grains", rows["grains"], [len(g["id"]) for g in frames])
    # Each split makes two of one.
    values.same("rve.columns:breakages", rows["breakages"], rows["grains"] - rows["grains"][0])
    values.same("rve.grains:id", now["id"].max(), rows["grains"][0] - 1 + 2 * rows["breakages"][-1])
    values.same("rve.grains:generation", (0.5**now["generation"]).sum(), rows["grains"][0])
    gradings(values, run, first, now)
    shapes(values, run, now)
    values.balance(run, "split_J", "fracture_J", "damping_J", "friction_J", "elastic_J")
    energy, fines = told["energy"], told["fines"]
    values.same("rve.columns:split_J", run.last["split_J"], energy["split_elastic_J"] + fines["kinetic_J"], 1e-6)
    values.same("rve.columns:inertial_number", run.last["inertial_number"],
                2000 * 2 * now["radius"].mean() * np.sqrt(2650 / run.last["mean_pressure_Pa"]), 1e-4)
    values.same("rve.summary:fines.kinetic_J", fines["kinetic_J"], energy["fines_kinetic_J"])
    values.same("rve.summary:fines.mass_kg", fines["mass_kg"], 2650 * (volumes[0] - volumes[-1]), 1e-4)
    values.same("rve.summary:mass.lost_kg", told["mass"]["lost_kg"], 2650 * (volumes[0] - volumes[-1]), 1e-4)
    values.same("rve.summary:counts.breakages", told["counts"]["breakages"], rows["grains"][-1] - rows["grains"][0])
    whole = rows["axial_stress_Pa"][rows["breakages"] == 0].max()
    results = told["results"]
    values.same("rve.summary:results.peak_before_breakage_Pa", results["peak_before_breakage_Pa"], whole, 1e-8)
    values.same("rve.summary:results.peak_axial_stress_Pa", results["peak_axial_stress_Pa"],
                rows["axial_stress_Pa"].max(), 1e-8)
    values.same("rve.summary:errors.worst_energy_error", told["errors"]["worst_energy_error"],
                np.abs(rows["energy_error"]).max(), 1e-6)
    for name in ("fracture", "friction", "damping"):
        values.same(f"rve.summary:energy.{name}_J", energy[f"{name}_J"], run.last[f"{name}_J"], 1e-6)
    taken = run.last["split_J"] - energy["split_elastic_J"]
    values.same("rve.summary:energy.fines_kinetic_J", energy["fines_kinetic_J"], taken, 1e-4)
    values.same("rve.summary:energy.split_elastic_J", energy["split_elastic_J"], run.last["split_J"] - taken, 1e-4)
    values.same("rve.summary:results.peak_axial_stress_is_last", not results["peak_axial_stress_is_last"], True)
    classes(values, run, now, volumes)


def classes(values, run, now, volumes):
    """grading.csv: what lies in each class of sizes at the end."""
    c = {k: v[40:] for k, v in table(run.path("grading.csv")).items()}
    values.same("rve.grading:time_s", c["time_s"], run.last["time_s"])
    values.same("rve.grading:strain", c["strain"], 0.08)
    first = 2 * run.frames()[0].grains()["radius"]
    low, high = first.min() / 8, first.max()
    values.same("rve.grading:diameter_m", c["diameter_m"], low * (high / low)**(np.arange(1, 41) / 40), 1e-4)
    d, m = 2 * now["radius"], now["radius"]**3
    of = np.clip(np.searchsorted(c["diameter_m"] * (1 + 1e-5), d), 0, 39)
    count = np.bincount(of, minlength=40)
    values.same("rve.grading:grains", c["grains"], count)
    values.same("rve.grading:mass_kg", c["mass_kg"], np.bincount(of, 2650 * 4 / 3 * np.pi * m, 40), 1e-5)
    lost = (volumes[0] - volumes[-1]) / (4 / 3 * np.pi)
    finer = np.array([m[d <= x * (1 + 1e-5)].sum() for x in c["diameter_m"]])
    coarse = c["diameter_m"] > 0.1 * high  # than all fines
    values.same("rve.grading:passing", c["passing"][coarse], ((lost + finer) / (lost + m.sum()))[coarse], 1e-3)
    for name in ("coordination", "elongation", "flatness", "generation"):
        values.same(f"rve.grading:{name}", c[name], np.bincount(of, now[name], 40) / np.maximum(count, 1), 1e-4)


def reshaped(values):
    """Halves that become rounder put in what their spins and surfaces do."""
    run = values.run("rve", "reshaped", SAND + SPLIT + 'shape_transition = { ratio = 0.5, time = "5 us" }\n' + BOX,
                     "loading.final_strain=0.03", "seed=4")
    values.balance(run, "reshape_J")
    values.same("rve.summary:energy.reshape_J", run.told["energy"]["reshape_J"], run.last["reshape_J"])


def balls(values):
    """Balls between walls, broken into fourteen."""
    run = values.run("rve", "balls", SAND + BALLS + BOX, "numerics.inertia.scaled_below=0.3 mm",
                     "material.sand.youngs_modulus=0.1 GPa",
                     "material.sand.fracture.contact_strength.strength=12 MPa",
                     "loading.final_strain=0.2", "output.history_interval=0.02")
    net, last, now = Network(run, -1), run.last, run.frames()[-1].grains()
    first = run.frames()[0].grains()
    wall = net.b < 0
    size, count = np.diag(net.edges), len(net.radius)
    values.balance(run, "inertia_J")
    values.same("rve.columns:coordination", last["coordination"], (2 * (~wall).sum() + wall.sum()) / count)
    begun = 4 / 3 * np.pi * (first["radius"]**3).sum()
    values.same("rve.columns:void_ratio_all", last["void_ratio_all"], net.volume / begun - 1, 1e-4)
    overlap = net.cells["overlap_m"] / net.smaller
    for share in (10, 30):
        values.same(f"rve.columns:overlap_share_{share}", last[f"overlap_share_{share}"],
                    (overlap > share / 100).mean())
    values.same("rve.summary:errors.overlap_to_radius.last", run.told["errors"]["overlap_to_radius"]["last"],
                overlap.max(), 1e-4)
    stress = []
    for k, part in enumerate(("xx", "yy", "zz")):
        area = net.volume / size[k]
        across = np.abs(net.normal[:, k]) > 0.999
        plus, minus = (abs(net.force[wall & across & (net.normal[:, k] * s > 0)][:, k].sum()) for s in (1, -1))
        stress.append(0.5 * (plus + minus) / area)
        values.same(f"rve.columns:wall_stress_{part}_Pa", last[f"wall_stress_{part}_Pa"], -stress[-1], 1e-4)
    values.same("rve.columns:stress_front_Pa", last["stress_front_Pa"], plus / area, 1e-4)
    values.same("rve.columns:stress_back_Pa", last["stress_back_Pa"], minus / area, 1e-4)
    values.same("rve.columns:axial_stress_Pa", last["axial_stress_Pa"], stress[2], 1e-4)
    values.same("rve.columns:k0", last["k0"], 0.5 * (stress[0] + stress[1]) / stress[2], 1e-4)
    off = abs(sum(stress) / 3 - last["mean_pressure_Pa"])
    rows = run.columns
    walls = -(rows["wall_stress_xx_Pa"] + rows["wall_stress_yy_Pa"] + rows["wall_stress_zz_Pa"]) / 3
    values.same("rve.summary:errors.wall_minus_cell_pressure.last",
                run.told["errors"]["wall_minus_cell_pressure"]["last"], off / walls.max(), 1e-3)
    bear = walls != 0
    apart, pressed = np.abs(walls - rows["mean_pressure_Pa"])[bear], np.maximum.accumulate(np.abs(walls))[bear]
    values.same("rve.summary:errors.wall_minus_cell_pressure.worst",
                run.told["errors"]["wall_minus_cell_pressure"]["worst"], (apart / pressed).max(), 1e-4)
    m = now["radius"]**3
    fines = (first["radius"]**3).sum() - m.sum()
    values.same("rve.columns:fines_fraction", last["fines_fraction"], fines / (fines + m.sum()), 1e-4)


def halves(values):
    """A grain that bursts between plates: its two contacts, what they bore, and what its halves kept."""
    with open(os.path.join(shipped, "single_grain.toml")) as f:
        run = values.run("rve", "halves", f.read(), "loading.final_strain=0.1", "output.frames=0",
                         "output.split_statistics=true", "output.history_interval=0.0005")
    c = run.columns
    at = np.flatnonzero(c["breakages"] == 1)[0]
    before, after = 0.6e-3**2 * c["axial_stress_Pa"][[at - 1, at]]
    for name, expected, rtol in (("contacts", 2, 0), ("contacts_kept", 2, 0), ("instants", 1, 0),
                                 ("force_N", 2 * before, 0.02), ("force_kept_N", 2 * after, 0.02),
                                 ("pressure_jump", 1 - after / before, 0.1)):
        values.same(f"rve.columns:split_{name}", c[f"split_{name}"][at], expected, rtol)


def held(values):
    for check in (split, reshaped, balls, halves):
        check(values)
