// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/probes.hpp"

#include <fmt/format.h>

#include "apps/run/folder.hpp"
#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
Probes::Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem,
               const BvpPoints& points, const std::vector<dem::State>& states, const coupling::RveMaterial* rves)
    : directory_(directory), scene_(scene), problem_(problem), points_(points), states_(states), rves_(rves) {
  for (const Probe& probe : scene.probes) {
    if (probe.where) {
      std::vector<std::uint8_t> some(problem.owned_points());
      for (std::size_t i = 0; i < some.size(); ++i) some[i] = probe.where(problem.point_position(i)) ? 1 : 0;
      probes_.push_back({&probe, 0, some, probe_columns(probe.name, {true, false, false}), {}});
      continue;
    }
    double nearest = INFINITY;
    std::size_t point = 0;
    for (std::size_t i = 0; i < problem.owned_points(); ++i) {
      const fem::Point x = problem.point_position(i);
      double d2 = 0;
      for (std::size_t k = 0; k < 3; ++k) d2 += (x[k] - probe.at[k]) * (x[k] - probe.at[k]);
      const bool same = std::abs(d2 - nearest) <= 1e-12 * d2;
      if (same ? problem.point_key(i) < problem.point_key(point) : d2 < nearest) nearest = d2, point = i;
    }
    if ((probe.frames || probe.grading) && points.rve_of[point] == SIZE_MAX)
      throw InputError(fmt::format("{}: probe \"{}\" lies in an elastic region, which has no grains to show",
                                   scene.file, probe.name));
    const bool cell = points.rve_of[point] != SIZE_MAX;
    probes_.push_back({&probe, point, {}, probe_columns(probe.name, {false, cell, probe.grading}), {}});
  }
}

std::vector<std::string> Probes::columns() const {
  std::vector<std::string> all;
  for (const Found& f : probes_)
    for (std::string& name : names_of(f.columns)) all.push_back(std::move(name));
  return all;
}

/// Means over the present volume of a place: strain, stress; void ratio over its cells; their grains and breakages.
ProbeRow Probes::of_place(const std::vector<std::uint8_t>& some) const {
  ProbeRow row;
  row.strain = problem_.mean_strain(some), row.stress = problem_.mean_stress(some);
  for (std::size_t k = 3; k < 6; ++k) row.strain[k] *= 0.5;
  double void_ratio = 0, volume = 0;
  for (std::size_t i = 0; i < some.size(); ++i) {
    const std::size_t rve = points_.rve_of[i];
    if (some[i] == 0 || rve == SIZE_MAX) continue;
    const dem::Facts& facts = rves_->facts(rve);
    void_ratio += points_.volume[rve] * facts.void_ratio, volume += points_.volume[rve];
    row.grains += static_cast<double>(facts.grains), row.breakages += static_cast<double>(facts.breakages);
  }
  row.void_ratio = volume > 0 ? void_ratio / volume : NAN;
  return row;
}

ProbeRow Probes::of_point(std::size_t i, bool grading) const {
  ProbeRow row;
  const auto deformation = problem_.deformation().subspan(9 * i, 9);
  dem::Mat3 gradient;
  for (int k = 0; k < 9; ++k) gradient(k / 3, k % 3) = deformation[static_cast<std::size_t>(k)] - (k % 4 == 0 ? 1 : 0);
  const dem::Vec6 strain = dem::to_voigt(0.5 * (gradient + gradient.transpose()));  // tensor components
  for (std::size_t k = 0; k < 6; ++k)
    row.strain[k] = strain[static_cast<Eigen::Index>(k)], row.stress[k] = problem_.stress()[6 * i + k];
  const std::size_t rve = points_.rve_of[i];
  if (rve == SIZE_MAX) return row;
  const dem::State s = rves_->committed(rve);
  const dem::Measurement m = dem::measure(scene_.unit_cells[0].model, s);
  row.void_ratio = m.void_ratio, row.coordination = m.coordination;
  row.grains = static_cast<double>(s.grains.size()), row.breakages = static_cast<double>(s.ledger.breakages);
  if (!grading) return row;
  const dem::Grading first(states_[points_.start[rve]]), now(s);
  row.diameter = {now.diameter(0.1), now.diameter(0.5), now.diameter(0.9)};
  row.einav = dem::einav_breakage(first, now), row.fines = now.fines_fraction();
  return row;
}

std::vector<double> Probes::row() const {
  std::vector<double> all;
  for (const Found& f : probes_) {
    const ProbeRow row = f.some.empty() ? of_point(f.point, f.probe->grading) : of_place(f.some);
    for (const double v : values_of(f.columns, row)) all.push_back(v);
  }
  return all;
}

double Probes::stress(const std::string& name, int component) const {
  for (const Found& f : probes_)
    if (f.probe->name == name && !f.some.empty())
      return problem_.mean_stress(f.some)[static_cast<std::size_t>(component)];
    else if (f.probe->name == name)
      return problem_.stress()[6 * f.point + static_cast<std::size_t>(component)];
  return NAN;
}

void Probes::frame(std::size_t number, double time) {
  for (Found& f : probes_) {
    if (!f.probe->frames) continue;
    const std::string name = fmt::format("grains_{}/grains_{:05}.hdf", f.probe->name, number);
    dem::write_grains(result_file(directory_, name), rves_->committed(points_.rve_of[f.point]));
    f.series.emplace_back(name, time);
    dem::write_series(result_file(directory_, fmt::format("grains_{}.hdf.series", f.probe->name)), f.series);
  }
}

std::vector<std::vector<std::pair<std::string, double>>> Probes::series() const {
  std::vector<std::vector<std::pair<std::string, double>>> all;
  for (const Found& f : probes_) all.push_back(f.series);
  return all;
}

void Probes::restore(const std::vector<std::vector<std::pair<std::string, double>>>& series) {
  for (std::size_t k = 0; k < probes_.size() && k < series.size(); ++k) probes_[k].series = series[k];
}

}  // namespace grus::app
