// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp_output.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "dem/io/vtkhdf.hpp"
#include "dem/io/whole_file.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

const char* const components[6] = {"xx", "yy", "zz", "yz", "xz", "xy"};

double total(double mine, MPI_Comm comm) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, comm);
  return all;
}

double worst(double mine, MPI_Comm comm) {
  double all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, comm);
  return all;
}

}  // namespace

BvpOutput::BvpOutput(std::string directory, const BvpScene& scene, fem::Problem& problem, const coupling::RveMaterial& rves, bool writes)
    : directory_(std::move(directory)), scene_(scene), problem_(problem), rves_(rves), writes_(writes), probes_(directory_, scene, problem, rves) {
  std::vector<std::string> columns{"increment", "time_s", "newton_iterations", "cutbacks", "residual"};
  for (const auto& b : problem.boundaries())
    for (char k : {'x', 'y', 'z'}) columns.push_back(fmt::format("reaction_{}_{}_N", b.name, k));
  for (const char* name : {"mean_strain_zz", "mean_stress_zz_Pa", "rves", "rves_advanced", "dem_steps", "breakages", "wall_s"}) columns.emplace_back(name);
  for (const char* ij : components)
    if (std::string(ij) != "zz") columns.push_back(fmt::format("mean_strain_{}", ij)), columns.push_back(fmt::format("mean_stress_{}_Pa", ij));
  for (const char* name : {"correction", "rve_noise", "volume_m3", "worst_unbalanced_force", "worst_stress_change", "worst_rve_energy_error", "mass_lost_fraction"}) columns.emplace_back(name);
  for (auto& name : probes_.columns()) columns.push_back(std::move(name));
  if (!writes_) return;
  history_.emplace((std::filesystem::path(directory_) / "history.csv").string(), columns);
  if (scene.frames > 0) std::filesystem::create_directories(std::filesystem::path(directory_) / "macro");
}

void BvpOutput::add(const fem::IncrementReport& r, double wall) {
  const MPI_Comm comm = problem_.comm();
  const auto strain = problem_.mean_strain(), stress = problem_.mean_stress();
  const coupling::SweepReport& report = rves_.report();
  std::vector<double> row{static_cast<double>(r.increment), r.load_factor, static_cast<double>(r.iterations), static_cast<double>(r.cutbacks), r.residual};
  for (std::size_t b = 0; b < problem_.boundaries().size(); ++b)
    for (double v : problem_.reaction(b)) row.push_back(v);
  strain_ = strain[2], stress_ = stress[2];
  breakages_ = total(static_cast<double>(rves_.breakages()), comm);
  steps_ = total(static_cast<double>(report.dem_steps), comm);
  iterations_ += r.iterations, cutbacks_ += r.cutbacks;
  double error = 0, mass = 0, lost = 0;
  for (std::size_t i = 0; i < rves_.points(); ++i) {
    const dem::State& s = rves_.committed(i);
    error = std::max(error, std::abs(dem::energy_error(s.ledger, dem::stored_energy(scene_.unit_cells[0].model, s))));
    lost += s.ledger.fines.mass;
    mass += s.ledger.fines.mass + dem::total_mass(s.grains);
  }
  row.insert(row.end(), {strain[2], stress[2], static_cast<double>(problem_.global_points()), total(static_cast<double>(report.advanced), comm), steps_, breakages_, wall});
  for (std::size_t k = 0; k < 6; ++k)
    if (k != 2) row.push_back(strain[k]), row.push_back(stress[k]);
  row.insert(row.end(), {r.correction, r.noise, problem_.current_volume(), worst(report.worst_unbalanced, comm), worst(report.worst_stress_change, comm), worst(error, comm),
                         total(lost, comm) / total(mass, comm)});
  const std::vector<double> probed = probes_.row();
  row.insert(row.end(), probed.begin(), probed.end());
  if (writes_) {
    history_->add(row);
    history_->save(2);
    if (!r.cut_reason.empty()) fmt::print("  increment {}: {} cutback(s), the last because {}\n", r.increment, r.cutbacks, r.cut_reason);
  }
  if (scene_.frames > 0 && r.load_factor >= static_cast<double>(series_.size()) / std::max(1, scene_.frames - 1) * (1 - 1e-9)) frame(r.load_factor);
}

void BvpOutput::frame(double load_factor) {
  const fem::MacroFields fields = problem_.gather_fields();
  // Void ratio, breakages a starting grain and worst unbalanced force of the cell's RVEs.
  std::vector<double> cells;
  const auto per_cell = static_cast<std::size_t>(problem_.points_per_cell());
  for (std::size_t i = 0; i < rves_.points(); ++i) {
    if (i % per_cell == 0) cells.insert(cells.end(), {0, 0, 0});
    const dem::State& s = rves_.committed(i);
    double* at = cells.data() + cells.size() - 3;
    at[0] += (s.boundary.cell.volume() / dem::solid_volume(s.grains) - 1) / static_cast<double>(per_cell);
    at[1] += static_cast<double>(s.ledger.breakages) / static_cast<double>(s.grains.size() - s.ledger.breakages) / static_cast<double>(per_cell);
    at[2] += static_cast<double>(s.grains.size()) / static_cast<double>(per_cell);
  }
  const std::vector<double> all = problem_.gather_cells(cells);
  const std::string name = fmt::format("macro/macro_{:05}.hdf", series_.size());
  probes_.frame(series_.size(), load_factor);
  series_.emplace_back(name, load_factor);
  if (!writes_) return;
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
    grid.types.push_back(fields.cells[c].size() == 8 ? 12 : 10);
    for (double v : fields.stress[c]) stress.values.push_back(static_cast<float>(v));
    grid.cell_fields["void_ratio"].values.push_back(static_cast<float>(all[3 * c]));
    grid.cell_fields["broken_fraction"].values.push_back(static_cast<float>(all[3 * c + 1]));
    grid.cell_fields["grains"].values.push_back(static_cast<float>(all[3 * c + 2]));
  }
  const std::filesystem::path folder = directory_;
  dem::write_vtkhdf((folder / name).string(), grid);
  dem::write_series((folder / "macro.hdf.series").string(), series_);
}

std::string BvpOutput::line(std::uint64_t sweeps) const {
  return fmt::format("strain zz {:.4f}  stress zz {:.3g} MPa  broken {:.0f}  material sweeps {}  DEM steps {:.3g}", strain_, stress_ / 1e6, breakages_, sweeps, steps_);
}

std::string BvpOutput::closing(int status, const fem::StaticsResult& result, double wall) const {
  return fmt::format("{}: load factor {:.4g}, mean strain zz {:.4f}, mean stress zz {:.4g} MPa, {:.0f} breakages, {} Newton iterations, {} cutbacks, {} material sweeps, "
                     "{:.3g} DEM steps in {} ({})",
                     status == finished ? "finished" : status == interrupted ? "interrupted" : "stopped", result.load_factor, strain_, stress_ / 1e6, breakages_,
                     iterations_, cutbacks_, result.law_sweeps, steps_, duration_text(wall), directory_);
}

void BvpOutput::finish(int status, const std::string& ending, const fem::StaticsResult& result, const Options& options, int ranks, double preparation, double wall) {
  const double distinct = total(static_cast<double>(rves_.report().distinct), problem_.comm());
  const double advanced = total(static_cast<double>(rves_.report().advanced), problem_.comm()), seconds = worst(rves_.report().seconds, problem_.comm());
  if (!writes_) return;
  history_->save();
  nlohmann::json summary = provenance();
  summary["title"] = scene_.title;
  summary["scene_file"] = std::filesystem::path(scene_.file).filename().string();
  summary["scene"] = scene_.record;
  summary["unit_cell"] = scene_.unit_cells[0].record;
  summary["status"] = status;
  summary["ending"] = ending;
  summary["seed"] = scene_.unit_cells[0].model.seed;
  summary["threads"] = options.threads;
  summary["ranks"] = ranks;
  summary["counts"] = {{"gauss_points", problem_.global_points()}, {"grains_a_point", scene_.unit_cells[0].state.grains.size()}, {"breakages", breakages_},
                       {"newton_iterations", iterations_}, {"cutbacks", cutbacks_}, {"material_sweeps", result.law_sweeps}, {"rves_advanced", advanced},
                       {"rves_distinct", distinct}, {"rves_asked", static_cast<double>(result.law_sweeps) * static_cast<double>(problem_.global_points())}, {"dem_steps", steps_}};
  const auto& columns = history_->columns();
  for (std::size_t i = 0; i < columns.size() && !history_->last().empty(); ++i) summary["last_row"][columns[i]] = history_->last()[i];
  summary["seconds"] = {{"preparation_wall", preparation}, {"solve_wall", wall - preparation}, {"rve_sweeps_wall", seconds}, {"cpu_rank0", Clock::cpu()}};
  dem::write_whole((std::filesystem::path(directory_) / "summary.json").string(), summary.dump(2) + "\n");
}

}  // namespace grus::app
