// SPDX-License-Identifier: LGPL-3.0-or-later
// Set-up of a problem and its two element sweeps.
#include "fem/problem_impl.hpp"

#include <dolfinx/mesh/utils.h>

namespace grus::fem {
namespace {

using Matrix3 = Eigen::Matrix3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Corners of the reference cell and the facets by their first three corners, in basix order.
struct Reference {
  std::vector<Eigen::Vector3d> corners;
  std::vector<std::vector<int>> facets;
};

Reference reference(bool hexahedron) {
  Reference r;
  if (hexahedron) {
    for (int v = 0; v < 8; ++v) r.corners.emplace_back(v & 1, v >> 1 & 1, v >> 2 & 1);
    r.facets = {{0, 1, 2, 3}, {0, 1, 4, 5}, {0, 2, 4, 6}, {1, 3, 5, 7}, {2, 3, 6, 7}, {4, 5, 6, 7}};
  } else {
    r.corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    r.facets = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  }
  return r;
}

}  // namespace

Problem::Impl::Impl(MPI_Comm c, const BoxMesh& b, const Discretisation& d, std::vector<BoundaryCondition> bcs, std::function<Point(const Point&)> force)
    : comm(c), box(b), discretisation(d), boundaries(std::move(bcs)), body_force(std::move(force)) {
  if (d.order != 1 && d.order != 2) throw std::invalid_argument("element order must be 1 or 2");
  mesh = compat::make_box(comm, box.size, box.cells, box.hexahedron);
  if (box.map) {
    auto x = mesh->geometry().x();
    for (std::size_t i = 0; i + 2 < x.size(); i += 3) {
      const Point p = box.map({x[i], x[i + 1], x[i + 2]});
      for (std::size_t k = 0; k < 3; ++k) x[i + k] = p[k];
    }
  }
  const auto element = compat::make_element(box.hexahedron, d.order);
  space = compat::make_space(mesh, element);
  cells = compat::topology(*mesh).index_map(3)->size_local();
  const auto cell_type = box.hexahedron ? basix::cell::type::hexahedron : basix::cell::type::tetrahedron;
  const auto rule = compat::quadrature(cell_type, d.quadrature_degree);
  points = rule[0], weights = rule[1];
  nq = static_cast<int>(weights.size());
  basis = compat::tabulate(element, points);
  geometry_basis = compat::tabulate_geometry(*mesh, points);
  nodes = static_cast<int>(basis.size() / (4 * weights.size()));
  geometry_nodes = static_cast<int>(geometry_basis.size() / (4 * weights.size()));

  const auto map = space->dofmap()->index_map;
  auto vector = [&] {
    auto v = std::make_unique<Vector>(map, 3);
    v->set(0.0);
    return v;
  };
  u = vector(), committed_u = vector(), internal = vector(), external = vector();
  F.assign(9 * size(), 0.0);
  for (std::size_t i = 0; i < size(); ++i) F[9 * i] = F[9 * i + 4] = F[9 * i + 8] = 1;
  committed_F = deformation = F;
  stress.assign(6 * size(), 0.0), committed_stress = stress;
  tangent.assign(36 * size(), 0.0), committed_tangent = tangent;

  const auto coordinates = space->tabulate_dof_coordinates(false);
  node_at.resize(coordinates.size() / 3);
  for (std::size_t i = 0; i < node_at.size(); ++i) node_at[i] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
  find_boundaries();
  assemble_external();
}

void Problem::Impl::find_boundaries() {
  boundary_nodes.resize(boundaries.size());
  std::vector<std::uint8_t> taken(3 * node_at.size(), 0);
  for (std::size_t b = 0; b < boundaries.size(); ++b) {
    const auto& bc = boundaries[b];
    for (std::size_t n = 0; n < node_at.size(); ++n) {
      if (!bc.where(node_at[n])) continue;
      if (static_cast<std::int32_t>(n) < owned_nodes()) boundary_nodes[b].push_back(static_cast<std::int32_t>(n));
      for (std::size_t k = 0; k < 3; ++k) {
        if (!bc.displacement[k] || taken[3 * n + k]) continue;  // the first condition that names a component holds
        taken[3 * n + k] = 1;
        prescribed.push_back({static_cast<std::int32_t>(3 * n + k), bc.at ? bc.at(node_at[n])[k] : *bc.displacement[k]});
      }
    }
    if (sum_over_ranks(comm, static_cast<double>(boundary_nodes[b].size())) == 0)
      throw std::invalid_argument("boundary '" + bc.name + "' holds at no node of the mesh");
  }
}

Eigen::Matrix3d Problem::Impl::jacobian(std::int32_t cell, const double* table, int q, int count, Point& at) const {
  const auto dofs = compat::geometry_dofs(*mesh, cell);
  const auto x = mesh->geometry().x();
  Matrix3 j = Matrix3::Zero();
  at = {0, 0, 0};
  for (int a = 0; a < geometry_nodes; ++a) {
    const double* p = x.data() + 3 * dofs[static_cast<std::size_t>(a)];
    for (int i = 0; i < 3; ++i) {
      at[static_cast<std::size_t>(i)] += p[i] * table[q * geometry_nodes + a];
      for (int k = 0; k < 3; ++k) j(i, k) += p[i] * table[((k + 1) * count + q) * geometry_nodes + a];
    }
  }
  return j;
}

void Problem::Impl::local(std::int32_t cell, int q, Local& out) const {
  const Matrix3 j = jacobian(cell, geometry_basis.data(), q, nq, out.at);
  const Matrix3 inverse = j.inverse();
  out.dv = weights[static_cast<std::size_t>(q)] * std::abs(j.determinant());  // tetrahedra may be left-handed
  out.gradient.resize(nodes, 3);
  out.value.resize(nodes);
  for (int a = 0; a < nodes; ++a) {
    Eigen::RowVector3d d;
    for (int k = 0; k < 3; ++k) d[k] = basis[static_cast<std::size_t>(((k + 1) * nq + q) * nodes + a)];
    out.gradient.row(a) = d * inverse;
    out.value[a] = basis[static_cast<std::size_t>(q * nodes + a)];
  }
}

bool Problem::Impl::strain_sweep() {
  const auto values = u->array();
  Local l;
  bool good = true;
  for (std::int32_t c = 0; c < cells; ++c) {
    const auto dofs = cell_nodes(c);
    for (int q = 0; q < nq; ++q) {
      local(c, q, l);
      RowMatrix3 f = RowMatrix3::Identity();
      for (int a = 0; a < nodes; ++a) {
        const double* ua = values.data() + 3 * dofs[static_cast<std::size_t>(a)];
        f += Eigen::Vector3d(ua[0], ua[1], ua[2]) * l.gradient.row(a);
      }
      const std::size_t p = static_cast<std::size_t>(c) * static_cast<std::size_t>(nq) + static_cast<std::size_t>(q);
      Eigen::Map<RowMatrix3> now(F.data() + 9 * p), increment(deformation.data() + 9 * p);
      const Eigen::Map<const RowMatrix3> before(committed_F.data() + 9 * p);
      now = f;
      good = good && f.determinant() > 0;
      if (discretisation.finite_strain) increment = f * before.inverse();
      else increment = RowMatrix3::Identity() + f - before;
    }
  }
  return all_true(comm, good);
}

void Problem::Impl::assemble_internal() {
  internal->set(0.0);
  auto r = internal->mutable_array();
  Local l;
  for (std::int32_t c = 0; c < cells; ++c) {
    const auto dofs = cell_nodes(c);
    for (int q = 0; q < nq; ++q) {
      local(c, q, l);
      const std::size_t p = static_cast<std::size_t>(c) * static_cast<std::size_t>(nq) + static_cast<std::size_t>(q);
      const double* s = stress.data() + 6 * p;
      Matrix3 sigma;
      sigma << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
      double dv = l.dv;
      Matrix3 push = sigma;  // sigma F^-T J turns reference gradients into forces
      if (discretisation.finite_strain) {
        const Eigen::Map<const RowMatrix3> f(F.data() + 9 * p);
        push = sigma * f.inverse().transpose();
        dv *= f.determinant();
      }
      for (int a = 0; a < nodes; ++a) {
        const Eigen::Vector3d force = dv * (push * l.gradient.row(a).transpose());
        for (int k = 0; k < 3; ++k) r[static_cast<std::size_t>(3 * dofs[static_cast<std::size_t>(a)] + k)] += force[k];
      }
    }
  }
  internal->scatter_rev(std::plus<double>());
}

void Problem::Impl::assemble_tangent(Mat A) const {
  check(MatZeroEntries(A), "MatZeroEntries");
  Local l;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Matrix k(3 * nodes, 3 * nodes), b(6, 3 * nodes), cb(6, 3 * nodes);
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> g(nodes, 3);
  for (std::int32_t c = 0; c < cells; ++c) {
    const auto dofs = cell_nodes(c);
    k.setZero();
    for (int q = 0; q < nq; ++q) {
      local(c, q, l);
      const std::size_t p = static_cast<std::size_t>(c) * static_cast<std::size_t>(nq) + static_cast<std::size_t>(q);
      double dv = l.dv;
      g = l.gradient;
      if (discretisation.finite_strain) {
        const Eigen::Map<const RowMatrix3> f(F.data() + 9 * p);
        g = l.gradient * f.inverse();
        dv *= f.determinant();
      }
      b.setZero();
      for (int a = 0; a < nodes; ++a) {
        const double x = g(a, 0), y = g(a, 1), z = g(a, 2);
        b(0, 3 * a) = x, b(1, 3 * a + 1) = y, b(2, 3 * a + 2) = z;
        b(3, 3 * a + 1) = z, b(3, 3 * a + 2) = y;
        b(4, 3 * a) = z, b(4, 3 * a + 2) = x;
        b(5, 3 * a) = y, b(5, 3 * a + 1) = x;
      }
      const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> C(tangent.data() + 36 * p);
      cb.noalias() = dv * C * b;
      k.noalias() += b.transpose() * cb;
      if (discretisation.finite_strain) {  // initial-stress stiffness
        const double* s = stress.data() + 6 * p;
        Matrix3 sigma;
        sigma << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
        const Matrix gs = dv * g * sigma * g.transpose();
        for (int a = 0; a < nodes; ++a)
          for (int e = 0; e < nodes; ++e)
            for (int i = 0; i < 3; ++i) k(3 * a + i, 3 * e + i) += gs(a, e);
      }
    }
    check(MatSetValuesBlockedLocal(A, nodes, dofs.data(), nodes, dofs.data(), k.data(), ADD_VALUES), "MatSetValuesBlockedLocal");
  }
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "MatAssembly");
}

void Problem::Impl::assemble_external() {
  external->set(0.0);
  auto f = external->mutable_array();
  Local l;
  if (body_force)
    for (std::int32_t c = 0; c < cells; ++c)
      for (int q = 0; q < nq; ++q) {
        local(c, q, l);
        const Point force = body_force(l.at);
        for (int a = 0; a < nodes; ++a)
          for (std::size_t k = 0; k < 3; ++k) f[3 * static_cast<std::size_t>(cell_nodes(c)[static_cast<std::size_t>(a)]) + k] += l.dv * l.value[a] * force[k];
      }
  bool tractions = false;
  for (const auto& bc : boundaries) tractions = tractions || bc.traction.has_value();
  if (tractions) {
    auto& topology = const_cast<dolfinx::mesh::Topology&>(compat::topology(*mesh));  // connectivities are made on demand
    topology.create_entities(2);
    topology.create_connectivity(2, 3);
    topology.create_connectivity(3, 2);
    const auto exterior = dolfinx::mesh::exterior_facet_indices(topology);
    std::vector<std::uint8_t> outer(static_cast<std::size_t>(topology.index_map(2)->size_local() + topology.index_map(2)->num_ghosts()), 0);
    for (auto facet : exterior) outer[static_cast<std::size_t>(facet)] = 1;
    const auto cell_facets = topology.connectivity(3, 2);
    const Reference ref = reference(box.hexahedron);
    const auto rule = compat::quadrature(box.hexahedron ? basix::cell::type::quadrilateral : basix::cell::type::triangle, 2 * discretisation.order + 1);
    const int count = static_cast<int>(rule[1].size());
    const auto element = compat::make_element(box.hexahedron, discretisation.order);
    const auto x = mesh->geometry().x();
    for (std::size_t side = 0; side < ref.facets.size(); ++side) {
      const auto& corner = ref.facets[side];
      const Eigen::Vector3d o = ref.corners[static_cast<std::size_t>(corner[0])], e1 = ref.corners[static_cast<std::size_t>(corner[1])] - o,
                            e2 = ref.corners[static_cast<std::size_t>(corner[2])] - o;
      std::vector<double> at;
      for (int q = 0; q < count; ++q) {
        const Eigen::Vector3d p = o + rule[0][static_cast<std::size_t>(2 * q)] * e1 + rule[0][static_cast<std::size_t>(2 * q + 1)] * e2;
        at.insert(at.end(), p.data(), p.data() + 3);
      }
      const auto values = compat::tabulate(element, at), geometry = compat::tabulate_geometry(*mesh, at);
      for (std::int32_t c = 0; c < cells; ++c) {
        if (!outer[static_cast<std::size_t>(cell_facets->links(c)[side])]) continue;
        const auto geometry_nodes_of = compat::geometry_dofs(*mesh, c);
        for (const auto& bc : boundaries) {
          if (!bc.traction) continue;
          bool here = true;
          for (int v : corner) {
            const double* p = x.data() + 3 * geometry_nodes_of[static_cast<std::size_t>(v)];
            here = here && bc.where({p[0], p[1], p[2]});
          }
          if (!here) continue;
          for (int q = 0; q < count; ++q) {
            Point unused;
            const Matrix3 j = jacobian(c, geometry.data(), q, count, unused);
            const double area = rule[1][static_cast<std::size_t>(q)] * (j * e1).cross(j * e2).norm();
            for (int a = 0; a < nodes; ++a)
              for (std::size_t k = 0; k < 3; ++k)
                f[3 * static_cast<std::size_t>(cell_nodes(c)[static_cast<std::size_t>(a)]) + k] +=
                    area * values[static_cast<std::size_t>(q * nodes + a)] * (*bc.traction)[k];
          }
        }
      }
    }
  }
  external->scatter_rev(std::plus<double>());
}

}  // namespace grus::fem
