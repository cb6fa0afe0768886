# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inertia by step and the grain that sets the step: piles of boxes, by hand."""
import numpy as np

C, RHO, A = 1e13, 2650.0, 1e-3  # foundation (Pa/m), density, edge (m)
ROCK = f"""
[material.rock]
density = {RHO}
contact = "overlap"
foundation = {C}
[material.heavy]
density = {100 * RHO}
contact = "overlap"
foundation = {C}
"""
TEST = """
[boundary]
kind = "walls"
box = {0}
[loading]
kind = "uniaxial-strain"
axis = "z"
strain_rate = {1}
final_strain = 1e-4
[numerics]
safety = 0.5
inertia = {{ step = {2} }}
[output]
history_interval = 2e-5
critical_grain = true
"""


def boxes(*rows):
    return "".join(f'[[grain]]\nshape = "hull"\nmaterial = "{material}"\nbox = {list(edges)}\nposition = {list(at)}\n'
                   for material, edges, at in rows)


def pile(values):
    """A cube on a larger one between walls. Eigenvalues over c A^2 / m of the larger: shifts 1 + 2/4, of the smaller
    8 (2/4 + 1/4); rocking 6 (1/12 + 2/192) and 8 x 24 x 3/192. The step allows 1."""
    unit, deep, rate = C * A**2 / (RHO * A**3), 1e-4 * A, 0.5
    low, high = 0.5 * A - deep, 1.25 * A - 2 * deep
    text = ROCK + boxes(("rock", [A] * 3, [1.5 * A, 1.5 * A, low]), ("rock", [0.5 * A] * 3, [1.5 * A, 1.5 * A, high]))
    run = values.run("rve", "pile", text + TEST.format([3 * A, 3 * A, 1.5 * A - 3 * deep], rate, unit**-0.5))
    shift, turn = np.array([1.5, 6.0]), np.array([1.0, 3.0])
    mass, moment = np.array([1, 1 / 8]), np.array([1, 1 / 32])
    added = (mass * (shift - 1)).sum() / mass.sum(), (moment * (turn - 1)).sum() / moment.sum()
    for name, expected in zip(("added_mass", "added_moment"), added):
        values.same(f"rve.columns:{name}", run.columns[name], expected, 5e-3)
        values.same(f"rve.summary:inertia.{name}.last", run.told["inertia"][name]["last"], run.last[name], 1e-8)
        values.same(f"rve.summary:inertia.{name}.worst", run.told["inertia"][name]["worst"], run.columns[name].max(),
                    1e-8)
    values.same("rve.summary:inertia.heavier_grains", run.told["inertia"]["heavier_grains"], 1)
    values.same("rve.summary:inertia.slower_grains", run.told["inertia"]["slower_grains"], 0.5)
    diameter = A * (6 / np.pi)**(1 / 3) * np.array([1, 0.5])
    own = rate * diameter[:, None] * np.sqrt(shift[:, None] * RHO / run.columns["mean_pressure_Pa"])
    values.same("rve.summary:inertia.largest_inertial_number", run.told["inertia"]["largest_inertial_number"],
                own.max(), 5e-3)
    values.same("rve.columns:time_step_s", run.columns["time_step_s"], unit**-0.5, 1e-3)
    values.balance(run, "work_J", "elastic_J")


def bar(values):
    """A bar on two heavy blocks under a wall: it turns about its middle faster than it shifts."""
    deep = 1e-4 * A
    edges, block = [10 * A, A, A], [2 * A] * 3
    text = ROCK + boxes(*(("heavy", block, [x * A, 6 * A, A - deep]) for x in (2, 10)),
                        ("rock", edges, [6 * A, 6 * A, 2.5 * A - 2 * deep]))
    run = values.run("rve", "bar", text + TEST.format([12 * A, 12 * A, 3 * A - 3 * deep], 0.1, 1e-9))
    # Both blocks 2 mm wide: they reach 2 mm under the bar's ends.
    shift = (10 + 2 * 2 * 2) * C * A**2 / (10 * RHO * A**3)
    turns = 1e3 / 12 + 2 * 2 * (2 * 4**2 + 8 / 12)
    turn = turns * C * A**4 / (10 * RHO * A**5 * 101 / 12)
    assert turn > shift
    values.same("rve.columns:critical_grain", run.columns["critical_grain"], 2)
    values.same("rve.columns:critical_diameter_m", run.columns["critical_diameter_m"], 2 * A * (7.5 / np.pi)**(1 / 3))
    values.same("rve.columns:critical_width_m", run.columns["critical_width_m"], A)
    values.same("rve.columns:critical_turning", run.columns["critical_turning"], 1, 1e-6)
    values.same("rve.columns:time_step_s", run.columns["time_step_s"], 0.5 * 2 / turn**0.5, 5e-3)


def held(values):
    for check in (pile, bar):
        check(values)
