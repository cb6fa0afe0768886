// SPDX-License-Identifier: LGPL-3.0-or-later
// Which points go together: points of one history have one RVE (exact sharing: the same bits as without), and, where a
// tolerance is given, points of similar history ride on one (similar sharing). Pure book-keeping: it says what is to be
// advanced, copied and replayed, and touches no grain.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

struct Sharing {
  struct Point {
    std::uint64_t slot = 0;
    std::size_t variant = 0;        // of the prepared states
    double distance = 0;            // largest so far to the slot's leader (similar sharing)
    Mat3 total = Mat3::Identity();  // F since the start
  };
  std::vector<Point> point;
  std::map<std::uint64_t, std::size_t> leader;  // of each slot: the point whose path its RVE has had
  std::vector<std::vector<Mat3>> path;          // committed increments of every point; similar sharing only
  std::map<std::uint64_t, std::vector<std::uint64_t>> copies;  // of a slot, that this increment has needed
  std::uint64_t next_slot = 0;
  double tolerance = 0;  // similar sharing: largest difference of deformation gradients, over the history; 0: off
};

/// The needs of a response. Copies come first, then replays, then jobs.
struct SharingPlan {
  struct Job {
    std::uint64_t slot;
    std::size_t leader;
    Mat3 increment;  // since the last commit
  };
  struct Copy {
    std::uint64_t from, to;
  };
  /// A point that has ridden on another's path gets an RVE of its own, which has to go the point's own path from the
  /// prepared state.
  struct Replay {
    std::size_t point;
    std::uint64_t slot, was;
    double distance;
  };
  std::vector<Job> job;
  std::vector<std::size_t> of;  // job of each point
  std::vector<Copy> copy;
  std::vector<Replay> replay;
  bool apart = false;  // of points that have parted: job i is point i's
};

/// Point i starts from prepared state start[i]; without `exact` each gets a slot of its own. The slots are the keys of
/// `leader`.
Sharing begin_sharing(std::span<const std::size_t> start, bool exact, double tolerance);

/// Throws InputError where points of a file go with nobody, or with one that is not there.
void check_sharing(const Sharing& sharing, const std::map<std::uint64_t, std::size_t>& leader, std::size_t variants);

/// Every point has an RVE of its own, and for good.
inline bool parted(const Sharing& s) { return s.tolerance == 0 && s.leader.size() == s.point.size(); }

/// Jobs for these increments, one a point.
SharingPlan plan(Sharing& sharing, std::span<const Mat3> increment);

/// One job a point, where all have parted; in the room of the plan before, of which little changes.
void plan_parted(const Sharing& sharing, std::span<const Mat3> increment, SharingPlan& plan);

/// The replay could not be done: the point stays where it was.
void undo(Sharing& sharing, const SharingPlan::Replay& replay);

/// The copy could not be made: the next plan asks for another one.
void undo(Sharing& sharing, const SharingPlan::Copy& copy);

/// The points go on with the jobs of the plan. Returns the slots that nobody needs any more, which are forgotten.
std::vector<std::uint64_t> commit(Sharing& sharing, const SharingPlan& plan, std::span<const Mat3> increment);

}  // namespace grus::dem
