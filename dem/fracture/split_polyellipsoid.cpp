// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/split_polyellipsoid.hpp"

namespace grus::dem {

std::array<Half, 2> halves(const PolyEllipsoid& parent, int axis, double asked) {
  const double rounding = std::max(asked, least_rounding);
  const double across = std::sqrt(1 - rounding);
  std::array<Half, 2> half;
  for (int side = 0; side < 2; ++side) {
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
  const Vec3 spin = spin_of(g, i), moment = g.angular_momentum[i];
  const double mass = g.mass[i], parent_diameter = 2 * equivalent_radius(g.shape[i]);
  const auto half = halves(g.shape[i], axis, fracture.rounding);
  const bool keep_mass = fracture.keep_mass || fracture.rounding == 0;
  const double density = mass / (keep_mass ? volume(half[0].shape) + volume(half[1].shape) : volume(g.shape[i]));
  const Quat orientation = g.orientation[i];
  const auto material = g.material[i];
  const std::uint8_t generation = g.generation.empty() ? 0 : g.generation[i];

  fines.mass += mass;
  fines.momentum += mass * parent.velocity;
  fines.angular_momentum += moment + mass * parent.position.cross(parent.velocity);
  fines.kinetic += 0.5 * (mass * parent.velocity.squaredNorm() + moment.dot(spin));
  double kept = 0;
  for (int side = 0; side < 2; ++side) {
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
    const double m = g.mass[slot];
    fines.mass -= m;
    fines.momentum -= m * child.velocity;
    fines.angular_momentum -= g.angular_momentum[slot] + m * child.position.cross(child.velocity);
    fines.kinetic -= 0.5 * (m * child.velocity.squaredNorm() + g.angular_momentum[slot].dot(spin));
    kept += m;
  }
  if (!keep_mass) add_fines(fines, fracture.fines.largest * parent_diameter, fracture.fines.dimension, mass - kept);
}

}  // namespace grus::dem
