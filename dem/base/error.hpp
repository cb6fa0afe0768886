// SPDX-License-Identifier: LGPL-3.0-or-later
// The two errors that the libraries throw: at edges and between passes, never in a loop over contacts.
#pragma once

#include <stdexcept>
#include <string>

namespace grus::dem {

/// The user's input cannot be used; one line that says what to change. Exit status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The run left the range where its results mean anything; one line: quantity, place, what to try. Exit status 3.
struct Unstable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace grus::dem
