// SPDX-License-Identifier: LGPL-3.0-or-later
// The driver of RVEs over a host without grains: bars whose stress is a closed form of where they are and of the way
// that they have come. What a new host must give is what this one has.
#include <new>

#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rves/driver.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;

namespace {

/// Length over its first one, and the sum of |ln| of all changes of it.
struct Bar {
  double length = 1, travelled = 0;
  Bar after(double stretch) const { return {length * stretch, travelled + std::abs(std::log(stretch))}; }
  double stress() const { return -(1e8 * (1 - length) + 1e10 * (1 - length) * (1 - length)) * (1 + travelled); }
  double tangent() const { return (1e8 + 2e10 * (1 - length)) * length * (1 + travelled); }  // the way held fixed
};

std::string bytes_of(const Bar& bar) {
  Saver a;
  a.plain(bar);
  return a.take();
}

struct Bars {
  std::map<std::uint64_t, Bar> committed, trial;
  double shortest = 0.5;    // a bar gets no shorter
  double believed = 1;      // what is told of the tangent
  bool full = false;        // no room for copies
  std::size_t commits = 0;  // calls

  void put(std::uint64_t slot, const std::string& state, double) {
    Loader a(state);
    Bar bar;
    a.plain(bar);
    committed[slot] = bar;
  }
  void copy(std::uint64_t from, std::uint64_t to) {
    if (full) throw std::bad_alloc();
    committed[to] = committed.at(from);
  }
  void drop(std::uint64_t slot) { REQUIRE(committed.erase(slot) == 1); }
  std::vector<Outcome> advance(const std::vector<Task>& tasks, const Watch& watch) {
    trial.clear();
    std::vector<Outcome> outcomes(tasks.size());
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      if (watch && !watch(static_cast<double>(k) / static_cast<double>(tasks.size()))) throw Interrupted("interrupted");
      Bar bar = committed.at(tasks[k].slot);
      Response& r = outcomes[k].response;
      for (const Mat3& f : tasks[k].path) bar = bar.after(f(2, 2)), ++r.steps;
      r.stress(2, 2) = bar.stress(), r.tangent(2, 2) = believed * bar.tangent();
      r.unbalanced_force = 0.1 * (1 - bar.length), r.stress_change = 0.2 * (1 - bar.length);
      const bool reached = bar.length >= shortest;
      outcomes[k].given_up = !reached && tasks[k].pace != Pace::relaxed;
      r.stable = reached || outcomes[k].given_up;
      if (!r.stable) r.failure = "too short";
      if (r.stable) (tasks[k].pace == Pace::relaxed ? trial : committed)[tasks[k].slot] = bar;
    }
    return outcomes;
  }
  std::vector<Facts> commit(const std::vector<std::uint64_t>& slots) {
    ++commits;
    for (const auto slot : slots) committed.at(slot) = trial.at(slot);
    return facts(slots);
  }
  std::vector<Facts> facts(const std::vector<std::uint64_t>& slots) const {
    std::vector<Facts> all(slots.size());
    for (std::size_t k = 0; k < slots.size(); ++k) all[k].work = committed.at(slots[k]).travelled;
    return all;
  }
  std::string fetch(std::uint64_t slot) const { return bytes_of(committed.at(slot)); }
};
static_assert(Host<Bars>);

constexpr double floor_stress = 1e3;  // Pa

struct Driven {
  Bars bars;
  Driver<Bars> driver;

  Driven(std::size_t points, RveOptions o = {})
      : driver(
            bars, [](std::size_t) { return bytes_of(Bar{}); }, 1, std::vector<std::size_t>(points, 0), with_floor(o)) {}
  static RveOptions with_floor(RveOptions o) {
    o.response.quasi_static.pressure_floor = floor_stress;
    return o;
  }
  bool respond(const std::vector<double>& stretches, const Watch& watch = {}) {
    std::vector<double> f;
    for (const double s : stretches) f.insert(f.end(), {1, 0, 0, 0, 1, 0, 0, 0, s});
    return driver.respond(f, 0, true, watch);
  }
  void go(const std::vector<double>& stretches) {
    REQUIRE(respond(stretches));
    driver.commit();
  }
  double heard(std::size_t point) const { return driver.answer(point).stress(2, 2); }
  const SweepReport& report() const { return driver.book().report; }
};

RveOptions sharing(double tolerance) {
  RveOptions o;
  o.share = tolerance;
  return o;
}

RveOptions deferring(double tolerance) {
  RveOptions o;
  o.error = tolerance;
  return o;
}

}  // namespace

TEST_CASE("every point hears its own bar; those of one history have one between them, and unused copies go") {
  RveOptions apart;
  apart.exact_sharing = false;
  Driven d(4), e(4, apart);
  CHECK((d.bars.committed.size() == 1 && e.bars.committed.size() == 4));
  const std::vector<double> first{0.99, 0.98, 0.99, 0.97};
  REQUIRE(d.respond({0.9, 0.8, 0.7, 0.6}));  // an iteration that is not committed
  for (Driven* x : {&d, &e}) {
    REQUIRE(x->respond(first));
    for (std::size_t i = 0; i < 4; ++i) CHECK(x->heard(i) == Approx(Bar{}.after(first[i]).stress()).epsilon(1e-7));
    x->driver.commit();
    CHECK(x->driver.facts(1).work == Approx(-std::log(0.98)));
  }
  CHECK((d.bars.committed.size() == 3 && d.report().distinct == 3 && e.bars.committed.size() == 4));
  CHECK((d.report().asked == 8 && d.report().advanced == 4 + 3 && e.report().advanced == 4));
  CHECK(d.report().dem_steps == 7);
}

TEST_CASE("the worst of the points is told, of the last commit alone, wherever it is among them") {
  RveOptions apart;
  apart.exact_sharing = false;
  for (std::size_t worst = 0; worst < 3; ++worst) {
    Driven three(3, apart);
    for (const double least : {0.96, 1.01}) {  // lengths then: 0.96, 0.9696 after 0.99, 0.9801
      std::vector<double> stretches(3, 0.99);
      stretches[worst] = least;
      three.go(stretches);
      const double length = least < 1 ? 0.96 : 0.9696;
      CHECK(three.report().worst_unbalanced == Approx(0.1 * (1 - length)));
      CHECK(three.report().worst_stress_change == Approx(0.2 * (1 - length)));
    }
  }
}

TEST_CASE("a point rides on a similar one to first order; where they part it goes its own way, and its error is told") {
  Driven d(2, sharing(1e-3));
  const Bar leads = Bar{}.after(0.99), own = Bar{}.after(0.9895);
  REQUIRE(d.respond({0.99, 0.9895}));
  const double told = leads.stress() + leads.tangent() * (0.9895 / 0.99 - 1);
  CHECK(d.heard(1) == Approx(told).epsilon(1e-7));
  CHECK((d.report().advanced == 1 && d.report().similar == 1));
  CHECK(d.report().correction == Approx(1 - leads.stress() / told).epsilon(1e-5));
  d.driver.commit();
  REQUIRE(d.respond({1, 0.98}));
  CHECK(d.heard(1) == Approx(own.after(0.98).stress()).epsilon(1e-7));
  CHECK((d.report().replayed == 1 && d.report().sharing.count == 1));
  const double wrong = std::abs(told / own.stress() - 1);
  REQUIRE(wrong > 1e-4);
  CHECK(d.report().sharing.worst == Approx(wrong).epsilon(1e-3));
  d.driver.commit();
  CHECK(d.bars.committed.at(d.driver.slot(1)).travelled == Approx(-std::log(0.9895 * 0.98)).epsilon(1e-7));
  Driven far(2, sharing(1e-3));
  far.go({0.99, 0.9885});
  CHECK((far.report().similar == 0 && far.bars.committed.size() == 2));
}

TEST_CASE("a bar that is put off answers by its tangent, then goes to its place first, and its error is told") {
  Driven d(1, deferring(0.05));
  d.go({0.99});
  const Bar asked = Bar{}.after(0.99), there = asked.after(0.9999 * 0.9999);
  for (int k = 0; k < 2; ++k) d.go({0.9999});
  CHECK(d.report().deferred == 2);
  const double told = asked.stress() + asked.tangent() * (0.9999 * 0.9999 - 1);
  CHECK(d.heard(0) == Approx(told).epsilon(1e-7));
  CHECK(d.bars.committed.at(0).length == Approx(0.99).epsilon(1e-8));  // where it was
  REQUIRE(d.respond({0.999}));
  CHECK(d.heard(0) == Approx(there.after(0.999).stress()).epsilon(1e-7));
  CHECK((d.report().advanced == 3 && d.report().deferral.count == 1));
  const double wrong = std::abs(told / there.stress() - 1);
  CHECK(d.report().deferral.worst == Approx(wrong).epsilon(1e-2));
  CHECK((wrong < 0.05 && d.report().least_trust == 1));
  // An iteration near it is not asked again.
  REQUIRE(d.respond({0.9991}));
  CHECK(d.report().advanced == 3);
}

TEST_CASE("who foretells badly is asked sooner") {
  Driven d(1, deferring(0.05));
  d.bars.believed = 0.2;
  d.go({0.99});
  const auto foretold = [&](double share) {  // the stretch whose foretold change is this share of the tolerance
    const Memory& m = d.driver.book().slots.at(0).memory;
    return 1 - share * 0.05 * m.stress.norm() / m.tangent(2, 2);
  };
  d.go({foretold(0.9)});
  REQUIRE(d.report().deferred == 1);
  const Bar asked = Bar{}.after(0.99);
  const double told = asked.stress() * (1 + 0.9 * 0.05), truth = d.bars.committed.at(0).after(foretold(0.9)).stress();
  const double wrong = std::abs(told / truth - 1);
  d.go({0.99});
  REQUIRE(wrong > 0.05);
  CHECK(d.report().deferral.worst == Approx(wrong).epsilon(1e-4));
  CHECK(d.report().least_trust == Approx(0.9 * 0.05 / wrong).epsilon(1e-4));
  for (const double share : {1.1, 0.9}) {
    const auto before = d.report().deferred;
    REQUIRE(d.respond({foretold(share * d.report().least_trust)}));
    CHECK(d.report().deferred - before == (share < 1 ? 1 : 0));
    d.driver.forget();
  }
}

TEST_CASE("a refusal names the point, and leaves what is committed") {
  Driven d(2);
  d.go({0.9, 0.8});
  const auto before = d.bars.committed;
  CHECK_FALSE(d.respond({0.9, 0.5}));
  CHECK(d.driver.book().reason == "RVE of point 1: too short");
  CHECK(d.bars.committed.at(1).length == before.at(1).length);
  d.go({0.9, 0.9});
  CHECK(d.bars.committed.at(1).length == Approx(0.72).epsilon(1e-8));
}

TEST_CASE("a point that cannot go its own way stays where it rode") {
  Driven d(2, sharing(1e-3)), undisturbed(2, sharing(1e-3));
  for (Driven* x : {&d, &undisturbed}) x->go({0.99, 0.9895});
  d.bars.shortest = 0.9897;
  CHECK_FALSE(d.respond({1, 1.01}));
  CHECK(d.driver.book().reason == "the RVE of point 1 does not get through the point's own path: too short");
  CHECK((d.bars.committed.size() == 1 && d.driver.slot(1) == 0));
  d.bars.shortest = 0.5;
  // Stopped on its way by the watch: the same.
  CHECK_THROWS_AS(d.respond({1, 1.01}, [](double) { return false; }), Interrupted);
  CHECK((d.bars.committed.size() == 1 && d.driver.slot(1) == 0));
  for (Driven* x : {&d, &undisturbed}) x->go({1, 1.01});
  CHECK(d.bars.committed.size() == 2);
  CHECK(d.heard(1) == undisturbed.heard(1));
}

TEST_CASE("a bar that was put off and does not get to its place is told as such") {
  Driven d(1, deferring(0.05));
  d.go({0.99});
  d.go({0.9998});
  d.bars.shortest = 0.98999;
  CHECK_FALSE(d.respond({1.01}));
  CHECK(d.driver.book().reason == "RVE of point 0, which was put off, does not get to its place: too short");
}

TEST_CASE("a copy for which there is no room is asked for again") {
  Driven d(3), undisturbed(3);
  d.bars.full = true;
  CHECK_THROWS_AS(d.respond({0.9, 0.8, 0.7}), std::bad_alloc);
  d.bars.full = false;
  for (Driven* x : {&d, &undisturbed}) x->go({0.9, 0.8, 0.7});
  for (std::size_t i = 0; i < 3; ++i) CHECK(d.heard(i) == undisturbed.heard(i));
  CHECK(d.bars.committed.size() == 3);
}

TEST_CASE("where there is no way back nothing is committed by request, and who gave up is counted") {
  RveOptions o;
  o.pace = Pace::steady;
  Driven d(2, o);
  d.go({0.8, 0.9});
  d.go({0.6, 0.9});
  CHECK((d.report().given_up == 1 && d.bars.commits == 0));
  CHECK(d.heard(1) == Approx(Bar{}.after(0.9).after(0.9).stress()).epsilon(1e-7));
  CHECK(d.driver.facts(1).work == 0);
  d.driver.refresh();
  CHECK(d.driver.facts(1).work == Approx(-2 * std::log(0.9)));
}

TEST_CASE("what a driver knows goes into another one, and what is no such thing leaves it as it was") {
  RveOptions o = sharing(1e-3);
  o.error = 0.05;
  Driven d(4, o), other(4, o), alone(1, o), plain(4);
  d.go({0.99, 0.9895, 0.98, 0.98});
  d.go({0.9998, 0.9998, 1, 1});
  REQUIRE((d.report().deferred > 0 && d.report().similar > 0));
  std::vector<std::string> parts;
  REQUIRE(d.respond({0.9, 0.95, 1, 0.97}));  // its copy is no part of it
  d.driver.save([&](const std::string& part) { parts.push_back(part); });
  const std::size_t with_copy = d.bars.committed.size();
  d.driver.forget();
  CHECK(d.bars.committed.size() == with_copy - 1);
  CHECK(d.driver.book().sharing.leader.size() == with_copy - 1);
  const std::string book = parts.front();
  parts.erase(parts.begin());
  CHECK(parts.size() == d.bars.committed.size());
  CHECK_THROWS_AS(alone.driver.load(book, parts), InputError);
  CHECK_THROWS_AS(plain.driver.load(book, parts), InputError);
  CHECK_THROWS_AS(other.driver.load(book.substr(0, book.size() - 1), parts), InputError);
  CHECK_THROWS_AS(other.driver.load(book, std::span(parts).first(1)), InputError);
  CHECK(other.bars.committed.size() == 1);
  other.driver.load(book, parts);
  for (Driven* x : {&d, &other}) x->go({0.99, 1, 0.9, 0.9});
  for (std::size_t i = 0; i < 4; ++i) CHECK(d.heard(i) == other.heard(i));
  CHECK(d.report().deferral.count == other.report().deferral.count);
  CHECK(d.report().sharing.worst == other.report().sharing.worst);
}

TEST_CASE("a state goes back to its point with what was known of it") {
  Driven d(2, deferring(0.05));
  d.go({0.99, 0.99});
  d.go({0.9998, 0.9998});
  const Memory memory = d.driver.book().slots.at(0).memory;
  REQUIRE(memory.pending(2, 2) < 1);
  const std::string state = d.bars.fetch(0);
  d.go({0.9, 0.9});
  Driven e(2, deferring(0.05));
  e.go({0.9, 0.9});
  for (Driven* x : {&d, &e}) {
    const std::size_t back = x == &d ? 1 : 0, stays = 1 - back;  // of e the point whose path the bar has had
    const double there = x->heard(stays);
    x->driver.replace(back, state, memory);
    CHECK((x->driver.slot(1) != x->driver.slot(0) && x->report().distinct == 2));
    REQUIRE(x->respond(back == 1 ? std::vector{1.0, 0.95} : std::vector{0.95, 1.0}));
    CHECK(x->heard(back) == Approx(Bar{}.after(0.99).after(0.9998).after(0.95).stress()).epsilon(1e-7));
    CHECK(x->heard(stays) == Approx(there));
  }
  CHECK_THROWS_AS(d.driver.replace(0, "no bar", memory), InputError);
  Memory damaged = memory;
  damaged.trust = NAN;
  CHECK_THROWS_AS(d.driver.replace(0, state, damaged), InputError);
}
