// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/patience.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace grus::app {
namespace {

constexpr int looks = 20, waiting_tag = 12;  // looks: in the time of patience
constexpr double grace = 0.25;               // of patience: for the others to tell
constexpr double least_turn = 5;             // s for each rank before, to end the job
constexpr std::size_t most_named = 8;

}  // namespace

std::string silent_ranks(int rank, bool can_tell, const std::vector<std::uint8_t>& told) {
  if (rank > 0) return "rank 0 has not answered";
  std::vector<std::size_t> names;
  for (std::size_t r = 0; r < told.size(); ++r)
    if (told[r] == 0) names.push_back(r);
  if (!can_tell || names.empty()) return "a rank has not answered";
  if (names.size() == 1) return fmt::format("rank {} has not answered", names[0]);
  const std::size_t more = names.size() > most_named ? names.size() - most_named : 0;
  names.resize(names.size() - more);
  return fmt::format("ranks {}{} have not answered", fmt::join(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

Patience::Patience(double seconds, std::function<void(const std::string&)> give_up)
    : seconds_(seconds), give_up_(std::move(give_up)) {
  MPI_Comm_dup(MPI_COMM_WORLD, &comm_);
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &ranks_);
  int level = 0;
  MPI_Query_thread(&level);
  tells_ = level == MPI_THREAD_MULTIPLE;
  told_.assign(static_cast<std::size_t>(ranks_), 0);
  thread_ = std::thread([this] { look(); });
}

/// The communicator stays: freeing it would wait for ranks that may be elsewhere.
Patience::~Patience() {
  {
    const std::lock_guard hold(mutex_);
    over_ = true;
  }
  ends_.notify_all();
  thread_.join();
  if (telling_ != MPI_REQUEST_NULL) MPI_Request_free(&telling_);
}

void Patience::look() {
  const std::chrono::duration<double> between(std::min(seconds_ / looks, 5.0));
  std::uint64_t seen = steps_;
  std::unique_lock hold(mutex_);
  while (!ends_.wait_for(hold, between, [&] { return over_; })) {
    hear();
    if (const std::uint64_t now = steps_; now != seen) {
      seen = now, quiet_ = 0, i_told_ = false;
      std::fill(told_.begin(), told_.end(), 0);
      continue;
    }
    quiet_ += between.count();  // not what the clock says: this process may have been stopped
    if (quiet_ >= seconds_) wait_in_vain();
  }
}

void Patience::wait_in_vain() {
  if (!works_ && !i_told_ && tells_) {
    if (rank_ == 0)
      told_[0] = 1;
    else
      MPI_Isend(nullptr, 0, MPI_BYTE, 0, waiting_tag, comm_, &telling_);
    i_told_ = true;
  }
  const double turns = std::min(rank_, looks) * std::max(grace * seconds_, least_turn);
  if (quiet_ >= (1 + grace) * seconds_ + turns)
    give_up_(fmt::format("{} for {:g} s (solve.patience)", silent_ranks(rank_, tells_, told_), seconds_));
}

void Patience::hear() {
  int there = tells_ && rank_ == 0 ? 1 : 0;
  while (there != 0) {
    MPI_Status from;
    MPI_Iprobe(MPI_ANY_SOURCE, waiting_tag, comm_, &there, &from);
    if (there == 0) return;
    MPI_Recv(nullptr, 0, MPI_BYTE, from.MPI_SOURCE, waiting_tag, comm_, MPI_STATUS_IGNORE);
    told_[static_cast<std::size_t>(from.MPI_SOURCE)] = 1;
  }
}

}  // namespace grus::app
