// SPDX-License-Identifier: LGPL-3.0-or-later
// PETSc's options (prefix grus_), which change the linear solver of Newton's increments.
#pragma once

#include <string>
#include <vector>

#include "fem/statics.hpp"

namespace grus::fem {

/// What PETSc has against the options that it has been given, in one line with their names and values; empty: nothing.
std::string fault_of_linear_options(LinearMethod method);

/// Options of that prefix that nothing has asked for, such as "-grus_kps_type cg": misspelt ones.
std::vector<std::string> unused_linear_options();

}  // namespace grus::fem
