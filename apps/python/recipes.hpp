// SPDX-License-Identifier: LGPL-3.0-or-later
// The description of a unit cell that grus/samples.py asks for.
#pragma once

#include <pybind11/pybind11.h>

#include "apps/scene/rve_scene.hpp"

namespace grus::python {

/// The scene that a dict of plain values asks for, all there and of their types (samples.py sees to that); `name`: what
/// errors call it.
app::RveScene scene_of(const pybind11::dict& asked, const std::string& name);

}  // namespace grus::python
