// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/cone_solver.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

using Bodies = std::vector<ConeBody>;
using Columns = std::vector<ConeRows>;

constexpr int looked_at = 10;  // iterations between looks at the residual

/// Nearest point of the cone |(g1, g2, g3)| <= friction g0.
void project(double friction, ConeRows& g) {
  const double along = std::sqrt(g[1] * g[1] + g[2] * g[2] + g[3] * g[3]);
  if (g[0] >= 0 && along <= friction * g[0]) return;
  double share = 0;
  if (friction * along <= -g[0]) {
    g[0] = 0;
  } else {
    g[0] = (g[0] + friction * along) / (1 + friction * friction);
    share = friction * g[0] / along;
  }
  for (std::size_t j = slide_row; j <= spin_row; ++j) g[j] *= share;
}

double product(const ConeRows& a, const ConeRows& b) {
  double sum = 0;
  for (std::size_t j = 0; j < cone_rows; ++j) sum += a[j] * b[j];
  return sum;
}

/// How far the springs along the plane are from what holds (N s, squared): of what slides across its way alone. Steps
/// far beyond the explicit one turn the least speed left into slip.
double off_plane(const ConeContact& c, double friction, const ConeRows& scale, const ConeRows& x, const ConeRows& w) {
  if (!(friction > 0)) return 0;
  double held2 = 0, along = 0;
  for (std::size_t j = slide_row; j <= spin_row; ++j) held2 += x[j] * x[j], along += x[j] * w[j];
  const bool slides = held2 > (1 - 1e-6) * friction * friction * x[press_row] * x[press_row];
  const double slip = slides && held2 > 0 ? std::min(0.0, along) / held2 : 0;
  double off = 0;
  for (std::size_t j = slide_row; j <= spin_row; ++j) {
    if (!(c.compliance[j] > 0)) continue;
    const double by = (w[j] - slip * x[j]) / scale[j] / c.compliance[j];
    off += by * by;
  }
  return off;
}

}  // namespace

void ConeSolver::index(std::size_t bodies, const std::vector<ConeContact>& contacts) {
  first_.assign(bodies + 1, 0);
  for (const ConeContact& c : contacts) {
    ++first_[c.a + 1];
    if (c.b != ConeContact::fixed) ++first_[c.b + 1];
  }
  for (std::size_t i = 0; i < bodies; ++i) first_[i + 1] += first_[i];
  entry_.resize(first_[bodies]);
  std::vector<Index> at(first_.begin(), first_.end() - 1);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    entry_[at[contacts[k].a]++] = static_cast<Index>(2 * k);
    if (contacts[k].b != ConeContact::fixed) entry_[at[contacts[k].b]++] = static_cast<Index>(2 * k + 1);
  }
}

void ConeSolver::scale(const Bodies& bodies, const std::vector<ConeContact>& contacts) {
  scale_.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ConeContact& c = contacts[k];
    const std::array<Vec3, 3> axis{c.normal, c.across, c.normal.cross(c.across)};
    double press = c.compliance[press_row], slide = 0, rock = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      double& along = j > 0 ? slide : press;
      if (j > 0) slide += c.compliance[j], rock += c.compliance[rock_row + j - 1];
      for (const bool of_b : {false, true}) {
        const Index i = of_b ? c.b : c.a;
        if (i == ConeContact::fixed) continue;
        const Vec3 turn = (of_b ? c.arm_b : c.arm_a).cross(axis[j]);
        along += bodies[i].inverse_mass + turn.dot(bodies[i].inverse_inertia * turn);
        if (j > 0) rock += axis[j].dot(bodies[i].inverse_inertia * axis[j]);
      }
    }
    const double of_press = 1 / std::sqrt(press), of_slide = 1 / std::sqrt(0.5 * slide);
    const double of_rock = c.rocks ? 1 / std::sqrt(0.5 * rock) : 0;
    scale_[k] = {{of_press, of_slide, of_slide, of_slide, of_rock, of_rock}, c.friction * of_press / of_slide};
  }
}

void ConeSolver::push(const Bodies& bodies, const std::vector<ConeContact>& contacts, const Columns& g, bool scaled,
                      Team& team) {
  team.blocks(contacts.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const ConeContact& c = contacts[k];
      ConeRows impulse = g[k];
      if (scaled)
        for (std::size_t j = 0; j < cone_rows; ++j) impulse[j] *= scale_[k].row[j];
      const Vec3 third = c.normal.cross(c.across);
      wrench_[k].force = impulse[0] * c.normal + impulse[1] * c.across + impulse[2] * third;
      wrench_[k].couple = c.spin_arm * impulse[3] * c.normal;
      if (c.rocks) wrench_[k].couple += impulse[4] * c.across + impulse[5] * third;
    }
  });
  team.blocks(bodies.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
      for (Index e = first_[i]; e < first_[i + 1]; ++e) {
        const std::size_t k = entry_[e] >> 1;
        const bool of_b = entry_[e] & 1;
        const Wrench& w = wrench_[k];
        const Vec3 moment = w.couple + (of_b ? contacts[k].arm_b : contacts[k].arm_a).cross(w.force);
        if (of_b)
          force += w.force, torque += moment;
        else
          force -= w.force, torque -= moment;
      }
      change_[i] = {bodies[i].inverse_mass * force, bodies[i].inverse_inertia * torque};
    }
  });
}

ConeRows ConeSolver::moved(const ConeContact& c) const {
  const Change& a = change_[c.a];
  Vec3 v = -a.velocity - a.spin.cross(c.arm_a), w = -a.spin;
  if (c.b != ConeContact::fixed) {
    const Change& b = change_[c.b];
    v += b.velocity + b.spin.cross(c.arm_b), w += b.spin;
  }
  const Vec3 third = c.normal.cross(c.across);
  return {c.normal.dot(v), c.across.dot(v), third.dot(v), c.spin_arm * c.normal.dot(w), c.across.dot(w), third.dot(w)};
}

void ConeSolver::apply(const Bodies& bodies, const std::vector<ConeContact>& contacts, const Columns& g, bool whole,
                       Columns& out, Team& team) {
  push(bodies, contacts, g, true, team);
  team.blocks(contacts.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const ConeContact& c = contacts[k];
      const ConeRows by = moved(c);
      for (std::size_t j = 0; j < cone_rows; ++j) {
        const double of = scale_[k].row[j];
        out[k][j] = of * (by[j] + c.compliance[j] * of * g[k][j] +
                          (whole ? c.free[j] + (j == press_row ? parting_[k] : 0) : 0));
      }
    }
  });
}

double ConeSolver::largest(const Bodies& bodies, const std::vector<ConeContact>& contacts, Team& team) {
  // A vector that has a part of every mode, the same for any order of the contacts' bodies.
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t j = 0; j < cone_rows; ++j)
      x_[k][j] = j < rock_row || contacts[k].rocks ? 1 + 0.1 * std::sin(static_cast<double>(7 * k + 3 * j)) : 0;
  double value = 0;
  for (int round = 0; round < 12; ++round) {
    double norm = 0;
    for (const ConeRows& x : x_) norm += product(x, x);
    norm = 1 / std::sqrt(norm);
    for (ConeRows& x : x_)
      for (double& of : x) of *= norm;
    apply(bodies, contacts, x_, false, gradient_, team);
    value = 0;
    for (const ConeRows& y : gradient_) value += product(y, y);
    value = std::sqrt(value);
    std::swap(x_, gradient_);
  }
  return value;
}

const std::vector<ConeSolver::Change>& ConeSolver::changes(const Bodies& bodies,
                                                           const std::vector<ConeContact>& contacts,
                                                           const Columns& impulse, Team& team) {
  index(bodies.size(), contacts);
  wrench_.resize(contacts.size()), change_.resize(bodies.size());
  push(bodies, contacts, impulse, false, team);
  return change_;
}

void ConeSolver::take_back_parting(const std::vector<ConeContact>& contacts, Team& team) {
  team.blocks(contacts.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      ConeRows& w = gradient_[k];  // of the scaled columns: velocities times their scales
      const double mu = contacts[k].friction;
      const double parts = mu * std::sqrt(w[1] * w[1] + w[2] * w[2] + w[3] * w[3]) / scale_[k].row[slide_row];
      // A press that gives way by what it is raised slides faster by at most mu of that: no step overshoots.
      const double more = (parts - parting_[k]) / (1 + mu * mu);
      parting_[k] += more, w[press_row] += scale_[k].row[press_row] * more;
    }
  });
}

ConeEnd ConeSolver::descend(const Bodies& bodies, const std::vector<ConeContact>& contacts, double length,
                            const ConeSettings& settings, Team& team) {
  const std::size_t n = contacts.size();
  const auto sums = [&](auto&& of) {  // by fixed blocks: the same bits for any number of threads
    team.blocks(n, [&](std::size_t begin, std::size_t stop) {
      for (std::size_t b = begin; b < stop; b += block_size) {
        std::array<double, 3> sum{};
        for (std::size_t k = b; k < std::min(stop, b + block_size); ++k) of(k, sum);
        block_[b / block_size] = sum;
      }
    });
    std::array<double, 3> sum{};
    for (const auto& b : block_) sum[0] += b[0], sum[1] += b[1], sum[2] += b[2];
    return sum;
  };
  y_ = x_;
  ConeEnd end;
  double theta = 1;
  while (end.iterations < settings.iterations) {
    apply(bodies, contacts, y_, true, gradient_, team);
    const double back = sums([&](std::size_t k, std::array<double, 3>& sum) {
      for (std::size_t j = 0; j < cone_rows; ++j) next_[k][j] = y_[k][j] - length * gradient_[k][j];
      project(scale_[k].friction, next_[k]);
      for (std::size_t j = 0; j < cone_rows; ++j) sum[0] += gradient_[k][j] * (next_[k][j] - x_[k][j]);
    })[0];
    double wider = 0.5 * (1 + std::sqrt(1 + 4 * theta * theta)), beyond = (theta - 1) / wider;
    if (back > 0) wider = 1, beyond = 0;  // it has gone past the minimum: begin anew
    theta = wider;
    team.blocks(n, [&](std::size_t begin, std::size_t stop) {
      for (std::size_t k = begin; k < stop; ++k)
        for (std::size_t j = 0; j < cone_rows; ++j) y_[k][j] = next_[k][j] + beyond * (next_[k][j] - x_[k][j]);
    });
    std::swap(x_, next_);
    ++end.iterations;
    if (end.iterations % looked_at != 0 && end.iterations < settings.iterations) continue;
    apply(bodies, contacts, x_, true, gradient_, team);
    if (!settings.parts) take_back_parting(contacts, team);
    const auto [off, all, gap] = sums([&](std::size_t k, std::array<double, 3>& sum) {
      const ConeRows& x = x_[k];
      ConeRows p = x;
      for (std::size_t j = 0; j < cone_rows; ++j) p[j] -= gradient_[k][j];  // its scaled diagonal is 1
      project(scale_[k].friction, p);
      for (std::size_t j = 0; j < rock_row; ++j) {
        const double impulse2 = scale_[k].row[j] * scale_[k].row[j];
        sum[0] += impulse2 * (p[j] - x[j]) * (p[j] - x[j]), sum[1] += impulse2 * x[j] * x[j];
      }
      if (!(p[press_row] > 0) || !(contacts[k].compliance[press_row] > 0)) return;
      const double w = gradient_[k][press_row] / scale_[k].row[press_row] - parting_[k];
      const double by = w / contacts[k].compliance[press_row];
      sum[2] += by * by + off_plane(contacts[k], scale_[k].friction, scale_[k].row, x, gradient_[k]);
    });
    const double whole = std::max(all, settings.least * settings.least);
    end.residual = whole > 0 ? std::sqrt(off / whole) : std::sqrt(off);
    end.by_overlap = whole > 0 ? std::sqrt(gap / whole) : 0;
    if (end.found(settings, end.iterations < settings.wished ? settings.wish : 1)) break;
  }
  return end;
}

ConeEnd ConeSolver::solve(const Bodies& bodies, const std::vector<ConeContact>& contacts, const ConeSettings& settings,
                          Columns& impulse, Team& team) {
  const std::size_t n = contacts.size();
  if (n == 0) return {};
  index(bodies.size(), contacts);
  scale(bodies, contacts);
  wrench_.resize(n), change_.resize(bodies.size());
  for (Columns* column : {&x_, &y_, &next_, &gradient_}) column->resize(n);
  block_.resize(block_count(n));
  parting_.resize(n);
  for (std::size_t k = 0; k < n; ++k) parting_[k] = settings.parts ? 0 : contacts[k].friction * contacts[k].slip;
  const double length = 1 / (1.05 * largest(bodies, contacts, team));
  for (std::size_t k = 0; k < n; ++k) {
    const ConeRows& scale = scale_[k].row;
    for (std::size_t j = 0; j < cone_rows; ++j) x_[k][j] = scale[j] > 0 ? impulse[k][j] / scale[j] : 0;
    project(scale_[k].friction, x_[k]);
  }
  const ConeEnd end = descend(bodies, contacts, length, settings, team);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t j = 0; j < cone_rows; ++j) impulse[k][j] = x_[k][j] * scale_[k].row[j];
  return end;
}

}  // namespace grus::dem
