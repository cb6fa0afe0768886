// SPDX-License-Identifier: LGPL-3.0-or-later
// The contact that is deepest for its size.
#pragma once

#include "dem/state/contacts.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

/// Largest overlap relative to the smaller equivalent radius, and the pair that has it.
struct DeepestContact {
  double ratio = 0;
  std::size_t pair = 0;
};
DeepestContact deepest_contact(const Grains& grains, const Contacts& contacts);

}  // namespace grus::dem
