// SPDX-License-Identifier: LGPL-3.0-or-later
// Ranks that wait for each other: who is named as silent, when, and when nobody is.
#include "apps/bvp/patience.hpp"

#include <chrono>
#include <optional>

#include "tests/catch.hpp"

using namespace grus::app;

namespace {

using Seconds = std::chrono::duration<double>;

int rank_of() {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

int all_ranks() {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

/// What is said on this rank, first, and after how long (s).
struct Heard {
  std::mutex mutex;
  std::optional<std::string> first;
  double after = 0;
  const std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();

  std::function<void(const std::string&)> ear() {
    return [this](const std::string& why) {
      const std::lock_guard hold(mutex);
      if (first) return;
      first = why, after = Seconds(std::chrono::steady_clock::now() - began).count();
    };
  }
  std::optional<std::string> said(double within) {
    for (const auto end = std::chrono::steady_clock::now() + Seconds(within); std::chrono::steady_clock::now() < end;) {
      std::this_thread::sleep_for(Seconds(0.01));
      const std::lock_guard hold(mutex);
      if (first) return first;
    }
    return {};
  }
};

constexpr double patience = 0.8;  // s

}  // namespace

TEST_CASE("rank 0 names those that have not told that they wait, by their numbers; the others name rank 0") {
  CHECK(silent_ranks(3, true, {}) == "rank 0 has not answered");
  CHECK(silent_ranks(0, true, {1, 0, 1}) == "rank 1 has not answered");
  CHECK(silent_ranks(0, true, {0, 1, 1}) == "rank 0 has not answered");
  CHECK(silent_ranks(0, true, {1, 0, 1, 0}) == "ranks 1, 3 have not answered");
  CHECK(silent_ranks(0, true, {1, 0, 0, 0, 0, 0, 0, 0, 0}) == "ranks 1, 2, 3, 4, 5, 6, 7, 8 have not answered");
  CHECK(silent_ranks(0, true, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}) ==
        "ranks 1, 2, 3, 4, 5, 6, 7, 8 and 2 more have not answered");
  CHECK(silent_ranks(0, true, {1, 1}) == "a rank has not answered");
  CHECK(silent_ranks(0, false, {1, 0}) == "a rank has not answered");
}

TEST_CASE("who works by itself while the others wait is named once their patience is over, and a quarter more") {
  const int rank = rank_of(), ranks = all_ranks();
  for (const int silent : {ranks - 1, 0}) {
    Heard heard;
    Patience waits(patience, heard.ear());
    {
      std::optional<Patience::Work> work;
      if (rank == silent) work.emplace(&waits);
      if (rank == 0) {
        const auto said = heard.said(20);
        REQUIRE(said);
        CHECK(*said == "rank " + std::to_string(silent) + " has not answered for 0.8 s (solve.patience)");
        CHECK(heard.after > 1.2 * patience);
      }
      MPI_Barrier(MPI_COMM_WORLD);
    }
  }
  // All wait, for something else than each other.
  Heard heard;
  Patience waits(patience, heard.ear());
  if (rank == 0) CHECK(heard.said(20) == "a rank has not answered for 0.8 s (solve.patience)");
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST_CASE("while all get on nobody loses patience, nor does who ends before") {
  Heard heard;
  {
    Patience waits(patience, heard.ear());
    for (int k = 0; k < 8; ++k) {  // they get on now and then: each time patience begins anew
      waits.got_on();
      std::this_thread::sleep_for(Seconds(0.3));
    }
    CHECK(!heard.first);
    { const Patience::Work work(&waits); }  // it gets on as it is done
  }
  CHECK(!heard.said(0.1));
  MPI_Barrier(MPI_COMM_WORLD);
}
