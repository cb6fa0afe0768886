// SPDX-License-Identifier: LGPL-3.0-or-later
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <fstream>

#include "dem/base/error.hpp"
#include "dem/base/parallel.hpp"
#include "dem/contact/broad_phase.hpp"
#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/criteria.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Grains cloud(std::size_t n, double size, double ratio) {
  Grains g;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = 0.02 * std::pow(ratio, random_uniform(1, i, Purpose::radius));
    Vec3 x;
    for (int k = 0; k < 3; ++k)
      x[k] = size *
             (3 * random_uniform(1, i, Purpose::position, static_cast<std::uint64_t>(k)) - 1);  // also outside the cell
    set_grain(g, i, {.shape = PolyEllipsoid::sphere(r), .position = x, .density = 1});
  }
  return g;
}

std::size_t brute_force(const Grains& g, const Cell& cell, double skin) {
  std::size_t pairs = 0;
  const int reach = cell.periodic() ? 4 : 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t j = i + 1; j < g.size(); ++j)
      for (int a = -reach; a <= reach; ++a)
        for (int b = -reach; b <= reach; ++b)
          for (int c = -reach; c <= reach; ++c) {
            const Vec3 d = g.motion[j].position + cell.vectors * Vec3(a, b, c) - g.motion[i].position;
            pairs += d.norm() < g.motion[i].radius + g.motion[j].radius + skin;
          }
  return pairs;
}

}  // namespace

TEST_CASE("the grids find every near pair once, size ratio 1:30") {
  const Grains g = cloud(600, 2, 30);
  Team team(2);
  Candidates found;
  SearchRoom room;
  find_candidates(g, {}, 0.01, found, room, team);
  CHECK(found.pair.size() == brute_force(g, {}, 0.01));
  CHECK(std::adjacent_find(found.pair.begin(), found.pair.end(),
                           [](const auto& p, const auto& q) { return p.a == q.a && p.b == q.b; }) == found.pair.end());
}

TEST_CASE("the grids find every near pair of a sheared periodic cell, images included") {
  const Grains g = cloud(150, 1.6, 30);
  Cell cell;
  cell.vectors << 1.6, 0.5, -0.2, 0, 1.7, 0.3, 0, 0, 1.5;
  Team team(2);
  Candidates found;
  SearchRoom room;
  find_candidates(g, cell, 0.01, found, room, team);
  CHECK(found.pair.size() == brute_force(g, cell, 0.01));
  for (const auto& p : found.pair) {
    const Vec3 d =
        g.motion[p.b].position + cell.vectors * Vec3(p.image[0], p.image[1], p.image[2]) - g.motion[p.a].position;
    REQUIRE(d.norm() < g.motion[p.a].radius + g.motion[p.b].radius + 0.01);
  }
}

TEST_CASE("Hoek-Brown strengths are those of the closed form") {
  const HoekBrown hb{592e6, 20.56};
  for (const auto& [s3, s1] : std::vector<std::pair<double, double>>{
           {0, 592e6}, {50e6, 1029.3e6}, {100e6, 1352.0e6}, {200e6, 1868.8e6}, {592e6, 3340.8e6}}) {
    const Mat3 stress = Vec3(-s1, -s3, -s3).asDiagonal();
    CHECK(hb.utilisation(stress, 1) == Approx(1).epsilon(1e-4));
    CHECK(hb.utilisation(stress, 2) < 1);
  }
  CHECK(hb.utilisation(Vec3(28.9e6, 0, 0).asDiagonal(), 1) >= 1);  // beyond the apex at 28.794 MPa: failed, not NaN
  CHECK(hb.utilisation(Vec3(1e12, 1e12, 1e12).asDiagonal(), 1) >= 1);
  CHECK(hb.utilisation(Mat3::Zero(), 1) == 0);
}

TEST_CASE("Weibull strengths pass a Kolmogorov-Smirnov test at N = 1e4, with the size effect") {
  const Weibull w{3.1, 0.3e-3, 3 / 3.1};
  for (double radius : {0.3e-3, 0.15e-3}) {
    std::vector<double> factor;
    for (std::uint64_t i = 0; i < 10000; ++i)
      factor.push_back(w.factor(radius, random_uniform(11, i, Purpose::strength)));
    std::sort(factor.begin(), factor.end());
    const double scale = std::pow(radius / w.reference_radius, -w.size_exponent);
    double distance = 0;
    for (std::size_t i = 0; i < factor.size(); ++i) {
      const double cdf = 1 - std::exp(-std::pow(factor[i] / scale, w.modulus));
      distance = std::max(
          {distance, std::abs(cdf - static_cast<double>(i) / 1e4), std::abs(cdf - static_cast<double>(i + 1) / 1e4)});
    }
    CHECK(distance < 1.63 / 100);  // p = 0.01
  }
  CHECK(w.factor(0.15e-3, 0.5) / w.factor(0.3e-3, 0.5) == Approx(std::pow(2.0, 3 / 3.1)).epsilon(1e-12));
}

TEST_CASE("shape rules: cases 1 to 5 of Zhang et al. 3.3.3") {
  auto shape = [](Vec3 plus, Vec3 minus) { return PolyEllipsoid{plus, minus}; };
  const Vec3 y_wins(0, 2, 1), z_wins(0, 1, 2);
  CHECK(choose_axis(shape({1, 1, 1}, {1, 1, 1}), Vec3(3, 2, 1)) == 0);                  // case 1
  CHECK(choose_axis(shape({0.9, 0.9, 0.9}, {0.1, 0.1, 0.1}), y_wins) == std::nullopt);  // case 2
  CHECK(choose_axis(shape({0.9, 0.9, 1}, {0.1, 0.1, 1}), y_wins) == 2);                 // case 3: 2 > 1.2 * 0.9
  CHECK(choose_axis(shape({0.9, 0.9, 0.5}, {0.1, 0.1, 0.5}), y_wins) == std::nullopt);  // case 4: 1 < 1.08
  CHECK(choose_axis(shape({0.9, 2, 1}, {0.1, 2, 1}), z_wins) == 1);                     // case 5: longer along y
  CHECK(choose_axis(shape({0.9, 1, 2}, {0.1, 1, 2}), y_wins) == 2);                     // longer along z
  CHECK(choose_axis(shape({0.9, 1, 1}, {0.1, 1, 1}), y_wins) == 1);                     // alike: the criterion decides
  CHECK(choose_axis(shape({0.9, 1, 1}, {0.1, 1, 1}), z_wins) == 2);                     // the paper's missing else
}

TEST_CASE("the dashpot gives the restitution that was asked for, force cut at zero") {
  for (double e : {0.2, 0.4, 0.6, 0.8, 0.9})
    for (const ContactLaw& law : {ContactLaw{HertzMindlin{}}, ContactLaw{LinearSpring{}}})
      CHECK(restitution_of(law, dashpot_for(law, e)) == Approx(e).epsilon(2e-3));
  // Independent figures: the textbook Hertz coefficient 2 sqrt(5/6) beta gives 0.4720 for 0.4 and 0.8081 for 0.8 once
  // cut.
  for (const auto& [e, cut] : std::vector<std::pair<double, double>>{{0.4, 0.4720}, {0.8, 0.8081}}) {
    const double beta = -std::log(e) / std::sqrt(std::log(e) * std::log(e) + pi * pi);
    CHECK(restitution_of(HertzMindlin{}, 2 * std::sqrt(5.0 / 6) * beta) == Approx(cut).epsilon(2e-3));
  }
}

TEST_CASE("a team covers every index once, for any number of threads") {
  for (int threads : {1, 2, 5}) {
    Team team(threads);
    std::vector<int> hits(10007, 0);
    for (int round = 0; round < 50; ++round)
      team.blocks(hits.size(), [&](std::size_t b, std::size_t e) {
        for (std::size_t i = b; i < e; ++i) ++hits[i];
      });
    team.each(hits.size(), [&](std::size_t i) { ++hits[i]; });
    CHECK(std::all_of(hits.begin(), hits.end(), [](int h) { return h == 51; }));
  }
}

TEST_CASE("columns share their length after splits and appends") {
  Grains g = cloud(5, 1, 2);
  g.strength.assign(5, 1), g.generation.assign(5, 0);
  set_grain(g, 5, {.shape = PolyEllipsoid::sphere(1), .density = 1});
  for_each_column(g, [&](auto& column) { CHECK((column.empty() || column.size() == 6)); });
}

TEST_CASE(
    "sizes that differ by any factor are searched, and a cell that is too small is refused before a run, unstable in "
    "it") {
  Team team(1);
  Grains g;
  const double sizes[] = {1e-3, 1e20, 2e-3};
  for (std::size_t i = 0; i < 3; ++i)
    set_grain(g, i,
              {.shape = PolyEllipsoid::sphere(sizes[i]),
               .position = Vec3(3e-3 * static_cast<double>(i), 0, 0),
               .density = 1e-3});
  Candidates found;
  SearchRoom room;
  find_candidates(g, {}, 1e-4, found, room, team);
  CHECK(found.pair.size() == 2);  // the giant holds both of the others, which are 2e-3 + 1e-3 apart from touching
  Cell cell;
  cell.vectors = Mat3::Identity();
  Grains one;
  set_grain(one, 0, {.shape = PolyEllipsoid::sphere(0.49), .position = Vec3::Zero(), .density = 1});
  CHECK_NOTHROW(refuse_small_cell(one, cell, 0.01));
  CHECK_NOTHROW(find_candidates(one, cell, 0.01, found, room, team));
  CHECK_THROWS_AS(refuse_small_cell(one, cell, 0.03), InputError);
  CHECK_THROWS_AS(find_candidates(one, cell, 0.03, found, room, team), Unstable);
}

TEST_CASE("threads that cannot be had are one error, and the others go home") {
  // Address space for a handful of stacks only.
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  rlimit tight = before;
  std::ifstream statm("/proc/self/statm");
  std::size_t pages = 0;
  statm >> pages;
  tight.rlim_cur = pages * 4096 + (std::size_t{100} << 20);
  REQUIRE(setrlimit(RLIMIT_AS, &tight) == 0);
  std::string said;
  try {
    Team many(500);
  } catch (const std::runtime_error& e) {
    said = e.what();
  }
  setrlimit(RLIMIT_AS, &before);
  CHECK(said.find("cannot start 500 threads") != std::string::npos);
  Team two(2);
  std::size_t sum = 0;
  two.blocks(1000, [&](std::size_t b, std::size_t e) { std::atomic_ref(sum) += e - b; });
  CHECK(sum == 1000);
}
