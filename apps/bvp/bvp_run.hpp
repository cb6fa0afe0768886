// SPDX-License-Identifier: LGPL-3.0-or-later
// The run of a macro problem: its materials, the solver that the scene names, rows, checkpoints, and where to go on
// from.
#pragma once

#include "apps/bvp/balance.hpp"
#include "apps/bvp/output.hpp"
#include "apps/bvp/shards.hpp"
#include "apps/run/command.hpp"
#include "dem/io/checkpoint.hpp"

namespace grus::app {

/// Everything that is set up before a run: on rank 0, or of a problem that is spread on each rank its own.
struct BvpSetup {
  std::unique_ptr<fem::Problem> problem;
  /// Makes it, its elements on these ranks (none: as they come); valid as long as the scene.
  std::function<std::unique_ptr<fem::Problem>(std::vector<std::int32_t> owner)> make;
  BvpPoints points;
  std::vector<dem::State> states;  // of the points' starts
  nlohmann::json prepared;         // what the preparation has made of them; null: there is none
  double density = 0;              // of the packed RVEs (kg/m^3), where the stress of the ground asks for it
};

std::string checkpoint_of(const Options& options);

/// The checkpoint of a run of this scene. Throws InputError where there is none, or one of another scene.
dem::Checkpoint find_checkpoint(const Options& options, const BvpScene& scene);

/// What each element's RVEs have cost a step up to a checkpoint of a problem that is spread; empty: it does not say.
std::vector<double> kept_costs(const dem::Checkpoint& kept);

/// Each rank keeps the states that its points start from, and rank 0 the first, which the summary tells of; it gets
/// those that it has not from a rank that has them.
void share_states(const AcrossRanks& across, BvpSetup& setup);

/// The macro problem with its materials; on rank 0, or on all ranks that it is spread over.
class BvpRun {
public:
  /// `farm` and `model`, that of the grains: none without grains. What is given by reference must outlive the run.
  BvpRun(const BvpScene& scene, const Options& options, BvpSetup setup, dem::Checkpoint kept, coupling::RveFarm* farm,
         const dem::Model* model, AcrossRanks& across);

  /// To the end, to a fault or to an interruption; `ready`: s that the preparation has taken.
  BvpEnding go(double ready, const Clock& clock);
  void finish(const BvpEnding& ending) { output_->finish(ending, options_); }

private:
  struct Course;
  fem::InitialStress initial_stress(std::size_t region) const;
  void make_materials();
  fem::Material grains();
  fem::Material regularise();
  void watch_responses(Course& course);
  void solve(Course& course);
  bool halts(Course& course);
  bool cut_pays(Course& course);
  void cut_anew(Course& course);
  std::vector<Parcel> pack(const fem::Snapshot& macro);
  void deliver(std::vector<Parcel> packed, const std::array<std::vector<std::string>, 2>& columns);
  template <class Report>
  bool after(Course& course, const Report& report, double now);
  template <class Report, class Solve>
  Report march(Course& course, Solve&& solve);
  template <class Report>
  void save(Course& course, const Report& report);
  void write_whole_checkpoint(nlohmann::json about);
  void write_sharded_checkpoint(nlohmann::json about);
  void take_shards(const nlohmann::json& about, const std::string& owners);
  Shard own_shard() const;
  std::string point_bytes(std::size_t rve) const;
  void take_point(std::size_t rve, const std::string& bytes);
  std::vector<double> measured_costs() const;
  void take_costs(const std::vector<double>& of_all);
  void agree_on_responses();
  template <class Start>
  Start begin();
  nlohmann::json resume();
  void take_parts(const nlohmann::json& about, std::vector<std::string>& parts);

  const BvpScene& scene_;
  const Options& options_;
  BvpSetup setup_;
  dem::Checkpoint kept_;  // to go on from; of a resumed run
  coupling::RveFarm* farm_;
  const dem::Model* model_;
  std::optional<coupling::RveMaterial> rves_;
  std::optional<fem::RegularisedMaterial> regularised_;  // the RVEs
  std::vector<fem::Material> regions_;
  std::optional<fem::Material> material_;
  std::vector<double> density_;
  std::optional<BvpOutput> output_;
  AcrossRanks& across_;
  std::vector<double> costs_;  // of this rank's elements, a step, up to the last look; empty: not known
  struct NextCut {
    std::vector<std::int32_t> owner;  // of each element of the mesh
    double now = 1, anew = 1;         // fullness, before and after
  } next_;
  Balance balance_;
  char shards_ = 'b';       // set of the last checkpoint, of a problem that is spread
  bool kept_here_ = false;  // there is a checkpoint to go on from
  double elapsed_ = 0, elapsed_cpu_ = 0, elapsed_sweeps_ = 0;  // s, of earlier parts: wall, CPU, wall of sweeps
};

}  // namespace grus::app
