// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/cores.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace grus::app {
namespace {

/// Cores by the CPU quota of a control group (version 2, then 1); no quota: infinite.
double quota_of(const std::string& folder) {
  std::string quota;
  double period = 0, time = 0;
  if (std::ifstream in(folder + "/cpu.max"); in >> quota >> period && quota != "max" && period > 0)
    return std::strtod(quota.c_str(), nullptr) / period;
  std::ifstream of(folder + "/cpu.cfs_quota_us"), per(folder + "/cpu.cfs_period_us");
  return of >> time && per >> period && time > 0 && period > 0 ? time / period : INFINITY;
}

}  // namespace

double tightest_quota(std::istream& groups, const std::vector<std::string>& roots) {
  double cores = INFINITY;
  for (std::string line; std::getline(groups, line);) {
    const auto path = line.rfind(':');
    if (path == std::string::npos) continue;
    for (const std::string& root : roots)
      for (std::filesystem::path at = line.substr(path + 1);;
           at = at.parent_path()) {  // the tightest of the group and those above it
        cores = std::min(cores, quota_of(root + at.string()));
        if (at == at.parent_path()) break;
      }
  }
  return cores;
}

int usable_cores() {
  cpu_set_t mask;
  CPU_ZERO(&mask);
  const double cores = sched_getaffinity(0, sizeof mask, &mask) == 0 ? static_cast<double>(CPU_COUNT(&mask))
                                                                     : std::thread::hardware_concurrency();
  std::ifstream groups("/proc/self/cgroup");
  const double quota = tightest_quota(groups, {"/sys/fs/cgroup", "/sys/fs/cgroup/cpu", "/sys/fs/cgroup/cpu,cpuacct"});
  return std::max(1, static_cast<int>(std::floor(std::min(cores, quota))));
}

}  // namespace grus::app
