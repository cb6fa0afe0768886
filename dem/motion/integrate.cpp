// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/integrate.hpp"

#include <algorithm>
#include <array>

namespace grus::dem {

SweepPass::SweepPass(Kick kick, Grains& g, Contacts& c, const MotionSettings& s, bool bonded, double dt,
                     std::vector<SweepEnergy>& energy)
    : kick_(kick),
      grains_(g),
      contacts_(c),
      energy_(energy),
      turning_(kick != Kick::close && (s.turn_spheres || !g.frame.empty())),
      rows_{.motion = reinterpret_cast<double*>(g.motion.data()),
            .load = nullptr,
            .elsewhere = reinterpret_cast<double*>(c.plan.load.data()),
            .remote = c.plan.remote.data(),
            .remote_row = c.plan.remote_row.data(),
            .force = reinterpret_cast<double*>(g.force.data()),
            .torque = reinterpret_cast<double*>(g.torque.data()),
            .angular_momentum = reinterpret_cast<double*>(g.angular_momentum.data()),
            .mass = g.mass.data(),
            .orientation = reinterpret_cast<double*>(g.orientation.data()),
            .frame = g.frame.empty() ? nullptr : reinterpret_cast<double*>(g.frame.data()),
            .inertia = reinterpret_cast<const double*>(g.inertia.data()),
            .shape = reinterpret_cast<const double*>(g.shape.data()),
            .gravity = {s.gravity.x(), s.gravity.y(), s.gravity.z()},
            .affine = {},
            .weighs = !s.gravity.isZero(0),
            .shears = !s.affine.isZero(0),
            .bonded = bonded,
            .damping = std::all_of(s.damping.begin(), s.damping.end(), [](double d) { return d == 0; })
                           ? nullptr
                           : s.damping.data(),
            .material = g.material.data(),
            .first = 0,
            .dt = dt},
      spheres_(sphere_kicks()),
      bodies_(body_kicks()),
      turns_(sphere_turns()) {
  static_assert(sizeof(Quat) == 32 && sizeof(Inertia) == 56 && sizeof(PolyEllipsoid) == 48 && sizeof(Frame) == 96 &&
                sizeof(Motion) == 96);
  for (int k = 0; k < 9; ++k) rows_.affine[k] = s.affine(k % 3, k / 3);
  if (energy.size() < tile_count(g.size())) energy.resize(tile_count(g.size()));
}

void SweepPass::tile(std::size_t t, Load* room) const {
  const Grains& g = grains_;
  SweepRows rows = rows_;
  SweepEnergy& total = energy_[t];
  auto book = [&](const SweepEnergy& e) {
    total.viscous += e.viscous;
    total.work += e.work;
    total.speed2 = std::max(total.speed2, e.speed2);
  };
  const std::size_t begin = t * tile_size(g.size()), end = std::min(g.size(), begin + tile_size(g.size()));
  rows.load = reinterpret_cast<double*>(room ? room : contacts_.plan.load.data() + begin),
  rows.first = static_cast<std::uint32_t>(begin);
  const bool all_round = g.frame.empty();
  if (all_round) book(spheres_(rows, kick_, begin, end));
  if (all_round && !turning_) return;
  std::array<Index, 128> round, other;
  for (std::size_t from = begin; from < end; from += round.size()) {
    const std::size_t to = std::min(end, from + round.size());
    std::size_t rounds = 0, others = 0;
    for (std::size_t i = from; i < to; ++i)
      (is_sphere(g, i) ? round[rounds++] : other[others++]) = static_cast<Index>(i);
    for (std::size_t k = 0; k < rounds && !all_round;) {  // those in a row together
      const std::size_t first = k++;
      while (k < rounds && round[k] == round[k - 1] + 1) ++k;
      book(spheres_(rows, kick_, round[first], round[k - 1] + 1));
    }
    if (others > 0) book(bodies_(rows, kick_, other.data(), others));
    if (turning_ && rounds > 0) turns_(rows, round.data(), rounds);
  }
}

void sweep(Kick kick, Grains& g, Contacts& c, const MotionSettings& s, bool bonded, double dt,
           std::vector<SweepEnergy>& energy, Team& team) {
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
