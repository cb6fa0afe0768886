// SPDX-License-Identifier: LGPL-3.0-or-later
// MPI and PETSc for as long as it lives; make one in main.
#pragma once

namespace grus::fem {

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
