// SPDX-License-Identifier: LGPL-3.0-or-later
// numerics.engine = "implicit": what such steps cannot do is refused.
#pragma once

#include <optional>
#include <string>

#include "dem/sample/programme.hpp"

namespace grus::app {

class Table;

/// After the materials and numerics.inertia, whose place it takes in what is refused of fast tests.
void read_implicit(Table& numerics, dem::Model& model, bool unit_cell);

/// The test of [loading].
void check_implicit(Table& loading, const dem::Model& model, dem::TestKind kind);

/// A stage; `stands`: nothing drives its boundary.
void check_rigid(Table& stage, const dem::Model& model, bool stands);

/// What is to be told of grains that do not give way.
std::optional<std::string> note_of_rigid(const dem::Model& model);

}  // namespace grus::app
