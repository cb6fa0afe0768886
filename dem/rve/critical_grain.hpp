// SPDX-License-Identifier: LGPL-3.0-or-later
// Which grain sets the time step, and how.
#pragma once

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct CriticalGrain {
  std::uint32_t id = 0;
  double diameter = 0, width = 0;  // of the sphere of equal volume; the least (m)
  double turning = 0;              // share of it in its fastest motion; NaN: its speed sets the step
};

/// Of a state whose contacts have been shown and indexed: at the end of a run.
CriticalGrain critical_grain(const Model& model, const State& state);

}  // namespace grus::dem
