// SPDX-License-Identifier: LGPL-3.0-or-later
// Where energy, mass and momentum went. Nothing is lost silently: every sink has its name.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Fines of one origin, s = 3 - dimension: mass below d is mass x (d^s - smallest^s) / (top^s - smallest^s).
struct FinesClass {
  std::int64_t octave8;  // round(8 log2 of top in m): classes of an eighth of an octave
  double dimension;      // of the material that broke
  double smallest;       // m
  double mass;           // kg
};

/// Taken out of the grains by splits: the parent's volume less the children's, moving on in the parent's rigid velocity
/// field.
struct Fines {
  double mass = 0, kinetic = 0;
  double volume = 0;  // solid (m^3): mass over the density of the material that broke
  Vec3 momentum = Vec3::Zero(), angular_momentum = Vec3::Zero();  // about the global origin
  std::vector<FinesClass> classes;
};

inline void add_fines(Fines& fines, double top, double smallest, double dimension, double mass) {
  const std::int64_t octave8 = std::lround(8 * std::log2(top));
  for (auto& c : fines.classes)
    if (c.octave8 == octave8 && c.dimension == dimension && c.smallest == smallest) return void(c.mass += mass);
  fines.classes.push_back({octave8, dimension, smallest, mass});
}

/// Filled only where the scene asks for it: what the halves kept of their parents' contacts at the instant of the
/// split.
struct SplitStatistics {
  std::size_t events = 0, instants = 0, contacts = 0, contacts_kept = 0;
  double force = 0, force_kept = 0;  // N, normal, summed
  double pressure_jump = 0;          // relative jumps of the sample's pressure, summed over the instants
};

/// Grains that were tested for cracks (rve/crack_tests.hpp).
struct CrackCounts {
  std::size_t tests = 0, holds = 0, cracks = 0;
  std::size_t stalled = 0;  // such that neither held nor parted, or only into wedges too thin: left whole
  double bond_energy = 0;   // that bonds in cracked grains gave up (J); rigid grains have never held it
};

/// Energies in J since the start of the run; dissipation is positive.
struct Ledger {
  double work = 0;  // of walls, cell and gravity on the grains
  double friction =
      0;  // Coulomb's limit times plastic slip, what springs shed as their stiffness changes, what parting ones hold
  double damping = 0;        // dashpots of contacts and bonds, and local damping
  double local_damping = 0;  // of it: by the grains' local damping, a device that no contact knows
  double bond_damping = 0;   // of it: by the dashpots of face bonds
  double bond_friction = 0;  // of friction: by what has given way of face bonds
  double adhesion = 0;       // contacts with attraction that snap on and off
  double fracture = 0;       // softening of bonds, as they take it: never falls
  double handed = 0;         // held by the pressed part of broken bonds, and by no contact that goes on with them
  double split =
      0;  // elastic energy that the parents' contacts held, less that of the children's and of newborn springs
  double split_added = 0;  // of it, summed over the instants at which more was put in (springs' birth) than left
  double reshape = 0;      // put in by shape transition: work of growing surfaces, spin x change of inertia x spin
  double inertia = 0;      // put in at births by scaled inertia: kinetic energy beyond the parent's
  double unexplained =
      0;  // what springs, splits and reshaped spins lost by the change of what they hold, beyond the above
  double most_friction = 0, most_damping = 0, most_fracture = 0;  // so far: none can fall
  double most_work = 0;                                           // |work|, the largest so far
  double start = 0;                                               // stored energy at the start
  double floor = 0;           // below this, energies are round-off: see energy_floor
  double fracture_area = 0;   // m^2 of planes made and of bonds broken
  double residual_force = 0;  // N, summed: part of the children's initial forces that springs could not carry
  std::size_t breakages = 0, bonds_broken = 0;
  std::size_t planes_dropped = 0;  // by pieces of hulls that would have had too many faces or corners
  CrackCounts cracks;
  Fines fines;
  SplitStatistics splits;

  double spent() const { return friction + damping + adhesion + fracture + handed + split + fines.kinetic; }
};

/// By bonds, whatever way (J).
inline double taken_by_bonds(const Ledger& l) { return l.fracture + l.bond_friction + l.handed; }

/// The scale that energies are judged against: the largest work so far, stored or held at the start, of the floor at
/// least (J). Work that was given back counts as exchanged: a ball that has bounced is back where nothing is stored and
/// the work of gravity is 0. A peak, not a sum of all that went to and fro: noise that lasts must not hide a fault.
inline double energy_scale(const Ledger& l, double stored) {
  return std::max({l.most_work, std::abs(l.work), std::abs(stored), std::abs(l.start), l.floor});
}

/// Friction and damping may fall, and splits may add, by this much of that scale: a dashpot's trapezoid errs by its
/// last step.
inline constexpr double least_dissipation_error = 0.01;

/// (work, reshaping and scaled inertia - change of everything stored or dissipated) / energy_scale: what is smaller is
/// round-off, and says nothing.
inline double energy_error(const Ledger& l, double stored) {
  const double scale = energy_scale(l, stored);
  return scale > 0 ? (l.work + l.reshape + l.inertia - (stored - l.start) - l.spent()) / scale : 0;
}

}  // namespace grus::dem
