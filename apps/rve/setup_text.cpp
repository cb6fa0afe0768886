// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/setup_text.hpp"

#include <fmt/format.h>

#include "apps/run/command.hpp"
#include "apps/scene/stage_scene.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

/// Why the time step falls while a test goes on; empty: it stays.
std::string falling_step(const dem::Model& model) {
  if (model.numerics.time_step > 0) return "";
  return fmt::format("the time step falls as contacts form{}{}", dem::stiffens(model.law) ? " and stiffen" : "",
                     model.breakable() ? ", and as grains break" : "");
}

/// What is known of a number that goes with the number of steps: a bound, or not even that.
std::string bound_text(bool falls, bool may_end_before) {
  if (falls == may_end_before) return "about";
  return falls ? "at least about" : "at most about";
}

}  // namespace

std::string setup_text(const RveScene& scene, const dem::State& s, double grains, double wall_estimate) {
  const dem::Measurement m = dem::measure(scene.model, s);
  const double whole = grains / static_cast<double>(s.grains.size());
  const std::string piece = whole != 1 ? fmt::format("   (from a piece of {} grains)", s.grains.size()) : "";
  std::string text =
      fmt::format("{}\n  grains {:.0f}   mean diameter {:.4g} m   ", scene.title, grains, dem::mean_diameter(s.grains));
  if (m.volume > 0)
    text += fmt::format("solid fraction {:.4f}   bulk density {:.4g} g/cm^3   ", m.solid_fraction,
                        dem::total_mass(s.grains) / m.volume / 1000);
  text += fmt::format("contacts {:.0f}{}\n", whole * static_cast<double>(m.contacts), piece);
  const double bytes =
      whole * (static_cast<double>(s.grains.size()) * 600 + static_cast<double>(s.contacts.size()) * 260);
  const std::string falling = falling_step(scene.model);
  const bool stress_ends = scene.test.final_stress && !scene.test.stress_time;
  const std::string bound = bound_text(!falling.empty(), stress_ends);
  const auto notes = [&] {
    for (const auto& note : scene.notes) text += fmt::format("\n  note: {}", note);
    return text;
  };
  if (!scene.test.stages.empty()) {
    text += fmt::format("  stages {}   rows at most {:.0f}   ", scene.test.stages.size(), rows_of(scene.test));
    if (!known_duration(scene.test)) {
      text += fmt::format("time step {:.3g} s   memory about {:.3g} MB   (how long stages take hangs on their ends)",
                          s.dt, bytes / 1e6);
      return notes();
    }
  }
  text +=
      fmt::format("  time step {:.3g} s   duration {}{:.4g} s   steps {} {:.3g}   memory about {:.3g} MB", s.dt,
                  stress_ends ? "at most " : "", scene.test.duration, bound, scene.test.duration / s.dt, bytes / 1e6);
  if (wall_estimate > 0) {
    text += fmt::format("   run time {} {}", bound, duration_text(wall_estimate));
    if (!falling.empty())
      text += fmt::format(" ({}{})", falling, stress_ends ? "; final_stress may end the test before" : "");
  }
  return notes();
}

void refuse_endless(const RveScene& scene, const dem::State& s) {
  if (!scene.test.stages.empty() && !known_duration(scene.test)) return;  // told as it runs
  if (dem::endless(s, scene.test.duration))
    throw dem::InputError(
        fmt::format("{}: loading: a time step of {:.3g} s would take {:.3g} steps to {:.3g} s: stiffness, density, "
                    "size or speed of the grains, or the rate, is out of all bounds",
                    scene.file, s.dt, scene.test.duration / s.dt, scene.test.duration));
}

}  // namespace grus::app
