// SPDX-License-Identifier: LGPL-3.0-or-later
// The sweeps over elements that every step makes: strains, and internal forces. The points of an element lie side by
// side.
#include <algorithm>
#include <type_traits>

#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

using Matrix3 = Eigen::Matrix3d;
using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Calls f(number) with the points of an element, of which the compiler knows the number where it is a common one.
template <class F>
void with_points(int nq, F&& f) {
  if (nq == 8) return f(std::integral_constant<int, 8>());
  if (nq == 4) return f(std::integral_constant<int, 4>());
  f(nq);
}

/// F at the points of an element, (9, points).
template <class N>
void deform_cell(const Problem::Impl& p, std::int32_t c, N nq, double* __restrict f) {
  const auto dofs = p.cell_nodes(c);
  const double* const values = p.u->array().data();
  const auto first = static_cast<std::size_t>(c) * static_cast<std::size_t>(p.nodes * nq);
  const double* g = p.slopes.data() + 3 * first;
  const double* ring = p.rings.empty() ? nullptr : p.rings.data() + first;
  for (int k = 0; k < 9; ++k) std::fill_n(f + k * nq, static_cast<int>(nq), k % 4 == 0 ? 1.0 : 0.0);
  for (int a = 0; a < p.nodes; ++a, g += 3 * nq) {
    const double* const ua = values + p.components * dofs[static_cast<std::size_t>(a)];
    for (int i = 0; i < p.components; ++i)
      for (int q = 0; q < 3 * nq; ++q) f[3 * i * nq + q] += ua[i] * g[q];
    for (int q = 0; q < nq && ring; ++q) f[8 * nq + q] += ua[0] * ring[a * nq + q];
  }
}

/// An element's points, side by side: det F-weighted volumes, F^-1 and volume x stress (9, points), the mean of the
/// latter in the stretched directions, and present gradients (3 nodes, points) and hoop parts (nodes, points).
struct CellRoom {
  std::vector<double> volume, inverse, push, even, gradient, hoop, of_stress;
  CellRoom(int nodes, int nq)
      : volume(static_cast<std::size_t>(nq)),
        inverse(9 * volume.size()),
        push(inverse.size()),
        even(volume.size()),
        gradient(static_cast<std::size_t>(3 * nodes * nq)),
        hoop(static_cast<std::size_t>(nodes * nq)),
        of_stress(volume.size()) {}
};

template <class N>
void look_at_points(const Problem::Impl& p, std::int32_t c, N nq, CellRoom& r) {
  const bool finite = p.discretisation.finite_strain, fbar = !p.stretch.empty();
  for (int q = 0; q < nq; ++q) {
    const std::size_t i = p.point(c, q), at = static_cast<std::size_t>(q);
    const double dv = p.locals[i].dv;
    const Matrix3 f = Eigen::Map<const RowMatrix3>(p.F.data() + 9 * i);
    const RowMatrix3 inverse = finite ? RowMatrix3(f.inverse()) : RowMatrix3(RowMatrix3::Identity());
    r.volume[at] = finite ? dv * p.dilation[i] : dv;
    const Matrix3 push = (fbar ? dv * p.told_dilation[i] : r.volume[at]) * symmetric(p.stress.data() + 6 * i);
    for (int k = 0; k < 9; ++k) {
      r.inverse[static_cast<std::size_t>(k * nq + q)] = inverse(k / 3, k % 3);
      r.push[static_cast<std::size_t>(k * nq + q)] = push(k / 3, k % 3);
    }
    r.even[at] = push.diagonal().head(p.stretched()).mean();
  }
}

template <class N>
void turn_gradients(const Problem::Impl& p, std::int32_t c, N nq, CellRoom& r) {
  const auto first = static_cast<std::size_t>(c) * static_cast<std::size_t>(p.nodes * nq);
  const double *from = p.slopes.data() + 3 * first, *inverse = r.inverse.data();
  double* __restrict to = r.gradient.data();
  for (int a = 0; a < p.nodes; ++a, from += 3 * nq, to += 3 * nq)
    for (int k = 0; k < 3; ++k)
      for (int q = 0; q < nq; ++q)
        to[k * nq + q] = from[q] * inverse[k * nq + q] + from[nq + q] * inverse[(3 + k) * nq + q] +
                         from[2 * nq + q] * inverse[(6 + k) * nq + q];
  for (int a = 0; a < p.nodes && !p.rings.empty(); ++a)
    for (int q = 0; q < nq; ++q)
      r.hoop[static_cast<std::size_t>(a * nq + q)] = p.rings[first + static_cast<std::size_t>(a * nq + q)] /
                                                     (p.discretisation.finite_strain ? p.F[9 * p.point(c, q) + 8] : 1);
}

/// The force on one component of a node.
template <class N>
double force_on(const Problem::Impl& p, int a, int k, double volume, N nq, CellRoom& r) {
  const double *g = r.gradient.data() + 3 * a * nq, *push = r.push.data() + 3 * k * nq;
  const double* const ring = k == 0 && !p.rings.empty() ? r.hoop.data() + a * nq : nullptr;
  double* __restrict part = r.of_stress.data();
  for (int q = 0; q < nq; ++q) part[q] = push[q] * g[q] + push[nq + q] * g[nq + q] + push[2 * nq + q] * g[2 * nq + q];
  const bool fbar = !p.stretch.empty();
  const auto trace = [&](int q) { return ring ? g[k * nq + q] + ring[q] : g[k * nq + q]; };
  double mean = 0, force = 0;
  for (int q = 0; q < nq && fbar; ++q) mean += r.volume[static_cast<std::size_t>(q)] * trace(q);
  mean /= volume;
  for (int q = 0; q < nq; ++q) {
    force += part[q];
    if (ring) force += r.push[static_cast<std::size_t>(8 * nq + q)] * ring[q];
    if (fbar) force += r.even[static_cast<std::size_t>(q)] * (mean - trace(q));
  }
  return force;
}

}  // namespace

/// What `locals` hold, in another order.
void Problem::Impl::lay_out_points() {
  const bool turned = discretisation.kinematics == Kinematics::axisymmetric;
  for (std::int32_t c = 0; c < cells; ++c)
    for (int a = 0; a < nodes; ++a) {
      for (int k = 0; k < 3; ++k)
        for (int q = 0; q < nq; ++q) slopes.push_back(local(c, q).gradient(a, k));
      for (int q = 0; q < nq && turned; ++q) rings.push_back(local(c, q).hoop[a]);
    }
}

void Problem::Impl::find_dilation() {
  for (std::size_t i = 0; i < size(); ++i) dilation[i] = Eigen::Map<const RowMatrix3>(F.data() + 9 * i).determinant();
}

void Problem::Impl::find_stretch() {
  if (discretisation.element != ElementKind::fbar) return;
  mean_dilatation(dilation, stretch);
  for (std::size_t i = 0; i < size(); ++i) told_dilation[i] = told(F, stretch, i).determinant();
}

bool Problem::Impl::strain_sweep_here() {
  with_points(nq, [&](auto count) {
    std::vector<double> f(9 * static_cast<std::size_t>(nq));
    for (std::int32_t c = 0; c < cells; ++c) {
      deform_cell(*this, c, count, f.data());
      double* to = F.data() + 9 * point(c, 0);
      for (int q = 0; q < count; ++q)
        for (int k = 0; k < 9; ++k) *to++ = f[static_cast<std::size_t>(k * count + q)];
    }
  });
  find_dilation();
  if (!std::all_of(dilation.begin(), dilation.end(), [](double J) { return J > 0; })) return false;
  find_stretch();
  const auto strained = [](const Matrix3& f) {
    return Matrix3(0.5 * (f + f.transpose()));
  };  // small strains: no rotation, and increments that add up
  for (std::size_t i = 0; i < size(); ++i) {
    Matrix3 f = told(F, stretch, i), before = told(committed_F, committed_stretch, i);
    if (!discretisation.finite_strain) f = strained(f), before = strained(before);
    const Matrix3 back = before.inverse();
    Eigen::Map<RowMatrix3>(deformation.data() + 9 * i).noalias() = f.lazyProduct(back);
  }
  return true;
}

/// Of all elements, (nodes, components) each.
void Problem::Impl::internal_forces() {
  cell_forces.resize(static_cast<std::size_t>(cells) * static_cast<std::size_t>(nodes * components));
  with_points(nq, [&](auto count) {
    CellRoom room(nodes, nq);
    double* to = cell_forces.data();
    for (std::int32_t c = 0; c < cells; ++c) {
      look_at_points(*this, c, count, room);
      turn_gradients(*this, c, count, room);
      double volume = 0;
      for (const double v : room.volume) volume += v;
      for (int a = 0; a < nodes; ++a)
        for (int k = 0; k < components; ++k) *to++ = force_on(*this, a, k, volume, count, room);
    }
  });
}

void Problem::Impl::assemble_internal() {
  internal_forces();
  sum_at_nodes(*internal, [&](auto&& add) { give_internal(add); });
}

void Problem::Impl::assemble_both(double time, std::span<double> most) {
  internal_forces();
  gather_external(time);
  most[0] = NodalQuanta::largest(cell_forces), most[1] = NodalQuanta::largest(outside_parts);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX, comm);
  const std::size_t owned = width() * static_cast<std::size_t>(owned_nodes());
  quanta->add_up(most[0], internal->mutable_array().subspan(0, owned), [&](auto&& add) {
    give_internal([&](std::int32_t node, int k, double value) { add(node * components + k, value); });
  });
  quanta->add_up(outside_parts, most[1], external->mutable_array().subspan(0, owned));
  add_weight();
}

}  // namespace grus::fem
