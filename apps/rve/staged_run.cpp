// SPDX-License-Identifier: LGPL-3.0-or-later
// The run of a test of several stages: leg by leg, rows within each.
#include <fmt/format.h>

#include "apps/rve/rve_run.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/stages.hpp"

namespace grus::app {

void RveRun::begin_stage() {
  dem::Programme& test = scene_.test;
  if (test.now.begun) return;
  dem::begin_stage(own_, scene_.model, state_, course_.row, test);
  progress_.note(fmt::format("  stage {} of {} ({}) begins at t = {:.4g} s", test.now.stage + 1, test.stages.size(),
                             test.stages[test.now.stage].name, state_.time));
}

void RveRun::note_stage(std::size_t stage, double began, std::uint64_t rows, dem::EndedBy end) {
  const dem::Stage& s = scene_.test.stages[stage];
  stages_.push_back({{"name", s.name},
                     {"began_s", began},
                     {"ended_s", state_.time},
                     {"ended_by", dem::name_of(end)},
                     {"rows", rows},
                     {"strain", dem::stage_strain(scene_.test, state_) - scene_.test.now.strain},
                     {"work_J", state_.ledger.work},
                     {"axial_stress_Pa", axial_}});
}

/// One stage to its end; false: the run ends here.
bool RveRun::go_through_stage() {
  dem::Programme& test = scene_.test;
  dem::StageNow& now = test.now;
  begin_stage();
  const std::size_t stage = now.stage;
  while (now.stage == stage) {
    if (!now.leg_begun) dem::begin_leg(own_, scene_.model, state_, test);
    const dem::EndedBy end = dem::leg_ended(test, state_);
    const bool told = course_.row > now.first_row && now.row_time == state_.time;  // the end has its row
    if (end == dem::EndedBy::nothing || !told) {
      const double until = end == dem::EndedBy::nothing ? dem::row_until(test) : state_.time;
      if (!go_to_row(course_.row + 1, until, dem::leg_landing(test))) return false;
      continue;
    }
    if (end == dem::EndedBy::limit) throw dem::Unstable(dem::unmet(test, state_));
    const double began = now.began;
    const std::uint64_t rows = course_.row - now.first_row;
    if (now.leg + 1 == test.stages[stage].legs() || end != dem::EndedBy::cycles) note_stage(stage, began, rows, end);
    dem::end_leg(test, end);
  }
  return true;
}

void RveRun::march_stages() {
  dem::Programme& test = scene_.test;
  dem::check_sanity(scene_.model, state_);
  if (!options_.resume) write_first_row();
  read_off();
  ended_ = false;
  while (test.now.stage < test.stages.size())
    if (!go_through_stage()) return;
}

}  // namespace grus::app
