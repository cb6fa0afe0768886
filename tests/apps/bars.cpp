// SPDX-License-Identifier: LGPL-3.0-or-later
// What grus-bvp makes of its results, and of the time that it will take: bars read by their gauges, means of cells,
// probes; what a folder loses to them.
#include <fmt/format.h>
#include <fstream>
#include <sstream>

#include "apps/bvp/estimate.hpp"
#include "apps/bvp/hopkinson.hpp"
#include "apps/bvp/points.hpp"
#include "apps/bvp/probes.hpp"
#include "apps/run/command.hpp"
#include "apps/run/folder.hpp"
#include "fem/session.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/fem/boundaries.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double there = 1e-4, beyond = 6e-5, length = 8e-5,
                 peak = 1e-3;  // s from gauges to the specimen; of the pulse

Hopkinson steel() {
  Hopkinson h;
  h.bar_modulus = 200e9, h.bar_density = 8000, h.bar_area = 3e-4, h.specimen_area = 2e-4, h.specimen_length = 0.01;
  const double wave = std::sqrt(h.bar_modulus / h.bar_density);
  h.incident_distance = there * wave, h.transmitted_distance = beyond * wave;
  h.incident = "in", h.transmitted = "out", h.axis = 1;
  return h;
}

double pulse(double t) { return t > 0 && t < length ? peak * std::pow(std::sin(pi * t / length), 2) : 0; }

/// Incident gauge: the pulse, and half of it back as tension; transmitted gauge: 0.3 of it. Not in equilibrium, so that
/// the analyses differ.
std::array<GaugeSignal, 2> gauges() {
  std::array<GaugeSignal, 2> g;
  for (int k = 0; k <= 8000; ++k) {
    const double t = 1e-7 * k, arrival = 2e-5;
    for (auto& one : g) one.time.push_back(t);
    g[0].strain.push_back(pulse(t - arrival) - 0.5 * pulse(t - arrival - 2 * there));
    g[1].strain.push_back(0.3 * pulse(t - arrival - there - beyond));
  }
  return g;
}

}  // namespace

TEST_CASE("one-, two- and three-wave analysis of bars are the formulas of the laboratory") {
  const Hopkinson bar = steel();
  const auto [incident, transmitted] = gauges();
  const auto rows = analyse_hopkinson(bar, incident, transmitted);
  REQUIRE(rows.size() > 1000);
  const double wave = 5000, force = 200e9 * 3e-4 / 2e-4;
  double worst = 0, last = 0;
  for (const HopkinsonRow& r : rows) {
    const double e = pulse(r.time - 2e-5 - there);  // at the specimen's face
    worst = std::max({worst, std::abs(r.incident - e) / peak, std::abs(r.reflected + 0.5 * e) / peak,
                      std::abs(r.transmitted - 0.3 * e) / peak});
    worst = std::max({worst, std::abs(r.rate_1 / (2 * wave * 0.5 * peak / 0.01) - e / peak),
                      std::abs(r.rate_3 / (wave * 1.2 * peak / 0.01) - e / peak)});
    worst = std::max({worst, std::abs(r.stress_1 / (force * 0.3 * peak) - e / peak),
                      std::abs(r.stress_2 / (force * 0.5 * peak) - e / peak),
                      std::abs(r.stress_3 / (force * 0.4 * peak) - e / peak)});
    if (&r != &rows.front()) {  // strains are trapezoids of the rates
      const HopkinsonRow& before = *(&r - 1);
      REQUIRE(r.strain_1 - before.strain_1 ==
              Approx(0.5 * (r.rate_1 + before.rate_1) * (r.time - before.time)).epsilon(1e-6).margin(1e-12));
      REQUIRE(r.strain_3 - before.strain_3 ==
              Approx(0.5 * (r.rate_3 + before.rate_3) * (r.time - before.time)).epsilon(1e-6).margin(1e-12));
    }
    last = r.time;
  }
  CHECK(worst < 1.5e-2);  // where waves are told apart, at a hundredth of the peak
  CHECK(last > 2e-5 + there + length);
  // Mean of sin^2 is a half.
  CHECK(rows.back().strain_1 == Approx(wave * peak / 0.01 * length / 2).epsilon(2e-3));
  CHECK(rows.back().strain_3 == Approx(1.2 * wave * peak / 0.01 * length / 2).epsilon(2e-3));
}

TEST_CASE(
    "hopkinson.csv: gauges are tension-positive in history.csv and compression-positive here; the specimen's own "
    "beside them") {
  const auto [incident, transmitted] = gauges();
  std::string history =
      "increment,time_s,probe_in_strain_yy,probe_out_strain_yy,grains_strain_yy,grains_stress_yy_Pa\n";
  for (std::size_t k = 0; k < incident.time.size(); ++k)
    history += fmt::format("{},{:.17g},{:.12g},{:.12g},{:.12g},{:.12g}\n", k, incident.time[k], -incident.strain[k],
                           -transmitted.strain[k], -0.5 * incident.time[k], -7e6);
  const app::test::Scratch scratch;
  const std::string path = scratch.path + "/hopkinson.csv";
  write_hopkinson(path, steel(), history);
  std::ifstream in(path);
  std::string line, cell;
  std::getline(in, line);
  CHECK(line ==
        "time_s,incident_strain,reflected_strain,transmitted_strain,rate_1wave,strain_1wave,stress_1wave_Pa,stress_"
        "2wave_Pa,rate_3wave,strain_3wave,stress_"
        "3wave_Pa,"
        "specimen_strain,specimen_stress_Pa");
  const auto rows = analyse_hopkinson(steel(), incident, transmitted);
  std::size_t at = 0;
  for (; std::getline(in, line); ++at) {
    std::vector<double> v;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) v.push_back(std::stod(cell));
    REQUIRE(v.size() == 13);
    const HopkinsonRow& r = rows.at(at);
    const double expected[13] = {r.time,     r.incident,   r.reflected, r.transmitted, r.rate_1,
                                 r.strain_1, r.stress_1,   r.stress_2,  r.rate_3,      r.strain_3,
                                 r.stress_3, 0.5 * r.time, 7e6};
    const double round_off[13] = {1e-14, 1e-10, 1e-10, 1e-10, 1e-3, 1e-8, 10, 10, 1e-3, 1e-8, 10, 1e-12, 1};
    for (std::size_t k = 0; k < 13; ++k) REQUIRE(v[k] == Approx(expected[k]).epsilon(1e-6).margin(round_off[k]));
  }
  CHECK(at == rows.size());
}

TEST_CASE("a cell of the macro frame has the means of its points with grains, and nothing where there are none") {
  std::vector<dem::Facts> facts(3);
  facts[0].void_ratio = 0.6, facts[0].grains = 120, facts[0].breakages = 20;
  facts[1].void_ratio = 0.8, facts[1].grains = 100, facts[1].breakages = 0;
  facts[2].void_ratio = 0.5, facts[2].grains = 200, facts[2].breakages = 100;
  const auto of = [&](std::size_t k) -> const dem::Facts& { return facts[k]; };
  const auto cells = element_means({0, 1, SIZE_MAX, 2, SIZE_MAX, SIZE_MAX}, 2, of);
  REQUIRE(cells.size() == 9);
  CHECK(cells[0] == Approx(0.7));
  CHECK(cells[1] == Approx(0.1));  // 20 of 100 that were there, and none
  CHECK(cells[2] == Approx(110));
  CHECK(cells[3] == Approx(0.5));
  CHECK(cells[4] == Approx(1));
  CHECK(cells[5] == Approx(200));
  for (int k = 6; k < 9; ++k) CHECK(std::isnan(cells[static_cast<std::size_t>(k)]));
}

TEST_CASE("stresses of the ground in classes: no member further off than the tolerance, single ones as they are") {
  std::vector<Start> starts;
  for (const double v : {100.0, 101.0, 102.0, 102.1, 150.0}) starts.push_back({0, true, {0.5 * v, v, 0.5 * v}});
  starts.push_back({1, true, {50.5, 101, 50.5}});  // another packing
  const auto each = stress_classes(starts, 0);
  REQUIRE(each.size() == starts.size());
  for (std::size_t k = 0; k < starts.size(); ++k) CHECK((each[k].start == starts[k] && each[k].deviation == 0));
  const auto classes = stress_classes(starts, 0.01);  // 100 to 102 are 1/101 off their middle, 2 * 100 * 102 / 202
  REQUIRE(classes.size() == 4);
  CHECK(classes[0].members == 3);
  CHECK(classes[0].start.stress[1] == Approx(2 * 100 * 102 / 202.0).epsilon(1e-14));
  CHECK(classes[0].start.stress[0] == Approx(100 * 102 / 202.0).epsilon(1e-14));
  CHECK(classes[0].deviation == Approx(1 / 101.0).epsilon(1e-12));
  CHECK((classes[1].start == starts[3] && classes[2].start == starts[4] && classes[3].start == starts[5]));
  CHECK(stress_classes({{0, false, {}}}, 0.01).size() == 1);
}

TEST_CASE("the ground bears its surcharge and what lies above it, across its axis k0 of that; above its surface none") {
  BvpScene scene;
  scene.low = {-3, -7, -5}, scene.high = {3, 4, 7};
  const double density = 1600, gravity = 9.81, k0 = 0.45, surcharge = 3e3, surface = 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    scene.gravity = {}, scene.gravity[axis] = -gravity;
    scene.ground = Ground{k0, surface, surcharge, static_cast<int>(axis), 0};
    for (const double height : {-2.3456, 0.1234, 2.98765, 3.0, 3.7}) {
      fem::Point at{0.3, 0.2, 0.1};
      at[axis] = height;
      const double vertical = surcharge + density * gravity * std::max(0.0, surface - height);
      const auto stress = ground_stress(scene, at, density);
      // Depths are told apart by a millionth of the mesh.
      const double grain = density * gravity * 0.5e-6 * (scene.high[axis] - scene.low[axis]);
      for (std::size_t k = 0; k < 6; ++k) {
        const double expected = k > 2 ? 0 : k == axis ? -vertical : -k0 * vertical;
        CHECK(stress[k] == Approx(expected).epsilon(1e-12).margin(1.01 * grain));
      }
    }
  }
}

TEST_CASE("a probe tells its point, of equally near ones the first, and a place the means of its points by volume") {
  const fem::Session session;  // one a program
  using fem::test::plane;
  BvpScene scene;
  std::vector<fem::BoundaryCondition> sides;
  for (std::size_t k = 0; k < 3; ++k) {
    sides.push_back(plane("base", 2, 0, k, 0));
    sides.push_back(plane("top", 2, 1, k, std::array<double, 3>{0.05, 0.02, -0.03}[k]));
  }
  fem::Problem problem(MPI_COMM_SELF, fem::BoxMesh{{2, 1, 1}, {2, 1, 2}, true, {}}, {1, 2, true}, sides);
  fem::Material material = fem::elastic_material(problem.owned_points(), 1e7, 0.3);
  REQUIRE(fem::solve_statics(problem, material, {}, [](const fem::IncrementReport&) { return true; }).converged);
  const auto lower = [](const fem::Point& x) { return x[0] > 1 && x[2] < 0.5; };  // an element of four
  scene.probes = {{.name = "at", .at = {0.5, 0.5, 0.75}, .where = {}}, {.name = "of", .where = lower}};
  BvpPoints points;
  points.rve_of.assign(problem.owned_points(), SIZE_MAX);
  AcrossRanks across(session, false);
  const Probes probes("", scene, problem, points, {}, nullptr, across);
  const auto names = probes.columns();
  const auto row = probes.row();
  REQUIRE(names.size() == row.size());
  const auto told = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    REQUIRE(at != names.end());
    return row[static_cast<std::size_t>(at - names.begin())];
  };
  const auto f = problem.deformation(), stress = problem.stress();
  const auto strain = [&](std::size_t i, std::size_t a, std::size_t b) {  // tensor components
    return 0.5 * (f[9 * i + 3 * a + b] + f[9 * i + 3 * b + a]) - (a == b ? 1 : 0);
  };
  std::size_t first = SIZE_MAX;
  double volume = 0;
  std::array<double, 6> mean_strain{}, mean_stress{};
  constexpr std::array<std::array<std::size_t, 2>, 6> place{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  for (std::size_t i = 0; i < problem.owned_points(); ++i) {
    const fem::Point x = problem.point_position(i);
    if (x[0] < 1 && x[2] > 0.5 && (first == SIZE_MAX || problem.point_key(i) < problem.point_key(first))) first = i;
    if (!lower(x)) continue;
    dem::Mat3 F;
    for (int k = 0; k < 9; ++k) F(k / 3, k % 3) = f[9 * i + static_cast<std::size_t>(k)];
    const double now = problem.point_volume(i) * F.determinant();
    volume += now;
    for (std::size_t k = 0; k < 6; ++k) {
      mean_strain[k] += now * strain(i, place[k][0], place[k][1]);
      mean_stress[k] += now * stress[6 * i + k];
    }
  }
  const std::array<const char*, 6> component{"xx", "yy", "zz", "yz", "xz", "xy"};
  for (std::size_t k = 0; k < 6; ++k) {
    const std::string c = component[k];
    CHECK(told("probe_at_strain_" + c) == Approx(strain(first, place[k][0], place[k][1])).epsilon(1e-12));
    CHECK(told("probe_at_stress_" + c + "_Pa") == stress[6 * first + k]);
    CHECK(told("probe_of_strain_" + c) == Approx(mean_strain[k] / volume).epsilon(1e-9).margin(1e-12));
    CHECK(told("probe_of_stress_" + c + "_Pa") == Approx(mean_stress[k] / volume).epsilon(1e-9).margin(1e-6));
    CHECK(probes.stress("at", static_cast<int>(k)) == stress[6 * first + k]);
    CHECK(probes.stress("of", static_cast<int>(k)) == Approx(mean_stress[k] / volume).epsilon(1e-9).margin(1e-6));
  }
  CHECK(std::isnan(probes.stress("none", 0)));
}

TEST_CASE("a folder is cleared of what lies in it: a mark that leads out of it, or to it, is of nobody's file") {
  const app::test::Scratch scratch;
  const std::string folder = scratch.path + "/results";
  std::filesystem::create_directories(folder + "/frames");
  const std::vector<std::string> kept{scratch.path + "/kept.csv", scratch.path + "/results2/kept.csv"};
  std::filesystem::create_directories(scratch.path + "/results2");
  const std::vector<std::string> gone{folder + "/history.csv", folder + "/frames/frames_00001.hdf"};
  for (const auto* files : {&kept, &gone})
    for (const std::string& name : *files) std::ofstream(name) << "something";
  std::ofstream(folder + "/.grus") << "../kept.csv\n../results2/kept.csv\nframes/../../kept.csv\n" + kept[1] +
                                          "\nhistory.csv\nframes/frames_*.hdf\n";
  Options options;
  options.directory = folder, options.force = true;
  { const Folder mine(options); }
  for (const std::string& name : kept) CHECK(std::filesystem::exists(name));
  for (const std::string& name : gone) CHECK_FALSE(std::filesystem::exists(name));
  CHECK_FALSE(std::filesystem::exists(folder + "/frames"));
  for (int times = 0; times < 2; ++times)  // each file is noted once, frames of a kind in one line
    for (const char* name : {"history.csv", "frames/frames_00001.hdf", "frames/frames_00002.hdf"})
      result_file(folder, name);
  std::ifstream marks(folder + "/.grus");
  CHECK(std::string{std::istreambuf_iterator<char>(marks), {}} == "history.csv\nframes/frames_*.hdf\n");
}

TEST_CASE("RVEs are answered for in whole rounds of all workers") {
  CHECK(rounds_of(1, 1) == 1);
  CHECK(rounds_of(8, 4) == 2);
  CHECK(rounds_of(9, 4) == 3);
  CHECK(rounds_of(3, 4) == 1);
}

TEST_CASE("an estimate asks its RVE what a step of the run will: an even share, at the solver's pace, in its time") {
  BvpScene scene;
  const dem::Vec3 strain(0.1, -0.2, 0.04);
  dem::Mat3 step = dem::Mat3::Identity();
  step.diagonal() += strain / 20;
  for (const dem::Pace pace : {dem::Pace::relaxed, dem::Pace::steady, dem::Pace::real_time}) {
    scene.rve.pace = pace;
    if (pace == dem::Pace::steady) scene.explicit_statics.emplace();
    if (pace == dem::Pace::real_time) scene.explicit_statics.reset(), scene.dynamics.emplace().duration = 3;
    const dem::Task task = task_of(scene, strain, 20);
    REQUIRE(task.path.size() == 1);
    CHECK((task.path[0] - step).norm() < 1e-15);
    CHECK((task.pace == pace && task.tangent == (pace == dem::Pace::relaxed) && !task.sharp));
    CHECK(task.duration == (pace == dem::Pace::real_time ? 3.0 / 20 : 0));
  }
}
