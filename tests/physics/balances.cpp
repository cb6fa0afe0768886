// SPDX-License-Identifier: LGPL-3.0-or-later
// Terms of the ledger, each against something that it is not made of.
#include "dem/base/error.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/real_time.hpp"
#include "dem/rve/reshape.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 3e-4;

/// A contact that is pressed, released and dragged about, step by step; what the law booked, and what it put into the
/// two bodies.
struct Dragged {
  BlockEnergy booked;
  double work = 0, held = 0, most = 0;  // of the tangential spring (J); held: now, and at most
};

Dragged drag(const PairLaw& pair, double load, double sway, int steps, double way) {
  const HertzMindlin law;
  Contact c;
  law.begin(own<HertzMindlin>(pair), R / 2, 1, c);
  Touch touch;
  Dragged out;
  const double dt = 1e-7;
  Vec3 before = Vec3::Zero();
  for (int k = 0; k < steps; ++k) {
    const double phase = 2 * pi * (k + 0.5) / steps;
    const double overlap = 1e-3 * R * (1 + load * std::sin(3 * phase));
    const Vec3 v = way / (steps * dt) * Vec3(std::cos(phase), std::sin(sway * phase), 0);
    advance_contact(law, pair, 1e-6, c, touch, Vec3(0, 0, 1), overlap, v, 0, dt, out.booked);
    out.work -= 0.5 * dt * (before + c.spring[slide_spring]).dot(v);
    before = c.spring[slide_spring];
    out.most = std::max(out.most, shear_energy(c));
  }
  out.held = shear_energy(c);
  return out;
}

PairLaw sticky(double friction) {
  PairLaw p;
  p.own = HertzMindlin::Pair{30e9}, p.shear_ratio = 0.8, p.friction = {friction};
  return p;
}

/// Integral of f(x) over a poly-ellipsoid in its geometry frame, by Gauss points of order 8 in each octant.
template <class F>
void integrate(const PolyEllipsoid& s, F&& f) {
  static const double at[8] = {0.0198550717512319, 0.1016667612931866, 0.2372337950418355, 0.4082826787521751,
                               0.5917173212478249, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681};
  static const double weight[8] = {0.0506142681451881, 0.1111905172266872, 0.1568533229389437, 0.1813418916891810,
                                   0.1813418916891810, 0.1568533229389437, 0.1111905172266872, 0.0506142681451881};
  for (int octant = 0; octant < 8; ++octant) {
    Vec3 a;
    for (int k = 0; k < 3; ++k) a[k] = octant >> k & 1 ? -s.minus[k] : s.plus[k];
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        for (int k = 0; k < 8; ++k) {
          const double r = at[i], tilt = pi / 2 * at[j], angle = pi / 2 * at[k];
          const Vec3 unit(r * std::sin(tilt) * std::cos(angle), r * std::sin(tilt) * std::sin(angle),
                          r * std::cos(tilt));
          f(a.cwiseProduct(unit),
            std::abs(a.prod()) * r * r * std::sin(tilt) * pi * pi / 4 * weight[i] * weight[j] * weight[k]);
        }
  }
}

}  // namespace

TEST_CASE(
    "what a spring loses is all explained: by the stiffness that changes, by Coulomb's limit times plastic slip") {
  // Under a constant load and without slip a spring loses nothing.
  const Dragged elastic = drag(sticky(1e3), 0, 2, 4000, 1e-7);
  CHECK(std::abs(elastic.work - elastic.held) < 1e-11 * elastic.most);
  CHECK(std::abs(elastic.booked.friction) < 1e-11 * elastic.most);
  CHECK(std::abs(elastic.booked.springs) < 1e-11 * elastic.most);
  // Sticking while the load changes, and sliding. Stiffness and plastic slip change at the ends of steps: what is left
  // unexplained goes with the step. A law that keeps its force while its stiffness falls gains as much as this one
  // sheds.
  for (const auto& [friction, way] : {std::pair{1e3, 1e-7}, std::pair{0.3, 1e-5}}) {
    double before = 0;
    for (const int steps : {2000, 4000, 8000}) {
      const Dragged d = drag(sticky(friction), 0.5, 2, steps, way);
      CHECK(d.work - d.held == Approx(d.booked.springs).epsilon(1e-9));
      CHECK(d.booked.friction > d.most);
      const double missed = std::abs(d.booked.springs - d.booked.friction) / d.booked.friction;
      if (before > 0) CHECK(before / missed == Approx(2).margin(0.3));
      CHECK(missed < 8.0 / steps);
      before = missed;
    }
  }
  // Steady sliding under a constant load: mu N times the way, whatever the steps.
  PairLaw pair = sticky(0.3);
  const HertzMindlin law;
  Contact c;
  law.begin(own<HertzMindlin>(pair), R / 2, 1, c);
  Touch touch;
  BlockEnergy first, later;
  auto slide = [&](BlockEnergy& e) {
    for (int k = 0; k < 100; ++k)
      advance_contact(law, pair, 1e-6, c, touch, Vec3(0, 0, 1), 1e-3 * R, Vec3(2, 1, 0), 0, 1e-7, e);
  };
  slide(first), slide(later);
  const double limit = 0.3 * law(c, 1e-3 * R).force, way = std::sqrt(5.0) * 100 * 1e-7;
  CHECK(later.friction == Approx(limit * way).epsilon(1e-12));
  CHECK(later.springs == Approx(limit * way).epsilon(1e-12));
}

TEST_CASE("fines are the volume that the halves leave, in the parent's rigid velocity field, by quadrature") {
  for (std::uint64_t i = 0; i < 20; ++i)
    for (const bool keep_mass : {false, true}) {
      State s;
      const PolyEllipsoid shape = random_shape(21, i, 0.2, 1);
      const int axis = static_cast<int>(i % 3);
      const Vec3 v = random_rotation(23, i) * Vec3(5, 0, 0), spin = random_rotation(24, i) * Vec3(20, 0, 0);
      add(s, shape, random_rotation(22, i) * Vec3(3, 0, 0), 2650, v, spin, random_rotation(25, i));
      const Frame frame = frame_of(s.grains, 0);
      const Vec3 centre = s.grains.motion[0].position;
      FractureModel fracture;
      halves_in(fracture).rounding = 0.1, halves_in(fracture).keep_mass = keep_mass;
      double mass = 0, kinetic = 0;
      Vec3 momentum = Vec3::Zero(), turning = Vec3::Zero();
      auto count = [&](const PolyEllipsoid& body, const Vec3& origin, double density) {
        integrate(body, [&](const Vec3& local, double dv) {
          const Vec3 x = frame.origin + frame.axes * (origin + local), u = v + spin.cross(x - centre);
          const double dm = density * dv;
          mass += dm, kinetic += 0.5 * dm * u.squaredNorm(), momentum += dm * u, turning += dm * x.cross(u);
        });
      };
      const auto half = halves(shape, axis, 0.1);
      const double whole_mass = s.grains.mass[0], whole_energy = kinetic_energy(s.grains);
      count(shape, Vec3::Zero(), 2650);
      CHECK(mass == Approx(whole_mass).epsilon(1e-10));
      CHECK(kinetic ==
            Approx(whole_energy).epsilon(1e-10));  // powers of sines and cosines up to five, and eight points
      for (const Half& h : half) count(h.shape, h.origin, -2650 * (keep_mass ? 1 / 0.9 : 1));
      Fines fines;
      split_grain(s.grains, 0, axis, fracture, fines);
      CHECK(fines.mass == Approx(mass).margin(1e-10 * whole_mass));
      CHECK((fines.momentum - momentum).norm() < 1e-9 * whole_mass * 5);
      CHECK((fines.angular_momentum - turning).norm() < 1e-8 * whole_mass * 5 * 4);
      CHECK(fines.kinetic == Approx(kinetic).margin(1e-8 * whole_energy));
    }
}

TEST_CASE("a reshaped body's spin energy changes by its inertia, and nothing is left unexplained") {
  const Model model = growing(1e-5);
  Team team(1);
  State s;
  add(s, halves(PolyEllipsoid::sphere(R), 0, 0.1)[0].shape, Vec3::Zero(), 2650, Vec3(1, 2, 3), Vec3(3000, 9000, -2000),
      random_rotation(1, 1));
  prepare(model, s, team);
  s.grains.generation[0] = 1;
  const double before = kinetic_energy(s.grains);
  Reshaping reshaping;
  for (int k = 0; k < 20; ++k) reshape_fragments(model, s, 2e-7, reshaping, team);
  CHECK(std::abs(s.ledger.reshape) > 1e-3 * before);
  CHECK(kinetic_energy(s.grains) == Approx(before + s.ledger.reshape).epsilon(1e-12));
  CHECK(std::abs(s.ledger.unexplained) < 1e-12 * before);
}

TEST_CASE("a split under load is booked by the parent's own contacts, and the rest of the sample holds what it held") {
  // Five grains in a row between walls, pressed and sheared; the middle one breaks. Dashpots and friction act.
  Material m = solid(60e9, 0.17, 2650, 0.5, 0.5);
  FractureModel f;
  f.criteria.emplace_back(HoekBrown{592e6, 20.56});
  f.springs = CohesiveSprings{4, 1.77e6};
  m.fracture = f;
  const Model model = model_of(m);
  State s;
  for (int i = 0; i < 5; ++i)
    add(s, PolyEllipsoid::sphere(R), Vec3(1.99 * R * i, 0, 0), 2650, Vec3(0.2 - 0.1 * i, 0.05 * (i % 2), 0),
        Vec3(0, 0, i == 2 ? 4e4 : 0));
  for (const double side : {-1.0, 1.0}) {
    Wall wall;
    wall.material = 1, wall.point = Vec3((side < 0 ? -0.995 : 8.955) * R, 0, 0),
    wall.shape = PlaneWall{Vec3(-side, 0, 0)};
    s.boundary.walls.push_back(wall);
  }
  Team team(1);
  prepare(model, s, team);
  run_steps(model, s, 40, team);
  const double unexplained = s.ledger.unexplained, stored = stored_energy(model, s) + s.ledger.spent();
  const double held = elastic_energy(model.law, s.contacts);
  apply_breaks(model, s, {across(s, 2, 1)}, team);
  REQUIRE(s.bonds.size() == 4);
  CHECK(std::abs(s.ledger.unexplained - unexplained) < 1e-12 * held);
  CHECK(std::abs(s.ledger.split) > 0.01 * held);
  double born = 0;  // springs that hold the halves of a spinning grain
  for (const auto& b : s.bonds.cohesive.row) born += 0.5 * b.peak / b.onset * b.preload.squaredNorm();
  CHECK(born > 1e-6 * held);
  CHECK(stored_energy(model, s) + s.ledger.spent() == Approx(stored).epsilon(1e-12));
}

TEST_CASE("the work of walls and of a cell is the same sum, however a run is cut into pieces") {
  for (const bool periodic : {true, false}) {
    const Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.7));
    State start;
    for (int i = 0; i < 27; ++i)
      add(start, PolyEllipsoid::sphere(R), 1.99 * R * Vec3(0.5 + i % 3, 0.5 + i / 3 % 3, 0.5 + i / 9), 2650,
          0.1 * (random_rotation(3, static_cast<std::uint64_t>(i)) * Vec3(1, 0, 0)));
    if (periodic)
      start.boundary.cell.vectors = 3 * 1.99 * R * Mat3::Identity();
    else
      add_box(start, 3 * 1.99 * R);
    Team team(1);
    prepare(model, start, team);
    start.dt *= 0.5;
    Mat3 rate = Mat3::Zero();
    rate(2, 2) = -500, rate(0, 2) = 300;
    if (periodic)
      set_cell_rate(start, rate * start.boundary.cell.vectors);
    else
      start.boundary.walls[5].velocity = Vec3(0, 0, -1);
    State whole = start, pieces = start;
    run_steps(model, whole, 60, team);
    for (int k = 0; k < 60; ++k) run_steps(model, pieces, 1, team);
    const double scale = stored_energy(model, whole);
    CHECK(std::abs(whole.ledger.work) > 0.01 * scale);
    CHECK(std::abs(whole.ledger.work - pieces.ledger.work) < 1e-12 * scale);
    CHECK(std::abs(energy_error(whole.ledger, scale)) < 5e-3);
    // Three steps: what the ends of a run count for shows. The balance itself errs by the square of the step.
    State brief = start;
    brief.dt *= 0.1;
    run_steps(model, brief, 3, team);
    const double gained = stored_energy(model, brief) - stored_energy(model, start);
    CHECK(brief.ledger.work - start.ledger.work ==
          Approx(gained + brief.ledger.spent() - start.ledger.spent()).epsilon(2e-3));
  }
}

TEST_CASE("a run whose ledger says what cannot be is stopped, whatever the balance") {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.5));
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650, Vec3(1, 0, 0));
  Team team(1);
  prepare(model, s, team);
  CHECK_NOTHROW(check_sanity(model, s));
  const double scale = energy_scale(s.ledger, stored_energy(model, s));
  auto stopped = [&](auto&& change) {
    State wrong = s;
    change(wrong.ledger);
    wrong.ledger.work += wrong.ledger.spent();  // the balance itself closes
    try {
      check_sanity(model, wrong);
    } catch (const Unstable& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  book({.friction = 1e-3 * scale, .viscous = 1e-3 * scale}, s.ledger);
  CHECK(s.ledger.most_friction == s.ledger.friction);
  auto falls = [&](double friction, double viscous) {
    return stopped([&](Ledger& l) {
      book({.friction = friction * scale, .springs = friction * scale, .viscous = viscous * scale}, l);
    });
  };
  CHECK(falls(-0.005, -0.005).empty());
  CHECK(falls(-0.02, 0).find("friction has fallen") != std::string::npos);
  CHECK(falls(0, -0.02).find("damping has fallen") != std::string::npos);
  const auto fracture_falls = [&](double by) {
    return stopped([&](Ledger& l) {
      l.fracture = l.most_fracture = 1e-3 * scale;
      l.fracture -= by * scale;
    });
  };
  CHECK(fracture_falls(1e-12).empty());
  CHECK(fracture_falls(1e-6).find("fracture has fallen") != std::string::npos);
  CHECK(stopped([&](Ledger& l) { l.split_added = 0.02 * scale; }).find("splits have added") != std::string::npos);
  CHECK(stopped([&](Ledger& l) { l.fines.kinetic = -0.02 * scale; }).find("negative kinetic") != std::string::npos);
  CHECK(stopped([&](Ledger& l) { l.split_added = l.fines.kinetic = 0.005 * scale; }).empty());
  for (const double sign : {1.0, -1.0}) {
    const double most = sign * model.numerics.max_energy_error * scale;
    CHECK(stopped([&](Ledger& l) { l.unexplained = 1.1 * most; }).find("no known reason") != std::string::npos);
    CHECK(stopped([&](Ledger& l) { l.unexplained = 0.9 * most; }).empty());
  }
}

TEST_CASE("a time step that leads nowhere stops a run instead of going on for ever") {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.5));
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650, Vec3(1, 0, 0));
  Team team(1);
  prepare(model, s, team);
  CHECK_FALSE(endless(s, 1e9 * s.dt));
  CHECK(endless(s, 1e12 * s.dt));  // a step costs as much as a thousand grains'
  CHECK(load(model, s, {}, 10 * s.dt, team));
  model.numerics.time_step = 1e-9 * s.dt, s.next_estimate = s.steps;
  CHECK_THROWS_AS(load(model, s, {}, s.time + 1e3 * s.dt, team), Unstable);
}

TEST_CASE("round-off is no energy error: a loose cell that is only turned, a grain at rest") {
  const Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.5));
  State s;
  const double r = 3e-4;
  for (int i = 0; i < 8; ++i) add(s, PolyEllipsoid::sphere(r), 3 * r * Vec3(i & 1, i >> 1 & 1, i >> 2), 2650);
  s.boundary.cell.vectors = 6 * r * Mat3::Identity();
  Team team(1);
  prepare(model, s, team);
  const Mat3 turn = random_rotation(2, 5).toRotationMatrix();
  for (const double duration : {1e-3, 1e-7}) {  // the cell's rate is round-off over the duration
    deform_in_time(model, s, turn, duration, team);
    CHECK_NOTHROW(check_sanity(model, s));
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-3);
  }
  s.ledger.work = 1e-45;
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-9);
  // An energy that means something is still an error: the floor is a strain of 1e-10 of all grains.
  s.ledger.work = 1e-9 * 8 * 60e9 * 4 * pi / 3 * r * r * r;
  CHECK(energy_error(s.ledger, stored_energy(model, s)) == Approx(1).epsilon(1e-3));
  CHECK_THROWS_AS(check_sanity(model, s), Unstable);
}
