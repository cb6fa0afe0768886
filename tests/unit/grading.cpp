// SPDX-License-Identifier: LGPL-3.0-or-later
// Grading, breakage indices and shapes against closed forms.
#include "dem/rve/grading.hpp"
#include "dem/packing/packing.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

State spheres(const std::vector<double>& diameters) {
  State s;
  for (std::size_t i = 0; i < diameters.size(); ++i)
    add(s, PolyEllipsoid::sphere(0.5 * diameters[i]), Vec3(static_cast<double>(i), 0, 0), 1000);
  return s;
}

}  // namespace

TEST_CASE("passing, percentiles and the mean logarithm of a few spheres are those done by hand") {
  const State s = spheres({1e-3, 2e-3, 2e-3});  // masses 1 : 8 : 8
  const Grading g(s);
  CHECK(g.passing(0.999e-3) == 0);
  CHECK(g.passing(1.001e-3) == Approx(1.0 / 17).epsilon(1e-12));
  CHECK(g.passing(2.001e-3) == Approx(1).epsilon(1e-12));
  CHECK(g.diameter(0.5) == Approx(2e-3).epsilon(1e-6));
  CHECK(g.mean_log(2e-3) == Approx(std::log(2.0) / 17).epsilon(1e-9));
  CHECK(g.hardin_potential() == Approx((std::log10(1e-3 / 74e-6) + 16 * std::log10(2e-3 / 74e-6)) / 17).epsilon(1e-9));
  CHECK(einav_breakage(g, g) == 0);
  CHECK(hardin_breakage(g, g) == Approx(0).margin(1e-15));
}

TEST_CASE("fines are a fractal: its dimension is found, and a sample of nothing else has Einav's breakage 1") {
  for (double dimension : {2.2, 2.6}) {
    const State first = spheres({1e-3});
    State ground = spheres({1e-7});  // next to nothing is left whole
    const double top = std::exp2(std::round(8 * std::log2(1e-3)) / 8);
    add_fines(ground.ledger.fines, 1e-3, 0, dimension, 1e-3);
    const Grading a(first), b(ground);
    CHECK(b.fines_fraction() == Approx(1).epsilon(1e-9));
    CHECK(b.passing(0.1 * top) == Approx(std::pow(0.1, 3 - dimension)).epsilon(1e-6));
    CHECK(b.fractal_dimension() == Approx(dimension).epsilon(1e-6));
    CHECK(b.mean_log(top) == Approx(1 / (3 - dimension)).epsilon(1e-6));
    // Classes of an eighth of an octave place the top within 4.4 %, of an area of 1/(3 - D).
    CHECK(einav_breakage(a, b, dimension) == Approx(1).margin(0.045 * (3 - dimension)));
    // Hardin: integral of log10(x / 74 um) over x from there to the top, mass (x / top)^(3 - D).
    double integral = 0;
    const int n = 20000;
    const double k = 3 - dimension, low = std::pow(74e-6 / top, k);
    for (int i = 0; i < n; ++i)
      integral += (1 - low) / n * std::log10(top * std::pow(low + (1 - low) * (i + 0.5) / n, 1 / k) / 74e-6);
    CHECK(b.hardin_potential() == Approx(integral).epsilon(1e-4));
  }
}

TEST_CASE("fines of two materials keep their own dimensions, and the fractal dimension begins at the 2 % size") {
  State two = spheres({1e-3, 2e-3});
  add_fines(two.ledger.fines, 1e-4, 0, 2.0, 1e-6);
  add_fines(two.ledger.fines, 1e-4, 0, 2.8, 3e-6);
  REQUIRE(two.ledger.fines.classes.size() == 2);
  const double top = std::exp2(std::round(8 * std::log2(1e-4)) / 8);
  const Grading g(two);
  CHECK(g.passing(0.1 * top) * total_mass(two.grains) / g.passing(1.01 * top) ==
        Approx((0.1 * 0.1e1 + 3 * std::pow(0.1, 0.2)) / 4 * total_mass(two.grains)).epsilon(1e-9));
  // A sample that is one fractal, 8 % of it fines, its grains placed where the fractal passes by their middle.
  State s;
  const double D = 2.5, largest = 1e-3, fines = 0.08;
  const int n = 4000;
  double x = 0;
  for (int k = 0; k < n; ++k) {
    const double d = largest * std::pow(fines + (1 - fines) * (k + 0.5) / n, 1 / (3 - D));
    add(s, PolyEllipsoid::sphere(0.5 * d), Vec3(x += largest, 0, 0), 1 / (d * d * d));  // all of one mass
  }
  const double d0 = largest * std::pow(fines, 1 / (3 - D));
  add_fines(s.ledger.fines, d0, 0, D, total_mass(s.grains) * fines / (1 - fines));
  CHECK(Grading(s).fractal_dimension() == Approx(D).margin(0.02));  // the class' top is within 4.4 % of d0
}

TEST_CASE("fines with a smallest size: passing, mean logarithm and Hardin's potential by integration") {
  // Ciantia et al. (2015), eq 12 and figure 2, in classes of an eighth of an octave: between 0.1 and 0.5 mm.
  State s = spheres({1e-9});
  const double smallest = 1e-4, D = 2.6, top = std::exp2(std::round(8 * std::log2(5e-4)) / 8);
  add_fines(s.ledger.fines, 5e-4, smallest, D, 1.0);
  const Grading g(s);
  const auto passing = [&](double d) {
    return (std::pow(d, 0.4) - std::pow(smallest, 0.4)) / (std::pow(top, 0.4) - std::pow(smallest, 0.4));
  };
  CHECK(g.passing(2e-4) == Approx(passing(2e-4)).epsilon(1e-9));
  CHECK(g.passing(3e-4) == Approx(passing(3e-4)).epsilon(1e-9));
  CHECK(g.passing(0.999e-4) < 1e-9);
  double log_mean = 0, hardin = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {  // midpoint of the mass, size by inverting eq 12
    const double low = std::pow(smallest, 0.4), span = std::pow(top, 0.4) - low;
    const double d = std::pow(low + span * (i + 0.5) / n, 2.5);
    log_mean += std::log(1e-3 / d) / n;
    hardin += std::max(0.0, std::log10(d / 1.5e-4)) / n;
  }
  CHECK(g.mean_log(1e-3) == Approx(log_mean).epsilon(1e-6));
  CHECK(g.hardin_potential(1.5e-4) == Approx(hardin).epsilon(1e-6));
}

TEST_CASE("Zingg's classes: a ball, a disc, a rod and a blade") {
  for (const auto& [widths, which] :
       std::vector<std::pair<Vec3, int>>{{{1, 1, 1}, 0}, {{1, 0.9, 0.4}, 1}, {{1, 0.5, 0.45}, 2}, {{1, 0.6, 0.3}, 3}}) {
    State s;
    PolyEllipsoid shape;
    shape.plus = Vec3(0.3 * widths[1], 0.5 * widths[0], 0.8 * widths[2]);  // order and centre must not matter
    shape.minus = Vec3(0.7 * widths[1], 0.5 * widths[0], 0.2 * widths[2]);
    add(s, shape, Vec3::Zero(), 1000);
    const Zingg z = zingg(s.grains);
    const double classes[4] = {z.equant, z.disc, z.rod, z.blade};
    for (int k = 0; k < 4; ++k) CHECK(classes[k] == Approx(k == which ? 1 : 0).margin(1e-12));
    CHECK(z.elongation == Approx(widths[1] / widths[0]).epsilon(1e-12));
    CHECK(z.flatness == Approx(widths[2] / widths[1]).epsilon(1e-12));
  }
}

TEST_CASE("size classes count every grain once, with its contacts") {
  const Model model = model_of(solid(60e9, 0.2, 1000));
  State s = spheres({1.0, 2.0, 4.0});
  s.grains.motion[1].position = Vec3(1.49, 0, 0);  // touches the first
  s.grains.motion[2].position = Vec3(100, 0, 0);
  Team team(1);
  prepare(model, s, team);
  const auto classes = size_classes(s, 0.7, 5.6, 3);
  REQUIRE(classes.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(classes[k].grains == 1);
  CHECK(classes[0].coordination == 1);
  CHECK(classes[1].coordination == 1);
  CHECK(classes[2].coordination == 0);
  CHECK(classes[2].upper == Approx(5.6).epsilon(1e-12));
}

TEST_CASE("roundness of a sample is that of its mass") {
  State s;
  add_body(s, box_between(Vec3::Constant(-0.5), Vec3::Constant(0.5)), Vec3::Zero(), Quat::Identity());
  add_body(s, box_between(Vec3(-2, -0.5, -2), Vec3(2, 0.5, 2)), Vec3(9, 0, 0), Quat::Identity());
  const double mass = 17;
  const Roundness cube = roundness(s.grains, 0), plate = roundness(s.grains, 1), all = roundness(s.grains);
  REQUIRE(cube.sphericity > plate.sphericity + 0.1);
  CHECK(all.sphericity == Approx((cube.sphericity + 16 * plate.sphericity) / mass).epsilon(1e-12));
  CHECK(all.angularity == Approx((cube.angularity + 16 * plate.angularity) / mass).epsilon(1e-12));
}

TEST_CASE("a class of a sieve curve: even in log r by mass, so r^-4 by number") {
  RadiusDistribution d;
  d.kind = "sieve", d.sieve = {{1, 0}, {2, 0.25}, {3, 1}};
  const SieveClass first = sieve_class(d, 0), second = sieve_class(d, 1);
  // Integrals of r^-4 and r^-3 from 1 to 2, and from 2 to 3.
  CHECK(first.mean == Approx(9.0 / 7).epsilon(1e-12));
  CHECK(second.mean == Approx(1.5 * (1.0 / 4 - 1.0 / 9) / (1.0 / 8 - 1.0 / 27)).epsilon(1e-12));
  CHECK(first.number == Approx(0.25 / std::log(2.0) * 7 / 24).epsilon(1e-12));
  CHECK(d.mean_cube() == Approx(1 / (first.number + second.number)).epsilon(1e-12));
}

TEST_CASE("a sample whose slope changes in the middle: the fractal dimension is fitted from the 2 % to the 60 % size") {
  // Mass even in log d below d20, of slope 1.5 above; by the same points as a fit of ln passing over ln d.
  State s;
  constexpr int n = 5000;
  const auto size_at = [](double p) {
    return p < 0.2 ? std::pow(p / 0.2, 2.0) : 1 + std::log(p / 0.2) / std::log(5.0);  // slopes 1/2, then steep
  };
  for (int k = 0; k < n; ++k) {
    const double d = size_at((k + 0.5) / n);
    add(s, PolyEllipsoid::sphere(0.5 * d), Vec3(3.0 * k, 0, 0), 1 / (d * d * d));
  }
  const double low = std::log(size_at(0.02)), high = std::log(size_at(0.6));
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  constexpr int points = 24;
  for (int k = 0; k < points; ++k) {
    const double x = low + (high - low) * k / (points - 1), d = std::exp(x);
    const double y = std::log(d < 1 ? 0.2 * std::sqrt(d) : 0.2 * std::pow(5.0, d - 1));
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  CHECK(Grading(s).fractal_dimension() == Approx(3 - (points * sxy - sx * sy) / (points * sxx - sx * sx)).margin(5e-3));
}

TEST_CASE("spheres that a draw has scaled must fit their cell as they are then, not as they were drawn") {
  // 41 grains of 1 m fill 0.298 of a cell 2.4 m wide; they need 2 m of it, each as scaled, and 0.4 m for the list.
  const Vec3 box(2.4, 2.4, 100);
  const auto packed = [&](double scale) {
    const double fraction = 41 * 4 * pi / 3 * std::pow(scale, 3) / box.prod();
    return random_packing(box, {"constant", 1, 0, 1, 1}, fraction, 41, true, 1);
  };
  CHECK_THROWS_WITH(packed(1.015), Catch::Contains("smaller than its largest grain (2.03 m across)"));
  const Packing small = packed(0.985);
  REQUIRE(small.spheres.size() == 41);
  for (const auto& s : small.spheres) CHECK(s.radius == Approx(0.985).epsilon(1e-9));
  CHECK_THROWS_WITH(packed(1.021), Catch::Contains("41 grains of this size fill 0.298 of the box"));
  CHECK_THROWS_WITH(packed(0.979), Catch::Contains("41 grains of this size fill 0.298 of the box"));
}

TEST_CASE("the part of a packing that is done is told to the end, of one that must be shaken, too") {
  Team team(1);
  std::vector<double> told;
  random_packing(Vec3::Constant(8), {"constant", 1, 0, 1, 1}, 0.62, 0, Container::periodic, 1, team, [&](double done) {
    told.push_back(done);
    return true;
  });
  CHECK(told.size() > 21000);  // it was shaken
  CHECK((*std::min_element(told.begin(), told.end()) >= 0 && *std::max_element(told.begin(), told.end()) < 1));
  CHECK(static_cast<double>(std::count(told.begin(), told.end(), 0.999)) < 0.01 * static_cast<double>(told.size()));
}
