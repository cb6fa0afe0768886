// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/rough_walls.hpp"

#include <algorithm>

namespace grus::dem {

bool any_rough(const Boundary& boundary) {
  return std::any_of(boundary.walls.begin(), boundary.walls.end(), [](const Wall& w) { return rough(w); });
}

bool any_rough_moves(const Boundary& boundary) {
  return std::any_of(boundary.walls.begin(), boundary.walls.end(),
                     [](const Wall& w) { return rough(w) && !w.velocity.isZero(0); });
}

void fix(Grains& g, std::size_t i, const Vec3& velocity) {
  constexpr double never_turns = 1e200;  // kg; infinity would leave none of the sweep's numbers whole
  Motion& m = g.motion[i];
  m.velocity = velocity, m.spin = g.angular_momentum[i] = Vec3::Zero();
  if (!is_sphere(g, i)) {
    if (g.turn_mass.empty()) g.turn_mass = g.mass;
    g.inertia[i].moments *= never_turns / g.turn_mass[i], g.turn_mass[i] = never_turns;
  }
  m.inverse_mass = m.inverse_inertia = 0;
}

void carry_rough_walls(State& s) {
  if (!any_rough(s.boundary)) return;
  for (std::size_t i = 0; i < s.grains.size(); ++i)
    for (const Wall& wall : s.boundary.walls) {
      if (!moves_with(wall, s.grains.material[i])) continue;
      Vec3& velocity = s.grains.motion[i].velocity;
      s.ledger.work += 0.5 * s.grains.mass[i] * (wall.velocity.squaredNorm() - velocity.squaredNorm());
      velocity = wall.velocity;
    }
}

double rough_power(const Model& model, const State& s) {
  double power = 0;
  if (!any_rough(s.boundary)) return power;
  for (std::size_t w = 0; w < s.boundary.walls.size(); ++w) {
    const Vec3& velocity = s.boundary.walls[w].velocity;
    if (rough(s.boundary.walls[w]) && !velocity.isZero(0)) power -= rough_force(s, w).dot(velocity);
  }
  if (model.motion.gravity.isZero(0)) return power;
  for (std::size_t i = 0; i < s.grains.size(); ++i)  // gravity's work on them is booked as on all grains
    if (const Motion& m = s.grains.motion[i]; m.inverse_mass == 0)
      power -= s.grains.mass[i] * model.motion.gravity.dot(m.velocity);
  return power;
}

Vec3 to_plane(const State& s, std::size_t i) {
  const auto& walls = s.boundary.walls;
  const auto holder =
      std::find_if(walls.begin(), walls.end(), [&](const Wall& w) { return moves_with(w, s.grains.material[i]); });
  return -holder->distance(s.grains.motion[i].position) * holder->facing();
}

Vec3 rough_force(const State& s, std::size_t wall) {
  Vec3 force = Vec3::Zero();
  each_rough_contact(s, wall, [&](std::size_t k, bool is_b) {
    const Vec3& on_b = s.contacts.touch[k].force;
    force += is_b ? on_b : Vec3(-on_b);
  });
  return force;
}

}  // namespace grus::dem
