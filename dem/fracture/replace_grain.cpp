// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/replace_grain.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// Integrals over a body of density, density x and density x x^T, x from a given centre (global axes): of its solid,
/// whatever resists its motion.
struct MassMoments {
  double mass;
  Vec3 first;
  Mat3 second;
};

MassMoments moments_of(const Grains& g, std::size_t i, const Vec3& centre) {
  const double m = solid_mass(g, i);
  const Vec3 x = g.motion[i].position - centre;
  const Mat3 inertia = (m / turn_mass(g, i)) * inertia_tensor(g, i);
  return {m, m * x, 0.5 * inertia.trace() * Mat3::Identity() - inertia + m * x * x.transpose()};
}

}  // namespace

std::vector<std::size_t> replace_grain(Grains& g, std::size_t i, const Pieces& pieces, const FinesGrading& grading,
                                       Fines& fines) {
  const Motion parent = g.motion[i];
  const Vec3 spin = spin_of(g, i);
  const double diameter = 2 * g.extent[i].equivalent_radius;
  const int generation = g.generation.empty() ? 0 : g.generation[i] + 1;
  MassMoments lost = moments_of(g, i, parent.position);
  std::vector<std::size_t> slots;
  for (GrainSpec piece : pieces.piece) {
    const std::size_t slot = slots.empty() ? i : g.size();
    piece.velocity = parent.velocity + spin.cross(piece.position - parent.position);
    piece.spin = spin;
    set_grain(g, slot, piece);
    if (!g.generation.empty()) g.generation[slot] = static_cast<std::uint8_t>(generation);
    const MassMoments kept = moments_of(g, slot, parent.position);
    lost.mass -= kept.mass;
    lost.first -= kept.first;
    lost.second -= kept.second;
    slots.push_back(slot);
  }
  // What is removed goes on in the parent's rigid velocity field, wherever the pieces go.
  const Mat3 inertia = lost.second.trace() * Mat3::Identity() - lost.second;
  const Vec3 turning = spin.cross(lost.first), momentum = lost.mass * parent.velocity + turning;
  fines.mass += lost.mass;
  fines.momentum += momentum;
  fines.angular_momentum += parent.position.cross(momentum) + lost.first.cross(parent.velocity) + inertia * spin;
  fines.kinetic +=
      0.5 * (lost.mass * parent.velocity.squaredNorm() + spin.dot(inertia * spin)) + parent.velocity.dot(turning);
  if (pieces.loses_mass) {
    const double top = grading.largest * diameter;
    add_fines(fines, top, std::min(grading.smallest, 0.5 * top), grading.dimension, lost.mass);
  }
  return slots;
}

}  // namespace grus::dem
