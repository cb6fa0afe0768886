// SPDX-License-Identifier: LGPL-3.0-or-later
// grus-bvp: a macro boundary-value problem with an RVE of grains at every Gauss point. Rank 0 solves it; all ranks advance RVEs.
#include <fmt/format.h>

#include <filesystem>

#include "apps/bvp_output.hpp"
#include "apps/bvp_standing.hpp"
#include "apps/folder.hpp"
#include "apps/run.hpp"
#include "dem/base/error.hpp"
#include "dem/base/watch.hpp"
#include "dem/io/checkpoint.hpp"
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
  } catch (const dem::Interrupted& e) {
    kind = 4, message = e.what();
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
  if (kind == 4) throw dem::Interrupted(message);
  throw std::runtime_error(message);
}

std::unique_ptr<fem::Problem> make_problem(const BvpScene& scene) {
  return std::visit([&](const auto& mesh) { return std::make_unique<fem::Problem>(MPI_COMM_SELF, mesh, scene.discretisation, scene.boundaries); }, scene.mesh);
}

/// Model of the run: in explicit runs grains are damped by their contacts only, unless told otherwise; local damping is for the preparation.
std::shared_ptr<const dem::Model> run_model(const BvpScene& scene) {
  auto model = std::make_shared<dem::Model>(scene.unit_cells[0].model);
  if (scene.damping || scene.is_explicit()) dem::set_damping(*model, scene.damping.value_or(0));
  return model;
}

/// Everything that is set up before a run, on rank 0.
struct Setup {
  std::unique_ptr<fem::Problem> problem;
  BvpPoints points;
  std::vector<dem::State> states;  // of the points' starts
  double density = 0;              // of the packed cells (kg/m^3), where the stress of the ground asks for it
};

std::string checkpoint_of(const Options& options) { return options.directory + "/checkpoint.h5"; }

/// The checkpoint of a run of this scene; refuses any other.
dem::Checkpoint find_checkpoint(const Options& options, const BvpScene& scene) {
  const std::string path = checkpoint_of(options);
  dem::Checkpoint kept = dem::read_checkpoint(path);
  const auto about = nlohmann::json::parse(kept.about, nullptr, false);
  if (about.is_discarded() || about.value("program", "") != "grus-bvp" || kept.parts.size() < 2 + scene.regions.size()) throw InputError(path + ": not a checkpoint of grus-bvp");
  if (about["scene"] != scene.record) throw InputError(path + ": checkpoint of another scene or other settings; give the same file and --set");
  return kept;
}

/// The macro problem with its materials; on rank 0.
class Run {
public:
  Run(const BvpScene& scene, const Options& options, Setup setup, dem::Checkpoint kept, coupling::RveFarm* farm)
      : scene_(scene), options_(options), setup_(std::move(setup)), kept_(std::move(kept)) {
    std::vector<fem::Material> parts;
    if (farm) {
      rves_.emplace(*farm, setup_.states, setup_.points.start, scene.rve);
      parts.push_back(rves_->material());
    } else {
      parts.push_back(fem::elastic_material(0, 1, 0));  // of no point
    }
    for (std::size_t r = 0; r < scene.regions.size(); ++r) {
      const Region& region = scene.regions[r];
      const auto count = static_cast<std::size_t>(std::count(setup_.points.group.begin(), setup_.points.group.end(), r + 1));
      const fem::InitialStress initial = initial_stress(r);
      const double E = region.youngs_modulus, nu = region.poissons_ratio;
      parts.push_back(region.j2 ? fem::j2_material(count, E, nu, region.yield_stress, region.hardening, initial) : fem::elastic_material(count, E, nu, initial));
    }
    regions_.assign(parts.begin() + 1, parts.end());
    material_.emplace(scene.regions.empty() ? parts[0] : fem::composite_material(parts, setup_.points.group));
    for (std::size_t i = 0; i < setup_.points.group.size(); ++i) {
      if (setup_.points.group[i] > 0) {
        density_.push_back(scene.regions[setup_.points.group[i] - 1].density);
      } else {
        const dem::State& s = setup_.states[setup_.points.start[setup_.points.rve_of[i]]];
        density_.push_back(dem::total_mass(s.grains) / s.boundary.cell.volume());
      }
    }
    if (scene.weighs()) setup_.problem->set_gravity(scene.gravity, density_);
    work_of_grains_ = scene.solve;
    for (const auto group : setup_.points.group) work_of_grains_.work_of.push_back(group == 0);
    output_.emplace(options.directory, scene, *setup_.problem, setup_.points, setup_.states, rves_ ? &*rves_ : nullptr);
  }

  BvpEnding go(double ready, const Clock& clock) {
    Progress progress(options_.quiet);
    BvpEnding ending;
    ending.preparation = ready;
    double time = 0, saved = clock.wall();
    bool told = false;
    std::uint64_t sweeps = 0;
    const auto respond = material_->respond;
    material_->respond = [&](const fem::Points& p) {
      if (!scene_.is_explicit() || sweeps % 64 == 0) progress.show(time / scene_.end_time(), output_->line(sweeps));
      if (!scene_.is_explicit() && interruption_asked() && !told) progress.note("  interrupted: ends with this increment, which --resume would have to begin anew; once more ends at once"), told = true;
      ++sweeps;
      return respond(p);
    };
    bool stop = false;
    auto after = [&](const auto& report, double now) {
      time = now;
      output_->add(report, elapsed_ + clock.wall() - ready);
      if constexpr (requires { report.cut_reason; })
        if (!report.cut_reason.empty()) progress.note(fmt::format("  increment {}: {} cutback(s), the last because {}", report.increment, report.cutbacks, one_line(report.cut_reason)));
      stop = interruption_asked();
      if (stop || clock.wall() - saved > scene_.checkpoint_interval) save(report, elapsed_ + clock.wall() - ready), saved = clock.wall();
      return !stop;
    };
    bool complete = false, broken = false;
    std::string failure;
    try {
      // Explicit runs stop between two rows, too, where a checkpoint is due or asked for.
      const auto due = [&] { return interruption_asked() || clock.wall() - saved > scene_.checkpoint_interval; };
      const auto march = [&](auto last, auto&& solve) {
        while (true) {
          const auto result = solve(last);
          last = result.last, complete = result.finished, failure = result.failure;
          if (!result.stopped || stop) return last;
          save(last, elapsed_ + clock.wall() - ready), saved = clock.wall();
          if ((stop = interruption_asked())) return last;
        }
      };
      if (scene_.dynamics) {
        fem::allocate_dynamics(*setup_.problem);
        fem::DynamicsOptions with = *scene_.dynamics;
        with.stop = due;
        ending.time = march(begin<fem::DynamicsReport>(), [&](const fem::DynamicsReport& from) {
          return fem::solve_dynamics(*setup_.problem, *material_, density_, with, [&](const fem::DynamicsReport& r) { return after(r, r.time); }, from);
        }).time;
      } else if (scene_.explicit_statics) {
        fem::allocate_explicit_statics(*setup_.problem);
        fem::ExplicitStaticsOptions with = *scene_.explicit_statics;
        with.stop = due;
        ending.time = march(begin<fem::ExplicitStaticsReport>(), [&](const fem::ExplicitStaticsReport& from) {
          return fem::solve_explicit_statics(*setup_.problem, *material_, with, [&](const fem::ExplicitStaticsReport& r) { return after(r, r.load_factor); }, from);
        }).load_factor;
      } else {
        fem::allocate_statics(*setup_.problem);
        const fem::StaticsStart start = begin<fem::StaticsStart>();
        const auto result = fem::solve_statics(*setup_.problem, *material_, work_of_grains_, [&](const fem::IncrementReport& r) { return after(r, r.load_factor); }, start);
        complete = result.converged, failure = result.failure, ending.time = result.load_factor;
      }
    } catch (const InputError&) {
      throw;
    } catch (const dem::Unstable&) {
      throw;
    } catch (const std::exception& e) {  // of the system, such as a full disk: what there is may still be kept
      broken = true, failure = e.what(), ending.time = time;
    }
    ending.status = broken ? failed : stop ? interrupted : complete ? finished : unstable;
    ending.text = stop && !broken ? "interrupted; --resume goes on from checkpoint.h5" : complete ? "finished" : failure;
    ending.wall = clock.wall();
    closing_ = output_->closing(ending);
    progress.finish(closing_);
    return ending;
  }

  void finish(const BvpEnding& ending) { output_->finish(ending, options_); }

private:
  /// Of the points of a region: its own, or that of the ground.
  fem::InitialStress initial_stress(std::size_t region) const {
    fem::InitialStress all;
    const Region& r = scene_.regions[region];
    for (std::size_t i = 0; i < setup_.points.group.size() && (r.initial_stress || scene_.ground); ++i)
      if (setup_.points.group[i] == region + 1)
        all.push_back(r.initial_stress ? *r.initial_stress : ground_stress(scene_, setup_.problem->point_position(i), setup_.density > 0 ? setup_.density : r.density));
    return all;
  }

  std::string path() const { return checkpoint_of(options_); }

  void write(nlohmann::json about, double wall) {
    about["program"] = "grus-bvp";
    about["scene"] = scene_.record;
    about["output"] = output_->state();
    about["wall"] = wall;
    auto pack = [](const std::vector<double>& v) { return std::string(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(double)); };
    dem::write_checkpoint(path(), about.dump(), [&](const dem::TakePart& take) {
      take(output_->history().text());
      take(pack(setup_.problem->snapshot()));
      for (const auto& r : regions_) take(r.save());
      if (rves_) rves_->save(take);
    });
  }

  template <class Report>
  void save(const Report& report, double wall) {
    write(standing(report), wall);
  }

  /// Where to go on from: the beginning, or where the checkpoint stands.
  template <class Start>
  Start begin() {
    Start start;
    if (options_.resume) stand(resume(), start);
    return start;
  }

  nlohmann::json resume() {
    dem::Checkpoint kept = std::move(kept_);
    const auto about = nlohmann::json::parse(kept.about);
    auto unpack = [](const std::string& bytes) {
      std::vector<double> v(bytes.size() / sizeof(double));
      std::memcpy(v.data(), bytes.data(), v.size() * sizeof(double));
      return v;
    };
    try {
      setup_.problem->restore(unpack(kept.parts[1]));
      for (std::size_t r = 0; r < regions_.size(); ++r) regions_[r].load(kept.parts[2 + r]);
      kept.parts.erase(kept.parts.begin() + 1, kept.parts.begin() + 2 + static_cast<std::ptrdiff_t>(regions_.size()));
      const std::string history = std::move(kept.parts.front());
      kept.parts.erase(kept.parts.begin());
      if (rves_) rves_->load(kept.parts);
      output_->restore(about["output"], history);
    } catch (const std::invalid_argument& e) {
      throw InputError(path() + ": " + e.what());
    }
    elapsed_ = about["wall"];
    return about;
  }

  const BvpScene& scene_;
  const Options& options_;
  Setup setup_;
  dem::Checkpoint kept_;  // to go on from; of a resumed run
  std::optional<coupling::RveMaterial> rves_;
  std::vector<fem::Material> regions_;
  std::optional<fem::Material> material_;
  fem::StaticsOptions work_of_grains_;  // scene.solve; work is told of the points with grains, as that of the cells is
  std::vector<double> density_;
  std::optional<BvpOutput> output_;
  double elapsed_ = 0;  // wall time of earlier parts of the run (s)
  std::string closing_;
};

void print_setup(const BvpScene& scene, const Setup& setup, const Options& options, int ranks) {
  const fem::Problem& p = *setup.problem;
  const auto rves = setup.points.start.size();
  double grains = 0;
  for (const auto& u : scene.unit_cells) grains += u.grains() / scene.variants;
  std::string length = fmt::format("increments {}", scene.solve.increments);
  if (scene.dynamics) length = fmt::format("duration {:.3g} s", scene.dynamics->duration);
  if (scene.explicit_statics) length = fmt::format("steps from {:.0f}", scene.explicit_statics->crossings * fem::crossing_steps(*setup.problem, *scene.explicit_statics));
  const int bytes = scene.is_explicit() ? 5000 : 8000;  // a grain, measured: trial states, and a checkpoint in the making
  fmt::print("{}\n  cells {}   Gauss points {}   with grains {} ({:.0f} grains each, {} packings)   {}   memory up to {:.3g} MB   ranks {} x threads {}\n", scene.title,
             p.global_points() / p.points_per_cell(), p.global_points(), rves, grains, scene.unit_cells.size(), length, static_cast<double>(rves) * grains * bytes / 1e6, ranks,
             options.threads);
  if (const auto& e = scene.explicit_statics)
    fmt::print("  limits of the rate: unbalanced force {:g} of what is applied, kinetic energy {:g} of internal, inertial number of the cells {}; local damping {:g}, safety {:g}\n",
               e->balance, e->kinetic, e->inertial_number > 0 ? fmt::format("{:g}", e->inertial_number) : "their own", e->damping, e->safety);
  if (!scene.is_explicit()) fmt::print("  residual to {:.2g}{}\n", std::max(scene.solve.tolerance, scene.residual_floor()), scene.has_rve ? " (the larger of solve.tolerance, rve.unbalanced_force and rve.stress_change)" : "");
  for (const auto& note : scene.notes) fmt::print("  note: {}\n", note);
  for (const auto& u : scene.unit_cells)
    for (const auto& note : u.notes) fmt::print("  note: unit cell: {}\n", note);
}

int run(const Options& given, const fem::Session& session) {
  const Clock clock;
  Options options = given;
  const bool leads = session.rank() == 0;
  BvpScene scene;
  Setup setup;
  dem::Checkpoint kept;
  together(session, [&] { scene = read_bvp_scene(options.scene, options.overrides); });
  std::vector<Start> starts;
  together(session, [&] {
    if (!scene.ground || !scene.has_rve || options.columns) return;  // the weight of the ground is that of its cells
    const auto packed = prepare_starts(scene, {Start{}}, options.threads, {});
    if (leads) setup.density = dem::total_mass(packed[0].grains) / packed[0].boundary.cell.volume();
  });
  together(session, [&] {
    if (!leads) return;
    setup.problem = make_problem(scene);
    setup.points = find_points(scene, *setup.problem, setup.density);
    starts = setup.points.starts;
    if (options.columns) {
      const std::vector<dem::State> none;
      for (const auto& name : bvp_columns(scene, *setup.problem, Probes("", scene, *setup.problem, setup.points, none, nullptr))) fmt::print("{}\n", name);
      return;
    }
    if (!options.quiet) print_setup(scene, setup, options, session.ranks());
    if (!options.check) check_folder(options);
    if (options.resume) kept = find_checkpoint(options, scene);
    if (options.check && starts.size() > 1) starts.resize(1);
  });
  if (options.columns) return finished;
  std::size_t count = starts.size();
  MPI_Bcast(&count, sizeof count, MPI_BYTE, 0, MPI_COMM_WORLD);
  starts.resize(count);
  MPI_Bcast(starts.data(), static_cast<int>(count * sizeof(Start)), MPI_BYTE, 0, MPI_COMM_WORLD);
  together(session, [&] {
    Progress progress(options.quiet || options.check);
    setup.states = prepare_starts(scene, starts, options.threads, [&](double done) { return progress.watch(done, "unit cells"); });
  });
  std::optional<Folder> made;
  together(session, [&] {
    if (leads && !options.check) made.emplace(options);
  });
  std::shared_ptr<const dem::Model> model;
  together(session, [&] {
    if (scene.has_rve) model = run_model(scene);
  });
  const double ready = clock.wall();
  if (leads && !options.quiet && scene.has_rve) fmt::print("  unit cells prepared in {}\n", duration_text(ready));
  if (options.check) {
    if (leads && scene.has_rve) {
      dem::Rve rve(model, scene.rve.response.quasi_static, setup.states[0]);
      const Clock timer;
      rve.advance({dem::Mat3::Identity()});
      fmt::print("  one RVE at rest: {:.3g} s; run time grows with strain and breakage\n", timer.wall());
    }
    return finished;
  }
  int status = failed;
  if (leads) {
    BvpEnding ending;
    std::exception_ptr error;
    std::optional<Run> work;
    std::optional<coupling::RveFarm> farm;
    try {  // the farm first: from then on the other ranks serve, and hear when it is gone
      if (scene.has_rve) farm.emplace(MPI_COMM_WORLD, model, scene.rve.response, options.threads);
      if (farm && scene.costs) farm->record_costs();
      work.emplace(scene, options, std::move(setup), std::move(kept), farm ? &*farm : nullptr);
      ending = work->go(ready, clock);
      ending.ranks = session.ranks();
      ending.migrated = farm ? farm->moved() : 0;
      status = ending.status;
      try {
        work->finish(ending);
        if (farm && farm->costs()) dem::write_whole(options.directory + "/costs.csv", *farm->costs());
      } catch (const std::exception&) {  // of one fault one line
        if (status != failed) throw;
      }
    } catch (const InputError&) {
      error = std::current_exception(), status = refused;
    } catch (const dem::Unstable&) {
      error = std::current_exception(), status = unstable;
    } catch (...) {
      error = std::current_exception(), status = failed;
    }
    work.reset(), farm.reset();
    MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
    if (error) std::rethrow_exception(error);
    if (status == failed) fmt::print(stderr, "{}\n", one_line(fmt::format("{}: {}", options.scene, ending.text)));
    if (status == unstable)
      fmt::print(stderr, "{}\n", one_line(fmt::format("{}: {} {:.4g}: {}; {}", options.scene, scene.dynamics ? "time" : "load factor", ending.time, ending.text,
                 scene.explicit_statics ? "larger limits in [solve], a larger unit cell or rve.on_failure = \"elastic\" may help"
                 : scene.dynamics       ? "a smaller solve.safety or another unit cell may help"
                                        : "more solve.increments, looser rve.unbalanced_force or a larger unit cell may help")));
    return status;
  }
  if (scene.has_rve) coupling::serve(MPI_COMM_WORLD, model, scene.rve.response, options.threads);
  MPI_Bcast(&status, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  const fem::Session session;
  return run_command(argc, argv, "grus-bvp", "A macro boundary-value problem, finite elements with breakable grains at every Gauss point (mpirun -n P for P ranks).",
                     [&](const Options& options) { return run(options, session); }, session.rank() == 0, session.sharers());
}
