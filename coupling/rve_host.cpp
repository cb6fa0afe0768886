// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_host.hpp"

#include <chrono>

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/rve/tangent.hpp"

namespace grus::coupling {

RveHost::RveHost(std::shared_ptr<const dem::Model> model, const ResponseOptions& options, int threads)
    : model_(std::move(model)), options_(options), team_(threads) {}

void RveHost::put(std::uint64_t slot, dem::State state) { rves_[slot] = std::make_unique<dem::Rve>(model_, options_.quasi_static, std::move(state)); }

std::vector<Outcome> RveHost::advance(const std::vector<Task>& tasks) {
  std::vector<Outcome> outcomes(tasks.size());
  std::vector<dem::Rve*> rves;
  for (const Task& t : tasks) rves.push_back(rves_.at(t.slot).get());
  team_.each(tasks.size(), [&](std::size_t k) {
    const auto begin = std::chrono::steady_clock::now();
    const Task& task = tasks[k];
    dem::Response& response = outcomes[k].response;
    try {
      if (task.real_time) {
        response = rves[k]->advance_in_time(task.path.front(), task.duration, task.tangent);
      } else {
        std::uint64_t steps = 0;
        for (std::size_t i = 0; i < task.path.size(); ++i) {
          response = rves[k]->advance({task.path[i]});
          steps += response.steps;
          if (!response.stable) break;
          if (i + 1 < task.path.size()) rves[k]->commit();
        }
        response.steps = steps;
        if (options_.tangent == TangentKind::perturbation && response.stable) {
          dem::Team alone(1);
          response.tangent = dem::perturbation_tangent(*model_, options_.quasi_static, rves[k]->trial(), options_.perturbation, options_.central, response.steps, alone);
        }
      }
    } catch (const std::exception& e) {  // must not leave a thread
      response = {};
      response.failure = e.what();
    }
    outcomes[k].seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  });
  return outcomes;
}

Facts RveHost::facts(std::uint64_t slot) const {
  const dem::State& s = committed(slot);
  Facts f;
  f.stored = dem::stored_energy(*model_, s);
  f.energy_error = std::abs(dem::energy_error(s.ledger, f.stored));
  f.work = s.ledger.work;
  f.dissipated = s.ledger.friction + s.ledger.damping + s.ledger.fracture;
  f.lost_mass = s.ledger.fines.mass;
  f.mass = f.lost_mass + dem::total_mass(s.grains);
  f.void_ratio = s.boundary.cell.volume() / dem::solid_volume(s.grains) - 1;
  f.grains = s.grains.size(), f.breakages = s.ledger.breakages, f.steps = s.steps;
  return f;
}

}  // namespace grus::coupling
