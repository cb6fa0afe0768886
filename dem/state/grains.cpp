// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/grains.hpp"

#include <algorithm>
#include <array>

namespace grus::dem {
namespace {

/// All columns that follow from the hull and the mass.
void put_hull(Grains& g, std::size_t i, Index hull) {
  const HullRow& row = g.hulls->row[hull];
  const double radius = std::cbrt(0.75 / pi * row.volume), m = turn_mass(g, i);
  g.hull[i] = hull;
  g.shape[i] = PolyEllipsoid::sphere(radius);
  g.kind[i] = ShapeKind::hull;
  g.extent[i] = {row.volume, radius, row.least_width};
  g.inertia[i] = {m * row.principal.moments, row.principal.axes};
  g.motion[i].radius = row.bounding_radius;
  g.motion[i].inverse_inertia = 1 / (m * row.principal.moments.x());
}

/// All columns that follow from the shape and the mass.
void put_shape(Grains& g, std::size_t i, const PolyEllipsoid& shape) {
  const PrincipalFrame principal = principal_frame(shape);
  const double m = turn_mass(g, i);
  g.shape[i] = shape;
  g.kind[i] = shape.is_sphere() ? ShapeKind::sphere : ShapeKind::polyellipsoid;
  g.extent[i] = {volume(shape), equivalent_radius(shape), (shape.plus + shape.minus).minCoeff()};
  g.inertia[i] = {m * principal.moments, principal.axes};
  g.motion[i].radius = bounding_radius(shape);
  g.motion[i].inverse_inertia = 1 / (m * principal.moments.x());
}

}  // namespace

void set_grain(Grains& g, std::size_t i, const GrainSpec& spec) {
  if (i == g.size()) {
    for_each_column(g, [&](auto& column) {
      const std::array<const void*, 10> optional{&g.frame,      &g.strength, &g.generation, &g.utilisation, &g.born,
                                                 &g.solid_mass, &g.hull,     &g.crystal,    &g.turn_mass,   &g.held};
      const bool may_be_empty = std::find(optional.begin(), optional.end(), &column) != optional.end();
      if (!may_be_empty || !column.empty()) column.emplace_back();
    });
  }
  if (spec.hull) g.hull.resize(g.size());
  const double room = spec.hull ? g.hulls->row[*spec.hull].volume : volume(spec.shape);
  const double solid = spec.density * room, m = spec.inertia * solid;
  if (spec.inertia != 1 && g.solid_mass.empty()) g.solid_mass = g.mass;
  if (!g.solid_mass.empty()) g.solid_mass[i] = solid;
  g.motion[i] = {spec.position, 0, spec.velocity, 1 / m, spec.spin, 0};
  g.orientation[i] = spec.orientation.normalized();
  g.mass[i] = m;
  if (!g.turn_mass.empty()) g.turn_mass[i] = m;
  if (spec.hull)
    put_hull(g, i, *spec.hull);
  else
    put_shape(g, i, spec.shape);
  if (spec.crystal) g.crystal[i] = *spec.crystal;
  if (!spec.turns) g.motion[i].inverse_inertia = 0;
  g.material[i] = spec.material;
  g.id[i] = g.next_id++;
  g.force[i] = g.torque[i] = Vec3::Zero();
  g.angular_momentum[i] = spec.turns ? Vec3(inertia_tensor(g, i) * spec.spin) : Vec3::Zero();
}

void restore_shape(Grains& g, std::size_t i) {
  const bool turns = g.motion[i].inverse_inertia > 0;
  if (g.hull.empty())
    put_shape(g, i, PolyEllipsoid(g.shape[i]));
  else
    put_hull(g, i, g.hull[i]);
  if (!turns) g.motion[i].inverse_inertia = 0;
}

void set_inertia(Grains& g, std::size_t i, double mass, double turning) {
  if (g.motion[i].inverse_mass == 0) return;  // of a rough wall
  if (g.solid_mass.empty()) g.solid_mass = g.mass;
  if (g.turn_mass.empty()) g.turn_mass = g.mass;
  g.angular_momentum[i] *= turning / g.turn_mass[i];
  g.mass[i] = mass, g.turn_mass[i] = turning;
  g.motion[i].inverse_mass = 1 / mass;
  restore_shape(g, i);
}

void set_shape(Grains& g, std::size_t i, const PolyEllipsoid& shape) {
  const bool turns = g.motion[i].inverse_inertia > 0;
  if (is_sphere(g, i) && turns)  // steps in the middle of a run keep the spin alone
    g.angular_momentum[i] = g.motion[i].spin / g.motion[i].inverse_inertia;
  g.shape[i] = shape;
  restore_shape(g, i);
  g.motion[i].spin = spin_of(g, i);
  if (!g.frame.empty()) g.frame[i] = frame_of(g, i);
}

Frame frame_of(const Grains& g, std::size_t i) {
  const Mat3 axes = g.orientation[i].toRotationMatrix();
  return {g.motion[i].position - axes * centre_of_mass(g.shape[i]), axes};
}

void update_frames(Grains& g) {
  bool spheres = true;
  for (const ShapeKind kind : g.kind) spheres = spheres && kind == ShapeKind::sphere;
  if (spheres) return g.frame.clear();
  g.frame.resize(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) g.frame[i] = frame_of(g, i);
}

Vec3 spin_of(const Grains& g, std::size_t i) {
  if (is_sphere(g, i)) return g.angular_momentum[i] * g.motion[i].inverse_inertia;
  const Quat q = g.orientation[i] * g.inertia[i].axes;
  const Vec3 p = q.conjugate() * g.angular_momentum[i];
  return q * p.cwiseQuotient(g.inertia[i].moments);
}

Mat3 inertia_tensor(const Grains& g, std::size_t i) {
  const Mat3 r = (g.orientation[i] * g.inertia[i].axes).toRotationMatrix();
  return r * g.inertia[i].moments.asDiagonal() * r.transpose();
}

double kinetic_energy(const Grains& g, std::size_t i) {
  return 0.5 * (g.mass[i] * g.motion[i].velocity.squaredNorm() + g.angular_momentum[i].dot(spin_of(g, i)));
}

double kinetic_energy(const Grains& g) {
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i) sum += kinetic_energy(g, i);
  return sum;
}

double total_mass(const Grains& g) {
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i) sum += solid_mass(g, i);
  return sum;
}

double solid_volume(const Grains& g) {
  double sum = 0;
  for (const Extent& e : g.extent) sum += e.volume;
  return sum;
}

Vec3 momentum(const Grains& g) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < g.size(); ++i) sum += g.mass[i] * g.motion[i].velocity;
  return sum;
}

Vec3 angular_momentum(const Grains& g) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < g.size(); ++i)
    sum += g.angular_momentum[i] + g.mass[i] * g.motion[i].position.cross(g.motion[i].velocity);
  return sum;
}

}  // namespace grus::dem
