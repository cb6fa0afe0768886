// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/jkr_scene.hpp"

namespace grus::app {
void read_jkr(Table& t, dem::Material& m) {
  m.youngs_modulus = t.number("youngs_modulus", dimension::pressure, positive);
  m.contact = dem::Jkr::Of{t.number("work_of_adhesion", dimension::surface_energy, positive)};
  if (t.has("fracture"))
    t.fail("fracture", "contact = \"jkr\" presses spheres that do not break; use \"hertz-mindlin\"");
}

}  // namespace grus::app
