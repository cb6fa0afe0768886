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
  if (discretisation.element == ElementKind::fbar) stretch.assign(size(), 1.0), committed_stretch = stretch;
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
  const auto dofs = cell_nodes(cell);
  const auto values = u->array();
  Matrix3 f = Matrix3::Identity();
  for (int a = 0; a < nodes; ++a) {
    const double* ua = values.data() + width() * static_cast<std::size_t>(dofs[static_cast<std::size_t>(a)]);
    f += Eigen::Vector3d(ua[0], ua[1], dim == 3 ? ua[2] : 0) * l.gradient.row(a);
    f(2, 2) += ua[0] * l.hoop[a];
  }
  return f;
}

void Problem::Impl::back_to_committed() {
  const auto from = committed_u->array();
  std::copy(from.begin(), from.end(), u->mutable_array().begin());
  F = committed_F;
  stress = committed_stress;
  tangent = committed_tangent;
  if (!stretch.empty()) mean_dilatation(F, stretch), committed_stretch = stretch;
  assemble_internal();
}

void Problem::Impl::commit() {
  const auto from = u->array();
  std::copy(from.begin(), from.end(), committed_u->mutable_array().begin());
  committed_F = F;
  committed_stress = stress;
  committed_tangent = tangent;
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

bool Problem::Impl::strain_sweep_here() {
  bool good = true;
  for (std::int32_t c = 0; c < cells; ++c)
    for (int q = 0; q < nq; ++q) {
      const Matrix3 f = deformation_at(c, local(c, q));
      Eigen::Map<RowMatrix3>(F.data() + 9 * point(c, q)) = f;
      good = good && f.determinant() > 0;
    }
  if (good && !stretch.empty()) mean_dilatation(F, stretch);
  const auto strained = [](const Matrix3& f) {
    return Matrix3(0.5 * (f + f.transpose()));
  };  // small strains: no rotation, and increments that add up
  for (std::size_t i = 0; i < size() && good; ++i) {
    const Matrix3 f = told(F, stretch, i), before = told(committed_F, committed_stretch, i);
    Eigen::Map<RowMatrix3>(deformation.data() + 9 * i) = discretisation.finite_strain
                                                             ? Matrix3(f * before.inverse())
                                                             : Matrix3(strained(f) * strained(before).inverse());
  }
  return good;
}

template <class Add>
void Problem::Impl::internal_forces(Add&& add) {
  std::vector<Present> now;
  Eigen::VectorXd mean;
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> of_cell(nodes, 3);
  for (std::int32_t c = 0; c < cells; ++c) {
    if (!stretch.empty()) mean = mean_trace(c, now);
    of_cell.setZero();
    for (int q = 0; q < nq; ++q) {
      const Local& l = local(c, q);
      const std::size_t p = point(c, q);
      const Eigen::Map<const RowMatrix3> f(F.data() + 9 * p);
      const Matrix3 sigma = symmetric(stress.data() + 6 * p);
      Matrix3 push = sigma;  // with F^-T turns reference gradients into forces
      double dv = l.dv;
      if (discretisation.finite_strain)
        push = sigma * f.inverse().transpose(),
        dv *= stretch.empty() ? f.determinant() : told(F, stretch, p).determinant();
      for (int a = 0; a < nodes; ++a) {
        Eigen::Vector3d force = dv * (push * l.gradient.row(a).transpose());
        force[0] += dv * push(2, 2) * l.hoop[a];
        of_cell.row(a) += force.transpose();
      }
      if (stretch.empty()) continue;
      const double even = sigma.diagonal().head(stretched()).mean();  // in the stretched directions (Pa)
      const Eigen::VectorXd& trace = now[static_cast<std::size_t>(q)].trace;
      for (int a = 0; a < nodes; ++a)
        for (int k = 0; k < components; ++k)
          of_cell(a, k) += dv * even * (mean[components * a + k] - trace[components * a + k]);
    }
    const auto dofs = cell_nodes(c);
    for (int a = 0; a < nodes; ++a)
      for (int k = 0; k < components; ++k) add(dofs[static_cast<std::size_t>(a)], k, of_cell(a, k));
  }
}

void Problem::Impl::assemble_internal() {
  sum_at_nodes(*internal, [&](auto&& add) { internal_forces(add); });
}

void Problem::Impl::assemble_both(double time, std::span<double> most) {
  gather(parts, [&](auto&& add) { internal_forces(add); });
  gather_external(time);
  most[0] = NodalQuanta::largest(parts), most[1] = NodalQuanta::largest(outside_parts);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX, comm);
  const std::size_t owned = width() * static_cast<std::size_t>(owned_nodes());
  quanta->add_up(parts, most[0], internal->mutable_array().subspan(0, owned));
  quanta->add_up(outside_parts, most[1], external->mutable_array().subspan(0, owned));
  add_weight();
}

void Problem::Impl::cell_tangent(std::int32_t c, Matrix& k) const {
  Matrix b(6, components * nodes), cb(6, components * nodes);
  k.setZero(components * nodes, components * nodes);
  std::vector<Present> all;
  const Eigen::VectorXd mean = mean_trace(c, all);
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
    cb.noalias() = dv * C * b;
    k.noalias() += b.transpose() * cb;
    if (!discretisation.finite_strain) continue;
    const Matrix3 sigma = symmetric(stress.data() + 6 * p);
    const Matrix gs = dv * g * sigma * g.transpose();  // initial-stress stiffness
    for (int a = 0; a < nodes; ++a)
      for (int e = 0; e < nodes; ++e) {
        for (int i = 0; i < components; ++i) k(components * a + i, components * e + i) += gs(a, e);
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
