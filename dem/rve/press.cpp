// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/press.hpp"

#include <algorithm>

#include "dem/bond/kinds.hpp"
#include "dem/bond/supports.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/rough_walls.hpp"
#include "dem/rve/servo.hpp"

namespace grus::dem {
namespace {

/// What a wall feels, along its normal.
struct Felt {
  double force = 0;      // N, that presses it outward,
  double stiffness = 0;  // N/m, with which that grows as the wall goes inward,
  double dashpot = 0;    // N s/m, and with its speed
  double speed = 0;      // m/s, of what touches it, weighed by stiffness
};

void add(Felt& to, double stiffness, double speed) { to.stiffness += stiffness, to.speed += stiffness * speed; }

Felt felt_by(const Model& model, const State& s, std::size_t wall) {
  const Vec3 n = s.boundary.walls[wall].facing();
  Felt felt;
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k) {
    const Pair& pair = s.contacts.pair[k];
    if (pair.b != wall || !s.contacts.contact.touching(k)) continue;
    const double stiffness = elastic_response(model.law, s.contacts, k).grip;
    const Motion& grain = s.grains.motion[pair.a];
    const Vec3 arm = contact_arm(s.grains, s.contacts, k, false);
    felt.force -= s.contacts.touch[k].force.dot(n);
    felt.dashpot += model.pairs[pair.law].dashpot * std::sqrt(s.grains.mass[pair.a] * stiffness);
    add(felt, stiffness, n.dot(grain.velocity + grain.spin.cross(arm)));
  }
  each_rough_contact(s, wall, [&](std::size_t k, bool is_b) {
    const Pair& pair = s.contacts.pair[k];
    const PairLaw& p = model.pairs[pair.law];
    const double normal = elastic_response(model.law, s.contacts, k).grip;
    const double along = std::pow(n.dot(s.contacts.touch[k].normal), 2);  // shares of the way that press and that rub
    const double across = p.friction[slide_spring] > 0 ? p.shear_ratio * (1 - along) : 0;
    const Index free = is_b ? pair.a : pair.b;
    const Motion& grain = s.grains.motion[free];
    const Vec3 arm = contact_arm(s.grains, s.contacts, k, !is_b);
    felt.force += (is_b ? -1 : 1) * s.contacts.touch[k].force.dot(n);
    felt.dashpot += along * p.dashpot * std::sqrt(s.grains.mass[free] * normal);
    add(felt, (along + across) * normal, n.dot(grain.velocity + grain.spin.cross(arm)));
  });
  for (const FaceBond& bond : s.bonds.wall) {
    if (bond.ends.b != wall) continue;
    const Quat& q = s.grains.orientation[bond.ends.a];
    const Motion& grain = s.grains.motion[bond.ends.a];
    felt.force -= bond.force.dot(n);
    add(felt, n.dot(stiffest(bond, q).shift * n), n.dot(grain.velocity + grain.spin.cross(Vec3(q * bond.at_a))));
  }
  if (felt.stiffness > 0) felt.speed /= felt.stiffness;
  return felt;
}

/// Speed of a wall along its normal (m/s) that brings it to `force` (N) in a step: inward no more than `most`, outward
/// as fast as the grains push it and no more than that beside. What it presses more than now stiffens Hertz's contacts.
double speed_to(const Felt& felt, double force, double now, double most, double dt) {
  if (!(felt.stiffness > 0)) return force > 0 ? std::min(most, std::max(now, 0.0) + 0.05 * most) : 0;
  const double stiffness = felt.stiffness * std::cbrt(std::max(1.0, force / std::max(felt.force, 1e-6 * force)));
  const double gap = force - felt.force + felt.dashpot * (now - felt.speed);
  const double speed = felt.speed + gap / (stiffness * dt + felt.dashpot);
  return std::clamp(speed, std::min(felt.speed, 0.0) - most, most);
}

/// What the walls must carry beside pressing alike: weight and dead loads (N).
Vec3 carried(const Model& model, const State& s, double mass) {
  for (std::size_t i = 0; i < s.grains.size(); ++i)  // those of rough walls are held by themselves
    if (s.grains.motion[i].inverse_mass == 0) mass -= solid_mass(s.grains, i);
  Vec3 force = -mass * model.motion.gravity;
  for (const DeadLoad& load : s.bonds.load) force -= load.felt;
  return force;
}

/// The area on which a wall presses (m^2).
double area_of(const State& s, const WallControl& control) {
  if (control.area > 0) return control.area;
  const Vec3 along = s.boundary.walls[control.wall].facing().cwiseAbs();
  return bulk_volume(s.boundary) / along.dot(size_of(s.boundary));
}

double force_asked(const State& s, const WallControl& control) {
  return std::max(0.0, control.stress + control.stress_rate * s.time) * area_of(s, control);
}

}  // namespace

void press_wall(const Model& model, State& state, const WallControl& control) {
  Wall& wall = state.boundary.walls[control.wall];
  const Vec3 n = wall.facing();
  const Felt felt = felt_by(model, state, control.wall);
  const double force = force_asked(state, control), area = area_of(state, control);
  const double pressure = std::max(force, felt.force) / area;
  const double most = control.max_speed > 0 ? control.max_speed
                      : pressure > 0        ? 0.5 * std::sqrt(area) * fastest_rate(state, {}, pressure)
                                            : 0;
  const double now = n.dot(wall.velocity);
  wall.velocity += (speed_to(felt, force, now, most, state.dt) - now) * n;
}

WallForce force_of(const State& s, const WallControl& control) {
  const Vec3 n = s.boundary.walls[control.wall].facing();
  WallForce found{.force = -n.dot(support_force(s.bonds, control.wall) + rough_force(s, control.wall)),
                  .asked = force_asked(s, control)};
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k)
    if (s.contacts.pair[k].b == control.wall) found.force -= s.contacts.touch[k].force.dot(n);
  return found;
}

void press_walls(const Model& model, State& state, const Loading& loading) {
  const Vec3 stress = normal_stresses(state), size = size_of(state.boundary);
  const std::array<AxisControl, 3> axes = controls(loading, stress, state.time);
  const double volume = bulk_volume(state.boundary), mass = total_mass(state.grains), density = mass / volume;
  const Vec3 outside = carried(model, state, mass), drift = momentum(state.grains);
  for (std::size_t w = 0; w < state.boundary.walls.size(); ++w) {
    Wall& wall = state.boundary.walls[w];
    const Vec3 facing = wall.facing();
    for (int k = 0; k < 3; ++k) {
      const double n = facing[k];
      if (std::abs(n) != 1) continue;
      const AxisControl& axis = axes[static_cast<std::size_t>(k)];
      if (!axis.stress) {
        wall.velocity[k] = n < 0 ? axis.strain_rate * loading.initial_size[k] : 0;
        continue;
      }
      const double asked = stress_asked(axis, state.time), pressure = std::max(std::abs(asked), std::abs(stress[k]));
      const double most = 0.5 * loading.initial_size[k] * fastest_rate(state, axis, pressure);
      // A sample that drifts between its walls comes to rest while the pressure could have moved it by its length.
      const double force = -asked * volume / size[k], brake = 0.01 * std::abs(force);
      const double rest = drift[k] * std::sqrt(std::abs(asked) / density) / size[k];
      const double both = outside[k] - std::clamp(rest, -brake, brake);
      wall.velocity[k] =
          n * speed_to(felt_by(model, state, w), force + 0.5 * n * both, n * wall.velocity[k], most, state.dt);
    }
  }
}

}  // namespace grus::dem
