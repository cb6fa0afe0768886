# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of explicit runs: a wave, a block at rest, cells under a load that goes on."""
import numpy as np

from values_cells import CELL, SQUARE
from values_devices import BLOCK as GRAINS, LATTICE
from values_macro import BLOCK

E, RHO, LENGTH = 10e9, 2000.0, 0.4
BAR = f"""
[mesh]
box = {{ size = ["10 mm", {LENGTH}], cells = [1, 80] }}
dimension = "plane-strain"
thickness = "5 mm"
[[region]]
where = "y<1"
material = "elastic"
youngs_modulus = {E}
poissons_ratio = 0
density = {RHO}
[[boundary]]
where = "y=min"
pressure = "1 MPa"
history = "constant"
[solve]
kind = "explicit-dynamic"
duration = "150 us"
linear_viscosity = 0.1
[output]
history_interval = "10 us"
"""


def lack(run, columns, *taken):
    """What the macro balance lacks."""
    return columns["macro_external_J"] - sum(columns[f"macro_{k}_J"] for k in taken)


def wave(values):
    """A step of pressure runs along a bar: half of its work moves, half is held."""
    run = values.run("bvp", "wave", BAR)
    c, t = run.columns, run.columns["time_s"]
    speed, area = np.sqrt(E / RHO), 10e-3 * 5e-3
    late = t > 50e-6
    work = 1e6 * area * 1e6 / (RHO * speed) * t
    for name, share in (("external", 1), ("kinetic", 0.5), ("internal", 0.5)):
        values.same(f"bvp.columns:macro_{name}_J", c[f"macro_{name}_J"][late], share * work[late], 0.1)
    values.same("bvp.columns:macro_work_J", c["macro_work_J"][late], 0.5 * work[late], 0.1)
    values.same("bvp.columns:kinetic_over_internal", c["kinetic_over_internal"],
                c["macro_kinetic_J"] / np.maximum(c["macro_external_J"], c["macro_internal_J"]), 1e-6)
    lacks = lack(run, c, "kinetic", "internal", "viscous")
    for name in ("energy_error", "macro_energy_error"):
        values.same(f"bvp.columns:{name}", c[name], lacks / c["macro_external_J"], 1e-3, 1e-8)
    taken = c["macro_viscous_J"][-1]
    values.same("bvp.columns:macro_viscous_J", taken, taken + lacks[-1], 0.1)
    values.same("bvp.columns:mean_strain_yy", run.last["mean_strain_yy"], -1e6 / E * speed * t[-1] / LENGTH, 0.03)
    values.same("bvp.summary:counts.material_sweeps", run.told["counts"]["material_sweeps"],
                run.last["increment"] + 1)


def resting(values):
    """A block is loaded while it stays at rest: rate and what bounds it, damping by the balance."""
    begin, whole = BLOCK.index("[solve]"), ("balance", "kinetic")
    for k, limits in enumerate(((0.02, 0.01), (0.2, 2e-4))):
        text = BLOCK[:begin].replace('cells = [2, 2, 2], cell = "tetrahedron"', "cells = [1, 1, 2]") + (
            '[solve]\nkind = "explicit-quasi-static"\ncrossings = 40\n' +
            "".join(f"{a} = {b}\n" for a, b in zip(whole, limits)) + "[output]\nhistory_interval = 0.05\n")
        run = values.run("bvp", f"resting{k}", text.replace("0.3 MPa", "0 MPa"))
        c, inner = run.columns, slice(4, -1)
        steady = np.flatnonzero(np.diff(c["load_rate"])[:-1] == 0) + 1  # a load factor a step; at the end it rests
        moved = np.diff(c["time_s"]) / np.diff(c["increment"])
        values.same("bvp.columns:load_rate", c["load_rate"][steady], moved[steady - 1], 1e-6)
        shares = np.stack([c["residual"] / limits[0], c["kinetic_over_internal"] / limits[1]])
        bound = np.abs(np.log(shares[0] / shares[1])) > 0.5
        values.same("bvp.columns:rate_governor", c["rate_governor"][inner][bound[inner]],
                    (shares.argmax(0) + 1)[inner][bound[inner]])
        put = lack(run, c, "kinetic", "internal", "damped") + c["macro_scaled_J"]
        values.same("bvp.columns:energy_error", c["energy_error"], put / c["macro_external_J"], 1e-3, 1e-8)


def cells(values):
    """Two points of grains under a load that goes on: haste, cells' rate, devices; cells that give up."""
    begin = SQUARE.index("[solve]")
    text = SQUARE[:begin].replace("unbalanced_force = 2e-2\nstress_change = 2e-2\nwindow = 30\nmax_hold = 4000",
                                  "damping = 0.2").replace('pressure = "1 MPa"\nhistory = "constant"',
                                                           'displacement = [0, "free"]')
    text += ('[solve]\nkind = "explicit-quasi-static"\ncrossings = 40\nkinetic = 0.1\nbalance = 0.2\n'
             'max_energy_error = 0.9\n[output]\nhistory_interval = 0.1\n')
    run = values.run("bvp", "cells", text, files=(("cell.toml", CELL),))
    c, last, told = run.columns, run.last, run.told
    haste = c["rve_work_J"] - c["macro_internal_J"]
    values.same("bvp.columns:cells_haste_J", last["cells_haste_J"], haste[-1], 1e-4)  # the load rests
    values.same("bvp.columns:inertial_number", c["inertial_number"].max(), 0.01, 1e-6)  # the limit of the scene
    done, devices = max(last["rve_work_J"], last["macro_external_J"]), told["errors"]["devices"]
    values.same("bvp.summary:errors.devices.haste_of_cells", devices["haste_of_cells"], haste[-1] / done, 1e-4)
    # Nothing is at rest after steps of this many.
    values.same("bvp.columns:rves_advanced", last["rves_advanced"], 2 * (last["increment"] + 1))
    values.same("bvp.columns:p_Pa", c["p_Pa"], -(c["mean_stress_xx_Pa"] + c["mean_stress_yy_Pa"] +
                                                 c["mean_stress_zz_Pa"]) / 3, 1e-6)
    values.same("bvp.columns:strain_volumetric", last["strain_volumetric"], 0.6 / 30, 1e-6)


def regularised(values):
    """Two elements of different packings, told the average of their stretches: what is left out is in the balance."""
    begin, length = SQUARE.index("[solve]"), 5e-3
    text = SQUARE[:begin].replace("unbalanced_force = 2e-2\nstress_change = 2e-2\nwindow = 30\nmax_hold = 4000",
                                  "damping = 0.2")
    text += ('[solve]\nkind = "explicit-quasi-static"\ncrossings = 40\nkinetic = 0.1\nbalance = 0.2\n'
             f'max_energy_error = 0.9\n[output]\nhistory_interval = 0.1\n[regularisation]\nlength = {length}\n')
    run = values.run("bvp", "regularised", text, files=(("cell.toml", CELL),))
    last, told = run.last, run.told["errors"]["regularisation"]
    taken = last["macro_internal_J"] - (last["rve_work_J"] - last["cells_haste_J"])  # the load rests
    values.same("bvp.columns:regularisation_J", last["regularisation_J"], taken, 1e-2)
    # One point an element: the mass is dealt to the corners; gradients of a right triangle.
    x, y = 20e-3, 30e-3
    gradient = np.array([[-1 / x, -1 / y], [1 / x, 0], [0, 1 / y]])
    matrix = np.eye(3) / 3 + length**2 * gradient @ gradient.T
    scale = np.diag(matrix)**-0.5
    low, _, high = np.linalg.eigvalsh(scale[:, None] * matrix * scale)
    values.same("bvp.summary:errors.regularisation.degree", told["degree"],
                np.ceil(np.arccosh(1 / told["promised"]) / np.arccosh((high + low) / (high - low))))
    values.same("bvp.summary:errors.regularisation.promised", told["promised"], 1e-3)


def stiffening(values):
    """A column of lattices of Hertz's spheres, which stiffen as they are pressed: elements that move become heavier,
    and what that puts in is what their balance has too much without it."""
    text = GRAINS.replace('"10 mm"], cells = [1, 1, 1]', '"40 mm"], cells = [1, 1, 4]').replace(
        "unbalanced_force = 2e-2\nstress_change = 2e-2\nwindow = 30\npressure_floor = 1e6\n", "damping = 0.2\n")
    for where, ways in (("x", (0, "free", "free")), ("y", ("free", 0, "free"))):
        text += "".join(f'[[boundary]]\nwhere = "{where}={side}"\ndisplacement = {list(ways)}\n'
                        for side in ("min", "max"))
    text += "".join(f'[[boundary]]\nwhere = "z={side}"\ndisplacement = ["free", "free", {way}]\n'
                    for side, way in (("min", 0), ("max", -1e-3)))
    text += ('[solve]\nkind = "explicit-quasi-static"\ncrossings = 20\nkinetic = 0.3\nbalance = 0.5\n'
             'max_energy_error = 0.9\n[output]\nhistory_interval = 0.1\n')
    run = values.run("bvp", "stiffening", text, files=(("cell.toml", LATTICE),))
    last, devices = run.last, run.told["errors"]["devices"]
    put = -lack(run, last, "kinetic", "internal", "viscous", "damped")
    values.same("bvp.columns:macro_scaled_J", last["macro_scaled_J"], put, 0.2)
    for name, joule in (("scaled_masses", put), ("macro_damping", last["macro_damped_J"])):
        values.same(f"bvp.summary:errors.devices.{name}", devices[name], joule / last["macro_external_J"], 0.2)


def held(values):
    for check in (wave, resting, cells, regularised, stiffening):
        check(values)
