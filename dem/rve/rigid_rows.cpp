// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/rigid_rows.hpp"

#include <algorithm>

#include "dem/bond/bonds.hpp"
#include "dem/contact/deepest_contact.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/rve/cone_steps.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

constexpr double looked = 0.01;  // of the smaller radius: points so near are rows, however slowly they close
constexpr double safely = 2;     // the same of those that close in so many steps: others may push them

/// No two points of a pair close faster (m/s), unless others push them.
double fastest(const State& s, const Pair& p, bool walled, double fall) {
  const Motion& a = s.grains.motion[p.a];
  if (walled) return (a.velocity - s.boundary.walls[p.b].velocity).norm() + a.spin.norm() * a.radius + fall;
  const Motion& b = s.grains.motion[p.b];
  return (b.velocity + at_image(s.boundary.cell.rate, p.image) - a.velocity).norm() + a.spin.norm() * a.radius +
         b.spin.norm() * b.radius + fall;
}

/// The patch in the global frame, from the mass centre of a; `normal`: as it was, and as it is.
Patch patch_of(const State& s, const Pair& p, double reach, Vec3& normal) {
  const Grains& g = s.grains;
  const Overlap o = overlap_of_pair(g, s.boundary.cell, p, normal);
  const bool overlaps = presses(o);
  if (overlaps)
    normal = o.force.normalized();
  else if (!hulls_near(g, s.boundary.cell, {p.a, p.b, p.image}, reach, normal))
    return {};
  const Mat3 &axes = g.frame[p.a].axes, back = axes.transpose();
  const Vec3 apart = branch(g, s.boundary.cell, {p.a, p.b, p.image});
  Patch patch = patch_between((*g.hulls)[g.hull[p.a]], (*g.hulls)[g.hull[p.b]], back * g.frame[p.b].axes, back * apart,
                              back * normal, reach);
  for (std::size_t j = 0; j < patch.points; ++j) patch.point[j].at = axes * patch.point[j].at;
  // Edges that have gone through each other: their faces are not above each other, or part there.
  if (overlaps && (patch.points == 0 || patch.point[0].gap > 0))
    patch.point[0] = {o.middle, -o.volume / o.area.norm()}, patch.points = 1;
  return patch;
}

Patch patch_of(const State& s, Index grain, const Wall& wall, double reach, Vec3& normal) {
  const Grains& g = s.grains;
  const auto* plane = std::get_if<PlaneWall>(&wall.shape);
  if (!plane) return {};
  const Mat3& axes = g.frame[grain].axes;
  normal = -plane->normal;
  Patch patch = patch_on_plane(
      (*g.hulls)[g.hull[grain]],
      {axes.transpose() * plane->normal, plane->normal.dot(wall.point - g.motion[grain].position)}, reach);
  for (std::size_t j = 0; j < patch.points; ++j) patch.point[j].at = axes * patch.point[j].at;
  return patch;
}

/// The row of a point.
void add_row(const Model& model, const State& s, double dt, std::size_t k, const PatchPoint& point,
             RigidSystem& system) {
  const Pair& p = s.contacts.pair[k];
  const bool walled = k >= s.contacts.begin[first_wall];
  const Grains& g = s.grains;
  const Motion& a = g.motion[p.a];
  const Vec3& n = s.contacts.touch[k].normal;
  RigidPoint of{.pair = static_cast<Index>(k), .at = point.at};
  of.gap = point.gap + kept_overlap * smaller_radius(s.grains, p, walled);
  if (walled) of.driven = s.boundary.walls[p.b].velocity;
  if (!walled && crosses(p)) of.driven = at_image(s.boundary.cell.rate, p.image);
  ConeContact c{.a = p.a,
                .b = walled ? ConeContact::fixed : p.b,
                .normal = n,
                .across = n.unitOrthogonal(),
                .arm_a = point.at,
                .friction = model.pairs[p.law].friction[slide_spring]};
  Vec3 velocity = of.driven - a.velocity - a.spin.cross(c.arm_a);
  if (walled) {
    velocity -= dt * model.motion.gravity;  // two that fall do not meet faster
  } else {
    const Motion& b = g.motion[p.b];
    c.arm_b = point.at - branch(g, s.boundary.cell, {p.a, p.b, p.image});
    velocity += b.velocity + b.spin.cross(c.arm_b);
  }
  of.moved = along(c, velocity);
  c.free = of.moved;
  c.free[press_row] += std::max(of.gap, 0.0) / dt;
  const Vec3& force = s.contacts.touch[k].force;
  const double press = n.dot(force);
  if ((force - press * n).norm() > 0.99 * c.friction * press)
    c.slip = std::sqrt(of.moved[1] * of.moved[1] + of.moved[2] * of.moved[2]);
  system.contact.push_back(c), system.point.push_back(of);
}

}  // namespace

void fill(const Model& model, State& s, double dt, Team& team, RigidSystem& system) {
  Contacts& contacts = s.contacts;
  fill_bodies(s.grains, team, system.body);
  system.patch.resize(contacts.size());
  const double fall = dt * model.motion.gravity.norm();
  team.blocks(contacts.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Pair& p = contacts.pair[k];
      const bool walled = k >= contacts.begin[first_wall];
      const double reach =
          std::max(looked * smaller_radius(s.grains, p, walled), safely * dt * fastest(s, p, walled, fall));
      Vec3& normal = contacts.touch[k].normal;
      system.patch[k] = walled ? patch_of(s, p.a, s.boundary.walls[p.b], reach, normal) : patch_of(s, p, reach, normal);
    }
  });
  system.contact.clear(), system.point.clear();
  for (std::size_t k = 0; k < contacts.size(); ++k)
    for (std::size_t j = 0; j < system.patch[k].points; ++j) add_row(model, s, dt, k, system.patch[k].point[j], system);
}

}  // namespace grus::dem
