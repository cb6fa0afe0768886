// SPDX-License-Identifier: LGPL-3.0-or-later
// A boundary-value problem of solid mechanics: mesh, boundaries, and three sweeps over the owned elements (strain,
// material, assembly). Large strain by F on the reference mesh, which never moves. DOLFINx stays inside.
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
#include "fem/mesh.hpp"

namespace grus::fem {

/// The bodies that two-dimensional elements stand for. Points always deform in three dimensions: plane strain has F_zz
/// = 1; axisymmetric has x the radius, y the axis and z the hoop, F_zz = 1 + u_x / x.
enum class Kinematics { solid, plane_strain, axisymmetric };

/// Elements as they are; with mean dilatation (quadrilaterals, hexahedra of order 1: they do not lock where the volume
/// hardly changes); with nodes on corners and edges only (8 and 20, with 2 quadrature points a direction: no locking
/// either).
enum class ElementKind { standard, fbar, serendipity };

struct Discretisation {
  int order = 1;  // of the displacement: 1 or 2
  int quadrature_degree = 2;
  bool finite_strain = true;
  Kinematics kinematics = Kinematics::solid;
  double thickness = 1;  // m, plane strain
  ElementKind element = ElementKind::standard;
  /// Sums over elements, nodes and points that are the same to the bit for any number of ranks (fem/exact_sum.hpp).
  /// What Newton's linear solver makes of them is not.
  bool exact_sums = false;
};

/// Multiplier of a boundary condition over time, linear between points, constant beyond them; empty: the time itself.
struct LoadHistory {
  std::vector<std::array<double, 2>> points;  // time, multiplier
  double at(double time) const;
};

/// Where a boundary condition holds: by place or by facet tags. Displacements are prescribed at nodes, tractions (Pa,
/// per reference area) and pressure (Pa, compression-positive, follows the surface) on outer facets, all of whose
/// corners lie there. Values are those at multiplier 1; `at` overrides a constant displacement.
struct BoundaryCondition {
  std::string name;
  std::function<bool(const Point&)> where;            // empty: `tags`
  std::array<std::optional<double>, 3> displacement;  // m; empty component: free
  std::function<Point(const Point&)> at;              // displacement by place, for components that are prescribed
  std::optional<Point> traction;
  std::optional<double> pressure;
  std::vector<int> tags;  // of the mesh file; a facet that has one of them
  LoadHistory history;
};

/// State of the macro model for output, gathered on rank 0 in the mesh's original numbering: the same for any number of
/// ranks.
struct MacroFields {
  std::vector<Point> nodes, displacement;        // of the mesh's vertices
  std::vector<std::vector<std::int64_t>> cells;  // vertices in VTK order
  std::vector<std::array<double, 6>> stress;     // mean of each element
  CellKind kind = CellKind::hexahedron;
};

/// All that decides how a problem goes on, of every element in the mesh's original numbering: displacement, F, stress
/// and tangent, and the columns that a solver keeps, which are named.
struct Snapshot {
  std::vector<std::string> at_nodes, of_cells;  // names of those columns
  std::vector<double> values;
};

class Problem {
public:
  /// Throws std::invalid_argument, one line, for what cannot be. `body_force` (N/m^3) grows with time.
  Problem(MPI_Comm comm, const BoxMesh& mesh, const Discretisation& discretisation,
          std::vector<BoundaryCondition> boundaries, std::function<Point(const Point&)> body_force = {});
  Problem(MPI_Comm comm, const MshMesh& mesh, const Discretisation& discretisation,
          std::vector<BoundaryCondition> boundaries);
  ~Problem();
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;

  /// Gauss points of the owned elements; their number over all ranks; and the first point's global key: points are
  /// numbered original element * points per element + q, whatever the ranks.
  std::size_t owned_points() const;
  std::int64_t global_points() const;
  std::int64_t point_key(std::size_t point) const;
  int points_per_cell() const;
  Point point_position(std::size_t point) const;  // in the reference mesh (m)
  int cell_tag(std::size_t point) const;          // physical group of its element; 0: none
  double point_volume(std::size_t point) const;   // m^3 of the reference configuration
  MPI_Comm comm() const;

  /// Weight of the points' material (gravity in m/s^2; kg/m^3 of the reference configuration, each owned point's): a
  /// load from the start on.
  void set_gravity(const Point& gravity, const std::vector<double>& density);

  const std::vector<BoundaryCondition>& boundaries() const;
  /// The force that holds the nodes of a boundary condition (N), summed over ranks: internal force less weight; a
  /// shared node counts in each.
  Point reaction(std::size_t boundary) const;
  /// Volume averages over the current configuration (Voigt; strain: small part of F - 1), of all points or of those in
  /// `some`.
  std::array<double, 6> mean_stress(const std::vector<std::uint8_t>& some = {}) const;
  std::array<double, 6> mean_strain(const std::vector<std::uint8_t>& some = {}) const;
  double current_volume() const;
  /// Volume (m^3) at the start and now, of all points or of those in `some`.
  std::array<double, 2> volumes(const std::vector<std::uint8_t>& some) const;
  /// Mean displacement (m) of the nodes of a boundary condition.
  Point mean_displacement(std::size_t boundary) const;

  /// L2 norms of u - exact and of its gradient's error (verification).
  std::array<double, 2> error_norms(const std::function<Point(const Point&)>& exact,
                                    const std::function<std::array<double, 9>(const Point&)>& gradient) const;
  MacroFields gather_fields() const;
  /// Values for each owned element, gathered on rank 0 by original element number.
  std::vector<double> gather_cells(const std::vector<double>& owned_values) const;
  /// Committed stress of the owned points, (n, 6).
  std::span<const double> stress() const;
  /// Committed deformation gradient of the owned points, (n, 9) row-major; of mean-dilatation elements the compatible
  /// one.
  std::span<const double> deformation() const;

  /// Gathered on rank 0; and back (given on every rank). Throws std::invalid_argument where the sizes are not this
  /// problem's.
  Snapshot snapshot() const;
  void restore(const Snapshot& snapshot);
  /// The same of the elements that this rank owns, in the order of `own_elements`: their original numbers. All ranks.
  Snapshot own_snapshot() const;
  void restore_own(const Snapshot& snapshot);
  std::vector<std::int64_t> own_elements() const;

  struct Impl;  // fem only
  Impl& impl() { return *impl_; }

private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace grus::fem
