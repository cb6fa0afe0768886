// SPDX-License-Identifier: LGPL-3.0-or-later
// The list of near pairs: made from candidates, sorted into bins, with the history of contacts that go on.
#pragma once

#include <span>

#include "dem/base/parallel.hpp"
#include "dem/contact/broad_phase.hpp"
#include "dem/contact/sleeping_hulls.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Room that rebuilds reuse. A copied state starts with none.
struct NeighbourRoom {
  NeighbourRoom() = default;
  NeighbourRoom(const NeighbourRoom&) {}
  NeighbourRoom(NeighbourRoom&&) = default;
  NeighbourRoom& operator=(const NeighbourRoom&) { return *this; }
  NeighbourRoom& operator=(NeighbourRoom&&) = default;

  Candidates candidates;  // of all pairs that were closer than `skin` when the grains were at `anchor`
  struct Anchor {
    Vec3 position;
    double radius;
  };
  std::vector<Anchor> anchor;
  Mat3 cell = Mat3::Zero();
  double skin = 0, largest = 0;
  Candidates few;  // pairs of the grains that a mending looks at
  SearchRoom search;
  std::vector<Index> strays;         // such grains
  std::vector<std::uint8_t> marked;  // one of them; by grain
  std::vector<Pair> pair;            // of the list before
  std::vector<Touch> touch;
  std::vector<Index> source;   // of each pair of the new list, its place on the list before
  std::vector<double> column;  // of histories, that is at hand
  HullGuesses guesses;
  std::size_t first_hulls = 0;  // pair of hulls
  struct Listed {
    Pair pair;
    Index old;  // in the list before
    Bin bin;
    Index normal = 0;  // row of `listed_normal`, of kinds that search
  };
  std::vector<std::vector<Listed>> listed;       // by tile
  std::vector<std::vector<Vec3>> listed_normal;  // search directions of pairs that are apart; by tile
  std::vector<std::vector<Index>> near;          // triangles near the sphere at hand; by tile
  std::vector<std::vector<Index>> crossing;      // pairs of which b is in a later tile; by tile of a
  std::vector<Index> next, receivers;
  std::vector<std::array<Index, 2 * bin_count>> counts;
  std::vector<std::uint64_t> work;
  SleepingHulls sleep;
};

/// Where things stood when the list was made: it holds until they have moved by the skin.
struct NeighbourReference {
  std::vector<Vec3> position;
  std::vector<Quat> orientation;  // empty while all grains are spheres
  std::vector<double> radius;     // empty unless spheres may swell: their growth is part of their way
  std::vector<Vec3> wall_point;
  Mat3 cell = Mat3::Zero();
  double skin = 0, grown = 0;  // grown: largest growth of a surface since, by shape transition
  double largest = 0;          // radius
  std::uint64_t builds = 0;    // lists made so far
  std::uint64_t mends = 0;     // of the list, since it was made
  NeighbourRoom room;
  std::vector<Pair> bonded;  // held by face bonds, sorted, law 0: never on the list
  std::vector<Pair> walled;  // the same of grains and walls
  bool stale = false;        // the list is to be made anew, wherever the grains are
  double travelled = 0;      // bound of any grain's way since, against the affine motion; kept by the step loop
};

/// Rebuilds the list. Contacts of pairs that are still near keep their history. `origin[i]` is the index that grain i
/// (or the parent it was split from) had in the old list; empty: unchanged. Children inherit a parent's contact
/// with its frozen stiffness.
/// `materials` is the number of materials: law row = material a * materials + material b. `indexed`: also by grain.
void build_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                    std::span<const Index> origin, Contacts& contacts, NeighbourReference& reference, Team& team,
                    bool indexed = true);

/// The same where only the pairs of `few` grains have to be searched again: of halves of grains that were split
/// (`origin` as above), or of strays (`origin` empty). All other pairs stay, and so does what is known of the other
/// grains' ways. Makes the whole list, with `skin`, where that takes no longer.
void mend_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                   std::span<const Index> few, std::span<const Index> origin, Contacts& contacts,
                   NeighbourReference& reference, Team& team, bool indexed = true);

/// Fills `first` and `entry` of the contacts: steps that test for no breakage can do without. `next`: room.
void index_grains(std::size_t grains, Contacts& contacts, std::vector<Index>& next);

enum class ListState { holds, strays, stale };

/// Whether the list may miss a contact, and if so, whether that is due to a few grains that have gone far (room.strays:
/// all that have gone a quarter of what the list allows). Looks at the grains only where `travelled` says that one
/// could have gone too far, and then corrects it: it is the furthest way of the grains that are not strays.
ListState look_at_list(const Grains& grains, const Boundary& boundary, NeighbourReference& reference);

}  // namespace grus::dem
