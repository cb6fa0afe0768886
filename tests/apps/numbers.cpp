// SPDX-License-Identifier: LGPL-3.0-or-later
// Numbers that users read or write: units, defaults, error estimates, gradings over a test.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "apps/rve/error_estimates.hpp"
#include "apps/rve/gradings.hpp"
#include "apps/rve/step_told.hpp"
#include "apps/scene/rve_scene.hpp"
#include "apps/scene/units.hpp"
#include "dem/base/text_file.hpp"
#include "dem/contact/forces.hpp"
#include "dem/packing/packing.hpp"
#include "dem/packing/sphere_files.hpp"
#include "dem/rve/loading.hpp"
#include "dem/sample/make.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::Scratch;
using namespace grus::dem::test;
using grus::dem::Mat3, grus::dem::Vec3, grus::dem::State, grus::dem::Model, grus::dem::PolyEllipsoid, grus::dem::Team,
    grus::dem::Wall, grus::dem::PlaneWall, grus::dem::pi;

namespace {

std::vector<std::vector<double>> rows_of(const std::string& file) {
  std::ifstream in(file);
  std::string line, cell;
  std::getline(in, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(in, line)) {
    rows.emplace_back();
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

}  // namespace

TEST_CASE("a quantity is its number in SI units, with prefixes above and under the stroke, and powers") {
  struct Row {
    const char* text;
    Dimension dimension;
    double value;
  };
  for (const Row& r : {Row{"0.3 mm", dimension::length, 3e-4},
                       Row{"7 um", dimension::length, 7e-6},
                       Row{"2.65 g/cm^3", dimension::density, 2650},
                       Row{"2650 kg/m^3", dimension::density, 2650},
                       Row{"2.65e-3 kg/cm^3", dimension::density, 2650},
                       Row{"1.77 MPa m^0.5", dimension::toughness, 1.77e6},
                       Row{"3 mm/ms", dimension::speed, 3},
                       Row{"3 um/us", dimension::speed, 3},
                       Row{"2 1/ms", dimension::rate, 2000},
                       Row{"5 kN/mm", dimension::stiffness, 5e6},
                       Row{"60 GPa", dimension::pressure, 60e9},
                       Row{"6 kN/cm^2", dimension::pressure, 6e7},
                       Row{"2 bar", dimension::pressure, 2e5},
                       Row{"1.5 min", dimension::time, 90},
                       Row{"30 deg", dimension::angle, pi / 6},
                       Row{"30°", dimension::angle, pi / 6},
                       Row{"0.5", dimension::angle, 0.5},
                       Row{"20 deg/s", dimension::rate, pi / 9},
                       Row{"2650 kg/m3", dimension::density, 2650},
                       Row{"2.65 g/cm3", dimension::density, 2650},
                       Row{"2.65 g cm-3", dimension::density, 2650},
                       Row{"2650 kg/m³", dimension::density, 2650},
                       Row{"120 N/mm2", dimension::pressure, 120e6},
                       Row{"9.81 m/s2", dimension::acceleration, 9.81},
                       Row{"10 TPa/m", dimension::foundation, 1e13},
                       Row{"12 %", dimension::none, 0.12},
                       Row{"7 cm^2", dimension::area, 7e-4},
                       Row{"3 mg", dimension::mass, 3e-6},
                       Row{"9.81 m/s^2", dimension::acceleration, 9.81},
                       Row{"4 mm/ms^2", dimension::acceleration, 4e3},
                       Row{"145.03773773020923 psi", dimension::pressure, 1e6},
                       Row{"8.702264263812553 ksi", dimension::pressure, 6e7},
                       Row{"300 \u00b5m", dimension::length, 3e-4},  // the micro sign
                       Row{"300 \u03bcm", dimension::length, 3e-4},  // the Greek letter
                       Row{"3 m/\u00b5s", dimension::speed, 3e6},
                       Row{"36 km/h", dimension::speed, 10},
                       Row{"1.5 h", dimension::time, 5400},
                       Row{"4 kg/m s^-2", dimension::pressure, 4},  // what follows a divisor multiplies again
                       Row{"4 N/mm cm^-1", dimension::pressure, 4e5},
                       Row{"250", dimension::pressure, 250}}) {
    INFO(r.text);
    CHECK(parse_quantity(r.text, r.dimension).value == Approx(r.value).epsilon(1e-12));
  }
  // A bound is told in the unit of the number that it bounds.
  const auto bound = [](double si, const char* text, const Dimension& d) {
    return bound_text(si, parse_quantity(text, d), d);
  };
  CHECK(bound(0.49 * pi, "89.9 deg", dimension::angle) == "88.2 deg");
  CHECK(bound(0.49 * pi, "1.57", dimension::angle) == "1.53938 rad (88.2 deg)");
  CHECK(bound(3e-4, "0.2 mm", dimension::length) == "0.3 mm");
  CHECK(bound(3e-4, "0.0002", dimension::length) == "0.0003 m");
  CHECK(bound(6e7, "70 MPa", dimension::pressure) == "60 MPa");
  CHECK(bound(0.5, "60 %", dimension::none) == "50 %");
  CHECK(bound(0.5, "0.6", dimension::none) == "0.5");
  CHECK(bound(0, "-1 deg", dimension::angle) == "0");
  CHECK_THROWS_AS(parse_quantity("3 mm", dimension::time), std::invalid_argument);
  CHECK_THROWS_AS(parse_quantity("3 g/cm^2", dimension::density), std::invalid_argument);
  CHECK_THROWS_AS(parse_quantity("3 parsec", dimension::length), std::invalid_argument);
  CHECK_THROWS_AS(parse_quantity("3 m2", dimension::length), std::invalid_argument);
  CHECK_THROWS_WITH(parse_quantity("30 deg", dimension::none), Catch::Contains("angle where a number"));
  CHECK_THROWS_WITH(parse_quantity("5 %", dimension::angle), Catch::Contains("no unit of an angle"));
  CHECK_THROWS_WITH(parse_quantity("72,5 MPa", dimension::pressure), Catch::Contains("decimal point"));
}

TEST_CASE("the size effect that nobody names is three over Weibull's modulus") {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  auto exponent = [&](const std::string& more) {
    std::ofstream(file)
        << "[material.m]\nyoungs_modulus = 1e9\ndensity = 2000.0\n[material.m.fracture]\nmodel = "
           "\"polyellipsoid-split\"\n"
           "hoek_brown = { compressive_strength = 1e8, m = 20 }\nweibull = { modulus = 4.2, reference_radius = 1e-3" +
               more +
               " }\n[[grain]]\nshape = \"sphere\"\nradius = 1e-3\nposition = [0, 0, 0]\nmaterial = "
               "\"m\"\n[boundary]\nkind = "
               "\"open\"\n[loading]\nkind = \"free\"\nduration = 1e-3\n";
    const auto scene = read_rve_scene(file, {});
    return std::get<grus::dem::Weibull>(scene.model.materials[0].fracture->strength_law).size_exponent;
  };
  CHECK(exponent("") == Approx(3 / 4.2).epsilon(1e-14));
  CHECK(exponent(", size_exponent = 0.5") == 0.5);
}

TEST_CASE("error estimates are of the last row and of the worst, and each is what its name says") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team team(1);
  const double r = 1e-3, size = 3.98e-3;
  auto box = [&](double deeper) {
    State s;
    for (int i = 0; i < 8; ++i)
      add(s, PolyEllipsoid::sphere(r),
          Vec3(0.25 + 0.5 * (i & 1), 0.25 + 0.5 * (i >> 1 & 1), 0.25 + 0.5 * (i >> 2)) * size, 2650);
    add_box(s, size);
    s.boundary.walls[5].point.z() -= deeper;
    prepare(model, s, team);
    s.grain_steps = 20 * 8;  // before that no energy error is told
    return s;
  };
  State even = box(0), uneven = box(1e-5);
  ErrorEstimates e;
  uneven.ledger.work = 0.3 * stored_energy(model, uneven);  // not accounted for
  even.ledger.work = -0.1 * stored_energy(model, even);
  State early = uneven;
  --early.grain_steps, early.ledger.work *= 3;
  dem::SurveyRoom room;
  e.add(early, {}, survey(model, early, team, room));
  for (const State* s : {&even, &uneven, &even}) e.add(*s, {}, survey(model, *s, team, room));
  const auto json = e.json(even);
  CHECK(json["worst_energy_error"] == Approx(0.3).epsilon(1e-9));
  CHECK(e.energy.last == Approx(0.1).epsilon(1e-9));
  // Between grains twice 0.005 r, at a wall half of that; the lid of the uneven box adds its way.
  CHECK(e.overlap.last == Approx(0.01).epsilon(1e-6));
  CHECK(e.overlap.worst == Approx(std::max(0.01, 0.005 + 1e-5 / r)).epsilon(1e-6));
  CHECK(e.unbalanced.worst == Approx(measure(model, uneven).unbalanced_force).epsilon(1e-12));
  CHECK(e.unbalanced.worst > e.unbalanced.last);
  const auto m = measure(model, uneven);
  const double wall = m.wall_stress.trace() / 3, cell = m.stress.trace() / 3;
  CHECK(e.wall_minus_cell.worst >= std::abs(wall - cell) / std::max(std::abs(wall), e.largest_wall) * (1 - 1e-12));
  CHECK(e.largest_wall == Approx(std::abs(wall)).epsilon(1e-12));
  CHECK(e.wall_minus_cell.last < e.wall_minus_cell.worst);
  CHECK(e.pressure_scatter.last < 1e-9);  // all grains alike
  // Two grains between the same platens, one pressed deeper: standard error of a mean of two shares, force times arm at
  // both ends.
  State two;
  for (const double more : {0.0, 1e-6}) add(two, PolyEllipsoid::sphere(r + more), Vec3(1e4 * more, 0, 0), 2650);
  for (const double side : {-1.0, 1.0}) {
    Wall platen;
    platen.material = 1, platen.shape = PlaneWall{Vec3(0, 0, -side)}, platen.point = Vec3(0, 0, side * (r - 1e-6));
    two.boundary.walls.push_back(platen);
  }
  prepare(model, two, team);
  double share[2];
  for (int k = 0; k < 2; ++k) {
    const double radius = r + 1e-6 * k, depth = 1e-6 * (1 + k);
    share[k] = 2 * 4.0 / 3 * reduced_modulus(model.pairs[1]) * std::sqrt(radius) * std::pow(depth, 1.5) *
               (radius - 0.5 * depth);
  }
  const double mean = 0.5 * (share[0] + share[1]), deviation = (share[1] - share[0]) / std::sqrt(2.0);  // n - 1 = 1
  CHECK(survey(model, two, team, room).pressure_scatter == Approx(deviation / std::sqrt(2.0) / mean).epsilon(1e-9));
}

TEST_CASE("what a row asks of many contacts at once is what each of them says, for any number of threads") {
  const Model model = model_of(solid(60e9, 0.2, 2650));
  Team one(1), two(2);
  State s;
  for (int i = 0; i < 18; ++i)
    for (int j = 0; j < 18; ++j)
      for (int k = 0; k < 18; ++k)
        add(s, PolyEllipsoid::sphere(1e-3 * (1 + 1e-3 * ((3 * i + 5 * j + 7 * k) % 11))), 1.99e-3 * Vec3(i, j, k), 2650,
            1e-3 * Vec3(i % 3, j % 5, k % 7));
  s.boundary.cell.vectors = 1.99e-3 * 18 * Mat3::Identity();
  prepare(model, s, one);
  REQUIRE(s.contacts.size() > 16384);
  dem::SurveyRoom room;
  const dem::Survey now = survey(model, s, one, room), again = survey(model, s, two, room);
  CHECK((now.stress - dem::love_weber(s, now.volume)).norm() < 1e-12 * now.stress.norm());
  CHECK(now.elastic == Approx(elastic_energy(model.law, s.contacts)).epsilon(1e-12));
  CHECK(now.kinetic == Approx(kinetic_energy(s.grains)).epsilon(1e-12));
  CHECK(now.solid_fraction == Approx(solid_volume(s.grains) / now.volume).epsilon(1e-12));
  const dem::DeepestContact deepest = dem::deepest_contact(s.grains, s.contacts);
  CHECK((now.deepest.ratio == deepest.ratio && now.deepest.pair == deepest.pair));
  std::size_t touching = 0, last = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) ++touching, last = k;
  for (std::size_t k : {std::size_t{0}, std::size_t{8191}, std::size_t{8192}, last}) {  // sums are of 8,192 contacts
    while (!s.contacts.contact.touching(k)) ++k;
    State one_deep = s;
    one_deep.contacts.touch[k].overlap = 1e-4;
    CHECK(survey(model, one_deep, two, room).deepest.pair == k);
  }
  CHECK(now.contacts == touching);
  CHECK(now.coordination == Approx(2.0 * static_cast<double>(touching) / 5832));
  CHECK(std::abs(now.fabric.trace() - 1) < 1e-12);
  CHECK((now.stress == again.stress && now.fabric == again.fabric && now.elastic == again.elastic));
  CHECK((now.kinetic == again.kinetic && now.pressure_scatter == again.pressure_scatter));
  CHECK(now.unbalanced_force == again.unbalanced_force);
}

TEST_CASE(
    "grading.csv: as many states as asked, evenly over the test, each class with what is finer and what its grains are "
    "like") {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file)
      << "[material.m]\nyoungs_modulus = 1e9\ndensity = 2000.0\n"
         "[[grain]]\nshape = \"sphere\"\nradius = 1e-3\nposition = [0, 0, 0]\nmaterial = \"m\"\n"
         "[[grain]]\nshape = \"sphere\"\nradius = 4e-3\nposition = [0, 0, 0.1]\nmaterial = \"m\"\n"
         "[boundary]\nkind = \"open\"\n[loading]\nkind = \"free\"\nduration = 0.3\n[output]\ngradings = 4\n";
  const RveScene scene = read_rve_scene(file, {});
  const Model model = scene.model;
  Team team(1);
  State s = dem::make(model, scene.recipe, team).state;
  const State start = s;
  prepare(model, s, team);
  GradingStates states(scratch.path, scene, start);
  for (int k = 0; k <= 30; ++k) s.time = 0.01 * k, states.write_if_due(s, s.time, 0);
  CHECK(states.written() == 4);
  const auto rows = rows_of(scratch.path + "/grading.csv");
  REQUIRE(rows.size() == 4 * 40);
  std::vector<double> times;
  for (std::size_t i = 0; i < rows.size(); i += 40) times.push_back(rows[i][0]);
  for (std::size_t k = 0; k < 4; ++k) CHECK(times[k] == Approx(0.1 * static_cast<double>(k)).margin(0.0101));
  const double small = 1.0 / 65;  // of the mass: 1 and 64
  double grains = 0, mass = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    const auto& r = rows[i];
    double finer = 0;
    if (r[2] >= 2e-3) finer = small;
    if (r[2] >= 8e-3) finer = 1;
    CHECK(r[3] == Approx(finer).margin(1e-6));
    grains += r[4], mass += r[5];
  }
  CHECK(grains == 2);
  CHECK(mass == Approx(2000 * 4 * pi / 3 * 65e-9).epsilon(1e-8));
  CHECK(rows[0][2] == Approx(2e-3 / 8).epsilon(0.15));  // the smallest class begins an eighth below the smallest grain
  CHECK(rows[39][2] == Approx(8e-3).epsilon(1e-5));
}

TEST_CASE(
    "a mixture has its shares of grains, the solid fraction that was asked for, and ellipsoids of the aspect said") {
  const Scratch folder;
  const std::string file = folder.path + "/mixture.toml";
  std::ofstream(file) << R"(
[material.sand]
density = 2650
youngs_modulus = "60 GPa"
[material.coal]
density = 1400
youngs_modulus = "2 GPa"
[packing]
kind = "random"
box = ["4 mm", "4 mm", "4 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.5
mixture = [ { material = "sand", share = 3 }, { material = "coal", share = 1, aspect = [1, 0.8, 0.6] } ]
[boundary]
kind = "periodic"
[loading]
kind = "free"
duration = "1 us"
)";
  const RveScene scene = read_rve_scene(file, {});
  Team team(2);
  State made = dem::make(scene.model, scene.recipe, team).state;
  const dem::Grains& g = made.grains;
  double solid = 0, mass = 0;
  std::size_t coal = 0;
  Vec3 axes = Vec3::Zero();
  for (std::size_t i = 0; i < g.size(); ++i) {
    const PolyEllipsoid& shape = g.shape[i];
    solid += 4 * pi / 3 * shape.plus.prod(), mass += g.mass[i];
    CHECK(shape.plus == shape.minus);
    CHECK(g.mass[i] == Approx((g.material[i] ? 1400 : 2650) * 4 * pi / 3 * shape.plus.prod()).epsilon(1e-12));
    if (g.material[i] == 0) {
      CHECK(dem::is_sphere(g, i));
      continue;
    }
    ++coal, axes += g.orientation[i] * Vec3::UnitX();
    CHECK(shape.plus.y() == Approx(0.8 * shape.plus.x()).epsilon(1e-12));
    CHECK(shape.plus.z() == Approx(0.6 * shape.plus.x()).epsilon(1e-12));
  }
  REQUIRE(g.size() > 400);
  CHECK(std::abs(static_cast<double>(coal) - 0.25 * static_cast<double>(g.size())) <= 1);
  CHECK(solid == Approx(0.5 * 64e-9).epsilon(1e-9));
  CHECK(axes.norm() < 3 * std::sqrt(static_cast<double>(coal)));  // directions of no preference: a random walk
  Team one(1);
  dem::prepare(scene.model, made, one);
  for (const auto& touch : made.contacts.touch) CHECK(touch.overlap < 1e-9);
}

TEST_CASE("a text file is the same text whatever mark and encoding its editor has given it") {
  const Scratch folder;
  const std::string path = folder.path + "/text";
  const std::string text = "1 \xC2\xB5m \xE2\x80\xA6 \xF0\x9D\x9C\x8E\r\n# end";  // 1 µm … 𝜎
  const std::vector<unsigned> units{'1',    ' ',  0xB5, 'm', ' ', 0x2026, ' ', 0xD835,
                                    0xDF0E, '\r', '\n', '#', ' ', 'e',    'n', 'd'};
  std::string little = "\xFF\xFE", big = "\xFE\xFF";
  for (const unsigned u : units) {
    const char low = static_cast<char>(u & 0xFF), high = static_cast<char>(u >> 8);
    little += low, little += high, big += high, big += low;
  }
  for (const std::string& bytes : {text, "\xEF\xBB\xBF" + text, little, big}) {
    std::ofstream(path, std::ios::binary) << bytes;
    std::stringstream read;
    read << dem::open_text(path)->rdbuf();
    CHECK(read.str() == text);
  }
  CHECK(dem::open_text(folder.path) == nullptr);
  for (const std::string head : {"", "\xEF\xBB\xBF"}) {
    std::ofstream(path, std::ios::binary) << head << "1e-3 2e-3 3e-3 5e-4\n";
    const dem::Packing packing = dem::read_spheres({path}).packing;
    REQUIRE(packing.spheres.size() == 1);
    CHECK((packing.spheres[0].position == Vec3(1e-3, 2e-3, 3e-3) && packing.spheres[0].radius == 5e-4));
  }
  std::ofstream(path, std::ios::binary) << "";
  CHECK(dem::open_text(path)->peek() == EOF);
}

TEST_CASE("a pressure that is told to be unbearable is some times what the densest lattice bears at the limit") {
  dem::Material sand = solid(10e9, 0.2, 2650);
  Model model = model_of(sand);
  const double R = 1e-3;
  for (const double limit : {0.05, 0.2}) {
    model.numerics.max_overlap = limit;
    // Twelve contacts of Hertz at a branch l = (2 - limit) R in the volume l^3 / sqrt(2): p = 12 F l / (2 x 3 V).
    const double l = (2 - limit) * R, E = 10e9 / (2 * (1 - 0.2 * 0.2));
    const double F = 4.0 / 3 * E * std::sqrt(R / 2) * std::pow(limit * R, 1.5), p = 2 * std::sqrt(2) * F / (l * l);
    const double told = dem::unbearable_pressure(model, R);
    CHECK((told > 2 * p && told < 5 * p));
    CHECK(dem::unbearable_pressure(model, 7 * R) == Approx(told).epsilon(1e-12));  // Hertz knows no size
  }
  model.numerics.max_overlap = 10;  // the voids are gone before
  CHECK(dem::unbearable_pressure(model, R) < 10e9);
  model.law = dem::Foundation{};
  CHECK(std::isinf(dem::unbearable_pressure(model, R)));
}

TEST_CASE("a step that has fallen by more than ten is told with the grain that sets it") {
  Team team(1);
  const Model model = dem::test::linear_model(1e6, 0, 2650, 0);
  State s;  // of two spheres between plates the small one is by far the faster
  dem::test::add(s, PolyEllipsoid::sphere(1e-3), Vec3(0, 0, 0.9999e-3), 2650);
  dem::test::add(s, PolyEllipsoid::sphere(1e-4), Vec3(0, 0, 2.0998e-3), 2650);
  dem::test::add_floor(s);
  prepare(model, s, team);
  StepTold told;
  const double first = s.dt;
  for (const double part : {1.0, 0.11, 0.5}) {
    s.dt = part * first, s.time += 1;
    told.add(model, s, 1, 1e5);
    CHECK(told.notes(false).empty());
  }
  s.dt = 0.09 * first, s.time += 1;
  told.add(model, s, 1, 1e5);
  const std::string from = fmt::format(
      "fallen from {:.3g} to {:.3g} s (t = 4 s): grain 1, diameter 0.0002 m, least "
      "width 0.0002 m, needs the short one as it is light",
      first, 0.09 * first);
  for (const bool by_step : {false, true}) {
    REQUIRE(told.notes(by_step).size() == 1);
    CHECK(told.notes(by_step)[0].find(from) != std::string::npos);
    CHECK((told.notes(by_step)[0].find("numerics.inertia.step") != std::string::npos) == !by_step);
  }
  const std::string solved = told.notes(false, true)[0];  // such steps know no lightest grain, and no inertia by step
  CHECK((solved.ends_with("changed too fast for longer steps") && solved.find("grain 1") == std::string::npos));
  told.inertial_number = 0.02;
  CHECK((told.notes(true).size() == 2 && told.notes(false).size() == 1));
}
