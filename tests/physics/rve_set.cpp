// SPDX-License-Identifier: LGPL-3.0-or-later
// Sets of RVEs, by a simple-cubic cell whose stress under oedometric strain is 2/3 E* strain^1.5 in closed form.
#include "dem/rves/rve_set.hpp"

#include <chrono>

#include "dem/base/error.hpp"
#include "dem/rve/rve.hpp"
#include "dem/rve/step.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double E_star = 30.892802e9;  // Pa

struct Cubic {
  std::shared_ptr<const Model> model;
  State state;
};

Cubic cubic() {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.5));
  set_damping(model, 0.5);
  State s;
  const double R = 3e-4;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) add(s, PolyEllipsoid::sphere(R), 2 * R * Vec3(x, y, z), 2650);
  s.boundary.cell.vectors = 6 * R * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  return {std::make_shared<const Model>(model), s};
}

ResponseOptions quick() {
  ResponseOptions o;
  o.quasi_static.pressure_floor = 1e5;
  return o;
}

RveSet set_of(std::size_t points, int threads = 1) {
  const Cubic c = cubic();
  const std::vector<std::size_t> start(points, 0);
  return {c.model, {c.state}, start, quick(), threads, 7};
}

std::vector<double> squeezed(const std::vector<double>& strains) {
  std::vector<double> f;
  for (const double e : strains) f.insert(f.end(), {1, 0, 0, 0, 1, 0, 0, 0, 1 - e});
  return f;
}

struct Answer {
  std::vector<double> stress, tangent;
};

Answer answer(RveSet& rves, const std::vector<double>& strains) {
  Answer a{std::vector<double>(6 * strains.size()), std::vector<double>(36 * strains.size())};
  rves.advance(squeezed(strains), a.stress, a.tangent);
  return a;
}

}  // namespace

TEST_CASE("every point of a set hears its own answer, and those alike have one RVE") {
  RveSet rves = set_of(4, 2);
  CHECK(rves.distinct() == 1);
  const std::vector<double> strains{1e-3, 1e-2, 1e-3, 5e-3};
  const Answer a = answer(rves, strains);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(a.stress[6 * i + 2] == Approx(-2.0 / 3 * E_star * std::pow(strains[i], 1.5)).epsilon(2e-3));
    CHECK(std::abs(a.stress[6 * i]) < 1e-3 * std::abs(a.stress[6 * i + 2]));
    // Its derivative; the cell's lower height and the frozen stiffness are of second order.
    CHECK(a.tangent[36 * i + 14] == Approx(E_star * std::sqrt(strains[i])).epsilon(2 * strains[i] + 2e-3));
    CHECK(rves.response(i).stress(2, 2) == a.stress[6 * i + 2]);
  }
  rves.commit();
  CHECK(rves.distinct() == 3);
  CHECK(rves.facts(0).work == rves.facts(2).work);
  CHECK(rves.facts(1).work > rves.facts(3).work);
  CHECK_THROWS_AS(rves.response(0), std::logic_error);
  CHECK_THROWS_AS(rves.commit(), std::logic_error);
}

TEST_CASE("a set goes back and forth between states, bit for bit") {
  RveSet rves = set_of(3);
  answer(rves, {1e-3, 1e-3, 2e-3});
  rves.commit();
  const std::string before = rves.bytes(0);
  std::vector<std::string> parts;
  rves.save([&](const std::string& part) { parts.push_back(part); });
  CHECK(parts.size() == 3);  // who shares, and two RVEs
  const Answer ahead = answer(rves, {1e-3, 2e-3, 1e-3});
  rves.commit();
  CHECK(rves.distinct() == 3);
  rves.load(parts);
  CHECK(rves.distinct() == 2);
  CHECK(answer(rves, {1e-3, 2e-3, 1e-3}).stress == ahead.stress);
  rves.restore(1, before);  // drops the copy that the increment has made
  CHECK(rves.distinct() == 3);
  CHECK(answer(rves, {1e-3, 2e-3, 1e-3}).stress == ahead.stress);
  rves.restore(0, before);
  rves.restore(0, before);
  CHECK(rves.distinct() == 3);
  CHECK(rves.bytes(0) == before);

  // The point whose path its RVE has had leaves it: another one leads.
  RveSet shared = set_of(3);
  shared.restore(0, shared.bytes(0));
  CHECK(shared.distinct() == 2);
  CHECK(answer(shared, {1e-3, 1e-3, 2e-3}).stress == answer(shared, {1e-3, 1e-3, 2e-3}).stress);
  shared.commit();
  CHECK(shared.distinct() == 3);
  CHECK(shared.bytes(0).size() == before.size());

  CHECK_THROWS_AS(rves.restore(0, before.substr(0, 5)), InputError);
  for (std::size_t part = 1; part < 40; ++part) {  // most numbers may be any number: only the checksum knows
    std::string damaged = before;
    damaged[part * damaged.size() / 40] ^= 1;
    CHECK_THROWS_AS(rves.restore(0, damaged), InputError);
  }
  CHECK_THROWS_AS(rves.load({parts[0], parts[1]}), InputError);
  CHECK_THROWS_AS(set_of(4).load(parts), InputError);
  const Cubic c = cubic();
  const std::vector<std::size_t> start(3, 0);
  RveSet stranger(c.model, {c.state}, start, quick(), 1, 8);
  CHECK_THROWS_AS(stranger.restore(0, before), InputError);
}

TEST_CASE("what is no increment is refused, and what leaves no room for the grains at once") {
  RveSet rves = set_of(2);
  std::vector<double> stress(12, 7.0), none;
  auto refused = [&](std::vector<double> f) { rves.advance(f, stress, none); };
  CHECK_THROWS_AS(refused(squeezed({0})), InputError);
  CHECK_THROWS_AS(refused(squeezed({0, 1})), InputError);    // det F = 0
  CHECK_THROWS_AS(refused(squeezed({0, 1.5})), InputError);  // det F < 0
  CHECK_THROWS_AS(refused(squeezed({0, NAN})), InputError);
  // Spheres that fill pi/6 of the cell: shrunk by half of 20 % of a radius they fill 0.382 of it.
  std::string said;
  try {
    refused(squeezed({0, 0.62}));
  } catch (const Unstable& e) {
    said = e.what();
  }
  CHECK(said.find("RVE of point 1: an increment to 0.38 of the volume leaves no room") == 0);
  CHECK(stress == std::vector<double>(12, 7.0));
  std::vector<double> tangent(72);
  CHECK_THROWS_AS(rves.advance(squeezed({0, 0}), stress, std::span(tangent).first(71)), InputError);
  refused(squeezed({0, 1e-3}));
  CHECK(stress[8] < -1e5);
}

TEST_CASE("an increment that no cell can follow is refused before a step is made") {
  // Forty thousand million steps if it were tried.
  const Cubic c = cubic();
  Rve rve(c.model, quick().quasi_static, c.state);
  RveSet rves = set_of(1);
  std::vector<double> stress(6), none;
  const auto advanced = [&](const Mat3& f) { return rve.advance({f}); };
  for (const double a : {1e6, 10.1, 1e150}) {
    const Response big = advanced(a * Mat3::Identity());
    CHECK(!big.stable);
    CHECK(big.steps == 0);
    CHECK(big.failure.find("take a smaller one") != std::string::npos);
    CHECK_THROWS_AS(rves.advance(std::vector<double>{a, 0, 0, 0, a, 0, 0, 0, a}, stress, none), Unstable);
  }
  Mat3 sheared = Mat3::Identity();
  sheared(0, 1) = 1e6;  // det F = 1: its volume is not what is wrong
  CHECK(advanced(sheared).failure.find("stretches by 1e-06 to 1e+06") != std::string::npos);
  const Response thin = advanced(Vec3(4, 4, 0.09).asDiagonal().toDenseMatrix());  // only that edge goes too far
  CHECK(thin.failure.find("stretches by 0.09 to 4") != std::string::npos);
  CHECK(thin.steps == 0);
  CHECK(advanced(-Mat3::Identity()).failure.find("det F = -1") == 0);
  CHECK(advanced(NAN * Mat3::Identity()).steps == 0);
  CHECK(advanced(Vec3(2, 1, 0.9).asDiagonal().toDenseMatrix()).failure.find("stretches") == std::string::npos);
  CHECK_THROWS_AS(rve.advance_steadily(sheared, false), Unstable);
}

TEST_CASE("the watch stops an advance between RVEs, and the committed states stand") {
  RveSet rves = set_of(3);
  const Answer before = answer(rves, {1e-3, 2e-3, 3e-3});
  std::vector<double> stress(18), none;
  int asked = 0;
  double last = 0;
  const Watch second = [&](double part) {
    CHECK(part >= last);  // thirds, and once more within an RVE that takes long
    CHECK(part < 1);
    last = part;
    return ++asked < 2;
  };
  CHECK_THROWS_AS(rves.advance(squeezed({1e-3, 2e-3, 3e-3}), stress, none, second), Interrupted);
  CHECK(asked == 2);
  CHECK_THROWS_AS(rves.commit(), std::logic_error);
  CHECK(answer(rves, {1e-3, 2e-3, 3e-3}).stress == before.stress);
}

TEST_CASE("the watch stops an advance within RVEs, on all threads") {
  // Three times as wide: 350,000 steps, a second or more.
  const Cubic c = cubic();
  for (const int threads : {1, 2}) {
    const std::vector<std::size_t> start(2, 0);
    RveSet rves(c.model, {c.state}, start, quick(), threads, 7);
    const Answer before = answer(rves, {1e-3, 2e-3});
    std::vector<double> stress(12, 7.0), none, wide(18, 0.0);
    for (std::size_t k = 0; k < 18; k += k % 9 == 8 ? 1 : 4) wide[k] = k < 9 ? 3 : 2.9;
    int asked = 0;
    const auto begin = std::chrono::steady_clock::now();
    CHECK_THROWS_AS(rves.advance(wide, stress, none, [&](double) { return ++asked < 3; }), Interrupted);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    CHECK(asked == 3);
    CHECK(seconds < 1);
    CHECK(stress == std::vector<double>(12, 7.0));
    CHECK(answer(rves, {1e-3, 2e-3}).stress == before.stress);
  }
}

namespace {

/// The same cells with and without what may be left out, and the largest difference of their stresses along z,
/// relative.
struct Both {
  RveSet plain, less;
  double apart = 0;

  Both(std::size_t points, RveOptions with) : plain(made(points, rest({}))), less(made(points, rest(with))) {}
  static RveOptions rest(RveOptions o) {
    o.response = {.quasi_static = quick().quasi_static, .elastic = o.response.elastic};
    o.response.quasi_static.unbalanced_force = o.response.quasi_static.stress_change = 1e-6;
    return o;
  }
  static RveSet made(std::size_t points, const RveOptions& o) {
    const Cubic c = cubic();
    return {c.model, {c.state}, std::vector<std::size_t>(points, 0), o, 1, 7};
  }
  void go(const std::vector<double>& strains) {
    const Answer a = answer(plain, strains), b = answer(less, strains);
    for (std::size_t k = 2; k < a.stress.size(); k += 6)
      apart = std::max(apart, std::abs(b.stress[k] / a.stress[k] - 1));
    plain.commit(), less.commit();
  }
};

// What is left of two cells, each at rest to 1e-6 of its forces, by several increments.
constexpr double at_rest = 1e-5;

}  // namespace

TEST_CASE("similar sharing in a set: fewer RVEs, other stresses, off by what is told once the points part") {
  RveOptions with;
  with.share = 2e-3;
  Both p(2, with);
  p.go({5e-3, 6e-3});
  CHECK((p.plain.distinct() == 2 && p.less.distinct() == 1));
  CHECK(p.less.report().similar == 1);
  CHECK(p.less.report().correction > 0.1);
  REQUIRE(p.apart > 1e-3);
  p.go({5e-3, 1e-2});
  CHECK(p.less.distinct() == 2);
  REQUIRE((p.less.report().replayed == 1 && p.less.report().sharing.count == 1));
  CHECK(p.less.report().sharing.worst == Approx(p.apart).epsilon(1e-2));
  CHECK_THROWS_AS(p.less.bytes(0), InputError);
  CHECK_THROWS_AS(p.less.restore(0, p.plain.bytes(0)), InputError);
}

TEST_CASE("deferral in a set: less DEM, other stresses, within what is told once the RVE has gone to its place") {
  RveOptions with;
  with.error = 0.4;
  Both p(1, with);
  p.go({5e-3});
  for (int k = 0; k < 12; ++k) p.go({4e-4});
  const std::string waiting = p.less.bytes(0);
  p.go({1e-2});  // the last one that waited is measured
  const SweepReport& report = p.less.report();
  CHECK((report.deferred > 6 && report.deferral.count > 1));
  CHECK(p.plain.report().advanced == 14);
  CHECK(report.advanced < 9);
  REQUIRE(p.apart > 2 * at_rest);
  CHECK(p.apart < report.deferral.worst + at_rest);
  CHECK(report.deferral.worst < with.error);
  // A state knows that its RVE waits: from it the same answer.
  const Answer ahead = answer(p.less, {1e-3});
  RveSet other = Both::made(1, Both::rest(with));
  other.restore(0, waiting);
  answer(other, {1e-2});
  other.commit();
  CHECK(answer(other, {1e-3}).stress == ahead.stress);
  std::string said;
  try {
    other.restore(0, p.plain.bytes(0));
  } catch (const InputError& e) {
    said = e.what();
  }
  CHECK(said.find("other settings") != std::string::npos);
}

TEST_CASE("elastic answers in a set: less DEM, other stresses, within what is told once the grains catch up") {
  RveOptions with;
  with.response.elastic = 0.3;
  Both p(1, with);
  p.go({5e-3});
  for (int k = 0; k < 12; ++k) p.go({4e-4});
  p.go({1e-2});
  const SweepReport& report = p.less.report();
  CHECK((report.elastic > 3 && report.linear.count > 0));
  CHECK(report.advanced < 12);
  REQUIRE(p.apart > 2 * at_rest);
  CHECK(p.apart < report.linear.worst + at_rest);
}

TEST_CASE("a set that leaves work out is saved with what it knows, and goes on with the same bits") {
  RveOptions with;
  with.share = 2e-3, with.error = 0.4;
  Both p(3, with);
  p.go({5e-3, 6e-3, 2e-2});
  p.go({4e-4, 4e-4, 4e-4});
  std::vector<std::string> parts;
  p.less.save([&](const std::string& part) { parts.push_back(part); });
  RveSet other = Both::made(3, Both::rest(with));
  other.load(parts);
  for (const auto& strains : {std::vector{4e-4, 4e-4, 1e-2}, std::vector{1e-3, 8e-3, 1e-3}}) {
    CHECK(answer(other, strains).stress == answer(p.less, strains).stress);
    other.commit(), p.less.commit();
  }
  CHECK(p.less.report().replayed == 1);
  CHECK(other.report().sharing.worst == p.less.report().sharing.worst);
  CHECK_THROWS_AS(p.plain.load(parts), InputError);
}
