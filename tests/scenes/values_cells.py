# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of macro problems of grains, against their cells' own grains and against the programs' other files."""
import numpy as np

from values_crushing import SAND, SPLIT, diameter
from values_tools import PARTS, Frame, table

CELL = SAND + SPLIT.replace("9 MPa", "20 MPa") + """
[packing]
kind = "random"
box = ["1.5 mm", "1.5 mm", "1.5 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.56
[boundary]
kind = "periodic"
[preparation]
pressure = "1 MPa"
friction = 0.2
inertial_number = 1e-2
unbalanced_force = 2e-2
stress_change = 2e-2
window = 30
max_hold = 4000
"""
SQUARE = """
[mesh]
box = { size = ["20 mm", "30 mm"], cells = [1, 1], cell = "triangle" }
dimension = "plane-strain"
thickness = "10 mm"
[element]
quadrature_degree = 1
[rve]
scene = "cell.toml"
variants = 2
inertial_number = 1e-2
strain_per_step = 1e-4
unbalanced_force = 2e-2
stress_change = 2e-2
window = 30
max_hold = 4000
[[boundary]]
where = "y=min"
displacement = ["free", 0]
name = "foot"
[[boundary]]
where = "y=max"
displacement = ["free", "-0.6 mm"]
name = "head"
[[boundary]]
where = "x=min"
displacement = [0, "free"]
[[boundary]]
where = "x=max"
pressure = "1 MPa"
history = "constant"
[[probe]]
name = "one"
at = ["13 mm", "10 mm"]
grading = true
frames = true
[[probe]]
name = "two"
at = ["7 mm", "20 mm"]
grading = true
frames = true
[[probe]]
name = "all"
where = "x<1"
[solve]
kind = "quasi-static"
increments = 2
tolerance = 5e-2
displacement_tolerance = 0.3
[output]
frames = 4
costs = true
"""


def square(values):
    """Two points of breaking grains: what the run tells of them, by the grains that it shows of each."""
    run = values.run("bvp", "square", SQUARE, files=(("cell.toml", CELL),))
    last, told, rows = run.last, run.told, run.columns
    solid, lost, whole, grains, breakages, voids, begun = {}, {}, {}, {}, {}, {}, {}
    for name in ("one", "two"):
        frames = [Frame(run.path(x)) for x in run.series(f"grains_{name}")]
        # Before the first row nothing is shown: the mass at first from what has been lost of it.
        now, head = frames[-1].grains(), f"bvp.columns:probe_{name}_"
        put = lambda what, expected, rtol=1e-5, head=head, name=name: values.same(
            head + what, last[f"probe_{name}_{what}"], expected, rtol)
        volume = abs(np.linalg.det(frames[-1].lines()[1]))
        solid[name] = 4 / 3 * np.pi * (now["radius"]**3).sum()
        grains[name], voids[name] = len(now["id"]), volume / solid[name] - 1
        breakages[name] = now["id"].max() + 1 - grains[name]  # each split ends one and numbers two
        begun[name] = grains[name] - breakages[name]
        whole[name] = (1.5e-3)**3 * 0.56
        lost[name] = whole[name] - solid[name]
        put("grains", grains[name])
        put("breakages", breakages[name])
        put("void_ratio", voids[name])
        put("coordination", now["coordination"].mean())
        put("fines_fraction", lost[name] / whole[name], 1e-3)
        d, m = 2 * now["radius"], now["radius"]**3
        for part in (10, 50, 90):
            put(f"d{part}_m", diameter(d, m, part / 100, lost[name] / (4 / 3 * np.pi)))
    both = ("one", "two")
    values.same("bvp.columns:breakages", last["breakages"], sum(breakages.values()))
    values.same("bvp.columns:mass_lost_fraction", last["mass_lost_fraction"],
                sum(lost.values()) / sum(whole.values()), 1e-3)
    values.same("bvp.columns:probe_all_void_ratio", last["probe_all_void_ratio"], np.mean([voids[k] for k in both]),
                1e-4)
    values.same("bvp.columns:probe_all_grains", last["probe_all_grains"], sum(grains.values()))
    values.same("bvp.columns:probe_all_breakages", last["probe_all_breakages"], sum(breakages.values()))
    shown = run.frames("macro")[-1].cells
    order = np.argsort(shown["grains"])
    known = sorted((grains[k], voids[k], breakages[k] / begun[k]) for k in both)
    for k, field in enumerate(("grains", "void_ratio", "broken_fraction")):
        values.same(f"bvp.macro:{field}", shown[field][order], [x[k] for x in known], 1e-5)
    costs = table(run.path("costs.csv"))
    counts = told["counts"]
    values.same("bvp.costs:steps", costs["steps"].sum(), last["dem_steps"])
    values.same("bvp.columns:dem_steps", last["dem_steps"], costs["steps"].sum())
    values.same("bvp.columns:rves_advanced", last["rves_advanced"], len(costs["slot"]))
    values.same("bvp.columns:rves", rows["rves"], 2)
    values.same("bvp.costs:slot", np.bincount(costs["slot"].astype(int)), [len(costs["slot"]) / 2] * 2)
    values.same("bvp.costs:sweep", costs["sweep"].max() + 1, counts["material_sweeps"])
    values.same("bvp.summary:counts.material_sweeps", counts["material_sweeps"], len(costs["slot"]) / 2)
    for name, expected in (("dem_steps", costs["steps"].sum()), ("rves", 2), ("gauss_points", 2),
                           ("rves_asked", len(costs["slot"])), ("rves_advanced", len(costs["slot"])),
                           ("rves_distinct", 2), ("grains_a_point", begun["one"]),
                           ("breakages", sum(breakages.values())),
                           ("newton_iterations", rows["newton_iterations"].sum())):
        values.same(f"bvp.summary:counts.{name}", counts[name], expected)
    values.same("bvp.columns:rves_distinct", rows["rves_distinct"], 2)
    errors, of = told["errors"], last["macro_internal_J"]
    values.same("bvp.columns:macro_internal_J", of, last["rve_work_J"], 1e-6)
    values.same("bvp.columns:rve_work_J", last["rve_work_J"], of, 1e-6)
    values.same("bvp.summary:errors.rve_work_J", errors["rve_work_J"], of, 1e-6)
    work = max(last["macro_work_J"], of)
    values.same("bvp.summary:errors.hill_mandel", errors["hill_mandel"], abs(last["macro_work_J"] - of) / work, 1e-6)
    values.same("bvp.columns:energy_error", last["energy_error"], (last["macro_external_J"] - of) / work, 1e-5)
    values.same("bvp.summary:errors.last_energy_error", errors["last_energy_error"],
                (last["macro_external_J"] - of) / work, 1e-5)
    values.same("bvp.summary:errors.worst_residual", errors["worst_residual"], rows["residual"].max(), 1e-6)
    for name in ("correction", "worst_unbalanced_force", "worst_stress_change"):
        values.same(f"bvp.summary:errors.last_{name}", errors[f"last_{name}"], last[name], 1e-6)
    values.same("bvp.columns:unbalanced_macro_force", rows["unbalanced_macro_force"], rows["residual"])
    values.same("bvp.summary:errors.worst_rve_energy_error", errors["worst_rve_energy_error"],
                rows["worst_rve_energy_error"].max(), 1e-6)
    prepared = told["preparation"]
    values.same("bvp.summary:preparation.packed_void_ratio", prepared["packed_void_ratio"], 1 / 0.56 - 1, 1e-6)
    values.same("bvp.summary:preparation.starts", prepared["starts"], 2)
    values.same("bvp.summary:preparation.asked_pressure_Pa", prepared["asked_pressure_Pa"], 1e6)
    values.same("bvp.summary:errors.residual_floor", errors["residual_floor"], 2e-2)


def in_part(values):
    """Grains beside an elastic region: their own means are those of their only point."""
    begin = SQUARE.index("[[probe]]\nname = \"two\"")
    text = SQUARE[:begin] + SQUARE[SQUARE.index("[solve]"):]
    run = values.run("bvp", "in_part", text + """[[region]]
where = "y>0.015"
material = "elastic"
youngs_modulus = "200 MPa"
poissons_ratio = 0.2
density = 1500
""", "output.frames=0", "probe.0.frames=false", files=(("cell.toml", CELL),))
    for k, part in enumerate(PARTS):
        twice = 1 if k < 3 else 2  # engineering shear
        values.same(f"bvp.columns:grains_strain_{part}", run.last[f"grains_strain_{part}"],
                    twice * run.last[f"probe_one_strain_{part}"], 1e-6, 1e-12)
        values.same(f"bvp.columns:grains_stress_{part}_Pa", run.last[f"grains_stress_{part}_Pa"],
                    run.last[f"probe_one_stress_{part}_Pa"], 1e-6)
    values.same("bvp.columns:rves", run.last["rves"], 1)


def held(values):
    for check in (square, in_part):
        check(values)
