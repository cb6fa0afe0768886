// SPDX-License-Identifier: LGPL-3.0-or-later
// An explicit run whose macro problem is spread cuts its mesh anew where ranks wait for one: elements and RVEs change
// their ranks in the midst of the run, as they would where it was stopped and went on.
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "apps/bvp/bvp_run.hpp"
#include "apps/bvp/course.hpp"
#include "dem/io/archive.hpp"

namespace grus::app {

void share_states(const AcrossRanks& across, BvpSetup& setup) {
  std::vector<dem::State>& states = setup.states;
  states.resize(setup.points.starts.size());
  std::vector<int> from(states.size(), across.ranks()), lacked(states.size(), 0);
  std::vector<std::uint8_t> wanted(states.size(), 0);
  for (const std::size_t s : setup.points.start) wanted[s] = 1;
  if (across.leads() && !wanted.empty()) wanted[0] = 1;
  for (std::size_t k = 0; k < states.size(); ++k)
    if (states[k].grains.size() > 0)
      from[k] = across.rank();
    else
      lacked[k] = wanted[k];
  const auto count = static_cast<int>(states.size());
  MPI_Allreduce(MPI_IN_PLACE, from.data(), count, MPI_INT, MPI_MIN, across.comm());
  MPI_Allreduce(MPI_IN_PLACE, lacked.data(), count, MPI_INT, MPI_MAX, across.comm());
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (lacked[k] != 0) {
      std::string bytes = across.rank() == from[k] ? dem::bytes_of(states[k]) : "";
      across.tell(from[k], bytes);
      if (wanted[k] != 0 && states[k].grains.size() == 0) states[k] = dem::state_of(bytes);
    }
    if (wanted[k] == 0) states[k] = {};
  }
}

/// A look at what the ranks have had to do, every fifty steps. True where a new cut pays: `next_`. All ranks know the
/// same numbers, and count DEM steps, not seconds: a machine that is busy with other things tells nothing of the RVEs.
bool BvpRun::cut_pays(Course& c) {
  constexpr std::uint64_t steps_between = 50;
  if (across_.ranks() == 1 || !scene_.is_explicit() || !rves_ || c.sweeps % steps_between != 0) return false;
  double spent = 0;
  for (std::size_t k = 0; k < rves_->points(); ++k) spent += rves_->spent(k);
  costs_ = measured_costs();
  rves_->count_anew();
  const std::vector<double> work = across_.all_numbers(spent);
  count(balance_, work);
  next_.now = fullness(across_.all_numbers(std::accumulate(costs_.begin(), costs_.end(), 0.0)));
  if (next_.now <= uneven) return false;
  const std::vector<double> all = setup_.problem->gather_cells(costs_);
  next_.owner = equal_parts(*setup_.problem, setup_.points, all);
  std::vector<double> then(static_cast<std::size_t>(across_.ranks()), 0);
  for (std::size_t e = 0; e < all.size(); ++e) then[static_cast<std::size_t>(next_.owner[e])] += all[e];
  next_.anew = fullness(then);  // on rank 0, which has all costs
  MPI_Bcast(&next_.anew, 1, MPI_DOUBLE, 0, across_.comm());
  const double ranks = across_.ranks(), grains = static_cast<double>(rves_->count(&dem::Facts::grains));
  return pays(balance_, next_.now, next_.anew, std::accumulate(work.begin(), work.end(), 0.0) / ranks, grains / ranks);
}

/// All that this rank has, for the ranks that get it; its RVEs are here no more.
std::vector<Parcel> BvpRun::pack(const fem::Snapshot& macro) {
  Shard shard = own_shard();
  shard.macro = macro.values;
  for (std::size_t r = 0; r < regions_.size(); ++r) shard.regions[r].bytes = regions_[r].save();
  return parcels(shard, next_.owner, across_.ranks(), setup_.problem->points_per_cell(), [&](std::size_t k) {
    std::string bytes = point_bytes(k);
    rves_->give_away(k);
    return bytes;
  });
}

/// Sends parcels to their ranks, and takes out of those that come what is this rank's now. One rank after the other:
/// what is held twice is one parcel.
void BvpRun::deliver(std::vector<Parcel> packed, const std::array<std::vector<std::string>, 2>& columns) {
  Shard shard = own_shard();
  ShardFiller filler(shard, [&](std::size_t k, const std::string& bytes) { take_point(k, bytes); });
  const int ranks = across_.ranks(), rank = across_.rank();
  for (int k = 0; k < ranks; ++k) {
    const int to = (rank + k) % ranks, from = (rank + ranks - k) % ranks;
    Parcel parcel = std::move(packed[static_cast<std::size_t>(to)]);
    if (k > 0) {
      dem::Saver out;
      for (std::string& part : parcel) out.text(part), part = {};
      const std::string bytes = across_.swap(out.take(), to, from);
      parcel.clear();
      for (dem::Loader in(bytes); !in.at_end();) in.text(parcel.emplace_back());
    }
    filler.take(fmt::format("rank {}", from), parcel);
    across_.got_on();
  }
  filler.end("cut anew");
  for (std::size_t r = 0; r < regions_.size(); ++r)
    if (!shard.regions[r].points.empty()) regions_[r].load(shard.regions[r].bytes);
  setup_.problem->restore_own({columns[0], columns[1], std::move(shard.macro)});
}

void BvpRun::cut_anew(Course& c) {
  const Clock clock;
  const coupling::SweepReport done = rves_->report_of_all();
  const double left_over = regularised_ ? regularised_->worst_left_over() : 0;
  const std::vector<double> costs = setup_.problem->gather_cells(costs_);
  const fem::Snapshot macro = setup_.problem->own_snapshot();
  c.apart = true;
  std::vector<Parcel> packed;
  across_.together([&] { packed = pack(macro); });
  elapsed_sweeps_ += rves_->seconds();
  material_.reset(), regions_.clear(), regularised_.reset(), rves_.reset();
  setup_.problem = setup_.make(next_.owner);
  setup_.points = find_points(scene_, *setup_.problem, setup_.density);
  share_states(across_, setup_);
  make_materials();
  deliver(std::move(packed), {macro.at_nodes, macro.of_cells});
  if (regularised_) regularised_->go_on_from(left_over);
  if (across_.leads()) rves_->go_on_counting(done);
  take_costs(costs);
  output_->now_of(*setup_.problem);
  watch_responses(c);
  c.apart = c.cut = false;
  note_cut(balance_);
  c.limit.wrote(clock.wall());
  c.progress.note(
      fmt::format("  cut anew at {:.4g}: the fullest rank had {:.2f} times the mean to do, now {:.2f}; took {:.2g} s",
                  c.time, next_.now, next_.anew, clock.wall()));
}

}  // namespace grus::app
