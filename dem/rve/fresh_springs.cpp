// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/fresh_springs.hpp"

#include "dem/bond/cohesive.hpp"

namespace grus::dem {
namespace {

/// Force on a child, and moment about the plane's centre, that its springs must supply.
std::pair<Vec3, Vec3> demand(const Grains& g, std::size_t child, const ParentMotion& parent) {
  const Vec3 d = g.motion[child].position - parent.position;
  const Vec3 a = parent.acceleration + parent.spin_rate.cross(d) + parent.spin.cross(parent.spin.cross(d));
  const Vec3 force = g.mass[child] * a - g.force[child];
  const Vec3 torque =
      inertia_tensor(g, child) * parent.spin_rate + parent.spin.cross(g.angular_momentum[child]) - g.torque[child];
  return {force, torque + (g.motion[child].position - parent.origin).cross(force)};
}

}  // namespace

ParentMotion motion_of(const Grains& g, std::size_t i) {
  const Frame frame = frame_of(g, i);
  const Vec3 spin = spin_of(g, i);
  return {g.motion[i].position,
          g.motion[i].inverse_mass * g.force[i],
          spin,
          inertia_tensor(g, i).inverse() * (g.torque[i] - spin.cross(g.angular_momentum[i])),
          frame.origin,
          frame.axes,
          g.extent[i].equivalent_radius};
}

/// Points of n springs around the middle of a plane, from the parent's octant origin, m.
std::vector<Vec3> points_on(const FreshPlane& plane, const ParentMotion& parent, int n) {
  std::vector<Vec3> at;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * pi * (k + 0.5) / n, c = std::cos(angle), s = std::sin(angle);
    const Vec3 p = 0.6 * c * (c >= 0 ? plane.u_plus : plane.u_minus) * plane.u +
                   0.6 * s * (s >= 0 ? plane.v_plus : plane.v_minus) * plane.v;
    at.emplace_back(parent.axes * p);
  }
  return at;
}

double add_springs(const Model& model, State& state, const ParentMotion& parent, const FreshPlane& plane,
                   std::span<const std::size_t> slots) {
  const Grains& g = state.grains;
  const std::size_t plus = slots[plane.above], minus = slots[plane.below];
  const Material& material = model.materials[g.material[plus]];
  const CohesiveSprings& options = *material.fracture->springs;
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  const int n = options.per_plane;
  const double area = plane.area(), radius = parent.radius;
  const double energy = options.toughness * options.toughness * (1 - nu * nu) / E * area / n;  // G_c A of one spring

  // Springs act from the piece below (a) on the one above (b); unknown forces on b at points of the plane, least norm.
  const auto [fp, mp] = demand(g, plus, parent);
  const auto [fm, mm] = demand(g, minus, parent);
  Vec6 target;
  target << 0.5 * (fp - fm), 0.5 * (mp - mm) / radius;
  state.ledger.residual_force += 0.5 * (fp + fm).norm();
  const std::vector<Vec3> at = points_on(plane, parent, n);
  Eigen::MatrixXd balance(6, 3 * n);
  for (int k = 0; k < n; ++k) {
    balance.block<3, 3>(0, 3 * k).setIdentity();
    balance.block<3, 3>(3, 3 * k) = cross_matrix(at[static_cast<std::size_t>(k)]) / radius;
  }
  const Eigen::VectorXd forces = balance.completeOrthogonalDecomposition().solve(target);

  const Vec3& normal = plane.normal;  // geometry frame
  double held = 0;
  for (int k = 0; k < n; ++k) {
    Vec3 force = parent.axes.transpose() * forces.segment<3>(3 * k);  // on the piece above, geometry frame
    const double push = force.dot(normal);
    if (push > 0) {  // the pieces press on each other: the contact's work, not the spring's
      force -= push * normal;
      state.ledger.residual_force += push;
    }
    const double stiffest = options.stiffness_ratio *
                            reduced_modulus(model.pairs[g.material[plus] * (model.materials.size() + 1)]) * radius;
    const double softest_peak = 2 * energy / (options.max_opening * radius);
    CohesiveSpring s;
    s.ends = {static_cast<Index>(minus), static_cast<Index>(plus), {}};
    // A spring of peak f and energy G has stiffness >= f^2 / G: the peak is capped where that meets the stiffest.
    s.peak = std::max(softest_peak, std::min(force.norm(), stiffest > 0 ? std::sqrt(stiffest * energy) : force.norm()));
    s.rupture = 2 * energy / s.peak;
    s.onset = stiffest > 0 ? std::clamp(s.peak / stiffest, 0.05 * s.rupture, 0.5 * s.rupture) : 0.05 * s.rupture;
    s.reached = s.onset;
    if (force.norm() > s.peak) {
      state.ledger.residual_force += force.norm() - s.peak;
      force *= s.peak / force.norm();
    }
    s.preload = -force * (s.onset / s.peak);  // force on b = -stiffness * opening
    s.normal_a = normal;
    const Vec3 point = parent.origin + at[static_cast<std::size_t>(k)];
    s.at_a = g.orientation[minus].conjugate() * (point - g.motion[minus].position);
    s.at_b = g.orientation[plus].conjugate() * (point - g.motion[plus].position);
    held += energy_at_birth(s);
    state.bonds.cohesive.row.push_back(s);
  }
  state.ledger.fracture_area += area;
  return held;
}

}  // namespace grus::dem
