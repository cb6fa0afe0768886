// SPDX-License-Identifier: LGPL-3.0-or-later
// numerics.engine = "implicit": what such steps cannot do is refused.
#pragma once

#include "dem/rve/implicit_stepper.hpp"
#include "dem/sample/programme.hpp"

namespace grus::app {

class Table;

/// After the materials and numerics.inertia, whose place it takes in what is refused of fast tests.
void read_implicit(Table& numerics, dem::Model& model, bool unit_cell);

/// The test of [loading].
void check_implicit(Table& loading, dem::TestKind kind);

}  // namespace grus::app
