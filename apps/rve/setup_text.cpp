// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/setup_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/run/command.hpp"
#include "apps/scene/stage_scene.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

/// What is known of a number that goes with the number of steps: a test that a stress ends takes as a rule far fewer,
/// whatever its step does.
std::string bound_text(bool falls, bool may_end_before) {
  if (may_end_before) return "at most about";
  return falls ? "at least about" : "about";
}

constexpr std::size_t least_graded = 20;  // grains that have a grading
constexpr double told_time = 0.1;         // s of a preparation, below which nobody asks for it

std::string grading_text(const dem::Grading& g) {
  return fmt::format("  d10 {:.4g} mm   d50 {:.4g} mm   d90 {:.4g} mm   Cu = d60/d10 {:.3g}\n", 1e3 * g.diameter(0.1),
                     1e3 * g.diameter(0.5), 1e3 * g.diameter(0.9), g.diameter(0.6) / g.diameter(0.1));
}

}  // namespace

std::string setup_text(const RveScene& scene, const dem::State& s, double grains, const Rehearsal* found) {
  const dem::Measurement m = dem::measure(scene.model, s);
  const double whole = grains / static_cast<double>(s.grains.size());
  const std::string piece = whole != 1 ? fmt::format("   (from a piece of {} grains)", s.grains.size()) : "";
  std::string text =
      fmt::format("{}\n  grains {:.0f}   mean diameter {:.4g} m   ", scene.title, grains, dem::mean_diameter(s.grains));
  if (m.volume > 0)
    text += fmt::format("solid fraction {:.4f}   void ratio {:.4f}   bulk density {:.4g} g/cm^3   ", m.solid_fraction,
                        std::max(0.0, m.void_ratio), dem::total_mass(s.grains) / m.volume / 1000);
  text += fmt::format("contacts {:.0f}{}{}\n", whole * static_cast<double>(m.contacts),
                      s.bonds.empty() ? "" : fmt::format("   bonds {}", s.bonds.size()), piece);
  if (m.volume > 0 && s.grains.size() >= least_graded && s.bonds.empty())
    text += grading_text(dem::Grading(s, scene.scale));
  const double bytes =
      whole * (static_cast<double>(s.grains.size()) * 600 + static_cast<double>(s.contacts.size()) * 260);
  const bool staged = !scene.test.stages.empty(), timed = !staged || known_duration(scene.test);
  if (staged) text += fmt::format("  stages {}   rows about {:.0f} ", scene.test.stages.size(), rows_of(scene.test));
  const bool stress_ends = scene.test.final_stress && !scene.test.stress_time;
  const double step = timed ? std::min(s.dt, scene.test.duration) : s.dt;
  text += fmt::format("  time step {:.3g} s", step);
  if (timed) text += fmt::format("   duration {}{:.4g} s", stress_ends ? "at most " : "", scene.test.duration);
  if (found)
    text += fmt::format("   steps {}", steps_text(*found));
  else if (timed)
    text += fmt::format("   steps {} {:.3g}", bound_text(scene.model.numerics.time_step <= 0, stress_ends),
                        scene.test.duration / step);
  text += fmt::format("   memory about {:.3g} MB", bytes / 1e6);
  if (found) text += fmt::format("\n  run time {} ({})", time_text(*found, whole), basis_text(*found));
  if (found && whole * found->prepared >= told_time)
    text += "\n  preparation about " + duration_text(whole * found->prepared);
  if (!found && !timed) text += "   (the time depends on when the stages meet their ends)";
  for (const auto& note : scene.notes) text += fmt::format("\n  note: {}", note);
  return text;
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
