// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/starts.hpp"

#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <thread>

#include "apps/run/same_scene.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "dem/base/clock.hpp"
#include "dem/base/fault.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/checkpoint.hpp"

namespace grus::app {
namespace {

struct Ranks {
  int rank = 0, count = 1;
  Ranks() { MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &count); }
};

/// What becomes of one start. `fault`: the bytes of a dem::Fault; `told`: of its preparation, in JSON.
struct Made {
  std::string bytes, fault, told;
};

/// Rank 0 gets what the others have made.
void gather(const Ranks& ranks, const std::vector<std::size_t>& which, const std::vector<int>& owner,
            std::vector<Made>& made) {
  for (const std::size_t k : which) {
    const int from = owner[k];
    for (std::string* text : {&made[k].fault, &made[k].told, &made[k].bytes}) {
      int size = static_cast<int>(text->size());
      if (ranks.rank == from && from != 0) {
        MPI_Send(&size, 1, MPI_INT, 0, 0, MPI_COMM_WORLD);
        MPI_Send(text->data(), size, MPI_CHAR, 0, 0, MPI_COMM_WORLD);
        text->clear(), text->shrink_to_fit();
      } else if (ranks.rank == 0 && from != 0) {
        MPI_Recv(&size, 1, MPI_INT, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        text->resize(static_cast<std::size_t>(size));
        MPI_Recv(text->data(), size, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      }
    }
  }
}

/// Whose states a file holds.
nlohmann::json about(const BvpScene& scene, const std::vector<Start>& starts) {
  nlohmann::json of = {{"program", "grus-bvp preparation"}, {"scene", *scene.record}};
  if (!scene.unit_cells.empty()) of["unit_cell"] = *scene.unit_cells[0].record;
  for (const Start& s : starts)
    of["starts"].push_back(
        fmt::format("{} {} {:a} {:a} {:a}", s.packing, s.stressed, s.stress[0], s.stress[1], s.stress[2]));
  return of;
}

void read(const StartsFile& file, nlohmann::json of, std::vector<Made>& made) {
  if (!file.resume || !std::filesystem::exists(file.path)) return;
  dem::Checkpoint kept = dem::read_checkpoint(file.path);
  auto there = nlohmann::json::parse(kept.about, nullptr, false);
  std::vector<std::size_t> which;
  if (there.is_object() && there.contains("made") && there["made"].is_array())
    for (const auto& k : there["made"]) which.push_back(k.is_number_unsigned() ? k.get<std::size_t>() : SIZE_MAX);
  for (const char* what : {"scene", "unit_cell"})
    if (there.is_object() && of.contains(what)) {
      refuse_changes(file.path, there.value(what, nlohmann::json()), of[what],
                     what == std::string("scene") ? "" : "unit cell");
      there[what] = of[what];  // but for the title the same
    }
  for (const char* kept_as_it_is : {"made", "told"})
    of[kept_as_it_is] = there.is_object() ? there.value(kept_as_it_is, nlohmann::json()) : nlohmann::json();
  if (there != of || which.size() != kept.parts.size() ||
      std::any_of(which.begin(), which.end(), [&](std::size_t k) { return k >= made.size(); }))
    throw InputError(file.path + ": preparation of another scene or other settings; give the same file and --set");
  if (!of["told"].is_array() || of["told"].size() != which.size() ||
      !std::all_of(of["told"].begin(), of["told"].end(),
                   [](const auto& told) { return told.is_null() || told.is_object(); }))
    throw InputError(file.path + ": checkpoint is damaged: what it tells of the preparation");
  for (std::size_t i = 0; i < which.size(); ++i)
    made[which[i]].bytes = std::move(kept.parts[i]), made[which[i]].told = of["told"][i].dump();
}

void write(const StartsFile& file, nlohmann::json of, const std::vector<Made>& made) {
  of["made"] = of["told"] = nlohmann::json::array();
  for (std::size_t k = 0; k < made.size(); ++k)
    if (!made[k].bytes.empty()) of["made"].push_back(k), of["told"].push_back(nlohmann::json::parse(made[k].told));
  file.before_it();
  dem::write_checkpoint(file.path, of.dump(), [&](const dem::TakePart& take) {
    for (const Made& m : made)
      if (!m.bytes.empty()) take(m.bytes);
  });
}

class Preparer {
public:
  Preparer(const BvpScene& scene, const std::vector<Start>& starts, int threads, const dem::Watch& watch,
           const StartsFile& file)
      : scene_(scene), starts_(starts), watch_(watch), file_(file), team_(threads), made_(starts.size()) {
    // A rank keeps to its packings where there are enough of them: each is made once.
    std::vector<std::size_t> packings;
    for (const Start& s : starts)
      if (std::find(packings.begin(), packings.end(), s.packing) == packings.end()) packings.push_back(s.packing);
    const auto ranks = static_cast<std::size_t>(ranks_.count);
    for (std::size_t k = 0; k < starts.size(); ++k)
      owner_.push_back(static_cast<int>((packings.size() >= ranks ? starts[k].packing : k) % ranks));
  }

  Starts go() {
    std::vector<std::size_t> left = begin();
    double saved = 0, each = 0;
    bool written = file_.resume && std::filesystem::exists(file_.path);  // then it is kept up to date
    while (!left.empty()) {
      const std::vector<std::size_t> now = next(left, each);
      const dem::Clock clock;
      dem::Fault fault;
      work(now, left.size());
      each = clock.wall();
      int stops = stopped_;
      MPI_Allreduce(MPI_IN_PLACE, &stops, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
      gather(ranks_, now, owner_, made_);
      std::erase_if(left, [&](std::size_t k) { return std::find(now.begin(), now.end(), k) != now.end(); });
      if (ranks_.rank == 0) {
        for (const std::size_t k : now)
          if (!fault) fault = on_rank(owner_[k], dem::Fault::of(made_[k].fault));
        const bool due = clock_.wall() - saved > file_.interval || stops != 0 || (written && left.empty());
        if (!fault && due && !file_.path.empty())
          fault = dem::fault_in([&] {
            write(file_, about(scene_, starts_), made_);
            written = true, saved = clock_.wall();
          });
      }
      int end = stops != 0 || fault ? 1 : 0;
      MPI_Bcast(&end, 1, MPI_INT, 0, MPI_COMM_WORLD);
      if (ranks_.rank == 0) rethrow(fault);
      if (stops != 0)
        throw dem::Interrupted(
            file_.path.empty() ? "interrupted while unit cells were prepared; nothing to go on from yet"
                               : "interrupted while unit cells were prepared; --resume goes on from preparation.h5");
      if (end != 0) break;  // rank 0 tells why
    }
    Starts all{{}, {}, {packing_, stress_}};
    if (ranks_.rank == 0)
      for (const Made& m : made_)
        all.states.push_back(dem::state_of(m.bytes)), all.told.push_back(nlohmann::json::parse(m.told));
    return all;
  }

private:
  /// What is still to be made, on all ranks alike.
  std::vector<std::size_t> begin() {
    dem::Fault fault;
    if (ranks_.rank == 0) fault = dem::fault_in([&] { read(file_, about(scene_, starts_), made_); });
    std::vector<std::uint8_t> have(starts_.size() + 1, 0);
    for (std::size_t k = 0; k < starts_.size(); ++k) have[k] = made_[k].bytes.empty() ? 0 : 1;
    have.back() = fault ? 1 : 0;
    MPI_Bcast(have.data(), static_cast<int>(have.size()), MPI_BYTE, 0, MPI_COMM_WORLD);
    rethrow(fault);
    std::vector<std::size_t> left;
    for (std::size_t k = 0; k < starts_.size() && have.back() == 0; ++k)
      if (have[k] == 0) left.push_back(k);
    return left;
  }

  /// The next ones: several for each thread, but so few that a checkpoint is not long overdue.
  std::vector<std::size_t> next(const std::vector<std::size_t>& left, double last) const {
    int size[2] = {team_.threads(), 1};
    if (last > 0) size[1] = static_cast<int>(std::clamp(0.5 * file_.interval / last, 1.0, 8.0));
    MPI_Bcast(size, 2, MPI_INT, 0, MPI_COMM_WORLD);
    const auto most = static_cast<std::size_t>(size[0] * size[1] * ranks_.count);
    return {left.begin(), left.begin() + static_cast<std::ptrdiff_t>(std::min(most, left.size()))};
  }

  /// This rank's part of them.
  void work(const std::vector<std::size_t>& now, std::size_t left) {
    std::vector<std::size_t> mine, fresh;
    for (const std::size_t k : now) {
      if (owner_[k] != ranks_.rank) continue;
      mine.push_back(k);
      const std::size_t packing = starts_[k].packing;
      if (!bases_.contains(packing)) bases_[packing], fresh.push_back(packing);
    }
    std::vector<Made> faults(fresh.size());
    each(fresh.size(), left, [&](std::size_t i, dem::Team& alone, const StageWatch& stage) {
      const std::size_t k = fresh[i];
      const auto& made = scene_.samples[k];
      attempt(k, faults[i], packing_,
              [&] { bases_.at(k) = prepare_base(scene_.unit_cells[k], made ? &*made : nullptr, alone, stage); });
    });
    for (const Made& m : faults)
      if (!m.fault.empty()) {
        made_[mine.front()].fault = m.fault;
        return;
      }
    each(mine.size(), left, [&](std::size_t i, dem::Team& alone, const StageWatch& stage) {
      const Start& start = starts_[mine[i]];
      const Base& base = bases_.at(start.packing);
      const RveScene& cell = scene_.unit_cells[start.packing];
      std::optional<dem::Vec3> stresses;
      if (start.stressed) stresses.emplace(start.stress[0], start.stress[1], start.stress[2]);
      Made& made = made_[mine[i]];
      attempt(start.packing, made, stress_, [&] {
        const dem::State state =
            dem::start_from(base.state, cell.model, cell.recipe.preparation, alone, stage, stresses);
        made.told = tell_preparation(cell, base.packed_void_ratio, state, stresses, base.density).dump();
        made.bytes = dem::bytes_of(state);
        ++done_;
      });
    });
  }

  /// On all threads; one of them shows the progress, all hear that they are to stop.
  template <class F>
  void each(std::size_t count, std::size_t left, F&& part) {
    const auto asking = std::this_thread::get_id();
    const std::size_t before = done_;
    const double total = static_cast<double>(starts_.size()), had = total - static_cast<double>(left);
    const double ranks = ranks_.count;
    team_.each(count, [&](std::size_t i) {
      if (stopped_ != 0) return;
      dem::Team alone(1);
      part(i, alone, [&](double, const char*) {
        const double now = static_cast<double>(done_ - before) * ranks;
        if (watch_ && std::this_thread::get_id() == asking && !watch_(std::min(1.0, (had + now) / total))) stopped_ = 1;
        return stopped_ == 0;
      });
    });
  }

  template <class F>
  void attempt(std::size_t packing, Made& made, std::atomic<double>& taken, F&& part) {
    const dem::Clock clock;
    const dem::Fault fault = dem::fault_in(part);
    if (fault.kind == dem::Fault::Kind::interrupted)
      stopped_ = 1;
    else
      made.fault = at(fmt::format("{}: ", scene_.unit_cells[packing].file), fault).bytes();
    taken += clock.wall();
  }

  const BvpScene& scene_;
  const std::vector<Start>& starts_;
  const dem::Watch& watch_;
  const StartsFile& file_;
  Ranks ranks_;
  dem::Team team_;
  std::vector<int> owner_;  // rank of each start
  std::vector<Made> made_;
  std::map<std::size_t, Base> bases_;  // of this rank's packings
  std::atomic<std::size_t> done_{0};
  std::atomic<int> stopped_{0};
  std::atomic<double> packing_{0}, stress_{0};  // s
  dem::Clock clock_;
};

}  // namespace

Starts prepare_starts(const BvpScene& scene, const std::vector<Start>& starts, int threads, const dem::Watch& watch,
                      const StartsFile& file) {
  return Preparer(scene, starts, threads, watch, file).go();
}

}  // namespace grus::app
