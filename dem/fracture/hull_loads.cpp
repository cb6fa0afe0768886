// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/hull_loads.hpp"

#include "dem/bond/face_bond.hpp"
#include "dem/bond/supports.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

/// A circle of the area of a contact, whose own shape nobody keeps: a polygon.
constexpr int corners = 16;
double radius_of(double area) { return std::sqrt(2 * area / (corners * std::sin(2 * pi / corners))); }

FlatPolygon disc_of(double area) {
  const double radius = radius_of(area);
  FlatPolygon p;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * pi * k / corners;
    p.add({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return p;
}

/// What of a load is on one side of a plane: all, nothing, or what its linear traction has there.
struct Side {
  Vec3 force, couple;  // the couple about where the load acts
};

Side beyond(const HullLoad& load, const Grains& g, const Vec3& normal, double offset) {
  const double height = normal.dot(load.at) - offset;
  const auto all_or_nothing = [&]() -> Side {
    if (height > 0) return {load.force, load.couple};
    return {Vec3::Zero(), Vec3::Zero()};
  };
  const Eigen::Vector2d slope(normal.dot(load.e1), normal.dot(load.e2));
  // No corner of a convex face is further from its middle than that of a triangle: sqrt 8 standard deviations.
  const double variance =
      load.face.area > 0
          ? (slope.x() * slope.x() * load.face.i2 + slope.y() * slope.y() * load.face.i1) / load.face.area
          : 0;
  if (height * height >= 8 * variance) return all_or_nothing();
  const FlatPolygon face = load.bond ? polygon_of(g, *load.bond, load.walled) : disc_of(load.face.area);
  const FlatMoments part = moments_of(clipped(face, -slope, height));
  Mat3 axes;
  axes << load.e1, load.e2, load.e1.cross(load.e2);
  const FaceWrench on = carried(load.face, {axes.transpose() * load.force, axes.transpose() * load.couple}, part);
  return {axes * on.force, axes * on.couple};
}

}  // namespace

void index_bonds(std::size_t n, const Bonds& bonds, GrainBonds& by) {
  by.first.assign(n + 1, 0);
  const auto each = [&](auto&& f) {
    using enum GrainBonds::End;
    for (std::size_t k = 0; k < bonds.face.row.size(); ++k)
      f(bonds.face.row[k].ends.a, k, a), f(bonds.face.row[k].ends.b, k, b);
    for (std::size_t k = 0; k < bonds.wall.size(); ++k) f(bonds.wall[k].ends.a, k, wall);
    for (std::size_t k = 0; k < bonds.load.size(); ++k) f(bonds.load[k].grain, k, load);
  };
  each([&](Index i, std::size_t, GrainBonds::End) { ++by.first[i + 1]; });
  for (std::size_t i = 0; i < n; ++i) by.first[i + 1] += by.first[i];
  by.entry.resize(by.first[n]);
  each([&](Index i, std::size_t k, GrainBonds::End end) { by.entry[by.first[i]++] = {static_cast<Index>(k), end}; });
  for (std::size_t i = n; i > 0; --i) by.first[i] = by.first[i - 1];
  by.first[0] = 0;
}

Vec3 LoadedHull::arm(Index entry) const {
  const std::size_t k = entry >> 1;
  const Pair& p = contacts_.pair[k];
  if (!(entry & 1)) return contacts_.spot[k].at;
  return contacts_.spot[k].at - branch(grains_, boundary_.cell, {p.a, p.b, p.image});
}

HullLoad LoadedHull::of_contact(Index entry) const {
  const std::size_t k = entry >> 1;
  const double sign = entry & 1 ? 1 : -1, area = contacts_.contact.stiffness[k] / contacts_.contact.radius[k];
  const double second = area * std::pow(radius_of(area), 2) * (3 - 2 * std::pow(std::sin(pi / corners), 2)) / 12;
  const std::array<Vec3, 2> e = across(contacts_.touch[k].normal);
  return {arm(entry),
          sign * contacts_.touch[k].force,
          sign * contacts_.spot[k].couple,
          e[0],
          e[1],
          {area, second, second},
          nullptr,
          false};
}

HullLoad LoadedHull::of_bond(const GrainBonds::Entry& entry) const {
  using enum GrainBonds::End;
  if (entry.end == load) {
    const DeadLoad& dead = bonds_.load[entry.at];
    return {grains_.orientation[i_] * dead.at, dead.felt, Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), {}, nullptr, false};
  }
  const FaceBond& s = entry.end == wall ? bonds_.wall[entry.at] : bonds_.face.row[entry.at];
  FaceBond now = s;
  Pull p = entry.end == wall
               ? pull_of_plate(now, frame_at_wall(grains_, boundary_, s.ends))
               : pull(now, frame_of(grains_, boundary_.cell, s.ends), {&grains_, bonds_.outline[entry.at]});
  if (entry.end != wall && !bonds_.dashpot.empty())
    p.force += bonds_.dashpot[entry.at].force, p.couple += bonds_.dashpot[entry.at].couple;
  const double sign = entry.end == b ? 1 : -1;
  const Quat& q = grains_.orientation[s.ends.a];
  const Vec3 e1 = q * s.e1, e2 = (q * s.normal).cross(e1);
  return {entry.end == b ? p.arm_b : p.arm_a,
          sign * p.force,
          sign * p.couple,
          e1,
          e2,
          {s.area, s.i1, s.i2},
          &s,
          entry.end == wall};
}

Mat3 LoadedHull::stress() const {
  Mat3 sum = Mat3::Zero();
  each_load([&](const HullLoad& load) { sum += load.force * load.at.transpose(); });
  sum -= motion_virial(grains_, i_);
  return 0.5 * (sum + sum.transpose()) / grains_.extent[i_].volume;
}

double LoadedHull::largest_force() const {
  double most = 0;
  each_load([&](const HullLoad& load) { most = std::max(most, load.force.squaredNorm()); });
  return std::sqrt(most);
}

double LoadedHull::load_density() const {
  double sum = 0;
  each_load([&](const HullLoad& load) { sum += load.force.norm() * load.at.norm(); });
  return sum / grains_.extent[i_].volume;
}

Mat3 LoadedHull::crystal_axes() const {
  return (grains_.crystal.empty() ? grains_.orientation[i_] : grains_.orientation[i_] * grains_.crystal[i_])
      .toRotationMatrix();
}

double LoadedHull::reach(const Vec3& along) const {
  const Vec3 own = axes().transpose() * along;
  return own.dot(support(hull(), own));
}

PlaneLoad LoadedHull::across_plane(const Vec3& normal, double offset) const {
  const Mat3 own = axes();
  const Vec3 n = own.transpose() * normal;
  PlaneLoad out;
  out.section = section_of(hull(), n, offset);
  const SolidMoments part = part_beyond(hull(), n, offset);
  const double volume = grains_.extent[i_].volume;
  out.share = std::min(part.volume, volume - part.volume) / volume;
  out.moments = moments_of(out.section);
  if (out.section.corners < 3 || !(out.moments.area > 0)) return {};
  const std::array<Vec3, 2> e = across(n);
  const Eigen::Vector2d middle = out.moments.first / out.moments.area;
  out.middle = own * (offset * n + middle.x() * e[0] + middle.y() * e[1]);
  // What the part needs to move with the grain, less what it is given from outside.
  const double mass = grains_.mass[i_] / volume * part.volume, density = turn_mass(grains_, i_) / volume;
  const Vec3 spin = spin_of(grains_, i_), momentum = grains_.angular_momentum[i_], x = own * part.centre;
  const Vec3 turning = inertia_tensor(grains_, i_).inverse() * (grains_.torque[i_] - spin.cross(momentum));
  const Mat3 second = density * own * part.second * own.transpose();
  const Mat3 inertia = second.trace() * Mat3::Identity() - second;
  out.force = mass * grains_.motion[i_].inverse_mass * grains_.force[i_] +
              density * part.volume * (turning.cross(x) + spin.cross(spin.cross(x)));
  out.moment = inertia * turning + spin.cross(inertia * spin) + (x - out.middle).cross(out.force);
  each_load([&](const HullLoad& load) {
    const Side side = beyond(load, grains_, normal, offset);
    out.force -= side.force, out.moment -= side.couple + (load.at - out.middle).cross(side.force);
  });
  return out;
}

Vec3 LoadedHull::imbalance() const {
  Vec3 left = grains_.force[i_];
  each_load([&](const HullLoad& load) { left -= load.force; });
  return left;
}

}  // namespace grus::dem
