// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/central_differences.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace grus::fem {

bool all_below(const Problem::Impl::Matrix& m, double limit) {
  if (!(limit > 0)) return false;
  constexpr double clear = 1e-10;   // of round-off, in this and in eigenvalues
  Problem::Impl::Matrix left = -m;  // row by row what is not yet factored
  left.diagonal().array() += (1 - clear) * limit;
  const auto n = left.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    const double pivot = left(k, k);
    if (!(pivot > clear * limit)) return false;
    const double* const from = left.data() + k * n;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      const double share = from[i] / pivot;
      double* __restrict to = left.data() + i * n;
      for (Eigen::Index j = i; j < n; ++j) to[j] -= share * from[j];
    }
  }
  return true;
}

CentralDifferences::CentralDifferences(Problem::Impl& impl, Material& m)
    : p(impl),
      material(m),
      velocity(p.keep_at_nodes("velocity")),
      last_load(p.keep_at_nodes("last load")),
      last_internal(p.keep_at_nodes("last internal")),
      now_internal(p.keep_at_nodes("now internal")) {
  need_energies(p, material);
  for (std::int32_t c = 0; c < p.cells; ++c)
    for (int q = 0; q < p.nq; ++q) volumes.push_back(p.local(c, q).dv);
  fixed.assign(p.u->array().size(), 0);
  for (const auto& c : p.prescribed) fixed[static_cast<std::size_t>(c.dof)] = 1;
  moved.assign(fixed.size(), 0);
}

void CentralDifferences::set_mass(const std::function<Eigen::VectorXd(std::int32_t)>& of) {
  Problem::Impl::Vector sum(p.space->dofmap()->index_map, 1);
  p.sum_at_nodes(sum, [&](auto&& add) {
    for (std::int32_t c = 0; c < p.cells; ++c) {
      const Eigen::VectorXd part = of(c);
      for (int a = 0; a < p.nodes; ++a) add(p.cell_nodes(c)[static_cast<std::size_t>(a)], 0, part[a]);
    }
  });
  sum.scatter_fwd();
  mass.assign(sum.array().begin(), sum.array().end());
}

/// Where an element has turned inside out, or a point has failed, all ranks go on to the one reduction that tells them:
/// there may be an average over all ranks among the answers.
bool CentralDifferences::respond_together(double dt, bool want_tangent, double next,
                                          const std::function<void()>& also) {
  enum { of_internal, of_external, of_nodes, inside_out, no_answer, first_wish, numbers = first_wish + 3 };
  const bool whole = p.strain_sweep_here();  // else the last increment stands in for this one
  const bool good = material.respond(
      {p.deformation, p.stress, want_tangent ? std::span<double>(p.tangent) : std::span<double>(), dt});
  if (good) material.commit();
  if (also) also();
  std::array<double, numbers> all{0, 0, most, whole ? 0.0 : 1.0, good ? 0.0 : 1.0};
  const int told = wishes.tell ? wishes.tell() : 0;
  for (std::size_t k = first_wish; k < numbers; ++k) all[k] = (told >> (k - first_wish)) & 1;
  p.assemble_both(next, all);
  external_ready = true;
  most = all[of_nodes];
  if (all[inside_out] != 0) {
    reason = "an element turned inside out";
    return false;
  }
  if (all[no_answer] != 0) {
    reason = material.reason();
    if (reason.empty()) reason = "a Gauss point of another rank failed";
    return false;
  }
  int heard = 0;
  for (std::size_t k = first_wish; k < numbers; ++k) heard |= all[k] != 0 ? 1 << (k - first_wish) : 0;
  if (wishes.hear) wishes.hear(heard);
  return true;
}

bool CentralDifferences::respond(double dt, bool want_tangent, double next, const std::function<void()>& also) {
  p.u->scatter_fwd();
  new_tangent = new_tangent || want_tangent;
  if (p.discretisation.exact_sums) return respond_together(dt, want_tangent, next, also);
  if (!p.strain_sweep()) {
    reason = "an element turned inside out";
    return false;
  }
  const bool mine = material.respond(
      {p.deformation, p.stress, want_tangent ? std::span<double>(p.tangent) : std::span<double>(), dt});
  if (!all_true(p.comm, mine)) {
    reason = mine ? "a Gauss point of another rank failed" : material.reason();
    return false;
  }
  material.commit();
  if (also) also();
  p.assemble_internal();
  return true;
}

/// Of external, kinetic, work of the internal forces, viscous, internal, damped energy (J).
void CentralDifferences::book(std::array<double, 6> all, MacroEnergy& total) {
  all[2] += -viscous, all[3] += viscous;
  total.external += all[0];
  total.kinetic = all[1];
  total.work += all[2];
  total.viscous += all[3];
  total.internal = all[4];
  total.damped += all[5];
  viscous = 0;
}

void CentralDifferences::step(const Stride& s, MacroEnergy& total) {
  book(p.sums<6>([&](auto& sums) { go(s, sums); }), total);
}

std::array<double, 6> CentralDifferences::step(const Stride& s, MacroEnergy& total,
                                               const std::array<ExactSum, 6>& also) {
  std::array<ExactSum, 6> own{};
  go(s, own);
  std::array<ExactSum, 12> both;
  std::copy(own.begin(), own.end(), both.begin());
  std::copy(also.begin(), also.end(), both.begin() + 6);
  const std::array<double, 12> all = over_ranks(p.comm, both);
  std::array<double, 6> first, rest;
  std::copy(all.begin(), all.begin() + 6, first.begin());
  std::copy(all.begin() + 6, all.end(), rest.begin());
  book(first, total);
  return rest;
}

template <class Sum>
void CentralDifferences::go(const Stride& s, std::array<Sum, 6>& sums) {
  const double mean_dt = s.last_dt == 0 ? 0.5 * s.dt : 0.5 * (s.last_dt + s.dt);
  const auto in = p.internal->array(), ex = p.external->array();
  const auto owned = static_cast<std::size_t>(p.owned_nodes());
  std::vector<double>&v = velocity, &load = last_load, &before = last_internal;
  auto target = [&](const Prescribed& c) {
    return (p.factor(c.boundary, s.next) - p.factor(c.boundary, s.time)) * c.value / s.dt;
  };
  // All is told of the instant of the positions: work by the forces at the ends of the last step, velocities between
  // its two.
  const double part = mean_dt > 0 ? 0.5 * s.last_dt / mean_dt : 0;
  if (s.first)
    for (const auto& c : p.prescribed)
      if (const auto i = static_cast<std::size_t>(c.dof); i < owned * p.width())
        v[i] = target(c), sums[0] += 0.5 * mass[i / p.width()] * v[i] * v[i];
  auto turn = [&](std::size_t i, double next, double force) {
    sums[0] += 0.5 * (load[i] + force) * moved[i];
    const double at_instant = v[i] + part * (next - v[i]);
    sums[1] += 0.5 * mass[i / p.width()] * at_instant * at_instant;
    sums[2] += 0.5 * (before[i] + in[i]) * moved[i];
    load[i] = force, before[i] = in[i];
    v[i] = next;
    moved[i] = s.dt * next;
    return at_instant;
  };
  for (std::size_t n = 0; n < owned; ++n) {
    const std::size_t begin = n * p.width(), end = begin + p.width();
    double drag = 0;  // N s/m: along the departure, not by components, which would not be objective
    const auto departure = [&](std::size_t i) { return s.drift > 0 ? v[i] - s.drift * (*drift)[i] : v[i]; };
    if (s.damping > 0) {
      double force2 = 0, speed2 = 0;
      for (std::size_t i = begin; i < end; ++i) {
        if (fixed[i]) continue;
        force2 += (ex[i] - in[i]) * (ex[i] - in[i]);
        speed2 += departure(i) * departure(i);
      }
      if (speed2 > 0)
        drag = std::min(s.damping * std::sqrt(force2 / speed2), mass[n] / mean_dt);  // no more than ends the departure
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (fixed[i]) continue;
      const double held = drag * departure(i);
      const double at_instant = turn(i, v[i] + mean_dt * (ex[i] - in[i] - held) / mass[n], ex[i]);
      sums[5] += held * at_instant * mean_dt;
      if (s.memory > 0) (*drift)[i] += (v[i] - (*drift)[i]) / s.memory;
    }
  }
  for (const auto& c : p.prescribed)
    if (const auto i = static_cast<std::size_t>(c.dof); i < owned * p.width()) {
      const double next = target(c);
      turn(i, next, in[i] + mass[i / p.width()] * (next - v[i]) / mean_dt);
    }
  auto u = p.u->mutable_array();
  for (std::size_t i = 0; i < owned * p.width(); ++i) u[i] += moved[i];
  add_energy(material, volumes, energies, sums[4]);
}

void CentralDifferences::keep() {
  p.commit(std::exchange(new_tangent, false));
  now_internal.assign(p.internal->array().begin(), p.internal->array().end());
}

void CentralDifferences::go_on(double last_dt) {
  std::copy(now_internal.begin(), now_internal.end(), p.internal->mutable_array().begin());
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = last_dt * velocity[i];
}

}  // namespace grus::fem
