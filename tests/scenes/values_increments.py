# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of Newton's increments and of explicit ones: residuals, corrections and cuts by the frames of other runs."""
import numpy as np

from scene_tools import need
from values_macro import BLOCK

LARGE = ("solve.increments=1", "solve.displacement_tolerance=0.9", "boundary.2.pressure=0",
         "boundary.1.displacement=[2e-3, 1e-3, -2e-3]")


def forces(frame):
    """Places of nodes, their displacements, and the forces of the stresses that a frame shows on them: V S grad N of
    the deformed tetrahedra. Each cell has nodes of its own there."""
    at, node = np.unique(np.round(frame.points, 9), axis=0, return_inverse=True)
    u = np.zeros_like(at)
    u[node] = frame.nodes["displacement_m"].reshape(-1, 3)
    cells = node[frame.connectivity.reshape(-1, 4)]
    corners = (at + u)[cells]
    edges = corners[:, 1:] - corners[:, :1]
    inverse = np.linalg.inv(edges)
    shapes = np.concatenate([-inverse.sum(2, keepdims=True), inverse], 2).transpose(0, 2, 1)
    xx, yy, zz, yz, xz, xy = frame.cells["stress_Pa"].T
    stress = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    force = np.zeros_like(at)
    np.add.at(force, cells, np.einsum("c,cij,cnj->cni", np.abs(np.linalg.det(edges)) / 6, stress, shapes))
    return at, u, force


def stopped(values, name, tolerance):
    run = values.run("bvp", name, BLOCK, *LARGE, f"solve.tolerance={tolerance}")
    return run, *forces(run.frames("macro")[-1])


def iterations(values):
    """Runs that stop after one iteration and after two: what is out of balance, and what the next one would move."""
    first, at, u, force = stopped(values, "first", 0.1)
    second, _, after, _ = stopped(values, "second", 0.02)
    values.same("bvp.columns:newton_iterations", [x.last["newton_iterations"] for x in (first, second)], [1, 2])
    for run, off in ((first, force), (second, forces(second.frames("macro")[-1])[2])):
        free = (at[:, 2] > 1e-9) & (at[:, 2] < 14e-3 - 1e-9)
        values.same("bvp.columns:residual", run.last["residual"], np.linalg.norm(off[free]) / np.linalg.norm(off), 1e-3)
    values.same("bvp.columns:correction", first.last["correction"], np.abs(after - u).max() / np.abs(u).max(), 1e-3)


def cuts(values):
    """An increment that Newton cannot take in two iterations is cut to a quarter until it can, and later ones grow by
    half: by where the rows are."""
    run = values.run("bvp", "cuts", BLOCK, *LARGE, "solve.tolerance=2e-3", "solve.max_iterations=2",
                     "solve.max_cutbacks=8", "output.frames=0")
    size, cut = np.diff(run.columns["time_s"], prepend=0), []
    planned = 1.0
    for now in size[:-1]:  # the last ends with the load
        cut.append(round(np.log(planned / now) / np.log(4)))
        planned = now * (1.5 if cut[-1] == 0 else 1)
    values.same("bvp.columns:cutbacks", run.columns["cutbacks"][:-1], cut)
    values.same("bvp.summary:counts.cutbacks", run.told["counts"]["cutbacks"], sum(cut) + run.last["cutbacks"])
    run = values.run("bvp", "rests", BLOCK, *LARGE, "solve.tolerance=0.1", "solve.increments=2", "output.frames=0",
                     "boundary.1.history=[[0, 0], [0.5, 1], [1, 1]]")
    residual = run.columns["residual"]
    need(residual[-1] < 0.9 * residual.max(), "the last residual is the worst")
    values.same("bvp.summary:errors.worst_residual", run.told["errors"]["worst_residual"], residual.max(), 1e-6)


def held(values):
    for check in (iterations, cuts):
        check(values)
