// SPDX-License-Identifier: LGPL-3.0-or-later
// Where boundary conditions hold, and external forces.
#include <dolfinx/mesh/utils.h>

#include <algorithm>
#include <utility>

#include "fem/problem_impl.hpp"

namespace grus::fem {

double LoadHistory::at(double time) const {
  if (points.empty()) return time;
  if (time <= points.front()[0]) return points.front()[1];
  for (std::size_t i = 1; i < points.size(); ++i)
    if (time <= points[i][0]) {
      const double part = (time - points[i - 1][0]) / (points[i][0] - points[i - 1][0]);
      return points[i - 1][1] + part * (points[i][1] - points[i - 1][1]);
    }
  return points.back()[1];
}

/// Marks nodes that a condition holds at, and notes its loaded facets.
void Problem::Impl::mark_boundary(std::size_t b, const std::vector<std::uint8_t>& outer, Vector& marks) {
  const auto& bc = boundaries[b];
  const auto cell_facets = compat::topology(*mesh).connectivity(dim, dim - 1);
  const ReferenceCell& ref = reference_cell(kind);
  const auto x = mesh->geometry().x();
  const auto& input = mesh->geometry().input_global_indices();
  marks.set(0.0);
  auto mark = marks.mutable_array();
  if (bc.where)
    for (std::size_t n = 0; n < node_at.size(); ++n) mark[n] = bc.where(node_at[n]) ? 1 : 0;
  const auto holds_on = [&](std::int32_t c, std::size_t side) {
    const auto corner_nodes = compat::geometry_dofs(*mesh, c);
    std::vector<std::int64_t> key;
    for (const int v : ref.facets[side]) {
      const auto node = static_cast<std::size_t>(corner_nodes[static_cast<std::size_t>(v)]);
      if (bc.where && !bc.where({x[3 * node], x[3 * node + 1], x[3 * node + 2]})) return false;
      key.push_back(input[node]);
    }
    if (bc.where) return true;
    std::sort(key.begin(), key.end());
    const auto at = facet_tags.find(key);
    return at != facet_tags.end() &&
           std::find_first_of(at->second.begin(), at->second.end(), bc.tags.begin(), bc.tags.end()) != at->second.end();
  };
  for (std::int32_t c = 0; c < cells; ++c)
    for (std::size_t side = 0; side < ref.facets.size(); ++side) {
      if (!outer[static_cast<std::size_t>(cell_facets->links(c)[side])] || !holds_on(c, side)) continue;
      if (bc.traction || bc.pressure) loaded.push_back({c, side, b});
      if (!bc.where)
        for (const int a : space->dofmap()->element_dof_layout().entity_closure_dofs(dim - 1, static_cast<int>(side)))
          mark[static_cast<std::size_t>(cell_nodes(c)[static_cast<std::size_t>(a)])] = 1;
    }
  if (bc.where) return;
  marks.scatter_rev(std::plus<double>());  // a node may touch the tag on another rank only
  marks.scatter_fwd();
}

/// Notes the nodes of the facets that a condition loads; a node may lie on such a facet of another rank only.
void Problem::Impl::find_loaded_nodes(std::size_t b, Vector& marks) {
  marks.set(0.0);
  auto mark = marks.mutable_array();
  for (const LoadedFacet& f : loaded)
    if (f.boundary == b)
      for (const int a : space->dofmap()->element_dof_layout().entity_closure_dofs(dim - 1, static_cast<int>(f.side)))
        mark[static_cast<std::size_t>(cell_nodes(f.cell)[static_cast<std::size_t>(a)])] = 1;
  marks.scatter_rev(std::plus<double>());
  for (std::int32_t n = 0; n < owned_nodes(); ++n)
    if (mark[static_cast<std::size_t>(n)] != 0) loaded_nodes[b].push_back(n);
}

void Problem::Impl::mark_applied(double time, std::vector<std::uint8_t>& marks) const {
  marks.assign(static_cast<std::size_t>(owned_nodes()), !weight.empty() || (body_force && time != 0) ? 1 : 0);
  for (const auto& c : prescribed)
    if (const auto n = static_cast<std::size_t>(c.dof) / width(); n < marks.size()) marks[n] = 1;
  for (std::size_t b = 0; b < boundaries.size(); ++b)
    if (factor(b, time) != 0)
      for (const auto n : loaded_nodes[b]) marks[static_cast<std::size_t>(n)] = 1;
}

/// Refuses a condition that holds nowhere, on any rank.
void Problem::Impl::check_boundary(std::size_t b, double found) const {
  const auto& bc = boundaries[b];
  if (sum_over_ranks(comm, found) == 0)
    throw std::invalid_argument("boundary '" + bc.name + "' holds at no node of the mesh" +
                                (bc.where ? "" : ": no outer facet has its tag"));
  const auto facets =
      std::count_if(loaded.begin(), loaded.end(), [&](const LoadedFacet& f) { return f.boundary == b; });
  if ((bc.traction || bc.pressure) && sum_over_ranks(comm, static_cast<double>(facets)) == 0)
    throw std::invalid_argument("boundary '" + bc.name +
                                "' has a traction or pressure but holds on no outer facet of the mesh");
}

void Problem::Impl::find_boundaries() {
  auto& topology = const_cast<dolfinx::mesh::Topology&>(compat::topology(*mesh));  // connectivities are made on demand
  topology.create_entities(dim - 1);
  topology.create_connectivity(dim - 1, dim);
  topology.create_connectivity(dim, dim - 1);
  std::vector<std::uint8_t> outer(
      static_cast<std::size_t>(topology.index_map(dim - 1)->size_local() + topology.index_map(dim - 1)->num_ghosts()),
      0);
  for (auto facet : dolfinx::mesh::exterior_facet_indices(topology)) outer[static_cast<std::size_t>(facet)] = 1;

  Vector marks(space->dofmap()->index_map, 1);
  boundary_nodes.resize(boundaries.size());
  loaded_nodes.resize(boundaries.size());
  std::vector<std::uint8_t> taken(width() * node_at.size(), 0), tied(node_at.size(), 0);
  for (std::int32_t c = 0; c < cells; ++c)
    for (const std::size_t a : ties.inside) tied[static_cast<std::size_t>(cell_nodes(c)[a])] = 1;
  for (std::size_t n = 0; n < tied.size(); ++n)  // they have no say, and stay where they are
    for (std::size_t k = 0; k < width() && tied[n] != 0; ++k)
      prescribed.push_back({static_cast<std::int32_t>(width() * n + k), 0, 0});
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const auto& bc = boundaries[b];
    mark_boundary(b, outer, marks);
    const auto mark = marks.mutable_array();
    double found = 0;
    for (std::size_t n = 0; n < node_at.size(); ++n) {
      if (mark[n] == 0 || tied[n] != 0) continue;
      if (static_cast<std::int32_t>(n) < owned_nodes())
        boundary_nodes[b].push_back(static_cast<std::int32_t>(n)), ++found;
      for (std::size_t k = 0; k < width(); ++k) {
        // The first condition that names a component holds.
        if (!bc.displacement[k] || taken[width() * n + k]) continue;
        taken[width() * n + k] = 1;
        prescribed.push_back(
            {static_cast<std::int32_t>(width() * n + k), bc.at ? bc.at(node_at[n])[k] : *bc.displacement[k], b});
      }
    }
    check_boundary(b, found);
    find_loaded_nodes(b, marks);
  }
  find_loaded_points();
}

/// One side of the reference element, with a quadrature rule on it.
struct Problem::Impl::Side {
  Eigen::Vector3d e1, e2;  // edges of the reference facet
  double outward;          // sign of their cross product
  std::vector<double> weight, values, geometry;
};

Problem::Impl::Side Problem::Impl::side_of_cell(std::size_t number) const {
  const ReferenceCell& ref = reference_cell(kind);
  auto facet = basix::cell::type::interval;
  if (dim == 3) facet = bricks(kind) ? basix::cell::type::quadrilateral : basix::cell::type::triangle;
  const auto rule = compat::quadrature(facet, 2 * discretisation.order + 1);
  auto corner = [&](std::size_t v) {
    return Eigen::Map<const Eigen::Vector3d>(ref.corners[static_cast<std::size_t>(ref.facets[number][v])].data());
  };
  Side side{{}, {}, 1, rule[1], {}, {}};
  const Eigen::Vector3d o = corner(0);
  side.e1 = corner(1) - o, side.e2 = dim == 3 ? Eigen::Vector3d(corner(2) - o) : Eigen::Vector3d::UnitZ();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& v : ref.corners)
    centre += Eigen::Vector3d(v[0], v[1], v[2]) / static_cast<double>(ref.corners.size());
  side.outward = side.e1.cross(side.e2).dot(o - centre) > 0 ? 1 : -1;
  std::vector<double> at;
  for (std::size_t q = 0; q < side.weight.size(); ++q) {
    const Eigen::Vector3d p = dim == 3 ? Eigen::Vector3d(o + rule[0][2 * q] * side.e1 + rule[0][2 * q + 1] * side.e2)
                                       : Eigen::Vector3d(o + rule[0][q] * side.e1);
    at.insert(at.end(), p.data(), p.data() + dim);
  }
  side.values = compat::tabulate(compat::make_element(kind, discretisation.order), at, width());
  tie(ties, static_cast<std::size_t>(nodes), side.values);
  side.geometry = compat::tabulate_geometry(*mesh, at, width());
  return side;
}

/// Tables of an element are slow to make, and a step asks for no other points.
void Problem::Impl::find_loaded_points() {
  std::stable_sort(loaded.begin(), loaded.end(), [](const auto& a, const auto& b) { return a.side < b.side; });
  std::map<std::size_t, Side> sides;
  for (const LoadedFacet& facet : loaded) {
    if (!sides.count(facet.side)) sides.emplace(facet.side, side_of_cell(facet.side));
    const Side& side = sides.at(facet.side);
    const int count = static_cast<int>(side.weight.size());
    for (int q = 0; q < count; ++q) {
      LoadedPoint& p = loaded_points.emplace_back(LoadedPoint{facet.cell, facet.boundary, {}, {}});
      local(facet.cell, q, {side.values, side.geometry, count}, 1, p.local);
      // Nodes behind the facet have round-off, which is below the quantum of exact sums (fem/nodal_quanta.hpp).
      if (discretisation.exact_sums) p.local.value = (p.local.value.array().abs() < 1e-15).select(0, p.local.value);
      const double outward = side.outward * (p.local.jacobian.determinant() > 0 ? 1 : -1);
      p.area = (outward * p.local.depth * side.weight[static_cast<std::size_t>(q)]) *
               (p.local.jacobian * side.e1).cross(p.local.jacobian * side.e2);
    }
  }
}

/// Force (N) of a condition's traction and pressure, `now` times, on an area vector of the reference facet's place.
Eigen::Vector3d Problem::Impl::facet_force(const BoundaryCondition& bc, double now, std::int32_t cell, const Local& l,
                                           const Eigen::Vector3d& area) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  if (bc.traction)
    force += now * area.norm() * Eigen::Vector3d((*bc.traction)[0], (*bc.traction)[1], (*bc.traction)[2]);
  if (!bc.pressure) return force;
  if (!discretisation.finite_strain) return force - now * *bc.pressure * area;
  const Eigen::Matrix3d F_here = deformation_at(cell, l);  // its cofactors carry the area to the present one
  return force - now * *bc.pressure * Eigen::Vector3d(F_here.determinant() * F_here.inverse().transpose() * area);
}

template <class Add>
void Problem::Impl::external_forces(double time, Add&& add_at) {
  auto add = [&](std::int32_t c, const Eigen::VectorXd& value, const Eigen::Vector3d& force) {
    const auto dofs = cell_nodes(c);
    for (int a = 0; a < nodes; ++a)
      for (int k = 0; k < components && value[a] != 0; ++k)
        add_at(dofs[static_cast<std::size_t>(a)], k, value[a] * force[k]);
  };
  if (body_force)
    for (std::int32_t c = 0; c < cells; ++c)
      for (int q = 0; q < nq; ++q) {
        const Local& here = local(c, q);
        const Point force = body_force(here.at);
        add(c, here.value, time * here.dv * Eigen::Vector3d(force[0], force[1], force[2]));
      }
  std::size_t last = boundaries.size();
  double now = 0;
  for (const LoadedPoint& p : loaded_points) {
    if (p.boundary != std::exchange(last, p.boundary)) now = factor(p.boundary, time);
    add(p.cell, p.local.value, facet_force(boundaries[p.boundary], now, p.cell, p.local, p.area));
  }
}

void Problem::Impl::assemble_external(double time) {
  sum_at_nodes(*external, [&](auto&& add) { external_forces(time, add); });
  add_weight();
}

void Problem::Impl::gather_external(double time) {
  gather(outside_parts, [&](auto&& add) { external_forces(time, add); });
}

void Problem::Impl::add_weight() {
  auto f = external->mutable_array();
  for (std::size_t i = 0; i < weight.size(); ++i) f[i] += weight[i];
}

}  // namespace grus::fem
