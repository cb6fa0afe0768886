// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/forces.hpp"

#include <algorithm>

#include "dem/shape/common_normal.hpp"

namespace grus::dem {
namespace {

struct Scene {
  const Grains& grains;
  const Boundary& boundary;
  std::span<const PairLaw> pairs;
  double dt;
  bool periodic;

  Vec3 shift(const Pair& p) const { return boundary.cell.vectors * Vec3(p.image[0], p.image[1], p.image[2]); }
  Vec3 shift_rate(const Pair& p) const { return boundary.cell.rate * Vec3(p.image[0], p.image[1], p.image[2]); }
};

inline bool crosses(const Pair& p) { return (p.image[0] | p.image[1] | p.image[2]) != 0; }

inline void apart(Contact& c, ContactForce& f, BlockEnergy& e) {
  if (c.stiffness > 0) part_contact(c, e);
  f.force.setZero(), f.torque_a.setZero(), f.torque_b.setZero();
}

template <class Law>
void begin_contact(const Law& law, const PairLaw& p, double radius, double volume_radius, double ellipse, Contact& c) {
  c.radius = std::clamp(radius, 0.1 * volume_radius, 4 * volume_radius);
  c.stiffness = law.stiffness_at_birth(p, c.radius);
  if constexpr (std::is_same_v<Law, HertzMindlin>) c.stiffness *= ellipse;
}

/// Force, both torques, and the work of a moving boundary on the pair (the boundary moves b by `drag`).
inline void set_force(ContactForce& f, const Vec3& force, const Vec3& arm_a, const Vec3& arm_b) {
  f.force = force;
  f.torque_a = force.cross(arm_a);  // arm x (-force)
  f.torque_b = arm_b.cross(force);
}

template <class Law>
void sphere_pairs(const Law& law, const Scene& s, Contacts& contacts, std::size_t begin, std::size_t end, BlockEnergy& e) {
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    Contact& c = contacts.contact[k];
    ContactForce& f = contacts.force[k];
    const Motion &a = s.grains.motion[pair.a], &b = s.grains.motion[pair.b];
    Vec3 d = b.position - a.position;
    const bool across = s.periodic && crosses(pair);
    if (across) d += s.shift(pair);
    const double sum = a.radius + b.radius, d2 = d.squaredNorm();
    Vec3 drag = Vec3::Zero();
    if (across) {
      drag = s.shift_rate(pair);
      e.work -= 0.5 * s.dt * f.force.dot(drag);
    }
    if (!(d2 < sum * sum)) {
      apart(c, f, e);
      continue;
    }
    const double distance = std::sqrt(d2), overlap = sum - distance;
    const Vec3 n = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
    const PairLaw& p = s.pairs[pair.law];
    if (c.stiffness == 0) {
      const double r = a.radius * b.radius / sum;
      begin_contact(law, p, r, r, 1, c);
    }
    const double la = a.radius - 0.5 * overlap, lb = b.radius - 0.5 * overlap;
    const Vec3 v = b.velocity + drag - a.velocity - (la * a.spin + lb * b.spin).cross(n);
    const Vec3 force = advance_contact(law, p, c, n, overlap, v, 0.5 * n.dot(a.spin + b.spin), s.dt, e);
    set_force(f, force, la * n, -lb * n);
    if (across) e.work -= 0.5 * s.dt * force.dot(drag);
  }
}

template <class Law>
void general_pairs(const Law& law, const Scene& s, Contacts& contacts, std::size_t begin, std::size_t end, BlockEnergy& e) {
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    Contact& c = contacts.contact[k];
    ContactForce& f = contacts.force[k];
    const Frame &fa = s.grains.frame[pair.a], &fb = s.grains.frame[pair.b];
    const bool across = s.periodic && crosses(pair);
    Vec3 r = fb.origin - fa.origin, drag = Vec3::Zero();
    if (across) {
      r += s.shift(pair);
      drag = s.shift_rate(pair);
      e.work -= 0.5 * s.dt * f.force.dot(drag);
    }
    const Vec3 cached = fa.axes.transpose() * c.normal;
    const ShapePair shapes{s.grains.shape[pair.a], s.grains.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
    if (c.stiffness == 0 && separation_test(shapes, cached) < 0) {  // the common case of a near pair that stays apart
      apart(c, f, e);
      continue;
    }
    CommonNormal found = warm_common_normal(shapes, cached);
    if (c.stiffness == 0 && found.overlap > 0) {  // a new contact is checked from scratch: a trap of the warm start shows here
      const CommonNormal fresh = cold_common_normal(shapes);
      if (fresh.overlap < found.overlap) found = fresh;
    }
    if (!(found.overlap > 0)) {
      c.normal = fa.axes * found.normal;
      apart(c, f, e);
      continue;
    }
    const PairLaw& p = s.pairs[pair.law];
    if (c.stiffness == 0) {
      const ContactCurvature curvature = contact_curvature(shapes, found.normal);
      const double ra = equivalent_radius(shapes.a), rb = equivalent_radius(shapes.b);
      begin_contact(law, p, curvature.radius, ra * rb / (ra + rb), curvature.ellipse_factor, c);
    }
    const Motion &a = s.grains.motion[pair.a], &b = s.grains.motion[pair.b];
    const Vec3 n = fa.axes * found.normal;
    const Vec3 point = fa.origin + fa.axes * (0.5 * (found.point_a + found.point_b));
    const Vec3 arm_a = point - a.position;
    Vec3 arm_b = point - b.position;
    if (across) arm_b -= s.shift(pair);
    const Vec3 v = b.velocity + drag + b.spin.cross(arm_b) - a.velocity - a.spin.cross(arm_a);
    const Vec3 force = advance_contact(law, p, c, n, found.overlap, v, 0.5 * n.dot(a.spin + b.spin), s.dt, e);
    set_force(f, force, arm_a, arm_b);
    if (across) e.work -= 0.5 * s.dt * force.dot(drag);
  }
}

template <bool round, class Law>
void wall_pairs(const Law& law, const Scene& s, Contacts& contacts, std::size_t begin, std::size_t end, BlockEnergy& e) {
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    Contact& c = contacts.contact[k];
    ContactForce& f = contacts.force[k];
    const Motion& a = s.grains.motion[pair.a];
    const Wall& wall = s.boundary.walls[pair.b];
    const Vec3 n = -wall.normal;
    e.work -= 0.5 * s.dt * f.force.dot(wall.velocity);
    double overlap;
    Vec3 arm, d;
    if constexpr (round) {
      overlap = a.radius - wall.normal.dot(a.position - wall.point);
      if (!(overlap > 0)) {
        apart(c, f, e);
        continue;
      }
      arm = (a.radius - 0.5 * overlap) * n;
    } else {
      const Frame& frame = s.grains.frame[pair.a];
      d = frame.axes.transpose() * n;
      const Vec3 tip = frame.origin + frame.axes * support(s.grains.shape[pair.a], d);
      overlap = wall.normal.dot(wall.point - tip);
      if (!(overlap > 0)) {
        apart(c, f, e);
        continue;
      }
      arm = tip - 0.5 * overlap * n - a.position;
    }
    const PairLaw& p = s.pairs[pair.law];
    if (c.stiffness == 0) {
      if constexpr (round) {
        begin_contact(law, p, a.radius, a.radius, 1, c);
      } else {
        const ContactCurvature curvature = plane_curvature(s.grains.shape[pair.a], d);
        begin_contact(law, p, curvature.radius, equivalent_radius(s.grains.shape[pair.a]), curvature.ellipse_factor, c);
      }
    }
    const Vec3 v = wall.velocity - a.velocity - a.spin.cross(arm);
    const Vec3 force = advance_contact(law, p, c, n, overlap, v, 0.5 * n.dot(a.spin), s.dt, e);
    set_force(f, force, arm, Vec3::Zero());
    e.work -= 0.5 * s.dt * force.dot(wall.velocity);
  }
}

template <class Law>
void block(const Law& law, const Scene& s, Contacts& contacts, std::size_t begin, std::size_t end, BlockEnergy& e) {
  auto part = [&](Bin bin, auto&& loop) {
    const std::size_t b = std::max(begin, contacts.begin[bin]), t = std::min(end, contacts.begin[bin + 1]);
    if (b < t) loop(law, s, contacts, b, t, e);
  };
  part(sphere_sphere, sphere_pairs<Law>);
  part(general, general_pairs<Law>);
  part(sphere_wall, wall_pairs<true, Law>);
  part(polyellipsoid_wall, wall_pairs<false, Law>);
}

}  // namespace

void contact_forces(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains, const Boundary& boundary,
                    double dt, Contacts& contacts, Team& team) {
  if (contacts.energy.size() < block_count(contacts.size())) contacts.energy.resize(block_count(contacts.size()));
  const Scene scene{grains, boundary, pairs, dt, boundary.cell.periodic()};
  std::visit(
      [&](const auto& l) {
        team.blocks(contacts.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t b = begin; b < end; b += block_size)
            block(l, scene, contacts, b, std::min(end, b + block_size), contacts.energy[b / block_size]);
        });
      },
      law);
}

BlockEnergy flush(Contacts& contacts) {
  BlockEnergy sum;
  for (auto& e : contacts.energy) {
    sum.friction += e.friction, sum.viscous += e.viscous, sum.work += e.work;
    e = {};
  }
  return sum;
}

void sum_wall_forces(const Contacts& contacts, Boundary& boundary) {
  for (auto& wall : boundary.walls) wall.force.setZero();
  for (std::size_t k = contacts.begin[sphere_wall]; k < contacts.begin[bin_count]; ++k)
    boundary.walls[contacts.pair[k].b].force += contacts.force[k].force;
}

double elastic_energy(const ContactLaw& law, const Contacts& contacts) {
  double sum = 0;
  std::visit([&](const auto& l) { for (const auto& c : contacts.contact) sum += elastic_energy(l, c); }, law);
  return sum;
}

DeepestContact deepest_contact(const Grains& grains, const Contacts& contacts) {
  DeepestContact deepest;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Contact& c = contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const Pair& p = contacts.pair[k];
    double r = equivalent_radius(grains.shape[p.a]);
    if (k < contacts.begin[sphere_wall]) r = std::min(r, equivalent_radius(grains.shape[p.b]));
    if (c.overlap > deepest.ratio * r) deepest = {c.overlap / r, k};
  }
  return deepest;
}

}  // namespace grus::dem
