// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/resting.hpp"

#include "dem/contact/forces.hpp"
#include "dem/rve/hand_over.hpp"
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
  kept.contact.keep_as(c.contact);
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

/// Exchanges what a resting state does without.
void exchange(State& s, State& aside, bool round) {
  Grains &g = s.grains, &other = aside.grains;
  std::swap(g.inertia, other.inertia), std::swap(g.extent, other.extent), std::swap(g.frame, other.frame);
  std::swap(g.force, other.force), std::swap(g.torque, other.torque);
  if (round) std::swap(g.shape, other.shape), std::swap(g.angular_momentum, other.angular_momentum);
  std::swap(s.contacts, aside.contacts), std::swap(s.reference, aside.reference);
  std::swap(s.bonds.cohesive.tiles, aside.bonds.cohesive.tiles), std::swap(s.bonds.face.tiles, aside.bonds.face.tiles);
  std::swap(s.grain_energy, aside.grain_energy), std::swap(s.break_room, aside.break_room);
}

}  // namespace

State resting_copy(State& s) {
  if (s.resting) return s;
  const bool round = s.grains.frame.empty();
  State aside;
  exchange(s, aside, round);
  State rest;
  try {
    rest = s;
  } catch (...) {
    exchange(s, aside, round);
    throw;
  }
  exchange(s, aside, round);
  rest.contacts = touching(s.contacts, !round);
  rest.reference.builds = s.reference.builds;
  rest.resting = true;
  return rest;
}

State at_rest(State s) { return s.resting ? s : resting_copy(s); }

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
