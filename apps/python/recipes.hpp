// SPDX-License-Identifier: LGPL-3.0-or-later
// What grus/samples.py asks for, as the description of a cell.
#pragma once

#include <pybind11/pybind11.h>

#include "apps/scene/rve_scene.hpp"

namespace grus::python {

/// Of a dict of plain values, all there and of their types (samples.py sees to that); `name`: what errors call it.
app::RveScene scene_of(const pybind11::dict& asked, const std::string& name);

}  // namespace grus::python
