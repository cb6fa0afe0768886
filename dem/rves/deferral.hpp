// SPDX-License-Identifier: LGPL-3.0-or-later
// Deferral: an RVE is not asked where what it last said foretells so small a change that its answer is known well
// enough.
#pragma once

#include <optional>

#include "dem/rve/rve.hpp"

namespace grus::dem {

/// The last answer of an RVE by DEM.
struct Memory {
  bool heard = false;               // it has answered at least once
  Mat3 pending = Mat3::Identity();  // deformation since it last advanced
  Mat3 stress = Mat3::Zero();       // as it last advanced
  Mat6 tangent = Mat6::Zero();
  double trust = 1;  // of the tolerance, lowered where predictions were bad
  struct Trial {
    Mat3 increment;  // since the last commit
    Response response;
  };
  std::optional<Trial> trial;  // the last answer of this increment, not committed
};

/// Its last answer, in this increment or at the last commit, and the deformation since, up to an increment.
struct Told {
  const Mat3& stress;
  const Mat6& tangent;
  Mat3 beyond;
};
Told told(const Memory& memory, const Mat3& increment);

struct Deferral {
  double tolerance = 0;  // largest predicted stress change relative to the stress; 0: off
  double floor = 0;      // Pa: no stress counts as smaller

  double scale(const Mat3& stress) const { return std::max(stress.norm(), floor); }

  /// Whether the tangent foretells so small a change of stress that no DEM is needed.
  bool foretells(const Memory& memory, const Mat3& increment) const;

  /// The RVE has been to where it was believed to be: returns how wrong that was, relative to the stress, and lets the
  /// memory start from there, with less trust where the error comes near the tolerance.
  double caught_up(Memory& memory, const Response& response) const;
};

/// The increment is committed, `answer` by DEM unless it was put off. Returns what the RVE itself commits: the answer,
/// or the last one of the increment that was not put off; null where there was none.
const Response* commit(Memory& memory, const Mat3& increment, bool deferred, const Response& answer);

}  // namespace grus::dem
