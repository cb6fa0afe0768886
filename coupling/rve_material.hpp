// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs, one for each Gauss point, that does no DEM the points do not need. Lives on rank 0.
#pragma once

#include <memory>
#include <optional>

#include "coupling/rve_farm.hpp"
#include "fem/material.hpp"

namespace grus::coupling {

/// What may be left out. With everything off every point advances an RVE of its own at every response.
struct RveOptions {
  ResponseOptions response;
  Pace pace = Pace::relaxed;
  bool exact_sharing = true;  // points of one history have one RVE; the same bits as without
  double share = 0;           // similar sharing: largest difference of deformation gradients, over the history; 0: off
  double error = 0;           // deferral: largest predicted stress change relative to the stress, since the last commit
                              // or since this increment's last DEM answer; 0: off
};

/// How well a device keeps to its tolerance: errors measured whenever the truth comes out, relative to the stress.
struct MeasuredError {
  std::uint64_t count = 0;
  double worst = 0, sum = 0;
  void add(double error) { ++count, sum += error, worst = std::max(worst, error); }
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
  /// two successive iterations are from any tangent between none and the elastic one (from the elastic one where
  /// breakage differs). Sliding and breakage make the response a staircase: no residual goes below its steps. At most
  /// max_noise.
  double noise();
  static constexpr double max_noise = 0.03;

  std::size_t points() const { return point_.size(); }
  double start_volume(std::size_t point) const {
    return start_volume_[point_[point].variant];
  }  // of the prepared cell (m^3)
  const Facts& facts(std::size_t point) const { return slots_.at(point_[point].slot).facts; }
  /// Sum of one energy of all points' RVEs (J), each for the volume (m^3, reference) that its point stands for.
  double total(double Facts::*energy, std::span<const double> volumes) const;
  dem::State committed(std::size_t point) const;
  /// Brings facts up to date; needed where there is no way back and steps do not tell them.
  void refresh();
  const SweepReport& report() const { return report_; }
  double seconds() const { return seconds_; }  // wall time in responses
  std::uint64_t breakages() const;             // of the committed states, every point counted

  /// All that decides how the points go on, handed over in parts (the states one by one); and back, into one that was
  /// made alike.
  void save(const std::function<void(const std::string&)>& take) const;
  void load(const std::vector<std::string>& parts);

private:
  struct Point {
    std::uint64_t slot = 0;
    std::size_t variant = 0;
    double distance = 0;                      // largest so far to the slot's leader (similar sharing)
    dem::Mat3 total = dem::Mat3::Identity();  // F since the start
    dem::Mat3 stress = dem::Mat3::Zero();     // as committed
  };
  /// The last DEM answer of an increment.
  struct Trial {
    dem::Mat3 increment;  // since the last commit
    dem::Response response;
  };
  /// An RVE with the committed path of one of its points, and what it last said.
  struct Slot {
    std::size_t leader = 0;                     // point whose path it has had
    bool heard = false;                         // it has answered at least once
    dem::Mat3 pending = dem::Mat3::Identity();  // deformation since it last advanced (deferral)
    dem::Mat3 stress = dem::Mat3::Zero();       // as it last advanced
    dem::Mat6 tangent = dem::Mat6::Zero();
    double trust = 1;  // of the deferral tolerance, lowered where predictions were bad
    Facts facts;
    std::optional<Trial> trial;  // the farm's, not committed (deferral)
  };
  /// One increment of one slot in this response.
  struct Job {
    std::uint64_t slot;
    std::size_t leader;
    dem::Mat3 increment;  // since the last commit
    bool deferred = false;
    dem::Response response;  // by DEM, or by a tangent
  };

  /// What one point hears.
  struct Answer {
    dem::Mat3 stress = dem::Mat3::Zero();
    dem::Mat6 tangent = dem::Mat6::Zero();
    std::size_t breakages = 0;
  };

  bool respond(const fem::Points& points);
  bool sharpen();
  bool sharp() const { return options_.response.tangent == TangentKind::network || sharp_ > 0; }
  /// Every point has an RVE of its own, and for good.
  bool parted() const { return options_.share == 0 && slots_.size() == point_.size(); }
  void find_jobs();
  std::size_t add_job(std::uint64_t slot, std::size_t leader);
  std::uint64_t part(std::uint64_t slot, std::size_t leader);
  bool replay(std::size_t point);
  double distance(std::size_t a, std::size_t b, double limit) const;
  bool foretold(const Job& job) const;
  /// What an RVE last said by DEM, in this increment or at the last commit, and the deformation since.
  struct Told {
    const dem::Mat3& stress;
    const dem::Mat6& tangent;
    dem::Mat3 beyond;
  };
  Told told(const Job& job) const;
  bool catch_up();
  void answer(double duration, bool tangent);
  void choose_tangents();
  void commit();
  Answer corrected(std::size_t point, const Job& job);

  RveFarm& farm_;
  RveOptions options_;
  std::vector<std::string> prepared_;  // bytes of the starting states; similar sharing only
  std::vector<double> start_volume_;   // of the starting states
  std::vector<Point> point_;
  std::map<std::uint64_t, Slot> slots_;
  std::vector<std::vector<dem::Mat3>> path_;  // committed increments of every point; similar sharing only
  std::map<std::uint64_t, std::vector<std::uint64_t>> parted_;  // slot -> copies of it that this increment has needed
  std::map<std::uint64_t, std::vector<std::size_t>> jobs_of_;   // slot that points have -> jobs that began there
  std::uint64_t next_slot_ = 0;
  std::vector<Job> jobs_;
  std::vector<std::size_t> job_;              // of each point
  std::vector<Answer> responses_, previous_;  // of this trial and of the one before it in the same increment
  std::vector<dem::Mat3> deformation_, previous_deformation_;
  int sharp_ = 0;                        // increments that will have the network's tangent
  std::vector<dem::Mat6> kept_tangent_;  // elastic, quasi-Newton
  bool has_previous_ = false;
  double measured_noise_ = 0;
  SweepReport report_;
  double seconds_ = 0;
  std::string reason_;
};

}  // namespace grus::coupling
