// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls that do not give way, as rows of the cone solver: several points a contact, none of which may close by more
// than its gap in a step.
#pragma once

#include "dem/motion/cone_solver.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"
#include "dem/shape/patch_points.hpp"

namespace grus::dem {

/// A row's contact.
struct RigidPoint {
  Index pair = 0;
  Vec3 driven = Vec3::Zero();  // m/s: how the boundary moves b, or its image
  Vec3 at = Vec3::Zero();      // from the mass centre of a (m)
  double gap = 0;              // m, from the overlap that contacts keep; negative: deeper
  ConeRows moved{};            // m/s: how the rows move, the boundary's motion included
};

struct RigidSystem {
  std::vector<ConeBody> body;        // by grain
  std::vector<ConeContact> contact;  // by point, those of a pair one after the other
  std::vector<RigidPoint> point;     // the same
  std::vector<Patch> patch;          // by pair
};

/// Contacts keep this overlap, of the smaller radius: by it they are found, and know which way they lie.
inline constexpr double kept_overlap = 1e-4;

/// `dt` (s): the step to come. Directions of pairs that are apart are looked for, and kept in touch.normal.
void fill(const Model& model, State& state, double dt, Team& team, RigidSystem& system);

}  // namespace grus::dem
