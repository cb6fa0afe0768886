// SPDX-License-Identifier: LGPL-3.0-or-later
// What the rooms do with a pair, by the bin that it is in: a new kind of pair is a bin and a row here.
#pragma once

#include <span>

#include "dem/contact/laws.hpp"
#include "dem/contact/sleeping_hulls.hpp"
#include "dem/kernel/contact_pass.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

struct Candidate;

/// One tile in a contact pass: what a bin's pass reads, and where it writes.
struct TileWork {
  const ContactLaw& law;
  std::span<const PairLaw> pairs;
  const Grains& grains;
  const Boundary& boundary;
  Contacts& contacts;
  const ContactRows& rows;  // for the kernels; load and first are this tile's
  Load* load;               // of the tile's grains, that of `first` first
  std::size_t first;
  BlockEnergy& energy;
  SleepingHulls* sleep = nullptr;  // null: all pairs are looked at

  double dt() const { return rows.dt; }
};

struct PairKind {
  /// Forces of pairs [begin, end) of a tile.
  void (*pass)(const TileWork& work, std::size_t begin, std::size_t end);
  /// Whether a candidate that is close by its bounding spheres is nearer than `skin`. `normal`: the last search
  /// direction if there is one; left for the next. Null: the bounding spheres have said it, or there is none (walls).
  bool (*near)(const Grains& grains, const Cell& cell, const Candidate& pair, double skin, Vec3& normal);
  bool shown_always;              // touch is written in every step: its normal is where the next search begins
  bool rolls;                     // flat faces may meet: rolling can rule the time step
  std::uint64_t touching, apart;  // cost of a pair in a step, in units of a fifteenth of two touching spheres
};

const PairKind& pair_kind(std::size_t bin);

/// The bin of two grains, and of a grain and a wall.
Bin pair_bin(ShapeKind a, ShapeKind b);
Bin wall_bin(ShapeKind kind, const Wall& wall);

/// The order in which a tile's bins are added up: sums depend on it.
inline constexpr std::array<Bin, bin_count> pass_order{sphere_sphere, sphere_wall, general,    polyellipsoid_wall,
                                                       hull_hull,     hull_wall,   sphere_mesh};

/// A kernel over the rows as they are, its energies booked.
void run_rows(const TileWork& work, const ContactRows& rows, PairLoop loop, std::size_t begin, std::size_t end);

}  // namespace grus::dem
