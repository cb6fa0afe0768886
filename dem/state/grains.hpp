// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains as plain columns. Positions are centres of mass and never wrapped in a periodic cell.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {

/// The kind of a grain's shape; a row of `shape_functions` (shape_kinds.hpp), and of the table of pairs
/// (contact/pair_kinds.hpp).
enum class ShapeKind : std::uint8_t { polyellipsoid, sphere, hull };

/// A grain's size, as every room may know it without asking its shape. The bounding radius is motion.radius, the
/// centre of mass motion.position.
struct Extent {
  double volume;             // m^3
  double equivalent_radius;  // of the sphere of equal volume (m)
  double least_width;        // m
};

/// The motion of a grain, which the contact loops read; global frame, SI.
struct Motion {
  Vec3 position;
  double radius;  // of the sphere, or of the bounding sphere about the centre of mass
  Vec3 velocity;
  double inverse_mass;
  Vec3 spin;               // rad/s
  double inverse_inertia;  // of a sphere
};

/// Placement of a poly-ellipsoid: octant origin and geometry -> global rotation.
struct Frame {
  Vec3 origin;
  Mat3 axes;
};

/// Principal moments (kg m^2) and the rotation principal -> geometry; constant over a grain's life.
struct Inertia {
  Vec3 moments;
  Quat axes;
};

/// What a grain bore when it was last tested for cracks and held.
struct HeldLoad {
  Mat3 moment = Mat3::Zero();  // sum of force x arm, geometry frame (N m)
  double contacts = 0;
};

struct Grains {
  std::vector<Motion> motion;
  std::vector<Quat> orientation;  // geometry -> global
  std::vector<Vec3> angular_momentum, force, torque;
  std::vector<double> mass;        // kg; what resists motion
  std::vector<double> solid_mass;  // kg; empty where that is the same: no inertia is scaled
  std::vector<double> turn_mass;   // kg; moments are those of a solid of it; empty where that is `mass`
  std::vector<Inertia> inertia;
  std::vector<PolyEllipsoid> shape;  // spheres, too; of a hull the sphere of equal volume
  std::vector<ShapeKind> kind;
  std::vector<Extent> extent;  // follows from the shape
  std::vector<std::uint8_t> material;
  std::vector<std::uint32_t> id;         // never reused
  std::vector<Frame> frame;              // empty unless some grain is not a sphere
  std::vector<double> strength;          // factor on the characteristic strengths; empty without a fracture table
  std::vector<std::uint8_t> generation;  // splits since the start; empty without a fracture table
  std::vector<double> utilisation;  // how near to failing at the last breakage test, NaN: not tested yet; empty without
                                    // a fracture table
  std::vector<std::uint64_t> born;  // step in which a fragment was made; empty unless some limit asks for rest
  std::vector<Quat> crystal;        // crystal -> geometry; empty unless some grain cleaves along planes of its crystal
  std::vector<Index> hull;          // row of `hulls`; empty unless all are hulls
  std::shared_ptr<const HullStore> hulls;  // never changed once made: states share it
  std::vector<HeldLoad> held;              // empty unless some grain is tested for cracks
  std::uint32_t next_id = 0;

  std::size_t size() const { return motion.size(); }
};

/// Calls f on every column: copying and hashing use this list.
template <class G, class F>
void for_each_column(G& g, F&& f) {
  f(g.motion);
  f(g.orientation);
  f(g.angular_momentum);
  f(g.force);
  f(g.torque);
  f(g.mass);
  f(g.inertia);
  f(g.shape);
  f(g.kind);
  f(g.material);
  f(g.id);
  f(g.frame);
  f(g.strength);
  f(g.generation);
  f(g.utilisation);
  f(g.extent);
  f(g.born);
  f(g.solid_mass);
  f(g.hull);
  f(g.crystal);
  f(g.turn_mass);
  f(g.held);
}

/// Empties a column for good: its room goes, too.
template <class Column>
void drop(Column& column) {
  column = Column();
}

inline bool is_sphere(const Grains& g, std::size_t i) { return g.kind[i] == ShapeKind::sphere; }

/// Pose and motion of a grain to be made; position is the centre of mass.
struct GrainSpec {
  PolyEllipsoid shape;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();
  Quat orientation = Quat::Identity();
  std::uint8_t material = 0;
  double density = 0;
  double inertia = 1;                // mass that resists motion, over density x volume
  bool turns = true;                 // false, of a sphere alone: it keeps its orientation
  std::optional<Quat> crystal = {};  // crystal -> geometry
  std::optional<Index> hull = {};    // row of the grains' hulls: takes the place of `shape`
};

/// Writes a grain into slot `i` (== size() appends): mass, inertia and bounds from the shape. The id is new.
void set_grain(Grains& grains, std::size_t i, const GrainSpec& spec);

/// Gives grain i another shape about the same centre of mass: mass, orientation, velocity and angular momentum stay,
/// inertia, spin and the cached frame follow.
void set_shape(Grains& grains, std::size_t i, const PolyEllipsoid& shape);

/// All that follows from the shape (or the hull) and the mass of grain i, again: the same bits as at its birth.
void restore_shape(Grains& grains, std::size_t i);

/// Recomputes the cached frames (all grains, once any is not a sphere).
void update_frames(Grains& grains);
Frame frame_of(const Grains& grains, std::size_t i);

/// Spin (rad/s, global) that belongs to the angular momentum of grain i at its orientation.
Vec3 spin_of(const Grains& grains, std::size_t i);

/// Inertia tensor about the centre of mass in the global frame (kg m^2).
Mat3 inertia_tensor(const Grains& grains, std::size_t i);

/// Density x volume (kg), whatever resists motion.
inline double solid_mass(const Grains& g, std::size_t i) { return g.solid_mass.empty() ? g.mass[i] : g.solid_mass[i]; }

/// What resists turns (kg): the moments are those of a solid of this mass.
inline double turn_mass(const Grains& g, std::size_t i) { return g.turn_mass.empty() ? g.mass[i] : g.turn_mass[i]; }

/// Gives grain i other masses (kg), that resist shifts and turns; velocity and spin stay, all that follows is renewed.
void set_inertia(Grains& grains, std::size_t i, double mass, double turning);

double kinetic_energy(const Grains& grains, std::size_t i);
double kinetic_energy(const Grains& grains);  // J, translation and rotation
double total_mass(const Grains& grains);      // of solid
double solid_volume(const Grains& grains);
Vec3 momentum(const Grains& grains);
Vec3 angular_momentum(const Grains& grains);  // about the global origin

}  // namespace grus::dem
