// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/going_on.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/run/same_scene.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

using nlohmann::json;

/// How far a test goes: a run may go on to more of it.
constexpr std::pair<const char*, const char*> further[] = {
    {"loading", "final_strain"},       {"loading", "final_stress"}, {"loading", "max_strain"}, {"loading", "duration"},
    {"loading", "final_displacement"}, {"output", "frames"},        {"output", "gradings"}};

/// What of a sample's material may change between a run and one that starts from it; the last two where grains and
/// contacts have the columns that they need.
constexpr const char* of_a_test[] = {"friction", "restitution", "damping", "rolling_friction", "fracture"};
constexpr std::size_t always_free = 3;

/// A checkpoint of a DEM test, and what it tells of itself.
std::pair<dem::Checkpoint, json> read(const std::string& path) {
  dem::Checkpoint kept = dem::read_checkpoint(path);
  json about = json::parse(kept.about, nullptr, false);
  if (!about.is_object() || about.value("program", "") != "grus-rve" || kept.parts.size() != 4)
    throw InputError(path + ": not a checkpoint of grus-rve");
  return {std::move(kept), std::move(about)};
}

/// The scene of the checkpoint with all that may have changed as it is now: how far the test goes, and stages that have
/// not begun.
json as_far_as(json kept, const json& now, const json& about) {
  if (!kept.is_object()) return kept;
  for (const auto& [table, key] : further) {
    if (!kept.contains(table) || !now.contains(table)) continue;
    const json was = kept[table].value(key, json()), is = now[table].value(key, json());
    if (was.is_number() && is.is_number() && is > was) kept[table][key] = is;
  }
  if (!kept.contains("stage") || !now.contains("stage")) return kept;
  const auto begun = about.value("stages_begun", std::size_t{0});
  json stages = json::array();
  for (std::size_t k = 0; k < std::max(begun, now["stage"].size()); ++k) {
    const json& from = k < begun ? kept["stage"] : now["stage"];
    if (k < from.size()) stages.push_back(from[k]);
  }
  kept["stage"] = std::move(stages);
  return kept;
}

/// What a scene says of its sample, without the first so many of of_a_test.
json sample_in(const json& scene, std::size_t without) {
  json of;
  for (const char* table : {"packing", "boundary", "grain", "wall", "clamp", "load", "seed"})
    if (scene.contains(table)) of[table] = scene[table];
  if (!scene.contains("material")) return of;
  of["material"] = scene["material"];
  for (auto& [name, material] : of["material"].items())
    for (std::size_t k = 0; k < without; ++k) material.erase(of_a_test[k]);
  return of;
}

/// Walls as the scene moves them; the cell stands.
void stand(const dem::Sample& sample, dem::State& state) {
  auto& walls = state.boundary.walls;
  const auto& made = sample.state.boundary.walls;
  for (std::size_t w = 0; w < walls.size() && w < made.size(); ++w) walls[w].velocity = made[w].velocity;
  if (state.boundary.cell.periodic()) dem::set_cell_rate(state, dem::Mat3::Zero());
}

}  // namespace

dem::Checkpoint find_checkpoint(const Options& options, const RveScene& scene) {
  const std::string path = options.directory + "/checkpoint.h5";
  auto [kept, about] = read(path);
  refuse_changes(path, as_far_as(about.value("scene", json()), *scene.record, about), *scene.record);
  if (!about.value("ended", false) && has_finished(options.directory, scene.record.get()))
    say(options, finished_before);
  return std::move(kept);
}

std::string with_columns(const std::string& rows, const std::vector<std::string>& columns) {
  std::istringstream lines(rows);
  const auto cells = [](const std::string& line) {
    std::vector<std::string> all;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) all.push_back(cell);
    return all;
  };
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> had = cells(line);
  if (had == columns) return rows;
  std::string out = fmt::format("{}\n", fmt::join(columns, ","));
  while (std::getline(lines, line)) {
    const std::vector<std::string> values = cells(line);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const auto at = static_cast<std::size_t>(std::find(had.begin(), had.end(), columns[k]) - had.begin());
      const std::string none = columns[k] == "cycle" ? "0" : "nan";
      out += fmt::format("{}{}", k > 0 ? "," : "", at < values.size() ? values[at] : none);
    }
    out += '\n';
  }
  return out;
}

namespace {

std::filesystem::path folder_of_start(const RveScene& scene) {
  return std::filesystem::path(scene.file).parent_path() / scene.start;
}

/// A run that failed has no last state; of one that was stopped midway it is told.
void look_at_end(const std::filesystem::path& folder, const json& about, RveScene& scene) {
  if (about.value("ended", false)) return;
  std::ifstream in(folder / "summary.json");
  const json summary = json::parse(in, nullptr, false);
  const int status = summary.is_object() ? summary.value("status", interrupted) : interrupted;
  if (status == unstable || status == failed)
    dem::refuse(scene.place_of_start,
                fmt::format("\"{}\" holds a run that failed (status {}): its checkpoint is from some time before; give "
                            "one that has finished",
                            scene.start, status));
  if (status == finished)
    dem::refuse(scene.place_of_start,
                fmt::format("\"{}\" holds a run that has finished but has not kept its last state: its checkpoint is "
                            "from some time before; run it again with output.last_state = true",
                            scene.start));
  scene.notes.push_back(
      fmt::format("start: the run in \"{}\" has not finished: this one begins in its last checkpoint; "
                  "--resume takes that run to its end",
                  scene.start));
}

}  // namespace

void refuse_own_start(const Options& options, const RveScene& scene) {
  std::error_code none;
  if (!scene.start.empty() && std::filesystem::equivalent(folder_of_start(scene), options.directory, none))
    dem::refuse(scene.place_of_start,
                fmt::format("\"{}\" is the results folder, too, whose checkpoint this run would take the place of; use "
                            "another -o DIR",
                            scene.start));
}

dem::State start_of(RveScene& scene, const dem::Sample& sample, dem::Team& team) {
  const std::filesystem::path folder = folder_of_start(scene);
  const std::string path = (folder / "checkpoint.h5").string();
  if (!std::filesystem::exists(path))
    dem::refuse(scene.place_of_start, fmt::format("\"{}\" holds no checkpoint.h5: a run keeps its last state with "
                                                  "output.last_state = true, or with stages",
                                                  scene.start));
  const auto [kept, about] = read(path);
  const auto refuse_others = [&, &made = about](std::size_t without) {
    refuse_changes(path, sample_in(made.value("scene", json::object()), without), sample_in(*scene.record, without),
                   "the sample's start", "set it back, or leave start out");
  };
  refuse_others(std::size(of_a_test));
  look_at_end(folder, about, scene);
  try {
    dem::State state = dem::state_of(kept.parts[0]);
    try {
      dem::check_state(scene.model, state);
    } catch (const InputError&) {  // its checksum is right: what this scene's laws need is not there
      refuse_others(always_free);
      throw;
    }
    stand(sample, state);
    state.time = 0, state.steps = 0, state.grain_steps = 0;
    state.ledger = {}, state.servo = {};
    dem::prepare(scene.model, state, team);
    return state;
  } catch (const InputError& e) {
    const std::string why = e.what();
    throw InputError(why.starts_with(path) ? why : path + ": " + why);
  }
}

}  // namespace grus::app
