// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/split_statistics.hpp"

#include <algorithm>

#include "dem/rve/measure.hpp"

namespace grus::dem {
namespace {

template <class F>
void each_touching(const Model& model, const State& state, std::size_t i, F&& f) {
  const Contacts& c = state.contacts;
  for (Index e = c.index.first[i]; e < c.index.first[i + 1]; ++e) {
    const std::size_t k = c.index.entry[e] >> 1;
    if (!c.contact.touching(k)) continue;
    f(k >= c.begin[first_wall], c.index.entry[e] & 1 ? c.pair[k].a : c.pair[k].b, elastic_force(model.law, c, k));
  }
}

}  // namespace

ParentContacts contacts_of(const Model& model, const State& state, std::span<const std::size_t> grains) {
  ParentContacts found;
  for (const std::size_t i : grains) {
    auto& list = found.of.emplace_back();
    each_touching(model, state, i, [&](bool wall, std::size_t other, double force) {
      list.emplace_back(wall ? state.grains.size() + other : other, force);
    });
  }
  found.virial = love_weber(state, 1).trace();
  return found;
}

void count_split(const Model& model, State& state, const ParentContacts& before,
                 std::span<const std::vector<std::size_t>> pieces, std::span<const Index> origin,
                 std::size_t grains_before) {
  SplitStatistics& s = state.ledger.splits;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    std::vector<std::pair<std::size_t, double>> after;
    for (const std::size_t piece : pieces[k])
      each_touching(model, state, piece, [&](bool wall, std::size_t other, double force) {
        after.emplace_back(wall ? grains_before + other : origin[other], force);
      });
    for (const auto& [neighbour, force] : before.of[k]) {
      double kept = 0;
      for (const auto& [n, f] : after)
        if (n == neighbour) kept += f;
      ++s.contacts, s.force += force;
      s.contacts_kept += kept > 0, s.force_kept += std::min(kept, force);
    }
  }
  const double virial = love_weber(state, 1).trace();
  s.events += pieces.size();
  ++s.instants;
  if (before.virial != 0) s.pressure_jump += std::abs(virial - before.virial) / std::abs(before.virial);
}

}  // namespace grus::dem
