// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/probes.hpp"

#include <fmt/format.h>

#include "apps/run/folder.hpp"
#include "dem/io/archive.hpp"
#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/measure.hpp"
#include "fem/exact_sum.hpp"

namespace grus::app {
Probes::Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem,
               const BvpPoints& points, const std::vector<dem::State>& states, const coupling::RveMaterial* rves,
               AcrossRanks& across)
    : directory_(directory),
      scene_(scene),
      problem_(problem),
      points_(points),
      states_(states),
      rves_(rves),
      across_(across) {
  for (const Probe& probe : scene.probes) {
    if (probe.where) {
      std::vector<std::uint8_t> some(problem.owned_points());
      for (std::size_t i = 0; i < some.size(); ++i) some[i] = probe.where(problem.point_position(i)) ? 1 : 0;
      probes_.push_back({&probe, 0, 0, some, probe_columns(probe.name, {true, false, false}), {}});
      continue;
    }
    const auto [rank, point] = nearest(probe.at);
    const bool cell = across.any(rank == across.rank() && points.rve_of[point] != SIZE_MAX ? 1 : 0) != 0;
    if ((probe.frames || probe.grading) && !cell)
      throw InputError(fmt::format("{}: probe \"{}\" lies in an elastic region, which has no grains to show",
                                   scene.file, probe.name));
    probes_.push_back({&probe, rank, point, {}, probe_columns(probe.name, {false, cell, probe.grading}), {}});
  }
}

std::pair<int, std::size_t> Probes::nearest(const fem::Point& place) const {
  const auto distance2 = [&](std::size_t i) {
    const fem::Point x = problem_.point_position(i);
    double d2 = 0;
    for (std::size_t k = 0; k < 3; ++k) d2 += (x[k] - place[k]) * (x[k] - place[k]);
    return d2;
  };
  double least = INFINITY;
  for (std::size_t i = 0; i < problem_.owned_points(); ++i) least = std::min(least, distance2(i));
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, problem_.comm());
  std::int64_t mine = INT64_MAX, key = 0;
  std::size_t point = 0;
  for (std::size_t i = 0; i < problem_.owned_points(); ++i) {
    const double d2 = distance2(i);
    if (std::abs(d2 - least) <= 1e-12 * d2 && problem_.point_key(i) < mine) mine = problem_.point_key(i), point = i;
  }
  MPI_Allreduce(&mine, &key, 1, MPI_INT64_T, MPI_MIN, problem_.comm());
  int rank = mine == key ? across_.rank() : -1;
  MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MAX, problem_.comm());
  return {rank, point};
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
  const auto sums = fem::sums_over_ranks<4>(problem_.comm(), across_.spread(), [&](auto& sum) {
    for (std::size_t i = 0; i < some.size(); ++i) {
      const std::size_t rve = points_.rve_of[i];
      if (some[i] == 0 || rve == SIZE_MAX) continue;
      const dem::Facts& facts = rves_->facts(rve);
      sum[0] += points_.volume[rve] * facts.void_ratio, sum[1] += points_.volume[rve];
      sum[2] += static_cast<double>(facts.grains), sum[3] += static_cast<double>(facts.breakages);
    }
  });
  row.void_ratio = sums[1] > 0 ? sums[0] / sums[1] : NAN;
  row.grains = sums[2], row.breakages = sums[3];
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
    std::vector<double> values(f.columns.size());
    if (f.probe->where) values = values_of(f.columns, of_place(f.some));
    if (!f.probe->where && f.rank == across_.rank()) values = values_of(f.columns, of_point(f.point, f.probe->grading));
    if (!f.probe->where && across_.spread())
      MPI_Bcast(values.data(), static_cast<int>(values.size()), MPI_DOUBLE, f.rank, problem_.comm());
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

double Probes::stress(const std::string& name, int component) const {
  for (const Found& f : probes_)
    if (f.probe->name == name && f.probe->where)
      return problem_.mean_stress(f.some)[static_cast<std::size_t>(component)];
    else if (f.probe->name == name)
      return problem_.stress()[6 * f.point + static_cast<std::size_t>(component)];
  return NAN;
}

void Probes::frame(std::size_t number, double time) {
  for (Found& f : probes_) {
    if (!f.probe->frames) continue;
    const std::string name = fmt::format("grains_{}/grains_{:05}.hdf", f.probe->name, number);
    f.series.emplace_back(name, time);
    std::optional<dem::State> grains;
    if (f.rank == across_.rank()) grains = rves_->committed(points_.rve_of[f.point]);
    if (f.rank != 0) {  // rank 0 writes, wherever the grains live
      std::string bytes = grains ? dem::bytes_of(*grains) : "";
      across_.tell(f.rank, bytes);
      if (across_.leads()) grains = dem::state_of(bytes);
    }
    across_.lead([&] {
      dem::write_grains(result_file(directory_, name), *grains);
      dem::write_series(result_file(directory_, fmt::format("grains_{}.hdf.series", f.probe->name)), f.series);
    });
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
