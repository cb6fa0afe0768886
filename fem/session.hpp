// SPDX-License-Identifier: LGPL-3.0-or-later
// MPI and PETSc for as long as it lives; make one in main.
#pragma once

#include <sched.h>

#include <span>

namespace grus::fem {

/// How many of these sets of cores have one in common with `mine`.
int sharers_of(std::span<const cpu_set_t> all, const cpu_set_t& mine);

class Session {
public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  int rank() const { return rank_; }
  int ranks() const { return ranks_; }
  /// Ranks of this node, this one counted, that may run on a core that this one may run on.
  int sharers() const { return sharers_; }

private:
  int rank_ = 0, ranks_ = 1, sharers_ = 1;
};

}  // namespace grus::fem
