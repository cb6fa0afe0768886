// SPDX-License-Identifier: LGPL-3.0-or-later
// A state's grains and contacts as NumPy arrays.
#pragma once

#include <pybind11/numpy.h>

#include <memory>

#include "dem/rve/state.hpp"

namespace grus::python {

/// Name -> array, one row a grain; views into the state, which lives as long as any of them.
pybind11::dict grains_of(const std::shared_ptr<const dem::State>& state);

/// Name -> array, one row a touching contact.
pybind11::dict contacts_of(const dem::State& state);

}  // namespace grus::python
