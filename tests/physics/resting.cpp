// SPDX-License-Identifier: LGPL-3.0-or-later
// A cell that rests between increments: what is kept is kept to the bit, the rest is made again, and costs little room.
#include "dem/rve/resting.hpp"

#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rves/rve_host.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// No dashpots: forces follow from where the grains are and from what the springs remember.
Model elastic_sand(double rolling = 0.2) {
  Material sand = solid(60e9, 0.17, 2650, 0.5);
  sand.rolling_friction = rolling;
  return model_of(sand);
}

/// A dense cell that shears, in the middle of a run: grains turn and slide.
State sheared(const Model& model, bool bodies, Team& team) {
  State s;
  const std::uint64_t n = 6;
  const double r = 3e-4, pitch = 1.97 * r;
  for (std::uint64_t i = 0; i < n * n * n; ++i) {
    PolyEllipsoid shape = PolyEllipsoid::sphere(r * (1 - 0.02 * random_uniform(4, i, Purpose::radius)));
    if (bodies && i % 2) shape = random_shape(3, i, 0.8, 1.1), shape.plus *= r, shape.minus *= r;
    add(s, shape,
        pitch * Vec3(static_cast<double>(i % n), static_cast<double>(i / n % n), static_cast<double>(i / n / n)), 2650,
        Vec3::Zero(), Vec3::Zero(), random_rotation(7, i));
  }
  s.boundary.cell.vectors = static_cast<double>(n) * pitch * Mat3::Identity();
  prepare(model, s, team);
  Mat3 shear = Mat3::Zero();
  shear(0, 2) = 3000, shear(2, 2) = -2000;
  set_cell_rate(s, shear * s.boundary.cell.vectors);
  for (int k = 0; k < 6; ++k) update_time_step(model, s), run_steps(model, s, 50, team);
  return s;
}

State bonded(const Model& model, Team& team) {
  State s;
  s.boundary.cell.vectors = 6 * Mat3::Identity();  // two tiles
  add_voronoi_grains(model, voronoi_packing(periodic_space(Vec3::Constant(6)), 216, 5, 1, team), 0, s);
  auto& bonds = s.bonds.face.row;
  for (std::size_t k = 0; k < bonds.size(); k += 2) bonds.erase(bonds.begin() + static_cast<std::ptrdiff_t>(k));
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -1e-3 / (50 * s.dt);
  set_cell_rate(s, rate * s.boundary.cell.vectors);
  run_steps(model, s, 50, team);
  return s;
}

/// Of touching pairs: what they remember, and the force, by their grains.
std::vector<std::tuple<Pair, Contact, Touch>> touching(const State& s) {
  std::vector<std::tuple<Pair, Contact, Touch>> all;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k))
      all.emplace_back(s.contacts.pair[k], s.contacts.contact[k], s.contacts.touch[k]);
  std::sort(all.begin(), all.end(),
            [](const auto& p, const auto& q) { return by_place(std::get<0>(p), std::get<0>(q)); });
  return all;
}

template <class Column>
std::string bytes_of_column(const Column& column) {
  Saver a;
  a.column(column);
  return a.take();
}

void check_awake(const Model& model, const State& before, Team& team) {
  State now = at_rest(before);
  awaken(model, now, team);
  Grains as_before = before.grains, as_now = now.grains;
  double most = 0;
  for (std::size_t i = 0; i < before.grains.size(); ++i) {
    most = std::max(most, before.grains.force[i].norm());
    CHECK((now.grains.extent[i].volume == before.grains.extent[i].volume &&
           now.grains.extent[i].least_width == before.grains.extent[i].least_width));
  }
  for (std::size_t i = 0; i < before.grains.size(); ++i)
    CHECK((now.grains.force[i] - before.grains.force[i]).norm() < 1e-11 * most);
  for (std::size_t i = 0; i < now.grains.frame.size(); ++i) {
    const Frame &was = before.grains.frame[i], &is = now.grains.frame[i];
    CHECK((was.origin - is.origin).norm() < 1e-13 * before.boundary.cell.height());
    CHECK((was.axes - is.axes).norm() < 1e-13);
  }
  // Sums in the order of another list; frames by another order of operations than a step's.
  as_before.force = as_now.force, as_before.torque = as_now.torque, as_before.frame = as_now.frame;
  std::vector<std::string> columns;
  for_each_column(as_before, [&](const auto& column) { columns.push_back(bytes_of_column(column)); });
  std::size_t at = 0;
  for_each_column(as_now, [&](const auto& column) {
    INFO("column " << at);
    CHECK((bytes_of_column(column) == columns[at++]));
  });
  const auto then = touching(before), there = touching(now);
  REQUIRE(then.size() == there.size());
  for (std::size_t k = 0; k < then.size(); ++k) {
    const auto& [pair, contact, touch] = then[k];
    const auto& [same, kept, found] = there[k];
    REQUIRE(pair == same);
    CHECK(kept.stiffness == Approx(contact.stiffness).epsilon(1e-11));  // of hulls that of the area
    CHECK(kept.radius == contact.radius);
    CHECK((kept.spring[slide_spring] - contact.spring[slide_spring]).norm() < 1e-11 * most);
    CHECK((kept.spring[roll_spring] - contact.spring[roll_spring]).norm() < 1e-11 * most);
    CHECK((found.force - touch.force).norm() < 1e-11 * most);
    CHECK((found.normal - touch.normal).norm() < 1e-9);
  }
  CHECK(stored_energy(model, now) == Approx(stored_energy(model, before)).epsilon(1e-12));
  CHECK(now.ledger.friction == Approx(before.ledger.friction).margin(1e-12 * before.ledger.work));
  State on = before;
  for (State* state : {&on, &now}) run_steps(model, *state, 3, team);
  double furthest = 0, way = 0;
  for (std::size_t i = 0; i < on.grains.size(); ++i) {
    furthest = std::max(furthest, (on.grains.motion[i].position - now.grains.motion[i].position).norm());
    way = std::max(way, (on.grains.motion[i].position - before.grains.motion[i].position).norm());
  }
  CHECK(furthest < 1e-10 * way);
  CHECK((now.time == on.time && now.dt == on.dt && now.steps == on.steps));
}

std::size_t bytes_of_columns(const State& s) {
  std::size_t sum = sizeof s;
  auto add = [&](const auto& column) { sum += column.capacity() * sizeof column[0]; };
  for_each_column(s.grains, add);
  for_each_contact_column(s.contacts.contact, add);
  add(s.contacts.pair), add(s.contacts.resting_normal), add(s.contacts.touch), add(s.contacts.plan.load),
      add(s.reference.position);
  return sum;
}

}  // namespace

TEST_CASE("a cell that has rested is the one it was: motions and histories to the bit, forces to round-off") {
  Team team(1);
  const Model sand = elastic_sand();
  SECTION("spheres") { check_awake(sand, sheared(sand, false, team), team); }
  SECTION("bodies") { check_awake(sand, sheared(sand, true, team), team); }
  SECTION("bonded cells") {
    const Model stone = rock(elastic(0.4), 0.3);
    check_awake(stone, bonded(stone, team), team);
  }
}

TEST_CASE("a resting cell of spheres takes 0.4 kB a grain at most, saved or not, and cannot be forgotten to be one") {
  Team team(1);
  const Model model = elastic_sand(0);
  const State s = sheared(model, false, team);
  const auto grains = static_cast<double>(s.grains.size());
  const State resting = at_rest(s);
  const double contacts = static_cast<double>(resting.contacts.size()) / grains;
  CHECK(contacts > 2.5);  // of five neighbours: a dense cell
  CHECK(static_cast<double>(bytes_of_columns(resting)) < 400 * grains);
  CHECK(static_cast<double>(bytes_of(resting).size()) < 400 * grains);
  CHECK(bytes_of_columns(s) > 2 * bytes_of_columns(resting));  // not all of its columns are counted
  CHECK((resting.reference.position.empty() && resting.reference.builds == s.reference.builds));
  State again = at_rest(resting);
  CHECK((bytes_of(again) == bytes_of(resting)));
  State loaded = state_of(bytes_of(resting));
  REQUIRE(loaded.resting);
  awaken(model, loaded, team), awaken(model, again, team);
  CHECK((bytes_of(loaded) == bytes_of(again)));
  State whole = s;
  awaken(model, whole, team);  // of one that does not rest: nothing
  CHECK((bytes_of(whole) == bytes_of(s)));
}

#ifdef __GLIBC__
TEST_CASE("many cells that are carried on take 0.8 kB of the machine's memory a grain: trials leave no holes") {
  Team team(1);
  const Model model = elastic_sand(0);
  const auto shared = std::make_shared<const Model>(model);
  State start = sheared(model, false, team);
  set_cell_rate(start, Mat3::Zero());
  ResponseOptions options;  // one window of steps is equilibrium enough
  options.quasi_static.window = 2, options.quasi_static.unbalanced_force = options.quasi_static.stress_change = 1e9;
  options.quasi_static.strain_per_step = 1e-5, options.quasi_static.inertial_number = 0.1;
  const auto resident = [] {
    std::size_t all = 0, in_memory = 0;
    std::ifstream("/proc/self/statm") >> all >> in_memory;
    return static_cast<double>(in_memory) * static_cast<double>(sysconf(_SC_PAGESIZE));
  };
  constexpr std::size_t cells = 200;
  const double before = resident();
  RveHost host(shared, options, 1);
  std::vector<Task> tasks;
  std::vector<std::uint64_t> slots;
  for (std::size_t k = 0; k < cells; ++k) {
    host.put(k, {.state = start}), slots.push_back(k);
    tasks.push_back({k, {Mat3(Vec3(1, 1, 1 - 1e-6 * static_cast<double>(k)).asDiagonal())}, 0, Pace::relaxed, false});
  }
  for (int increment = 0; increment < 3; ++increment) {
    if (increment == 2)
      std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // holes are looked for once a second
    for (const Outcome& o : host.advance(tasks)) REQUIRE(o.response.stable);
    host.commit(slots);
  }
  CHECK(resident() - before < 800.0 * static_cast<double>(cells * start.grains.size()));
}
#endif

TEST_CASE(
    "dashpots and sliding: a cell that rests every ten steps goes where one goes that does not, and loses nothing") {
  Team team(1);
  const Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.5));
  State on = sheared(model, true, team), off = on;
  for (int k = 0; k < 10; ++k) {
    off = at_rest(off);
    awaken(model, off, team);
    for (State* s : {&on, &off}) update_time_step(model, *s), run_steps(model, *s, 10, team);
  }
  const Mat3 stress = love_weber(on, on.boundary.cell.volume());
  // What is lost is the dashpots' share of one step's force in ten, in the first and the last half kick of a run.
  CHECK((love_weber(off, off.boundary.cell.volume()) - stress).norm() < 1e-3 * stress.norm());
  CHECK(off.ledger.friction == Approx(on.ledger.friction).epsilon(1e-3));
  CHECK(energy_error(off.ledger, stored_energy(model, off)) ==
        Approx(energy_error(on.ledger, stored_energy(model, on))).margin(1e-4));
}
