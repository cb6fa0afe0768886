// SPDX-License-Identifier: LGPL-3.0-or-later
// Steps that solve their contacts, at extremes: they give what statics says, or refuse.
#include "dem/base/error.hpp"
#include "dem/rve/implicit_stepper.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double g0 = 9.81, unit_density = 1 / (4 * pi / 3);  // 1 kg at a radius of 1 m

Model implicit(Model model, double step = 0) {
  model.stepper = &implicit_stepper, model.numerics.time_step = step;
  return model;
}

/// By steps of the stepper's own choice.
void run_to(const Model& model, State& s, double time, Team& team) {
  while (s.time < time) {
    update_time_step(model, s);
    run_steps(model, s, 1, team);
  }
}

/// Spheres one on the other, from the floor on: radius 1 m, of these masses (kg), each with the weight above it pressed
/// into what is below by this spring (N/m).
State tower(const std::vector<double>& masses, const std::vector<double>& springs) {
  State s;
  double above = 0, z = 0;
  for (const double m : masses) above += m;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    z += (i == 0 ? 1 : 2) - above * g0 / springs[i];
    add(s, PolyEllipsoid::sphere(1), Vec3(0, 0, z), masses[i] * unit_density);
    above -= masses[i];
  }
  add_floor(s);
  return s;
}

/// Force of each contact of a tower, from the floor on, over the weight that it carries.
std::vector<double> shares(const State& s, const std::vector<double>& masses) {
  std::vector<double> share(masses.size());
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Pair& p = s.contacts.pair[k];
    const std::size_t upper = k >= s.contacts.begin[first_wall] ? p.a : std::max(p.a, p.b);
    double above = 0;
    for (std::size_t i = upper; i < masses.size(); ++i) above += masses[i];
    share[upper] = s.contacts.touch[k].force.norm() / (above * g0);
  }
  return share;
}

}  // namespace

TEST_CASE("one grain: it falls as free fall says, and one that lies carries its weight") {
  Team team(1);
  Model model = implicit(linear_model(1e5, 0.5, unit_density, 0.5));
  model.motion.gravity = -g0 * Vec3::UnitZ();
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3(0, 0, 100), unit_density);
  add_floor(s);
  prepare(model, s, team);
  run_to(model, s, 0.5, team);
  CHECK(s.grains.motion[0].velocity.z() == Approx(-g0 * s.time).epsilon(1e-9));
  State lies = tower({1}, {1e5});
  prepare(model, lies, team);
  run_to(model, lies, 1, team);
  CHECK(shares(lies, {1})[0] == Approx(1).epsilon(1e-3));
}

TEST_CASE("without friction a plate slides as it falls; with a friction of 10 it sticks at 80 degrees") {
  Team team(1);
  for (const double friction : {0.0, 10.0}) {
    const double angle = (friction > 0 ? 80 : 30) * pi / 180, c = 1e9, dt = 1e-3;  // k dt^2 / m is 1e4
    Model model = implicit(hull_model(friction, c), dt);
    model.motion.gravity = g0 * Vec3(std::sin(angle), 0, -std::cos(angle));
    State s;
    add_body(s, box_between(Vec3(-5, -5, -0.05), Vec3(5, 5, 0.05)), Vec3(0, 0, 0.05 - 0.1 * g0 * std::cos(angle) / c),
             Quat::Identity());
    add_floor(s);
    prepare(model, s, team);
    run_for(model, s, 0.1, team);
    const double free = g0 * std::sin(angle) * 0.1;
    CHECK(s.grains.motion[0].velocity.x() / free == Approx(friction > 0 ? 0 : 1).margin(1e-9));
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-9);
  }
}

TEST_CASE("towers bear their weight: masses of 1 to 1e9, light below heavy and the other way") {
  Team team(1);
  for (const auto& masses : {std::vector<double>{1, 1e6}, {1e-9, 1}, {1, 1e-9}, {1, 1e-5, 1}}) {
    double total = 0;
    for (const double m : masses) total += m;
    const double k = 1e5 * total;
    Model model = implicit(linear_model(k, 0.5, unit_density, 0.5));
    model.motion.gravity = -g0 * Vec3::UnitZ();
    State s = tower(masses, std::vector<double>(masses.size(), k));
    prepare(model, s, team);
    run_to(model, s, 0.1, team);
    // The residual is relative to the largest force: one of 1e-9 of it is what overlaps say, to 0.3 %.
    for (const double share : shares(s, masses)) CHECK(share == Approx(1).epsilon(3e-3));
    CHECK(s.steps < 200);  // 20,000 of 5e-6 s by explicit steps for a light one of 1e-5 kg
  }
}

TEST_CASE("springs of 1 to 1e6 in one sample") {
  Team team(1);
  const double soft = 1e5, hard = 1e11;
  Model model = implicit(linear_model(soft, 0.5, unit_density, 0.5));
  Material firm = model.materials[0];
  firm.name = "firm", firm.contact = LinearSpring::Of{.stiffness = hard, .shear_ratio = 0.5};
  model.materials.insert(model.materials.begin() + 1, firm);
  make_pair_laws(model);
  model.motion.gravity = -g0 * Vec3::UnitZ();
  const std::vector<double> masses{1, 1, 1, 1};
  State s = tower(masses, {soft, std::sqrt(soft * hard), hard, hard});  // a mixed pair has their mean
  for (std::size_t i = 1; i < 4; ++i) s.grains.material[i] = 1;
  s.boundary.walls[0].material = 2;
  prepare(model, s, team);
  run_to(model, s, 1, team);
  for (const double share : shares(s, masses)) CHECK(share == Approx(1).epsilon(3e-3));
}

TEST_CASE("a heap that falls makes no energy") {
  Team team(1);
  Model model = implicit(linear_model(1e5, 0.5, unit_density, 0.5));
  model.materials[0].restitution = 0.5;
  make_pair_laws(model);
  model.motion.gravity = -g0 * Vec3::UnitZ();
  State s;
  for (int n = 0; n < 27; ++n)
    add(s, PolyEllipsoid::sphere(1),
        Vec3(2.2 * (n % 3) + 0.02 * n, 2.2 * ((n / 3) % 3) - 0.01 * n, 1.1 + 2.3 * (n / 9)), unit_density);
  add_floor(s);
  prepare(model, s, team);
  for (double time = 0.1; time < 2; time += 0.1) {
    run_to(model, s, time, team);
    CHECK(stored_energy(model, s) < 1.001 * s.ledger.work);
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.03);  // dashpots that set in within a step
  }
  CHECK(s.ledger.local_damping > 0);
}

TEST_CASE("a step a thousand times too long is refused, or gives what statics says") {
  Team team(1);
  Model model = implicit(linear_model(1e5, 0.5, unit_density, 0.5), 20);  // k dt^2 / m is 4e7
  model.motion.gravity = -g0 * Vec3::UnitZ();
  const std::vector<double> masses(10, 1);
  State s = tower(masses, std::vector<double>(10, 1e5));
  prepare(model, s, team);
  std::string told;
  try {
    run_steps(model, s, 5, team);
  } catch (const Unstable& e) {
    told = e.what();
  }
  if (told.empty())
    for (const double share : shares(s, masses)) CHECK(share == Approx(1).epsilon(0.01));
  else
    CHECK_THAT(told, Catch::Contains("lower numerics"));
}
