# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grains as the material of your own DOLFINx program: a block of 2 x 2 x 2 hexahedra, pushed down and sideways, by
Newton at finite strain.

python3 block_dolfinx.py, or mpirun -n 2 python3 block_dolfinx.py; DOLFINx 0.5 and 0.9. The same problem as block.toml
of grus-bvp.
"""
import os
import sys

import basix
import dolfinx
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

import grus

comm, here = MPI.COMM_WORLD, os.path.dirname(os.path.abspath(__file__))
new = tuple(int(v) for v in dolfinx.__version__.split(".")[:2]) >= (0, 8)
block = mesh.create_box(comm, [[0, 0, 0], [0.02, 0.02, 0.02]], [2, 2, 2], mesh.CellType.hexahedron)
cells = np.arange(block.topology.index_map(3).size_local, dtype=np.int32)

# Displacements, and stress and tangent at the quadrature points (eight an element).
if new:
    import basix.ufl
    V = fem.functionspace(block, ("Lagrange", 1, (3,)))
    spaces = [
        fem.functionspace(block, basix.ufl.quadrature_element("hexahedron", value_shape=shape, degree=2))
        for shape in ((6,), (36,))
    ]
else:
    V = fem.VectorFunctionSpace(block, ("Lagrange", 1))
    spaces = [
        fem.FunctionSpace(block, ufl.VectorElement("Quadrature", ufl.hexahedron, 2, dim=size, quad_scheme="default"))
        for size in (6, 36)
    ]
u, S, C = fem.Function(V), fem.Function(spaces[0]), fem.Function(spaces[1])
points, _ = basix.make_quadrature(basix.CellType.hexahedron, 2)
for space in spaces:  # rows of their arrays are (cell, point) where dofs count up
    dofs = space.dofmap.list if new else space.dofmap.list.array
    assert np.array_equal(np.ravel(dofs), np.arange(dofs.size))
n = cells.size * len(points)


def voigt(a):
    """Tensor of a stress in Voigt order xx yy zz yz xz xy."""
    return ufl.as_tensor([[a[0], a[5], a[4]], [a[5], a[1], a[3]], [a[4], a[3], a[2]]])


# Internal forces and their derivative: the stress turns with the material, and changes by C where it is strained.
dx = ufl.Measure("dx", domain=block, metadata={"quadrature_degree": 2, "quadrature_scheme": "default"})
du, v = ufl.TrialFunction(V), ufl.TestFunction(V)
F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
J, sigma = ufl.det(F), voigt(S)
l = ufl.grad(du) * ufl.inv(F)
e, w = ufl.sym(l), ufl.skew(l)
strain = ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])
change = voigt([ufl.dot(ufl.as_vector([C[6 * a + b] for b in range(6)]), strain) for a in range(6)])
dsigma = change + w * sigma - sigma * w
sides = np.sort(mesh.locate_entities_boundary(block, 2, lambda p: np.isclose(p[0], 0) | np.isclose(p[0], 0.02)))
ds = ufl.Measure("ds", domain=block, subdomain_data=mesh.meshtags(block, 2, sides, np.ones(sides.size, np.int32)))
pressure = ufl.inner(-1e6 * ufl.FacetNormal(block), v) * ds(1)
residual = fem.form(ufl.inner(J * sigma * ufl.inv(F).T, ufl.grad(v)) * dx - pressure)
stiffness = fem.form(ufl.inner(J * (dsigma + ufl.tr(l) * sigma - sigma * l.T) * ufl.inv(F).T, ufl.grad(v)) * dx)
deformation = fem.Expression(ufl.Identity(3) + ufl.grad(u), points)


def held(axis, where, value):
    """Displacement along one axis of the nodes of a place."""
    space = V.sub(axis)
    dofs = fem.locate_dofs_topological(space, 2, mesh.locate_entities_boundary(block, 2, where))
    return fem.dirichletbc(value, dofs, space), dofs


push = [fem.Constant(block, PETSc.ScalarType(0)) for _ in range(3)]
zero = PETSc.ScalarType(0)
top, bottom = (lambda p: np.isclose(p[2], 0.02)), (lambda p: np.isclose(p[2], 0))
held_top = [held(axis, top, push[axis]) for axis in range(3)]
bcs = [bc for bc, _ in held_top] + [held(axis, bottom, zero)[0] for axis in range(3)]
bcs += [held(1, lambda p: np.isclose(p[1], 0) | np.isclose(p[1], 0.02), zero)[0]]

rves = grus.RveSet(os.path.join(here, "../../scenes/sand_rve.toml"), n, threads=1, comm=comm,
                   set=["material.sand.fracture="], tangent="network", unbalanced_force=1e-3, stress_change=1e-3)
F_old = np.tile(np.eye(3), (n, 1, 1))


x = u.x.petsc_vec if new else u.vector


def summed(vector):
    """What the ranks have for a node of more than one."""
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    return vector


def respond():
    """F at the points, and internal forces. Raises grus.Unstable, on all ranks, where an RVE does not get there."""
    F_new = (deformation.eval(block, cells) if new else deformation.eval(cells)).reshape(n, 3, 3)
    rves.advance(F_new @ np.linalg.inv(F_old), stress=S.x.array[:6 * n], tangent=C.x.array[:36 * n])
    return F_new, summed(petsc.assemble_vector(residual))


def newton(tolerance=2e-3):
    """Iterations until what is out of balance is this small beside all forces."""
    for iteration in range(30):
        F_new, force = respond()
        lift = petsc.create_vector(residual)  # the boundary moves with the first correction
        petsc.apply_lifting(lift, [stiffness], [bcs], [x], -1.0)
        right = force.copy()
        right.axpy(1.0, summed(lift))
        petsc.set_bc(right, bcs, x, -1.0)
        if iteration > 0 and right.norm() <= tolerance * force.norm():
            return iteration, F_new, force
        matrix = petsc.assemble_matrix(stiffness, bcs=bcs)
        matrix.assemble()
        solver = PETSc.KSP().create(comm)
        solver.setOperators(matrix)
        solver.setType("preonly")
        solver.getPC().setType("lu")
        solver.getPC().setFactorSolverType("mumps")
        step = right.copy()
        solver.solve(right, step)
        x.axpy(-1.0, step)
        u.x.scatter_forward()
    raise SystemExit("no convergence")


respond(), rves.commit()  # at rest, at the start
rows = []
for increment in range(int(os.environ.get("INCREMENTS", 2))):
    for axis, most in enumerate((2.5e-5, 0, -5e-5)):
        push[axis].value = most * (increment + 1)
    iterations, F_old, forces = newton()
    rves.commit()
    owned = V.dofmap.index_map.size_local * 3
    sums = [comm.allreduce(forces.array_r[[d for d in np.unique(dofs) if d < owned]].sum()) for _, dofs in held_top]
    rows.append(sums)
    if comm.rank == 0:
        print(
            f"{iterations} iterations, reaction of the top {sums[0]:.6g} {sums[1]:.6g} {sums[2]:.6g} N, "
            f"{rves.distinct} RVEs on rank 0",
            flush=True)
if len(sys.argv) > 1 and comm.rank == 0:
    np.savetxt(sys.argv[1], rows)
