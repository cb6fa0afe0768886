// SPDX-License-Identifier: LGPL-3.0-or-later
// How runs of grus-bvp end: what does not get to its end is not called finished, whichever solver it is.
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "apps/bvp/bvp_run.hpp"
#include "fem/session.hpp"
#include "tests/apps/refused.hpp"

using namespace grus;
using namespace grus::app;

namespace {

/// Two elements between plates; the upper one comes down, or goes beyond the lower one: they turn inside out.
std::string scene_of(const std::string& solve, double way) {
  return "mesh.box = { size = [1, 1, 2], cells = [1, 1, 2] }\nsolve = " + solve +
         "\nboundary = [{ where = \"z=min\", displacement = [0, 0, 0] }, { where = \"z=max\", displacement = [0, 0, " +
         std::to_string(way) +
         "] }]\nregion = [{ where = \"z>0\", material = \"elastic\", youngs_modulus = 1e9, poissons_ratio = 0.2, "
         "density = 2000 }]\n";
}

BvpEnding run(const fem::Session& session, const std::string& text, const std::string& folder) {
  Options options;
  options.scene = folder + "/scene.toml", options.directory = folder, options.quiet = true;
  std::ofstream(options.scene) << text;
  const BvpScene scene = read_bvp_scene(options.scene, {});
  BvpSetup setup;
  setup.problem = std::visit(
      [&](const auto& mesh) {
        return std::make_unique<fem::Problem>(MPI_COMM_SELF, mesh, scene.discretisation, scene.boundaries);
      },
      scene.mesh);
  setup.points = find_points(scene, *setup.problem, 0);
  AcrossRanks across(session, false);
  const Clock clock;
  BvpRun work(scene, options, std::move(setup), {}, nullptr, nullptr, across);
  return work.go(clock.wall(), clock);
}

}  // namespace

TEST_CASE("a run that fails is unstable and says why, one that gets to its end is finished, by each solver") {
  const fem::Session session;  // one a program
  for (const std::string solve :
       {"{ kind = \"quasi-static\", increments = 2, max_cutbacks = 0 }", "{ kind = \"explicit-quasi-static\" }",
        "{ kind = \"explicit-dynamic\", duration = 0.01 }"}) {
    INFO(solve);
    const app::test::Scratch good, bad;
    const BvpEnding whole = run(session, scene_of(solve, -0.002), good.path);
    CHECK(whole.status == finished);
    CHECK(whole.text == "finished");
    CHECK(std::abs(whole.time / (solve.find("dynamic") != std::string::npos ? 0.01 : 1) - 1) < 1e-9);
    const BvpEnding half = run(session, scene_of(solve, -6), bad.path);
    CHECK(half.status == unstable);
    CHECK(half.text.size() > 10);
    CHECK(half.text != "finished");
    CHECK(half.time < 0.999 * whole.time);
  }  // Who is told to stop before the first answer ends with none, in the midst of the increment. Last, as nothing that
  // comes after it in this process would run.
  hear_signals();
  raise(SIGINT);
  const app::test::Scratch stopped;
  const BvpEnding none = run(session, scene_of("{ kind = \"quasi-static\", increments = 2 }", -0.002), stopped.path);
  CHECK(none.status == interrupted);
  CHECK(none.text == "interrupted within the first increment; nothing to go on from yet");
  CHECK(none.time == 0);
  CHECK(!std::filesystem::exists(stopped.path + "/checkpoint.h5"));
}
