// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/bvp_run.hpp"

#include <fmt/format.h>

#include "apps/bvp/course.hpp"
#include "apps/bvp/standing.hpp"
#include "apps/run/folder.hpp"
#include "apps/run/same_scene.hpp"
#include "coupling/start_stiffness.hpp"
#include "dem/base/error.hpp"
#include "dem/base/fault.hpp"

namespace grus::app {

std::string checkpoint_of(const Options& options) { return options.directory + "/checkpoint.h5"; }

namespace {

/// An increment that --max-time does not leave the time to end.
struct OutOfTime {};

}  // namespace

dem::Checkpoint find_checkpoint(const Options& options, const BvpScene& scene) {
  const std::string path = checkpoint_of(options);
  dem::Checkpoint kept = dem::read_checkpoint(path);
  const auto about = nlohmann::json::parse(kept.about, nullptr, false);
  const std::size_t least = scene.spread ? 2 : 2 + scene.regions.size() + (scene.regularisation ? 1 : 0);
  if (about.is_discarded() || about.value("program", "") != "grus-bvp" || kept.parts.size() < least)
    throw InputError(path + ": not a checkpoint of grus-bvp");
  const nlohmann::json cell = scene.has_rve ? *scene.unit_cells[0].record : nlohmann::json();
  refuse_changes(path, about.value("scene", nlohmann::json()), *scene.record);
  refuse_changes(path, about.value("unit_cell", nlohmann::json()), cell, "unit cell");
  if (has_finished(options.directory, scene.record.get())) say(options, finished_before);
  return kept;
}

BvpRun::BvpRun(const BvpScene& scene, const Options& options, BvpSetup setup, dem::Checkpoint kept,
               coupling::RveFarm* farm, const dem::Model* model, AcrossRanks& across)
    : scene_(scene),
      options_(options),
      setup_(std::move(setup)),
      kept_(std::move(kept)),
      farm_(farm),
      model_(model),
      across_(across) {
  make_materials();
  output_.emplace(options.directory, scene, *setup_.problem, setup_.points, setup_.states, rves_ ? &*rves_ : nullptr,
                  regularised_ ? &*regularised_ : nullptr, across);
}

/// Of the points that this rank has.
void BvpRun::make_materials() {
  std::vector<fem::Material> parts;
  if (farm_) {
    const auto among = across_.spread() ? std::optional(across_.comm()) : std::nullopt;
    rves_.emplace(*farm_, setup_.states, setup_.points.start, scene_.rve, among, own_shard().rves);
    parts.push_back(scene_.regularisation ? regularise() : grains());
  } else {
    parts.push_back(fem::elastic_material(0, 1, 0));  // of no point
  }
  for (std::size_t r = 0; r < scene_.regions.size(); ++r) {
    const Region& region = scene_.regions[r];
    const auto count =
        static_cast<std::size_t>(std::count(setup_.points.group.begin(), setup_.points.group.end(), r + 1));
    const fem::InitialStress initial = initial_stress(r);
    const double E = region.youngs_modulus, nu = region.poissons_ratio;
    parts.push_back(region.j2 ? fem::j2_material(count, E, nu, region.yield_stress, region.hardening, initial)
                              : fem::elastic_material(count, E, nu, initial));
  }
  regions_.assign(parts.begin() + 1, parts.end());
  material_.emplace(scene_.regions.empty() ? parts[0] : fem::composite_material(parts, setup_.points.group));
  density_.clear();
  for (std::size_t i = 0; i < setup_.points.group.size(); ++i) {
    if (setup_.points.group[i] > 0) {
      density_.push_back(scene_.regions[setup_.points.group[i] - 1].density);
    } else {
      const dem::State& s = setup_.states[setup_.points.start[setup_.points.rve_of[i]]];
      density_.push_back(dem::total_mass(s.grains) / s.boundary.cell.volume());
    }
  }
  if (scene_.weighs()) setup_.problem->set_gravity(scene_.gravity, density_);
}

/// The RVEs, which ask nothing of other ranks where these have their own.
fem::Material BvpRun::grains() {
  fem::Material m = rves_->material();
  m.respond = [this, respond = m.respond](const fem::Points& p) {
    const Patience::Work by_itself = across_.work();
    return respond(p);
  };
  return m;
}

/// The RVEs behind the average of what they are told.
fem::Material BvpRun::regularise() {
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < setup_.points.group.size(); ++i)
    if (setup_.points.group[i] == 0) points.push_back(i);
  std::vector<std::array<double, 36>> stiffness;
  try {
    across_.together([&] { stiffness = coupling::start_stiffness(*model_, setup_.states, setup_.points.start); });
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: regularisation: {}", scene_.file, e.what()));
  }
  try {
    regularised_.emplace(*setup_.problem, grains(), points, stiffness, *scene_.regularisation);
  } catch (const std::invalid_argument& e) {  // on all ranks
    throw InputError(fmt::format("{}: regularisation.length: {}", scene_.file, e.what()));
  }
  return regularised_->material();
}

fem::InitialStress BvpRun::initial_stress(std::size_t region) const {
  fem::InitialStress all;
  const Region& r = scene_.regions[region];
  const double density = setup_.density > 0 ? setup_.density : r.density;
  for (std::size_t i = 0; i < setup_.points.group.size() && (r.initial_stress || scene_.ground); ++i)
    if (setup_.points.group[i] == region + 1)
      all.push_back(r.initial_stress ? *r.initial_stress
                                     : ground_stress(scene_, setup_.problem->point_position(i), density));
  return all;
}

/// Shows how far the run is before every sweep through the points, or before some; hears there what cannot wait for the
/// end of an increment.
void BvpRun::watch_responses(Course& c) {
  if (across_.spread()) agree_on_responses();
  material_->respond = [this, &c, respond = material_->respond](const fem::Points& p) {
    if (!scene_.is_explicit() || c.sweeps % 64 == 0)
      c.progress.show(c.time / scene_.end_time(), output_->line(c.sweeps));
    if (!scene_.is_explicit()) {
      const int any = across_.any((c.limit.past() ? 1 : 0) | (interruption_asked() ? 2 : 0));
      if ((any & 2) != 0 && !(rves_ && rves_->puts_off())) throw dem::Interrupted("within an increment");
      if ((any & 2) != 0 && !std::exchange(c.told, true))
        c.progress.note("  interrupted: ends with this increment, as RVEs were put off; once more ends at once");
      if (any & 1) throw OutOfTime{};
    }
    ++c.sweeps;
    return respond(p);
  };
}

/// Whether the solver is to stop after this step, or increment: for a checkpoint, or because the mesh is cut anew.
bool BvpRun::halts(Course& c) {
  c.owed = c.due(scene_.checkpoint_interval);
  c.cut = cut_pays(c);
  return c.owed || c.cut;
}

/// A row; false where the solver is to stop.
template <class Report>
bool BvpRun::after(Course& c, const Report& report, double now) {
  c.time = now;
  output_->add(report, elapsed_ + c.clock.wall() - c.ready);
  if constexpr (requires { report.cut_reason; })
    if (!report.cut_reason.empty())
      c.progress.note(fmt::format("  increment {}: {} cutback(s), the last because {}", report.increment,
                                  report.cutbacks, one_line(report.cut_reason)));
  // An increment that lasts longer than those before it may be lost, what comes before it not.
  const bool last = !scene_.is_explicit() && across_.any(c.limit.over(3) ? 1 : 0) != 0;
  halts(c);
  c.stop = c.why();
  if (c.owed || last) save(c, report);
  return c.stop == Stop::none && !c.cut;
}

/// From checkpoint to checkpoint, and from cut to cut; returns the last report.
template <class Report, class Solve>
Report BvpRun::march(Course& c, Solve&& solve) {
  Report last = begin<Report>();
  while (true) {
    const auto result = solve(last);
    last = result.last;
    c.complete = result.finished;
    c.failure = result.failure;
    if (!c.gains.empty()) {
      c.complete = false, c.failure = c.gains;
      return last;
    }
    if (!result.stopped || c.stop != Stop::none) return last;
    if (c.owed) c.stop = c.why(), save(c, last);
    if (c.stop != Stop::none) return last;
    if (c.cut) cut_anew(c);
  }
}

/// The solver that the scene names.
void BvpRun::solve(Course& c) {
  const auto halts_here = [&] { return halts(c); };
  fem::Wishes wishes;
  if (across_.spread())
    wishes = {[&] { return c.wishes(scene_.checkpoint_interval); }, [&](int any) { c.heard = any; }};
  if (scene_.dynamics) {
    fem::DynamicsOptions with = *scene_.dynamics;
    with.stop = halts_here, with.wishes = wishes;
    const auto row = [&](const fem::DynamicsReport& r) {
      const double dt = r.time / static_cast<double>(r.steps);
      if (c.time == 0)
        c.progress.note(fmt::format("  time step {:.3g} s, about {:.3g} steps in all", dt, with.duration / dt));
      return after(c, r, r.time);
    };
    c.end = march<fem::DynamicsReport>(c, [&](const fem::DynamicsReport& from) {
              return fem::solve_dynamics(*setup_.problem, *material_, density_, with, row, from);
            }).time;
  } else if (scene_.explicit_statics) {
    fem::ExplicitStaticsOptions with = *scene_.explicit_statics;
    with.stop = halts_here, with.wishes = wishes;
    const auto row = [&](const fem::ExplicitStaticsReport& r) {
      const bool on = after(c, r, r.load_factor);
      if (r.load_factor > 0.02 && output_->given() > with.max_energy_error)
        c.gains = fmt::format("regularisation_J has fallen by {:.2g} % of the largest energy: points strain apart",
                              100 * output_->given());
      return on && c.gains.empty();
    };
    c.end = march<fem::ExplicitStaticsReport>(c, [&](const fem::ExplicitStaticsReport& from) {
              return fem::solve_explicit_statics(*setup_.problem, *material_, with, row, from);
            }).load_factor;
  } else {
    const auto start = begin<fem::StaticsStart>();
    fem::StaticsStart kept = start;
    std::optional<dem::BetweenIncrements> before;
    if (rves_) before = rves_->between_increments();
    const auto row = [&](const fem::IncrementReport& r) {
      kept = start_after(r);
      if (rves_) before = rves_->between_increments();
      return after(c, r, r.load_factor);
    };
    if (rves_ && !rves_->puts_off() && !across_.spread()) rves_->watch([](double) { return !interruption_asked(); });
    fem::StaticsResult result;
    try {
      result = fem::solve_statics(*setup_.problem, *material_, scene_.solve, row, start);
    } catch (const dem::Interrupted&) {  // in the midst of an increment, which --resume begins anew
      if (before) rves_->forget(*before);
      c.stop = Stop::asked, c.end = c.time;
      if (kept.increments > 0) save(c, kept);
      return;
    }
    c.complete = result.converged;
    c.failure = result.failure;
    c.end = result.load_factor;
  }
}

BvpEnding BvpRun::go(double ready, const Clock& clock) {
  Course c{clock, across_,      ready, Progress(options_),
           0,     clock.wall(), 0,     TimeLimit(options_.started, options_.max_time)};
  watch_responses(c);
  try {
    solve(c);
  } catch (const InputError&) {
    throw;
  } catch (const dem::Unstable&) {
    throw;
  } catch (const OutOfTime&) {
    c.stop = Stop::time;
    c.end = c.time;
  } catch (const std::exception&) {  // of the system, such as a full disk: what there is may still be kept
    if (c.apart || !across_.agreed()) throw;
    c.broken = true;
    c.failure = dem::caught().text;
    c.end = c.time;
  }
  BvpEnding ending;
  ending.preparation = ready, ending.time = c.end;
  ending.earlier = elapsed_, ending.cpu = elapsed_cpu_ + cpu_seconds();
  ending.sweeps_wall = elapsed_sweeps_ + (rves_ ? rves_->seconds() : 0);
  ending.prepared = setup_.prepared;
  ending.cuts = balance_.cuts, ending.imbalance = balance_.imbalance();
  if (c.broken) {
    ending.status = failed, ending.text = c.failure;
  } else if (c.stop != Stop::none && !kept_here_) {
    ending.status = interrupted;
    ending.text = fmt::format("{} within the first increment; nothing to go on from yet",
                              c.stop == Stop::asked ? "interrupted" : "the time of --max-time is over");
  } else if (c.stop == Stop::asked) {
    ending.status = interrupted, ending.text = "interrupted; --resume goes on from checkpoint.h5";
  } else if (c.stop == Stop::time) {
    ending.status = out_of_time, ending.text = "out of time; --resume goes on from checkpoint.h5";
  } else {
    ending.status = c.complete ? finished : unstable, ending.text = c.complete ? "finished" : c.failure;
  }
  ending.wall = clock.wall();
  c.progress.finish(output_->closing(ending));
  if (c.stop != Stop::none) c.progress.note("  " + ending.text);
  for (const std::string& note : output_->notes()) c.progress.note("  note: " + note);
  return ending;
}

template <class Report>
void BvpRun::save(Course& c, const Report& report) {
  const Clock writing;
  nlohmann::json about;
  if constexpr (std::is_same_v<Report, fem::IncrementReport>)
    about["standing"] = app::save(start_after(report));
  else
    about["standing"] = app::save(report);
  about["program"] = "grus-bvp";
  about["scene"] = *scene_.record;
  if (scene_.has_rve) about["unit_cell"] = *scene_.unit_cells[0].record;
  about["output"] = output_->state(), about["balance"] = app::save(balance_);
  about["wall"] = elapsed_ + c.clock.wall() - c.ready;
  about["cpu"] = elapsed_cpu_ + cpu_seconds(), about["sweeps_wall"] = elapsed_sweeps_ + (rves_ ? rves_->seconds() : 0);
  if (across_.spread())
    write_sharded_checkpoint(std::move(about));
  else
    write_whole_checkpoint(std::move(about));
  c.owed = false, c.saved = c.clock.wall();
  c.limit.wrote(writing.wall());
  if (checkpoint_asked()) c.progress.note(fmt::format("  checkpoint written at {:.4g}, as asked", c.time));
  checkpoint_written();
  kept_here_ = true;
}

void BvpRun::write_whole_checkpoint(nlohmann::json about) {
  auto pack = [](const std::vector<double>& v) {
    return std::string(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(double));
  };
  const fem::Snapshot macro = setup_.problem->snapshot();
  about["columns"] = {macro.at_nodes, macro.of_cells};
  dem::write_checkpoint(result_file(options_.directory, "checkpoint.h5"), about.dump(), [&](const dem::TakePart& take) {
    take(output_->history().text());
    take(pack(macro.values));
    for (const auto& r : regions_) take(r.save());
    if (regularised_) take(regularised_->save());
    if (rves_) rves_->save(take);
  });
}

/// Where to go on from: the beginning, or where the checkpoint stands.
template <class Start>
Start BvpRun::begin() {
  Start start;
  across_.tell(0, kept_.about);  // rank 0 has read it
  if (!kept_.about.empty()) try {
      app::load(resume().at("standing"), start);
    } catch (const nlohmann::json::exception&) {
      throw InputError(checkpoint_of(options_) + ": checkpoint is damaged: where the run stands");
    }
  return start;
}

nlohmann::json BvpRun::resume() {
  dem::Checkpoint kept = std::move(kept_);
  auto about = nlohmann::json::parse(kept.about);
  const std::string path = checkpoint_of(options_) + ": ";
  try {
    if (across_.spread()) take_costs(kept_costs(kept));
    kept.parts.resize(std::max(kept.parts.size(), std::size_t{2}));  // other ranks hear of them
    across_.tell(0, kept.parts[0]);
    app::load(about.at("balance"), balance_);
    if (across_.spread())
      across_.tell(0, kept.parts[1]), take_shards(about, kept.parts[1]);
    else
      take_parts(about, kept.parts);
    output_->restore(about["output"], kept.parts.front());
    elapsed_ = about.at("wall"), elapsed_cpu_ = about.at("cpu"), elapsed_sweeps_ = about.at("sweeps_wall");
  } catch (const InputError& e) {
    const std::string text = e.what();
    throw InputError(text.starts_with("checkpoint.h5: ") ? path + text.substr(15) : path + text);
  } catch (const std::invalid_argument& e) {
    throw InputError(path + e.what());
  } catch (const nlohmann::json::exception&) {
    throw InputError(path + "checkpoint is damaged: what it tells of itself");
  }
  kept_here_ = true;
  return about;
}

/// Takes on what one file holds of a problem on one rank, and leaves the history of its parts.
void BvpRun::take_parts(const nlohmann::json& about, std::vector<std::string>& parts) {
  auto unpack = [](const std::string& bytes) {
    std::vector<double> v(bytes.size() / sizeof(double));
    std::memcpy(v.data(), bytes.data(), v.size() * sizeof(double));
    if (bytes.size() % sizeof(double) != 0 ||
        !std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); }))
      throw std::invalid_argument("checkpoint is damaged: displacements");
    return v;
  };
  const auto columns = about.at("columns").get<std::array<std::vector<std::string>, 2>>();
  setup_.problem->restore({columns[0], columns[1], unpack(parts[1])});
  for (std::size_t r = 0; r < regions_.size(); ++r) regions_[r].load(parts[2 + r]);
  std::size_t used = 2 + regions_.size();
  if (regularised_) regularised_->load(parts[used++]);
  const std::string history = std::move(parts.front());
  parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(used));
  if (rves_) rves_->load(parts);
  parts = {history};
}

}  // namespace grus::app
