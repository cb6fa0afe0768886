// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/cone_rows.hpp"

#include <algorithm>

#include "dem/bond/bonds.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/rve/cone_steps.hpp"
#include "dem/state/images.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

/// How a contact lies, and how it resists: what the laws do not say.
struct Place {
  Vec3 arm_a, arm_b;                 // from the mass centres (m)
  double more = 1;                   // slope of the force over the law's
  double spin_arm = 0, rocking = 0;  // m; N m
  Vec3 couple = Vec3::Zero();        // elastic, on b about the contact (N m)
  bool presses = true;
};

Place place_of(const State& s, std::size_t k, bool walled) {
  const Grains& g = s.grains;
  const Pair& p = s.contacts.pair[k];
  const Vec3& n = s.contacts.touch[k].normal;
  const Vec3 apart = walled ? Vec3(Vec3::Zero()) : branch(g, s.boundary.cell, {p.a, p.b, p.image});
  if (g.kind[p.a] != ShapeKind::hull) {
    Place at;
    at.arm_a = surface_arm(g, p.a, n);
    at.arm_b = walled ? Vec3(Vec3::Zero()) : surface_arm(g, p.b, -n);
    return at;
  }
  const Overlap o = walled ? overlap_at_wall(g, s.boundary.walls[p.b], p.a)
                           : overlap_of_pair(g, s.boundary.cell, p, s.contacts.touch[k].normal);
  Place at;
  at.presses = presses(o);
  if (!at.presses) return at;
  const double modulus = s.contacts.contact.radius[k];
  at.arm_a = o.middle, at.arm_b = o.middle - apart;
  at.more = sharpness(o.volume, o.force.norm());
  at.spin_arm = std::min(std::sqrt(o.polar / o.area.norm()), g.motion[p.a].radius);
  at.rocking = at.more * modulus * 0.5 * o.polar;
  at.couple = modulus * (o.moment - o.middle.cross(o.force));
  return at;
}

/// The rows of a touching pair; false: it presses nowhere.
bool rows_of(const Model& model, const State& s, double dt, std::size_t row, ConeSystem& system) {
  ConeContact& c = system.contact[row];
  HeldContact& of = system.held[row];
  const std::size_t k = of.pair;
  const Grains& g = s.grains;
  const Pair& p = s.contacts.pair[k];
  const bool walled = k >= s.contacts.begin[first_wall];
  const PairLaw& law = model.pairs[p.law];
  const Contact now = s.contacts.contact[k];
  const Place at = place_of(s, k, walled);
  if (!at.presses) return false;
  const Elastic elastic =
      std::visit([&](const auto& l) { return Elastic(l(now, s.contacts.touch[k].overlap)); }, model.law);
  const Vec3& n = s.contacts.touch[k].normal;
  const Motion& a = g.motion[p.a];
  const bool hull = g.kind[p.a] == ShapeKind::hull;
  Vec3 spin = -a.spin, driven = Vec3::Zero();
  double lightness = hull ? mobility(g, p.a, at.arm_a, n) : a.inverse_mass;  // of what a dashpot's blow meets (1/kg)
  if (walled) driven = s.boundary.walls[p.b].velocity;
  if (crosses(p)) driven = at_image(s.boundary.cell.rate, p.image);
  Vec3 velocity = driven - a.velocity - a.spin.cross(at.arm_a);
  if (!walled) {
    const Motion& b = g.motion[p.b];
    velocity += b.velocity + b.spin.cross(at.arm_b), spin += b.spin;
    lightness += hull ? mobility(g, p.b, at.arm_b, n) : b.inverse_mass;
  }
  c = {.a = p.a,
       .b = walled ? ConeContact::fixed : p.b,
       .normal = n,
       .across = n.unitOrthogonal(),
       .arm_a = at.arm_a,
       .arm_b = at.arm_b,
       .friction = law.friction[slide_spring],
       .spin_arm = law.friction[slide_spring] > 0 ? at.spin_arm : 0,
       .rocks = at.rocking > 0};
  const Vec3 third = n.cross(c.across);
  const double dashpot = law.dashpot > 0 ? law.dashpot * std::sqrt(elastic.grip / lightness) : 0;
  of.energy = hull ? s.contacts.touch[k].held : elastic.energy, of.viscous = now.viscous, of.driven = driven;
  const double press = at.more * elastic.normal_stiffness + dashpot / dt, slide = law.shear_ratio * elastic.grip;
  const Vec3 spring = now.spring[slide_spring];
  ConeRows &held = of.held, &moved = of.moved;
  held = {elastic.force, c.across.dot(spring),    third.dot(spring),
          n.dot(spring), c.across.dot(at.couple), third.dot(at.couple)};
  moved = {n.dot(velocity),          c.across.dot(velocity), third.dot(velocity),
           c.spin_arm * n.dot(spin), c.across.dot(spin),     third.dot(spin)};
  if (spring.norm() > 0.99 * c.friction * (elastic.force + now.viscous))
    c.slip = std::sqrt(moved[1] * moved[1] + moved[2] * moved[2] + moved[3] * moved[3]);
  c.compliance.fill(1 / (std::max(slide, 1e-300) * dt * dt));
  c.compliance[press_row] = 1 / (press * dt * dt);
  if (c.rocks)
    c.compliance[rock_row] = c.compliance[rock_row + 1] = 1 / (at.rocking * dt * dt);
  else
    held[rock_row] = held[rock_row + 1] = moved[rock_row] = moved[rock_row + 1] = 0;
  if (c.friction == 0)  // no spring: rows that the cone keeps at nothing
    for (std::size_t j = slide_row; j <= spin_row; ++j) c.compliance[j] = held[j] = 0;
  if (c.spin_arm == 0) held[spin_row] = 0;
  for (std::size_t j = 0; j < cone_rows; ++j) c.free[j] = moved[j] - held[j] * dt * c.compliance[j];
  return true;
}

}  // namespace

void fill(const Model& model, const State& s, double dt, Team& team, ConeSystem& system) {
  fill_bodies(s.grains, team, system.body);
  system.held.clear();
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) system.held.push_back({.pair = static_cast<Index>(k)});
  const std::size_t n = system.held.size();
  system.contact.resize(n), system.presses.resize(n);
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) system.presses[row] = rows_of(model, s, dt, row, system);
  });
  std::size_t kept = 0;
  for (std::size_t row = 0; row < n; ++row)
    if (system.presses[row]) system.contact[kept] = system.contact[row], system.held[kept] = system.held[row], ++kept;
  system.contact.resize(kept), system.held.resize(kept);
}

}  // namespace grus::dem
