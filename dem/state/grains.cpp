// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/grains.hpp"

namespace grus::dem {

void set_grain(Grains& g, std::size_t i, const GrainSpec& spec) {
  if (i == g.size()) {
    for_each_column(g, [&](auto& column) {
      const bool optional =
          static_cast<const void*>(&column) == &g.frame || static_cast<const void*>(&column) == &g.strength ||
          static_cast<const void*>(&column) == &g.generation || static_cast<const void*>(&column) == &g.utilisation;
      if (!optional || !column.empty()) column.emplace_back();
    });
  }
  const double m = spec.density * volume(spec.shape);
  const PrincipalFrame principal = principal_frame(spec.shape);
  g.motion[i] = {spec.position, bounding_radius(spec.shape),    spec.velocity, 1 / m,
                 spec.spin,     1 / (m * principal.moments.x())};
  g.orientation[i] = spec.orientation.normalized();
  g.mass[i] = m;
  g.inertia[i] = {m * principal.moments, principal.axes};
  g.shape[i] = spec.shape;
  g.round[i] = spec.shape.is_sphere();
  g.material[i] = spec.material;
  g.id[i] = g.next_id++;
  g.force[i] = g.torque[i] = Vec3::Zero();
  g.angular_momentum[i] = inertia_tensor(g, i) * spec.spin;
}

void set_shape(Grains& g, std::size_t i, const PolyEllipsoid& shape) {
  const PrincipalFrame principal = principal_frame(shape);
  g.shape[i] = shape;
  g.round[i] = shape.is_sphere();
  g.inertia[i] = {g.mass[i] * principal.moments, principal.axes};
  g.motion[i].radius = bounding_radius(shape);
  g.motion[i].inverse_inertia = 1 / g.inertia[i].moments.x();
  g.motion[i].spin = spin_of(g, i);
  if (!g.frame.empty()) g.frame[i] = frame_of(g, i);
}

Frame frame_of(const Grains& g, std::size_t i) {
  const Mat3 axes = g.orientation[i].toRotationMatrix();
  return {g.motion[i].position - axes * centre_of_mass(g.shape[i]), axes};
}

void update_frames(Grains& g) {
  bool all_round = true;
  for (auto round : g.round) all_round = all_round && round;
  if (all_round) return g.frame.clear();
  g.frame.resize(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) g.frame[i] = frame_of(g, i);
}

Vec3 spin_of(const Grains& g, std::size_t i) {
  if (g.round[i]) return g.angular_momentum[i] * g.motion[i].inverse_inertia;
  const Quat q = g.orientation[i] * g.inertia[i].axes;
  const Vec3 p = q.conjugate() * g.angular_momentum[i];
  return q * p.cwiseQuotient(g.inertia[i].moments);
}

Vec3 surface_arm(const Grains& g, std::size_t i, const Vec3& outward) {
  if (g.round[i]) return g.motion[i].radius * outward;
  const Mat3& axes = g.frame[i].axes;
  return g.frame[i].origin + axes * support(g.shape[i], axes.transpose() * outward) - g.motion[i].position;
}

Mat3 inertia_tensor(const Grains& g, std::size_t i) {
  const Mat3 r = (g.orientation[i] * g.inertia[i].axes).toRotationMatrix();
  return r * g.inertia[i].moments.asDiagonal() * r.transpose();
}

double kinetic_energy(const Grains& g) {
  double sum = 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    sum += 0.5 * (g.mass[i] * g.motion[i].velocity.squaredNorm() + g.angular_momentum[i].dot(spin_of(g, i)));
  return sum;
}

double total_mass(const Grains& g) {
  double sum = 0;
  for (double m : g.mass) sum += m;
  return sum;
}

double solid_volume(const Grains& g) {
  double sum = 0;
  for (const auto& shape : g.shape) sum += volume(shape);
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
