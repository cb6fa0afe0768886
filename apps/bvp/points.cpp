// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/points.hpp"

#include <fmt/format.h>
#include <numeric>

#include <algorithm>
#include <cmath>

#include "fem/hilbert_cut.hpp"

namespace grus::app {
namespace {

double size(const fem::Point& stress) {
  return std::sqrt(stress[0] * stress[0] + stress[1] * stress[1] + stress[2] * stress[2]);
}

}  // namespace

std::vector<StressClass> stress_classes(const std::vector<Start>& starts, double tolerance) {
  std::vector<StressClass> classes;
  for (std::size_t k = 0; k < starts.size();) {
    const Start& first = starts[k];
    std::size_t end = k + 1;
    if (first.stressed && tolerance > 0)  // midway between a and b the deviations of both are (b - a) / (b + a)
      while (end < starts.size() && starts[end].packing == first.packing &&
             size(starts[end].stress) - size(first.stress) <=
                 tolerance * (size(starts[end].stress) + size(first.stress)))
        ++end;
    StressClass& made = classes.emplace_back(StressClass{first, end - k, 0});
    if (const double a = size(first.stress), b = size(starts[end - 1].stress); end - k > 1) {
      for (double& s : made.start.stress) s *= 2 * b / (a + b);
      made.deviation = (b - a) / (b + a);
    }
    k = end;
  }
  return classes;
}

namespace {

/// Of all ranks, in order, each once.
std::vector<Start> distinct(std::vector<Start> starts, MPI_Comm comm) {
  const auto once = [](std::vector<Start>& all) {
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
  };
  once(starts);
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return starts;
  static_assert(std::is_trivially_copyable_v<Start>);
  const int mine = static_cast<int>(starts.size() * sizeof(Start));
  std::vector<int> counts(static_cast<std::size_t>(ranks)), from(static_cast<std::size_t>(ranks), 0);
  MPI_Allgather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  for (std::size_t r = 1; r < from.size(); ++r) from[r] = from[r - 1] + counts[r - 1];
  std::vector<Start> all(static_cast<std::size_t>(from.back() + counts.back()) / sizeof(Start));
  MPI_Allgatherv(starts.data(), mine, MPI_BYTE, all.data(), counts.data(), from.data(), MPI_BYTE, comm);
  once(all);
  return all;
}

}  // namespace

BvpPoints find_points(const BvpScene& scene, const fem::Problem& problem, double density) {
  BvpPoints points;
  std::vector<Start> starts;  // of each point with grains
  for (std::size_t i = 0; i < problem.owned_points(); ++i) {
    std::size_t group = 0;
    for (std::size_t r = 0; r < scene.regions.size() && group == 0; ++r) {
      const Region& region = scene.regions[r];
      const auto tagged = [&] { return std::count(region.tags.begin(), region.tags.end(), problem.cell_tag(i)) > 0; };
      if (region.where ? region.where(problem.point_position(i)) : tagged()) group = r + 1;
    }
    points.group.push_back(group);
    points.rve_of.push_back(group == 0 ? starts.size() : SIZE_MAX);
    if (group != 0) continue;
    Start& start = starts.emplace_back();
    start.packing = static_cast<std::size_t>(problem.point_key(i)) % static_cast<std::size_t>(scene.variants);
    if (scene.ground) {
      const auto stress = ground_stress(scene, problem.point_position(i), density);
      start.stressed = true, start.stress = {-stress[0], -stress[1], -stress[2]};
    }
    points.volume.push_back(problem.point_volume(i));
  }
  points.starts = distinct(starts, problem.comm());
  const std::vector<StressClass> classes = stress_classes(points.starts, scene.ground ? scene.ground->tolerance : 0);
  std::vector<std::size_t> class_of;  // of each start
  for (std::size_t c = 0; c < classes.size(); ++c) class_of.resize(class_of.size() + classes[c].members, c);
  for (const Start& s : starts)
    points.start.push_back(class_of[static_cast<std::size_t>(
        std::lower_bound(points.starts.begin(), points.starts.end(), s) - points.starts.begin())]);
  points.stresses = points.starts.size();
  points.starts.clear();
  for (const StressClass& c : classes) {
    points.starts.push_back(c.start);
    points.deviation = std::max(points.deviation, c.deviation);
  }
  const auto over_ranks = [&](std::uint64_t mine) {
    MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_UINT64_T, MPI_SUM, problem.comm());
    return mine;
  };
  points.all_rves = over_ranks(points.start.size());
  if (!scene.has_rve && points.all_rves > 0)
    throw InputError(fmt::format("{}: rve: {} Gauss points lie in no [[region]] and there is no [rve] for them",
                                 scene.file, points.all_rves));
  if (scene.has_rve && points.all_rves == 0)
    throw InputError(fmt::format("{}: rve: every Gauss point lies in a [[region]]; leave [rve] out", scene.file));
  for (const Probe& probe : scene.probes) {
    bool found = !probe.where;
    for (std::size_t i = 0; i < problem.owned_points() && !found; ++i) found = probe.where(problem.point_position(i));
    if (over_ranks(found ? 1 : 0) == 0)
      throw InputError(fmt::format("{}: probe \"{}\" holds at no Gauss point", scene.file, probe.name));
  }
  for (std::size_t r = 0; r < scene.regions.size(); ++r)
    if (over_ranks(static_cast<std::uint64_t>(std::count(points.group.begin(), points.group.end(), r + 1))) == 0)
      throw InputError(fmt::format("{}: region[{}]: holds at no Gauss point", scene.file, r));
  return points;
}

std::vector<std::int32_t> equal_parts(const fem::Problem& problem, const BvpPoints& points,
                                      const std::vector<double>& measured) {
  constexpr double of_rest = 1e-3;  // cost of a point without grains, of one with
  const auto per_cell = static_cast<std::size_t>(problem.points_per_cell());
  std::vector<double> owned;  // of each element its middle and its cost
  for (std::size_t first = 0; first < points.group.size(); first += per_cell) {
    std::array<double, 4> of{};
    for (std::size_t i = first; i < first + per_cell; ++i) {
      const fem::Point at = problem.point_position(i);
      for (std::size_t k = 0; k < 3; ++k) of[k] += at[k] / static_cast<double>(per_cell);
      of[3] += points.group[i] == 0 ? 1 : of_rest;
    }
    owned.insert(owned.end(), of.begin(), of.end());
  }
  const std::vector<double> all = problem.gather_cells(owned);
  std::vector<fem::Point> middles;
  std::vector<double> costs;
  for (std::size_t at = 0; at < all.size(); at += 4) {
    middles.push_back({all[at], all[at + 1], all[at + 2]});
    costs.push_back(all[at + 3]);
  }
  const double mean = std::accumulate(measured.begin(), measured.end(), 0.0) / static_cast<double>(costs.size());
  if (measured.size() == costs.size() && mean > 0)
    std::transform(measured.begin(), measured.end(), costs.begin(),
                   [&](double cost) { return std::max(cost, of_rest * mean); });
  int ranks = 1, rank = 0;
  MPI_Comm_size(problem.comm(), &ranks);
  MPI_Comm_rank(problem.comm(), &rank);
  std::vector<std::int32_t> owner;
  if (rank == 0) owner = fem::hilbert_cut(middles, costs, ranks);
  owner.resize(static_cast<std::size_t>(problem.global_points()) / per_cell);
  MPI_Bcast(owner.data(), static_cast<int>(owner.size()), MPI_INT32_T, 0, problem.comm());
  return owner;
}

std::array<double, 6> ground_stress(const BvpScene& scene, const fem::Point& at, double density) {
  const Ground& g = *scene.ground;
  const auto axis = static_cast<std::size_t>(g.axis);
  const double grain = 1e-6 * (scene.high[axis] - scene.low[axis]);  // depths that differ by round-off are one
  const double depth = std::round(std::max(0.0, g.surface - at[axis]) / grain) * grain;
  const double vertical = g.surcharge + density * std::abs(scene.gravity[axis]) * depth;
  std::array<double, 6> stress{-g.k0 * vertical, -g.k0 * vertical, -g.k0 * vertical, 0, 0, 0};
  stress[axis] = -vertical;
  return stress;
}

std::vector<double> element_means(const std::vector<std::size_t>& rve_of, std::size_t per_element,
                                  const std::function<const dem::Facts&(std::size_t)>& facts) {
  std::vector<double> cells(3 * (rve_of.size() / per_element), 0.0), with(rve_of.size() / per_element, 0.0);
  for (std::size_t i = 0; i < rve_of.size(); ++i) {
    if (rve_of[i] == SIZE_MAX) continue;
    const dem::Facts& f = facts(rve_of[i]);
    double* at = cells.data() + 3 * (i / per_element);
    at[0] += f.void_ratio;
    const auto [broken, whole] = f.bonds + f.bonds_broken > 0 ? std::pair{f.bonds_broken, f.bonds + f.bonds_broken}
                                                              : std::pair{f.breakages, f.grains - f.breakages};
    at[1] += static_cast<double>(broken) / static_cast<double>(whole);
    at[2] += static_cast<double>(f.grains);
    ++with[i / per_element];
  }
  for (std::size_t k = 0; k < cells.size(); ++k)
    cells[k] = with[k / 3] > 0 ? cells[k] / with[k / 3] : NAN;  // no grains, no void ratio
  return cells;
}

}  // namespace grus::app
