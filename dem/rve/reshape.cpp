// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/reshape.hpp"

#include <algorithm>

#include "dem/fracture/shape_transition.hpp"

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

}  // namespace

void reshape_fragments(const Model& model, State& state, double duration, Reshaping& now, Team& team) {
  Grains& g = state.grains;
  now.growths.clear();
  if (g.frame.empty()) return;  // spheres only: nothing has split
  now.held.assign(g.size(), 0);
  for_each_bond(state.bonds, [&](const auto& bond) {
    if (bond.keeps_whole) now.held[bond.ends.a] = now.held[bond.ends.b] = 1;
  });
  now.next.assign(g.size(), std::nullopt);
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto& fracture = model.materials[g.material[i]].fracture;
      if (fracture && fracture->transition && g.generation[i] > 0 && !now.held[i])
        now.next[i] = next_shape(g.shape[i], *fracture->transition, duration);
    }
  });
  double furthest = 0;
  const Contacts& contacts = state.contacts;
  for (std::size_t i = 0; i < g.size(); ++i) {
    if (!now.next[i]) continue;
    const PolyEllipsoid& next = *now.next[i];
    furthest = std::max(furthest,
                        (next.plus - g.shape[i].plus).cwiseAbs().sum() * 1.75);  // support height, and centre of mass
    for (Index e = contacts.first[i]; e < contacts.first[i + 1]; ++e) {
      const std::size_t k = contacts.entry[e] >> 1;
      if (!contacts.contact.touching(k)) continue;
      const Vec3& n = contacts.touch[k].normal;
      const Vec3 outward = contacts.entry[e] & 1 ? Vec3(-n) : n;
      // At the least overlap the direction does not matter to first order: the overlap grows by the growth along it.
      now.growths.push_back({k, growth(g.shape[i], next, g.frame[i].axes.transpose() * outward)});
    }
    const Vec3 spin = g.motion[i].spin;
    const Mat3 inertia = inertia_tensor(g, i);
    set_shape(g, i, next);
    const Vec3& now_spin = g.motion[i].spin;
    const double put_in = -0.5 * spin.dot((inertia_tensor(g, i) - inertia) * now_spin);  // at the same angular momentum
    state.ledger.reshape += put_in;
    state.ledger.unexplained -= 0.5 * g.angular_momentum[i].dot(now_spin - spin) - put_in;
  }
  state.reference.grown += furthest;
  state.ledger.reshape += half_work(model, contacts, now.growths);
}

void book_growth(const Model& model, State& state, const Reshaping& now) {
  state.ledger.reshape += half_work(model, state.contacts, now.growths);
}

}  // namespace grus::dem
