// SPDX-License-Identifier: LGPL-3.0-or-later
// Results of macro problems: sums and means of all rows, and that a run which goes on tells what one in one piece
// tells.
#include <fmt/format.h>

#include <fstream>

#include "apps/bvp/bvp_run.hpp"
#include "fem/session.hpp"
#include "tests/apps/refused.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::Scratch;

namespace {

/// One session a program: PETSc begins once.
const fem::Session& session() {
  static const fem::Session one;
  return one;
}

/// A problem without grains, and its results in a folder of its own.
struct Told {
  Scratch scratch;
  BvpScene scene;
  std::unique_ptr<fem::Problem> problem;
  BvpPoints points;
  std::vector<dem::State> states;
  AcrossRanks across;
  std::optional<BvpOutput> output;

  explicit Told(const std::string& solve) : across(session(), false) {
    const std::string file = scratch.path + "/scene.toml";
    std::ofstream(file) << "title = \"Block\"\nmesh.box = { size = [1, 1, 2], cells = [1, 1, 2] }\nsolve = " + solve +
                               "\nboundary = [{ where = \"z=min\", displacement = [0, 0, 0] }]\noutput.frames = 2\n"
                               "probe = [{ name = \"p\", at = [0, 0, 0] }]\n"
                               "region = [{ where = \"z>0\", material = \"elastic\", youngs_modulus = 1e9, "
                               "poissons_ratio = 0.2, density = 2000 }]\n";
    scene = read_bvp_scene(file, {});
    problem = std::make_unique<fem::Problem>(MPI_COMM_SELF, std::get<fem::BoxMesh>(scene.mesh), scene.discretisation,
                                             scene.boundaries);
    points = find_points(scene, *problem, 0);
    output.emplace(scratch.path, scene, *problem, points, states, nullptr, nullptr, across);
  }
  nlohmann::json summary(const BvpEnding& ending) {
    Options options;
    options.threads = 3;
    output->finish(ending, options);
    std::ifstream in(scratch.path + "/summary.json");
    return nlohmann::json::parse(in);
  }
};

const std::string still = "{ kind = \"quasi-static\", increments = 4 }";
const std::string slow = "{ kind = \"explicit-quasi-static\" }";
const std::string fast = "{ kind = \"explicit-dynamic\", duration = 0.5 }";

fem::IncrementReport increment(int k) {
  fem::IncrementReport r{};
  r.increment = k, r.load_factor = 0.25 * k, r.iterations = 3 + k, r.cutbacks = k, r.law_sweeps = 10 * k;
  r.residual = k == 1 ? 5e-4 : 1e-5 * k, r.correction = 0.01 * k, r.noise = 0.02 * k;
  r.residuals = {1.0, 0.1, 0.1 / (1 << k), 0};
  r.linear_iterations = 7 * k, r.linear_failures = k;
  r.energy.work = 2.0 * k, r.energy.internal = 2.1 * k, r.energy.external = 2.5 * k, r.energy.largest = 4.0 * k;
  return r;
}

/// Other numbers in place of all those that a record holds, of texts of them, too; times of series are numbers.
nlohmann::json with_other_numbers(nlohmann::json record, const std::set<std::string>& but, double& next) {
  for (auto& [key, value] : record.items()) {
    if (but.contains(key)) continue;
    if (value.is_structured())
      value = with_other_numbers(value, {}, next);
    else if (value.is_number_integer())
      value = static_cast<int>(next += 1);
    else if (value.is_number())
      value = next += 1.125;
    else if (value.is_string() && value.get<std::string>().starts_with("0x"))
      value = fmt::format("{:a}", next += 1.0625);
  }
  return record;
}

}  // namespace

TEST_CASE("every number that results of a macro run go on from comes back") {
  for (const std::string& solve : {still, slow, fast}) {
    Told first(solve), second(solve);
    if (solve == still) {
      first.output->add(increment(1), 1.5), first.output->add(increment(2), 2.5);
    } else if (solve == slow) {
      first.output->add(fem::ExplicitStaticsReport{}, 1.5);
    } else {
      first.output->add(fem::DynamicsReport{}, 1.5);
    }
    const nlohmann::json state = nlohmann::json::parse(first.output->state().dump());
    double next = 100;
    const nlohmann::json other = with_other_numbers(state, {"rows"}, next);
    CHECK(next > 100 + 15);
    CHECK(other != state);
    second.output->restore(other, first.output->history().text());
    CHECK(nlohmann::json::parse(second.output->state().dump()) == other);
    CHECK(second.output->history().text() == first.output->history().text());
  }
}

TEST_CASE("a run of increments in two parts tells what one in one piece tells: rows, notes, ending and summary") {
  BvpEnding ending;
  ending.status = interrupted, ending.ranks = 2, ending.text = "half way", ending.time = 0.75;
  ending.preparation = 1.5, ending.wall = 4, ending.earlier = 8, ending.cpu = 16;
  std::vector<nlohmann::json> summaries;
  std::vector<std::string> histories, said;
  for (const bool parted : {false, true}) {
    Told first(still), second(still);
    Told* now = &first;
    for (int k = 1; k <= 3; ++k) {
      now->output->add(increment(k), 1.0 * k);
      if (!parted || k != 2) continue;
      second.output->restore(nlohmann::json::parse(first.output->state().dump()), first.output->history().text());
      now = &second;
    }
    histories.push_back(now->output->history().text());
    said.push_back(now->output->line(5) + fmt::format("{}", fmt::join(now->output->notes(), "\n")));
    nlohmann::json s = now->summary(ending);
    s.erase("files"), s.erase("scene_file");
    summaries.push_back(s);
  }
  CHECK(histories[0] == histories[1]);
  CHECK(said[0] == said[1]);
  CHECK(summaries[0] == summaries[1]);

  const nlohmann::json& s = summaries[0];
  CHECK((s["title"] == "Block" && s["status"] == interrupted && s["ending"] == "half way" && s["ranks"] == 2));
  CHECK((s["threads"] == 3 && !s.contains("preparation")));
  const auto& counts = s["counts"];
  CHECK(
      (counts["newton_iterations"] == 4 + 5 + 6 && counts["cutbacks"] == 1 + 2 + 3 && counts["material_sweeps"] == 30));
  CHECK((counts["gauss_points"] == 16 && counts["breakages"] == 0 && counts["bonds_broken"] == 0));
  CHECK(!counts.contains("linear_iterations"));
  const auto& errors = s["errors"];
  CHECK((errors["worst_residual"] == 5e-4 && errors["macro_work_J"] == 6.0));
  CHECK(errors["hill_mandel"].get<double>() == Approx(0.3 / 6.3));
  CHECK(errors["last_energy_error"].get<double>() == Approx((7.5 - 6.3) / 12));
  CHECK(errors["last_correction"].get<double>() == Approx(0.03));
  CHECK(!errors.contains("worst_rve_energy_error"));
  // A tenth, and a half, a quarter, an eighth, in turn; what has no residual left does not count.
  CHECK(s["newton_contraction"].get<double>() == Approx(std::pow(1e-3 / 64, 1.0 / 6)));
  CHECK((s["seconds"]["preparation_wall"] == 1.5 && s["seconds"]["solve_wall"] == 10.5 &&
         s["seconds"]["cpu_rank0"] == 16));
  CHECK((s["last_row"]["increment"] == 3 && s["last_row"]["time_s"] == 0.75 && s["last_row"]["wall_s"] == 3));
  CHECK((s["mesh"]["low_m"] == nlohmann::json{0, 0, 0} && s["mesh"]["high_m"] == nlohmann::json{1, 1, 2}));
  REQUIRE(s["notes"].size() == 1);
  CHECK(s["notes"][0] ==
        "the macro balance of energy is off by 10 % (energy_error): stresses change too much within a step; take more "
        "solve.increments");
}

TEST_CASE("linear solves are counted where they are iterated; what a preparation tells stands in the summary") {
  Told told("{ kind = \"quasi-static\", increments = 4, linear_solver = \"iterative\" }");
  for (int k = 1; k <= 3; ++k) told.output->add(increment(k), 1);
  BvpEnding ending;
  ending.prepared = {{"a", 1}};
  const nlohmann::json s = told.summary(ending);
  CHECK((s["counts"]["linear_iterations"] == 42 && s["counts"]["linear_solves_made_direct"] == 6));
  CHECK((s["preparation"] == nlohmann::json{{"a", 1}} && s["status"] == 0));
}

TEST_CASE(
    "explicit runs count a sweep a step and one for the start; the worst unbalance is that of increments' residual") {
  Told statics(slow), waves(fast);
  fem::ExplicitStaticsReport e;
  fem::DynamicsReport d;
  for (const int k : {1, 2, 3}) {
    e.steps = d.steps = static_cast<std::uint64_t>(100 * k), e.load_factor = d.time = 0.15 * k;
    e.unbalanced = k == 2 ? 0.03 : 0.01;
    e.energy.work = d.energy.work = 4, e.energy.internal = d.energy.internal = 5;
    e.energy.external = d.energy.external = 7, e.energy.largest = d.energy.largest = 100;
    statics.output->add(e, k), waves.output->add(d, k);
  }
  const nlohmann::json s = statics.summary({}), w = waves.summary({});
  for (const auto& told : {s, w}) {
    CHECK((told["counts"]["material_sweeps"] == 301 && told["counts"]["newton_iterations"] == 0));
    CHECK(told["errors"]["hill_mandel"].get<double>() == Approx(0.2));
    CHECK(told["errors"]["last_energy_error"].get<double>() == Approx(0.02));
    CHECK((!told.contains("newton_contraction") && !told.contains("notes") &&
           !told["errors"].contains("last_correction")));
    CHECK(told["last_row"]["time_s"].get<double>() == Approx(0.45));
  }
  CHECK(s["errors"]["worst_residual"] == 0.03);
  CHECK(!w["errors"].contains("worst_residual"));
}

TEST_CASE("frames are written at the first row and at even parts of the way, the last of them at its end") {
  Told told(fast);
  std::vector<std::size_t> frames;
  for (const double time : {0.0, 0.25, 0.49, 0.5}) {
    fem::DynamicsReport r;
    r.time = time;
    told.output->add(r, 0);
    frames.push_back(told.output->state()["series"].size());
  }
  CHECK(frames == std::vector<std::size_t>{1, 1, 1, 2});
  CHECK(told.output->state()["series"][1] == nlohmann::json{"macro/macro_00001.hdf", 0.5});
}

TEST_CASE("how a macro run has ended is said by its status, its way and what it has counted") {
  Told increments(still), statics(slow), waves(fast);
  for (int k = 1; k <= 3; ++k) increments.output->add(increment(k), 1);
  BvpEnding e;
  e.time = 0.5, e.wall = 3, e.earlier = 9.3;
  const auto said = [&](Told& told) {
    const std::string text = told.output->closing(e);
    CHECK(text.ends_with("0 DEM steps in 12.3 s (" + told.scratch.path + ")"));
    return text.substr(0, text.find(" DEM steps"));
  };
  for (const auto& [status, how] : std::map<int, std::string>{
           {finished, "finished"}, {interrupted, "interrupted"}, {out_of_time, "out of time"}, {unstable, "stopped"}}) {
    e.status = status;
    CHECK(said(increments) == how +
                                  ": load factor 0.5, mean strain zz 0.0000, mean stress zz 0 MPa, 0 breakages, 15 "
                                  "Newton iterations, 6 cutbacks, 30 material sweeps, 0");
    CHECK(said(statics) == how + ": 50 % of the load, mean stress zz 0 MPa, 0 breakages, 0");
    CHECK(said(waves) == how + ": 0.5 s, mean stress zz 0 MPa, 0 breakages, 0");
  }
}
