// SPDX-License-Identifier: LGPL-3.0-or-later
// The book that a driver of RVEs keeps between responses, and its rules that ask no host.
#pragma once

#include <span>
#include <string>

#include "dem/rves/deferral.hpp"
#include "dem/rves/driver_options.hpp"
#include "dem/rves/sharing.hpp"
#include "dem/rves/tangents.hpp"

namespace grus::dem {

struct DriverBook {
  /// An RVE, what it last said and what is known of it.
  struct Slot {
    Memory memory;
    Facts facts;
  };
  /// One increment of one slot in this response.
  struct Job {
    std::uint64_t slot;
    std::size_t leader;
    Mat3 increment;  // since the last commit
    bool deferred = false;
    Response response;       // by DEM, or by a tangent
    Facts* facts = nullptr;  // of its slot, once looked up; of points that have parted, who keep their slots
  };

  RveOptions options;
  Deferral deferral;
  std::size_t variants = 0;  // of the prepared states
  Sharing sharing;
  std::map<std::uint64_t, Slot> slots;
  std::vector<Mat3> stress;  // of the points, as committed; similar sharing only
  SharingPlan plan;
  std::vector<Job> jobs;  // of the plan
  SharingPlan last_plan;  // of points that have parted: what the increment before has left, to be filled anew
  std::vector<Job> last_jobs;
  Sweep now, before;  // this response, and the one before it in the same increment
  NoiseMeter noise;
  int sharp = 0;                   // increments that will have the network's tangent
  std::vector<Mat6> kept_tangent;  // elastic, quasi-Newton
  SweepReport report;
  std::string reason;               // why the last response failed
  std::vector<std::int64_t> names;  // of the points, for messages; empty: their places here
};

DriverBook begin_book(std::span<const std::size_t> start, std::size_t variants, const RveOptions& options);

inline bool relaxed(const DriverBook& b) { return b.options.pace == Pace::relaxed; }

/// What RVEs last answered is kept by those who may put one off.
inline bool remembers(const DriverBook& b) { return b.options.error > 0; }
/// Whether the network's tangent is asked for.
inline bool sharp(const DriverBook& b) { return b.options.response.tangent == TangentKind::network || b.sharp > 0; }

/// Takes the points' increments (9 a point, row by row), put on a grid; alike where grains will do the same.
void take_increments(DriverBook& book, std::span<const double> deformation);

/// Jobs of points that have parted, for good and without a memory.
inline bool goes_alone(const DriverBook& b) { return !relaxed(b) && !remembers(b) && parted(b.sharing); }
void jobs_of_parted(DriverBook& book);

/// Adds what an RVE has done to the report.
void count_outcome(SweepReport& report, const Outcome& outcome);

/// Foretells the answer from the last one, instead of DEM; false: the RVE must be asked.
bool defer(const DriverBook& book, DriverBook::Job& job);

/// Every job has its response: what each point hears, or the reason why there is none. True: all answers are there.
bool conclude(DriverBook& book);

/// The increment is committed: returns slots of which the RVE's own last advance is to be, where there are trials.
std::vector<std::uint64_t> commit_jobs(DriverBook& book);

/// The points go on with their jobs; returns slots that nobody needs any more.
std::vector<std::uint64_t> end_increment(DriverBook& book);

/// Copies that the increment has made, which is not committed: forgotten, with its answers.
std::vector<std::uint64_t> forget_increment(DriverBook& book);

/// What responses change that is no RVE's own, as it is between two increments.
struct BetweenIncrements {
  std::uint64_t next_slot;
  std::vector<Mat6> kept_tangent;
  int sharp;
  SweepReport report;
};
BetweenIncrements between_increments(const DriverBook& book);
/// After forget_increment: as if the increment had not been begun. Not where RVEs were put off: those have caught up.
void go_back(DriverBook& book, const BetweenIncrements& before);

/// The next five increments have the network's tangent; false: they had it, or another kind was chosen.
bool sharpen(DriverBook& book);

/// Relative error of the stress of the last response: what the RVEs' own equilibrium leaves, or, measured, how far two
/// successive iterations disagree (tangents.hpp), at all points that `join` knows of. At most max_noise.
double noise(DriverBook& book, const Joining& join = {});
constexpr double max_noise = 0.03;

/// Slots whose RVEs are points', without copies of an increment that is not committed.
std::vector<std::uint64_t> lasting(const DriverBook& book);

/// All that decides how the points go on, but the states; and back, for a book that was begun alike. Throws InputError
/// for bytes that no book of as many points has left.
std::string book_bytes(const DriverBook& book);
DriverBook book_of(const DriverBook& own, const std::string& bytes);

/// What a message calls a point.
inline std::int64_t name(const DriverBook& b, std::size_t point) {
  return b.names.empty() ? static_cast<std::int64_t>(point) : b.names[point];
}

/// A memory as bytes; and one of a file that no run can have left is refused (InputError).
template <class A>
void archive_memory(A& a, auto& memory) {
  a.plain(memory.heard);
  a.plain(memory.pending);
  a.plain(memory.stress);
  a.plain(memory.tangent);
  a.plain(memory.trust);
}
void check_memory(const Memory& memory);

}  // namespace grus::dem
