// SPDX-License-Identifier: LGPL-3.0-or-later
// Balls that are born with their mother's mass in half of her volume grow at a bounded rate until the material has its
// density again: what fourteen balls do not fill is not lost, and contacts that the split has opened close. The
// surface does work on the neighbours, which is booked (rve/reshape.hpp); a ball waits while it is pressed harder than
// the sample.
#pragma once

#include <optional>

#include "dem/contact/laws.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// A ball of fourteen takes this many contact times to the 1.2327 times larger radius that its mass wants.
inline constexpr double swelling_times = 20;

/// But no more than this part of that radius in a step: contacts are to stiffen slowly, however light they are.
inline constexpr double swelling_step = 1e-3;

/// Radius (m) of ball i after a time `duration` of growth at the material's `density` (kg/m^3); none where it has its
/// volume. `stiffness` (N/m): with the ball's mass, half a period is a contact time.
std::optional<double> next_radius(const Grains& grains, std::size_t i, double density, double stiffness,
                                  double duration);

/// Forces of touching contacts times distance from the centre, over three times the volume (Pa): of ball i, and of
/// all grains. Contacts must be shown, those of a ball indexed by grain.
double mean_pressure(const ContactLaw& law, const Grains& grains, const Contacts& contacts, std::size_t i);
double mean_pressure(const ContactLaw& law, const Grains& grains, const Contacts& contacts);

}  // namespace grus::dem
