// SPDX-License-Identifier: LGPL-3.0-or-later
// The run of one DEM test: rows, frames, checkpoints, where to go on from, and the summary.
#pragma once

#include <nlohmann/json.hpp>

#include "apps/run/command.hpp"
#include "apps/rve/columns.hpp"
#include "apps/rve/error_estimates.hpp"
#include "apps/rve/frames.hpp"
#include "apps/rve/gradings.hpp"
#include "apps/rve/step_told.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/io/checkpoint.hpp"
#include "dem/rve/measure.hpp"
#include "dem/sample/make.hpp"
#include "dem/sample/stages.hpp"

namespace grus::app {

/// The state in which a test begins, and what its preparation tells (null: there is none).
struct Begun {
  dem::State state;
  nlohmann::json prepared;
};

class RveRun {
public:
  /// `sample`: as it was made; `begun`: the state in which the test begins; `kept`: to go on from, if the run is
  /// resumed. What is given by reference must outlive the run. `ready`: s of wall time that the preparation has taken.
  RveRun(const Options& options, RveScene& scene, dem::Sample sample, dem::Team& team, Begun begun,
         const dem::Checkpoint& kept, const Clock& clock, double ready);

  /// To the end, to a fault or to an interruption; returns the exit status.
  int go();

private:
  /// All that a run carries besides its state.
  struct Course {
    dem::Mat3 initial_cell = dem::Mat3::Zero();
    dem::Vec3 initial_size = dem::Vec3::Zero();
    std::uint64_t row = 0;
    double wall = 0, cpu = 0;     // s, of all parts so far
    double peak = 0, intact = 0;  // axial stress (Pa): the largest, and that until the first grain gave way
    double reading = 0;           // largest stress that the test itself tells, of Voronoi cells (Pa)
    bool peak_is_last = false, reading_is_last = false;  // the last row's: it might have gone on
    double axial = 0, before = 0;                        // Pa, axial stress of the last row and of the one before
    double bulk = 0, solid = 0, mass = 0;                // m^3, m^3, kg, in which the test begins
    double overfull =
        -1;  // stress (Pa) at which grains and fines first were more than the sample's volume; below 0: never
    ErrorEstimates errors;
    StepTold step;
  };

  void take_up(const dem::Checkpoint& kept);
  void check_course(bool whole) const;
  void save_checkpoint();
  bool due();
  void show();
  std::string broken(const char* between) const;
  double strain_of_gradings() const;
  void write_row();
  void hear_of_breaks(const dem::State& state, std::span<const dem::Break> breaks);
  void read_off();
  void read_off_stop();
  void note_peak();
  std::string load_text() const;
  std::string peak_text() const;
  double done() const;
  dem::Landing landing() const;
  bool go_to_row(std::uint64_t row, double until, const dem::Landing& landing);
  void write_first_row();
  void march();
  bool staged() const { return !scene_.test.stages.empty(); }
  void begin_stage();
  void note_stage(std::size_t stage, double began, std::uint64_t rows, dem::EndedBy end);
  bool go_through_stage();
  void march_stages();
  bool has_peak() const;
  double split_share() const;
  double good_until() const;
  std::vector<std::string> notes() const;
  nlohmann::json summary() const;
  void finish();

  const Options& options_;
  RveScene& scene_;
  const dem::Model own_;  // of the scene; stages change its friction, damping and gravity
  dem::Sample sample_;    // as it was made; of its grains what strain gauges need
  dem::Team& team_;
  const Clock& clock_;
  double ready_;
  dem::State state_;
  nlohmann::json stages_ = nlohmann::json::array();  // those that are over
  nlohmann::json prepared_;  // what the preparation was asked and has reached; null: there is none
  dem::SurveyRoom room_;
  dem::Survey now_;     // of the last row that is good; in the end of where the run was stopped
  dem::Ledger ledger_;  // of then
  std::vector<Column<Row>> columns_;
  History history_;
  GrainFrames frames_;
  CrackFrames cracks_;
  GradingStates gradings_;
  const FirstGrains first_grains_;
  Course course_;
  Progress progress_;
  TimeLimit limit_;
  bool ended_ = false;                        // the checkpoint is of a test that has come to its end
  bool over_ = false;                         // the time that the run may take is
  double axial_ = 0, shown_ = 0, error_ = 0;  // of the last row: axial stress, the one that is shown (Pa), energy error
  double saved_, earlier_;                    // wall time of the last checkpoint, and of earlier parts of the run (s)
  double earlier_cpu_;                        // CPU time of these (s)
  double end_ = 0;                            // wall time (s)
  int status_ = finished;
  std::string ending_ = "finished";
};

}  // namespace grus::app
