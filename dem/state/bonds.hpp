// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds between grains, by kind. A kind is a row type, a member of `Bonds`, and the functions that bond/bonds.hpp asks
// of it.
#pragma once

#include <array>
#include <vector>

#include "dem/state/contacts.hpp"

namespace grus::dem {

/// What all kinds have: the two grains, and the number of cell vectors added to b.
struct BondEnds {
  Index a, b;
  std::array<std::int16_t, 3> image{};
};

/// One spring between two fragments. Opening w = (point on b - point on a) + preload, force on b = -secant stiffness *
/// w.
struct CohesiveSpring {
  /// While it lasts its grains neither break nor change their shape.
  static constexpr bool keeps_whole = true;

  BondEnds ends;
  Vec3 at_a, at_b;            // from each centre of mass, in each geometry frame (m)
  Vec3 normal_a;              // plane normal from a to b, geometry frame of a
  Vec3 preload;               // geometry frame of a (m): the opening that carries the initial force
  double peak;                // largest force (N)
  double onset, rupture;      // openings (m) of peak and of zero force
  double reached;             // largest opening so far, at least onset
  Vec3 force = Vec3::Zero();  // on b, global (N)
};

/// How bonds are dealt to tiles of grains: a bond is work of the tile of its lower grain, as pairs are. What it does to
/// a grain of another tile goes to a row of its own, which that tile adds. Made when it is needed (`grains` says for
/// how many).
struct BondTiles {
  std::size_t grains = 0;
  std::vector<Index> first, bond;          // bond[first[t]] to bond[first[t + 1]]: of tile t, by birth
  std::vector<Index> first_far, bond_far;  // those whose higher grain is in tile t, but not their lower one
  std::vector<Load> far;                   // by bond: what its higher grain feels, if that is in another tile
  std::vector<double> dissipated;          // by tile (J)
  std::vector<std::size_t> broken;
};

/// The bonds of one kind, by birth; a broken one is removed.
template <class Row>
struct BondColumn {
  std::vector<Row> row;
  BondTiles tiles;
};

struct Bonds {
  BondColumn<CohesiveSpring> cohesive;

  std::size_t size() const;
  bool empty() const { return size() == 0; }
  void clear();
};

/// Calls f on the column of every kind.
template <class B, class F>
void for_each_kind(B& bonds, F&& f) {
  f(bonds.cohesive);
}

/// Calls f on every bond, whatever its kind.
template <class B, class F>
void for_each_bond(B& bonds, F&& f) {
  for_each_kind(bonds, [&](auto& column) {
    for (auto& bond : column.row) f(bond);
  });
}

inline std::size_t Bonds::size() const {
  std::size_t n = 0;
  for_each_kind(*this, [&](const auto& column) { n += column.row.size(); });
  return n;
}

inline void Bonds::clear() { *this = {}; }

}  // namespace grus::dem
