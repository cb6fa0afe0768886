// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run does otherwise where its macro problem is spread over ranks: it hears of failures on any of them, and
// keeps a checkpoint in shards.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "apps/bvp/bvp_run.hpp"
#include "apps/bvp/standing.hpp"
#include "apps/run/folder.hpp"

namespace grus::app {

/// What one rank's points throw, all throw; what one rank's points refuse, all tell.
void BvpRun::agree_on_responses() {
  struct Answer {
    bool good = false;
    dem::Fault fault;
  };
  const auto mine = std::make_shared<Answer>();
  material_->respond = [this, mine, respond = material_->respond](const fem::Points& p) {
    across_.got_on();
    mine->good = false;
    mine->fault = dem::fault_in([&] { mine->good = respond(p); });
    return mine->good;
  };
  // Asked on all ranks where any has failed.
  material_->reason = [this, mine, why = material_->reason] {
    across_.together([&] { rethrow(mine->fault); });
    return across_.first(mine->good ? "" : why());
  };
}

Shard BvpRun::own_shard() const {
  Shard shard;
  shard.elements = setup_.problem->own_elements();
  shard.regions.resize(scene_.regions.size());
  for (std::size_t i = 0; i < setup_.points.group.size(); ++i) {
    const std::size_t group = setup_.points.group[i];
    (group == 0 ? shard.rves : shard.regions[group - 1].points).push_back(setup_.problem->point_key(i));
  }
  return shard;
}

std::vector<double> kept_costs(const dem::Checkpoint& kept) {
  std::vector<double> costs;
  if (kept.parts.size() < 3) return costs;
  costs.resize(kept.parts[2].size() / sizeof(double));
  std::memcpy(costs.data(), kept.parts[2].data(), costs.size() * sizeof(double));
  const bool good = std::all_of(costs.begin(), costs.end(), [](double c) { return std::isfinite(c) && c >= 0; });
  return good ? costs : std::vector<double>();
}

/// What this rank's elements cost a step: since the last look, and before in so far as that is short.
std::vector<double> BvpRun::measured_costs() const {
  const double long_enough = scene_.is_explicit() ? 10 : 5;  // steps, increments
  const auto per_cell = static_cast<std::size_t>(setup_.problem->points_per_cell());
  std::vector<double> costs(setup_.points.group.size() / per_cell, 0);
  for (std::size_t i = 0, k = 0; i < setup_.points.group.size() && rves_; ++i)
    if (setup_.points.group[i] == 0) costs[i / per_cell] += rves_->spent(k++);
  const double steps = rves_ ? static_cast<double>(rves_->sweeps()) : 0;
  const bool before = costs_.size() == costs.size();
  for (std::size_t e = 0; e < costs.size(); ++e)
    costs[e] = (costs[e] + (before ? long_enough * costs_[e] : 0)) / std::max(1.0, steps + (before ? long_enough : 0));
  return costs;
}

/// What has been measured of all elements, on rank 0, for each rank's own.
void BvpRun::take_costs(const std::vector<double>& of_all) {
  std::string bytes(reinterpret_cast<const char*>(of_all.data()), of_all.size() * sizeof(double));
  across_.tell(0, bytes);
  std::vector<double> all(bytes.size() / sizeof(double));
  std::memcpy(all.data(), bytes.data(), bytes.size());
  costs_.clear();
  for (const std::int64_t e : setup_.problem->own_elements())
    if (static_cast<std::size_t>(e) < all.size()) costs_.push_back(all[static_cast<std::size_t>(e)]);
}

std::string BvpRun::point_bytes(std::size_t rve) const {
  return (regularised_ ? regularised_->save_point(rve) : "") + rves_->save_point(rve);
}

void BvpRun::take_point(std::size_t rve, const std::string& bytes) {
  const std::size_t own = regularised_ ? regularised_->load_point(rve, bytes) : 0;
  rves_->load_point(rve, bytes.substr(own));
}

void BvpRun::write_sharded_checkpoint(nlohmann::json about) {
  const char set = shards_ == 'a' ? 'b' : 'a';
  across_.lead([&] { result_file(options_.directory, shard_file(set, 0)); });
  fem::Snapshot macro = setup_.problem->own_snapshot();
  about["columns"] = {macro.at_nodes, macro.of_cells};
  about["shards"] = std::string(1, set);
  if (rves_) about["sweeps"] = app::save(rves_->report_of_all()), about["sharp"] = rves_->sharp();
  if (regularised_) about["left_over"] = regularised_->worst_left_over();
  Shard shard = own_shard();
  const std::vector<double> rank(shard.elements.size(), across_.rank());
  const std::vector<double> owner = setup_.problem->gather_cells(rank);
  across_.together([&] {
    shard.macro = std::move(macro.values);
    for (std::size_t r = 0; r < regions_.size(); ++r) shard.regions[r].bytes = regions_[r].save();
    write_shard(options_.directory + "/" + shard_file(set, across_.rank()), shard,
                [&](std::size_t k) { return point_bytes(k); });
  });
  const std::vector<double> costs = setup_.problem->gather_cells(measured_costs());
  across_.lead([&] {  // from here on the new set is the checkpoint
    const std::vector<std::int32_t> owners(owner.begin(), owner.end());
    dem::write_checkpoint(result_file(options_.directory, "checkpoint.h5"), about.dump(), [&](const auto& take) {
      take(output_->history().text());
      take(std::string(reinterpret_cast<const char*>(owners.data()), owners.size() * sizeof(std::int32_t)));
      take(std::string(reinterpret_cast<const char*>(costs.data()), costs.size() * sizeof(double)));
    });
  });
  shards_ = set;
  across_.lead([&] {  // that of before, which more ranks may have written
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(options_.directory + "/checkpoint", none))
      if (entry.path().filename().string().starts_with(fmt::format("{}_", set == 'a' ? 'b' : 'a')))
        std::filesystem::remove(entry.path(), none);
  });
}

void BvpRun::take_shards(const nlohmann::json& about, const std::string& packed) {
  const auto columns = about.at("columns").get<std::array<std::vector<std::string>, 2>>();
  shards_ = about.at("shards").get<std::string>().at(0);
  std::vector<std::int32_t> owners(packed.size() / sizeof(std::int32_t));
  std::memcpy(owners.data(), packed.data(), owners.size() * sizeof(std::int32_t));
  Shard shard = own_shard();
  across_.together([&] {
    read_shards(options_.directory, shards_, owners, shard,
                [&](std::size_t k, const std::string& bytes) { take_point(k, bytes); });
    for (std::size_t r = 0; r < regions_.size(); ++r)
      if (!shard.regions[r].points.empty()) regions_[r].load(shard.regions[r].bytes);
  });
  if (regularised_) regularised_->go_on_from(about.at("left_over").get<double>());
  setup_.problem->restore_own({columns[0], columns[1], std::move(shard.macro)});
  if (rves_) rves_->go_on_sharp(std::max(0, about.at("sharp").get<int>()));
  if (!rves_ || !across_.leads()) return;
  coupling::SweepReport done;
  app::load(about.at("sweeps"), done);
  rves_->go_on_counting(done);
}

}  // namespace grus::app
