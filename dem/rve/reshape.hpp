// SPDX-License-Identifier: LGPL-3.0-or-later
// Fragments of a state change their shape or swell: geometry changes, and every joule of it is booked.
#pragma once

#include <optional>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// A surface grew by `amount` (m) along the normal of a contact.
struct Growth {
  std::size_t contact;
  double amount;
};

/// Growth that a step of transition leaves for its second half, and columns that are kept from step to step.
struct Reshaping {
  std::vector<Growth> growths;
  double furthest = 0;  // by how much any surface grew (m)
  std::vector<std::uint8_t> held;
  std::vector<std::optional<PolyEllipsoid>> next;
};

/// Steps between looks at the sample's mean pressure, above which a ball does not swell.
inline constexpr std::uint64_t pressure_every = 10;

/// Lets every free, badly shaped fragment change its shape, and every ball that lacks volume swell, for `duration`
/// (s), one step at a time: after the drift and before the forces, so that leapfrog sees a slowly varying potential.
/// ledger.reshape gets the change of spin energy at constant angular momentum, and half the work of growing surfaces,
/// at the forces before; `book_growth` adds the other half at the forces after (the trapezoid that the integrator's own
/// work uses).
void reshape_fragments(const Model& model, State& state, double duration, Reshaping& now, Team& team);
void book_growth(const Model& model, State& state, const Reshaping& now);

}  // namespace grus::dem
