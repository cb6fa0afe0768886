// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether a candidate pair is near enough for the list.
#pragma once

#include "dem/contact/broad_phase.hpp"

namespace grus::dem {

/// Bounding spheres closer than `skin`: for spheres the answer, for other shapes a first question.
bool close(const Grains& g, const Cell& cell, const Candidate& pair, double skin);

}  // namespace grus::dem
