// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-rve: one DEM test, standalone.
#include <fmt/format.h>

#include "apps/run/folder.hpp"
#include "apps/rve/columns.hpp"
#include "apps/rve/going_on.hpp"
#include "apps/rve/rehearsal.hpp"
#include "apps/rve/rve_run.hpp"
#include "apps/rve/setup_text.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "dem/rve/step.hpp"

using namespace grus;
using namespace grus::app;

namespace {

/// The sample, where the scene has not had it at once.
dem::Sample sample_of(RveScene& scene, std::optional<dem::Sample> made, dem::Team& team, const StageWatch& watch) {
  if (made) return std::move(*made);
  dem::Sample sample = dem::make(scene.model, scene.recipe, team, dem::stage_of(watch, "packing"));
  settle(scene, sample);
  return sample;
}

/// Brought to where its test begins, and what there is to tell of that.
Begun prepare_sample(RveScene& scene, const dem::Sample& sample, dem::Team& team, const StageWatch& watch) {
  if (!scene.start.empty()) return {start_of(scene, sample, team), {}};
  Base base = prepare_base(scene, &sample, team, watch);
  Begun begun{dem::start_from(std::move(base.state), scene.model, scene.recipe.preparation, team, watch), {}};
  begun.prepared = tell_preparation(scene, base.packed_void_ratio, begun.state, {}, base.density);
  if (const std::string note = note_of_preparations({begun.prepared}); !note.empty()) scene.notes.push_back(note);
  return begun;
}

constexpr double rehearsal_time = 3;  // s, of --check

/// --check: what a run would be like, from a piece of the sample where that is large.
int check(const Options& options, RveScene& scene, std::optional<dem::Sample> made, dem::Team& team) {
  const double all = scene.recipe.count();
  const std::optional<dem::Recipe> piece =
      scene.start.empty() ? dem::piece_of(scene.recipe) : std::optional<dem::Recipe>();
  if (piece) scene.recipe = *piece;
  Progress progress(options);
  const auto watch = [&](double done, const char* what) { return progress.watch(done, what); };
  const Clock preparing;
  const dem::Sample sample = sample_of(scene, std::move(made), team, watch);
  dem::State state = prepare_sample(scene, sample, team, watch).state;
  const double prepared = scene.start.empty() ? preparing.wall() : 0;
  dem::begin_loading(scene.model, state, scene.test.loading);
  refuse_endless(scene, state);
  const double grains = piece ? all : static_cast<double>(state.grains.size());
  Rehearsal found = rehearse(scene, state, rehearsal_time, team, watch);
  found.prepared = prepared;
  say(options, setup_text(scene, state, grains, &found));
  return finished;
}

/// The spheres of a file, which the sample has by now.
void let_spheres_go(dem::Recipe& recipe) {
  if (auto* read = std::get_if<dem::Spheres>(&recipe.grains)) dem::drop(read->spheres), dem::drop(read->materials);
}

/// The columns of a scene; of a random packing they hang on its walls alone.
int tell_columns(const RveScene& scene, std::optional<dem::Sample> made) {
  if (!made) made.emplace().state.boundary = dem::boundary_of(scene.recipe);
  for (const auto& name : names_of(rve_columns({scene, *made}))) fmt::print("{}\n", name);
  return finished;
}

int run(const Options& options) {
  const Clock clock;
  RveScene scene = read_rve_scene(options.scene, options.overrides);
  std::optional<dem::Sample> made = made_at_once(scene);
  if (made) settle(scene, *made);
  if (options.columns) return tell_columns(scene, std::move(made));
  dem::Team team(options.threads);
  if (options.check) return check(options, scene, std::move(made), team);
  dem::Checkpoint kept;
  refuse_own_start(options, scene);
  if (options.resume) kept = find_checkpoint(options, scene);
  check_folder(options);
  dem::Sample sample;
  Begun begun;
  {
    Progress progress(options);
    const auto watch = [&](double done, const char* what) { return progress.watch(done, what); };
    sample = sample_of(scene, std::move(made), team, watch);
    if (!options.resume) {
      begun = prepare_sample(scene, sample, team, watch);
      dem::begin_loading(scene.model, begun.state, scene.test.loading);
      refuse_endless(scene, begun.state);
    }
  }
  let_spheres_go(scene.recipe);
  const Folder folder(options);
  if (options.speaks() && !options.resume)
    say(options, setup_text(scene, begun.state, static_cast<double>(begun.state.grains.size()), nullptr));
  return RveRun(options, scene, std::move(sample), team, std::move(begun), kept, clock, clock.wall()).go();
}

}  // namespace

int main(int argc, char** argv) {
  return run_command(argc, argv, "grus-rve",
                     "One DEM test of grains that may break: oedometer, SHPB, triaxial, shear, stages, single grains, "
                     "free motion, bonded rock.",
                     run);
}
