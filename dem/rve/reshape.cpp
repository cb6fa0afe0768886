// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/reshape.hpp"

#include <algorithm>

#include "dem/fracture/shape_transition.hpp"
#include "dem/fracture/swelling.hpp"

namespace grus::dem {
namespace {

/// Half the trapezoid of force times growth, at the forces of now.
double half_work(const Model& model, const Contacts& contacts, const std::vector<Growth>& growths) {
  double work = 0;
  for (const auto& growth : growths) {
    if (contacts.contact.touching(growth.contact))
      work += 0.5 * elastic_force(model.law, contacts, growth.contact) * growth.amount;
  }
  return work;
}

/// The shape that fragment i has next; none: it stays.
std::optional<PolyEllipsoid> next_of(const Model& model, const State& state, std::size_t i, double duration) {
  const Grains& g = state.grains;
  const Material& material = model.materials[g.material[i]];
  if (g.generation[i] == 0) return std::nullopt;
  if (material.fracture->transition) return next_shape(g.shape[i], *material.fracture->transition, duration);
  const double stiffness =
      stiffness_between(model.law, material.solid(), material.contact, g.extent[i].equivalent_radius);
  const auto radius = next_radius(g, i, material.density, stiffness, duration);
  if (!radius || mean_pressure(model.law, g, state.contacts, i) > state.grain_pressure) return std::nullopt;
  return PolyEllipsoid::sphere(*radius);
}

/// By how much any point of the surface moves at most, seen from the centre of mass (m).
double furthest_growth(const PolyEllipsoid& before, const PolyEllipsoid& after) {
  return (after.plus - before.plus).cwiseAbs().sum() * 1.75;  // support height, and centre of mass
}

}  // namespace

void reshape_fragments(const Model& model, State& state, double duration, Reshaping& now, Team& team) {
  Grains& g = state.grains;
  now.growths.clear(), now.furthest = 0;
  const bool swells = model.swells();
  if (g.frame.empty() && !swells) return;  // spheres only: nothing has split
  if (swells && state.steps % pressure_every == 0) state.grain_pressure = mean_pressure(model.law, g, state.contacts);
  now.held.assign(g.size(), 0);
  for_each_bond(state.bonds, [&](const auto& bond) {
    if (bond.keeps_whole) now.held[bond.ends.a] = now.held[bond.ends.b] = 1;
  });
  now.next.assign(g.size(), std::nullopt);
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Material& material = model.materials[g.material[i]];
      if (now.held[i] || !(material.swells() || (material.fracture && material.fracture->transition))) continue;
      now.next[i] = next_of(model, state, i, duration);
    }
  });
  double furthest = 0, swollen = 0;
  const Contacts& contacts = state.contacts;
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (!now.next[i]) continue;
    const PolyEllipsoid& next = *now.next[i];
    if (is_sphere(g, i) && next.is_sphere())
      swollen = std::max(swollen, next.plus.x() - g.shape[i].plus.x());
    else
      furthest = std::max(furthest, furthest_growth(g.shape[i], next));
    for (Index e = contacts.index.first[i]; e < contacts.index.first[i + 1]; ++e) {
      const std::size_t k = contacts.index.entry[e] >> 1;
      if (!contacts.contact.touching(k)) continue;
      const Vec3& n = contacts.touch[k].normal;
      const Vec3 outward = contacts.index.entry[e] & 1 ? Vec3(-n) : n;
      // At the least overlap the direction does not matter to first order: the overlap grows by the growth along it.
      const Mat3 axes = g.frame.empty() ? Mat3::Identity() : g.frame[i].axes;  // all the same to a sphere
      now.growths.push_back({k, growth(g.shape[i], next, axes.transpose() * outward)});
    }
    const Vec3 spin = g.motion[i].spin;
    const Mat3 inertia = inertia_tensor(g, i);
    set_shape(g, i, next);
    const Vec3& now_spin = g.motion[i].spin;
    const double put_in = -0.5 * spin.dot((inertia_tensor(g, i) - inertia) * now_spin);  // at the same angular momentum
    state.ledger.reshape += put_in;
    state.ledger.unexplained -= 0.5 * g.angular_momentum[i].dot(now_spin - spin) - put_in;
  }
  state.reference.grown += furthest, state.reference.travelled += swollen;
  now.furthest = std::max(furthest, swollen);
  state.ledger.reshape += half_work(model, contacts, now.growths);
}

void book_growth(const Model& model, State& state, const Reshaping& now) {
  state.ledger.reshape += half_work(model, state.contacts, now.growths);
}

}  // namespace grus::dem
