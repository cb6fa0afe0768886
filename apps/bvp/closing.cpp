// SPDX-License-Identifier: LGPL-3.0-or-later
// What is said at the end of a macro run.
#include <fmt/format.h>

#include "apps/bvp/output.hpp"
#include "fem/linear_options.hpp"

namespace grus::app {

/// Empty where there is one rank, or no balance is kept.
std::string BvpOutput::balance_text(const BvpEnding& e) const {
  if (across_.ranks() == 1 || !rves_ || !scene_.is_explicit()) return "";
  return fmt::format(", the fullest rank {:.2f} times the mean, {} cut{}", e.imbalance, e.cuts, e.cuts == 1 ? "" : "s");
}

std::string BvpOutput::closing(const BvpEnding& e) const {
  const double steps = rves_ ? static_cast<double>(rves_->report_of_all().dem_steps) : 0.0;
  const char* how = e.status == finished      ? "finished"
                    : e.status == interrupted ? "interrupted"
                    : e.status == out_of_time ? "out of time"
                                              : "stopped";
  if (scene_.is_explicit())
    return fmt::format("{}: {:.4g} {}, mean stress {} {:.4g} MPa, {:.0f} breakages{}, {:.3g} DEM steps{} in {} ({})",
                       how, scene_.dynamics ? e.time : 100 * e.time, scene_.dynamics ? "s" : "% of the load", axis(),
                       stress_ / 1e6 + 0.0, breakages_, bonds_text(", broken bonds "), steps, balance_text(e),
                       duration_text(e.earlier + e.wall), directory_);
  return fmt::format(
      "{0}: load factor {1:.4g}, mean strain {2} {3:.4f}, mean stress {2} {4:.4g} MPa, {5:.0f} breakages{12}, {6} "
      "Newton iterations, {7} cutbacks, {8} material sweeps, {9:.3g} DEM steps in {10} ({11})",
      how, e.time, axis(), strain_, stress_ / 1e6 + 0.0, breakages_, iterations_, cutbacks_, sweeps_, steps,
      duration_text(e.earlier + e.wall), directory_, bonds_text(", broken bonds "));
}

std::vector<std::string> BvpOutput::notes() const {
  std::vector<std::string> all;
  const char* mend = scene_.is_explicit() ? "shorter steps (solve)" : "more solve.increments";
  if (std::abs(energy_error_) > most_energy_error)
    all.push_back(
        fmt::format("the macro balance of energy is off by {:.2g} % (energy_error): stresses change too much "
                    "within a step; take {}",
                    100 * energy_error_, mend));
  if (given_ > most_given)
    all.push_back(fmt::format(
        "regularisation_J has fallen by {:.2g} % of the largest energy: points within regularisation.length of each "
        "other strain apart; a larger regularisation.memory holds them",
        100 * given_));
  if (given_up_ > 0)
    all.push_back(fmt::format("RVEs have given up at {} points, and answer elastically from then on", given_up_));
  if (!scene_.is_explicit())
    for (const std::string& option : fem::unused_linear_options())
      all.push_back(fmt::format("PETSc has no use for its option {}: misspelt?", option));
  return all;
}

}  // namespace grus::app
