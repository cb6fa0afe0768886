// SPDX-License-Identifier: LGPL-3.0-or-later
// Candidate pairs within the skin, binned by kind, with what each contact remembers.
#pragma once

#include <array>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

/// Pairs of one kind share a loop. `general` is any pair of grains of which one is not a sphere.
enum Bin : int { sphere_sphere, general, sphere_wall, polyellipsoid_wall, bin_count };

/// Grain a < b; `image` is the number of cell vectors added to b. For walls, b is the wall's index.
struct Pair {
  Index a, b;
  std::array<std::int16_t, 3> image{};
  std::uint16_t law = 0;  // row of the model's table of pair laws
  bool operator==(const Pair&) const = default;
};

/// What a contact remembers. Touching when stiffness > 0.
struct Contact {
  Vec3 normal = Vec3::Zero();  // unit, from a to b; the search direction while apart
  double overlap = 0;          // m, > 0 touching
  Vec3 spring = Vec3::Zero();  // tangential elastic force on b (N)
  double stiffness = 0;        // Hertz: F = stiffness overlap^1.5; linear: F = stiffness overlap. Frozen at contact birth
  double radius = 0;           // effective radius (m), frozen at contact birth
  double effective_mass = 0;   // kg
  double tangential = 0;       // current tangential stiffness (N/m)
  double shear_energy = 0;     // held by the spring (J)
  double viscous = 0;          // viscous part of the normal force (N)
};

/// Force of a contact as grains feel it: +force on b, -force on a.
struct ContactForce {
  Vec3 force, torque_a, torque_b;
};

/// Work and dissipation of one block of pairs since the last flush (J).
struct BlockEnergy {
  double friction = 0, viscous = 0, work = 0;
};

struct Contacts {
  std::array<std::size_t, bin_count + 1> begin{};  // bins are ranges of the columns below, each sorted by (a, b, image)
  std::vector<Pair> pair;
  std::vector<Contact> contact;
  std::vector<ContactForce> force;
  std::vector<Index> first, entry;  // of grain i: entry[first[i]..first[i+1]) = 2 * pair + (is b)
  std::vector<BlockEnergy> energy;

  std::size_t size() const { return pair.size(); }
};

/// Touching contacts of grain i, walls included.
inline int coordination(const Contacts& c, std::size_t i) {
  int touching = 0;
  for (Index e = c.first[i]; e < c.first[i + 1]; ++e) touching += c.contact[c.entry[e] >> 1].stiffness > 0;
  return touching;
}

}  // namespace grus::dem
