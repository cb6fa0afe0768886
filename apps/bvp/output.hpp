// SPDX-License-Identifier: LGPL-3.0-or-later
// Results of grus-bvp: history.csv, macro frames, summary.json.
#pragma once

#include <nlohmann/json.hpp>

#include <limits>
#include <optional>

#include "apps/bvp/columns.hpp"
#include "apps/bvp/probes.hpp"
#include "apps/run/command.hpp"

namespace grus::app {

/// How a run ended, for summary.json.
struct BvpEnding {
  int status = 0, ranks = 1;
  std::string text;
  double time = 0;                                // load factor or s
  double preparation = 0, wall = 0, earlier = 0;  // s of wall time: of this part, and what earlier parts took to solve
  double cpu = 0, sweeps_wall = 0;                // s of all parts: of rank 0, and of the RVEs' answers
  nlohmann::json prepared;                        // what the preparation has made of the RVEs; null: there is none
  std::uint64_t migrated = 0;                     // RVEs moved between ranks
  std::uint64_t cuts = 0;                         // of the mesh while it ran
  double imbalance = 1;                           // work of the fullest rank over the mean

  double solve_wall() const { return earlier + wall - preparation; }
};

/// Columns of history.csv.
std::vector<std::string> bvp_columns(const BvpScene& scene, const fem::Problem& problem, const Probes& probes);

/// A macro balance of energy that is off by more than this is told of; so is a regularisation that has given more.
inline constexpr double most_energy_error = 0.05, most_given = 0.005;

class BvpOutput {
public:
  BvpOutput(std::string directory, const BvpScene& scene, fem::Problem& problem, const BvpPoints& points,
            const std::vector<dem::State>& states, coupling::RveMaterial* rves,
            const fem::RegularisedMaterial* regularised, AcrossRanks& across);

  /// The mesh has been cut anew: another problem, and of points and RVEs others on this rank.
  void now_of(fem::Problem& problem);
  /// One row, and a frame if one is due.
  void add(const fem::IncrementReport& report, double wall);
  void add(const fem::DynamicsReport& report, double wall);
  void add(const fem::ExplicitStaticsReport& report, double wall);
  void finish(const BvpEnding& ending, const Options& options);

  /// Where things stand, for the progress line.
  std::string line(std::uint64_t sweeps) const;
  /// Notes of what the run has shown, beside the scene's.
  std::vector<std::string> notes() const;
  /// By how much regularisation_J has fallen at most, over the largest energy: given, not held or taken.
  double given() const { return given_; }
  std::string closing(const BvpEnding& ending) const;

  /// Everything that a resumed run needs to go on writing as if it had never stopped; and back.
  nlohmann::json state() const;
  void restore(const nlohmann::json& state, const std::string& history);
  const History& history() const { return *history_; }

private:
  void add_rves(nlohmann::json& summary, const BvpEnding& ending) const;
  void read_off(MacroRow& row);
  void add(MacroRow row);
  void frame(double time);
  void write_frame(const std::string& name, const fem::MacroFields& fields, const std::vector<double>& means);
  double work_error() const;
  nlohmann::json devices() const;
  double last(double (*of)(const MacroRow&, std::size_t)) const;
  std::string bonds_text(const char* head) const;
  std::string balance_text(const BvpEnding& ending) const;
  double of_rves(dem::Facts::Number energy) const;  // J: of all points with grains, by the volumes that they stand for
  const char* axis() const { return scene_.flat() ? "yy" : "zz"; }

  std::string directory_;
  const BvpScene& scene_;
  fem::Problem* problem_;
  const BvpPoints& points_;
  const std::vector<dem::State>& states_;
  coupling::RveMaterial* rves_;                  // null: no grains anywhere
  const fem::RegularisedMaterial* regularised_;  // null: they are told what the points do
  AcrossRanks& across_;                          // rank 0 writes; what is told of all is summed by all
  std::optional<Probes> probes_;
  std::vector<MacroColumn> columns_;
  std::vector<std::uint8_t> grains_;  // points that have an RVE
  std::optional<History> history_;
  std::vector<std::pair<std::string, double>> series_;
  std::vector<double> contraction_;  // of Newton: logarithms of residual ratios
  double strain_ = 0, stress_ = 0, breakages_ = 0, bonds_broken_ = 0, macro_work_ = 0, material_work_ = 0,
         worst_residual_ = 0, worst_energy_ = 0, energy_error_ = 0, dem_steps_ = 0,
         given_ = 0;  // energy_error_, dem_steps_, given_: of the last row
  std::uint64_t given_up_ = 0;
  double most_regularised_ = std::numeric_limits<double>::lowest(), fallen_ = 0;  // J: in a row; at most below it
  int iterations_ = 0, cutbacks_ = 0, sweeps_ = 0;
  int linear_iterations_ = 0, linear_failures_ = 0;  // of an iterative linear solver
};

}  // namespace grus::app
