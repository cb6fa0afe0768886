// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-bvp: a macro boundary-value problem with an RVE of grains at every Gauss point.
#include <fmt/format.h>

#include <filesystem>
#include <numeric>

#include "apps/bvp_output.hpp"
#include "apps/prepare_sample.hpp"
#include "apps/run.hpp"
#include "dem/io/whole_file.hpp"
#include "fem/session.hpp"

using namespace grus;
using namespace grus::app;

namespace {

/// Runs `part` on every rank; if any throws, all throw the first rank's error: nobody is left waiting.
template <class F>
void together(const fem::Session& session, F&& part) {
  std::string message;
  int kind = 0;
  try {
    part();
  } catch (const InputError& e) {
    kind = 1, message = e.what();
  } catch (const dem::Unstable& e) {
    kind = 2, message = e.what();
  } catch (const std::invalid_argument& e) {
    kind = 1, message = e.what();
  } catch (const std::exception& e) {
    kind = 3, message = e.what();
  }
  const int mine = kind != 0 ? session.rank() : session.ranks();
  int first = 0;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (first == session.ranks()) return;
  int size = static_cast<int>(message.size());
  MPI_Bcast(&kind, 1, MPI_INT, first, MPI_COMM_WORLD);
  MPI_Bcast(&size, 1, MPI_INT, first, MPI_COMM_WORLD);
  message.resize(static_cast<std::size_t>(size));
  MPI_Bcast(message.data(), size, MPI_CHAR, first, MPI_COMM_WORLD);
  if (kind == 1) throw InputError(message);
  if (kind == 2) throw dem::Unstable(message);
  throw std::runtime_error(message);
}

/// Prepared states of the variants that this rank's points need, and which of them each point starts from.
std::vector<dem::State> prepare_points(const BvpScene& scene, const fem::Problem& problem, int threads, std::vector<std::size_t>& start) {
  const auto variants = static_cast<std::size_t>(scene.variants);
  std::vector<std::size_t> variant(problem.owned_points());
  std::vector<std::uint8_t> needed(variants, 0);
  for (std::size_t i = 0; i < variant.size(); ++i) needed[variant[i] = static_cast<std::size_t>(problem.point_key(i)) % variants] = 1;
  std::vector<std::size_t> list;
  for (std::size_t v = 0; v < variants; ++v)
    if (needed[v]) list.push_back(v);
  std::vector<dem::State> prepared(variants);
  std::vector<std::string> errors(variants);
  dem::Team team(threads);
  team.each(list.size(), [&](std::size_t k) {
    dem::Team alone(1);
    try {
      prepared[list[k]] = prepare_sample(scene.unit_cells[list[k]], alone);
    } catch (const std::exception& e) {
      errors[list[k]] = e.what();
    }
  });
  for (const auto& e : errors)
    if (!e.empty()) throw dem::Unstable(fmt::format("unit cell: {}", e));
  std::vector<dem::State> states;
  std::vector<std::size_t> place(variants, 0);
  for (const std::size_t v : list) place[v] = states.size(), states.push_back(std::move(prepared[v]));
  for (const std::size_t v : variant) start.push_back(place[v]);
  return states;
}

int run(const Options& given, const fem::Session& session) {
  const Clock clock;
  Options options = given;
  const bool speaks = session.rank() == 0;
  BvpScene scene;
  if (options.resume) throw dem::InputError("--resume: grus-bvp writes no checkpoints in this version; run again without --resume");
  together(session, [&] { scene = read_bvp_scene(options.scene, options.overrides); });
  std::unique_ptr<fem::Problem> problem;
  together(session, [&] { problem = std::make_unique<fem::Problem>(MPI_COMM_WORLD, scene.mesh, scene.discretisation, scene.boundaries); });
  const double grains = std::accumulate(scene.unit_cells.begin(), scene.unit_cells.end(), 0.0, [](double s, const auto& u) { return s + static_cast<double>(u.state.grains.size()); }) / scene.variants;
  if (speaks && !options.quiet)
    fmt::print("{}\n  cells {}   Gauss points {}   grains a point {:.0f} ({} packings)   increments {}   memory about {:.3g} MB   ranks {} x threads {}\n", scene.title,
               problem->global_points() / problem->points_per_cell(), problem->global_points(), grains, scene.variants, scene.solve.increments,
               static_cast<double>(problem->global_points()) * grains * 2 * 4000 / 1e6, session.ranks(), options.threads);
  if (!options.check) together(session, [&] { if (speaks) make_folder(options); });
  std::vector<dem::State> states;
  std::vector<std::size_t> start;
  together(session, [&] { states = prepare_points(scene, *problem, options.threads, start); });
  const double ready = clock.wall();
  if (speaks && !options.quiet) fmt::print("  unit cells prepared in {}\n", duration_text(ready));

  auto model = std::make_shared<const dem::Model>(scene.unit_cells[0].model);
  if (options.check) {
    double seconds = 0;
    together(session, [&] {
      if (states.empty()) return;
      dem::Rve probe(model, scene.quasi_static, states[0]);
      const Clock timer;
      probe.advance({dem::Mat3::Identity()});
      seconds = timer.wall();
    });
    if (speaks) fmt::print("  one RVE at rest: {:.3g} s; run time grows with strain and breakage\n", seconds);
    return finished;
  }
  coupling::RveMaterial rves(model, scene.quasi_static, std::move(states), std::move(start), options.threads, scene.rve);
  fem::Material material = rves.material(MPI_COMM_WORLD);
  Progress progress(options.quiet);
  BvpOutput output(options.directory, scene, *problem, rves, speaks);
  double load = 0;
  std::uint64_t sweeps = 0;
  auto show = [&] {
    if (!speaks) return;
    progress.show(load, output.line(sweeps));
  };
  const auto respond = material.respond;
  material.respond = [&](const fem::Points& p) {
    show();
    ++sweeps;
    return respond(p);
  };
  bool stop = false;
  const fem::StaticsResult result = fem::solve_statics(*problem, material, scene.solve, [&](const fem::IncrementReport& r) {
    load = r.load_factor;
    together(session, [&] { output.add(r, clock.wall() - ready); });
    int asked = interruption_asked() ? 1 : 0, any = 0;
    MPI_Allreduce(&asked, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    stop = any != 0;
    return !stop;
  });
  const int status = stop ? interrupted : result.converged ? finished : unstable;
  const std::string ending = stop ? "interrupted" : result.converged ? "finished" : result.failure;
  together(session, [&] { output.finish(status, ending, result, options, session.ranks(), ready, clock.wall()); });
  if (speaks) progress.finish(output.closing(status, result, clock.wall() - ready));
  if (speaks && status == unstable)
    fmt::print(stderr, "{}: load factor {:.4g}: {}; smaller solve.increments, looser rve.unbalanced_force or a larger unit cell may help\n", options.scene,
               result.load_factor, ending);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const fem::Session session;
  return run_command(argc, argv, "grus-bvp", "A macro boundary-value problem, finite elements with breakable grains at every Gauss point (mpirun -n P for P ranks).",
                     [&](const Options& options) { return run(options, session); }, session.rank() == 0);
}
