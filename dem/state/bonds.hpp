// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds between grains, by kind. A kind is a row type, a member of `Bonds`, and the functions that bond/bonds.hpp asks
// of it.
#pragma once

#include <array>
#include <vector>

#include "dem/state/contacts.hpp"  // Load

namespace grus::dem {

/// The ends of a bond of any kind: the two grains, and the number of cell vectors added to b.
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

/// Where a face bond gives way; a rod is that of two spheres, which breaks as a parallel one does.
enum class FaceCriterion : std::uint8_t { cohesive, strain_sum, parallel, rod };

/// The face that two Voronoi cells share, as an elastic foundation: opening w and small turn theta of b against a since
/// the bond was made, stiffness per area against opening and shear, moments of the face against turns. All vectors of
/// the face are in the geometry frame of a; e1, e2 and the normal are its principal axes.
struct FaceBond {
  static constexpr bool keeps_whole = false;

  BondEnds ends;
  Vec3 at_a, at_b;                              // middle of the face from each mass centre, in each geometry frame (m)
  Vec3 normal, e1;                              // from a to b; e2 = normal x e1
  Quat rest;                                    // turns b's orientation against a's back to none
  double area, i1, i2;                          // m^2; second moments against turns about e1 and e2 (m^4)
  double kn, kt;                                // Pa/m
  double tension, cohesion, tan_phi, friction;  // Pa, Pa; of brittle bonds the limits that their criterion asks for
  double energy_1, energy_2;                    // J/m^2, opening and shear
  FaceCriterion criterion = FaceCriterion::cohesive;
  double reached = 0, onset = 0,
         rupture = 0;             // openings in the energy norm: largest so far, at onset (0: none), at the end
  double slip_1 = 0, slip_2 = 0;  // of the part that has given way, along e1 and e2 (m)
  double slip_3 = 0;              // the same about the normal (rad)
  double spent = 0;               // J, by softening
  double rubbed = 0;              // J, by friction of what has given way
  double held = 0;                // J
  double damage = 0;              // 0 to 1
  Vec3 force = Vec3::Zero();      // on b, global (N)
  Vec3 shear = Vec3::Zero();      // friction on b, global (N), as a contact has it: along the normal the moment over
                                  // the area's radius of gyration
};

/// A dashpot that resists the velocity of a face bond's opening and turn.
struct FaceDashpot {
  double normal = 0, shear = 0;  // N s/m
  Vec3 turn = Vec3::Zero();      // about e1, e2 and the normal (N m s)
  Vec3 force = Vec3::Zero();     // on b, at the last step, global (N)
  Vec3 couple = Vec3::Zero();    // the same (N m)
};

/// A bond has broken: a contact between the same two, if they press, goes on with its foundation and its friction. Of
/// a rod nothing goes on: the contact of its spheres has been there all along.
struct Handed {
  BondEnds ends;
  Vec3 at_a;                   // as of the bond
  double modulus;              // Pa/m; 0: of a rod
  double area;                 // m^2
  double fresh;                // m^2 of it that no cut has counted
  Vec3 shear;                  // on b (N)
  double compliance;           // m/N
  double held;                 // J, by the bond at its end
  double spent;                // J, by softening since its birth
  double kept = 0;             // J, what the contact will hold: it is there from the next list on
  Vec3 normal = Vec3::Zero();  // as of the bond
  double sliding = 0;          // share of shear and twist in the energy that parts the face, 0 to 1
};

/// A bond that has broken, where that is recorded.
struct BrokenBond {
  double time;                 // s
  Vec3 at;                     // middle of the face (m)
  double area;                 // m^2
  double energy;               // J, since the bond was made
  std::uint32_t a = 0, b = 0;  // numbers of its grains
  Vec3 normal = Vec3::Zero();  // of the face, from a to b (global)
  double sliding = 0;          // share of shear and twist in the energy that parted it, 0 to 1
};

/// A force on a point of a grain that stays as it is, or grows to that in proportion to time.
struct DeadLoad {
  Index grain;
  Vec3 at;                    // from the centre of mass, geometry frame (m)
  Vec3 force;                 // N
  double ramp = 0;            // s, until it is whole
  Vec3 felt = Vec3::Zero();   // N, now
  Vec3 point = Vec3::Zero();  // m, now
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
  std::vector<double> rubbed;              // by tile (J): friction of what has given way
  std::vector<double> viscous;             // by tile (J): taken by dashpots
  std::vector<double> power;               // by tile (W): of a moving cell on bonds with images
  std::vector<std::size_t> broken;
  std::vector<std::size_t> begun;  // by tile: bonds that soften and have no outline yet
};

/// The corners of the faces that have begun to soften, about their middles along e1 and e2 (m); they follow from the
/// Voronoi cells, so nothing but speed hangs on whether one is here.
struct FaceOutlines {
  struct Range {
    Index first = 0, corners = 0;
  };
  std::vector<Range> of;  // by row; none: no corners, and beyond the end
  std::vector<Eigen::Vector2d> corner;

  std::span<const Eigen::Vector2d> operator[](std::size_t row) const {
    if (row >= of.size()) return {};
    return {corner.data() + of[row].first, of[row].corners};
  }
  void clear() { of.clear(), corner.clear(); }
};

/// The bonds of one kind, by birth; a broken one is removed.
template <class Row>
struct BondColumn {
  std::vector<Row> row;
  BondTiles tiles;
};

struct Bonds {
  BondColumn<CohesiveSpring> cohesive;
  BondColumn<FaceBond> face;
  FaceOutlines outline;
  std::vector<FaceDashpot> dashpot;  // by face bond; none: they resist no velocity
  std::vector<FaceBond> wall;        // of grains (a) with walls (b, which do not turn): they never break
  std::vector<DeadLoad> load;
  std::vector<Handed> handed;      // by face bonds that have broken since the last neighbour list
  std::vector<BrokenBond> broken;  // all of them, where that is wanted

  /// Those between grains.
  std::size_t size() const;
  bool empty() const { return size() == 0 && wall.empty() && load.empty(); }
  void clear();
};

/// The bonds of each grain, by grain; room that tests reuse.
struct GrainBonds {
  enum class End : std::uint8_t { a, b, wall, load };
  struct Entry {
    Index at;  // row of its kind
    End end;
  };
  std::vector<Index> first;
  std::vector<Entry> entry;
};

/// Calls f on the column of every kind.
template <class B, class F>
void for_each_kind(B& bonds, F&& f) {
  f(bonds.cohesive);
  f(bonds.face);
}

/// Calls f on every bond of grains with grains, whatever its kind.
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
