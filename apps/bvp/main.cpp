// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-bvp: a macro boundary-value problem with an RVE of grains at every Gauss point. Rank 0 solves it and all ranks
// advance RVEs; or it is spread over the ranks, each with the elements and RVEs that it owns.
#include <fmt/format.h>

#include <filesystem>

#include "apps/bvp/bvp_run.hpp"
#include "apps/bvp/estimate.hpp"
#include "apps/bvp/on_all_ranks.hpp"
#include "apps/bvp/setup_text.hpp"
#include "apps/run/folder.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/whole_file.hpp"
#include "fem/linear_options.hpp"
#include "fem/support.hpp"

using namespace grus;
using namespace grus::app;

namespace {

std::unique_ptr<fem::Problem> make_problem(const BvpScene& scene, MPI_Comm comm) {
  return std::visit(
      [&](const auto& mesh) {
        return std::make_unique<fem::Problem>(comm, mesh, scene.discretisation, scene.boundaries);
      },
      scene.mesh);
}

/// Model of the run: in explicit runs grains are damped by their contacts only, unless told otherwise; local damping is
/// for the preparation.
std::shared_ptr<const dem::Model> run_model(const BvpScene& scene) {
  auto model = std::make_shared<dem::Model>(scene.unit_cells[0].model);
  if (scene.damping || scene.is_explicit()) dem::set_damping(*model, scene.damping.value_or(0));
  return model;
}

/// What no increment of Newton can solve is refused before any RVE is prepared.
void check_increments(const BvpScene& scene, fem::Problem& problem) {
  if (scene.is_explicit()) return;
  const std::string loose = fem::loose_motions(problem);
  if (!loose.empty())
    throw InputError(fmt::format(
        "{}: boundary: nothing stops the body from {}, which solve.kind = \"quasi-static\" needs: add a [[boundary]] "
        "with a displacement of 0 against it, at a corner or along an edge (the explicit kinds need none)",
        scene.file, loose));
  if (const std::string fault = fem::fault_of_linear_options(scene.solve.linear); !fault.empty())
    throw InputError(fmt::format("{}: solve: {}", scene.file, fault));
}

/// Ends all ranks for what the others know nothing of, and may wait for.
[[noreturn]] void end_all(const Options& options, const std::string& why, int status) {
  say_fault(options, fmt::format("{}: {}", options.scene, why));
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, status);
  std::_Exit(status);
}

/// What all ranks do together: of a scene or a mesh that is no good all hear. Of what else fails on one of them, memory
/// as a rule, the others hear nothing, and wait: it ends the job.
template <class F>
void all_or_none(const Options& options, const AcrossRanks& across, F&& part) {
  if (across.ranks() == 1) return part();
  try {
    part();
  } catch (const InputError&) {
    throw;
  } catch (const std::invalid_argument&) {
    throw;
  } catch (...) {
    end_all(options, fmt::format("rank {}: {}", across.rank(), one_line(dem::caught().text)), failed);
  }
}

/// Problem, points and the states that their RVEs start from, on rank 0 or on all ranks that it is spread over; the
/// states' starts on all.
std::vector<Start> set_up(BvpScene& scene, const Options& options, const fem::Session& session,
                          const AcrossRanks& across, BvpSetup& setup, dem::Checkpoint& kept) {
  const bool leads = session.rank() == 0;
  std::vector<Start> starts;
  on_all_ranks(session, [&] {
    if (!scene.ground || !scene.has_rve || options.columns) return;  // the weight of the ground is that of its RVEs
    const auto packed = prepare_starts(scene, {Start{}}, options.threads, {}).states;
    if (leads) setup.density = dem::total_mass(packed[0].grains) / packed[0].boundary.cell.volume();
  });
  if (across.spread()) MPI_Bcast(&setup.density, 1, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  double crossing = 0;
  on_all_ranks(session, [&] {
    if (leads && across.ranks() > 1 && options.resume && std::filesystem::exists(checkpoint_of(options)))
      kept = find_checkpoint(options, scene);
  });
  on_all_ranks(session, [&] {
    if (!leads && !across.spread()) return;
    all_or_none(options, across, [&] {
      setup.make = [&scene, comm = across.comm()](std::vector<std::int32_t> owner) {
        std::visit([&](auto& mesh) { mesh.owner = std::move(owner); }, scene.mesh);
        return make_problem(scene, comm);
      };
      setup.problem = setup.make({});
      setup.points = find_points(scene, *setup.problem, setup.density);
      if (across.ranks() > 1) {
        setup.problem = setup.make(equal_parts(*setup.problem, setup.points, kept_costs(kept)));
        setup.points = find_points(scene, *setup.problem, setup.density);
      }
      if (!options.columns) check_increments(scene, *setup.problem);
      if (scene.explicit_statics) crossing = fem::crossing_steps(*setup.problem, *scene.explicit_statics);
    });
  });
  on_all_ranks(session, [&] {
    if (!leads || options.columns) return;
    starts = setup.points.starts;
    check_starts(scene, starts);
    if (starts.size() < setup.points.stresses)
      scene.notes.push_back(fmt::format(
          "initial_stress: {} stresses in {} class{}, each of which is prepared once; a point's stress is "
          "off by {:.2g} % at most (initial_stress.tolerance)",
          setup.points.stresses, starts.size(), starts.size() > 1 ? "es" : "", 100 * setup.points.deviation));
    if (options.speaks()) say(options, setup_text(scene, setup, options, session.ranks(), crossing));
    if (!options.check) check_folder(options);
    if (options.resume && kept.about.empty() && std::filesystem::exists(checkpoint_of(options)))
      kept = find_checkpoint(options, scene);
    if (options.check && starts.size() > 1) starts = {starts[starts.size() / 2]};
  });
  std::size_t count = starts.size();
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, MPI_COMM_WORLD);
  starts.resize(count);
  MPI_Bcast(starts.data(), static_cast<int>(count * sizeof(Start)), MPI_BYTE, 0, MPI_COMM_WORLD);
  return starts;
}

void print_columns(const BvpScene& scene, const BvpSetup& setup, AcrossRanks& across) {
  const std::vector<dem::State> none;
  const Probes probes("", scene, *setup.problem, setup.points, none, nullptr, across);
  for (const auto& name : bvp_columns(scene, *setup.problem, probes)) fmt::print("{}\n", name);
}

void write_costs(const Options& options, AcrossRanks& across, const std::string& mine) {
  const std::string heading = mine.substr(0, mine.find('\n') + 1), rows = across.all_texts(mine.substr(heading.size()));
  across.lead([&] { dem::write_whole(result_file(options.directory, "costs.csv"), heading + rows); });
}

/// The run, on rank 0; the other ranks serve until it is over, and hear the status. Or on all ranks, of a problem that
/// is spread.
int lead(const BvpScene& scene, const Options& options, const fem::Session& session, AcrossRanks& across,
         const std::shared_ptr<const dem::Model>& model, BvpSetup setup, dem::Checkpoint kept, const Clock& clock) {
  BvpEnding ending;
  std::exception_ptr error;
  // Given back before the last words: with no memory at all MPI would end the others with another status.
  std::vector<std::vector<char>> reserve(across.ranks() > 1 ? 32 : 0, std::vector<char>(1 << 15));
  std::optional<BvpRun> work;
  std::optional<coupling::RveFarm> farm;
  const double ready = clock.wall();
  try {  // the farm first: from then on the other ranks serve, and hear when it is gone
    const MPI_Comm served = across.spread() ? MPI_COMM_SELF : MPI_COMM_WORLD;
    if (scene.has_rve) farm.emplace(served, model, scene.rve.response, options.threads);
    if (farm && scene.costs) farm->record_costs();
    if (across.spread()) share_states(across, setup);
    work.emplace(scene, options, std::move(setup), std::move(kept), farm ? &*farm : nullptr, model.get(), across);
    across.lose_patience_after(scene.patience, [&](const std::string& why) { end_all(options, why, failed); });
    ending = work->go(ready, clock);
    across.be_patient();
    ending.ranks = session.ranks();
    ending.migrated = farm ? farm->moved() : 0;
    try {
      if (farm && farm->costs()) write_costs(options, across, *farm->costs());
      work->finish(ending);
    } catch (const std::exception&) {  // of one fault one line
      if (ending.status != failed || !across.agreed()) throw;
    }
  } catch (const InputError&) {
    error = std::current_exception(), ending.status = refused;
  } catch (const dem::Unstable&) {
    error = std::current_exception(), ending.status = unstable;
  } catch (...) {
    error = std::current_exception(), ending.status = failed;
  }
  const bool by_all = ending.status == refused && !work;  // a scene is refused by all ranks
  if (error && !by_all && !across.agreed()) {
    reserve.clear();
    const dem::Fault fault = dem::fault_in([&] { std::rethrow_exception(error); });
    end_all(options, fmt::format("rank {}: {}", session.rank(), one_line(fault.text)), ending.status);
  }
  work.reset(), farm.reset();
  if (!across.spread()) MPI_Bcast(&ending.status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (error) std::rethrow_exception(error);
  if (const std::string why = failure_text(scene, options, ending); across.leads() && !why.empty())
    say_fault(options, why);
  return ending.status;
}

/// --check: how long preparation and run would take; `one`: what one of the starts took.
void tell_times(const BvpScene& scene, const Options& options, const BvpSetup& setup,
                const std::shared_ptr<const dem::Model>& model, const StartTimes& one, int ranks) {
  const int workers = ranks * options.threads;
  fmt::print("{}\n",
             preparation_text(setup.points.starts.size(), static_cast<std::size_t>(scene.variants), workers, one));
  fmt::print("{}\n", run_text(estimate_run(scene, setup, model, workers)));
}

/// What the preparation has made of the RVEs' packings: in notes and results.
void tell_preparations(BvpScene& scene, const Options& options, const std::vector<nlohmann::json>& told,
                       BvpSetup& setup) {
  setup.prepared = sum_of_preparations(told);
  const std::string note = note_of_preparations(told);
  if (note.empty()) return;
  scene.notes.push_back("unit cell: " + note);
  if (options.check || options.speaks()) say(options, "  note: " + scene.notes.back());
}

int run(const Options& options, const fem::Session& session) {
  const Clock clock;
  const bool leads = session.rank() == 0;
  BvpScene scene;
  BvpSetup setup;
  dem::Checkpoint kept;
  on_all_ranks(session, [&] { scene = read_bvp_scene(options.scene, options.overrides); });
  AcrossRanks across(session, scene.spread && !options.check && !options.columns);
  const std::vector<Start> starts = set_up(scene, options, session, across, setup, kept);
  if (options.columns) {
    if (leads) print_columns(scene, setup, across);
    return finished;
  }
  std::optional<Folder> made;
  const auto make_folder = [&] {
    if (!made) made.emplace(options);
  };
  Starts prepared;
  on_all_ranks(session, [&] {
    Progress progress(options, options.check);
    StartsFile file;
    if (!options.check)
      file = {options.directory + "/preparation.h5", scene.checkpoint_interval, options.resume, [&] {
                make_folder();
                result_file(options.directory, "preparation.h5");
              }};
    prepared = prepare_starts(
        scene, starts, options.threads, [&](double done) { return progress.watch(done, "unit cells"); }, file);
  });
  on_all_ranks(session, [&] {
    if (leads && !options.check) make_folder();
  });
  std::shared_ptr<const dem::Model> model;
  on_all_ranks(session, [&] {
    if (scene.has_rve) model = run_model(scene);
  });
  if (leads && scene.has_rve) {
    if (!options.check) say(options, "  unit cells prepared in " + duration_text(clock.wall()));
    setup.states = std::move(prepared.states);
    tell_preparations(scene, options, prepared.told, setup);
    if (options.check) tell_times(scene, options, setup, model, prepared.times, session.ranks());
  }
  if (options.check) return finished;
  if (leads || across.spread())
    return lead(scene, options, session, across, model, std::move(setup), std::move(kept), clock);
  if (scene.has_rve) coupling::serve(MPI_COMM_WORLD, model, scene.rve.response, options.threads);
  int status = failed;
  MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const fem::Session session;
  return run_command(
      argc, argv, "grus-bvp",
      "A macro boundary-value problem, finite elements with breakable grains at every Gauss point (mpirun -n P for P "
      "ranks).",
      [&](const Options& options) { return run(options, session); }, session.rank() == 0, session.sharers(),
      [&](const std::function<void()>& part) { on_all_ranks(session, part); });
}
