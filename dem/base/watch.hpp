// SPDX-License-Identifier: LGPL-3.0-or-later
// How long work tells how far it is, and hears that it is to stop: asked between passes, never in a loop over contacts.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace grus::dem {

/// Told the part that is done, 0 to 1; false: stop. Empty: nobody watches.
using Watch = std::function<bool(double done)>;

/// Work that has nothing to keep was stopped by its watch. Exit status 130.
struct Interrupted : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws Interrupted, which says `what` was stopped, where the watch says so.
inline void tell(const Watch& watch, double done, const char* what) {
  if (watch && !watch(done))
    throw Interrupted(std::string("interrupted while ") + what + "; nothing to go on from yet");
}

}  // namespace grus::dem
