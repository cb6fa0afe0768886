// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/split_polyellipsoid.hpp"

namespace grus::dem {
namespace {

/// Integrals over a body of density, density x and density x x^T, x from a given centre (global axes).
struct MassMoments {
  double mass;
  Vec3 first;
  Mat3 second;
};

MassMoments moments_of(const PolyEllipsoid& shape, double density, const Mat3& axes, const Vec3& centre) {
  const double m = density * volume(shape);
  return {m, m * centre, m * (axes * second_moment(shape) * axes.transpose() + centre * centre.transpose())};
}

}  // namespace

std::array<Half, 2> halves(const PolyEllipsoid& parent, int axis, double asked) {
  const double rounding = std::max(asked, least_rounding);
  const double across = std::sqrt(1 - rounding);
  std::array<Half, 2> half;
  for (std::size_t side = 0; side < 2; ++side) {
    Half& h = half[side];
    const double length = side == 0 ? parent.plus[axis] : parent.minus[axis];
    h.shape = {across * parent.plus, across * parent.minus};
    (side == 0 ? h.shape.plus : h.shape.minus)[axis] = (1 - rounding) * length;
    (side == 0 ? h.shape.minus : h.shape.plus)[axis] = rounding * length;
    h.origin = Vec3::Zero();
    h.origin[axis] = (side == 0 ? 1 : -1) * rounding * length;
  }
  return half;
}

void split_grain(Grains& g, std::size_t i, int axis, const FractureModel& fracture, Fines& fines) {
  const Frame frame = frame_of(g, i);
  const Motion parent = g.motion[i];
  const Vec3 spin = spin_of(g, i);
  const double mass = g.mass[i], parent_diameter = 2 * equivalent_radius(g.shape[i]);
  const auto half = halves(g.shape[i], axis, fracture.rounding);
  const bool keep_mass = fracture.keep_mass || fracture.rounding == 0;
  const double density = mass / (keep_mass ? volume(half[0].shape) + volume(half[1].shape) : volume(g.shape[i]));
  const Quat orientation = g.orientation[i];
  const auto material = g.material[i];
  const std::uint8_t generation = g.generation.empty() ? 0 : g.generation[i];

  MassMoments lost = moments_of(g.shape[i], mass / volume(g.shape[i]), frame.axes, Vec3::Zero());
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t slot = side == 0 ? i : g.size();
    GrainSpec child;
    child.shape = half[side].shape;
    child.position = frame.origin + frame.axes * (half[side].origin + centre_of_mass(child.shape));
    child.velocity = parent.velocity + spin.cross(child.position - parent.position);
    child.spin = spin;
    child.orientation = orientation;
    child.material = material;
    child.density = density;
    set_grain(g, slot, child);
    if (!g.generation.empty()) g.generation[slot] = static_cast<std::uint8_t>(generation + 1);
    const MassMoments kept = moments_of(child.shape, density, frame.axes, child.position - parent.position);
    lost.mass -= kept.mass, lost.first -= kept.first, lost.second -= kept.second;
  }
  // What is removed goes on in the parent's rigid velocity field, wherever the children go.
  const Mat3 inertia = lost.second.trace() * Mat3::Identity() - lost.second;
  const Vec3 turning = spin.cross(lost.first), momentum = lost.mass * parent.velocity + turning;
  fines.mass += lost.mass;
  fines.momentum += momentum;
  fines.angular_momentum += parent.position.cross(momentum) + lost.first.cross(parent.velocity) + inertia * spin;
  fines.kinetic +=
      0.5 * (lost.mass * parent.velocity.squaredNorm() + spin.dot(inertia * spin)) + parent.velocity.dot(turning);
  if (!keep_mass) add_fines(fines, fracture.fines.largest * parent_diameter, fracture.fines.dimension, lost.mass);
}

}  // namespace grus::dem
