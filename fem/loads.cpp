// SPDX-License-Identifier: LGPL-3.0-or-later
// Where boundary conditions hold, and external forces.
#include <dolfinx/mesh/utils.h>

#include <algorithm>

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

void Problem::Impl::find_boundaries() {
  auto& topology = const_cast<dolfinx::mesh::Topology&>(compat::topology(*mesh));  // connectivities are made on demand
  topology.create_entities(dim - 1);
  topology.create_connectivity(dim - 1, dim);
  topology.create_connectivity(dim, dim - 1);
  std::vector<std::uint8_t> outer(
      static_cast<std::size_t>(topology.index_map(dim - 1)->size_local() + topology.index_map(dim - 1)->num_ghosts()),
      0);
  for (auto facet : dolfinx::mesh::exterior_facet_indices(topology)) outer[static_cast<std::size_t>(facet)] = 1;
  const auto cell_facets = topology.connectivity(dim, dim - 1);
  const ReferenceCell& ref = reference_cell(kind);
  const auto x = mesh->geometry().x();
  const auto& input = mesh->geometry().input_global_indices();

  Vector marks(space->dofmap()->index_map, 1);
  boundary_nodes.resize(boundaries.size());
  std::vector<std::uint8_t> taken(width() * node_at.size(), 0), tied(node_at.size(), 0);
  for (std::int32_t c = 0; c < cells; ++c)
    for (const std::size_t a : ties.inside) tied[static_cast<std::size_t>(cell_nodes(c)[a])] = 1;
  for (std::size_t n = 0; n < tied.size(); ++n)  // they have no say, and stay where they are
    for (std::size_t k = 0; k < width() && tied[n] != 0; ++k)
      prescribed.push_back({static_cast<std::int32_t>(width() * n + k), 0, 0});
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const auto& bc = boundaries[b];
    marks.set(0.0);
    auto mark = marks.mutable_array();
    if (bc.where)
      for (std::size_t n = 0; n < node_at.size(); ++n) mark[n] = bc.where(node_at[n]) ? 1 : 0;
    for (std::int32_t c = 0; c < cells; ++c)
      for (std::size_t side = 0; side < ref.facets.size(); ++side) {
        if (!outer[static_cast<std::size_t>(cell_facets->links(c)[side])]) continue;
        const auto corner_nodes = compat::geometry_dofs(*mesh, c);
        bool here = true;
        std::vector<std::int64_t> key;
        for (const int v : ref.facets[side]) {
          const auto node = static_cast<std::size_t>(corner_nodes[static_cast<std::size_t>(v)]);
          if (bc.where)
            here = here && bc.where({x[3 * node], x[3 * node + 1], x[3 * node + 2]});
          else
            key.push_back(input[node]);
        }
        if (!bc.where) {
          std::sort(key.begin(), key.end());
          const auto at = facet_tags.find(key);
          here = at != facet_tags.end() && std::find(at->second.begin(), at->second.end(), bc.tag) != at->second.end();
        }
        if (!here) continue;
        if (bc.traction || bc.pressure) loaded.push_back({c, side, b});
        if (!bc.where)
          for (const int a : space->dofmap()->element_dof_layout().entity_closure_dofs(dim - 1, static_cast<int>(side)))
            mark[static_cast<std::size_t>(cell_nodes(c)[static_cast<std::size_t>(a)])] = 1;
      }
    if (!bc.where)
      marks.scatter_rev(std::plus<double>()), marks.scatter_fwd();  // a node may touch the tag on another rank only
    double found = 0;
    for (std::size_t n = 0; n < node_at.size(); ++n) {
      if (mark[n] == 0 || tied[n] != 0) continue;
      if (static_cast<std::int32_t>(n) < owned_nodes())
        boundary_nodes[b].push_back(static_cast<std::int32_t>(n)), ++found;
      for (std::size_t k = 0; k < width(); ++k) {
        if (!bc.displacement[k] || taken[width() * n + k])
          continue;  // the first condition that names a component holds
        taken[width() * n + k] = 1;
        prescribed.push_back(
            {static_cast<std::int32_t>(width() * n + k), bc.at ? bc.at(node_at[n])[k] : *bc.displacement[k], b});
      }
    }
    if (sum_over_ranks(comm, found) == 0)
      throw std::invalid_argument("boundary '" + bc.name + "' holds at no node of the mesh" +
                                  (bc.where ? "" : ": no facet has the tag " + std::to_string(bc.tag)));
    const auto facets =
        std::count_if(loaded.begin(), loaded.end(), [&](const LoadedFacet& f) { return f.boundary == b; });
    if ((bc.traction || bc.pressure) && sum_over_ranks(comm, static_cast<double>(facets)) == 0)
      throw std::invalid_argument("boundary '" + bc.name +
                                  "' has a traction or pressure but holds on no outer facet of the mesh");
  }
}

void Problem::Impl::assemble_external(double time) {
  external->set(0.0);
  auto f = external->mutable_array();
  Local l;
  auto add = [&](std::int32_t c, const Eigen::VectorXd& value, const Eigen::Vector3d& force) {
    const auto dofs = cell_nodes(c);
    for (int a = 0; a < nodes; ++a)
      for (int k = 0; k < components; ++k)
        f[width() * static_cast<std::size_t>(dofs[static_cast<std::size_t>(a)]) + static_cast<std::size_t>(k)] +=
            value[a] * force[k];
  };
  if (body_force)
    for (std::int32_t c = 0; c < cells; ++c)
      for (int q = 0; q < nq; ++q) {
        const Local& here = local(c, q);
        const Point force = body_force(here.at);
        add(c, here.value, time * here.dv * Eigen::Vector3d(force[0], force[1], force[2]));
      }
  if (!loaded.empty()) {
    const ReferenceCell& ref = reference_cell(kind);
    const auto rule = compat::quadrature(dim == 2                       ? basix::cell::type::interval
                                         : kind == CellKind::hexahedron ? basix::cell::type::quadrilateral
                                                                        : basix::cell::type::triangle,
                                         2 * discretisation.order + 1);
    const int count = static_cast<int>(rule[1].size());
    const auto element = compat::make_element(kind, discretisation.order);
    for (std::size_t side = 0; side < ref.facets.size(); ++side) {
      auto corner = [&](std::size_t v) {
        return Eigen::Map<const Eigen::Vector3d>(ref.corners[static_cast<std::size_t>(ref.facets[side][v])].data());
      };
      const Eigen::Vector3d o = corner(0), e1 = corner(1) - o,
                            e2 = dim == 3 ? Eigen::Vector3d(corner(2) - o) : Eigen::Vector3d::UnitZ();
      Eigen::Vector3d centre = Eigen::Vector3d::Zero();
      for (const auto& v : ref.corners)
        centre += Eigen::Vector3d(v[0], v[1], v[2]) / static_cast<double>(ref.corners.size());
      const double outward = e1.cross(e2).dot(o - centre) > 0 ? 1 : -1;
      std::vector<double> at;
      for (int q = 0; q < count; ++q) {
        Eigen::Vector3d p = dim == 3 ? Eigen::Vector3d(o + rule[0][static_cast<std::size_t>(2 * q)] * e1 +
                                                       rule[0][static_cast<std::size_t>(2 * q + 1)] * e2)
                                     : Eigen::Vector3d(o + rule[0][static_cast<std::size_t>(q)] * e1);
        at.insert(at.end(), p.data(), p.data() + dim);
      }
      auto values = compat::tabulate(element, at, width());
      tie(ties, static_cast<std::size_t>(nodes), values);
      const auto geometry = compat::tabulate_geometry(*mesh, at, width());
      for (const LoadedFacet& facet : loaded) {
        if (facet.side != side) continue;
        const BoundaryCondition& bc = boundaries[facet.boundary];
        const double now = factor(facet.boundary, time);
        for (int q = 0; q < count; ++q) {
          local(facet.cell, q, {values, geometry, count}, 1, l);
          // Area vector of the reference facet; cofactors of F carry it to the present one.
          const Eigen::Vector3d area =
              (outward * (l.jacobian.determinant() > 0 ? 1 : -1) * l.depth * rule[1][static_cast<std::size_t>(q)]) *
              (l.jacobian * e1).cross(l.jacobian * e2);
          Eigen::Vector3d force = Eigen::Vector3d::Zero();
          if (bc.traction)
            force += now * area.norm() * Eigen::Vector3d((*bc.traction)[0], (*bc.traction)[1], (*bc.traction)[2]);
          if (bc.pressure) {
            const Eigen::Matrix3d F_here = deformation_at(facet.cell, l);
            force -= now * *bc.pressure *
                     (discretisation.finite_strain
                          ? Eigen::Vector3d(F_here.determinant() * F_here.inverse().transpose() * area)
                          : area);
          }
          add(facet.cell, l.value, force);
        }
      }
    }
  }
  external->scatter_rev(std::plus<double>());
  for (std::size_t i = 0; i < weight.size(); ++i) f[i] += weight[i];
}

}  // namespace grus::fem
