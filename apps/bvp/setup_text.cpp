// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/setup_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace grus::app {

std::string setup_text(const BvpScene& scene, const BvpSetup& setup, const Options& options, int ranks,
                       double crossing) {
  const fem::Problem& p = *setup.problem;
  const auto rves = setup.points.all_rves;
  double grains = 0;
  const bool made = !setup.states.empty();
  for (const auto& state : setup.states)
    grains += static_cast<double>(state.grains.size()) / static_cast<double>(setup.states.size());
  for (std::size_t k = 0; !made && k < scene.unit_cells.size(); ++k) {
    const auto& sample = scene.samples[k];
    grains += (sample ? static_cast<double>(sample->state.grains.size()) : scene.unit_cells[k].recipe.count()) /
              scene.variants;
  }
  std::string length = fmt::format("increments {}", scene.solve.increments);
  if (scene.dynamics) length = fmt::format("duration {:.3g} s", scene.dynamics->duration);
  if (scene.explicit_statics) length = fmt::format("steps from {:.0f}", scene.explicit_statics->crossings * crossing);
  const int bytes =
      scene.is_explicit() ? 5000 : 8000;  // a grain, measured: trial states, and a checkpoint in the making
  std::string text = fmt::format(
      "{}\n  mesh {}   elements {}   Gauss points {}   with grains {} ({}{:.0f} grains each, {} packings)   {}   "
      "memory "
      "up to "
      "{:.3g} "
      "MB   ranks {} x threads {}",
      scene.title, scene.extent(), p.global_points() / p.points_per_cell(), p.global_points(), rves,
      made ? "" : "about ", grains, scene.unit_cells.size(), length, static_cast<double>(rves) * grains * bytes / 1e6,
      ranks, options.threads);
  if (const auto& e = scene.explicit_statics)
    text += fmt::format(
        "\n  limits of the rate: unbalanced force {:g} of what is applied, kinetic energy {:g} of internal, inertial "
        "number of the RVEs {}; local damping {:g}, safety {:g}",
        e->balance, e->kinetic, e->inertial_number > 0 ? fmt::format("{:g}", e->inertial_number) : "their own",
        e->damping, e->safety);
  if (!scene.is_explicit())
    text += fmt::format(
        "\n  residual to {:.2g}{}", std::max(scene.solve.tolerance, scene.residual_floor()),
        scene.has_rve ? " (the larger of solve.tolerance, rve.unbalanced_force and rve.stress_change)" : "");
  for (const auto& note : scene.notes) text += fmt::format("\n  note: {}", note);
  return text;
}

void check_starts(const BvpScene& scene, const std::vector<Start>& starts) {
  for (const Start& s : starts) {
    const double pressure = (s.stress[0] + s.stress[1] + s.stress[2]) / 3;
    const std::string fault =
        s.stressed ? dem::unbearable(scene.unit_cells[s.packing].model, scene.unit_cells[s.packing].recipe, pressure)
                   : "";
    if (!fault.empty()) throw InputError(fmt::format("{}: initial_stress: {}", scene.file, fault));
  }
}

std::string preparation_text(std::size_t starts, std::size_t variants, int workers, const StartTimes& one) {
  const std::size_t packings = std::min(starts, variants);  // starts of one packing go on from one sample
  const double seconds = rounds_of(packings, workers) * one.packing + rounds_of(starts, workers) * one.stress;
  return fmt::format("  preparation: about {} ({} starts of {} packings; {:.3g} s a packing, {:.3g} s a start)",
                     duration_text(seconds), starts, packings, one.packing, one.stress);
}

std::string run_text(const RunEstimate& run) {
  const std::string time = run.high > 0 ? fmt::format("{} to {}", duration_text(run.low), duration_text(run.high))
                                        : "at least about " + duration_text(run.low);
  return fmt::format("  run: {} ({}); {}", time, run.text, run.rest);
}

std::string failure_text(const BvpScene& scene, const Options& options, const BvpEnding& ending) {
  if (ending.status == failed) return fmt::format("{}: {}", options.scene, ending.text);
  if (ending.status != unstable) return "";
  const char* help =
      "more solve.increments, tighter rve.unbalanced_force or a larger unit cell may help, or explicit-quasi-static";
  if (scene.dynamics) help = "a smaller solve.safety or another unit cell may help";
  if (scene.explicit_statics)
    help = "larger limits in [solve], a larger unit cell or rve.on_failure = \"elastic\" may help";
  if (ending.text.starts_with("regularisation_J")) help = "a larger regularisation.memory may help";
  return fmt::format("{}: {} {:.4g}: {}; {}", options.scene, scene.dynamics ? "time" : "load factor", ending.time,
                     ending.text, help);
}

}  // namespace grus::app
