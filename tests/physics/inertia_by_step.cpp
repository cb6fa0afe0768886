// SPDX-License-Identifier: LGPL-3.0-or-later
// Inertia by each grain's own step: closed forms of one and three bodies, what it does to motion and energy, packings,
// births, extremes.
#include "dem/motion/inertia_by_step.hpp"
#include "dem/io/archive.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/rve/critical_grain.hpp"
#include "dem/rve/resting.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"
#include "tests/held_grains.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

std::vector<double> solids(const Grains& g) {
  std::vector<double> all;
  for (std::size_t i = 0; i < g.size(); ++i) all.push_back(solid_mass(g, i));
  return all;
}

GivenInertia give(const Model& model, State& s, double most) {
  return give_inertia(held_of(model, s), most, solids(s.grains), s.grains);
}

/// A box of this density at x, its edges along the axes.
std::size_t add_box_of(State& s, const Vec3& edges, const Vec3& x, double density) {
  const std::size_t i = add_body(s, box_between(-0.5 * edges, 0.5 * edges), x, Quat::Identity());
  GrainSpec spec;
  spec.hull = s.grains.hull[i], spec.position = x, spec.density = density, spec.orientation = s.grains.orientation[i];
  set_grain(s.grains, i, spec);
  return i;
}

/// A cube of 1 mm, 2650 kg/m^3, as deep as this in a plane (m).
State cube_on_plane(double overlap) {
  State s;
  add_box_of(s, Vec3::Constant(1e-3), Vec3(0, 0, 0.5e-3 - overlap), 2650);
  add_floor(s);
  return s;
}

double eigenvalue(const Model& model, const State& s, std::size_t i) {
  return largest_eigenvalue(held_of(model, s).stiffness(i));
}

}  // namespace

TEST_CASE("a cube on a plane gets the mass that its foundation asks for, half as much against rocking; no more") {
  Model model = hull_model(0, 1e14);
  model.numerics.safety = 0.5, model.numerics.inertia_step = 5e-7;
  Team team(1);
  State s = cube_on_plane(1e-9);
  const double solid = s.grains.mass[0];
  prepare(model, s, team);
  // c A (step / safety)^2 / 4 over 2650 kg/m^3 mm^3. Rocking: c a^4 / 12 over m a^2 / 6.
  CHECK(s.grains.mass[0] / solid == Approx(9.43396).epsilon(1e-5));
  CHECK(turn_mass(s.grains, 0) / solid == Approx(9.43396 / 2).epsilon(1e-4));
  CHECK(s.grains.inertia[0].moments.x() == Approx(9.43396 / 2 * solid * 1e-6 / 6).epsilon(1e-4));
  CHECK(s.dt == Approx(5e-7).epsilon(1e-8));
  CHECK(s.ledger.inertia == 0);
  CHECK(solid_mass(s.grains, 0) == solid);
  CHECK(total_mass(s.grains) == solid);
  // A step that needs nothing gives nothing.
  model.numerics.inertia_step = 1.6e-7;
  State light = cube_on_plane(1e-9);
  prepare(model, light, team);
  CHECK(light.grains.solid_mass.empty());
  CHECK(light.grains.turn_mass.empty());
  CHECK(light.dt == Approx(0.5 * 2 / std::sqrt(1e8 / solid)).epsilon(1e-6));
  const CriticalGrain critical = critical_grain(model, light);
  CHECK(critical.turning == Approx(0).margin(1e-9));
  CHECK(critical.width == Approx(1e-3));
  CHECK(critical.diameter == Approx(1e-3 * std::cbrt(6 / pi)));
}

TEST_CASE("with that mass the cube is stable just below the bound and leaves just above it") {
  for (const double part : {0.95, 1.05}) {
    Model model = hull_model(0, 1e14);
    model.numerics.safety = 0.5, model.numerics.inertia_step = 5e-7;
    Team team(1);
    State s = cube_on_plane(1e-7);
    prepare(model, s, team);
    const double weight = 1e8 * 1e-7;
    model.motion.gravity = Vec3(0, 0, -weight / s.grains.mass[0]);
    model.numerics.inertia_step = 0, model.numerics.time_step = part * 1e-6;
    prepare(model, s, team);
    s.grains.motion[0].position.z() -= 1e-11;  // a ten-thousandth of the overlap
    run_steps(model, s, 60, team);
    const double off = std::abs(s.grains.motion[0].position.z() - (0.5e-3 - 1e-7));
    CHECK((off < 1e-10) == (part < 1));
  }
}

TEST_CASE("a bar on two cubes turns too fast, not shifts: its moments grow, its mass does not") {
  const Model model = loose(0);  // c = 1e6
  Team team(1);
  State s;
  const double deep = 1e-8;
  add_box_of(s, Vec3(10, 1, 1), Vec3::Zero(), 1);
  for (const double side : {-4.5, 4.5}) add_box_of(s, Vec3::Ones(), Vec3(side, 0, -1 + deep), 1);
  prepare(model, s, team);
  // Of pairs twice: shifts 2 x 2 c over 10; turns about y 2 x 2 (c 4.5^2 + c / 12) over 10 (100 + 1) / 12.
  const double c = 1e6, of_shifts = 4 * c / 10, of_turns = 4 * c * (4.5 * 4.5 + 1.0 / 12) / (10 * 101.0 / 12);
  CHECK(eigenvalue(model, s, 0) == Approx(of_turns).epsilon(1e-6));
  CHECK(share_of_turning(held_of(model, s), {1, 0, 0, false, false}) == Approx(1).epsilon(1e-6));
  CHECK(share_of_turning(held_of(model, s), {1, 1, 0, false, false}) == Approx(0).margin(1e-6));  // a cube: 2 c over 1
  const double most = 0.5 * c;
  CHECK(of_shifts < most);
  give(model, s, most);
  CHECK(s.grains.mass[0] == solid_mass(s.grains, 0));
  CHECK(turn_mass(s.grains, 0) / solid_mass(s.grains, 0) == Approx(of_turns / most).epsilon(1e-6));
  CHECK(s.grains.mass[1] == Approx(2 * c / most).epsilon(1e-6));
  CHECK(turn_mass(s.grains, 1) == Approx(2 * c / 12 / (1.0 / 6) / most).epsilon(1e-6));  // rocking
  for (std::size_t i = 0; i < 3; ++i) CHECK(eigenvalue(model, s, i) <= most * (1 + 1e-8));
  const AddedInertia added = added_inertia(s.grains);
  CHECK(added.mass == Approx(2 * 3 / 12.0).epsilon(1e-6));
  const double bar = 2 * 101 / 12.0 * 10 + 10 / 6.0, cube = 0.5;  // traces
  CHECK(added.moment == Approx((bar * (of_turns / most - 1) + 2 * cube) / (bar + 2 * cube)).epsilon(1e-6));
  CHECK(added.heavier == Approx(2 / 3.0));
  CHECK(added.slower == Approx(1));
  CHECK(largest_inertial_number(s.grains, 3, 4) ==
        Approx(3 * 2 * std::cbrt(7.5 / pi) * std::sqrt(1 / 4.0)).epsilon(1e-6));
}

TEST_CASE("packings: every grain bears the step, none has more than it needs, none less than its solid") {
  Team team(1);
  const Model hulls = loose(0.4);
  Material rolls = solid(60e9, 0.17, 2650, 0.5);
  rolls.rolling_friction = 0.1;
  const Model rounds = model_of(rolls);
  for (const int kind : {0, 1, 2}) {
    const Model& model = kind == 0 ? hulls : rounds;
    State s;
    if (kind == 0) s = pressed_cells(model, 100, 0.01);
    for (std::uint64_t i = 0; kind > 0 && i < 64; ++i) {
      PolyEllipsoid shape = random_shape(3, i, 0.3, 1.2);
      shape.plus *= 3e-4, shape.minus *= 3e-4;
      if (kind == 2) shape = PolyEllipsoid::sphere(3e-4 * (0.3 + random_uniform(4, i, Purpose::radius)));
      const Vec3 place(static_cast<double>(i % 4), static_cast<double>(i / 4 % 4), static_cast<double>(i / 16));
      add(s, shape, 4.5e-4 * place, 2650, Vec3(0.1, 0.2, -0.1), Vec3(10, 20, 5), random_rotation(7, i));
    }
    prepare(model, s, team);
    const State before = s;
    const double dt = critical_step(held_of(model, s), true).dt,
                 most = 4 / (1.44 * dt * dt);  // a step longer by a fifth
    const GivenInertia given = give(model, s, most);
    std::size_t heavier = 0, slower = 0;
    const auto touched = held_of(model, s).touched();
    for (std::size_t i = 0; i < s.grains.size(); ++i) {
      const double m = solid_mass(s.grains, i), turning = turn_mass(s.grains, i), now = eigenvalue(model, s, i);
      CHECK((m == before.grains.mass[i] && s.grains.mass[i] >= m && turning >= m));
      CHECK(now <= most * (1 + 1e-8));
      const bool more = s.grains.mass[i] > m || turning > m;
      if (more && touched[i]) CHECK(now >= most * (1 - 1e-2));
      if (!more) CHECK(eigenvalue(model, before, i) <= most);
      heavier += s.grains.mass[i] > m, slower += turning > m;
      const Motion &is = s.grains.motion[i], &was = before.grains.motion[i];
      CHECK((s.grains.mass[i] * is.velocity - m * was.velocity).norm() <= 1e-12 * m * was.velocity.norm());
      CHECK((turning * spin_of(s.grains, i) - m * was.spin).norm() <= 1e-12 * m * 30);
      CHECK((spin_of(s.grains, i) - is.spin).norm() <= 1e-12 * 30);
      CHECK((s.grains.inertia[i].moments - turning / m * before.grains.inertia[i].moments).norm() <=
            1e-12 * s.grains.inertia[i].moments.norm());
      CHECK(s.grains.motion[i].inverse_mass == 1 / s.grains.mass[i]);
    }
    CHECK(heavier > 0);
    CHECK(slower > 0);
    CHECK(heavier + slower < s.grains.size());
    const double gained = kinetic_energy(s.grains) - kinetic_energy(before.grains);
    CHECK(given.kinetic == Approx(gained).epsilon(1e-9).margin(1e-20));
    if (kind > 0) CHECK(gained < 0);
    CHECK(critical_step(held_of(model, s), true).dt == Approx(1.2 * dt).epsilon(1e-6));
    // A second time there is nothing to do.
    const State once = s;
    CHECK(give(model, s, most).rise == 1);
    CHECK((s.grains.mass == once.grains.mass && s.grains.turn_mass == once.grains.turn_mass));
  }
}

TEST_CASE("grains get the same masses from any number of threads, also where these have been given some before") {
  const Model model = loose(0.4);
  Team one(1);
  State s = pressed_cells(model, 400, 0.01);
  prepare(model, s, one);
  const double dt = critical_step(held_of(model, s), true).dt;
  for (const double longer : {2.0, 3.0, 1.2}) {  // the last gives mass up again
    const double most = 4 / (longer * longer * dt * dt);
    std::vector<State> by(3, s);
    for (int k = 0; k < 3; ++k) {
      State& now = by[static_cast<std::size_t>(k)];
      Team team(k + 1);
      const HeldGrains held(model.law, model.pairs, model.materials.size(), now.grains, now.boundary, now.contacts,
                            now.bonds, 0, team);
      give_inertia(held, most, solids(now.grains), now.grains);
      CHECK(hash(now) == hash(by[0]));
    }
    CHECK(hash(by[0]) != hash(s));
    s = by[0];
  }
}

TEST_CASE("what is over goes once half of it would do, and the solid stays; a hull in flight keeps all") {
  Model model = hull_model(0, 1e14);
  model.numerics.safety = 0.5, model.numerics.inertia_step = 5e-7;
  Team team(1);
  State s = cube_on_plane(1e-9);
  prepare(model, s, team);
  const double omega = 2 * 0.5 / 5e-7, most = omega * omega, mass = s.grains.mass[0], solid = solid_mass(s.grains, 0),
               turning = turn_mass(s.grains, 0);
  State turns = s;  // four times the moments that it needs, and the mass; less than twice is kept
  set_inertia(turns.grains, 0, mass, 1.9 * turning);
  give(model, turns, most);
  CHECK(turn_mass(turns.grains, 0) == Approx(1.9 * turning).epsilon(1e-12));
  set_inertia(turns.grains, 0, mass, 4 * turning);
  give(model, turns, most);
  CHECK(turn_mass(turns.grains, 0) == Approx(turning).epsilon(1e-6));
  CHECK(turns.grains.mass[0] == Approx(mass).epsilon(1e-6));
  s.grains.motion[0].velocity.z() = 1;
  State flies = s;
  // In flight the wall could meet a quarter of its surface, by 2 c S / 4, three times the face. It gives up no more
  // than would leave that.
  give(model, s, 5 * most);
  CHECK(s.grains.mass[0] == Approx(mass).epsilon(1e-12));
  const double energy = kinetic_energy(s.grains);
  const GivenInertia given = give(model, s, 7 * most);
  CHECK(s.grains.mass[0] == Approx(3.0 / 7 * mass).epsilon(1e-6));
  CHECK(turn_mass(s.grains, 0) == Approx(solid).epsilon(1e-12));
  CHECK(s.grains.motion[0].velocity.z() == 1);
  CHECK(given.kinetic == Approx(kinetic_energy(s.grains) - energy).epsilon(1e-12));
  CHECK(given.kinetic < 0);
  CHECK(given.rise == 1);
  give(model, s, 1e6 * most);
  CHECK(s.grains.mass[0] == solid);

  flies.contacts.contact.set(0, {});
  give(model, flies, most);
  CHECK(flies.grains.mass[0] == Approx(3 * mass).epsilon(1e-6));
  CHECK(turn_mass(flies.grains, 0) == turning);
  CHECK(flies.grains.motion[0].velocity.z() == Approx(1.0 / 3).epsilon(1e-6));
  flies.grains.motion[0].position.z() += 0.5e-3;
  give(model, flies, most / 1.9);
  CHECK(flies.grains.mass[0] == Approx(1.9 * 3 * mass).epsilon(1e-6));
  give(model, flies, 1e6 * most);
  CHECK(flies.grains.mass[0] == Approx(1.9 * 3 * mass).epsilon(1e-6));
  CHECK(turn_mass(flies.grains, 0) == turning);
}

TEST_CASE("in a cell that deforms a grain that gains mass keeps its momentum against the field") {
  Model model = loose(0);
  Team team(1);
  State s = pressed_cells(model, 60, 0.01);
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -3, rate(0, 2) = 2;
  set_cell_rate(s, rate);
  const Mat3 field = s.boundary.cell.rate * s.boundary.cell.vectors.inverse();
  for (std::size_t i = 0; i < s.grains.size(); ++i) s.grains.motion[i].velocity += 0.1 * random_vector(i, 5);
  const State before = s;
  const double dt = critical_step(held_of(model, s), true).dt;
  give(model, s, 4 / (4 * dt * dt));
  std::size_t heavier = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const Vec3 at = field * s.grains.motion[i].position;
    const Vec3 is = s.grains.mass[i] * (s.grains.motion[i].velocity - at),
               was = before.grains.mass[i] * (before.grains.motion[i].velocity - at);
    CHECK((is - was).norm() <= 1e-12 * before.grains.mass[i] * (at.norm() + 1));
    heavier += s.grains.mass[i] > before.grains.mass[i];
  }
  CHECK(heavier > 0);
}

TEST_CASE("bonded cells with dashpots get what both ask for, and stand still in the step that they then bear") {
  Team team(1);
  BondModel bond = elastic(1);
  bond.damping = 0.3;
  Model model = rock(bond);
  State s = pressed_cells(model, 27, 0);
  prepare(model, s, team);
  const double own = s.dt / model.numerics.safety;
  model.numerics.inertia_step = 4 * own * model.numerics.safety;
  prepare(model, s, team);
  CHECK(s.dt >= 4 * own * model.numerics.safety * (1 - 1e-6));
  CHECK(added_inertia(s.grains).mass > 1);
}

namespace {

/// Loose cells that cleave while they are compressed, for so many times 1e-3 of strain.
State crushed(Model model, double step, double strain, int threads = 1, bool saved = false) {
  model.numerics.inertia_step = step, model.numerics.safety = 0.5;
  Team team(threads);
  State s = pressed_cells(model, 27, 0.002);
  prepare(model, s, team);
  Mat3 rate = Mat3::Zero();
  rate(2, 2) = -0.25 * s.boundary.cell.vectors(2, 2);
  set_cell_rate(s, rate);
  for (const double end = strain / 0.25; s.time < end;) {
    if (saved && s.time > 0.5 * end) s = state_of(bytes_of(s)), saved = false;
    update_time_step(model, s);
    run_steps(model, s, 20, team);
  }
  return s;
}

Model cleaving() {
  Model model = rock(elastic(0.4), 0.5);
  FractureModel f;
  Cleavage c;
  c.toughness = 2e5, c.flaw = 1e-2, c.planes = {{Vec3::UnitX(), 1e5}, {Vec3(0.6, 0.8, 0), 2e5}};
  f.crystal = Crystal{};
  f.criteria.emplace_back(c);
  f.splitter = Cut{false, 50};
  f.limit.max_generations = 3;
  model.materials[0].fracture = f;
  model.materials[0].bond.reset();
  make_pair_laws(model);
  return model;
}

}  // namespace

TEST_CASE("cells that cleave: pieces get the inertia for the step at birth, the ledger closes, any threads, resumed") {
  const Model model = cleaving();
  const State plain = crushed(model, 0, 0.008);
  REQUIRE(plain.ledger.breakages > 20);
  const double step = 2 * plain.dt;
  const State s = crushed(model, step, 0.008);
  CHECK(s.ledger.breakages > 20);
  CHECK(s.dt >= step * (1 - 1e-6));
  CHECK(s.ledger.inertia != 0);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.02);
  CHECK(std::abs(total_mass(s.grains) / total_mass(plain.grains) - 1) < 1e-10);
  CHECK(std::abs(s.ledger.fines.kinetic) < 1e-9 * energy_scale(s.ledger, 0));  // pieces have all of the solid's turns
  CHECK(10 * s.steps < 7 * plain.steps);
  const AddedInertia added = added_inertia(s.grains);
  CHECK(added.mass > 0.01);
  CHECK(added.mass < 1);
  CHECK(hash(crushed(model, step, 0.008, 2)) == hash(s));
  CHECK(hash(crushed(model, step, 0.008, 1, true)) == hash(s));
  // At rest and awake again: the same inertia to the bit.
  Team team(1);
  State again = at_rest(s);
  awaken(model, again, team);
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    CHECK(again.grains.inertia[i].moments == s.grains.inertia[i].moments);
    CHECK(turn_mass(again.grains, i) == turn_mass(s.grains, i));
  }
}

TEST_CASE(
    "across a plane of a grain whose turns are resisted by another mass than its shifts both sides tell the same") {
  const Model model = loose(0);
  State s = loaded_body(model, box_between(Vec3(-2, -0.5, -0.5), Vec3(2, 0.5, 0.5)),
                        {{Vec3(2, 0.4, 0.1), Vec3(1, 3, -2)}, {Vec3(-2, 0.1, 0.3), Vec3(-2, 1, 1)}});
  set_inertia(s.grains, 0, 3 * s.grains.mass[0], 7 * s.grains.mass[0]);
  s.grains.angular_momentum[0] = inertia_tensor(s.grains, 0) * Vec3(0.5, -1, 2);
  const LoadedHull g = loaded_hull(model, s, 0);
  for (std::uint64_t k = 0; k < 6; ++k) {
    const Vec3 n = random_vector(1, k).normalized();
    const PlaneLoad one = g.across_plane(n, 0.2), other = g.across_plane(-n, -0.2);
    CHECK((one.force + other.force).norm() < 1e-9);
    CHECK((one.moment + other.moment).norm() < 1e-9);
    CHECK(one.force.norm() > 0.1);
  }
}

TEST_CASE(
    "needles and plates of 1 : 10, sizes of 1 : 100, all grains at once: stable at the step that they are given") {
  Team team(1);
  for (const int kind : {0, 1, 2}) {
    Model model = loose(0.3);
    model.numerics.safety = 0.5;
    State s;
    const Vec3 edges = kind == 0 ? Vec3(10, 1, 1) : Vec3(10, 10, 1);
    double top = 0;
    for (int k = 0; k < 12; ++k) {  // piles of three layers, crossed; of sizes each a fifth of the one below
      const double scale = kind == 2 ? std::pow(0.01, k / 11.0) : 1;
      const Vec3 of = scale * (kind == 2 ? Vec3::Ones().eval() : edges);
      const Quat q(Eigen::AngleAxisd(0.5 * pi * (kind < 2 ? k / 4 : 0), Vec3::UnitZ()));
      const double high = kind == 2 ? top + 0.5 * of.z() : 0.5 + k / 4 - 1e-5 * (k / 4);
      const double aside = kind == 2 ? 0 : 3 * (k % 4 - 1.5) * (kind == 0 ? 1 : 10);
      add_body(s, box_between(-0.5 * of, 0.5 * of), q * Vec3(0, aside, 0) + Vec3(0, 0, high), q);
      top += of.z() * (1 - 1e-5);
    }
    add_floor(s);
    prepare(model, s, team);
    const double own = s.dt;
    model.numerics.inertia_step = 10 * own;
    prepare(model, s, team);
    CHECK(s.dt >= 10 * own * (1 - 1e-6));
    run_for(model, s, 2000 * s.dt, team);
    CHECK(s.dt >= 10 * own * (1 - 1e-6));
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 0.05);
    if (kind == 2) CHECK(s.grains.mass[11] / solid_mass(s.grains, 11) > 50);
  }
}
