// SPDX-License-Identifier: LGPL-3.0-or-later
// Into what a grain breaks. A splitter is a value with three functions of (splitter, grains, grain): `can_split`,
// `pieces_of`, and nothing else; replace_grain.hpp books what it makes. A new splitter is a struct, its two functions
// and a name in `Splitter`.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "dem/fracture/partition.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// How the load wants a grain to break.
struct Wanted {
  Mat3 stress;                // of the grain (Pa, tension-positive, global)
  std::optional<Vec3> plane;  // its normal (global, unit); none: across the most tensile direction
  Vec3 load = Vec3::Zero();   // from the centre to the contact of largest force (global, unit); zero: none touches
  double offset = 0;          // of that plane from the mass centre (m)
};

/// A plane between two of the pieces, across which springs can hold: four quarters of ellipses about a centre, seen
/// from the parent's geometry frame (origin and axes of its `frame_of` once it is turned).
struct FreshPlane {
  std::size_t below, above;                 // pieces
  Vec3 normal;                              // unit, from below to above
  Vec3 u, v;                                // unit, in the plane
  double u_plus, u_minus, v_plus, v_minus;  // half widths (m)

  double area() const { return pi / 4 * (u_plus + u_minus) * (v_plus + v_minus); }
};

/// A plane between two of the hulls, in the parent's geometry frame.
struct FreshFace {
  std::size_t below, above;  // pieces
  Vec3 normal;               // unit, from below to above
  FaceMoments moments;
};

struct Pieces {
  std::vector<GrainSpec> piece;  // at rest: replace_grain lets them move with the parent
  Quat orientation;              // of the parent's geometry frame, once a sphere's has turned to the plane
  bool loses_mass = false;       // what the pieces do not hold is fines
  bool keeps_contacts = true;    // the pieces' contacts go on as the parent's; otherwise theirs are new
  std::vector<FreshPlane> plane = {};
  std::vector<FreshFace> face = {};
  std::vector<Polyhedron> body = {};  // of hulls, in the parent's geometry frame: they become rows of the grains' hulls
  std::vector<HullPlace> place = {};  // of those rows' frames in the parent's
  int planes_dropped = 0;             // of hulls that would have had too many
};

/// Halves of a poly-ellipsoid or a sphere along one of its axes (split_polyellipsoid.hpp).
struct Halves {
  bool turn_spheres = false;   // their axes first turn to the ideal plane (geometry only, no motion)
  double slight_rotation = 0;  // rad: spheres' axes turn by a random angle of [theta/2, theta] about each axis (3.3.1)
  double rounding = 0.02;      // epsilon of the split geometry; why 0.02: docs/validation/zhang2015.md
  bool keep_mass = false;  // the lost volume's mass stays, by density / (1 - rounding); otherwise it goes to the fines
};

/// Fourteen balls in a sphere that touch it from inside and one another (apollonian.hpp).
struct Balls {
  bool keep_mass = false;  // by density; otherwise what the balls do not fill goes to the fines
  bool swells = false;     // with keep_mass: they grow to the volume of their mass (swelling.hpp)
};

/// Two hulls of one (split_hull.hpp), held by a bond of the fresh face until that has taken its energy.
struct Cut {
  bool cohesive = true;
  double energy = 0;  // J/m^2
};

/// As many hulls of one as it has cracked into (shatter.hpp); no bond holds them.
struct Shatter {
  PartingRules parting;
};

using Splitter = std::variant<Halves, Balls, Cut, Shatter>;

/// Whether a splitter can do anything with a grain's shape.
bool can_split(const Splitter& splitter, const Grains& grains, std::size_t i);

/// The pieces that a splitter makes of a grain; random draws by (seed, id).
Pieces pieces_of(const Splitter& splitter, const Grains& grains, std::size_t i, const Wanted& wanted,
                 std::uint64_t seed);

}  // namespace grus::dem
