// SPDX-License-Identifier: LGPL-3.0-or-later
// How many threads make sense here.
#pragma once

#include <istream>
#include <string>
#include <vector>

namespace grus::app {

/// Cores that this process may use, by its affinity mask and the quota of its control group; at least 1.
int usable_cores();

/// The tightest CPU quota, in cores, of control groups as /proc/self/cgroup lists them, and of those above them;
/// `roots` are where they may be mounted. Infinite where there is none.
double tightest_quota(std::istream& groups, const std::vector<std::string>& roots);

}  // namespace grus::app
