// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/speeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/scene/packing_scene.hpp"

namespace grus::app {
namespace {

/// Modulus that a material's waves go by (Pa); that of common rock where its contacts are given by a stiffness.
double wave_modulus(const dem::Material& m) {
  if (const auto* hulls = std::get_if<dem::Foundation::Of>(&m.contact); hulls && hulls->modulus > 0)
    return hulls->modulus;
  if (const auto* springs = std::get_if<dem::LinearSpring::Of>(&m.contact); springs && springs->modulus > 0)
    return springs->modulus;
  return m.youngs_modulus;
}

}  // namespace

double fastest_wave(const dem::Model& model) {
  double fastest = 0;
  for (const dem::Material& m : model.materials)
    if (std::isfinite(m.youngs_modulus)) fastest = std::max(fastest, 2 * std::sqrt(wave_modulus(m) / m.density));
  return fastest;
}

void refuse_fast(const Table& t, const std::string& key, double speed, const dem::Model& model) {
  const double most = fastest_wave(model);
  if (speed > most)
    t.fail(key, fmt::format("{:.4g} m/s: faster than any wave in these grains, which are below {:.4g} m/s: they would "
                            "be passed before they could press back",
                            speed, most));
}

void refuse_fast_rate(const Table& t, const std::string& key, double rate, double length, const dem::Model& model) {
  const double most = fastest_wave(model), speed = std::abs(rate) * length;
  if (speed > most)
    t.fail(key,
           fmt::format("{:.4g} 1/s over {:.4g} m is {:.4g} m/s: faster than any wave in these grains; ask for less "
                       "than {:.4g} 1/s",
                       std::abs(rate), length, speed, most / length));
}

void refuse_high_pressure(const Table& t, const std::string& key, double pressure, const dem::Model& model,
                          const std::string& what) {
  double stiffest = 0;
  for (const dem::Material& m : model.materials)
    if (std::isfinite(m.youngs_modulus)) stiffest = std::max(stiffest, wave_modulus(m));
  if (pressure > stiffest)
    t.fail(key,
           fmt::format("{}{:.4g} Pa: above the stiffness of the grains, {:.4g} Pa, which they cannot bear; ask for "
                       "less, or give a stiffer material",
                       what, pressure, stiffest));
}

dem::Vec3 read_velocity(Table& t, const dem::Model& model) {
  dem::Vec3 velocity = vector3(t.numbers_or("velocity", {0, 0, 0}, dimension::speed));
  refuse_fast(t, "velocity", velocity.norm(), model);
  return velocity;
}

}  // namespace grus::app
