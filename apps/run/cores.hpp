// SPDX-License-Identifier: LGPL-3.0-or-later
// How many threads make sense here.
#pragma once

namespace grus::app {

/// Cores that this process may use, by its affinity mask and the quota of its control group; at least 1.
int usable_cores();

}  // namespace grus::app
