// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/macro_energy.hpp"

#include <algorithm>
#include <cmath>

namespace grus::fem {

double MacroEnergy::error() const {
  MacroEnergy now = *this;
  now.note_largest();
  return now.largest > 0 ? (external - kinetic - internal - viscous - damped + scaled) / now.largest : 0;
}

double MacroEnergy::kinetic_over_internal() const {
  const double held = std::max(std::abs(internal), std::abs(external));
  return held > 0 ? kinetic / held : 0;
}

void MacroEnergy::note_largest() {
  largest = std::max({largest, std::abs(external), kinetic, std::abs(internal), viscous, damped});
}

}  // namespace grus::fem
