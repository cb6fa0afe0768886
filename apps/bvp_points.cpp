// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp_points.hpp"

#include <fmt/format.h>

#include <atomic>
#include <thread>

#include "apps/scene/prepare_sample.hpp"
#include "dem/io/archive.hpp"

namespace grus::app {

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
  points.starts = starts;
  std::sort(points.starts.begin(), points.starts.end());
  points.starts.erase(std::unique(points.starts.begin(), points.starts.end()), points.starts.end());
  for (const Start& s : starts)
    points.start.push_back(static_cast<std::size_t>(std::lower_bound(points.starts.begin(), points.starts.end(), s) -
                                                    points.starts.begin()));
  if (!scene.has_rve && !points.start.empty())
    throw InputError(fmt::format("{}: rve: {} Gauss points lie in no [[region]] and there is no [rve] for them",
                                 scene.file, points.start.size()));
  if (scene.has_rve && points.start.empty())
    throw InputError(fmt::format("{}: rve: every Gauss point lies in a [[region]]; leave [rve] out", scene.file));
  for (const Probe& probe : scene.probes) {
    bool found = !probe.where;
    for (std::size_t i = 0; i < problem.owned_points() && !found; ++i) found = probe.where(problem.point_position(i));
    if (!found) throw InputError(fmt::format("{}: probe \"{}\" holds at no Gauss point", scene.file, probe.name));
  }
  for (std::size_t r = 0; r < scene.regions.size(); ++r)
    if (std::find(points.group.begin(), points.group.end(), r + 1) == points.group.end())
      throw InputError(fmt::format("{}: region[{}]: holds at no Gauss point", scene.file, r));
  return points;
}

namespace {

/// Rank 0 gets what the others have made.
void gather(int rank, int ranks, std::vector<std::string>& errors, std::vector<std::string>& bytes) {
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const int from = static_cast<int>(k % static_cast<std::size_t>(ranks));
    for (std::string* text : {&errors[k], &bytes[k]}) {
      int size = static_cast<int>(text->size());
      if (rank == from && from != 0) {
        MPI_Send(&size, 1, MPI_INT, 0, 0, MPI_COMM_WORLD);
        MPI_Send(text->data(), size, MPI_CHAR, 0, 0, MPI_COMM_WORLD);
      } else if (rank == 0 && from != 0) {
        MPI_Recv(&size, 1, MPI_INT, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        text->resize(static_cast<std::size_t>(size));
        MPI_Recv(text->data(), size, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      }
    }
  }
}

}  // namespace

std::vector<dem::State> prepare_starts(const BvpScene& scene, const std::vector<Start>& starts, int threads,
                                       const dem::Watch& watch) {
  int rank, ranks;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  std::vector<std::size_t> mine;
  for (std::size_t k = static_cast<std::size_t>(rank); k < starts.size(); k += static_cast<std::size_t>(ranks))
    mine.push_back(k);
  std::vector<std::string> bytes(starts.size()),
      errors(starts.size());  // of an error: a letter for its kind, and what it says
  std::atomic<std::size_t> made{0};
  std::atomic<int> stopped{0};
  const auto asking = std::this_thread::get_id();  // one thread shows the progress; all hear that they are to stop
  dem::Team team(threads);
  team.each(mine.size(), [&](std::size_t m) {
    const Start& start = starts[mine[m]];
    const std::string place = fmt::format("{}: ", scene.unit_cells[start.packing].file);
    try {
      dem::Team alone(1);
      RveScene cell = scene.unit_cells[start.packing];
      std::optional<dem::Vec3> stresses;
      if (start.stressed) stresses.emplace(start.stress[0], start.stress[1], start.stress[2]);
      bytes[mine[m]] = dem::bytes_of(prepare_sample(
          cell, alone,
          [&](double, const char*) {
            if (watch && std::this_thread::get_id() == asking &&
                !watch(static_cast<double>(made) / static_cast<double>(mine.size())))
              stopped = 1;
            return stopped == 0;
          },
          stresses));
      ++made;
    } catch (const dem::Interrupted&) {
      stopped = 1;
    } catch (const InputError& e) {
      errors[mine[m]] = std::string("i") + e.what();
    } catch (const dem::Unstable& e) {
      errors[mine[m]] = "u" + place + e.what();
    } catch (const std::exception& e) {
      errors[mine[m]] = "f" + place + e.what();
    }
  });
  int stops = stopped;
  MPI_Allreduce(MPI_IN_PLACE, &stops, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (stops != 0) throw dem::Interrupted("interrupted while unit cells were prepared; nothing to go on from yet");
  gather(rank, ranks, errors, bytes);
  std::vector<dem::State> states;
  if (rank != 0) return states;
  for (const std::string& e : errors) {
    if (e.empty()) continue;
    if (e[0] == 'i') throw InputError(e.substr(1));
    if (e[0] == 'u') throw dem::Unstable(e.substr(1));
    throw std::runtime_error(e.substr(1));
  }
  for (const std::string& b : bytes) states.push_back(dem::state_of(b));
  return states;
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

std::vector<double> cell_means(const std::vector<std::size_t>& rve_of, std::size_t per_cell,
                               const std::function<const dem::Facts&(std::size_t)>& facts) {
  std::vector<double> cells(3 * (rve_of.size() / per_cell), 0.0), with(rve_of.size() / per_cell, 0.0);
  for (std::size_t i = 0; i < rve_of.size(); ++i) {
    if (rve_of[i] == SIZE_MAX) continue;
    const dem::Facts& f = facts(rve_of[i]);
    double* at = cells.data() + 3 * (i / per_cell);
    at[0] += f.void_ratio;
    const auto [broken, whole] = f.bonds + f.bonds_broken > 0 ? std::pair{f.bonds_broken, f.bonds + f.bonds_broken}
                                                              : std::pair{f.breakages, f.grains - f.breakages};
    at[1] += static_cast<double>(broken) / static_cast<double>(whole);
    at[2] += static_cast<double>(f.grains);
    ++with[i / per_cell];
  }
  for (std::size_t k = 0; k < cells.size(); ++k)
    cells[k] = with[k / 3] > 0 ? cells[k] / with[k / 3] : NAN;  // no grains, no void ratio
  return cells;
}

}  // namespace grus::app
