// SPDX-License-Identifier: LGPL-3.0-or-later
// Set-up of a problem and its element sweeps.
#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

using Matrix3 = Eigen::Matrix3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

}  // namespace

const ReferenceCell& reference_cell(CellKind kind) {
  static const ReferenceCell cells[4] = {
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{1, 2}, {0, 2}, {0, 1}}, {0, 1, 2}},
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1}, {0, 2}, {1, 3}, {2, 3}}, {0, 1, 3, 2}},
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}, {0, 1, 2, 3}},
      {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}},
       {{0, 1, 2, 3}, {0, 1, 4, 5}, {0, 2, 4, 6}, {1, 3, 5, 7}, {2, 3, 6, 7}, {4, 5, 6, 7}},
       {0, 1, 3, 2, 4, 5, 7, 6}}};
  return cells[static_cast<int>(kind)];
}

Problem::Impl::Impl(MPI_Comm c, const BoxMesh& box, const Discretisation& d, std::vector<BoundaryCondition> bcs,
                    std::function<Point(const Point&)> force)
    : comm(c), discretisation(d), boundaries(std::move(bcs)), body_force(std::move(force)) {
  const bool flat = d.kinematics != Kinematics::solid;
  if (flat)
    kind = box.hexahedron ? CellKind::quadrilateral : CellKind::triangle;
  else
    kind = box.hexahedron ? CellKind::hexahedron : CellKind::tetrahedron;
  mesh = compat::make_box(comm, box.size, box.cells, kind, box.owner);
  if (box.map) {
    auto x = mesh->geometry().x();
    for (std::size_t i = 0; i + 2 < x.size(); i += 3) {
      const Point p = box.map({x[i], x[i + 1], x[i + 2]});
      for (std::size_t k = 0; k < 3; ++k) x[i + k] = p[k];
    }
  }
  build();
}

Problem::Impl::Impl(MPI_Comm c, const MshMesh& msh, const Discretisation& d, std::vector<BoundaryCondition> bcs)
    : comm(c),
      kind(msh.kind),
      discretisation(d),
      boundaries(std::move(bcs)),
      facet_tags(msh.facets),
      cell_tags(msh.cell_tags) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  if ((fem::dimension(kind) == 2) != (d.kinematics != Kinematics::solid))
    throw std::invalid_argument(std::string("the mesh has ") +
                                (fem::dimension(kind) == 2 ? "two dimensions" : "three dimensions") +
                                ", which the kinematics does not allow");
  std::vector<double> x;
  std::vector<std::int64_t> cells_of;
  if (rank == 0) {
    for (const auto& p : msh.nodes) x.insert(x.end(), p.begin(), p.begin() + fem::dimension(kind));
    const auto& order = reference_cell(kind).vtk;  // its own inverse
    for (std::size_t at = 0; at < msh.cells.size(); at += order.size())
      for (const int k : order) cells_of.push_back(msh.cells[at + static_cast<std::size_t>(k)]);
  }
  mesh = compat::make_mesh(comm, x, std::move(cells_of), kind, msh.owner);
  build();
}

void Problem::Impl::build() {
  dim = fem::dimension(kind), components = dim;
  if (discretisation.order != 1 && discretisation.order != 2)
    throw std::invalid_argument("element order must be 1 or 2");
  if (discretisation.element == ElementKind::fbar && (!bricks(kind) || discretisation.order != 1))
    throw std::invalid_argument("elements with mean dilatation are quadrilaterals or hexahedra of order 1");
  if (discretisation.element == ElementKind::fbar && !discretisation.finite_strain)
    throw std::invalid_argument("elements with mean dilatation are for large strain");
  if (discretisation.element == ElementKind::serendipity && (!bricks(kind) || discretisation.order != 2))
    throw std::invalid_argument("serendipity elements are quadrilaterals or hexahedra of order 2");
  const auto element = compat::make_element(kind, discretisation.order);
  space = compat::make_space(mesh, element, components);
  cells = compat::topology(*mesh).index_map(dim)->size_local();
  const auto rule = compat::quadrature(compat::basix_cell(kind), discretisation.quadrature_degree);
  points = rule[0], weights = rule[1];
  nq = static_cast<int>(weights.size());
  basis = compat::tabulate(element, points, width());
  geometry_basis = compat::tabulate_geometry(*mesh, points, width());
  nodes = static_cast<int>(basis.size() / ((1 + width()) * weights.size()));
  if (discretisation.element == ElementKind::serendipity) {
    ties = serendipity_ties(element.points().first, width());
    tie(ties, static_cast<std::size_t>(nodes), basis);
  }
  geometry_nodes = static_cast<int>(geometry_basis.size() / ((1 + width()) * weights.size()));

  locals.resize(size());
  for (std::int32_t c = 0; c < cells; ++c)
    for (int q = 0; q < nq; ++q)
      local(c, q, {basis, geometry_basis, nq}, weights[static_cast<std::size_t>(q)], locals[point(c, q)]);

  lay_out_points();

  const auto map = space->dofmap()->index_map;
  auto vector = [&] {
    auto v = std::make_unique<Vector>(map, components);
    v->set(0.0);
    return v;
  };
  u = vector();
  committed_u = vector();
  internal = vector();
  external = vector();
  if (discretisation.exact_sums) quanta.emplace(comm, map, components);
  F.assign(9 * size(), 0.0);
  for (std::size_t i = 0; i < size(); ++i) F[9 * i] = F[9 * i + 4] = F[9 * i + 8] = 1;
  committed_F = deformation = F;
  dilation.assign(size(), 1.0);
  if (discretisation.element == ElementKind::fbar) stretch = committed_stretch = told_dilation = dilation;
  stress.assign(6 * size(), 0.0), committed_stress = stress;
  tangent.assign(36 * size(), 0.0), committed_tangent = tangent;

  const auto coordinates = space->tabulate_dof_coordinates(false);
  node_at.resize(coordinates.size() / 3);
  for (std::size_t i = 0; i < node_at.size(); ++i)
    node_at[i] = {coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]};
  if (discretisation.exact_sums) settle_node_places(element.points().first);
  if (discretisation.kinematics == Kinematics::axisymmetric)
    for (const auto& x : node_at)
      if (x[0] < -1e-12) throw std::invalid_argument("an axisymmetric mesh must lie at x >= 0: x is the radius");
  find_boundaries();
}

/// A node lies where the elements around it say, which differs by round-off: of theirs the largest coordinates,
/// whichever rank they live on. `places`: of an element's nodes, on the reference element.
void Problem::Impl::settle_node_places(std::span<const double> places) {
  const std::vector<double> table = compat::tabulate_geometry(*mesh, {places.begin(), places.end()}, width());
  Vector largest(space->dofmap()->index_map, 3);
  largest.set(-INFINITY);
  auto at = largest.mutable_array();
  const auto x = mesh->geometry().x();
  for (std::int32_t c = 0; c < cells; ++c)
    for (int a = 0; a < nodes; ++a)
      for (std::size_t k = 0; k < 3; ++k) {
        double place = 0;
        for (int b = 0; b < geometry_nodes; ++b)
          place += table[static_cast<std::size_t>(a * geometry_nodes + b)] *
                   x[3 * static_cast<std::size_t>(compat::geometry_dofs(*mesh, c)[static_cast<std::size_t>(b)]) + k];
        double& most = at[3 * static_cast<std::size_t>(cell_nodes(c)[static_cast<std::size_t>(a)]) + k];
        most = std::max(most, place);
      }
  largest.scatter_rev([](double a, double b) { return std::max(a, b); });
  largest.scatter_fwd();
  for (std::size_t n = 0; n < node_at.size(); ++n) node_at[n] = {at[3 * n], at[3 * n + 1], at[3 * n + 2]};
}

void Problem::Impl::local(std::int32_t cell, int q, const Tables& t, double share, Local& out) const {
  const auto dofs = compat::geometry_dofs(*mesh, cell);
  const auto x = mesh->geometry().x();
  Matrix3 j = Matrix3::Zero();
  if (dim == 2) j(2, 2) = 1;
  out.at = {0, 0, 0};
  for (int a = 0; a < geometry_nodes; ++a) {
    const double* p = x.data() + 3 * dofs[static_cast<std::size_t>(a)];
    for (int i = 0; i < dim; ++i) {
      out.at[static_cast<std::size_t>(i)] += p[i] * t.geometry[static_cast<std::size_t>(q * geometry_nodes + a)];
      for (int k = 0; k < dim; ++k)
        j(i, k) += p[i] * t.geometry[static_cast<std::size_t>(((k + 1) * t.count + q) * geometry_nodes + a)];
    }
  }
  const Matrix3 inverse = j.inverse();
  const bool turned = discretisation.kinematics == Kinematics::axisymmetric;
  out.jacobian = j;
  out.depth = dim == 2 ? discretisation.thickness : 1;
  if (turned) out.depth = 2 * M_PI * out.at[0];
  out.dv = share * out.depth * std::abs(j.determinant());  // elements may be left-handed
  out.gradient.resize(nodes, 3);
  out.value.resize(nodes);
  out.hoop.resize(nodes);
  for (int a = 0; a < nodes; ++a) {
    Eigen::RowVector3d d = Eigen::RowVector3d::Zero();
    for (int k = 0; k < dim; ++k) d[k] = t.basis[static_cast<std::size_t>(((k + 1) * t.count + q) * nodes + a)];
    out.gradient.row(a) = d * inverse;
    out.value[a] = t.basis[static_cast<std::size_t>(q * nodes + a)];
    out.hoop[a] = turned ? out.value[a] / std::max(out.at[0], 1e-300) : 0;
  }
}

Matrix3 Problem::Impl::deformation_at(std::int32_t cell, const Local& l) const {
  const std::int32_t* dof = cell_nodes(cell).data();
  const double *values = u->array().data(), *g = l.gradient.data(), *hoop = l.hoop.data();
  const bool turned = discretisation.kinematics == Kinematics::axisymmetric;
  const int number = nodes, each = components;
  double f[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // by rows
  for (int a = 0; a < number; ++a, g += 3) {
    const double* ua = values + each * dof[a];
    f[0] += ua[0] * g[0], f[1] += ua[0] * g[1], f[2] += ua[0] * g[2];
    f[3] += ua[1] * g[0], f[4] += ua[1] * g[1], f[5] += ua[1] * g[2];
    if (each == 3) f[6] += ua[2] * g[0], f[7] += ua[2] * g[1], f[8] += ua[2] * g[2];
    if (turned) f[8] += ua[0] * hoop[a];
  }
  return Eigen::Map<const RowMatrix3>(f);
}

void Problem::Impl::back_to_committed() {
  const auto from = committed_u->array();
  std::copy(from.begin(), from.end(), u->mutable_array().begin());
  F = committed_F;
  stress = committed_stress;
  tangent = committed_tangent;
  find_dilation(), find_stretch();
  committed_stretch = stretch;
  assemble_internal();
}

void Problem::Impl::commit(bool new_tangent) {
  const auto from = u->array();
  std::copy(from.begin(), from.end(), committed_u->mutable_array().begin());
  committed_F = F;
  committed_stress = stress;
  if (new_tangent) committed_tangent = tangent;
  committed_stretch = stretch;
}

double Problem::Impl::work_since_commit() const {
  auto first_piola = [&](const double* s, const Matrix3& f) -> Matrix3 {
    return discretisation.finite_strain ? Matrix3(f.determinant() * symmetric(s) * f.inverse().transpose())
                                        : symmetric(s);
  };
  return sums<1>([&](auto& work) {
    for (std::int32_t c = 0; c < cells; ++c)
      for (int q = 0; q < nq; ++q) {
        const Local& l = local(c, q);
        const std::size_t p = point(c, q);
        const Matrix3 before = told(committed_F, committed_stretch, p), now = told(F, stretch, p);
        const Matrix3 mean =
            0.5 * (first_piola(committed_stress.data() + 6 * p, before) + first_piola(stress.data() + 6 * p, now));
        work[0] += l.dv * mean.cwiseProduct(now - before).sum();
      }
  })[0];
}

void Problem::Impl::cell_tangent(std::int32_t c, Matrix& k) const {
  const int rows = components * nodes;
  Matrix b(6, rows), cb(6, rows), gs(nodes, 3);
  k.setZero(rows, rows);
  std::vector<Present> all;
  Eigen::VectorXd mean;
  mean_trace(c, all, mean);
  for (int q = 0; q < nq; ++q) {
    const Present& now = all[static_cast<std::size_t>(q)];
    const std::size_t p = point(c, q);
    const double dv = stretch.empty() ? now.volume : local(c, q).dv * told(F, stretch, p).determinant();
    const auto& g = now.gradient;
    const auto& h = now.hoop;
    b.setZero();
    for (int a = 0; a < nodes; ++a) {
      const double x = g(a, 0), y = g(a, 1), z = g(a, 2);
      const int at = components * a;
      b(0, at) = x, b(1, at + 1) = y, b(2, at) = h[a], b(5, at) = y, b(5, at + 1) = x;
      if (components == 3) b(2, at + 2) = z, b(3, at + 1) = z, b(3, at + 2) = y, b(4, at) = z, b(4, at + 2) = x;
    }
    if (!stretch.empty()) b.topRows(stretched()).rowwise() += ((mean - now.trace) / stretched()).transpose();
    const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> C(tangent.data() + 36 * p);
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> stiff = dv * C;
    const double *b0 = b.data(), *b1 = b0 + rows, *b2 = b1 + rows, *b3 = b2 + rows, *b4 = b3 + rows, *b5 = b4 + rows;
    for (int i = 0; i < 6; ++i) {
      const double* const s = stiff.data() + 6 * i;
      double* __restrict to = cb.data() + i * rows;
      for (int e = 0; e < rows; ++e)
        to[e] = (s[0] * b0[e] + (s[1] * b1[e] + s[2] * b2[e])) + (s[3] * b3[e] + (s[4] * b4[e] + s[5] * b5[e]));
    }
    const double *c0 = cb.data(), *c1 = c0 + rows, *c2 = c1 + rows, *c3 = c2 + rows, *c4 = c3 + rows, *c5 = c4 + rows;
    for (int i = 0; i < rows; ++i) {
      double* __restrict to = k.data() + i * rows;
      for (int e = 0; e < rows; ++e)
        to[e] = to[e] + b0[i] * c0[e] + b1[i] * c1[e] + b2[i] * c2[e] + b3[i] * c3[e] + b4[i] * c4[e] + b5[i] * c5[e];
    }
    if (!discretisation.finite_strain) continue;
    const Matrix3 sigma = symmetric(stress.data() + 6 * p);
    gs.noalias() = g.lazyProduct(dv * sigma);  // initial-stress stiffness
    for (int a = 0; a < nodes; ++a)
      for (int e = 0; e < nodes; ++e) {
        const double both = gs(a, 0) * g(e, 0) + gs(a, 1) * g(e, 1) + gs(a, 2) * g(e, 2);
        for (int i = 0; i < components; ++i) k(components * a + i, components * e + i) += both;
        k(components * a, components * e) += dv * h[a] * sigma(2, 2) * h[e];
      }
  }
  if (!stretch.empty()) add_mean_dilatation(c, all, mean, k);
}

void Problem::Impl::assemble_tangent(Mat A) const {
  check(MatZeroEntries(A), "MatZeroEntries");
  Matrix k;
  for (std::int32_t c = 0; c < cells; ++c) {
    const auto dofs = cell_nodes(c);
    cell_tangent(c, k);
    check(MatSetValuesBlockedLocal(A, nodes, dofs.data(), nodes, dofs.data(), k.data(), ADD_VALUES),
          "MatSetValuesBlockedLocal");
  }
  check(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY), "MatAssembly");
}

}  // namespace grus::fem
