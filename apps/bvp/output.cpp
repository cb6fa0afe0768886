// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "apps/bvp/hopkinson.hpp"
#include "apps/run/folder.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/io/whole_file.hpp"
#include "fem/stretch_average.hpp"

namespace grus::app {
namespace {

int vtk_type(fem::CellKind kind) {
  constexpr std::array types{5, 9, 10, 12};  // in the order of CellKind
  return types[static_cast<std::size_t>(kind)];
}

/// Numbers as JSON keeps them bit by bit, those that are none included; and back.
std::vector<std::string> exact(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double v : values) texts.push_back(fmt::format("{:a}", v));
  return texts;
}

std::vector<double> numbers_of(const nlohmann::json& texts) {
  std::vector<double> values;
  for (const auto& t : texts) values.push_back(std::strtod(t.get<std::string>().c_str(), nullptr));
  return values;
}

bool bonded(const BvpScene& scene) {
  return scene.has_rve && !scene.samples.empty() && scene.samples[0] && scene.samples[0]->bonded();
}

}  // namespace

std::vector<std::string> bvp_columns(const BvpScene& scene, const fem::Problem& problem, const Probes& probes) {
  std::vector<std::string> names = names_of(macro_columns({scene, problem, bonded(scene)}));
  for (auto& name : probes.columns()) names.push_back(std::move(name));
  return names;
}

BvpOutput::BvpOutput(std::string directory, const BvpScene& scene, fem::Problem& problem, const BvpPoints& points,
                     const std::vector<dem::State>& states, coupling::RveMaterial* rves,
                     const fem::RegularisedMaterial* regularised, AcrossRanks& across)
    : directory_(std::move(directory)),
      scene_(scene),
      problem_(&problem),
      points_(points),
      states_(states),
      rves_(rves),
      regularised_(regularised),
      across_(across),
      columns_(macro_columns({scene, problem, bonded(scene)})) {
  now_of(problem);
  const std::string file = across.leads() ? result_file(directory_, "history.csv") : "";
  history_.emplace(file, bvp_columns(scene, problem, *probes_));
}

void BvpOutput::now_of(fem::Problem& problem) {
  problem_ = &problem;
  const auto series = probes_ ? probes_->series() : std::vector<decltype(series_)>();
  probes_.emplace(directory_, scene_, problem, points_, states_, rves_, across_);
  probes_->restore(series);
  grains_.clear();
  for (const auto group : points_.group) grains_.push_back(group == 0);
}

void BvpOutput::add(const fem::IncrementReport& r, double wall) {
  macro_work_ = r.energy.work, material_work_ = r.energy.internal;
  iterations_ += r.iterations;
  cutbacks_ += r.cutbacks;
  linear_iterations_ += r.linear_iterations, linear_failures_ += r.linear_failures;
  sweeps_ = r.law_sweeps;
  worst_residual_ = std::max(worst_residual_, r.residual);
  for (std::size_t k = 1; k < r.residuals.size(); ++k)
    if (r.residuals[k] > 0 && r.residuals[k - 1] > 0)
      contraction_.push_back(std::log(r.residuals[k] / r.residuals[k - 1]));
  add({static_cast<double>(r.increment), r.load_factor, static_cast<double>(r.iterations),
       static_cast<double>(r.cutbacks), r.residual, r.correction, r.noise, wall, 0, r.energy.error(), &r.energy});
}

/// Hill and Mandel: the stresses' work against what the materials have taken, relative to the larger.
double BvpOutput::work_error() const {
  const double largest = std::max(std::abs(macro_work_), std::abs(material_work_));
  return largest > 0 ? std::abs(macro_work_ - material_work_) / largest : 0;
}

void BvpOutput::add(const fem::DynamicsReport& r, double wall) {
  macro_work_ = r.energy.work, material_work_ = r.energy.internal;
  sweeps_ = static_cast<int>(r.steps) + 1;  // one for the start
  if (rves_) rves_->refresh();
  add({static_cast<double>(r.steps), r.time, 0, 0, 0, 0, 0, wall, r.energy.kinetic_over_internal(), r.energy.error(),
       &r.energy});
}

void BvpOutput::add(const fem::ExplicitStaticsReport& r, double wall) {
  macro_work_ = r.energy.work, material_work_ = r.energy.internal;
  worst_residual_ = std::max(worst_residual_, r.unbalanced);
  sweeps_ = static_cast<int>(r.steps) + 1;
  if (rves_) rves_->refresh();
  add({static_cast<double>(r.steps), r.load_factor, 0, 0, r.unbalanced, 0, 0, wall, r.energy.kinetic_over_internal(),
       r.energy.error(), &r.energy, &r});
}

double BvpOutput::of_rves(dem::Facts::Number energy) const { return rves_ ? rves_->total(energy, points_.volume) : 0; }

/// What the problem's means and the RVEs have for a row.
void BvpOutput::read_off(MacroRow& r) {
  r.strain = problem_->mean_strain(), r.stress = problem_->mean_stress();
  for (std::size_t b = 0; b < problem_->boundaries().size(); ++b) {
    for (const double v : problem_->reaction(b)) r.reaction.push_back(v);
    for (const double v : problem_->mean_displacement(b)) r.moved.push_back(v);
  }
  r.volume = problem_->current_volume(), r.macro_work = macro_work_;
  if (regularised_) r.regularised = regularised_->energy();
  r.grains_strain = r.strain, r.grains_stress = r.stress;
  if (rves_) {
    r.sweep = rves_->report_of_all(), r.rves = static_cast<double>(rves_->all_points());
    r.breakages = static_cast<double>(rves_->count(&dem::Facts::breakages));
    r.bonds_broken = static_cast<double>(rves_->count(&dem::Facts::bonds_broken));
    r.worst_energy_error = rves_->largest([](const dem::Facts& f) { return f.energy_error; });
    const double lost = rves_->sum([](const dem::Facts& f) { return f.lost_mass; });
    const double mass = rves_->sum([](const dem::Facts& f) { return f.mass; });
    r.mass_lost = mass > 0 ? lost / mass : 0;
    r.work = of_rves(&dem::Facts::work), r.unexplained = of_rves(&dem::Facts::unexplained);
    r.haste = of_rves(&dem::Facts::haste);
    r.grains_strain = problem_->mean_strain(grains_), r.grains_stress = problem_->mean_stress(grains_);
  }
  const auto& carried = r.grains_stress;
  r.p = -(carried[0] + carried[1] + carried[2]) / 3;
  double q2 = 0;  // 3/2 of the deviator's square
  for (std::size_t k = 0; k < 6; ++k)
    q2 += k < 3 ? 1.5 * (carried[k] + r.p) * (carried[k] + r.p) : 3 * carried[k] * carried[k];
  r.q = std::sqrt(q2);
  const auto volume = problem_->volumes(rves_ ? grains_ : std::vector<std::uint8_t>{});
  r.volumetric = 1 - volume[1] / volume[0];
}

void BvpOutput::add(MacroRow r) {
  read_off(r);
  const std::size_t axis = scene_.flat() ? 1 : 2;  // in two dimensions z is across the plane, or the hoop
  strain_ = r.strain[axis], stress_ = r.stress[axis], energy_error_ = r.energy_error;
  most_regularised_ = std::max(most_regularised_, r.regularised);  // what the start has let go is in the first row
  fallen_ = std::max(fallen_, most_regularised_ - r.regularised);
  given_ = fallen_ / std::max(r.energy->largest, 1e-300);
  given_up_ = r.sweep.given_up;
  breakages_ = r.breakages, bonds_broken_ = r.bonds_broken, dem_steps_ = static_cast<double>(r.sweep.dem_steps);
  worst_energy_ = std::max(worst_energy_, r.worst_energy_error);
  std::vector<double> row = values_of(columns_, r);
  const std::vector<double> probed = probes_->row();
  row.insert(row.end(), probed.begin(), probed.end());
  history_->add(row);
  across_.lead([&] { history_->save(2); });
  const double part = r.time / scene_.end_time();
  if (scene_.frames > 0 && part >= static_cast<double>(series_.size()) / std::max(1, scene_.frames - 1) * (1 - 1e-9))
    frame(r.time);
}

void BvpOutput::frame(double time) {
  const fem::MacroFields fields = problem_->gather_fields();
  const auto facts = [&](std::size_t k) -> const dem::Facts& { return rves_->facts(k); };
  const auto per_element = static_cast<std::size_t>(problem_->points_per_cell());
  const std::vector<double> all = problem_->gather_cells(element_means(points_.rve_of, per_element, facts));
  const std::string name = fmt::format("macro/macro_{:05}.hdf", series_.size());
  probes_->frame(series_.size(), time);
  series_.emplace_back(name, time);
  across_.lead([&] { write_frame(name, fields, all); });
}

/// `means`: of each element's RVEs, element_means.
void BvpOutput::write_frame(const std::string& name, const fem::MacroFields& fields, const std::vector<double>& means) {
  dem::VtkGrid grid;
  auto& u = grid.point_fields["displacement_m"];
  u.components = 3;
  for (std::size_t n = 0; n < fields.nodes.size(); ++n)
    for (std::size_t k = 0; k < 3; ++k) {
      grid.points.push_back(static_cast<float>(fields.nodes[n][k]));
      u.values.push_back(static_cast<float>(fields.displacement[n][k]));
    }
  grid.offsets.push_back(0);
  auto& stress = grid.cell_fields["stress_Pa"];
  stress.components = 6;
  for (std::size_t c = 0; c < fields.cells.size(); ++c) {
    grid.connectivity.insert(grid.connectivity.end(), fields.cells[c].begin(), fields.cells[c].end());
    grid.offsets.push_back(static_cast<std::int64_t>(grid.connectivity.size()));
    grid.types.push_back(static_cast<std::uint8_t>(vtk_type(fields.kind)));
    for (double v : fields.stress[c]) stress.values.push_back(static_cast<float>(v));
    if (!rves_) continue;
    grid.cell_fields["void_ratio"].values.push_back(static_cast<float>(means[3 * c]));
    grid.cell_fields["broken_fraction"].values.push_back(static_cast<float>(means[3 * c + 1]));
    grid.cell_fields["grains"].values.push_back(static_cast<float>(means[3 * c + 2]));
  }
  dem::write_vtkhdf(result_file(directory_, name), grid);
  dem::write_series(result_file(directory_, "macro.hdf.series"), series_);
}

std::string BvpOutput::line(std::uint64_t sweeps) const {
  double steps = rves_ ? static_cast<double>(rves_->report().dem_steps) : 0.0;
  if (across_.spread()) steps = dem_steps_;  // of all ranks
  return fmt::format(
      "strain {0} {1:.4f}  stress {0} {2:.3g} MPa  broken {3:.0f}{6}  material sweeps {4}  DEM steps {5:.3g}", axis(),
      strain_, stress_ / 1e6 + 0.0, breakages_, sweeps, steps, bonds_text(", bonds "));
}

/// Empty where no face is bonded.
std::string BvpOutput::bonds_text(const char* head) const {
  return bonded(scene_) ? fmt::format("{}{:.0f}", head, bonds_broken_) : "";
}

nlohmann::json BvpOutput::state() const {
  return {{"rows", history_->rows()},
          {"last_row", exact(history_->last())},
          {"shown", exact({strain_, stress_, breakages_, bonds_broken_, energy_error_, fallen_, most_regularised_})},
          {"series", series_},
          {"probe_series", probes_->series()},
          {"contraction", contraction_},
          {"macro_work", macro_work_},
          {"material_work", material_work_},
          {"worst_residual", worst_residual_},
          {"worst_energy", worst_energy_},
          {"iterations", iterations_},
          {"cutbacks", cutbacks_},
          {"linear", {linear_iterations_, linear_failures_}},
          {"sweeps", sweeps_}};
}

void BvpOutput::restore(const nlohmann::json& s, const std::string& history) {
  history_->restore(history, s.at("rows"), numbers_of(s.at("last_row")));
  const std::vector<double> shown = numbers_of(s.at("shown"));
  strain_ = shown.at(0), stress_ = shown.at(1), breakages_ = shown.at(2), bonds_broken_ = shown.at(3);
  energy_error_ = shown.at(4), fallen_ = shown.at(5), most_regularised_ = shown.at(6);
  series_ = s.at("series").get<decltype(series_)>();
  probes_->restore(s.at("probe_series").get<std::vector<decltype(series_)>>());
  contraction_ = s.at("contraction").get<std::vector<double>>();
  macro_work_ = s.at("macro_work"), material_work_ = s.at("material_work");
  worst_residual_ = s.at("worst_residual"), worst_energy_ = s.at("worst_energy");
  iterations_ = s.at("iterations");
  cutbacks_ = s.at("cutbacks");
  linear_iterations_ = s.at("linear").at(0), linear_failures_ = s.at("linear").at(1);
  sweeps_ = s.at("sweeps");
}

/// What the last row says in a column; 0 where it is not there.
double BvpOutput::last(double (*of)(const MacroRow&, std::size_t)) const {
  const auto c = find_column(columns_, of);
  return c ? history_->last().at(*c) : 0;
}

/// What numerical devices have taken or put in, of the larger of what the loads have done and the grains have taken.
nlohmann::json BvpOutput::devices() const {
  const double done = std::max(std::abs(of_rves(&dem::Facts::work)), std::abs(last(macro_column::external_work)));
  nlohmann::json all;
  auto put = [&](const char* name, double joule) { all[name] = done > 0 ? joule / done : 0; };
  put("local_damping_of_cells", of_rves(&dem::Facts::local_damping));
  const auto& cells = scene_.unit_cells;
  if (bonded(scene_)) put("bond_damping_of_cells", of_rves(&dem::Facts::bond_damping));
  if (std::any_of(cells.begin(), cells.end(), [](const auto& c) { return c.model.numerics.scales_inertia(); }))
    put("scaled_inertia_of_cells", of_rves(&dem::Facts::scaled_inertia));
  if (scene_.explicit_statics) {
    put("haste_of_cells", of_rves(&dem::Facts::haste));
    put("macro_damping", last(macro_column::damped)), put("scaled_masses", last(macro_column::scaled));
  }
  return all;
}

/// What the RVEs have done and how well.
void BvpOutput::add_rves(nlohmann::json& summary, const BvpEnding& e) const {
  const coupling::SweepReport r = rves_->report_of_all();
  summary["unit_cell"] = *scene_.unit_cells[0].record;
  summary["seed"] = scene_.unit_cells[0].model.seed;
  auto& counts = summary["counts"];
  counts["grains_a_point"] = states_[points_.start.empty() || across_.spread() ? 0 : points_.start[0]].grains.size();
  counts["rves"] = rves_->all_points();
  counts["rves_asked"] = r.asked, counts["rves_advanced"] = r.advanced, counts["rves_distinct"] = r.distinct,
  counts["rves_deferred"] = r.deferred, counts["rves_elastic"] = r.elastic;
  counts["rves_similar"] = r.similar, counts["rves_replayed"] = r.replayed, counts["rves_retried_in_parts"] = r.retried,
  counts["rves_moved_between_ranks"] = e.migrated;
  if (across_.ranks() > 1 && scene_.is_explicit()) counts["mesh_cuts"] = e.cuts, summary["imbalance"] = e.imbalance;
  counts["dem_steps"] = r.dem_steps;
  auto& errors = summary["errors"];
  errors["rve_work_J"] = of_rves(&dem::Facts::work);
  if (!scene_.is_explicit()) errors["residual_floor"] = scene_.residual_floor();
  if (scene_.explicit_statics) counts["rves_given_up"] = r.given_up;
  const auto told = [&](const char* device, const char* tolerance, double value, const coupling::MeasuredError& by,
                        const char* measured) {
    const auto known = [&](double error) { return by.count > 0 ? nlohmann::json(error) : nlohmann::json(nullptr); };
    errors[device] = {{tolerance, value}, {measured, by.count}, {"worst", known(by.worst)}, {"mean", known(by.mean())}};
  };
  if (scene_.rve.error > 0) {
    told("deferral", "tolerance", scene_.rve.error, r.deferral, "measured");
    errors["deferral"]["least_trust"] = r.least_trust;
  }
  if (scene_.rve.response.elastic >= 0)
    told("elastic", "tolerance_force_share", scene_.rve.response.elastic, r.linear, "measured");
  if (scene_.rve.share > 0) {
    told("sharing", "tolerance_strain", scene_.rve.share, r.sharing, "measured_at_replays");
    errors["sharing"]["largest_correction"] = r.correction;
  }
  summary["seconds"]["rve_sweeps_wall"] = e.sweeps_wall;
}

void BvpOutput::finish(const BvpEnding& e, const Options& options) {
  across_.lead([&] { history_->save(); });
  nlohmann::json summary = provenance();
  summary["title"] = scene_.title;
  std::vector<std::string> told = scene_.notes;
  for (const std::string& note : notes()) told.push_back(note);
  if (!told.empty()) summary["notes"] = told;
  summary["scene_file"] = std::filesystem::path(scene_.file).filename().string();
  summary["scene"] = *scene_.record;
  summary["status"] = e.status;
  summary["ending"] = e.text;
  summary["threads"] = options.threads;
  summary["ranks"] = e.ranks;
  summary["counts"] = {
      {"gauss_points", problem_->global_points()}, {"breakages", breakages_}, {"bonds_broken", bonds_broken_},
      {"newton_iterations", iterations_},          {"cutbacks", cutbacks_},   {"material_sweeps", sweeps_}};
  if (scene_.solve.linear == fem::LinearMethod::iterative) {
    summary["counts"]["linear_iterations"] = linear_iterations_;
    summary["counts"]["linear_solves_made_direct"] = linear_failures_;
  }
  summary["errors"] = {{"macro_work_J", macro_work_}, {"hill_mandel", work_error()}};
  if (!scene_.dynamic()) summary["errors"]["worst_residual"] = worst_residual_;
  if (rves_) summary["errors"]["worst_rve_energy_error"] = worst_energy_;
  summary["mesh"] = {{"low_m", scene_.low}, {"high_m", scene_.high}};
  if (!e.prepared.is_null()) summary["preparation"] = e.prepared;
  if (regularised_)
    summary["errors"]["regularisation"] = {{"degree", regularised_->degree()},
                                           {"promised", fem::StretchAverage::promised},
                                           {"worst", regularised_->worst_left_over()}};
  if (scene_.ground && rves_) {
    summary["counts"]["initial_stresses"] = points_.stresses, summary["counts"]["starts"] = points_.starts.size();
    summary["errors"]["initial_stress"] = {{"tolerance", scene_.ground->tolerance}, {"worst", points_.deviation}};
  }
  summary["seconds"] = {{"preparation_wall", e.preparation}, {"solve_wall", e.solve_wall()}, {"cpu_rank0", e.cpu}};
  if (!contraction_.empty()) {
    double mean = 0;
    for (const double v : contraction_) mean += v / static_cast<double>(contraction_.size());
    summary["newton_contraction"] = std::exp(mean);  // geometric mean of the ratio of successive residuals
  }
  if (rves_) add_rves(summary, e);
  const auto& columns = history_->columns();
  for (std::size_t i = 0; i < columns.size() && !history_->last().empty(); ++i)
    summary["last_row"][columns[i]] = history_->last()[i];
  std::vector known{macro_column::energy_error};  // what this run has computed
  if (!scene_.is_explicit()) known.push_back(macro_column::correction);
  if (!scene_.is_explicit() && rves_)
    known.insert(known.end(), {macro_column::worst_unbalanced, macro_column::worst_stress_change});
  const bool told_row = !history_->last().empty();
  for (const auto of : known)
    if (const auto c = find_column(columns_, of); c && told_row)
      summary["errors"]["last_" + columns_[*c].name] = history_->last()[*c];
  if (rves_ && told_row) summary["errors"]["devices"] = devices();
  across_.lead([&] {
    if (scene_.hopkinson && history_->rows() > 1)
      write_hopkinson(result_file(directory_, "hopkinson.csv"), *scene_.hopkinson, history_->text());
    const std::string last = result_file(directory_, "summary.json");
    summary["files"] = result_files(directory_);
    dem::write_whole(last, summary.dump(2) + "\n");
  });
}

}  // namespace grus::app
