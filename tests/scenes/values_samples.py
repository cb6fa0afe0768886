# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of samples of grains, made again from the frames of their grains and contacts."""
import numpy as np
from scipy.linalg import expm

from values_tools import PARTS, voigt

K = 4e5
SHEARED = f"""
seed = 5
[material.sand]
density = 2650
contact = "linear"
normal_stiffness = {K}
shear_ratio = 0.5
friction = 0.3
restitution = 1
damping = 0
[material.coal]
density = 1400
contact = "linear"
normal_stiffness = {2 * K}
shear_ratio = 0.5
friction = 0.3
restitution = 1
damping = 0
[packing]
kind = "random"
box = ["2 mm", "2.2 mm", "2.4 mm"]
radius = {{ distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }}
solid_fraction = 0.55
[[packing.mixture]]
material = "sand"
share = 3
[[packing.mixture]]
material = "coal"
share = 1
[boundary]
kind = "periodic"
[loading]
kind = "velocity-gradient"
velocity_gradient = [[-120, 60, -90], [0, -150, 80], [0, 0, -200]]
duration = "0.32 ms"
[output]
history_interval = "0.04 ms"
frames = 2
contacts = true
grading = true
"""
DENSITY = np.array([2650.0, 1400.0])


class Network:
    """Grains of a frame, and between which of them each contact's line lies, walls as -1."""

    def __init__(self, run, number):
        frame, lines = run.frames()[number], run.frames("contacts")[number]
        self.grains, self.force, self.cells = frame.grains(), lines.cells["force_N"], lines.cells
        self.corner, self.edges = frame.lines()
        self.begin, self.end = lines.branches()
        self.branch = self.end - self.begin
        self.volume, self.radius = abs(np.linalg.det(self.edges)), self.grains["radius"]
        self.a, self.b = self.owner(self.begin), self.owner(self.end)
        wall = self.b < 0
        self.normal = self.branch / np.linalg.norm(self.branch, axis=1)[:, None]
        self.smaller = np.where(wall, self.radius[self.a], np.minimum(self.radius[self.a], self.radius[self.b]))

    def owner(self, points):
        apart = np.linalg.solve(self.edges, (points[:, None] - self.grains["centre"][None]).reshape(-1, 3).T)
        apart = (self.edges @ (apart - np.round(apart))).T.reshape(len(points), -1, 3)
        distance = np.linalg.norm(apart, axis=2)
        near = distance.argmin(1)
        return np.where(distance[np.arange(len(points)), near] < 1e-3 * self.radius[near], near, -1)

    def of_grains(self, at_a, at_b):
        """Sums over the contacts of each grain."""
        sums = np.zeros((len(self.radius), *np.shape(at_a)[1:]))
        np.add.at(sums, self.a, at_a)
        np.add.at(sums, self.b[self.b >= 0], np.asarray(at_b)[self.b >= 0])
        return sums


def sheared(values):
    """A periodic cell that is sheared and pressed: what contacts carry, hold and are, and how the cell has changed."""
    run = values.run("rve", "sheared", SHEARED)
    last, told = run.last, run.told
    net, first = Network(run, -1), run.frames()[0].lines()[1]
    gradient = net.edges @ np.linalg.inv(first) - np.eye(3)
    rate = np.array([[-120, 60, -90], [0, -150, 80], [0, 0, -200.0]])
    stress = -np.einsum("ci,cj->ij", net.force, net.branch) / net.volume
    stress = 0.5 * (stress + stress.T)
    fabric = np.einsum("ci,cj->ij", net.normal, net.normal) / len(net.a)
    for k, part in enumerate(PARTS):
        values.same(f"rve.columns:strain_{part}", last[f"strain_{part}"], voigt(0.5 * (gradient + gradient.T))[k], 1e-4,
                    1e-6)
        values.same(f"rve.columns:stress_{part}_Pa", last[f"stress_{part}_Pa"], voigt(stress)[k], 1e-3,
                    1e-3 * abs(voigt(stress)).min())
        values.same(f"rve.columns:fabric_{part}", last[f"fabric_{part}"], voigt(fabric)[k], 1e-3, 1e-5)
    exact = expm(rate * 3.2e-4) - np.eye(3)
    values.same("rve.columns:strain_xz", last["strain_xz"], voigt(0.5 * (exact + exact.T))[4], 0.05)
    pressure = -np.trace(stress) / 3
    values.same("rve.columns:mean_pressure_Pa", last["mean_pressure_Pa"], pressure, 1e-3)
    values.same("rve.columns:axial_stress_Pa", last["axial_stress_Pa"], -stress[2, 2], 1e-3)
    values.same("rve.columns:axial_strain", last["axial_strain"], -gradient[2, 2], 1e-4)
    count, solid = len(net.radius), 4 / 3 * np.pi * (net.radius**3).sum()
    mass = 4 / 3 * np.pi * (net.radius**3 * DENSITY[net.grains["material"].astype(int)]).sum()
    values.same("rve.columns:solid_fraction", last["solid_fraction"], solid / net.volume, 1e-5)
    values.same("rve.columns:void_ratio", last["void_ratio"], net.volume / solid - 1, 1e-5)
    values.same("rve.columns:grains", last["grains"], count)
    values.same("rve.columns:mass_kg", last["mass_kg"], mass, 1e-5)
    values.same("rve.columns:coordination", last["coordination"], 2 * len(net.a) / count)
    values.same("rve.grains:coordination", net.grains["coordination"], net.of_grains(0 * net.a + 1, 0 * net.b + 1))
    carried = net.of_grains(-net.force, net.force)
    mean_force = np.linalg.norm(net.force, axis=1).mean()
    unbalanced = np.linalg.norm(carried, axis=1).mean() / mean_force
    values.same("rve.columns:unbalanced_force", last["unbalanced_force"], unbalanced, 1e-3)
    # Between two materials a spring of their mean stiffness.
    stiffness = np.array([K, 2 * K])[net.grains["material"].astype(int)]
    normal = 0.5 * (stiffness[net.a] + stiffness[net.b])
    along = np.einsum("ci,ci->c", net.force, net.normal)
    across = np.linalg.norm(net.force - along[:, None] * net.normal, axis=1)
    overlap = net.radius[net.a] + net.radius[net.b] - np.linalg.norm(net.branch, axis=1)
    values.same("rve.contacts:overlap_m", net.cells["overlap_m"], overlap, 1e-3, 1e-3 * overlap.max())
    values.same("rve.contacts:normal_force_N", net.cells["normal_force_N"], along, 1e-3, 1e-3 * along.max())
    values.same("rve.contacts:tangential_force_N", net.cells["tangential_force_N"], across, 1e-2, 1e-3 * across.max())
    values.same("rve.contacts:normal_force_N", along, normal * overlap, 1e-2, 1e-2 * along.max())
    values.same("rve.contacts:force_N", along, net.cells["normal_force_N"], 1e-3, 1e-3 * along.max())
    held = (0.5 * along**2 / normal + 0.5 * across**2 / (0.5 * normal)).sum()
    values.same("rve.columns:elastic_J", last["elastic_J"], held, 1e-3)
    values.same("rve.summary:energy.elastic_J", told["energy"]["elastic_J"], held, 1e-3)
    # Of each grain: forces on its surface, and what its motion carries.
    arms = [net.normal * net.radius[k][:, None] for k in (net.a, net.b)]
    virial = net.of_grains(-np.einsum("ci,ci->c", net.force, arms[0]), -np.einsum("ci,ci->c", net.force, arms[1]))
    pressures = -virial / 3 / (4 / 3 * np.pi * net.radius**3)
    shown = net.grains["mean_pressure_Pa"]
    values.same("rve.grains:mean_pressure_Pa", shown, pressures, 1e-2, 2e-2 * pressures.max())
    values.same("rve.columns:inertial_number", last["inertial_number"],
                np.linalg.norm(rate) * 2 * net.radius.mean() * np.sqrt(mass / solid / pressure), 1e-3)
    errors, sample, rows = told["errors"], told["sample"], run.columns
    values.same("rve.summary:errors.unbalanced_force.last", errors["unbalanced_force"]["last"], unbalanced, 1e-3)
    values.same("rve.summary:errors.unbalanced_force.worst", errors["unbalanced_force"]["worst"],
                rows["unbalanced_force"][1:].max(), 1e-8)
    values.same("rve.summary:errors.overlap_to_radius.last", errors["overlap_to_radius"]["last"],
                (overlap / net.smaller).max(), 1e-3)
    share = net.of_grains(*2 * [0.5 * np.einsum("ci,ci->c", net.force, net.branch)])
    scatter = np.sqrt(count) * share.std(ddof=1) / share.sum()
    values.same("rve.summary:errors.pressure_standard_error.last", errors["pressure_standard_error"]["last"], scatter,
                1e-3)
    begun = abs(np.linalg.det(first))
    values.same("rve.summary:sample.solid_fraction", sample["solid_fraction"], solid / begun, 1e-5)
    values.same("rve.summary:sample.void_ratio", sample["void_ratio"], begun / solid - 1, 1e-5)
    values.same("rve.summary:sample.bulk_density_kg_m3", sample["bulk_density_kg_m3"], mass / begun, 1e-5)
    values.same("rve.summary:counts.grains", told["counts"]["grains"], count)
    values.same("rve.summary:mass.grains_kg", told["mass"]["grains_kg"], mass, 1e-5)
    values.same("rve.summary:results.final_void_ratio", told["results"]["final_void_ratio"], net.volume / solid - 1,
                1e-5)
    # Grading, by mass: 24 points between what 2 % and 60 % passes, on a line in logarithms.
    m = net.radius**3 * DENSITY[net.grains["material"].astype(int)]
    order = np.argsort(net.radius)
    d, passing = 2 * net.radius[order], np.cumsum(m[order]) / m.sum()
    low, high = (np.log(d[np.searchsorted(passing, part)]) for part in (0.02, 0.6))
    x = np.linspace(low, high, 24)
    y = np.log(passing[np.searchsorted(d, np.exp(x) * (1 + 1e-6), side="right") - 1])
    values.same("rve.columns:fractal_dimension", last["fractal_dimension"], 3 - np.polyfit(x, y, 1)[0], 1e-3)
    values.balance(run, "work_J", "kinetic_J", "friction_J")
    values.same("rve.grains:material", np.bincount(net.grains["material"].astype(int), 2650 * net.radius**3),
                (2650 * net.radius**3).sum() * np.array([3, 1]) / 4, 0.2)  # shares of the volume
    values.same("rve.summary:energy.energy_error", told["energy"]["energy_error"], last["energy_error"], 1e-6)
    values.same("rve.summary:errors.pressure_standard_error.worst", errors["pressure_standard_error"]["worst"] >=
                scatter * (1 - 1e-3), True)
    values.same("rve.summary:seed", told["seed"], 5)
    values.same("rve.summary:threads", told["threads"], 1)


def held(values):
    for check in (sheared,):
        check(values)
