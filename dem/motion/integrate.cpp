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

inline void half_kick(Grains& g, std::size_t i, const MotionSettings& s, double h, BlockEnergy& e) {
  Motion& m = g.motion[i];
  Vec3 force = g.force[i], torque = g.torque[i];
  if (s.local_damping > 0) {
    const Vec3 df = opposing(force, m.velocity - s.affine * m.position, s.local_damping);
    const Vec3 dt = opposing(torque, m.spin, s.local_damping);
    force += df, torque += dt;
    e.viscous -= h * (df.dot(m.velocity + 0.5 * h * m.inverse_mass * force) + dt.dot(m.spin));
  }
  e.work += h * g.mass[i] * s.gravity.dot(m.velocity + 0.5 * h * m.inverse_mass * force);
  m.velocity += (h * m.inverse_mass) * force;
  g.angular_momentum[i] += h * torque;
  if (g.round[i]) m.spin = m.inverse_inertia * g.angular_momentum[i];
}

inline void gather(Grains& g, const Contacts& c, std::size_t i, const Vec3& gravity, bool bonded) {
  Vec3 force = g.mass[i] * gravity, torque = Vec3::Zero();
  if (bonded) force += g.force[i], torque += g.torque[i];
  for (Index e = c.first[i]; e < c.first[i + 1]; ++e) {
    const Index entry = c.entry[e];
    const ContactForce& f = c.force[entry >> 1];
    if (entry & 1) force += f.force, torque += f.torque_b;
    else force -= f.force, torque += f.torque_a;
  }
  g.force[i] = force;
  g.torque[i] = torque;
}

inline void drift(Grains& g, std::size_t i, double dt, bool turn_spheres) {
  Motion& m = g.motion[i];
  m.position += dt * m.velocity;
  if (g.round[i]) {
    if (!turn_spheres) return;
    g.orientation[i] = unit(rotation_by(dt * m.spin) * g.orientation[i]);
    if (!g.frame.empty()) g.frame[i].origin = m.position, g.frame[i].axes = g.orientation[i].toRotationMatrix();
    return;
  }
  g.orientation[i] = turn(g.orientation[i], g.inertia[i], g.angular_momentum[i], dt);
  g.frame[i] = frame_of(g, i);
  m.spin = spin_of(g, i);
}

template <bool close, bool open>
void sweep(Grains& g, const Contacts* c, const MotionSettings& s, bool bonded, double dt, std::vector<BlockEnergy>& energy,
           Team& team) {
  if (energy.size() < block_count(g.size())) energy.resize(block_count(g.size()));
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      BlockEnergy& e = energy[i / block_size];
      if constexpr (close) {
        gather(g, *c, i, s.gravity, bonded);
        half_kick(g, i, s, 0.5 * dt, e);
        if (!g.round[i]) g.motion[i].spin = spin_of(g, i);
      }
      if constexpr (open) {
        half_kick(g, i, s, 0.5 * dt, e);
        drift(g, i, dt, s.turn_spheres || !g.frame.empty());
      }
    }
  });
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

void close_step(Grains& g, const Contacts& c, const MotionSettings& s, bool bonded, double dt, std::vector<BlockEnergy>& energy,
                Team& team) {
  sweep<true, false>(g, &c, s, bonded, dt, energy, team);
}

void open_step(Grains& g, const MotionSettings& s, double dt, std::vector<BlockEnergy>& energy, Team& team) {
  sweep<false, true>(g, nullptr, s, false, dt, energy, team);
}

void close_and_open_step(Grains& g, const Contacts& c, const MotionSettings& s, bool bonded, double dt,
                         std::vector<BlockEnergy>& energy, Team& team) {
  sweep<true, true>(g, &c, s, bonded, dt, energy, team);
}

void move_boundary(Boundary& boundary, double dt) {
  for (auto& wall : boundary.walls) wall.point += dt * wall.velocity;
  if (boundary.cell.periodic()) boundary.cell.vectors += dt * boundary.cell.rate;
}

}  // namespace grus::dem
