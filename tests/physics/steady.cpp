// SPDX-License-Identifier: LGPL-3.0-or-later
// A cell that is carried on without rest: objectivity, pace, what its rate costs, and where it goes as the rate goes to
// zero.
#include "dem/rve/steady.hpp"

#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/rves/rve_host.hpp"
#include "tests/fem/sand.hpp"

using namespace grus::dem;

namespace {

const grus::fem::test::Sand& cell() { return grus::fem::test::standard(); }

const std::shared_ptr<const Model>& cell_model() { return cell().model; }

Mat3 stretch(double x, double y, double z) { return Vec3(1 + x, 1 + y, 1 + z).asDiagonal(); }

struct Carried {
  State state = cell().state;
  Steady steady;
  QuasiStatic q = cell().q;
  Team team{1};
  Response operator()(const Mat3& f) { return respond_steadily(*cell().model, q, state, steady, f, true, team); }
};

}  // namespace

TEST_CASE("the stress of a cell that turns while it is strained is that of one that does not, turned: exactly") {
  Carried straight, turning;
  Mat3 total = Mat3::Identity();
  Response a, b;
  for (int k = 0; k < 200; ++k) {
    const Mat3 u = stretch(1e-5, 2e-5, -5e-5), r = rotation_by(Vec3(4e-3, -2e-3, 5e-3)).toRotationMatrix();
    a = straight(u);
    b = turning(r * total * u * total.transpose());
    total = r * total;
  }
  CHECK((b.stress - total * a.stress * total.transpose()).norm() <
        1e-6 * a.stress.norm());  // round-off of 200 products, through sliding contacts
  CHECK((b.tangent - turned(a.tangent, total)).norm() < 1e-6 * a.tangent.norm());
  const State there = in_space(turning.state, turning.steady);
  CHECK((parted_stress(there).rest - b.stress).norm() < 1e-9 * b.stress.norm());
}

TEST_CASE("steps are as many as strain and inertial number want, one at least, and the cell's time is its own") {
  Carried c;
  const double pressure = mean_pressure(parted_stress(c.state).rest), dt = c.state.dt;
  const double start = c.state.time;
  CHECK(c(Mat3::Identity()).steps == 1);
  CHECK(c.state.time - start == Approx(dt));
  c.q.strain_per_step = 1, c.q.inertial_number = 1e-3;
  const double begin = c.state.time;
  const Response fast = c(stretch(0, 0, -2e-4));
  CHECK(fast.inertial_number == Approx(1e-3).epsilon(0.05));  // at the pressure at the start and at the end
  CHECK(c.state.time - begin == Approx(2e-4 / (1e-3 / inertial_number(c.state, 1, pressure))).epsilon(0.02));
  Carried first;  // the first increment of all knows the pressure, too
  first.q = c.q;
  first(stretch(0, 0, -2e-4));
  CHECK(first.state.time - start == Approx(2e-4 / (1e-3 / inertial_number(first.state, 1, pressure))).epsilon(0.02));
  c.q.inertial_number = 1e9, c.q.strain_per_step = 1e-5;
  Carried by_strain;
  by_strain.q = c.q;
  CHECK(by_strain(stretch(0, 0, -2e-4)).steps == 20);
  // A small increment after a large one goes at a lower rate, not for a shorter time: what the grains answer is in
  // proportion to it.
  const double before = by_strain.state.time;
  by_strain(stretch(0, 0, -2e-5));
  CHECK(by_strain.state.time - before == Approx(0.97 * 20 * dt).epsilon(0.05));
}

TEST_CASE(
    "work on the grains less what the dashpots took for haste is the told stress on the strain; slower, the haste "
    "vanishes") {
  double haste[2];
  int k = 0;
  for (const double inertial : {4e-3, 4e-4}) {
    Carried c;
    c.q.inertial_number = inertial;
    const double start = c.state.ledger.work;
    Mat3 before = parted_stress(c.state).rest;
    double told = 0;
    Response r;
    for (int i = 0; i < 500; ++i) {
      const double volume = c.state.boundary.cell.volume();
      const Mat3 u = stretch(0, 0, -2e-5);
      r = c(u);
      told += 0.5 * volume * (before + r.stress).cwiseProduct(u - Mat3::Identity()).sum();
      before = r.stress;
    }
    const double work = c.state.ledger.work - start;
    CHECK(r.work == c.state.ledger.work);
    CHECK(r.haste > 0);
    CHECK(work - r.haste == Approx(told).epsilon(inertial > 1e-3 ? 0.02 : 0.002));  // the rest is the grains' inertia
    haste[k++] = r.haste / work;
  }
  CHECK(haste[1] < 0.4 * haste[0]);  // what grains lose when they jump stays
}

TEST_CASE("haste is booked where the rate jumps, too: dashpots are those of the new rate from the first DEM step on") {
  Carried c;
  Mat3 last = Mat3::Zero();  // a cell at rest has none
  for (const double strain : {-2e-4, 2e-4, -2e-4}) {
    State s = c.state;
    const double time = s.time, before = c.steady.haste;
    const Mat3 u = stretch(0, 0, strain), e = u - Mat3::Identity();
    const Response r = c(u);
    REQUIRE(r.steps >= 20);
    const double steps = static_cast<double>(r.steps), duration = c.state.time - time;
    Cell& cell = s.boundary.cell;
    set_cell_rate(s, cell.of_began(e * cell.began() / duration));
    update_time_step(*cell_model(), s, c.team);
    s.dt = duration / steps;
    double taken = 0;  // step by step
    for (std::uint64_t k = 0; k < r.steps; ++k) {
      run_steps(*cell_model(), s, 1, c.team);
      const Mat3 now = parted_stress(s).dashpots;
      taken += 0.5 * cell.volume() * (last + now).cwiseProduct(e).sum() / steps;
      last = now;
    }
    CHECK(taken > 0);
    CHECK(r.haste - before ==
          Approx(taken).epsilon(0.15));  // between its first step and its last it is no straight line
  }
}

TEST_CASE("as the inertial number goes to zero the stress goes to that of a cell that is brought to rest") {
  Rve rest(cell().model, cell().q, cell().state);
  Response r;
  for (int i = 0; i < 10; ++i) {
    r = rest.advance({stretch(1e-4, 1e-4, -5e-4)});
    REQUIRE(r.stable);
    rest.commit();
  }
  double off[2];
  int k = 0;
  for (const double inertial : {1e-2, 2e-4}) {
    Carried c;
    c.q.inertial_number = inertial;
    Response s;
    for (int i = 0; i < 500; ++i) s = c(stretch(2e-6, 2e-6, -1e-5));
    off[k++] = (s.stress - r.stress).norm() / r.stress.norm();
  }
  CHECK(off[1] < 0.04);  // 60 grains: sliding is a staircase
  CHECK(off[1] < off[0]);
}

TEST_CASE("what answers for grains that could not go on works on the volume that it has by now") {
  ResponseOptions options;
  options.quasi_static = cell().q;
  RveHost host(cell().model, options, 1);
  HostedRve rve{.state = cell().state};
  const double volume = 2, stress = -3e5;
  Remainder left;
  left.stress(2, 2) = stress, left.volume = volume, left.work = 7;
  rve.remainder = left;
  host.put(0, std::move(rve));
  Task task;
  task.pace = Pace::steady, task.path = {stretch(0, 0, -0.02)};
  double work = 0;
  for (int k = 0; k < 5; ++k) {
    const Outcome out = host.advance({task})[0];
    CHECK(out.given_up);
    CHECK(out.response.stress(2, 2) == Approx(stress));
    work = out.response.work;
  }
  CHECK(work - 7 == Approx(stress * volume * (std::pow(0.98, 5) - 1)).epsilon(1e-9));
}

TEST_CASE("where there is no memory that is no fault of the grains, and what is left of a host's answers is not told") {
  ResponseOptions options;
  options.quasi_static = cell().q;
  RveHost host(cell().model, options, 1);
  host.put(0, {.state = cell().state});
  Task task;
  task.pace = Pace::steady, task.path = {stretch(0, 0, -1e-5)};
  std::vector<Outcome> room = host.advance({task});
  REQUIRE(room[0].response.stable);
  const Watch no_memory = [](double) -> bool { throw std::bad_alloc(); };
  CHECK_THROWS_AS(host.advance({task}, no_memory, room), std::bad_alloc);
  task.path = {stretch(0, 0, 2 * Rve::most_stretch)};  // refused
  const std::vector<Outcome> refused = host.advance({task}, {}, std::move(room));
  REQUIRE(refused.size() == 1);
  CHECK_FALSE((refused[0].response.stable || refused[0].response.failure.empty()));
}
