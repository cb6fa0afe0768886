// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/probes.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
namespace {

const char* const components[6] = {"xx", "yy", "zz", "yz", "xz", "xy"};
const char* const facts[] = {"void_ratio", "coordination", "grains", "breakages"};
const char* const grading_facts[] = {"d10_m", "d50_m", "d90_m", "breakage_einav", "fines_fraction"};

}  // namespace

Probes::Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem, const coupling::RveMaterial& rves)
    : directory_(directory), scene_(scene), problem_(problem), rves_(rves) {
  for (const Probe& probe : scene.probes) {
    double nearest = INFINITY, over_all = 0;
    std::ptrdiff_t point = -1;
    for (std::size_t i = 0; i < problem.owned_points(); ++i) {
      const fem::Point x = problem.point_position(i);
      double d2 = 0;
      for (std::size_t k = 0; k < 3; ++k) d2 += (x[k] - probe.at[k]) * (x[k] - probe.at[k]);
      const bool same = std::abs(d2 - nearest) <= 1e-12 * d2;
      if (same ? problem.point_key(i) < problem.point_key(static_cast<std::size_t>(point)) : d2 < nearest) nearest = d2, point = static_cast<std::ptrdiff_t>(i);
    }
    MPI_Allreduce(&nearest, &over_all, 1, MPI_DOUBLE, MPI_MIN, problem.comm());
    const bool candidate = point >= 0 && nearest <= over_all * (1 + 1e-12);
    std::int64_t key = candidate ? problem.point_key(static_cast<std::size_t>(point)) : std::numeric_limits<std::int64_t>::max(), lowest = 0;
    MPI_Allreduce(&key, &lowest, 1, MPI_INT64_T, MPI_MIN, problem.comm());
    probes_.push_back({&probe, candidate && key == lowest ? point : -1, {}});
    if (probe.frames && scene.frames > 0 && probes_.back().point >= 0)
      std::filesystem::create_directories(std::filesystem::path(directory) / ("grains_" + probe.name));
  }
}

std::vector<std::string> Probes::columns() const {
  std::vector<std::string> c;
  for (const Found& f : probes_) {
    const std::string head = "probe_" + f.probe->name + "_";
    for (const char* ij : components) c.push_back(fmt::format("{}strain_{}", head, ij));
    for (const char* ij : components) c.push_back(fmt::format("{}stress_{}_Pa", head, ij));
    for (const char* name : facts) c.push_back(head + name);
    if (f.probe->grading)
      for (const char* name : grading_facts) c.push_back(head + name);
  }
  return c;
}

std::vector<double> Probes::row() const {
  std::vector<double> mine;
  for (const Found& f : probes_) {
    if (f.point < 0) {
      mine.insert(mine.end(), 12 + std::size(facts) + (f.probe->grading ? std::size(grading_facts) : 0), 0.0);
      continue;
    }
    const auto i = static_cast<std::size_t>(f.point);
    const auto deformation = problem_.deformation().subspan(9 * i, 9);
    dem::Mat3 gradient;
    for (int k = 0; k < 9; ++k) gradient(k / 3, k % 3) = deformation[static_cast<std::size_t>(k)] - (k % 4 == 0 ? 1 : 0);
    const dem::Vec6 strain = dem::to_voigt(0.5 * (gradient + gradient.transpose()));  // tensor components
    for (int k = 0; k < 6; ++k) mine.push_back(strain[k]);
    for (std::size_t k = 0; k < 6; ++k) mine.push_back(problem_.stress()[6 * i + k]);
    const dem::State& s = rves_.committed(i);
    const dem::Model& model = scene_.unit_cells[0].model;
    const dem::Measurement m = dem::measure(model, s);
    mine.insert(mine.end(), {m.void_ratio, m.coordination, static_cast<double>(s.grains.size()), static_cast<double>(s.ledger.breakages)});
    if (!f.probe->grading) continue;
    const auto variant = static_cast<std::size_t>(problem_.point_key(i)) % scene_.unit_cells.size();
    const dem::Grading first(model, scene_.unit_cells[variant].state), now(model, s);
    mine.insert(mine.end(), {now.diameter(0.1), now.diameter(0.5), now.diameter(0.9), dem::einav_breakage(first, now), now.fines_fraction()});
  }
  std::vector<double> all(mine.size());
  MPI_Allreduce(mine.data(), all.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_SUM, problem_.comm());
  return all;
}

void Probes::frame(std::size_t number, double load_factor) {
  const std::filesystem::path folder = directory_;
  for (Found& f : probes_) {
    if (f.point < 0 || !f.probe->frames) continue;
    const std::string name = fmt::format("grains_{}/grains_{:05}.hdf", f.probe->name, number);
    dem::write_grains((folder / name).string(), rves_.committed(static_cast<std::size_t>(f.point)));
    f.series.emplace_back(name, load_factor);
    dem::write_series((folder / fmt::format("grains_{}.hdf.series", f.probe->name)).string(), f.series);
  }
}

}  // namespace grus::app
