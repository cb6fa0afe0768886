// SPDX-License-Identifier: LGPL-3.0-or-later
// Free rotation, isolated systems, the critical step, lattices.
#include <algorithm>
#include <cstdio>

#include "dem/base/error.hpp"
#include "dem/contact/forces.hpp"
#include "dem/motion/critical_step.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/measure.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("a 1:9 body tumbles without losing energy or angular momentum") {
  PolyEllipsoid shape;
  shape.plus = Vec3(9e-3, 1.2e-3, 1e-3), shape.minus = Vec3(8e-3, 1e-3, 1.1e-3);
  Model model = model_of(solid(60e9, 0.17, 2650));
  State s;
  add(s, shape, Vec3::Zero(), 2650, Vec3::Zero(), Vec3(30, 100, 20), random_rotation(1, 1));
  model.numerics.time_step = 1e-5;
  Team team(1);
  prepare(model, s, team);
  const double energy = kinetic_energy(s.grains);
  const Vec3 momentum = angular_momentum(s.grains);
  double worst = 0;
  for (int k = 0; k < 200; ++k) {
    run_steps(model, s, 1000, team);  // 2 s in all: more than 200 radians
    worst = std::max(worst, std::abs(kinetic_energy(s.grains) / energy - 1));
  }
  CHECK(worst < 1e-6);  // bounded, of second order in spin * dt = 1e-3
  CHECK((angular_momentum(s.grains) - momentum).norm() < 1e-13 * momentum.norm());
}

TEST_CASE("the intermediate axis flips with the exact period") {
  // Ellipsoid with the moments of a 2 x 3 x 5 mm box: <x^2> = L^2 / 12 = a^2 / 5.
  PolyEllipsoid shape;
  shape.plus = shape.minus = 1e-3 * std::sqrt(5.0 / 12) * Vec3(2, 3, 5);
  Model model = model_of(solid(60e9, 0.17, 2650));
  State s;
  add(s, shape, Vec3::Zero(), 2650, Vec3::Zero(), Vec3(0.1, 100, 0.1));
  model.numerics.time_step = 1e-5;
  Team team(1);
  prepare(model, s, team);
  double first = 0, second = 0, before = 1;
  while (s.time < 1.5 && second == 0) {
    run_steps(model, s, 10, team);
    const double along = (s.grains.orientation[0].conjugate() * s.grains.motion[0].spin).y();
    if (before > 0 && along <= 0) (first == 0 ? first : second) = s.time;
    before = along;
  }
  CHECK(second - first == Approx(0.829987).epsilon(1e-3));
}

TEST_CASE("an isolated cloud keeps linear and angular momentum through a thousand impacts") {
  Model model = model_of(solid(60e9, 0.17, 2650, 0.5, 0.8));
  model.numerics.safety = 0.05;
  State s;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const Vec3 x =
        1.3e-3 * Vec3(static_cast<double>(i % 4), static_cast<double>(i / 4 % 4), static_cast<double>(i / 16));
    PolyEllipsoid shape = random_shape(3, i);
    shape.plus *= 6e-4, shape.minus *= 6e-4;
    add(s, i % 3 ? shape : PolyEllipsoid::sphere(5e-4), x, 2650,
        -2e3 * (x - Vec3::Constant(2e-3)) + random_rotation(4, i) * Vec3(1, 0, 0),
        random_rotation(5, i) * Vec3(500, 0, 0), random_rotation(6, i));
  }
  Team team(1);
  prepare(model, s, team);
  const Vec3 p = momentum(s.grains), l = angular_momentum(s.grains);
  double scale = 0;
  for (std::size_t i = 0; i < s.grains.size(); ++i) scale += s.grains.mass[i] * s.grains.motion[i].velocity.norm();
  run_for(model, s, 1.5e-3, team);
  CHECK(s.ledger.damping > 0);
  CHECK(s.ledger.local_damping == 0);  // dashpots are the contacts'
  CHECK((momentum(s.grains) - p).norm() < 1e-12 * scale);
  CHECK((angular_momentum(s.grains) - l).norm() < 1e-12 * scale * 2e-3);
  CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 1e-2);
}

namespace {

/// Periodic lattice of equal spheres, compressed to a contact overlap.
State lattice(bool fcc, int n, double R, double overlap, double density) {
  State s;
  const double d = 2 * R - overlap, edge = fcc ? std::sqrt(2.0) * d : d;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const Vec3 o = edge * Vec3(x, y, z);
        add(s, PolyEllipsoid::sphere(R), o, density);
        if (fcc)
          for (const Vec3& f : {Vec3(0.5, 0.5, 0), Vec3(0.5, 0, 0.5), Vec3(0, 0.5, 0.5)})
            add(s, PolyEllipsoid::sphere(R), o + edge * f, density);
      }
  s.boundary.cell.vectors = n * edge * Mat3::Identity();
  return s;
}

/// Stress per unit strain by differences: the cell is strained affinely (exact for lattices) and forces re-evaluated.
Mat6 stiffness_by_difference(const Model& model, const State& start) {
  Mat6 c;
  Team team(1);
  for (int e = 0; e < 6; ++e) {
    Vec6 stress[2];
    for (int side = 0; side < 2; ++side) {
      State s = start;
      const double h = (side ? -1 : 1) * 1e-8;
      Mat3 rate = Mat3::Zero();
      const int i = voigt_row[e], j = voigt_col[e];
      if (i == j)
        rate(i, i) = h;
      else
        rate(i, j) = rate(j, i) = 0.5 * h;
      s.dt = 1;  // one quasi-static step: velocities are those of the strain, no force acts on them
      for (std::size_t k = 0; k < s.grains.size(); ++k) {
        s.grains.motion[k].velocity = rate * s.grains.motion[k].position;
        s.grains.motion[k].position += rate * s.grains.motion[k].position;
      }
      s.boundary.cell.rate = rate * s.boundary.cell.vectors;
      s.boundary.cell.vectors += s.boundary.cell.rate;
      contact_forces(model.law, model.pairs, s.grains, s.boundary, s.dt, true, s.contacts, team);
      stress[side] = to_voigt(love_weber(s, s.boundary.cell.volume()));
    }
    c.col(e) = (stress[0] - stress[1]) / 2e-8;
  }
  return c;
}

}  // namespace

TEST_CASE("lattices of linear springs have the stiffness of the closed form, by differences and by the tangent") {
  const double R = 5e-4, kn = 1e6, kt = 8e5;
  Model model = linear_model(kn, 0.8, 2650, 1e3);
  Team team(1);
  for (bool fcc : {false, true}) {
    State s = lattice(fcc, fcc ? 3 : 4, R, 1e-9, 2650);
    prepare(model, s, team);
    const double c11 = fcc ? 2.545584e9 : kn / (2 * R), c12 = fcc ? 1.414214e8 : 0,
                 c44 = fcc ? 1.272792e9 : kt / (4 * R);
    for (const Mat6& c : {contact_stiffness_tangent(model, s), stiffness_by_difference(model, s)}) {
      CHECK(c(0, 0) == Approx(c11).epsilon(1e-4));
      CHECK(c(0, 1) == Approx(c12).margin(1e-4 * c11));
      CHECK(c(3, 3) == Approx(c44).epsilon(1e-4));
      CHECK(c(4, 4) == Approx(c44).epsilon(1e-4));
      CHECK(std::abs(c(0, 3)) < 1e-4 * c11);
    }
  }
}

TEST_CASE("lattices whose contacts have dashpots resist a strain rate by the closed form") {
  const double R = 5e-4, kn = 1e6, dashpot = 0.5;
  Model model = linear_model(kn, 0.8, 2650, 1e3);
  for (PairLaw& p : model.pairs) p.dashpot = dashpot;
  Team team(1);
  for (bool fcc : {false, true}) {
    State s = lattice(fcc, fcc ? 3 : 4, R, 1e-9, 2650);
    prepare(model, s, team);
    const double c = dashpot * std::sqrt(0.5 * s.grains.mass[0] * kn);
    for (int k = 0; k < 3; ++k)
      CHECK(contact_viscosity(model, s)[k] == Approx(c / (fcc ? std::sqrt(2.0) : 2) / R).epsilon(1e-4));
  }
}

TEST_CASE("Hertz lattices under pressure have the stiffness of the closed form") {
  struct Row {
    bool fcc;
    double p, c11, c12, c44;
  };
  const double R = 3e-4;
  Model model = model_of(solid(60e9, 0.17, 2650, 10));
  Team team(1);
  for (const auto& r : {Row{false, 1e6, 1127.03e6, 0, 511.17e6}, Row{true, 1e6, 2149.36e6, 52.35e6, 1074.68e6},
                        Row{true, 1e7, 4630.66e6, 112.78e6, 2315.33e6}}) {
    const double force = (r.fcc ? std::sqrt(2.0) : 4.0) * R * R * r.p;
    const double overlap = std::pow(force / (4.0 / 3 * reduced_modulus(model.pairs[0]) * std::sqrt(R / 2)), 2.0 / 3);
    State s = lattice(r.fcc, r.fcc ? 3 : 4, R, overlap, 2650);
    prepare(model, s, team);
    CHECK(mean_pressure(love_weber(s, s.boundary.cell.volume())) ==
          Approx(r.p * std::pow(2 * R / (2 * R - overlap), 2)).epsilon(1e-6));  // the closed form takes touching radii
    const Mat6 c = contact_stiffness_tangent(model, s);
    CHECK(c(0, 0) == Approx(r.c11).epsilon(1e-2));
    CHECK(c(0, 1) == Approx(r.c12).margin(1e-2 * r.c11));
    CHECK(c(3, 3) == Approx(r.c44).epsilon(1e-2));
  }
}

TEST_CASE("the critical step of a simple-cubic lattice is exact, and a true bound for the face-centred one") {
  const double R = 5e-4;
  Team team(1);
  struct Row {
    bool fcc;
    double ratio, exact;
  };
  for (const auto& r : {Row{false, 0, 1.177938e-6}, Row{false, 0.8, 5.889688e-7}, Row{false, 2.0 / 7, 9.396716e-7},
                        Row{true, 0.8, 4.164638e-7}}) {
    Model model = linear_model(1e6, r.ratio, 2650, r.ratio > 0 ? 1 : 0);
    State s = lattice(r.fcc, 3, R, 1e-9, 2650);
    prepare(model, s, team);
    const CriticalStep c = critical_step(model.law, model.pairs, 2, s.grains, s.boundary, s.contacts, s.bonds);
    CHECK(c.dt <= r.exact * (1 + 1e-6));
    CHECK(c.dt >= 0.7 * r.exact);
    if (!r.fcc && r.ratio != 2.0 / 7) CHECK(c.dt == Approx(r.exact).epsilon(1e-4));
  }
}

TEST_CASE("the critical step is that of the worst grain, also where cheap bounds leave most grains out") {
  for (std::uint64_t sample = 0; sample < 60; ++sample) {
    const bool bodies = sample > 5;
    Material rolls = solid(60e9, 0.17, 2650, 0.5);
    rolls.rolling_friction = bodies ? 0.1 : 0;
    Model model = model_of(rolls);
    model.numerics.time_step = 1e-8;
    State s;
    const std::uint64_t n = 3;
    const double R = 3e-4, pitch = 1.7 * R;
    for (std::uint64_t i = 0; i < n * n * n; ++i) {
      PolyEllipsoid shape = random_shape(3 + sample, i, 0.2, 1.2);
      shape.plus *= R, shape.minus *= R;
      if (!bodies) shape = PolyEllipsoid::sphere(R * (0.9 + 0.2 * random_uniform(4 + sample, i, Purpose::radius)));
      add(s, shape,
          pitch * Vec3(static_cast<double>(i % n), static_cast<double>(i / n % n), static_cast<double>(i / n / n)),
          2650, Vec3::Zero(), Vec3::Zero(), random_rotation(7 + sample, i));
    }
    Team team(1);
    prepare(model, s, team);
    auto step = [&](const State& of) {
      return critical_step(model.law, model.pairs, 2, of.grains, of.boundary, of.contacts, of.bonds).dt;
    };
    const double all = step(s);
    // The contacts of one grain alone: of those that it touches none is stiffer than in the whole.
    double least = INFINITY;
    for (std::size_t i = 0; i < s.grains.size(); ++i) {
      State star = s;
      for (std::size_t k = 0; k < star.contacts.size(); ++k)
        if (star.contacts.pair[k].a != i && star.contacts.pair[k].b != i) star.contacts.contact.set(k, {});
      least = std::min(least, step(star));
    }
    CHECK(all == Approx(least).epsilon(1e-12));
    CHECK(all < 0.5 * step([&] {
                  State none = s;
                  for (std::size_t k = 0; k < none.contacts.size(); ++k) none.contacts.contact.set(k, {});
                  return none;
                }()));
  }
}

TEST_CASE("a lattice is stable just below the critical step and diverges just above") {
  Model model = linear_model(1e6, 0, 2650, 0);
  Team team(1);
  for (double part : {0.95, 1.05}) {
    State s =
        lattice(false, 4, 5e-4, 1e-9, 2650);  // hardly compressed: a frictionless cubic lattice under load buckles
    model.numerics.time_step = part * 1.177938e-6;
    prepare(model, s, team);
    for (std::size_t i = 0; i < s.grains.size(); ++i)
      s.grains.motion[i].velocity = 1e-6 * (random_rotation(3, i) * Vec3(1, 0, 0));
    const double before = kinetic_energy(s.grains);
    run_steps(model, s, 400, team);
    if (part < 1)
      CHECK(kinetic_energy(s.grains) < 40 * before);
    else
      CHECK(kinetic_energy(s.grains) > 1e3 * before);
  }
}

TEST_CASE("packings have the density asked for, no overlap beyond the bound, and the lattices their boxes") {
  const Vec3 box = Vec3::Constant(4e-3);
  for (bool periodic : {false, true}) {
    const Packing p = random_packing(box, {"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4}, 0.55, 0, periodic, 7);
    double solid = 0, worst = 0;
    for (std::size_t i = 0; i < p.spheres.size(); ++i) {
      solid += 4 * pi / 3 * std::pow(p.spheres[i].radius, 3);
      for (std::size_t j = 0; j < i; ++j) {
        Vec3 d = p.spheres[i].position - p.spheres[j].position;
        if (periodic)
          for (int k = 0; k < 3; ++k) d[k] -= box[k] * std::round(d[k] / box[k]);
        worst = std::max(worst, (p.spheres[i].radius + p.spheres[j].radius - d.norm()) /
                                    std::min(p.spheres[i].radius, p.spheres[j].radius));
      }
      if (!periodic)
        for (int k = 0; k < 3; ++k)
          worst = std::max({worst, 1 - p.spheres[i].position[k] / p.spheres[i].radius,
                            1 - (box[k] - p.spheres[i].position[k]) / p.spheres[i].radius});
    }
    CHECK(solid / box.prod() == Approx(0.55).epsilon(1e-9));
    CHECK(worst < 1e-6);
  }
  const Packing hcp = hexagonal_close(3e-4, {10, 10, 10});
  CHECK(hcp.box.x() == Approx(6.300e-3).epsilon(1e-4));
  CHECK(hcp.box.y() == Approx(5.4497e-3).epsilon(1e-4));
  CHECK(hcp.box.z() == Approx(5.0091e-3).epsilon(1e-4));
  CHECK(1000 * 2.65 * 4 * pi / 3 * std::pow(0.3, 3) / (hcp.box.prod() * 1e9) == Approx(1.7427).epsilon(1e-3));
  const Packing sc = simple_cubic(3e-4, {10, 10, 10});
  CHECK(1000 * 2.65 * 4 * pi / 3 * std::pow(0.3, 3) / (sc.box.prod() * 1e9) == Approx(1.3875).epsilon(1e-3));
}

TEST_CASE(
    "dense packings: the densest of a wide grading, the same with any threads, refused with the density reached, "
    "stopped when asked") {
  const RadiusDistribution wide{"uniform", 2.5e-4, 0, 1e-4, 4e-4};
  const Vec3 box = Vec3::Constant(3.6e-3);
  Team one(1), two(2);
  const Packing p = random_packing(box, wide, 0.66, 0, Container::periodic, 3, two, {});
  double solid = 0, worst = 0;
  for (const auto& s : p.spheres) solid += 4 * pi / 3 * std::pow(s.radius, 3);
  CHECK(solid / box.prod() == Approx(0.66).epsilon(1e-9));
  for (std::size_t i = 0; i < p.spheres.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = p.spheres[i].position - p.spheres[j].position;
      for (int k = 0; k < 3; ++k) d[k] -= box[k] * std::nearbyint(d[k] / box[k]);
      worst = std::max(worst, (p.spheres[i].radius + p.spheres[j].radius - d.norm()) /
                                  std::min(p.spheres[i].radius, p.spheres[j].radius));
    }
  CHECK(worst < 2e-6);
  // Radii change places: the grading is what was drawn.
  std::vector<double> drawn, placed;
  for (const auto& s :
       random_packing(std::cbrt(0.66 / 0.5) * box, wide, 0.5, p.spheres.size(), Container::periodic, 3, one, {})
           .spheres)
    drawn.push_back(s.radius);
  for (const auto& s : p.spheres) placed.push_back(s.radius);
  std::sort(drawn.begin(), drawn.end()), std::sort(placed.begin(), placed.end());
  for (std::size_t i = 0; i < drawn.size(); ++i)
    REQUIRE(placed[i] / drawn[i] == Approx(placed[0] / drawn[0]).epsilon(1e-3));
  const Packing again = random_packing(box, wide, 0.66, 0, Container::periodic, 3, one, {});
  REQUIRE(again.spheres.size() == p.spheres.size());
  for (std::size_t i = 0; i < p.spheres.size(); ++i)
    REQUIRE((again.spheres[i].position == p.spheres[i].position && again.spheres[i].radius == p.spheres[i].radius));
  std::string said;
  try {
    random_packing(Vec3::Constant(2e-3), {"constant", 3e-4, 0, 0, 0}, 0.7, 0, Container::periodic, 1, two, {});
  } catch (const InputError& e) {
    said = e.what();
  }
  double reached = 0;
  REQUIRE(std::sscanf(said.c_str(), "0.7: the densest random packing found of these grains in this box is %lf",
                      &reached) == 1);
  CHECK(reached > 0.6);
  CHECK(reached < 0.7);
  CHECK_THROWS_AS(
      random_packing(box, wide, 0.66, 0, Container::periodic, 3, two, [](double done) { return done < 0.01; }),
      Interrupted);
  CHECK_THROWS_AS(
      random_packing(Vec3::Constant(6e-4), {"constant", 2.9e-4, 0, 0, 0}, 0.4, 0, Container::periodic, 1, two, {}),
      InputError);
}

TEST_CASE("the densest packing does not depend on what is asked: one number is told, and what is told can be had") {
  const RadiusDistribution radius{"uniform", 3e-4, 0, 2.2e-4, 3.8e-4};
  const Vec3 box = Vec3::Constant(2e-3);
  Team one(1);
  const auto asked = [&](double fraction) {
    return random_packing(box, radius, fraction, 0, Container::box, 1, one, {});
  };
  const auto told = [&](double fraction) {
    double reached = 0;
    try {
      asked(fraction);
    } catch (const InputError& e) {
      const std::string said = e.what();
      std::sscanf(said.substr(said.find(':')).c_str(),
                  ": the densest random packing found of these grains in this box is %lf", &reached);
    }
    return reached;
  };
  const double densest = told(0.6);
  CHECK(densest > 0.5);
  CHECK(told(0.56) == densest);
  CHECK(told(0.9) == densest);
  for (const double fraction : {0.51, densest}) {
    const Packing p = asked(fraction);
    double solid = 0, worst = 0;
    for (std::size_t i = 0; i < p.spheres.size(); ++i) {
      const Sphere& s = p.spheres[i];
      solid += 4 * pi / 3 * std::pow(s.radius, 3);
      for (int k = 0; k < 3; ++k)
        worst = std::max({worst, s.radius - s.position[k], s.position[k] + s.radius - box[k]});
      for (std::size_t j = 0; j < i; ++j)
        worst = std::max(worst, s.radius + p.spheres[j].radius - (s.position - p.spheres[j].position).norm());
    }
    CHECK(solid / box.prod() == Approx(fraction).epsilon(1e-9));
    CHECK(worst < 1e-6 * 2.2e-4);
  }
}
