// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/split_polyellipsoid.hpp"

#include "dem/fracture/break_plane.hpp"

namespace grus::dem {

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

bool can_split(const Halves&, const Grains& g, std::size_t i) {
  return choose_axis(g.shape[i], Vec3::Zero()).has_value();
}

Pieces pieces_of(const Halves& splitter, const Grains& g, std::size_t i, const Wanted& wanted, std::uint64_t seed) {
  const Mat3 axes = g.orientation[i].toRotationMatrix();
  const AxisPreference preference = wanted.plane ? AxisPreference((axes.transpose() * *wanted.plane).cwiseAbs())
                                                 : AxisPreference((axes.transpose() * wanted.stress * axes).diagonal());
  const int axis = *choose_axis(g.shape[i], preference);
  Quat q = g.orientation[i];
  if (is_sphere(g, i) && splitter.turn_spheres) {  // only a sphere's axes are free to turn
    q = turned_to_plane(q, axis, wanted.plane ? *wanted.plane : Vec3(principal_axes(wanted.stress).directions.col(2)));
  }
  if (is_sphere(g, i) && splitter.slight_rotation > 0)
    q = (q * Quat(slight_rotation(splitter.slight_rotation, seed, g.id[i]))).normalized();
  return halves_of(splitter, g, i, axis, q);
}

Pieces halves_of(const Halves& splitter, const Grains& g, std::size_t i, int axis, const Quat& orientation) {
  const PolyEllipsoid& parent = g.shape[i];
  const auto half = halves(parent, axis, splitter.rounding);
  const bool keep_mass = splitter.keep_mass || splitter.rounding == 0;
  const double density =
      solid_mass(g, i) / (keep_mass ? volume(half[0].shape) + volume(half[1].shape) : g.extent[i].volume);
  const Mat3 frame = orientation.toRotationMatrix();
  const Vec3 origin = g.motion[i].position - frame * centre_of_mass(parent);
  Pieces out;
  out.orientation = orientation;
  for (const Half& h : half)
    out.piece.push_back({.shape = h.shape,
                         .position = origin + frame * (h.origin + centre_of_mass(h.shape)),
                         .orientation = orientation,
                         .material = g.material[i],
                         .density = density});
  out.loses_mass = !keep_mass;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  out.plane.push_back({1, 0, Vec3::Unit(axis), Vec3::Unit(u), Vec3::Unit(v), parent.plus[u], parent.minus[u],
                       parent.plus[v], parent.minus[v]});
  return out;
}

}  // namespace grus::dem
