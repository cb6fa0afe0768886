// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs, one for each Gauss point, that does no DEM the points do not need. Lives on rank 0.
#pragma once

#include <memory>
#include <optional>

#include "coupling/deferral.hpp"
#include "coupling/rve_farm.hpp"
#include "coupling/tangents.hpp"
#include "dem/rves/sharing.hpp"
#include "fem/material.hpp"

namespace grus::coupling {

/// What may be left out. With everything off every point advances an RVE of its own at every response.
struct RveOptions {
  dem::ResponseOptions response;
  dem::Pace pace = dem::Pace::relaxed;
  bool exact_sharing = true;  // points of one history have one RVE; the same bits as without
  double share = 0;           // similar sharing: largest difference of deformation gradients, over the history; 0: off
  double error = 0;           // deferral: largest predicted stress change relative to the stress, since the last commit
                              // or since this increment's last DEM answer; 0: off
};

/// How well a device keeps to its tolerance: errors measured whenever the truth comes out, relative to the stress.
struct MeasuredError {
  std::uint64_t count = 0;
  double worst = 0, sum = 0;
  void add(double error) {
    ++count;
    sum += error;
    worst = std::max(worst, error);
  }
  double mean() const { return count > 0 ? sum / static_cast<double>(count) : 0; }
};

/// Figures of the last commit and of everything since the start.
struct SweepReport {
  std::uint64_t asked = 0, advanced = 0, deferred = 0, elastic = 0, similar = 0, replayed = 0,
                retried = 0;  // answers; of them DEM runs, others
  std::uint64_t dem_steps = 0;
  std::uint64_t distinct = 0;               // RVEs now
  MeasuredError deferral, sharing, linear;  // prediction against what the RVE then did; at replays; of elastic points
  double least_trust = 1;                   // lowest share of the deferral tolerance that a slot was left with
  double correction = 0;                    // largest first-order correction of a similar point, relative to its stress
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the last commit
  double inertial_number = 0;                            // mean of the steady cells in the last response
  std::uint64_t given_up = 0;                            // RVEs that answer with what is left of their stiffness
};

class RveMaterial {
public:
  /// Point i starts from the prepared state `states[start[i]]`. Slots are made on the farm, which must outlive this.
  RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
              const RveOptions& options);

  /// Valid as long as this object.
  fem::Material material();

  /// Relative error of the stress of the last response: what the RVEs' own equilibrium leaves, or, measured, how far
  /// two successive iterations disagree (tangents.hpp). At most max_noise.
  double noise();
  static constexpr double max_noise = 0.03;

  std::size_t points() const { return sharing_.point.size(); }
  double start_volume(std::size_t point) const { return start_volume_[sharing_.point[point].variant]; }  // m^3
  const dem::Facts& facts(std::size_t point) const { return slots_.at(sharing_.point[point].slot).facts; }
  /// Sum of one energy of all points' RVEs (J), each for the volume (m^3, reference) that its point stands for.
  double total(dem::Facts::Number energy, std::span<const double> volumes) const;
  dem::State committed(std::size_t point) const;
  /// Brings facts up to date; needed where there is no way back and steps do not tell them.
  void refresh();
  const SweepReport& report() const { return report_; }
  double seconds() const { return seconds_; }         // wall time in responses
  std::uint64_t count(dem::Facts::Count what) const;  // of the committed states, every point counted

  /// All that decides how the points go on, handed over in parts (the states one by one); and back, into one that was
  /// made alike.
  void save(const std::function<void(const std::string&)>& take) const;
  void load(const std::vector<std::string>& parts);

private:
  /// An RVE, what it last said and what is known of it.
  struct Slot {
    Memory memory;
    dem::Facts facts;
  };
  /// One increment of one slot in this response.
  struct Job {
    std::uint64_t slot;
    std::size_t leader;
    dem::Mat3 increment;  // since the last commit
    bool deferred = false;
    dem::Response response;  // by DEM, or by a tangent
  };

  bool respond(const fem::Points& points);
  bool sharpen();
  bool sharp() const { return options_.response.tangent == dem::TangentKind::network || sharp_ > 0; }
  bool relaxed() const { return options_.pace == dem::Pace::relaxed; }
  void take_increments(const fem::Points& points);
  void find_jobs();
  void replay(const dem::SharingPlan::Replay& replay);
  void catch_up();
  void answer(double duration, bool tangent);
  void hand_over(const fem::Points& points) const;
  void commit();
  Answer corrected(std::size_t point, const Job& job);
  template <class A>
  static void archive(A& a, auto& material);

  RveFarm& farm_;
  RveOptions options_;
  Deferral deferral_;
  std::vector<std::string> prepared_;  // bytes of the starting states; similar sharing only
  std::vector<double> start_volume_;   // of the starting states
  dem::Sharing sharing_;
  std::map<std::uint64_t, Slot> slots_;
  std::vector<dem::Mat3> stress_;  // of the points, as committed; similar sharing only
  dem::SharingPlan plan_;
  std::vector<Job> jobs_;  // of the plan
  Sweep now_, before_;     // this response, and the one before it in the same increment
  NoiseMeter noise_;
  int sharp_ = 0;                        // increments that will have the network's tangent
  std::vector<dem::Mat6> kept_tangent_;  // elastic, quasi-Newton
  SweepReport report_;
  double seconds_ = 0;
  std::uint64_t commits_ = 0;  // of explicit runs, in this process
  std::string reason_;
};

}  // namespace grus::coupling
