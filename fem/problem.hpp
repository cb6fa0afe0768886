// SPDX-License-Identifier: LGPL-3.0-or-later
// A quasi-static boundary-value problem of solid mechanics: mesh, boundaries, and three sweeps over the owned cells
// (strain, material, assembly). Large strain by F on the reference mesh, which never moves. DOLFINx stays inside.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/material.hpp"

namespace grus::fem {

using Point = std::array<double, 3>;

struct BoxMesh {
  Point size{1, 1, 1};  // m
  std::array<long, 3> cells{1, 1, 1};
  bool hexahedron = true;
  std::function<Point(const Point&)> map;  // moves nodes before anything is built (distorted meshes of tests); may be empty
};

struct Discretisation {
  int order = 1;               // of the displacement: 1 or 2
  int quadrature_degree = 2;
  bool finite_strain = true;
};

/// Where a boundary condition holds. Displacements are prescribed at nodes, tractions (Pa, per reference area) on the
/// outer facets all of whose nodes lie there. Values are those at load factor 1; `at` overrides a constant displacement.
struct BoundaryCondition {
  std::string name;
  std::function<bool(const Point&)> where;
  std::array<std::optional<double>, 3> displacement;  // m; empty component: free
  std::function<Point(const Point&)> at;              // displacement by place, for components that are prescribed
  std::optional<Point> traction;
};

/// State of the macro model for output, gathered on rank 0 in the mesh's original numbering: the same for any number of ranks.
struct MacroFields {
  std::vector<Point> nodes, displacement;               // of the mesh's vertices
  std::vector<std::vector<std::int64_t>> cells;         // vertices in VTK order
  std::vector<std::array<double, 6>> stress;            // mean of each cell
};

class Problem {
public:
  Problem(MPI_Comm comm, const BoxMesh& mesh, const Discretisation& discretisation, std::vector<BoundaryCondition> boundaries,
          std::function<Point(const Point&)> body_force = {});
  ~Problem();
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  /// Gauss points of the owned cells; their number over all ranks; and the first point's global key: points are
  /// numbered original cell * points per cell + q, whatever the ranks.
  std::size_t owned_points() const;
  std::int64_t global_points() const;
  std::int64_t point_key(std::size_t point) const;
  int points_per_cell() const;
  Point point_position(std::size_t point) const;  // in the reference mesh (m)
  MPI_Comm comm() const;

  const std::vector<BoundaryCondition>& boundaries() const;
  /// Internal force on the nodes of a boundary condition (N), summed over ranks; a shared node counts in each.
  Point reaction(std::size_t boundary) const;
  /// Volume averages over the current configuration (Voigt; strain: small part of F - 1).
  std::array<double, 6> mean_stress() const;
  std::array<double, 6> mean_strain() const;
  double current_volume() const;

  /// L2 norms of u - exact and of its gradient's error (verification).
  std::array<double, 2> error_norms(const std::function<Point(const Point&)>& exact,
                                    const std::function<std::array<double, 9>(const Point&)>& gradient) const;
  MacroFields gather_fields() const;
  /// A value for each owned cell, gathered on rank 0 by original cell number.
  std::vector<double> gather_cells(const std::vector<double>& owned_values) const;
  /// Committed stress of the owned points, (n, 6).
  std::span<const double> stress() const;
  /// Committed deformation gradient of the owned points, (n, 9) row-major.
  std::span<const double> deformation() const;

  struct Impl;  // fem only
  Impl& impl() { return *impl_; }

private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace grus::fem
