// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/jkr_scene.hpp"

#include <fmt/format.h>

namespace grus::app {
namespace {

constexpr double deepest = 0.1;  // of a radius; half the radius is then the circle's

}  // namespace

void read_jkr(Table& t, dem::Material& m) {
  m.youngs_modulus = t.number("youngs_modulus", dimension::pressure, positive);
  m.contact = dem::Jkr::Of{t.number("work_of_adhesion", dimension::surface_energy, positive)};
  if (t.has("fracture"))
    t.fail("fracture", "contact = \"jkr\" presses spheres that do not break; use \"hertz-mindlin\"");
}

void refuse_sunk(const Table& t, const dem::Material& m, double radius, const std::string& key) {
  const auto* own = std::get_if<dem::Jkr::Of>(&m.contact);
  if (!own) return;
  const double most = dem::Jkr::work_at(m.solid(), radius, deepest);
  if (own->work > most)
    t.fail(key,
           fmt::format("material.{}.work_of_adhesion = {:.3g} J/m^2 alone would press grains of radius {:.3g} m into "
                       "each other by more than {:.0f} % of it; at most {:.3g} J/m^2, or a stiffer material",
                       m.name, own->work, radius, 100 * deepest, most));
}

}  // namespace grus::app
