// SPDX-License-Identifier: LGPL-3.0-or-later
// [loading] kind = "true-triaxial": three axes, each by itself.
#pragma once

#include "apps/scene/reader.hpp"
#include "dem/sample/programme.hpp"

namespace grus::app {

void read_true_triaxial(Table& loading, dem::Programme& test);

}  // namespace grus::app
