// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/resting.hpp"

#include "dem/contact/forces.hpp"
#include "dem/rve/bonded.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

/// Contacts that touch, bin by bin in the order of the list; of bodies with the normal, where searches go on.
Contacts touching(const Contacts& c, bool bodies) {
  Contacts kept;
  kept.spots = c.spots;
  std::size_t count = 0;
  for (std::size_t k = 0; k < c.size(); ++k) count += c.contact.touching(k);
  kept.pair.reserve(count);
  if (bodies) kept.resting_normal.reserve(count);
  kept.contact.rolls = c.contact.rolls;
  for_each_contact_column(kept.contact, [&](auto& column) { column.resize(count); });
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    kept.begin[bin] = kept.pair.size();
    for (std::size_t k = c.begin[bin]; k < c.begin[bin + 1]; ++k) {
      if (!c.contact.touching(k)) continue;
      kept.contact.set(kept.pair.size(), c.contact[k]);
      kept.pair.push_back(c.pair[k]);
      if (bodies) kept.resting_normal.push_back(c.touch[k].normal);
    }
  }
  kept.begin[bin_count] = count;
  return kept;
}

}  // namespace

State at_rest(State s) {
  if (s.resting) return s;
  Grains& g = s.grains;
  const bool round = g.frame.empty();
  s.contacts = touching(s.contacts, !round);
  drop(g.inertia), drop(g.extent), drop(g.frame), drop(g.force), drop(g.torque);
  if (round) drop(g.shape), drop(g.angular_momentum);
  for_each_kind(s.bonds, [](auto& column) { column.tiles = {}; });
  NeighbourReference waiting;
  waiting.builds = s.reference.builds;
  s.reference = std::move(waiting);
  drop(s.grain_energy), drop(s.break_room);
  s.grain_bonds = {};
  s.resting = true;
  return s;
}

void awaken(const Model& model, State& s, Team& team) {
  if (!s.resting) return;
  s.resting = false;
  Grains& g = s.grains;
  Contacts& c = s.contacts;
  const std::size_t n = g.size();
  if (g.shape.empty())
    for (const Motion& m : g.motion) g.shape.push_back(PolyEllipsoid::sphere(m.radius));
  g.inertia.resize(n), g.extent.resize(n);
  for (auto* column : {&g.force, &g.torque, &g.angular_momentum}) column->resize(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) restore_shape(g, i);
  update_frames(g);
  if (model.swells()) s.reference.radius.resize(n);
  s.reference.position.resize(n);  // of as many grains as the list before
  c.touch.resize(c.size());
  for (std::size_t k = 0; k < c.resting_normal.size(); ++k) c.touch[k].normal = c.resting_normal[k];
  drop(c.resting_normal);
  s.listed_at = s.steps;
  note_bonded(s);
  build_contacts(g, s.boundary, s.skin, model.materials.size(), {}, c, s.reference, team);
  take_over(s);
  book(refresh_forces(model, s, team), s.ledger);
}

}  // namespace grus::dem
