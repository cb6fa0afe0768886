// SPDX-License-Identifier: LGPL-3.0-or-later
// Candidate pairs within the skin, binned by kind, with what each contact remembers and shows.
#pragma once

#include <array>
#include <vector>

#include "dem/base/tensor.hpp"
#include "dem/kernel/hull_overlap.hpp"
#include "dem/kernel/spring_rows.hpp"

namespace grus::dem {

/// Pairs of one kind share a loop; contact/pair_kinds.hpp says which bin two shapes belong to, and what is done there.
/// `general`: one of them a poly-ellipsoid. Pairs of grains come first, then those with walls.
enum Bin : std::uint32_t {
  sphere_sphere,
  general,
  hull_hull,
  sphere_wall,
  polyellipsoid_wall,
  hull_wall,
  sphere_mesh,
  bin_count
};
inline constexpr Bin first_wall = sphere_wall;

/// Grain a < b; `image` is the number of cell vectors added to b. For walls, b is the wall's index; of a surface of
/// triangles `image` tells which one (contact/mesh_pairs.hpp).
struct Pair {
  Index a, b;
  std::array<std::int16_t, 3> image{};
  std::uint16_t law = 0;  // row of the model's table of pair laws
  bool operator==(const Pair&) const = default;
};

/// Order of pairs by their grains and image.
inline bool by_place(const Pair& p, const Pair& q) {
  if (p.a != q.a) return p.a < q.a;
  return p.b != q.b ? p.b < q.b : p.image < q.image;
}

/// True for a pair whose partner is an image.
inline bool crosses(const Pair& p) { return (p.image[0] | p.image[1] | p.image[2]) != 0; }

/// By row, whether a spring is kept.
using SpringSet = std::array<bool, spring_rows>;

/// Forces on b that the springs of a contact hold (N); the couple of a spring is radius x force.
using Springs = std::array<Vec3, spring_rows>;
inline Springs no_springs() {
  Springs none;
  none.fill(Vec3::Zero());
  return none;
}

/// What a contact remembers. Touching when stiffness > 0.
struct Contact {
  Springs spring = no_springs();
  double stiffness = 0;   // > 0, frozen at contact birth; the law says of what: Hertz N/m^1.5, linear N/m
  double compliance = 0;  // 1 / tangential stiffness (m/N) of the step before; 0: no spring yet
  double viscous = 0;     // viscous part of the normal force (N)
  double radius = 0;      // effective radius (m), frozen at contact birth
  double reach = 0;       // separation at which it parts (m), > 0 with attraction; frozen at contact birth
};

/// The same of many contacts, column by column: the kernels read and write as many in a row as a register holds.
struct ContactColumns {
  std::array<std::array<std::vector<double>, 3>, spring_rows> spring;  // x, y, z of each; empty unless it is kept
  std::vector<double> stiffness, compliance, viscous, radius;
  std::vector<double> reach;  // empty unless `reaches`
  SpringSet keeps{true};      // the first always
  bool reaches = false;       // contacts hold beyond touch

  [[gnu::always_inline]] Contact operator[](std::size_t k) const {
    Contact c{.stiffness = stiffness[k], .compliance = compliance[k], .viscous = viscous[k], .radius = radius[k]};
    c.spring[slide_spring] = force(slide_spring, k);
    for (const SpringRow row : couple_springs)
      if (keeps[row]) c.spring[row] = force(row, k);
    if (reaches) c.reach = reach[k];
    return c;
  }
  Vec3 force(SpringRow row, std::size_t k) const { return {spring[row][0][k], spring[row][1][k], spring[row][2][k]}; }
  void set_force(SpringRow row, std::size_t k, const Vec3& f) {
    for (std::size_t j = 0; j < 3; ++j) spring[row][j][k] = f[static_cast<Eigen::Index>(j)];
  }
  void set(std::size_t k, const Contact& c) {
    set_force(slide_spring, k, c.spring[slide_spring]);
    for (const SpringRow row : couple_springs)
      if (keeps[row]) set_force(row, k, c.spring[row]);
    stiffness[k] = c.stiffness;
    compliance[k] = c.compliance;
    viscous[k] = c.viscous;
    radius[k] = c.radius;
    if (reaches) reach[k] = c.reach;
  }
  /// These springs are kept from now on, and others no longer; new ones hold nothing. So are reaches.
  void keep(const SpringSet& springs, bool reaching) {
    keeps = springs, reaches = reaching;
    const auto kept = [&](std::vector<double>& column, bool is) {
      is ? column.resize(stiffness.size(), 0.0) : std::vector<double>().swap(column);
    };
    for (const SpringRow row : couple_springs)
      for (auto& column : spring[row]) kept(column, keeps[row]);
    kept(reach, reaches);
  }
  void keep_as(const ContactColumns& other) { keeps = other.keeps, reaches = other.reaches; }
  bool touching(std::size_t k) const { return stiffness[k] > 0; }
};

/// Calls f on every column that is kept.
template <class C, class F>
void for_each_contact_column(C& c, F&& f) {
  for (std::size_t row = 0; row < spring_rows; ++row)
    for (std::size_t j = 0; j < 3 && c.keeps[row]; ++j) f(c.spring[row][j]);
  f(c.stiffness);
  f(c.compliance);
  f(c.viscous);
  f(c.radius);
  if (c.reaches) f(c.reach);
}

/// What a contact shows: of the last step of a run, and of steps that test for breakage. Steps in between leave it out
/// for spheres.
struct alignas(64) Touch {
  Vec3 normal = Vec3::Zero();  // unit, from a to b; the search direction while apart
  double overlap = 0;          // m, > 0 touching; with attraction from minus the contact's reach on
  Vec3 force = Vec3::Zero();   // on b (N); -force on a
  double held = 0;             // of hulls: energy of the overlap (J)
};

/// Where a contact of hulls acts, kept where they may cleave.
struct Spot {
  Vec3 at = Vec3::Zero();      // middle of its area, from the mass centre of a (m, global)
  Vec3 couple = Vec3::Zero();  // on b besides the force, about there (N m); -couple on a
};

/// What the overlaps of hulls were made of in the step before, of which rows of the grains' hulls: they decide no bit
/// of what is found, so they are in no checkpoint.
struct HullGuesses {
  struct Row {
    Index a, b;
    HullGuess guess;
  };
  std::vector<Row> row;  // of the pairs of hulls
};

/// Force and torque that a grain collects in a step; a row of the kernels.
struct alignas(64) Load {
  Vec3 force = Vec3::Zero();
  double unused = 0;
  Vec3 torque = Vec3::Zero();
  double unused_too = 0;
};

/// Energy held by the springs (J).
inline double shear_energy(const Contact& c) {
  double size2 = 0;
  for (const Vec3& spring : c.spring) size2 += spring.squaredNorm();
  return 0.5 * c.compliance * size2;
}

/// Couple on b of all springs that hold one (N m); -couple on a.
inline Vec3 couple(const Contact& c) {
  Vec3 force = c.spring[first_couple];
  for (std::size_t row = first_couple + 1; row < spring_rows; ++row) force += c.spring[row];
  return c.radius * force;
}

/// Work and dissipation of one tile since the last flush (J). `friction`: the limit times plastic slip or roll, what a
/// spring sheds as its stiffness changes, what a parting one holds. `springs`: their work less the change of what they
/// hold, the same if the law is right. `adhesion`: what contacts with attraction take as they snap on and off.
struct BlockEnergy {
  double friction = 0, springs = 0, viscous = 0, work = 0, adhesion = 0;
};

/// Grains are cut into tiles of consecutive indices, pairs belong to the tile of their grain a. A tile's pairs are one
/// thread's work: what they do to grains of the tile goes to those grains' loads, what they do to grains of later tiles
/// to rows of its own (`target`), which the later grain adds up. So no order depends on the number of threads. The size
/// follows from the number of grains alone: enough tiles for a team, few pairs between tiles.
inline int tile_bits(std::size_t grains) {
  int bits = 7;
  while (bits < 12 && (grains >> bits) > 64) ++bits;
  return bits;
}
inline std::size_t tile_size(std::size_t grains) { return std::size_t{1} << tile_bits(grains); }
inline std::size_t tile_count(std::size_t grains) { return (grains + tile_size(grains) - 1) >> tile_bits(grains); }
inline std::size_t tile_words(std::size_t grains) { return (tile_count(grains) + 63) / 64; }

/// Kernels read whole groups of pairs, and may look beyond the last.
inline constexpr std::size_t overrun = 8;

/// What a sphere's pass finds of a triangle near it.
struct MeshTouch {
  Vec3 place, normal;   // nearest to the sphere's centre, from the wall's point; from there to the centre
  double distance = 0;  // m
  bool touches = false, presses = false;  // no other triangle does so for it
};

/// What follows from the pairs of a list and from nothing else (`lay_out` makes it, `entail` makes it again): columns
/// as the kernels read them, rows of loads, tiles and who has done them. It is copied with its state, since the next
/// step needs it, but it is in no checkpoint.
struct Plan {
  std::vector<Index> a, b, law;  // of `pair` (b of a wall: 0); longer by `overrun`, as is `target`
  std::vector<Index> shift;      // row of `images`; empty without a periodic cell
  std::vector<Index> target;     // row of `load` for b; of walls, the wall
  std::vector<std::array<std::int16_t, 3>> images;
  std::vector<Load> load;  // one a grain, then one for each tile and grain of a later tile that it has pairs with; all
                           // zero between steps
  std::vector<Load> tile_load;  // room for the tile that each thread has at hand
  std::vector<Index> remote,
      remote_row;  // of grain i: load[remote_row[remote[i]]] to load[remote_row[remote[i + 1]]], by tile
  std::vector<std::uint64_t> tile_work;  // running sums of what the tiles cost, in nanoseconds or so
  std::vector<std::uint64_t> before;     // tile_words() words a tile: the bits of the tiles that have pairs with it
  std::vector<std::uint32_t> taken, done,
      moved;                // of each tile: the pass in which its pairs were begun and done, and its grains moved, last
  std::uint32_t round = 0;  // passes so far
  double firmest = INFINITY;        // eigenvalue (rad^2 s^-2) that the time step allows a contact of hulls alone
  std::uint32_t firmer = 0;         // some has passed it in this run of steps
  std::vector<BlockEnergy> energy;  // one a tile; all zero between steps
  std::vector<double> law_rows, shift_rows, wall_rows, round_rows;  // room for the kernels' tables
  std::vector<double> mesh_rows;      // the same of pairs of spheres and triangles: of each the plane at hand
  std::vector<MeshTouch> mesh_touch;  // of such pairs
};

/// Pairs by grain: entry[first[i]..first[i+1]) = 2 * pair + (is b) of grain i, first those of which it is a. Empty
/// until somebody asks (index_grains).
struct PairIndex {
  std::vector<Index> first, entry;
};

struct Contacts {
  std::array<std::size_t, bin_count + 1> begin{};   // bins are ranges of the columns below
  std::array<std::vector<Index>, bin_count> tile;   // of each bin: first pair of each tile, and the end
  std::array<std::vector<Index>, bin_count> apart;  // first pair of each tile that did not touch when the list was made
  std::vector<Pair>
      pair;  // in a tile: pairs that touched when the list was made, then the others; each by (a, b, image)
  ContactColumns contact;  // of `pair`; longer by `overrun`, as are touch and active
  std::vector<Touch> touch;
  std::vector<Spot> spot;  // of `pair`; empty unless `spots`
  bool spots = false;
  HullGuesses guesses;
  std::vector<Vec3> resting_normal;  // of `pair`, of bodies; only of a state at rest (rve/resting.hpp)
  std::vector<std::uint8_t> active;  // touching; kept for spheres
  PairIndex index;
  Plan plan;

  std::size_t size() const { return pair.size(); }
};

/// Touching contacts of grain i, walls included.
inline int coordination(const Contacts& c, std::size_t i) {
  int touching = 0;
  for (Index e = c.index.first[i]; e < c.index.first[i + 1]; ++e) touching += c.contact.touching(c.index.entry[e] >> 1);
  return touching;
}

}  // namespace grus::dem
