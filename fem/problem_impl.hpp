// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: what a Problem holds.
#pragma once

#include <Eigen/Dense>
#include <stdexcept>

#include "fem/dolfinx_compat.hpp"
#include "fem/problem.hpp"

namespace grus::fem {

static_assert(std::is_same_v<PetscScalar, double> && sizeof(PetscInt) == 4, "needs PETSc with real scalars and 32-bit indices");

inline void check(PetscErrorCode code, const char* what) {
  if (code != 0) throw std::runtime_error(std::string("PETSc: ") + what + " failed");
}

/// One prescribed component of one local node.
struct Prescribed {
  std::int32_t dof;  // local, unrolled
  double value;      // m at load factor 1
};

struct Problem::Impl {
  MPI_Comm comm;
  BoxMesh box;
  Discretisation discretisation;
  std::vector<BoundaryCondition> boundaries;
  std::function<Point(const Point&)> body_force;

  std::shared_ptr<compat::Mesh> mesh;
  std::shared_ptr<compat::Space> space;
  std::vector<double> basis, geometry_basis, points, weights;  // (4, nq, nodes) flat; quadrature
  int nq = 0, nodes = 0, geometry_nodes = 0;
  std::int32_t cells = 0;
  std::vector<Point> node_at;  // of owned and ghost nodes

  using Vector = dolfinx::la::Vector<double>;
  std::unique_ptr<Vector> u, committed_u, internal, external;
  std::vector<double> F, committed_F, deformation;      // (points, 9)
  std::vector<double> stress, tangent, committed_stress, committed_tangent;
  std::vector<Prescribed> prescribed;                    // owned and ghost, each component once
  std::vector<std::vector<std::int32_t>> boundary_nodes; // owned nodes of each displacement boundary

  Impl(MPI_Comm comm, const BoxMesh& box, const Discretisation& d, std::vector<BoundaryCondition> boundaries, std::function<Point(const Point&)> body_force);

  std::int32_t owned_nodes() const { return space->dofmap()->index_map->size_local(); }
  std::size_t size() const { return static_cast<std::size_t>(cells) * static_cast<std::size_t>(nq); }
  std::span<const std::int32_t> cell_nodes(std::int32_t cell) const { return space->dofmap()->cell_dofs(cell); }

  /// Gradients of the basis against reference coordinates, and weight times volume, at a Gauss point.
  struct Local {
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> gradient;
    Eigen::VectorXd value;
    Point at;
    double dv;
  };
  void local(std::int32_t cell, int q, Local& out) const;
  /// The same at any reference point, from tabulated tables (used for facets); returns the Jacobian.
  Eigen::Matrix3d jacobian(std::int32_t cell, const double* geometry_table, int q, int count, Point& at) const;

  /// Sweep 1: F and the increment's F at all points; false where the element turned inside out.
  bool strain_sweep();
  /// Sweep 3: internal forces; and the tangent, if asked.
  void assemble_internal();
  void assemble_tangent(Mat a) const;

private:
  void find_boundaries();
  void assemble_external();
};

/// True on all ranks only if it is true on each.
inline bool all_true(MPI_Comm comm, bool mine) {
  int in = mine ? 1 : 0, out = 0;
  MPI_Allreduce(&in, &out, 1, MPI_INT, MPI_MIN, comm);
  return out == 1;
}

inline double sum_over_ranks(MPI_Comm comm, double mine) {
  double out = 0;
  MPI_Allreduce(&mine, &out, 1, MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

}  // namespace grus::fem
