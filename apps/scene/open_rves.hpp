// SPDX-License-Identifier: LGPL-3.0-or-later
// The RVEs of a macro program from the scene file of their unit cell.
#pragma once

#include "dem/rves/rve_set.hpp"

namespace grus::app {

/// RVEs of `points` points: read, prepared and ready. `response`: lines KEY = VALUE, as in [rve] of a problem. Throws
/// InputError with file, line and key; Unstable where the preparation does not come to rest.
dem::RveSet open_rves(const std::string& file, const std::vector<std::string>& overrides, std::size_t points,
                      int threads = 1, const std::string& response = "");

}  // namespace grus::app
