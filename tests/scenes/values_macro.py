# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of elastic macro problems: made again from the nodes' displacements, and by closed forms."""
import numpy as np

from values_tools import PARTS, voigt

E, NU = 2e9, 0.3
LAME, SHEAR = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
BLOCK = f"""
[mesh]
box = {{ size = ["10 mm", "12 mm", "14 mm"], cells = [2, 2, 2], cell = "tetrahedron" }}
[element]
order = 1
[[region]]
where = "x<1"
material = "elastic"
youngs_modulus = {E}
poissons_ratio = {NU}
density = 2000
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
name = "foot"
[[boundary]]
where = "z=max"
displacement = ["5 um", "3 um", "-8 um"]
name = "head"
[[boundary]]
where = "x=max"
pressure = "0.3 MPa"
name = "side"
[[probe]]
name = "lower"
where = "z<0.007"
[[probe]]
name = "corner"
at = [0, 0, 0]
[solve]
kind = "quasi-static"
increments = 2
[output]
frames = 3
"""


class Tetrahedra:
    """Linear elements by hand: gradients, stresses, nodal forces of a frame's displacements."""

    def __init__(self, frame):
        self.x, self.u = frame.points, frame.nodes["displacement_m"].reshape(-1, 3)
        self.cells = frame.connectivity.reshape(-1, 4)
        corners = self.x[self.cells]
        edges = corners[:, 1:] - corners[:, :1]
        self.volume = np.abs(np.linalg.det(edges)) / 6
        inverse = np.linalg.inv(edges)  # columns: gradients of the shapes of corners 1 to 3
        self.shapes = np.concatenate([-inverse.sum(2, keepdims=True), inverse], 2).transpose(0, 2, 1)
        self.gradient = np.einsum("cni,cnj->cij", self.u[self.cells], self.shapes)
        self.strain = 0.5 * (self.gradient + self.gradient.transpose(0, 2, 1))
        trace = np.trace(self.strain, axis1=1, axis2=2)
        self.stress = LAME * trace[:, None, None] * np.eye(3) + 2 * SHEAR * self.strain
        self.middle = corners.mean(1)
        self.force = np.zeros_like(self.x)
        np.add.at(self.force, self.cells, np.einsum("c,cij,cnj->cni", self.volume, self.stress, self.shapes))

    def mean(self, m, of=slice(None)):
        return np.einsum("c,cij->ij", self.volume[of], m[of]) / self.volume[of].sum()


def elastic(values):
    """A block between rough plates, pressed at a side."""
    run = values.run("bvp", "elastic", BLOCK)
    last, told = run.last, run.told
    frames = run.frames("macro")
    mesh = Tetrahedra(frames[-1])
    tolerance = {"rtol": 2e-3, "atol": 1e-15}  # small strains, of single precision
    shown = frames[-1].cells["stress_Pa"]
    values.same("bvp.macro:stress_Pa", shown, voigt(mesh.stress).T, 5e-3, 2e-3 * np.abs(shown).max())
    top = np.abs(mesh.x[:, 2] - 14e-3) < 1e-9
    foot, side = np.abs(mesh.x[:, 2]) < 1e-9, np.abs(mesh.x[:, 0] - 10e-3) < 1e-9
    values.same("bvp.macro:displacement_m", mesh.u[top], [[5e-6, 3e-6, -8e-6]], 1e-5)
    for k, part in enumerate(PARTS):
        twice = 1 if k < 3 else 2  # means over the mesh are told as engineering shear
        values.same(f"bvp.columns:mean_strain_{part}", last[f"mean_strain_{part}"],
                    twice * voigt(mesh.mean(mesh.strain))[k], **tolerance)
        values.same(f"bvp.columns:mean_stress_{part}_Pa", last[f"mean_stress_{part}_Pa"],
                    voigt(mesh.mean(mesh.stress))[k], 2e-3, 300)
        low = mesh.middle[:, 2] < 7e-3
        values.same(f"bvp.columns:probe_lower_strain_{part}", last[f"probe_lower_strain_{part}"],
                    voigt(mesh.mean(mesh.strain, low))[k], **tolerance)
        values.same(f"bvp.columns:probe_lower_stress_{part}_Pa", last[f"probe_lower_stress_{part}_Pa"],
                    voigt(mesh.mean(mesh.stress, low))[k], 2e-3, 100)
        corner = np.linalg.norm(mesh.middle, axis=1).argmin()
        values.same(f"bvp.columns:probe_corner_strain_{part}", last[f"probe_corner_strain_{part}"],
                    voigt(mesh.strain[corner])[k], **tolerance)
        values.same(f"bvp.columns:probe_corner_stress_{part}_Pa", last[f"probe_corner_stress_{part}_Pa"],
                    voigt(mesh.stress[corner])[k], 2e-3, 100)
    _, first = np.unique(np.round(mesh.x[side], 9), axis=0, return_index=True)  # each cell has nodes of its own
    moved = mesh.u[side][first].mean(0)
    for k, axis in enumerate("xyz"):
        for name, nodes in (("foot", foot), ("head", top)):
            own = mesh.force[nodes, k].sum()
            values.same(f"bvp.columns:reaction_{name}_{axis}_N", last[f"reaction_{name}_{axis}_N"], own, 1e-2, 1e-2)
        values.same(f"bvp.columns:moved_side_{axis}_m", last[f"moved_side_{axis}_m"], moved[k], 1e-3)
    sigma = mesh.mean(mesh.stress)
    p = -np.trace(sigma) / 3
    values.same("bvp.columns:p_Pa", last["p_Pa"], p, **tolerance)
    values.same("bvp.columns:q_Pa", last["q_Pa"], np.sqrt(1.5) * np.linalg.norm(sigma + p * np.eye(3)), **tolerance)
    values.same("bvp.columns:strain_volumetric", last["strain_volumetric"], -np.trace(mesh.mean(mesh.strain)),
                **tolerance)
    determinant = np.linalg.det(np.eye(3) + mesh.gradient)
    values.same("bvp.columns:volume_m3", last["volume_m3"], (mesh.volume * determinant).sum(), 1e-6)
    work = 0.5 * np.einsum("c,cij,cij->", mesh.volume, mesh.stress, mesh.strain)
    for name in ("macro_work_J", "macro_internal_J", "macro_external_J"):
        values.same(f"bvp.columns:{name}", last[name], work, 5e-3)
    values.same("bvp.summary:errors.macro_work_J", told["errors"]["macro_work_J"], work, 5e-3)
    values.same("bvp.columns:increment", run.columns["increment"], [1, 2])
    values.same("bvp.columns:time_s", run.columns["time_s"], [0.5, 1])
    values.same("bvp.summary:counts.gauss_points", told["counts"]["gauss_points"], 4 * len(mesh.cells))
    for name in ("newton_iterations", "cutbacks"):
        values.same(f"bvp.summary:counts.{name}", told["counts"][name], run.columns[name].sum())
    values.same("bvp.summary:mesh.high_m", told["mesh"]["high_m"], [10e-3, 12e-3, 14e-3])


def contraction(values):
    """How fast residuals fall, by those of runs that stop after one iteration and after three."""
    large = ("solve.increments=1", "solve.displacement_tolerance=0.9", "boundary.1.displacement=[2e-3, 1e-3, -2e-3]")
    first, third = (values.run("bvp", f"contraction{t}", BLOCK, f"solve.tolerance={t}", *large) for t in (0.1, 1e-3))
    values.same("bvp.columns:newton_iterations", [first.last["newton_iterations"], third.last["newton_iterations"]],
                [1, 3])
    falls = np.sqrt(third.last["residual"] / first.last["residual"])
    values.same("bvp.summary:newton_contraction", third.told["newton_contraction"], falls, 1e-6)


TIED = """
[mesh]
box = { size = ["2 mm", "1 mm", "1 mm"], cells = [2, 1, 1] }
[element]
kind = "standard"
[[region]]
where = "x<0.001"
material = "elastic"
youngs_modulus = "1 GPa"
poissons_ratio = 0
density = 2000
[[region]]
where = "x>0.001"
material = "elastic"
youngs_modulus = "3 GPa"
poissons_ratio = 0
density = 2000
[[boundary]]
where = "x=min"
displacement = [0, 0, 0]
[[boundary]]
where = "x=max"
displacement = ["2 um", 0, 0]
[[probe]]
name = "between"
at = ["1 mm", "0.5 mm", "0.5 mm"]
[solve]
kind = "quasi-static"
increments = 1
"""


def tied(values):
    """Of points as near as each other the first is told: eight about the plane between a soft and a stiff brick."""
    run = values.run("bvp", "tied", TIED)
    values.same("bvp.columns:probe_between_strain_xx", run.last["probe_between_strain_xx"], 1.5e-3, 1e-6)


def held(values):
    for check in (elastic, contraction, tied):
        check(values)
