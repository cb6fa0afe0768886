// SPDX-License-Identifier: LGPL-3.0-or-later
// The techniques of Zhang et al. (2015), 3.3-3.4, each by its own physics.
#include "dem/contact/forces.hpp"
#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/shape_transition.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/reshape.hpp"
#include "dem/rve/split_statistics.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 3e-4;

Model breakable(const FractureModel& fracture, double friction = 0, double restitution = 1) {
  Material m = solid(60e9, 0.17, 2650, friction, restitution);
  m.fracture = fracture;
  return model_of(m);
}

FractureModel hoek_brown() {
  FractureModel f;
  f.criteria.emplace_back(HoekBrown{592e6, 20.56});
  return f;
}

/// Walls that press a body along an axis by `depth` on either side.
void squeeze(State& s, std::size_t i, int axis, double depth) {
  update_frames(s.grains);
  for (int side : {-1, 1}) {
    Wall wall;
    wall.material = 1;
    wall.shape = PlaneWall{-side * Vec3::Unit(axis)};
    wall.point = s.grains.motion[i].position;
    wall.point[axis] +=
        side * (std::abs((is_sphere(s.grains, i) ? Vec3(R * side * Vec3::Unit(axis))
                                                 : surface_arm(s.grains, i, side * Vec3::Unit(axis)))[axis]) -
                depth);
    s.boundary.walls.push_back(wall);
  }
}

PolyEllipsoid bad_child() { return halves(PolyEllipsoid::sphere(R), 0, 0.1)[0].shape; }

}  // namespace

TEST_CASE(
    "shape transition keeps mass, momentum, angular momentum and the centre of mass, and reaches a breakable shape") {
  FractureModel f = hoek_brown();
  f.transition = ShapeTransition{0.25, 1e-5};
  const Model model = breakable(f);
  Team team(1);
  State s;
  add(s, bad_child(), Vec3(1e-3, 2e-3, 3e-3), 2650, Vec3(1, -2, 3), Vec3(500, 900, -300), random_rotation(1, 1));
  prepare(model, s, team);
  s.grains.generation[0] = 1;
  const double mass = s.grains.mass[0], v = volume(s.grains.shape[0]), energy = kinetic_energy(s.grains);
  const Vec3 l = s.grains.angular_momentum[0], x = s.grains.motion[0].position, u = s.grains.motion[0].velocity;
  REQUIRE(choose_axis(s.grains.shape[0], Vec3(1, 0, 0)) != 0);  // bad along the split axis
  Reshaping reshaping;
  for (int k = 0; k < 100; ++k) reshape_fragments(model, s, 2e-7, reshaping, team);
  const PolyEllipsoid& now = s.grains.shape[0];
  CHECK(now.minus.x() / now.plus.x() == Approx(0.25).epsilon(1e-9));
  CHECK(choose_axis(now, Vec3(1, 0, 0)) == 0);
  CHECK(volume(now) == Approx(v).epsilon(1e-14));
  CHECK(s.grains.mass[0] == mass);
  CHECK(s.grains.angular_momentum[0] == l);
  CHECK(s.grains.motion[0].position == x);
  CHECK(s.grains.motion[0].velocity == u);
  CHECK(kinetic_energy(s.grains) == Approx(energy + s.ledger.reshape).epsilon(1e-12));
  CHECK(s.ledger.reshape != 0);
  const Vec3 before = s.grains.motion[0].spin;
  CHECK((spin_of(s.grains, 0) - before).norm() < 1e-12 * before.norm());
}

TEST_CASE("the work of a growing surface against its neighbours is booked, and no force jumps") {
  FractureModel f;
  f.criteria.emplace_back(ContactTension{1e15, 3});  // nothing breaks here
  f.transition = ShapeTransition{0.25, 2e-5};
  const Model model = breakable(f);
  Team team(1);
  State s;
  add(s, bad_child(), Vec3::Zero(), 2650);
  squeeze(s, 0, 0, 0.01 * R);
  prepare(model, s, team);
  s.grains.generation[0] = 1;
  // One step at rest: the overlap changes by a quarter of the origin's path, the force by 1.5 times that over the
  // overlap.
  State still = s;
  Reshaping reshaping;
  const double step = 5e-8, path = 0.25 / 1.25 * R * step / 2e-5;
  reshape_fragments(model, still, step, reshaping, team);
  contact_forces(model.law, model.pairs, still.grains, still.boundary, 0, true, still.contacts, team);
  for (std::size_t k = 0; k < 2; ++k) {
    const double before = s.contacts.touch[k].force.norm(),
                 jump = std::abs(still.contacts.touch[k].force.norm() - before);
    CHECK(jump == Approx(1.5 * 0.25 * path / (0.01 * R) * before).epsilon(0.02));
    CHECK(jump < 0.02 * before);
  }
  const double start = stored_energy(model, s);
  double work = 0;
  while (s.time < 3e-5) {
    update_time_step(model, s);
    run_steps(model, s, 5, team);
    work = std::max(work, std::abs(s.ledger.reshape));
  }
  CHECK(s.grains.shape[0].minus.x() / s.grains.shape[0].plus.x() == Approx(0.25).epsilon(1e-9));
  CHECK(work > 0.01 * start);
  // Leapfrog holds an oscillation's energy to (omega dt)^2 / 8, and omega dt <= 2 x safety = 0.6: 4.5 %, of the moving
  // part.
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 5e-3);
}

TEST_CASE("a sphere's axes turn to the plane that the load asks for, and nothing else changes") {
  FractureModel f = hoek_brown();
  halves_in(f).turn_spheres = true;
  const Model model = breakable(f);
  Team team(1);
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650, Vec3::Zero(), Vec3::Zero(), random_rotation(3, 3));
  squeeze(s, 0, 2, 0.1 * R);
  prepare(model, s, team);
  const auto breaks = find_breaks(model, s, team);
  REQUIRE(breaks.size() == 1);
  const Pieces halves = pieces_of(model, s, breaks[0]);
  const Vec3 normal = halves.orientation * halves.plane[0].normal;
  CHECK(std::abs(normal.z()) < 1e-9);  // the tensile directions of two poles lie in the equator
  State turned = s;
  apply_breaks(model, turned, breaks, team);
  CHECK(momentum(turned.grains).norm() < 1e-20);
  CHECK(turned.contacts.begin[bin_count] >=
        4);  // both platens still touch both halves: the plane runs through the poles
}

TEST_CASE("the plane of critical contacts and that of the average stress differ where the load says so") {
  // Four equal contacts in the x-y plane and a weak pair along z: the stress is least compressive along z, and so is
  // the normal of the contacts' plane; with Hoek-Brown deciding, each rule must find z by its own way.
  for (const auto rule : {BreakPlane::average_stress, BreakPlane::critical_contacts}) {
    FractureModel f = hoek_brown();
    f.plane = rule;
    const Model model = breakable(f);
    Team team(1);
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
    squeeze(s, 0, 0, 0.1 * R);
    squeeze(s, 0, 1, 0.099 * R);
    prepare(model, s, team);
    const auto breaks = find_breaks(model, s, team);
    REQUIRE(breaks.size() == 1);
    CHECK(pieces_of(model, s, breaks[0]).plane[0].normal == Vec3(Vec3::UnitZ()));
  }
  // Two contacts only: no plane, so the stress decides.
  FractureModel f = hoek_brown();
  f.plane = BreakPlane::critical_contacts;
  const Model model = breakable(f);
  Team team(1);
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
  squeeze(s, 0, 1, 0.1 * R);
  prepare(model, s, team);
  const auto breaks = find_breaks(model, s, team);
  REQUIRE(breaks.size() == 1);
  CHECK(pieces_of(model, s, breaks[0]).plane[0].normal != Vec3(Vec3::UnitY()));
}

TEST_CASE("the slight rotation draws its angles from both outer halves, and its matrix is that of eqs 21-23") {
  const double theta = std::atan(0.2);
  int negative = 0;
  double sum = 0;
  for (std::uint64_t id = 0; id < 4000; ++id) {
    const Mat3 r = slight_rotation(theta, 7, id);
    REQUIRE((r.transpose() * r - Mat3::Identity()).norm() < 1e-14);
    const double b = -std::asin(r(0, 2));  // c' = (-sin beta, ...)
    REQUIRE(std::abs(b) <= theta * (1 + 1e-12));
    REQUIRE(std::abs(b) >= 0.5 * theta * (1 - 1e-12));
    const double alpha = std::atan2(r(1, 2), r(2, 2)), gamma = std::atan2(r(0, 1), r(0, 0));
    for (double a : {alpha, gamma})
      REQUIRE((std::abs(a) >= 0.5 * theta * (1 - 1e-9) && std::abs(a) <= theta * (1 + 1e-9)));
    const double read[3] = {alpha, b, gamma};
    for (std::uint64_t k = 0; k < 3; ++k) {  // the angles that were drawn, each with its sign
      const double u = 2 * random_uniform(7, id, Purpose::rotation, k) - 1;
      REQUIRE(std::abs(read[k] - std::copysign(0.5 * theta * (1 + std::abs(u)), u)) < 1e-12);
    }
    const Vec3 a1(std::cos(b) * std::cos(gamma),
                  std::cos(gamma) * std::sin(alpha) * std::sin(b) - std::cos(alpha) * std::sin(gamma),
                  std::sin(alpha) * std::sin(gamma) + std::cos(alpha) * std::cos(gamma) * std::sin(b));
    REQUIRE((r.col(0) - a1).norm() < 1e-12);
    negative += b < 0, sum += std::abs(b);
  }
  CHECK(negative == Approx(2000).margin(4 * std::sqrt(1000.0)));  // a fair coin, four standard deviations
  CHECK(sum / 4000 == Approx(0.75 * theta).margin(4 * theta / std::sqrt(48.0 * 4000)));  // uniform over half of theta
}

TEST_CASE("mass kept by density: nothing is lost, and what the shift of the centres leaves over is booked") {
  FractureModel f;
  halves_in(f).keep_mass = true;
  for (double rounding : {0.1, 0.02, 0.0}) {
    halves_in(f).rounding = rounding;
    State s;
    add(s, random_shape(31, 5, 0.3, 1), Vec3(1, 2, 3), 2650, Vec3(4, 5, 6), Vec3(7, 8, 9), random_rotation(32, 1));
    const double mass = total_mass(s.grains), energy = kinetic_energy(s.grains);
    const Vec3 p = momentum(s.grains), l = angular_momentum(s.grains);
    Fines fines;
    split_grain(s.grains, 0, 1, f, fines);
    CHECK(total_mass(s.grains) == Approx(mass).epsilon(1e-14));
    CHECK(std::abs(fines.mass) < 1e-14 * mass);
    CHECK(fines.classes.empty());
    CHECK((momentum(s.grains) + fines.momentum - p).norm() < 1e-13 * p.norm());
    CHECK((angular_momentum(s.grains) + fines.angular_momentum - l).norm() < 1e-13 * l.norm());
    CHECK(std::abs(kinetic_energy(s.grains) + fines.kinetic - energy) < 1e-13 * energy);
    CHECK(s.grains.mass[0] / volume(s.grains.shape[0]) ==
          Approx(2650 / (1 - std::max(rounding, least_rounding))).epsilon(1e-12));
  }
}

TEST_CASE("exact halves keep every contact and the force; with the paper's rounding those at the plane are lost") {
  for (double rounding : {0.0, 0.1}) {
    FractureModel f = hoek_brown();
    halves_in(f).rounding = rounding;
    Model model = breakable(f);
    model.split_statistics = true;
    Team team(1);
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
    for (int axis : {0, 1, 2}) squeeze(s, 0, axis, (axis == 2 ? 0.01 : 0.002) * R);
    prepare(model, s, team);
    apply_breaks(model, s, {across(s, 0, 0)}, team);
    const SplitStatistics& split = s.ledger.splits;
    CHECK(split.contacts == 6);
    if (rounding == 0) {
      CHECK(split.contacts_kept == 6);
      // The edge's rounding of 1e-3 gives way by 5e-4 R at the plane, where y and z touch; x is kept whole.
      const double gap = 1 - std::sqrt(1 - least_rounding), fx = std::pow(0.002, 1.5), fz = std::pow(0.01, 1.5);
      const double kept = fx + std::pow(0.002 - gap, 1.5) + std::pow(0.01 - gap, 1.5);
      CHECK(split.force_kept / split.force == Approx(kept / (2 * fx + fz)).epsilon(2e-3));
    } else {
      CHECK(split.contacts_kept == 2);  // those along the split axis; 0.0513 R opens at the equator
    }
  }
}

TEST_CASE("max_generations and the smallest radius end the breaking; with a shape transition there is no other end") {
  auto splits = [](FractureModel f) {
    const Model model = breakable(f);
    Team team(1);
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
    int rounds = 0;
    for (; rounds < 12;
         ++rounds) {  // every grain squeezed beyond any strength along its longest axis, one after the other
      const std::size_t i = 0;
      s.boundary.walls.clear();
      const Vec3 w = s.grains.shape[i].plus + s.grains.shape[i].minus;
      int shortest;
      w.minCoeff(&shortest);
      s.grains.orientation[i] = Quat::Identity();
      squeeze(s, i, shortest, 0.05 * w[shortest]);
      while (s.grains.size() > 1)
        for_each_column(s.grains, [](auto& c) {
          if (!c.empty()) c.pop_back();
        });
      s.bonds.clear();
      prepare(model, s, team);
      const auto breaks = find_breaks(model, s, team);
      if (breaks.empty()) break;
      apply_breaks(model, s, breaks, team);
      s.boundary.walls.clear(), s.bonds.clear();
      Reshaping reshaping;
      build_contacts(s.grains, s.boundary, s.skin, 2, {}, s.contacts, s.reference, team);
      reshape_fragments(model, s, 1e-3, reshaping, team);
    }
    return rounds;
  };
  FractureModel f = hoek_brown();
  std::get<HoekBrown>(f.criteria[0]).compressive_strength = 1e6;
  CHECK(splits(f) == 3);
  f.limit.max_generations = 2;
  CHECK(splits(f) == 2);
  f.limit.max_generations = 255;
  f.transition = ShapeTransition{};
  CHECK(splits(f) == 12);
  f.limit.smallest_radius = 0.45 * R;  // a ninth of the volume; a split leaves between a half and 1 / (1 + ratio) of it
  CHECK(splits(f) >= 4);
  CHECK(splits(f) <= 10);
}

TEST_CASE("what a split keeps of a contact's force counts no higher than what there was") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  State s;
  for (const double x : {0.0, 1.99}) add(s, PolyEllipsoid::sphere(1), Vec3(x, 0, 0), 2650);
  prepare(model, s, team);
  const std::vector<std::size_t> first{0};
  const ParentContacts now = contacts_of(model, s, first);
  REQUIRE(now.of.at(0).size() == 1);
  const double force = now.of[0][0].second;
  CHECK(force == Approx(s.contacts.touch[0].force.norm()).epsilon(1e-12));
  const std::vector<std::vector<std::size_t>> pieces{first};
  const std::vector<Index> origin{0, 1};
  for (const double before : {0.5, 2.0}) {
    State after = s;
    ParentContacts had = now;
    had.of[0][0].second = before * force;
    count_split(model, after, had, pieces, origin, 2);
    CHECK(after.ledger.splits.force == Approx(before * force).epsilon(1e-12));
    CHECK(after.ledger.splits.force_kept == Approx(std::min(before, 1.0) * force).epsilon(1e-12));
    CHECK(after.ledger.splits.contacts_kept == 1);
  }
}
