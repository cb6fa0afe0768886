// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: what a Problem holds.
#pragma once

#include <Eigen/Dense>
#include <map>
#include <stdexcept>

#include "fem/dolfinx_compat.hpp"
#include "fem/exact_sum.hpp"
#include "fem/nodal_quanta.hpp"
#include "fem/problem.hpp"
#include "fem/serendipity.hpp"

namespace grus::fem {

static_assert(std::is_same_v<PetscScalar, double> && sizeof(PetscInt) == 4,
              "needs PETSc with real scalars and 32-bit indices");

inline void check(PetscErrorCode code, const char* what) {
  if (code != 0) throw std::runtime_error(std::string("PETSc: ") + what + " failed");
}

/// One prescribed component of one local node.
struct Prescribed {
  std::int32_t dof;  // local, unrolled
  double value;      // m at multiplier 1
  std::size_t boundary;
};

/// An outer facet on which a boundary condition loads.
struct LoadedFacet {
  std::int32_t cell;
  std::size_t side, boundary;
};

/// Corners of the reference element, and the facets by their corners, in basix order.
struct ReferenceCell {
  std::vector<std::array<double, 3>> corners;
  std::vector<std::vector<int>> facets;
  std::vector<int> vtk;  // corners in VTK's (and Gmsh's) order
};
const ReferenceCell& reference_cell(CellKind kind);

/// True on all ranks only if it is true on each.
inline bool all_true(MPI_Comm comm, bool mine) {
  int in = mine ? 1 : 0, out = 0;
  MPI_Allreduce(&in, &out, 1, MPI_INT, MPI_MIN, comm);
  return out == 1;
}

struct Problem::Impl {
  MPI_Comm comm;
  CellKind kind;
  int dim, components;  // of the mesh; of a node's displacement
  Discretisation discretisation;
  std::vector<BoundaryCondition> boundaries;
  std::function<Point(const Point&)> body_force;
  std::vector<double> weight;  // of the nodes, by components (N), on their owners; empty: none

  std::shared_ptr<compat::Mesh> mesh;
  std::shared_ptr<compat::Space> space;
  std::vector<double> basis, geometry_basis, points, weights;  // (4, nq, nodes) flat; quadrature
  Ties ties;                                                   // serendipity only
  int nq = 0, nodes = 0, geometry_nodes = 0;
  std::int32_t cells = 0;
  std::vector<Point> node_at;  // of owned and ghost nodes

  using Vector = dolfinx::la::Vector<double>;
  std::unique_ptr<Vector> u, committed_u, internal, external;
  std::optional<NodalQuanta> quanta;  // of forces; exact sums only
  std::vector<Contribution> parts, outside_parts;
  std::vector<double> cell_forces;                  // internal, of the elements' nodes by components (N)
  std::vector<double> F, committed_F, deformation;  // (points, 9)
  /// Mean-dilatation elements only: what F is stretched by to have its element's mean dilatation
  /// (fem/mean_dilatation.cpp).
  std::vector<double> stretch, committed_stretch;
  std::vector<double> dilation,
      told_dilation;  // det F of the points; of what the material is told, mean dilatation only
  std::vector<double> stress, tangent, committed_stress, committed_tangent;
  /// Columns that a solver keeps from step to step, by name: of owned and ghost nodes by components, and of elements.
  std::map<std::string, std::vector<double>> at_nodes, of_cells;
  std::vector<Prescribed> prescribed;                     // owned and ghost, each component once
  std::vector<std::vector<std::int32_t>> boundary_nodes;  // owned nodes of each boundary
  std::vector<LoadedFacet> loaded;                        // side by side
  std::vector<std::vector<std::int32_t>> loaded_nodes;    // owned nodes of each boundary's loaded facets
  std::map<std::vector<std::int64_t>, std::vector<int>> facet_tags;
  std::vector<int> cell_tags;  // by original element; empty: none

  Impl(MPI_Comm comm, const BoxMesh& box, const Discretisation& d, std::vector<BoundaryCondition> boundaries,
       std::function<Point(const Point&)> body_force);
  Impl(MPI_Comm comm, const MshMesh& msh, const Discretisation& d, std::vector<BoundaryCondition> boundaries);

  /// A solver's own column, zero when it is first asked for; snapshots keep it.
  std::vector<double>& keep_at_nodes(const std::string& name);
  std::vector<double>& keep_of_cells(const std::string& name);

  std::int32_t owned_nodes() const { return space->dofmap()->index_map->size_local(); }
  std::size_t size() const { return static_cast<std::size_t>(cells) * static_cast<std::size_t>(nq); }
  std::span<const std::int32_t> cell_nodes(std::int32_t cell) const { return space->dofmap()->cell_dofs(cell); }

  std::size_t width() const { return static_cast<std::size_t>(components); }
  double factor(std::size_t boundary, double time) const { return boundaries[boundary].history.at(time); }

  /// Gradients of the basis against reference coordinates, and the measure, at a point of an element. In two dimensions
  /// the third gradient component is zero; axisymmetric nodes have their hoop part N / x.
  struct Local {
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> gradient;
    Eigen::VectorXd value, hoop;
    Point at;
    Eigen::Matrix3d jacobian;
    double depth;  // thickness, or circumference; 1 in 3D
    double dv;     // weight x volume
  };
  /// Tables of basis and geometry at `count` points, and which of them.
  struct Tables {
    const std::vector<double>&basis, &geometry;
    int count;
  };
  const Local& local(std::int32_t cell, int q) const { return locals[point(cell, q)]; }
  void local(std::int32_t cell, int q, const Tables& tables, double share, Local& out) const;
  Eigen::Matrix3d deformation_at(std::int32_t cell, const Local& l) const;
  std::vector<Local> locals;  // of the quadrature points: the mesh never moves
  /// Of them gradients (element, node, direction, point) and hoop parts (element, node, point; axisymmetric only).
  std::vector<double> slopes, rings;
  /// Quadrature points of loaded facets, with their share of the area (m^2), outward.
  struct LoadedPoint {
    std::int32_t cell;
    std::size_t boundary;
    Local local;
    Eigen::Vector3d area;
  };
  std::vector<LoadedPoint> loaded_points;
  std::size_t point(std::int32_t cell, int q) const {
    return static_cast<std::size_t>(cell) * static_cast<std::size_t>(nq) + static_cast<std::size_t>(q);
  }

  /// Marks owned nodes on which something is applied at a time: those of facets that are loaded then, those with a
  /// prescribed component, and with weight all.
  void mark_applied(double time, std::vector<std::uint8_t>& marks) const;
  /// Displacement, F, stress and tangent of the committed state, and its internal forces.
  void back_to_committed();
  void commit(bool new_tangent = true);
  /// Work of the stresses from the committed state to the present one (J), by the trapezoidal rule in P : dF, over all
  /// ranks.
  double work_since_commit() const;

  /// Sweep 1: F and the increment's F at all points; false where an element turned inside out, on any rank or here.
  bool strain_sweep() { return all_true(comm, strain_sweep_here()); }
  bool strain_sweep_here();
  /// N sums over what this rank and all others add, exact where the problem is to have such (fem/exact_sum.hpp).
  template <std::size_t N, class Add>
  std::array<double, N> sums(Add&& add) const {
    return sums_over_ranks<N>(comm, discretisation.exact_sums, std::forward<Add>(add));
  }
  /// Adds up what elements `give(add)` to nodes, `add(node, component, value)`; shared nodes over ranks.
  template <class Give>
  void sum_at_nodes(Vector& into, Give&& give);

  /// Sweep 3: internal forces; external ones at a time and the present displacement; and the tangent, if asked.
  void assemble_internal();
  struct Side;
  Side side_of_cell(std::size_t number) const;
  void find_loaded_points();
  Eigen::Vector3d facet_force(const BoundaryCondition& bc, double now, std::int32_t cell, const Local& l,
                              const Eigen::Vector3d& area);
  void assemble_external(double time);
  /// Both, of a problem with exact sums, in one reduction, to which further numbers of this rank are given: of each the
  /// largest of all ranks is left. The first two are used here.
  void assemble_both(double time, std::span<double> most);
  void assemble_tangent(Mat a) const;
  /// The deformation that the material is told: F, or F with the element's mean dilatation. In plane strain only the
  /// plane is stretched.
  Eigen::Matrix3d told(const std::vector<double>& f, const std::vector<double>& by, std::size_t point) const {
    Eigen::Matrix3d all = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(f.data() + 9 * point);
    const double s = by.empty() ? 1 : by[point];
    all.row(0) *= s, all.row(1) *= s;
    if (stretched() == 3) all.row(2) *= s;
    return all;
  }
  /// Fills `by` from det F.
  void mean_dilatation(const std::vector<double>& dilation, std::vector<double>& by) const;
  /// From F: `dilation`; from that `stretch`, and what it makes of the dilation.
  void find_dilation();
  void find_stretch();
  /// Directions that a mean dilatation stretches: 2 in plane strain, or 3.
  int stretched() const { return discretisation.kinematics == Kinematics::plane_strain ? 2 : 3; }

  /// Stiffness of one element, (nodes * components)^2.
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  void cell_tangent(std::int32_t cell, Matrix& k) const;

private:
  /// Gradients against the present place, and the volume, at a point: where its stress does its work.
  struct Present {
    Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> gradient;
    Eigen::VectorXd hoop, trace;  // trace: of the velocity gradient in the stretched directions, a component each
    double volume = 0;
  };
  void present(std::int32_t cell, int q, Present& out) const;
  /// Volume-weighted mean of `trace` over an element; `all` gets its points as they are.
  void mean_trace(std::int32_t cell, std::vector<Present>& all, Eigen::VectorXd& mean) const;
  void add_mean_dilatation(std::int32_t cell, const std::vector<Present>& all, const Eigen::VectorXd& mean,
                           Matrix& k) const;
  void lay_out_points();
  /// What points do to their element's nodes: `cell_forces`; and `add(node, component, force)` for each of those.
  void internal_forces();
  template <class Add>
  void give_internal(Add&& add) const {
    const double* from = cell_forces.data();
    for (std::int32_t c = 0; c < cells; ++c)
      for (const std::int32_t node : cell_nodes(c))
        for (int k = 0; k < components; ++k) add(node, k, *from++);
  }
  template <class Add>
  void external_forces(double time, Add&& add);
  /// The same as contributions, of a problem with exact sums.
  template <class Give>
  void gather(std::vector<Contribution>& into, Give&& give) const;
  void gather_external(double time);
  void add_weight();
  void build();
  void settle_node_places(std::span<const double> places);
  void mark_boundary(std::size_t b, const std::vector<std::uint8_t>& outer, Vector& marks);
  void find_loaded_nodes(std::size_t b, Vector& marks);
  void check_boundary(std::size_t b, double found) const;
  void find_boundaries();
};

/// A stress in Voigt order as a matrix.
inline Eigen::Matrix3d symmetric(const double* s) {
  Eigen::Matrix3d m;
  m << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return m;
}

inline double sum_over_ranks(MPI_Comm comm, double mine) {
  double out = 0;
  MPI_Allreduce(&mine, &out, 1, MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

template <class Give>
void Problem::Impl::gather(std::vector<Contribution>& into, Give&& give) const {
  into.clear();
  give([&](std::int32_t node, int component, double value) { into.push_back({node * components + component, value}); });
}

template <class Give>
void Problem::Impl::sum_at_nodes(Vector& into, Give&& give) {
  const auto block = static_cast<std::size_t>(into.bs());
  const auto at = [&](std::int32_t node, int component) {
    return block * static_cast<std::size_t>(node) + static_cast<std::size_t>(component);
  };
  auto sum = into.mutable_array();
  if (!discretisation.exact_sums) {
    into.set(0.0);
    give([&](std::int32_t node, int component, double value) { sum[at(node, component)] += value; });
    return into.scatter_rev(std::plus<double>());
  }
  parts.clear();
  give([&](std::int32_t node, int component, double value) {
    parts.push_back({static_cast<std::int32_t>(at(node, component)), value});
  });
  const auto owned = sum.subspan(0, block * static_cast<std::size_t>(owned_nodes()));
  if (into.bs() == components) return quanta->add_up(parts, owned);
  NodalQuanta(comm, space->dofmap()->index_map, into.bs()).add_up(parts, owned);
}

/// Mean of each rank's value with its weight; of one rank its own, to the bit.
inline double mean_over_ranks(MPI_Comm comm, double mine, double weight) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return mine;
  const double sums[2] = {weight * mine, weight};
  double all[2];
  MPI_Allreduce(sums, all, 2, MPI_DOUBLE, MPI_SUM, comm);
  return all[1] > 0 ? all[0] / all[1] : 0;
}

}  // namespace grus::fem
