// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres that attract, against the closed forms of Johnson, Kendall & Roberts, Proc. R. Soc. Lond. A 324 (1971) 301.
#include "dem/contact/jkr.hpp"

#include "dem/contact/forces.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/resting.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-4, E = 1e6, nu = 0.3, density = 1500;

Model sticky(double work, double friction = 0, double restitution = 1, double youngs = E) {
  Material m = solid(youngs, nu, density, friction, restitution), rigid;
  m.contact = Jkr::Of{work};
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  Model model;
  model.law = Jkr{};
  model.materials = {m, rigid};
  make_pair_laws(model);
  return model;
}

/// The contact as the paper tells it, by the radius of its circle.
struct Circle {
  double youngs, work, radius;  // E*, W, R_e

  double least() const { return std::cbrt(pi * work * radius * radius / (8 * youngs)); }
  double sunk(double a) const { return std::sqrt(2 * pi * work * a / youngs); }  // by what attraction adds
  double overlap(double a) const { return a * a / radius - sunk(a); }
  double force(double a) const {
    return 4 * youngs * a * a * a / (3 * radius) - std::sqrt(8 * pi * work * youngs * a * a * a);
  }
  /// Pressed by Hertz to the circle, drawn back as a flat punch; less the surfaces that it closes.
  double energy(double a) const {
    const double hertz = 4 * youngs * a * a * a / (3 * radius), back = sunk(a);
    return 0.4 * hertz * a * a / radius - hertz * back + youngs * a * back * back - pi * work * a * a;
  }
  double pull_off() const { return 1.5 * pi * work * radius; }
  double lost() const { return 7.0921 * std::cbrt(std::pow(work, 5) * std::pow(radius, 4) / (youngs * youngs)); }
};

Circle circle_of(const Model& model, bool wall, double radius = R) {
  const Jkr::Pair p = own<Jkr>(model.pairs[wall ? 1 : 0]);
  return {p.youngs, p.work, wall ? radius : radius / 2};
}

Contact contact_of(const Circle& circle) {
  Contact c;
  Jkr::begin({circle.youngs, circle.work}, circle.radius, 1, c);
  return c;
}

/// Overlap at no force, by the paper: a^3 = 9 pi W R^2 / (2 E*), a^2 / (3 R).
double at_rest_overlap(const Circle& circle) {
  const double a = std::cbrt(4.5 * pi * circle.work * circle.radius * circle.radius / circle.youngs);
  return a * a / (3 * circle.radius);
}

/// Two spheres that fly at each other with `speed` between them.
State flying(double speed) {
  State s;
  for (const double side : {-1.0, 1.0})
    add(s, PolyEllipsoid::sphere(R), Vec3(side * R * 1.0001, 0, 0), density, Vec3(-0.5 * side * speed, 0, 0));
  return s;
}

/// Time of an oscillation about rest: m* and the grip there.
double period_of(const Circle& circle, double mass) {
  return 2 * pi * std::sqrt(mass / Jkr{}(contact_of(circle), at_rest_overlap(circle)).grip);
}

/// A cohesive cell, packed loosely, that closes on itself and shears.
State cell_of(const Model& model, Team& team) {
  State s;
  const Packing p = random_packing(Vec3::Constant(1.2e-3), {"uniform", R, 0, 0.7 * R, 1.2 * R}, 0.5, 0, true, 4);
  for (const auto& sphere : p.spheres) add(s, PolyEllipsoid::sphere(sphere.radius), sphere.position, density);
  s.boundary.cell.vectors = p.box.asDiagonal();
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate.diagonal() = Vec3(-40, -40, -60), rate(0, 2) = 100;
  set_cell_rate(s, rate * s.boundary.cell.vectors);
  return s;
}

}  // namespace

TEST_CASE("JKR: force, slope and energy by overlap are those of the circle of contact, from separation on") {
  for (const Circle& circle : {Circle{5e5, 0.1, 5e-5}, Circle{3e10, 0.02, 1e-3}, Circle{1e7, 1e-6, 1e-5}}) {
    const Contact c = contact_of(circle);
    const Jkr law;
    const double ac = circle.least();
    CHECK(c.reach == Approx(3 * ac * ac / circle.radius).epsilon(1e-12));
    CHECK(law(c, 0).pull_off == Approx(circle.pull_off()).epsilon(1e-12));
    double least = 0;
    for (double a = ac; a < 30 * ac; a *= 1.01) {
      const double overlap = circle.overlap(a), scale = circle.pull_off() + std::abs(circle.force(a));
      const Elastic e = law(c, overlap);
      // Where the circle is smallest it goes with the root of the overlap: half of the digits are left.
      const double digits = a < 1.005 * ac ? 1e-7 : 1e-12;
      CHECK(std::abs(e.force - circle.force(a)) < digits * scale);
      CHECK(std::abs(e.energy - circle.energy(a)) < 1e-11 * scale * (std::abs(overlap) + c.reach));
      CHECK(e.grip == Approx(2 * circle.youngs * a).epsilon(100 * digits));
      least = std::min(least, e.force);
      if (a < 1.05 * ac) continue;
      const double h = 1e-5 * (overlap + c.reach);
      CHECK((law(c, overlap + h).force - law(c, overlap - h).force) / (2 * h) ==
            Approx(e.normal_stiffness).epsilon(1e-5).margin(1e-5 * e.grip));
      CHECK((law(c, overlap + h).energy - law(c, overlap - h).energy) / (2 * h) ==
            Approx(e.force).epsilon(1e-6).margin(1e-6 * scale));
      CHECK(e.normal_stiffness < e.grip);
    }
    CHECK(-least == Approx(circle.pull_off()).epsilon(1e-4));  // of a grid of 1 % in a
    CHECK(law(c, -c.reach * (1 - 1e-12)).force == Approx(-5.0 / 9 * circle.pull_off()).epsilon(1e-5));
    CHECK(law(c, 0).force == Approx(-8.0 / 9 * circle.pull_off()).epsilon(1e-12));
    CHECK(std::abs(law(c, at_rest_overlap(circle)).force) < 1e-12 * circle.pull_off());
    // What a closed way takes: Thornton & Ning, Powder Technology 99 (1998) 154.
    CHECK(Jkr::snap_on(c) + Jkr::snap_off(c) == Approx(circle.lost()).epsilon(1e-4));
    CHECK(Jkr::snap_off(c) == Approx(law(c, -c.reach).energy).epsilon(1e-6));
    CHECK(Jkr::snap_on(c) == Approx(-law(c, 0).energy).epsilon(1e-12));
  }
  // Hardly any attraction, and none: Hertz.
  for (const double work : {1e-25, 0.0}) {
    const Contact c = contact_of({1e7, work, 1e-4});
    for (const double overlap : {1e-9, 1e-6}) {
      const Elastic e = Jkr{}(c, overlap), hertz = HertzMindlin{}(c, overlap);
      CHECK(e.force == Approx(hertz.force).epsilon(1e-9));
      CHECK(e.energy == Approx(hertz.energy).epsilon(1e-9));
      CHECK(e.normal_stiffness == Approx(hertz.normal_stiffness).epsilon(1e-9));
      CHECK(e.pull_off < 1e-9 * e.force);
    }
  }
}

TEST_CASE("JKR: two materials meet with the mean work of adhesion; a rigid wall takes the grain's") {
  Model model = sticky(0.4);
  Material other = model.materials[0];
  other.contact = Jkr::Of{0.1};
  model.materials.push_back(other);
  make_pair_laws(model);
  CHECK(own<Jkr>(model.pairs[2]).work == Approx(0.2));
  CHECK(own<Jkr>(model.pairs[3 * 1 + 2]).work == 0.1);
  CHECK(own<Jkr>(model.pairs[0]).youngs == Approx(0.5 * E / (1 - nu * nu)));
  CHECK(own<Jkr>(model.pairs[1]).youngs == Approx(E / (1 - nu * nu)));
  // Grains ten times as large with ten times the work of adhesion: the same overlaps by radius.
  LawConstants of = Jkr::Of{0.4};
  scale(model.law, of, 10);
  const Circle circle = circle_of(model, false);
  const Circle larger{circle.youngs, std::get<Jkr::Of>(of).work, 10 * circle.radius};
  CHECK(at_rest_overlap(larger) == Approx(10 * at_rest_overlap(circle)));
  CHECK(Jkr::work_at(model.materials[0].solid(), R, at_rest_overlap(circle) / R) == Approx(0.4));
}

TEST_CASE("JKR: an impact loses what the two snaps take, or sticks; the ledger says so") {
  const double work = 0.01;
  const Model made = sticky(work);
  const Circle circle = circle_of(made, false);
  const double mass = 0.5 * density * 4 / 3 * pi * R * R * R;
  Team team(1);
  for (const double part : {0.9, 1.5, 5.0})
    for (const double youngs : {E, 20 * E}) {
      Model model = sticky(work, 0, 1, youngs);
      const Circle here = circle_of(model, false);
      const double speed = part * std::sqrt(2 * here.lost() / mass), dt = period_of(here, mass) / 2000;
      model.numerics.time_step = dt;
      State s = flying(speed);
      prepare(model, s, team);
      const double start = kinetic_energy(s.grains);
      run_steps(model, s, 12000, team);  // six periods
      INFO("part " << part << " modulus " << youngs);
      // The step in which a pair snaps has half of a step's way too much or too little of the force at most.
      const double error = 1.5 * circle.pull_off() * speed * dt / start;
      CHECK(error < 0.02);
      CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < error);
      CHECK(s.ledger.unexplained == 0);
      const double relative = (s.grains.motion[1].velocity - s.grains.motion[0].velocity).x();
      if (part < 1) {
        CHECK(s.contacts.contact.touching(0));
        CHECK(s.ledger.adhesion == Approx(Jkr::snap_on(contact_of(here))).epsilon(1e-12));
      } else {
        CHECK_FALSE(s.contacts.contact.touching(0));
        CHECK(s.ledger.adhesion == Approx(here.lost()).epsilon(1e-4));
        CHECK(relative * relative / (speed * speed) == Approx(1 - 1 / (part * part)).margin(2 * error));
      }
    }
}

TEST_CASE("JKR: a sphere hangs from a ceiling up to its pull-off force, through lists, rest and a checkpoint") {
  Team team(1);
  Model model = sticky(0.5);
  model.numerics.skin = 1e-3;  // far less than the separation at which it parts
  set_damping(model, 0.5);
  const Circle circle = circle_of(model, true);
  const double mass = density * 4 / 3 * pi * R * R * R, reach = contact_of(circle).reach;
  REQUIRE(reach > 0.03 * R);
  for (const double part : {0.97, 1.03}) {
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, -R + at_rest_overlap(circle)), density);
    Wall ceiling;
    ceiling.point = Vec3::Zero(), ceiling.shape = PlaneWall{Vec3(0, 0, -1)}, ceiling.material = 1;
    s.boundary.walls.push_back(ceiling);
    prepare(model, s, team);
    for (int load = 1; load <= 40; ++load) {  // slowly, so that it does not fall by its swing
      model.motion.gravity = Vec3(0, 0, -part * circle.pull_off() / mass * std::min(1.0, load / 30.0));
      update_time_step(model, s);
      run_steps(model, s, 400, team);
      s.reference.stale = load % 2 == 0;  // a new list, of a pair that does not overlap
      if (load % 5 == 0) s = state_of(bytes_of(s));
      if (load % 7 == 0 && load < 30) s = at_rest(s), awaken(model, s, team);
    }
    INFO("part " << part);
    const double gap = -s.grains.motion[0].position.z() - R;
    if (part < 1) {
      REQUIRE(s.contacts.size() == 1);
      CHECK(s.contacts.contact.touching(0));
      CHECK(gap > 0);
      CHECK(s.contacts.touch[0].force.norm() == Approx(part * circle.pull_off()).epsilon(1e-3));
    } else {
      CHECK(gap > 2 * reach);
      CHECK(s.ledger.adhesion == Approx(Jkr::snap_off(contact_of(circle))).epsilon(1e-9));
    }
  }
}

TEST_CASE("JKR: spheres that are drawn apart pull by the pull-off force at most and part at their reach") {
  Team team(1);
  Model model = sticky(0.5);
  model.numerics.skin = 1e-3, model.numerics.time_step = 1e-7;
  const Circle circle = circle_of(model, false);
  const double reach = contact_of(circle).reach, rest = at_rest_overlap(circle), speed = 1e-3;
  State s;  // so heavy that nothing turns them back
  for (const double side : {-1.0, 1.0})
    add(s, PolyEllipsoid::sphere(R), Vec3(side * (R - 0.5 * rest), 0, 0), 1e12, Vec3(0.5 * side * speed, 0, 0));
  prepare(model, s, team);
  const double step = 10 * speed * s.dt;
  REQUIRE(step < 1e-3 * reach);
  double strongest = 0, last = 0, gap = -rest;
  for (; gap < 1.5 * reach; gap = (s.grains.motion[1].position - s.grains.motion[0].position).x() - 2 * R) {
    run_steps(model, s, 10, team);
    s.reference.stale = true;
    if (s.contacts.size() == 0 || !s.contacts.contact.touching(0)) continue;
    last = -s.contacts.touch[0].overlap;
    strongest = std::max(strongest, -s.contacts.touch[0].force.dot(s.contacts.touch[0].normal));
  }
  CHECK(strongest == Approx(circle.pull_off()).epsilon(1e-4));
  CHECK((last <= reach && last > reach - 2 * step));
}

TEST_CASE("JKR: friction goes on under tension, up to mu (N + 2 pull-off), rolling too; dashpots pull no harder") {
  const Circle circle{1e7, 0.1, 1e-4};
  PairLaw pair;
  pair.own = Jkr::Pair{circle.youngs, circle.work};
  pair.shear_ratio = 0.8, pair.friction = {0.3, 0.1};
  const Vec3 n(0, 0, 1);
  const double ac = circle.least();
  for (const double a : {1.1 * ac, 2.08 * ac, 2.6 * ac, 4 * ac}) {
    Contact c = contact_of(circle);
    Touch touch;
    BlockEnergy e;
    const double dt = 1e-7;
    const Vec3 slip(0.01, 0, 0), turn(0, 200, 0);
    Vec3 force;
    for (int k = 0; k < 4000; ++k)
      force = advance_contact(Jkr{}, pair, 1e-6, c, touch, n, circle.overlap(a), slip, 0, dt, e, turn);
    const double limit = 0.3 * (circle.force(a) + 2 * circle.pull_off());
    CHECK(c.spring[slide_spring].norm() == Approx(limit).epsilon(1e-9));
    CHECK(c.spring[roll_spring].norm() == Approx(limit / 3).epsilon(1e-9));
    CHECK(force.dot(n) == Approx(circle.force(a)).epsilon(1e-9));
    CHECK(c.compliance == Approx(1 / (0.8 * 2 * circle.youngs * a)).epsilon(1e-9));
    CHECK(e.friction == Approx(e.springs).epsilon(0.01));
    pair.dashpot = 1;
    CHECK(advance_contact(Jkr{}, pair, 1e-6, c, touch, n, circle.overlap(a), Vec3(0, 0, 1e3), 0, dt, e).dot(n) ==
          Approx(-circle.pull_off()).epsilon(1e-9));
    pair.dashpot = 0;
  }
}

TEST_CASE("JKR: a cohesive cell is the same for any number of threads, and its energy is told") {
  const auto run = [](int threads, bool stored) {
    Team team(threads);
    Model model = sticky(0.2, 0.4, 0.6);
    model.materials[0].rolling_friction = 0.1;
    make_pair_laws(model);
    State s = cell_of(model, team);
    for (int k = 0; k < 40; ++k) {
      if (k == 12) set_cell_rate(s, -s.boundary.cell.rate);  // drawn
      update_time_step(model, s), run_steps(model, s, 50, team);
      if (stored && k == 20) s = state_of(bytes_of(s));
    }
    return s;
  };
  const State s = run(1, false);
  const Model model = sticky(0.2, 0.4, 0.6);
  const double stored = stored_energy(model, s);
  CHECK(hash(s) == hash(run(3, false)));
  CHECK(hash(s) == hash(run(1, true)));
  std::size_t drawn = 0, apart = 0, touching = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) {
      ++touching;
      drawn += s.contacts.touch[k].force.dot(s.contacts.touch[k].normal) < 0;
      apart += s.contacts.touch[k].overlap < 0;
    }
  INFO("grains " << s.grains.size() << ", touching " << touching << ", drawn " << drawn << ", apart " << apart
                 << ", adhesion " << s.ledger.adhesion << " of " << s.ledger.spent() << ", error "
                 << energy_error(s.ledger, stored) << ", strain " << s.boundary.cell.vectors(2, 2) / 1.2e-3);
  CHECK((touching > s.grains.size() && drawn > touching / 10 && apart > 3));
  CHECK(s.ledger.adhesion > 0.01 * s.ledger.spent());
  CHECK(s.ledger.friction > 0);
  CHECK(std::abs(energy_error(s.ledger, stored)) < 0.01);
  CHECK(std::abs(s.ledger.unexplained) < 0.01 * energy_scale(s.ledger, stored));
  CHECK_FALSE(linear_response(model, s, 1));
}

TEST_CASE("JKR: the critical step is below that of the stiffest swing, and knows how hard an impact may be") {
  Team team(1);
  Model model = sticky(0.05);
  const Circle circle = circle_of(model, false);
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), density);
  add(s, PolyEllipsoid::sphere(R), Vec3(2 * R - at_rest_overlap(circle), 0, 0), density);
  prepare(model, s, team);
  update_time_step(model, s);
  const double slope = Jkr{}(contact_of(circle), at_rest_overlap(circle)).normal_stiffness;
  const double exact = 2 / std::sqrt(2 * slope / s.grains.mass[0]), dt = s.dt / model.numerics.safety;
  CHECK(dt < exact);
  CHECK(dt > 0.5 * exact);
  // The stiffness at the deepest point of an impact is no more than what was foretold, and no less than half of it.
  for (const double speed : {0.01, 0.3, 5.0}) {
    const double mass = 0.5 * s.grains.mass[0], energy = 0.5 * mass * speed * speed;
    const Contact c = contact_of(circle);
    double low = 0, high = R;
    for (int k = 0; k < 200; ++k) {
      const double middle = 0.5 * (low + high);
      (Jkr{}(c, middle).energy < energy ? low : high) = middle;
    }
    const double told = hardest_impact(model.law, model.pairs[0], {mass, R, speed, false});
    CHECK(told > Jkr{}(c, high).grip);
    CHECK(told < 2 * Jkr{}(c, high).grip);
  }
}

TEST_CASE("JKR: the tangent of a cell, at rest and drawn, is that of small strains") {
  for (const double drawn : {0.0, 0.6}) {  // of the way from no force to the largest tension
    const Model model = sticky(1e-5, 10);
    Team team(1);
    const Circle circle = circle_of(model, false);
    const double none = at_rest_overlap(circle), most = circle.overlap(std::cbrt(9.0) * circle.least());
    State s;
    const auto spread = [&](const Vec3& d) {
      for (std::size_t i = 0; i < 27; ++i)
        s.grains.motion[i].position = d.cwiseProduct(
            Vec3(static_cast<double>(i / 9), static_cast<double>(i / 3 % 3), static_cast<double>(i % 3)));
      s.boundary.cell.vectors = (3 * d).asDiagonal();
    };
    for (int i = 0; i < 27; ++i) add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), density);
    spread(Vec3::Constant(2 * R - none));
    prepare(model, s, team);  // all touch; then the cell is stretched
    const double d = 2 * R - (none + drawn * (most - none)), h = 1e-4 * (none - most);
    const auto stress_at = [&](double more) {
      spread(Vec3(d, d, d + more));
      contact_forces(model.law, model.pairs, s.grains, s.boundary, 0, true, s.contacts, team);
      drop_loads(s.contacts), flush(s.contacts);
      return love_weber(s, s.boundary.cell.volume());
    };
    const double measured = (stress_at(h) - stress_at(-h))(2, 2) / (2 * h / d);
    stress_at(0);
    const Elastic e = elastic_response(model.law, s.contacts, 0);
    const Mat6 network = network_tangent(model, s), affine = contact_stiffness_tangent(model, s);
    INFO("drawn " << drawn << " slope " << e.normal_stiffness << " grip " << e.grip);
    CHECK((drawn > 0) == (e.force < -0.5 * circle.pull_off()));
    for (int k = 0; k < 3; ++k) {
      // What the largest tension adds, F / d against the slope over d, is 1e-4.
      CHECK(network(k, k) == Approx(measured).epsilon(1e-3));
      CHECK(affine(k, k) == Approx(measured).epsilon(1e-3));
      CHECK(network(k + 3, k + 3) == Approx(0.5 * model.pairs[0].shear_ratio * e.grip / d).epsilon(1e-3));
    }
  }
}
