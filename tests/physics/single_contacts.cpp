// SPDX-License-Identifier: LGPL-3.0-or-later
// Impacts, sliding and rolling against closed forms (Chung & Ooi 2011, tests 1-4, and textbooks).
#include <map>

#include "dem/contact/forces.hpp"
#include "dem/rve/measure.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

struct Bounce {
  double depth = 0, force = 0, time = 0, restitution = 0;
};

/// Head-on, from first touch; the duration by the steps in contact, the peak by the largest overlap.
Bounce collide(const Model& model, State s, double speed) {
  Team team(1);
  prepare(model, s, team);
  Bounce r;
  const double before = s.grains.motion[0].velocity.norm();
  for (int k = 0; k < 100000; ++k) {
    run_steps(model, s, 1, team);
    if (s.contacts.size() > 0 && s.contacts.contact.touching(0)) {
      r.time += s.dt;
      r.depth = std::max(r.depth, s.contacts.touch[0].overlap);
      r.force = std::max(r.force, s.contacts.touch[0].force.norm());
    } else if (r.time > 0) {
      break;
    }
  }
  r.restitution = s.grains.motion[0].velocity.norm() / before;
  (void)speed;
  return r;
}

State two_spheres(double R, double density, double speed) {
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3(-R * (1 + 1e-12), 0, 0), density, Vec3(speed, 0, 0));
  add(s, PolyEllipsoid::sphere(R), Vec3(R * (1 + 1e-12), 0, 0), density, Vec3(-speed, 0, 0));
  return s;
}

State sphere_on_wall(double R, double density, const Vec3& v, const PolyEllipsoid* shape = nullptr) {
  State s;
  const PolyEllipsoid body = shape ? *shape : PolyEllipsoid::sphere(R);
  add(s, body, Vec3(0, 0, R * (1 + 1e-12)), density, v);
  add_floor(s);
  return s;
}

}  // namespace

TEST_CASE("Chung & Ooi 1: elastic normal impact of two spheres") {
  struct Row {
    double E, nu, density, depth, force, time;
  };
  for (const auto& r : {Row{48e9, 0.2, 2800, 274.113e-6, 10.6969e3, 40.3395e-6},
                        Row{20e9, 0.25, 2500, 368.304e-6, 7.10824e3, 54.2010e-6}}) {
    Model model = model_of(solid(r.E, r.nu, r.density));
    model.numerics.time_step = r.time / 500;
    const Bounce i = collide(model, two_spheres(0.01, r.density, 10), 10);
    CHECK(i.depth == Approx(r.depth).epsilon(3e-4));
    CHECK(i.force == Approx(r.force).epsilon(5e-4));
    CHECK(i.time == Approx(r.time).epsilon(4e-3));  // counted in steps of 1/500
    CHECK(i.restitution == Approx(1).epsilon(1e-5));
  }
}

TEST_CASE("Chung & Ooi 2: elastic normal impact on a rigid wall") {
  struct Row {
    double E, nu, density, depth, force, time;
  };
  for (const auto& r : {Row{70e9, 0.3, 2699, 49.7172e-6, 11.3699e3, 731.657e-6},
                        Row{40e9, 0.35, 1800, 52.1233e-6, 7.23268e3, 767.066e-6}}) {
    Model model = model_of(solid(r.E, r.nu, r.density));
    model.numerics.time_step = r.time / 500;
    const Bounce i = collide(model, sphere_on_wall(0.1, r.density, Vec3(0, 0, -0.2)), 0.2);
    CHECK(i.depth == Approx(r.depth).epsilon(3e-4));
    CHECK(i.force == Approx(r.force).epsilon(5e-4));
    CHECK(i.time == Approx(r.time).epsilon(4e-3));
  }
}

TEST_CASE("Chung & Ooi 3: the measured restitution is the given one") {
  for (const auto& [E, nu, density, time] :
       std::vector<std::array<double, 4>>{{380e9, 0.23, 4000, 6.1045e-6}, {100e9, 0.25, 7000, 12.9721e-6}})
    for (double e : {0.2, 0.4, 0.6, 0.8, 1.0}) {
      Model model = model_of(solid(E, nu, density, 0, e));
      model.numerics.time_step = time / 1000;
      CHECK(collide(model, sphere_on_wall(0.0025, density, Vec3(0, 0, -3.9)), 3.9).restitution ==
            Approx(e).epsilon(1e-2));
    }
}

TEST_CASE("Chung & Ooi 4: oblique impact; gross slip in closed form, stick by this tangential form") {
  const double mu = 0.092, e = 0.98, R = 0.0025;
  // e_t at 5..25 degrees for Al oxide with k_t incremental, rescaled on unloading: integrated independently.
  const std::map<int, double> own{{5, 0.8613}, {10, 0.7106}, {15, 0.6314}, {20, 0.6201}, {25, 0.6381}};
  for (int degrees : {5, 10, 15, 20, 25, 30, 40, 50, 60, 70, 80, 85}) {
    Model model = model_of(solid(380e9, 0.23, 4000, mu, e));
    model.numerics.time_step = 6.1e-6 / 1500;
    const double angle = degrees * pi / 180, vn = 3.9 * std::cos(angle), vt = 3.9 * std::sin(angle);
    State s = sphere_on_wall(R, 4000, Vec3(vt, 0, -vn));
    Team team(1);
    prepare(model, s, team);
    run_steps(model, s, static_cast<std::uint64_t>(1500 * 3 / std::pow(std::cos(angle), 0.2)), team);
    REQUIRE(s.grains.motion[0].velocity.z() > 0);
    const double et = s.grains.motion[0].velocity.x() / vt, spin = s.grains.motion[0].spin.y();
    if (degrees >= 30) {
      CHECK(et == Approx(1 - mu * (1 + e) * vn / vt).epsilon(3e-3));
      CHECK(spin == Approx(5 * mu * (1 + e) * vn / (2 * R)).epsilon(3e-3));
    } else {
      CHECK(et == Approx(own.at(degrees)).margin(0.01));
    }
    // Angular momentum about the contact; the force acts half an overlap (8.1 um at most) above the wall.
    CHECK(et - 1 == Approx(-0.4 * R * spin / vt).epsilon(0.5 * 8.1e-6 / R));
  }
}

TEST_CASE("an elastic bounce keeps its energy") {
  Model model = model_of(solid(60e9, 0.17, 2650));
  State s = sphere_on_wall(3e-4, 2650, Vec3(0, 0, -1));
  Team team(1);
  model.numerics.safety = 0.01;
  prepare(model, s, team);
  run_for(model, s, 3e-5, team);
  CHECK(s.grains.motion[0].velocity.z() == Approx(1).epsilon(1e-4));
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-4);
}

TEST_CASE("pole impact of ellipsoids on a plane: the elliptic Hertz contact, exact within 0.5 %") {
  struct Row {
    Vec3 axes;
    double depth, force, time;
  };
  for (const auto& r :
       {Row{{1, 1, 1}, 1.9524e-6, 7.1068, 5.7464e-6}, Row{{2, 2, 1}, 2.5762e-6, 21.5439, 7.5825e-6},
        Row{{0.5, 0.5, 1}, 1.4796e-6, 2.3444, 4.3550e-6}, Row{{1.5, 1, 0.75}, 1.7720e-6, 8.8091, 5.2155e-6},
        Row{{2, 1, 1}, 2.2080e-6, 12.5684, 6.4987e-6}}) {
    PolyEllipsoid shape;
    shape.plus = shape.minus = 1e-3 * r.axes;
    Model model = model_of(solid(60e9, 0.17, 2650));
    model.numerics.time_step = r.time / 1000;
    const Bounce i = collide(model, sphere_on_wall(shape.plus.z(), 2650, Vec3(0, 0, -1), &shape), 1);
    CHECK(i.depth == Approx(r.depth).epsilon(5e-3));
    CHECK(i.force == Approx(r.force).epsilon(5e-3));
    CHECK(i.time == Approx(r.time).epsilon(7e-3));
  }
}

TEST_CASE("a tilted prolate body leaves a frictionless plane as rigid-body dynamics says") {
  PolyEllipsoid shape;
  shape.plus = shape.minus = Vec3(2e-3, 1e-3, 1e-3);
  Model model = model_of(solid(60e9, 0.17, 2650));
  model.numerics.time_step = 4e-9;
  State s;
  const Quat q(Eigen::AngleAxisd(30 * pi / 180, Vec3(0, 1, 0)));
  const double height = support_height(shape, q.conjugate() * Vec3(0, 0, -1));
  add(s, shape, Vec3(0, 0, height * (1 + 1e-9)), 2650, Vec3(0, 0, -1), Vec3::Zero(), q);
  add_floor(s);
  Team team(1);
  prepare(model, s, team);
  const double energy = kinetic_energy(s.grains);
  run_steps(model, s, 8000, team);
  CHECK(s.grains.motion[0].velocity.z() == Approx(0.018182).margin(3e-3));
  CHECK(s.grains.motion[0].spin.norm() ==
        Approx(999.835).epsilon(3e-3));  // finite contact time turns the body a little
  CHECK(kinetic_energy(s.grains) == Approx(energy).epsilon(1e-5));
}

TEST_CASE("a sphere on an incline rolls or slides as Coulomb and inertia say") {
  struct Row {
    double angle, mu, a, alpha;
  };
  for (const auto& r :
       {Row{20, 0.2, 2.396584, 2.396584}, Row{20, 0.05, 2.894298, 1.152298}, Row{45, 0.2, 5.549374, 0}}) {
    const double R = 0.01, g = 9.81, angle = r.angle * pi / 180;
    Model model = linear_model(1e5, 2.0 / 7, 2650, r.mu);
    model.motion.gravity = Vec3(g * std::sin(angle), 0, -g * std::cos(angle));
    State s;
    const double sink = 4 * pi / 3 * R * R * R * 2650 * g * std::cos(angle) / 1e5;  // starts at rest on its contact
    add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, R - sink), 2650);
    add_floor(s);
    model.numerics.time_step = 1e-5;
    Team team(1);
    prepare(model, s, team);
    run_steps(model, s, 50000, team);
    CHECK(s.grains.motion[0].velocity.x() == Approx(r.a * 0.5).epsilon(2e-3));
    if (r.alpha > 0) CHECK(s.grains.motion[0].spin.y() * R == Approx(r.alpha * 0.5).epsilon(3e-3));
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 2e-3);
  }
}

TEST_CASE("a billiard ball slides into rolling at 5/7 of its speed") {
  const double R = 0.01, mu = 0.3, g = 9.81;
  Model model = linear_model(1e5, 2.0 / 7, 2650, mu);
  model.motion.gravity = Vec3(0, 0, -g);
  State s;
  const double mass = 4 * pi / 3 * R * R * R * 2650;
  add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, R - mass * g / 1e5), 2650, Vec3(1, 0, 0));
  add_floor(s);
  model.numerics.time_step = 1e-5;
  Team team(1);
  prepare(model, s, team);
  run_steps(model, s, 9708, team);
  CHECK(s.grains.motion[0].position.x() == Approx(0.083214).epsilon(2e-3));
  run_steps(model, s, 5000, team);
  CHECK(s.grains.motion[0].velocity.x() == Approx(5.0 / 7).epsilon(2e-3));
  CHECK(s.ledger.friction == Approx(0.5 * mass * 2 / 7).epsilon(5e-3));
}

TEST_CASE("no-slip impact with linear springs returns the closed-form contact speed") {
  for (const auto& [ratio, back] :
       std::vector<std::pair<double, double>>{{2.0 / 7, -1}, {0.5, -0.52818}, {0.8, 0.51799}}) {
    const double R = 5e-4;
    Model model = linear_model(1e6, ratio, 2650, 1e6);
    State s = sphere_on_wall(R, 2650, Vec3(1e-3, 0, -1e-3));
    model.numerics.time_step = 3.7e-6 / 3000;
    Team team(1);
    prepare(model, s, team);
    run_steps(model, s, 3500, team);
    const Vec3 contact = s.grains.motion[0].velocity + s.grains.motion[0].spin.cross(Vec3(0, 0, -R));
    CHECK(contact.x() / 1e-3 == Approx(back).margin(5e-3));
  }
}

TEST_CASE("pairs that touch by round-off only have finite histories") {
  Model model;
  State state;
  Team team(1);
  Material m;
  m.friction = 0.5, m.restitution = 0.5;
  model.materials = {m};
  model.numerics.time_step = 1e-8;
  make_pair_laws(model);
  const double radius = 3e-4;
  double distance = 2 * radius * (1 + 4e-16);
  for (int i = 0; i < 40; ++i) {  // pairs along a line, each a unit of the last place closer
    for (int side = 0; side < 2; ++side)
      set_grain(
          state.grains, state.grains.size(),
          {.shape = PolyEllipsoid::sphere(radius), .position = Vec3(side * distance, 0.01 * i, 0), .density = 2650});
    distance = std::nextafter(distance, 0.0);
  }
  prepare(model, state, team);
  for (int step = 0; step < 5; ++step)
    contact_forces(model.law, model.pairs, state.grains, state.boundary, 1e-8, true, state.contacts, team);
  std::size_t touching = 0;
  for (std::size_t k = 0; k < state.contacts.size(); ++k) {
    const Contact contact = state.contacts.contact[k];
    touching += contact.stiffness > 0;
    REQUIRE(std::isfinite(contact.compliance + contact.viscous + contact.spring[slide_spring].sum() +
                          state.contacts.touch[k].force.sum()));
    if (contact.stiffness > 0) REQUIRE(state.contacts.touch[k].overlap > 0);
  }
  CHECK(touching > 10);
  CHECK(touching < 40);
  const BlockEnergy e = flush(state.contacts);
  CHECK(std::isfinite(e.friction + e.viscous + e.work));
  CHECK(std::isfinite(elastic_energy(model.law, state.contacts)));
}
