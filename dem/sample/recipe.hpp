// SPDX-License-Identifier: LGPL-3.0-or-later
// The recipe of a sample: plain data, SI units. `make` (make.hpp) turns it into grains, walls and bonds.
#pragma once

#include <variant>

#include "dem/base/error.hpp"
#include "dem/packing/packing.hpp"
#include "dem/packing/voronoi.hpp"
#include "dem/rve/rve.hpp"

namespace grus::dem {

/// Who asked for something, for what is told of it: file, line and key of a scene, or nothing.
using Place = std::string;

/// The bounds of the grains: nothing, six walls, an upright cylinder with two plates, a periodic cell, or one between
/// two plates across z.
enum class Bounds : std::uint8_t { open, walls, cylinder, periodic, periodic_xy };

/// What grains are packed in; `round`: a cylinder, though nothing bounds them.
Container container_of(Bounds bounds, bool round = false);

/// A part of a mixture: the material of its grains and their shape, axes of an ellipsoid of the sphere's volume,
/// relative.
struct Part {
  std::uint8_t material = 0;
  double share = 1;
  Vec3 aspect = Vec3::Ones();
};

/// Grains are Voronoi cells of a relaxed mesh, or all balls of planes, each in the sphere that holds it.
struct RandomHulls {
  int rounds = 5;              // of relaxation
  Vec3 aspect = Vec3::Ones();  // lengths along three axes
  bool balls = false;          // of 32 planes: round until they break
};

/// Spheres at random, grown until they fit; hulls or ellipsoids in them.
struct RandomPacking {
  RadiusDistribution radius;
  double solid_fraction = 0;
  std::size_t count = 0;  // 0: as many as fill the fraction
  bool turned = true;     // orientations at random
  std::vector<Part> parts = std::vector<Part>(1);
  std::optional<RandomHulls> hulls = {};  // of the first part's material
  bool round = false;                     // they fill a cylinder along z, whatever the bounds
  Place place = {};
};

/// Equal spheres in contact; the box just holds them.
struct Lattice {
  bool hexagonal = true;  // else simple cubic
  double radius = 0;      // m
  std::array<int, 3> layers{1, 1, 1};
  std::uint8_t material = 0;
  bool turned = true;
};

/// Spheres at given places.
struct Spheres {
  std::vector<Sphere> spheres;
  std::uint8_t material = 0;
  std::vector<std::uint8_t> materials = {};  // of each instead; none: they are all of one
  bool turned = true;
  bool round = false;  // they make up a cylinder along z
};

/// Grains one by one. Density and turning are those of the material.
struct ListedGrain {
  GrainSpec spec;                                  // of a hull: `position` is of its mass centre
  std::optional<std::vector<Vec3>> vertices = {};  // of a convex hull (m)
  Vec3 box = Vec3::Zero();                         // of a block (m); zero: none
  Place place = {}, place_of_size = {};

  bool hull() const { return vertices || !box.isZero(); }
};

/// Voronoi cells that fill a space, bonded where they share a face and their material has bonds.
struct VoronoiPacking {
  std::optional<TessellationSpace> space = {};  // none: the box
  bool round = false;                           // the space is a cylinder along z
  std::size_t count = 1;
  std::vector<Vec3> seeds = {};  // given ones, instead of `count` at random
  int rounds = 5;                // of relaxation
  std::size_t clusters = 0;      // that Voronoi cells are dealt to; 0: all are one
  std::uint8_t material = 0;
  Place place = {};
};

/// Hexagonal prisms on their lattice, as many as the box takes.
struct Prisms {
  double side = 0, thickness = 0, gap = 0;  // m
  bool round = false;                       // those within the cylinder along z that touches the box
  std::uint8_t material = 0;
  Place place = {};
};

/// Convex bodies from elsewhere, bonded where they lie face to face and their materials have bonds.
struct Bodies {
  std::vector<Polyhedron> body;
  std::vector<Vec3> middle;             // of each, between which bonds are as long as they are apart
  std::vector<std::uint8_t> materials;  // of each
  bool round = false;                   // they make up a cylinder along z
  double tolerance = 1e-5;              // of faces that count as one, over the bodies' sizes
  Place place = {};
};

/// Grains of a packing, each filled with Voronoi cells.
struct FilledGrains {
  std::variant<RandomPacking, Lattice, Spheres> parents;
  std::size_t count = 20;
  int rounds = 5;
  std::uint8_t material = 0;
  Place place = {};
};

/// Spheres of a packing, each filled with smaller ones, which their bonds hold together.
struct Agglomerates {
  std::variant<RandomPacking, Lattice, Spheres> parents;
  RadiusDistribution radius;
  double solid_fraction = 0.6;  // of the packing that fills them
  std::uint8_t material = 0;
  Place place = {};
};

/// A wall of its own, beside those of the bounds.
struct OwnWall {
  Wall wall = {};
  Place place = {}, place_of_normal = {};
};

/// A side of the box that has something of its own.
struct Side {
  std::string name;  // of its wall, "zmax"
  Vec3 velocity = Vec3::Zero();
  std::optional<std::uint8_t> material = {};  // none: that of the bounds
};

/// Grains that move with a plane wall, which they make rough.
struct RoughWall {
  std::size_t wall = 0;
  double within = INFINITY;                // m, from the wall, of their centres
  std::optional<std::uint8_t> of = {};     // material; none: any
  std::vector<std::uint8_t> becomes = {};  // by material: that of such a grain
  Place place = {};
};

/// The Voronoi cells' end in a direction, glued to a rigid plane that moves.
struct Clamp {
  Vec3 outward;
  Vec3 velocity = Vec3::Zero();  // m/s
  bool slides = false;           // free to shear and twist
  std::uint8_t material = 0;
  Place place = {};
};

/// A dead load on the Voronoi cells' end in a direction.
struct EndLoad {
  Vec3 outward;
  Vec3 force = Vec3::Zero();  // N
  double ramp = 0;            // s, until it is whole
  Place place = {};
};

/// Voronoi cells are glued to the walls of their box.
struct Glue {
  bool slides = false;
  Place place = {};
};

/// Two rigid plates that touch the grains; the upper one moves towards the lower, by a speed (m/s) or by a rate of
/// strain of their distance (1/s).
struct Platens {
  int axis = 2;
  double pace = 0;
  bool by_speed = true;
  std::uint8_t material = 0;
};

/// Rollers along the third axis that touch a box of Voronoi cells: two below, `outer` apart, one or two above, `inner`
/// apart, which move down.
struct Rollers {
  int axis = 2, span = 0;
  double outer = 0, inner = 0, radius = 0, speed = 0;  // m, m, m, m/s
  std::uint8_t material = 0;
  Place place_of_outer = {}, place_of_inner = {};
};

struct Supports {
  std::optional<Glue> glue = {};
  std::vector<Clamp> clamps = {};
  std::vector<EndLoad> loads = {};
  std::variant<std::monostate, Platens, Rollers> press = {};
};

/// A sample in a periodic cell or between six walls is compressed before its test begins.
struct Preparation {
  double pressure = 0;  // Pa
  Place place_of_pressure = {};
  double friction = 0;  // between grains meanwhile; where a void ratio is asked what is tried first
  QuasiStatic quasi_static = {};
  std::optional<double> void_ratio = {};  // that it leaves; see sample/density.hpp
  Place place_of_density = {};
};

using Listed = std::vector<ListedGrain>;

struct Recipe {
  Bounds bounds = Bounds::open;
  Vec3 box = Vec3::Zero();         // m, corner at the origin; of a cylinder [diameter, diameter, height]
  std::uint8_t wall_material = 0;  // of the bounds
  std::variant<Listed, RandomPacking, Lattice, Spheres, VoronoiPacking, Prisms, FilledGrains, Bodies, Agglomerates>
      grains = {};
  std::vector<OwnWall> walls = {};
  std::vector<Side> sides = {};  // of bounds that are walls
  std::vector<RoughWall> rough = {};
  Supports supports = {};
  std::optional<Preparation> preparation = {};

  bool periodic() const { return bounds == Bounds::periodic; }
  bool repeats() const { return periodic() || bounds == Bounds::periodic_xy; }  // along x and y
  /// The first axis along which it does not; 3: none.
  int first_walls() const { return periodic() ? 3 : bounds == Bounds::periodic_xy ? 2 : 0; }
  bool between_plates() const { return bounds == Bounds::cylinder || bounds == Bounds::periodic_xy; }
  bool has_sides() const { return bounds == Bounds::walls || between_plates(); }
  bool random() const { return std::holds_alternative<RandomPacking>(grains); }  // takes its time to be made
  const Listed* listed() const { return std::get_if<Listed>(&grains); }
  bool of_voronoi() const;  // tessellation, prisms, filled grains, or bodies from elsewhere
  bool of_hulls() const;    // some grain is one
  bool in_cylinder() const;
  bool at_mesh() const;  // some wall is a surface of triangles
  /// How many grains, about: Voronoi cells may be merged, random packings round.
  double count() const;
};

/// The material of Voronoi cells, of bodies from elsewhere the first one's; null: there are none.
const std::uint8_t* voronoi_material(const Recipe& recipe);

/// The grains make up an upright cylinder.
bool is_round(const Recipe& recipe);

/// The box that a lattice makes (m).
Vec3 box_of(const Lattice& lattice, bool periodic);

/// Prisms in a box (m). Throws InputError where not one fits.
Tessellation prisms_of(const Prisms& prisms, const Vec3& box);

/// The box that Voronoi cells fill (m): of prisms what whole ones take.
Vec3 voronoi_box(const Recipe& recipe);

/// A piece of a random packing in its bounds, of a thousand grains: enough to tell the time step and the cost of a
/// grain. None where the sample is not larger.
std::optional<Recipe> piece_of(const Recipe& recipe);

/// Why a grain of this radius has no mass or inertia that a number holds; empty: it has.
std::string unthinkable_mass(const Material& material, double radius);

/// Throws InputError: the place, if there is one, and why.
[[noreturn]] void refuse(const Place& place, const std::string& why);

}  // namespace grus::dem
