// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/breakage.hpp"

#include <array>
#include <atomic>
#include <numeric>

#include "dem/bond/bonds.hpp"
#include "dem/contact/forces.hpp"
#include "dem/contact/listing.hpp"
#include "dem/fracture/loaded_grain.hpp"
#include "dem/fracture/replace_grain.hpp"
#include "dem/fracture/split_hull.hpp"
#include "dem/rve/crack_tests.hpp"
#include "dem/rve/cut_bonds.hpp"
#include "dem/rve/fresh_springs.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/split_statistics.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {
namespace {

LoadedGrain loaded(const Model& model, const State& state, std::size_t i) {
  const double nu = model.materials[state.grains.material[i]].poissons_ratio;
  return {model.law, nu, state.grains, state.contacts, i};
}

bool is_hull(const State& state, std::size_t i) { return state.grains.kind[i] == ShapeKind::hull; }

/// Calls f on the grain under its load, as its shape has it.
template <class F>
auto with_load(const Model& model, const State& state, std::size_t i, F&& f) {
  return is_hull(state, i) ? f(loaded_hull(model, state, i)) : f(loaded(model, state, i));
}

/// A fragment that its neighbours have not yet taken up, or that flies from them.
bool unsettled(const Model& model, const State& state, int rest, std::size_t i) {
  const Grains& g = state.grains;
  if (g.generation[i] == 0) return false;
  if (state.steps - g.born[i] < static_cast<std::uint64_t>(rest)) return true;
  const double most =
      is_hull(state, i) ? loaded_hull(model, state, i).largest_force() : largest_contact(loaded(model, state, i)).force;
  return g.force[i].norm() >= 0.5 * most;
}

/// How near grain i is to failing; a utilisation of 0 where it may not break or nothing could be made of it.
Verdict verdict_of(const Model& model, const State& state, std::size_t i) {
  const Grains& g = state.grains;
  const auto& fracture = model.materials[g.material[i]].fracture;
  if (!fracture || !fracture->limit.allows(g.extent[i].equivalent_radius, g.generation[i])) return {};
  if (!can_split(fracture->splitter, g, i)) return {};
  if (fracture->limit.rest > 0 && unsettled(model, state, fracture->limit.rest, i)) return {};
  return with_load(model, state, i, [&](const auto& grain) { return judge(fracture->criteria, grain, g.strength[i]); });
}

/// Grains of its material are tested themselves, and not by their utilisation alone.
bool tests_cracks(const Model& model, const Grains& g, std::size_t i) {
  const auto& fracture = model.materials[g.material[i]].fracture;
  return fracture && fracture->cracks;
}

/// How the load wants a grain that fails to break.
Wanted wanted_by(const Model& model, const State& state, std::size_t i) {
  const FractureModel& fracture = *model.materials[state.grains.material[i]].fracture;
  return with_load(model, state, i, [&](const auto& grain) {
    Wanted wanted{grain.stress(), std::nullopt, load_direction(grain)};
    if (fracture.plane == BreakPlane::average_stress) return wanted;
    const Criterion& failed = fracture.criteria[verdict_of(model, state, i).by];
    wanted.plane = std::visit([&](const auto& c) { return c.plane(grain, state.grains.strength[i]); }, failed);
    if (!wanted.plane && fracture.plane == BreakPlane::critical_contacts) wanted.plane = contact_plane(grain, 0, 3);
    if constexpr (std::is_same_v<std::decay_t<decltype(grain)>, LoadedHull>)
      if (const auto* cleavage = std::get_if<Cleavage>(&failed)) {
        const Cleft cleft = cleavage->worst(grain, state.grains.strength[i]);
        wanted.plane = cleft.normal, wanted.offset = cleft.offset;
      }
    return wanted;
  });
}

/// Contacts of some grains as seen from them.
struct Seen {
  Index contact, other;  // the other grain, or the wall
  bool wall;
  std::array<int, 3> image;  // of the other grain
  bool operator==(const Seen& o) const { return other == o.other && wall == o.wall && image == o.image; }
};

Seen seen_from(const Contacts& contacts, Index entry) {
  const Index k = entry >> 1;
  const Pair& p = contacts.pair[k];
  const bool is_b = entry & 1;
  Seen seen{k, is_b ? p.a : p.b, k >= contacts.begin[first_wall], {}};
  for (std::size_t n = 0; n < 3; ++n) seen.image[n] = (is_b ? -1 : 1) * p.image[n];
  return seen;
}

/// A neighbour at the plane may touch several pieces: together they go on with no more than the parent's force. The
/// contacts that they inherited share their stiffness in proportion to what the deepest one carries. Says whether there
/// are any.
bool share_contacts(const Model& model, State& state, std::span<const std::size_t> pieces) {
  Contacts& contacts = state.contacts;
  bool shared = false;
  const auto among = [&](Index i) { return std::find(pieces.begin(), pieces.end(), i) != pieces.end(); };
  const auto each_inherited = [&](std::size_t piece, auto&& f) {
    for (Index e = contacts.index.first[piece]; e < contacts.index.first[piece + 1]; ++e) {
      const Seen seen = seen_from(contacts, contacts.index.entry[e]);
      if (contacts.contact.touching(seen.contact) && (seen.wall || !among(seen.other))) f(seen);
    }
  };
  for (std::size_t n = 0; n + 1 < pieces.size(); ++n)
    each_inherited(pieces[n], [&](const Seen& mine) {
      const double stiffness = contacts.contact.stiffness[mine.contact];
      std::vector<Index> inherited{mine.contact};
      for (std::size_t m = n + 1; m < pieces.size(); ++m)
        each_inherited(pieces[m], [&](const Seen& theirs) {
          if (theirs == mine && contacts.contact.stiffness[theirs.contact] == stiffness)
            inherited.push_back(theirs.contact);
        });
      if (inherited.size() < 2) return;
      double most = 0, sum = 0;
      for (const Index k : inherited) {
        const double force = elastic_force(model.law, contacts, k);
        most = std::max(most, force), sum += force;
      }
      const double share = most / sum;
      for (const Index k : inherited) {
        Contact c = contacts.contact[k];
        c.stiffness *= share;
        for (Vec3& spring : c.spring) spring *= share;
        c.compliance /= share;
        contacts.contact.set(k, c);
      }
      shared = true;
    });
  return shared;
}

/// Elastic energy of the contacts of some grains; a contact between two of them counts once (J).
double energy_of(const Model& model, const State& state, const std::vector<Index>& grains) {
  std::vector<std::uint8_t> among(state.grains.size(), 0);
  for (const Index i : grains) among[i] = 1;
  const Contacts& c = state.contacts;
  double sum = 0;
  for (const Index i : grains)
    for (Index e = c.index.first[i]; e < c.index.first[i + 1]; ++e) {
      const std::size_t k = c.index.entry[e] >> 1;
      const bool twice = k < c.begin[first_wall] && among[c.pair[k].a] && among[c.pair[k].b];
      const auto held = [&](const auto& law) { return elastic_energy(law, c.contact[k], c.touch[k]); };
      sum += (twice ? 0.5 : 1) * std::visit(held, model.law);
    }
  return sum + bond_energy_of(state, among);
}

/// A grain that has given way.
struct Split {
  ParentMotion parent;
  Pieces pieces;
  std::vector<std::size_t> slots;  // of the pieces
};

Split split(const Model& model, State& state, const Break& b) {
  Grains& g = state.grains;
  const FractureModel& fracture = *model.materials[g.material[b.grain]].fracture;
  Split out;
  out.pieces = b.pieces ? *b.pieces : pieces_of(fracture.splitter, g, b.grain, b.wanted, model.seed);
  put_bodies(g, b.grain, out.pieces);
  state.ledger.planes_dropped += static_cast<std::size_t>(out.pieces.planes_dropped);
  const bool cuts = !out.pieces.face.empty() && std::holds_alternative<Cut>(fracture.splitter);
  if (cuts) cut_bonds(out.pieces, static_cast<Index>(b.grain), static_cast<Index>(g.size()), state);
  if (!out.pieces.body.empty() && !cuts)
    share_out(out.pieces, static_cast<Index>(b.grain), static_cast<Index>(g.size()), state);
  for (GrainSpec& piece : out.pieces.piece)
    piece.inertia = model.numerics.inertia_factor(equivalent_radius(piece.shape));
  g.orientation[b.grain] = out.pieces.orientation;
  out.parent = motion_of(g, b.grain);
  Fines& fines = state.ledger.fines;
  const double before = fines.mass, moving = kinetic_energy(g, b.grain) + fines.kinetic;
  const Material& material = model.materials[g.material[b.grain]];
  const double strength = g.strength[b.grain], radius = g.extent[b.grain].equivalent_radius;
  out.slots = replace_grain(g, b.grain, out.pieces, fracture.fines, fines);
  fines.volume += (fines.mass - before) / material.density;
  for (const std::size_t i : out.slots) {
    draw_strength(model, g, i);
    if (const auto own = fracture.inherited(strength, radius, g.extent[i].equivalent_radius)) g.strength[i] = *own;
    g.utilisation[i] = NAN;
    if (!g.held.empty()) g.held[i] = {};
    if (!g.born.empty()) g.born[i] = state.steps;
  }
  if (!g.solid_mass.empty()) {  // pieces that resist motion by more than their solid, at its velocity
    double now = fines.kinetic;
    for (const std::size_t i : out.slots) now += kinetic_energy(g, i);
    state.ledger.inertia += now - moving;
  }
  if (cuts) join_pieces(model, out.pieces, out.slots, state);
  return out;
}

}  // namespace

void draw_strength(const Model& model, Grains& g, std::size_t i) {
  const auto& fracture = model.materials[g.material[i]].fracture;
  g.strength[i] = fracture ? fracture->strength_factor(g.extent[i].equivalent_radius, model.seed, g.id[i]) : 1;
}

std::vector<Break> find_breaks(const Model& model, State& state, Team& team) {
  enum : std::uint8_t { holds, bonded, asks, fails };
  Grains& g = state.grains;
  if (!g.hull.empty()) index_bonds(g.size(), state.bonds, state.break_room.bonds);
  auto& room = state.break_room.failing;
  room.assign(g.size(), holds);
  for_each_bond(state.bonds, [&](const auto& bond) {
    if (bond.keeps_whole) room[bond.ends.a] = room[bond.ends.b] = bonded;
  });
  const double since = static_cast<double>(state.steps - state.tested_at), every = model.numerics.fracture_every;
  std::atomic<std::uint64_t> soonest{static_cast<std::uint64_t>(every) -
                                     state.steps % static_cast<std::uint64_t>(every)};
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    double steps = every;
    for (std::size_t i = begin; i < end; ++i) {
      if (room[i] == bonded) continue;
      const double now = verdict_of(model, state, i).utilisation, rate = (now - g.utilisation[i]) / since;
      const bool tested = !g.held.empty() && tests_cracks(model, g, i);
      if (tested ? worth_a_test(model, state, i, now) : now >= 1)
        room[i] = tested ? asks : fails;
      else if (now < 1 && now + rate * every > 1 + overshoot)
        steps = std::min(steps, (1 + overshoot - now) / rate);
      g.utilisation[i] = now;
    }
    const auto mine = static_cast<std::uint64_t>(std::max(1.0, std::floor(steps)));
    for (std::uint64_t least = soonest; mine < least && !soonest.compare_exchange_weak(least, mine);) {
    }
  });
  state.tested_at = state.steps, state.next_test = state.steps + soonest;
  std::vector<Break> breaks;
  for (std::size_t i = 0; i < room.size(); ++i)
    if (room[i] == fails) {
      const Wanted wanted = wanted_by(model, state, i);
      const Splitter& splitter = model.materials[g.material[i]].fracture->splitter;
      if (!is_hull(state, i) || !pieces_of(splitter, g, i, wanted, model.seed).piece.empty())
        breaks.push_back({i, wanted});
    }
  if (g.held.empty()) return breaks;
  std::vector<Index> asked;
  for (std::size_t i = 0; i < room.size(); ++i)
    if (room[i] == asks) asked.push_back(static_cast<Index>(i));
  std::vector<Break> cracked = crack_breaks(model, state, asked, team), all;
  std::merge(std::make_move_iterator(breaks.begin()), std::make_move_iterator(breaks.end()),
             std::make_move_iterator(cracked.begin()), std::make_move_iterator(cracked.end()), std::back_inserter(all),
             [](const Break& a, const Break& b) { return a.grain < b.grain; });
  return all;
}

void apply_breaks(const Model& model, State& state, const std::vector<Break>& breaks, Team& team) {
  Grains& g = state.grains;
  Ledger& ledger = state.ledger;
  // Contacts slide by the dashpots of the whole step's velocities; that is friction, and must not be taken for what the
  // split does.
  contact_forces(model.law, model.pairs, g, state.boundary, 0, true, state.contacts, team);
  drop_loads(state.contacts);
  book(flush(state.contacts), ledger);
  const double elastic_before = elastic_energy(model.law, state.contacts);
  const double bonds_before = stored_energy(state.bonds), taken_before = taken_by_bonds(ledger);
  const std::size_t grains_before = g.size();
  const bool hulls = !g.hull.empty();
  const std::vector<std::size_t> bonds_were = counts(state.bonds);
  std::vector<Index> few;
  for (const auto& b : breaks) few.push_back(static_cast<Index>(b.grain));
  double left = energy_of(model, state, few);
  ParentContacts before;
  if (model.split_statistics) {
    std::vector<std::size_t> parents;
    for (const auto& b : breaks) parents.push_back(b.grain);
    before = contacts_of(model, state, parents);
  }
  std::vector<Index> origin(g.size());
  std::iota(origin.begin(), origin.end(), 0u);
  std::vector<Split> splits;
  for (const Break& b : breaks) {
    splits.push_back(split(model, state, b));
    const Index past = splits.back().pieces.keeps_contacts ? static_cast<Index>(b.grain) : Past::nobody;
    origin[b.grain] = past;
    for (std::size_t n = 1; n < splits.back().slots.size(); ++n) {
      origin.push_back(past);
      few.push_back(static_cast<Index>(splits.back().slots[n]));
    }
  }
  update_frames(g);
  if (hulls) note_bonded(state);
  mend_contacts(g, state.boundary, state.skin, model.materials.size(), few, origin, state.contacts, state.reference,
                team);
  refresh_forces(model, state, team);  // what the lost contacts held is in the balance below
  bool shared = false;
  for (const Split& s : splits)
    if (s.pieces.keeps_contacts && !hulls)  // springs of hulls' contacts go with their areas
      shared = share_contacts(model, state, s.slots) || shared;
  if (shared) refresh_forces(model, state, team);
  if (model.split_statistics) {
    std::vector<std::vector<std::size_t>> pieces;
    for (const Split& s : splits) pieces.push_back(s.slots);
    count_split(model, state, before, pieces, origin, grains_before);
  }
  for (const Split& s : splits)
    if (model.materials[g.material[s.slots[0]]].fracture->springs)
      for (const FreshPlane& plane : s.pieces.plane) left -= add_springs(model, state, s.parent, plane, s.slots);
  double born = 0;  // held by the bonds of fresh faces: rigid grains have held nothing
  for (const Split& s : splits)
    for (const FreshFace& face : s.pieces.face) born += load_cap(state, s.parent, face, s.slots);
  if (hulls)
    refresh_forces(model, state, team);
  else
    add_bond_forces(g, state.boundary.cell, state.bonds, bonds_were, ledger);
  const double unexplained = ledger.unexplained;
  if (!state.bonds.handed.empty()) book_broken(state, model.records_bonds), state.reference.stale = true;
  left += unexplained - ledger.unexplained;  // made where contacts took over: not the splits' doing
  ledger.breakages += breaks.size();
  left -= energy_of(model, state, few);
  if (hulls) left -= taken_by_bonds(ledger) - taken_before;
  const double gone = elastic_before + bonds_before - elastic_energy(model.law, state.contacts) -
                      stored_energy(state.bonds) - (taken_by_bonds(ledger) - taken_before);
  ledger.split += left, ledger.unexplained = unexplained + gone - left;
  ledger.split_added += std::max(0.0, -left - born);
}

}  // namespace grus::dem
