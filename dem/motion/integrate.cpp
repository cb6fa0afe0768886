// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/integrate.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

Vec3 opposing(const Vec3& force, const Vec3& velocity, double alpha) {
  Vec3 d;
  for (int k = 0; k < 3; ++k) d[k] = velocity[k] == 0 ? 0 : -alpha * std::copysign(std::abs(force[k]), velocity[k]);
  return d;
}

inline void half_kick(Grains& g, std::size_t i, const MotionSettings& s, const Vec3& f, const Vec3& t, double h, SweepEnergy& e) {
  Motion& m = g.motion[i];
  Vec3 force = f, torque = t;
  if (s.local_damping > 0) {
    const Vec3 df = opposing(force, m.velocity - s.affine * m.position, s.local_damping);
    const Vec3 dt = opposing(torque, m.spin, s.local_damping);
    force += df, torque += dt;
    e.viscous -= h * (df.dot(m.velocity + 0.5 * h * m.inverse_mass * force) + dt.dot(m.spin));
  }
  e.work += h * g.mass[i] * s.gravity.dot(m.velocity + 0.5 * h * m.inverse_mass * force);
  m.velocity += (h * m.inverse_mass) * force;
  if (g.round[i]) m.spin += (h * m.inverse_inertia) * torque;
  else g.angular_momentum[i] += h * torque;
}

/// Takes the loads of grain i, its own row and those of pairs of other tiles.
inline void gather(const Grains& g, Contacts& c, Load& load, std::size_t i, const Vec3& gravity, bool bonded, Vec3& force, Vec3& torque) {
  force = g.mass[i] * gravity + load.force, torque = load.torque;
  load = {};
  for (Index e = c.remote[i]; e < c.remote[i + 1]; ++e) {
    const Index r = c.remote_row[e];
    force += c.load[r].force, torque += c.load[r].torque;
    c.load[r] = {};
  }
  if (bonded) force += g.force[i], torque += g.torque[i];
}

inline void drift(Grains& g, std::size_t i, double dt) {
  Motion& m = g.motion[i];
  m.position += dt * m.velocity;
  g.orientation[i] = turn(g.orientation[i], g.inertia[i], g.angular_momentum[i], dt);
  g.frame[i] = frame_of(g, i);
  m.spin = spin_of(g, i);
}

inline void turn_sphere(Grains& g, std::size_t i, double dt) {
  g.orientation[i] = unit(rotation_by(dt * g.motion[i].spin) * g.orientation[i]);
  if (!g.frame.empty()) g.frame[i].origin = g.motion[i].position, g.frame[i].axes = g.orientation[i].toRotationMatrix();
}

/// Grain by grain: tiles that hold other shapes than spheres, or bonds.
template <bool close, bool open>
void sweep_each(Grains& g, Contacts& c, Load* load, const MotionSettings& s, bool bonded, double dt, std::size_t begin, std::size_t end, SweepEnergy& e) {
  for (std::size_t i = begin; i < end; ++i) {
    Motion& m = g.motion[i];
    Vec3 force = g.force[i], torque = g.torque[i];
    if constexpr (close) {
      gather(g, c, load[i], i, s.gravity, bonded, force, torque);
      if constexpr (!open) g.force[i] = force, g.torque[i] = torque;
      half_kick(g, i, s, force, torque, 0.5 * dt, e);
      if (!g.round[i]) m.spin = spin_of(g, i);
      else if (!open) g.angular_momentum[i] = m.spin / m.inverse_inertia;
    }
    if constexpr (open) {
      half_kick(g, i, s, force, torque, 0.5 * dt, e);
      if (g.round[i]) m.position += dt * m.velocity;
      else drift(g, i, dt);
      const double speed = (m.velocity - s.affine * m.position).norm() + (g.round[i] ? 0 : 1.01 * m.spin.norm() * m.radius);
      e.speed2 = std::max(e.speed2, speed * speed);
    }
  }
}

}  // namespace

Quat turn(const Quat& orientation, const Inertia& inertia, const Vec3& momentum, double dt) {
  const Vec3& I = inertia.moments;
  const double split = 1 / I.x() - 1 / I.y(), spin = 1 / I.z() - 1 / I.y();
  Quat q = orientation * inertia.axes;
  auto about_x = [&] {
    if (split == 0) return;
    const double p = (q.conjugate() * momentum).x();
    q = q * rotation_by({0.5 * dt * p * split, 0, 0});
  };
  about_x();
  const double pz = (q.conjugate() * momentum).z();  // a top keeps it
  q = rotation_by(dt / I.y() * momentum) * q * rotation_by({0, 0, dt * pz * spin});
  about_x();
  return unit(q * inertia.axes.conjugate());
}

SweepPass::SweepPass(Kick kick, Grains& g, Contacts& c, const MotionSettings& s, bool bonded, double dt, std::vector<SweepEnergy>& energy)
    : kick_(kick), grains_(g), contacts_(c), settings_(s), bonded_(bonded), energy_(energy),
      rows_{.motion = reinterpret_cast<double*>(g.motion.data()),
            .load = nullptr,
            .elsewhere = reinterpret_cast<double*>(c.load.data()),
            .remote = c.remote.data(),
            .remote_row = c.remote_row.data(),
            .force = reinterpret_cast<double*>(g.force.data()),
            .torque = reinterpret_cast<double*>(g.torque.data()),
            .angular_momentum = reinterpret_cast<double*>(g.angular_momentum.data()),
            .mass = g.mass.data(),
            .gravity = {s.gravity.x(), s.gravity.y(), s.gravity.z()},
            .affine = {},
            .weighs = !s.gravity.isZero(0),
            .shears = !s.affine.isZero(0),
            .damping = s.local_damping,
            .dt = dt},
      kicks_(sphere_kicks()) {
  for (int k = 0; k < 9; ++k) rows_.affine[k] = s.affine(k % 3, k / 3);
  if (energy.size() < tile_count(g.size())) energy.resize(tile_count(g.size()));
}

void SweepPass::tile(std::size_t t, Load* load) const {
  if (!load) load = contacts_.load.data();
  Grains& g = grains_;
  const std::size_t begin = t * tile_size(g.size()), end = std::min(g.size(), begin + tile_size(g.size()));
  SweepEnergy& total = energy_[t];
  bool spheres = !bonded_;
  if (!g.frame.empty())
    for (std::size_t i = begin; i < end && spheres; ++i) spheres = g.round[i];
  if (spheres) {
    SphereSweep rows = rows_;
    rows.load = reinterpret_cast<double*>(load);
    const SweepEnergy e = kicks_(rows, kick_, begin, end);
    total.viscous += e.viscous, total.work += e.work, total.speed2 = std::max(total.speed2, e.speed2);
  } else if (kick_ == Kick::close) {
    sweep_each<true, false>(g, contacts_, load, settings_, bonded_, rows_.dt, begin, end, total);
  } else if (kick_ == Kick::open) {
    sweep_each<false, true>(g, contacts_, load, settings_, bonded_, rows_.dt, begin, end, total);
  } else {
    sweep_each<true, true>(g, contacts_, load, settings_, bonded_, rows_.dt, begin, end, total);
  }
  if (kick_ == Kick::close || !(settings_.turn_spheres || !g.frame.empty())) return;
  for (std::size_t i = begin; i < end; ++i)
    if (g.round[i]) turn_sphere(g, i, rows_.dt);
}

void sweep(Kick kick, Grains& g, Contacts& c, const MotionSettings& s, bool bonded, double dt, std::vector<SweepEnergy>& energy, Team& team) {
  const SweepPass pass(kick, g, c, s, bonded, dt, energy);
  team.pieces(tile_count(g.size()), [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) pass.tile(t);
  });
}

double take_speed(std::vector<SweepEnergy>& energy) {
  double speed2 = 0;
  for (auto& e : energy) speed2 = std::max(speed2, e.speed2), e.speed2 = 0;
  return std::sqrt(speed2);
}

void move_boundary(Boundary& boundary, double dt) {
  for (auto& wall : boundary.walls) wall.point += dt * wall.velocity;
  if (boundary.cell.periodic()) boundary.cell.vectors += dt * boundary.cell.rate;
}

}  // namespace grus::dem
