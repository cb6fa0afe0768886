// SPDX-License-Identifier: LGPL-3.0-or-later
// What users ask of a problem: sizes, averages, reactions, fields.
#include <algorithm>

#include "fem/problem_impl.hpp"

namespace grus::fem {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Problem::Problem(MPI_Comm comm, const BoxMesh& mesh, const Discretisation& d, std::vector<BoundaryCondition> boundaries,
                 std::function<Point(const Point&)> body_force)
    : impl_(std::make_unique<Impl>(comm, mesh, d, std::move(boundaries), std::move(body_force))) {}

Problem::Problem(MPI_Comm comm, const MshMesh& mesh, const Discretisation& d, std::vector<BoundaryCondition> boundaries)
    : impl_(std::make_unique<Impl>(comm, mesh, d, std::move(boundaries))) {}

Problem::~Problem() = default;

std::size_t Problem::owned_points() const { return impl_->size(); }
std::int64_t Problem::global_points() const {
  return compat::topology(*impl_->mesh).index_map(impl_->dim)->size_global() * impl_->nq;
}
int Problem::points_per_cell() const { return impl_->nq; }
MPI_Comm Problem::comm() const { return impl_->comm; }
const std::vector<BoundaryCondition>& Problem::boundaries() const { return impl_->boundaries; }
std::span<const double> Problem::deformation() const { return impl_->committed_F; }

Point Problem::point_position(std::size_t point) const { return impl_->locals[point].at; }

double Problem::point_volume(std::size_t point) const { return impl_->locals[point].dv; }

int Problem::cell_tag(std::size_t point) const {
  if (impl_->cell_tags.empty()) return 0;
  return impl_->cell_tags[static_cast<std::size_t>(
      compat::original_cell(*impl_->mesh, static_cast<std::int32_t>(point) / impl_->nq))];
}

void Problem::set_gravity(const Point& gravity, const std::vector<double>& density) {
  Impl::Vector force(impl_->space->dofmap()->index_map, impl_->components);
  impl_->sum_at_nodes(force, [&](auto&& add) {
    for (std::int32_t c = 0; c < impl_->cells; ++c)
      for (int q = 0; q < impl_->nq; ++q) {
        const auto& l = impl_->local(c, q);
        for (int a = 0; a < impl_->nodes; ++a)
          for (int k = 0; k < impl_->components; ++k)
            add(impl_->cell_nodes(c)[static_cast<std::size_t>(a)], k,
                density[impl_->point(c, q)] * gravity[static_cast<std::size_t>(k)] * l.dv * l.value[a]);
      }
  });
  impl_->weight.assign(force.array().begin(), force.array().end());
}

std::span<const double> Problem::stress() const { return impl_->committed_stress; }

std::int64_t Problem::point_key(std::size_t point) const {
  const auto nq = static_cast<std::size_t>(impl_->nq);
  return compat::original_cell(*impl_->mesh, static_cast<std::int32_t>(point / nq)) * impl_->nq +
         static_cast<std::int64_t>(point % nq);
}

Point Problem::reaction(std::size_t boundary) const {
  const auto r = impl_->internal->array();
  return impl_->sums<3>([&](auto& sum) {
    for (auto node : impl_->boundary_nodes[boundary])
      for (std::size_t k = 0; k < impl_->width(); ++k) {
        const std::size_t i = impl_->width() * static_cast<std::size_t>(node) + k;
        sum[k] += r[i] - (impl_->weight.empty() ? 0 : impl_->weight[i]);
      }
  });
}

namespace {

/// Averages of a Voigt field over the current volume.
template <class Field>
std::array<double, 6> average(const Problem::Impl& p, const std::vector<std::uint8_t>& some, Field&& field) {
  const std::array<double, 7> total = p.sums<7>([&](auto& sum) {
    for (std::int32_t c = 0; c < p.cells; ++c)
      for (int q = 0; q < p.nq; ++q) {
        const std::size_t i = p.point(c, q);
        if (!some.empty() && !some[i]) continue;
        const auto& l = p.local(c, q);
        const Eigen::Map<const RowMatrix3> f(p.committed_F.data() + 9 * i);
        const double dv = l.dv * (p.discretisation.finite_strain ? f.determinant() : 1.0);
        const std::array<double, 6> v = field(i);
        for (std::size_t k = 0; k < 6; ++k) sum[k] += dv * v[k];
        sum[6] += dv;
      }
  });
  std::array<double, 6> mean{};
  for (std::size_t k = 0; k < 6; ++k) mean[k] = total[k] / total[6];
  return mean;
}

}  // namespace

std::array<double, 6> Problem::mean_stress(const std::vector<std::uint8_t>& some) const {
  return average(*impl_, some, [&](std::size_t i) {
    std::array<double, 6> v;
    std::copy_n(impl_->committed_stress.data() + 6 * i, 6, v.data());
    return v;
  });
}

std::array<double, 6> Problem::mean_strain(const std::vector<std::uint8_t>& some) const {
  return average(*impl_, some, [&](std::size_t i) {
    const double* f = impl_->committed_F.data() + 9 * i;
    return std::array<double, 6>{f[0] - 1, f[4] - 1, f[8] - 1, f[5] + f[7], f[2] + f[6], f[1] + f[3]};
  });
}

double Problem::current_volume() const { return volumes({})[1]; }

std::array<double, 2> Problem::volumes(const std::vector<std::uint8_t>& some) const {
  return impl_->sums<2>([&](auto& volume) {
    for (std::size_t i = 0; i < impl_->size(); ++i) {
      if (!some.empty() && !some[i]) continue;
      const double dv = impl_->locals[i].dv;
      volume[0] += dv;
      volume[1] += dv * Eigen::Map<const RowMatrix3>(impl_->committed_F.data() + 9 * i).determinant();
    }
  });
}

Point Problem::mean_displacement(std::size_t boundary) const {
  const auto u = impl_->committed_u->array();
  const auto& nodes = impl_->boundary_nodes[boundary];
  const auto sum = impl_->sums<4>([&](auto& all) {
    for (auto node : nodes)
      for (std::size_t k = 0; k < impl_->width(); ++k) all[k] += u[impl_->width() * static_cast<std::size_t>(node) + k];
    all[3] += static_cast<double>(nodes.size());
  });
  return {sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]};
}

std::array<double, 2> Problem::error_norms(const std::function<Point(const Point&)>& exact,
                                           const std::function<std::array<double, 9>(const Point&)>& gradient) const {
  double l2 = 0, h1 = 0;
  const auto u = impl_->u->array();
  for (std::int32_t c = 0; c < impl_->cells; ++c)
    for (int q = 0; q < impl_->nq; ++q) {
      const auto& l = impl_->local(c, q);
      const auto dofs = impl_->cell_nodes(c);
      Eigen::Vector3d value = Eigen::Vector3d::Zero();
      RowMatrix3 grad = RowMatrix3::Zero();
      for (int a = 0; a < impl_->nodes; ++a) {
        const double* at = u.data() + impl_->width() * static_cast<std::size_t>(dofs[static_cast<std::size_t>(a)]);
        const Eigen::Vector3d ua(at[0], at[1], impl_->dim == 3 ? at[2] : 0);
        value += l.value[a] * ua;
        grad += ua * l.gradient.row(a);
      }
      const Point e = exact(l.at);
      const std::array<double, 9> g = gradient(l.at);
      l2 += l.dv * (value - Eigen::Vector3d(e[0], e[1], e[2])).squaredNorm();
      h1 += l.dv * (grad - Eigen::Map<const RowMatrix3>(g.data())).squaredNorm();
    }
  return {std::sqrt(sum_over_ranks(impl_->comm, l2)), std::sqrt(sum_over_ranks(impl_->comm, h1))};
}

std::vector<double> Problem::gather_cells(const std::vector<double>& owned) const {
  int rank, size;
  MPI_Comm_rank(impl_->comm, &rank);
  MPI_Comm_size(impl_->comm, &size);
  const std::size_t width = impl_->cells > 0 ? owned.size() / static_cast<std::size_t>(impl_->cells) : 0;
  std::vector<double> packed;  // original element, values
  for (std::int32_t c = 0; c < impl_->cells; ++c) {
    packed.push_back(static_cast<double>(compat::original_cell(*impl_->mesh, c)));
    packed.insert(packed.end(), owned.begin() + static_cast<std::ptrdiff_t>(width * static_cast<std::size_t>(c)),
                  owned.begin() + static_cast<std::ptrdiff_t>(width * (static_cast<std::size_t>(c) + 1)));
  }
  const int mine = static_cast<int>(packed.size());
  std::vector<int> counts(static_cast<std::size_t>(size)), starts(static_cast<std::size_t>(size), 0);
  MPI_Gather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, impl_->comm);
  for (std::size_t r = 1; r < counts.size(); ++r) starts[r] = starts[r - 1] + counts[r - 1];
  std::vector<double> all(rank == 0 ? static_cast<std::size_t>(starts.back() + counts.back()) : 0);
  MPI_Gatherv(packed.data(), mine, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE, 0, impl_->comm);
  if (rank != 0) return {};
  const auto cells = static_cast<std::size_t>(compat::topology(*impl_->mesh).index_map(impl_->dim)->size_global());
  const std::size_t stride = all.size() / cells;
  std::vector<double> sorted(cells * (stride - 1));
  for (std::size_t i = 0; i < cells; ++i)
    std::copy_n(all.data() + i * stride + 1, stride - 1,
                sorted.data() + static_cast<std::size_t>(all[i * stride]) * (stride - 1));
  return sorted;
}

MacroFields Problem::gather_fields() const {
  const auto& order = reference_cell(impl_->kind).vtk;
  const int dim = impl_->dim;
  // Every element brings its own corners: coordinates, displacement, stress. Order-2 nodes are not shown.
  std::vector<double> owned;
  const auto u = impl_->committed_u->array();
  const auto x = impl_->mesh->geometry().x();
  for (std::int32_t c = 0; c < impl_->cells; ++c) {
    const auto geometry = compat::geometry_dofs(*impl_->mesh, c);
    const auto dofs = impl_->cell_nodes(c);
    for (const int v : order) {
      const auto at = static_cast<std::size_t>(v);
      for (int k = 0; k < 3; ++k) owned.push_back(x[static_cast<std::size_t>(3 * geometry[at] + k)]);
      for (int k = 0; k < 3; ++k) owned.push_back(k < dim ? u[static_cast<std::size_t>(dim * dofs[at] + k)] : 0);
    }
    for (int k = 0; k < 6; ++k) {
      double mean = 0;
      for (int q = 0; q < impl_->nq; ++q)
        mean += impl_->committed_stress[6 * impl_->point(c, q) + static_cast<std::size_t>(k)];
      owned.push_back(mean / impl_->nq);
    }
  }
  const std::vector<double> all = gather_cells(owned);
  MacroFields fields;
  fields.kind = impl_->kind;
  const std::size_t stride = 6 * order.size() + 6;
  for (std::size_t c = 0; c * stride < all.size(); ++c) {
    const double* p = all.data() + c * stride;
    fields.cells.emplace_back();
    for (std::size_t v = 0; v < order.size(); ++v, p += 6) {
      fields.cells.back().push_back(static_cast<std::int64_t>(fields.nodes.size()));
      fields.nodes.push_back({p[0], p[1], p[2]});
      fields.displacement.push_back({p[3], p[4], p[5]});
    }
    fields.stress.push_back({p[0], p[1], p[2], p[3], p[4], p[5]});
  }
  return fields;
}

namespace {

/// Owners tell ghosts: solvers keep what they have at owned nodes only, and an element tells of all of its own.
void share_nodal_state(Problem::Impl& p) {
  Problem::Impl::Vector column(p.space->dofmap()->index_map, p.components);
  for (auto& [name, nodal] : p.at_nodes) {
    std::copy(nodal.begin(), nodal.end(), column.mutable_array().begin());
    column.scatter_fwd();
    std::copy(column.array().begin(), column.array().end(), nodal.begin());
  }
}

/// Calls `each(value)` for all that an element keeps, in one order for saving and restoring.
template <class F>
void cell_state(Problem::Impl& p, std::int32_t c, F&& each) {
  const auto at_its_nodes = [&](auto&& column) {
    for (const auto node : p.cell_nodes(c))
      for (std::size_t k = 0; k < p.width(); ++k) each(column[p.width() * static_cast<std::size_t>(node) + k]);
  };
  at_its_nodes(p.committed_u->mutable_array());
  for (auto& [name, column] : p.at_nodes) at_its_nodes(column);
  for (auto& [name, column] : p.of_cells) each(column[static_cast<std::size_t>(c)]);
  for (std::size_t i = p.point(c, 0); i < p.point(c + 1, 0); ++i) {
    for (std::size_t k = 0; k < 9; ++k) each(p.committed_F[9 * i + k]);
    for (std::size_t k = 0; k < 6; ++k) each(p.committed_stress[6 * i + k]);
    for (std::size_t k = 0; k < 36; ++k) each(p.committed_tangent[36 * i + k]);
  }
}

}  // namespace

std::vector<double>& Problem::Impl::keep_at_nodes(const std::string& name) {
  return at_nodes.try_emplace(name, u->array().size(), 0.0).first->second;
}

std::vector<double>& Problem::Impl::keep_of_cells(const std::string& name) {
  return of_cells.try_emplace(name, static_cast<std::size_t>(cells), 0.0).first->second;
}

Snapshot Problem::snapshot() const {
  Snapshot all = own_snapshot();
  all.values = gather_cells(all.values);
  return all;
}

Snapshot Problem::own_snapshot() const {
  Snapshot all;
  for (const auto& [name, column] : impl_->at_nodes) all.at_nodes.push_back(name);
  for (const auto& [name, column] : impl_->of_cells) all.of_cells.push_back(name);
  impl_->committed_u->scatter_fwd();
  share_nodal_state(*impl_);
  for (std::int32_t c = 0; c < impl_->cells; ++c)
    cell_state(*impl_, c, [&](const double& v) { all.values.push_back(v); });
  return all;
}

std::vector<std::int64_t> Problem::own_elements() const {
  std::vector<std::int64_t> all;
  for (std::int32_t c = 0; c < impl_->cells; ++c) all.push_back(compat::original_cell(*impl_->mesh, c));
  return all;
}

void Problem::restore_own(const Snapshot& snapshot) {
  for (const std::string& name : snapshot.at_nodes) impl_->keep_at_nodes(name);
  for (const std::string& name : snapshot.of_cells) impl_->keep_of_cells(name);
  std::size_t count = 0;
  for (std::int32_t c = 0; c < impl_->cells; ++c) cell_state(*impl_, c, [&](const double&) { ++count; });
  if (!all_true(impl_->comm, snapshot.values.size() == count))
    throw std::invalid_argument("the snapshot is of another mesh or element");
  const double* from = snapshot.values.data();
  for (std::int32_t c = 0; c < impl_->cells; ++c) cell_state(*impl_, c, [&](double& v) { v = *from++; });
  impl_->back_to_committed();
}

void Problem::restore(const Snapshot& snapshot) {
  for (const std::string& name : snapshot.at_nodes) impl_->keep_at_nodes(name);
  for (const std::string& name : snapshot.of_cells) impl_->keep_of_cells(name);
  std::size_t width = 0;
  if (impl_->cells > 0) cell_state(*impl_, 0, [&](const double&) { ++width; });
  const auto total = static_cast<std::size_t>(compat::topology(*impl_->mesh).index_map(impl_->dim)->size_global());
  if (!all_true(impl_->comm, impl_->cells == 0 || snapshot.values.size() == total * width))
    throw std::invalid_argument("the snapshot is of another mesh or element");
  for (std::int32_t c = 0; c < impl_->cells; ++c) {
    const double* from =
        snapshot.values.data() + width * static_cast<std::size_t>(compat::original_cell(*impl_->mesh, c));
    cell_state(*impl_, c, [&](double& v) { v = *from++; });
  }
  impl_->back_to_committed();
}

}  // namespace grus::fem
