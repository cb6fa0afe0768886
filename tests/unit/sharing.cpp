// SPDX-License-Identifier: LGPL-3.0-or-later
// Who goes with whom, by made-up increments: no grain is asked.
#include "dem/rves/sharing.hpp"
#include "dem/rves/alike.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;

namespace {

Mat3 stretched(double strain) {
  Mat3 f = Mat3::Identity();
  f(2, 2) += strain;
  return f;
}

std::vector<Mat3> increments(std::initializer_list<double> strains) {
  std::vector<Mat3> f;
  for (const double e : strains) f.push_back(stretched(e));
  return f;
}

std::vector<std::uint64_t> slots(const SharingPlan& plan) {
  std::vector<std::uint64_t> of;
  for (const std::size_t job : plan.of) of.push_back(plan.job[job].slot);
  return of;
}

using Slots = std::vector<std::uint64_t>;
using Points = std::vector<std::size_t>;

}  // namespace

TEST_CASE("points of one history share an RVE until their increments differ") {
  Sharing s = begin_sharing(Points{0, 0, 1, 0}, true, 0);
  CHECK(s.leader == std::map<std::uint64_t, std::size_t>{{0, 0}, {1, 2}});
  const auto same = increments({0.1, 0.1, 0.1, 0.1});
  SharingPlan p = plan(s, same);
  CHECK(slots(p) == Slots{0, 0, 1, 0});
  CHECK(p.job.size() == 2);
  CHECK(commit(s, p, same).empty());
  // Two of them go another way, and together: one copy of their RVE.
  const auto apart = increments({0.1, 0.2, 0.1, 0.2});
  p = plan(s, apart);
  REQUIRE(p.copy.size() == 1);
  CHECK((p.copy[0].from == 0 && p.copy[0].to == 2));
  CHECK(slots(p) == Slots{0, 2, 1, 2});
  CHECK(p.job[2].increment == stretched(0.2));
  CHECK(p.job[2].leader == 1);
  // The next iteration parts them otherwise: the copy is used again, and one more is made.
  p = plan(s, increments({0.1, 0.3, 0.1, 0.4}));
  REQUIRE(p.copy.size() == 1);
  CHECK((p.copy[0].from == 0 && p.copy[0].to == 3));
  CHECK(slots(p) == Slots{0, 2, 1, 3});
  // And the last one needs one copy only: the other goes, with its leader.
  p = plan(s, apart);
  CHECK(p.copy.empty());
  CHECK(commit(s, p, apart) == Slots{3});
  CHECK(s.leader == std::map<std::uint64_t, std::size_t>{{0, 0}, {1, 2}, {2, 1}});
  // Once parted, equal increments do not bring them together again.
  p = plan(s, same);
  CHECK(slots(p) == Slots{0, 2, 1, 2});
  CHECK_FALSE(parted(s));
  const auto all = increments({0.1, 0.2, 0.1, 0.3});
  commit(s, plan(s, all), all);
  CHECK(parted(s));
  // The plan of those that have parted, in the room of another one: the same jobs, and the same end.
  for (const auto& now : {same, all}) {
    const SharingPlan slow = plan(s, now);
    plan_parted(s, now, p);
    REQUIRE(p.of == Points{0, 1, 2, 3});
    CHECK(slots(p) == slots(slow));
    for (std::size_t i = 0; i < 4; ++i)
      CHECK((p.job[i].leader == i && p.job[i].increment == slow.job[slow.of[i]].increment));
    Sharing other = s;
    CHECK((commit(s, p, now).empty() && commit(other, slow, now).empty()));
    for (std::size_t i = 0; i < 4; ++i)
      CHECK((s.point[i].total == other.point[i].total && s.point[i].slot == other.point[i].slot));
    CHECK(s.leader == other.leader);
  }
}

TEST_CASE("without exact sharing every point has an RVE of its own") {
  Sharing s = begin_sharing(Points{0, 0, 0}, false, 0);
  CHECK(parted(s));
  CHECK(slots(plan(s, increments({0.1, 0.1, 0.1}))) == Slots{0, 1, 2});
}

TEST_CASE("similar points ride on one RVE within the tolerance over their whole history, or replay their own") {
  Sharing s = begin_sharing(Points{0, 0}, true, 0.01);
  auto go = [&](double a, double b) {
    const auto f = increments({a, b});
    const SharingPlan p = plan(s, f);
    commit(s, p, f);
    return p;
  };
  SharingPlan p = go(0.1, 0.106);
  CHECK(slots(p) == Slots{0, 0});
  CHECK(s.point[1].distance == Approx(0.006));
  CHECK(p.replay.empty());
  // Back at the same deformation: the distance of the history stays.
  go(0, stretched(0.1)(2, 2) / stretched(0.106)(2, 2) - 1);
  CHECK((s.point[1].total - s.point[0].total).norm() < 1e-12);
  CHECK(s.point[1].distance == Approx(0.006));
  // Too far apart: what it has ridden on is not its own past.
  const auto far = increments({0.1, 0.12});
  p = plan(s, far);
  REQUIRE(p.replay.size() == 1);
  CHECK((p.replay[0].point == 1 && p.replay[0].slot == 1 && p.replay[0].was == 0));
  CHECK(slots(p) == Slots{0, 1});
  CHECK(s.path[1].size() == 2);
  CHECK(p.copy.empty());
  // A replay that fails leaves it where it was.
  undo(s, p.replay[0]);
  CHECK(s.point[1].slot == 0);
  CHECK(s.point[1].distance == Approx(0.006));
  CHECK(s.leader == std::map<std::uint64_t, std::size_t>{{0, 0}});
  p = plan(s, far);
  CHECK(slots(p) == Slots{0, 2});  // numbers are not used twice
  commit(s, p, far);
  CHECK(s.point[1].distance == 0);
  CHECK(s.leader.at(2) == 1);
}

TEST_CASE("points of another packing never ride along") {
  Sharing s = begin_sharing(Points{0, 1}, true, 0.01);
  CHECK(slots(plan(s, increments({0.1, 0.1}))) == Slots{0, 1});
}

TEST_CASE("increments that differ by round-off are one, those that differ by more are not") {
  for (int k = 0; k < 200; ++k) {
    Alike alike;
    const Mat3 f = stretched(0.01 + 1e-10 * k);
    CHECK(alike(f) == f);
    CHECK(alike(stretched(0.01 + 1e-10 * k + 2e-10)) == f);
    const Mat3 other = stretched(0.01 + 1e-10 * k + 2e-9);
    CHECK(alike(other) == other);
  }
}
