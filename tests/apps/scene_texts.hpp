// SPDX-License-Identifier: LGPL-3.0-or-later
// Two scenes of grus-rve and how they are read with changes.
#pragma once

#include <fstream>

#include "apps/scene/rve_scene.hpp"
#include "tests/apps/scratch.hpp"

namespace grus::app::test {

inline const std::string sand = R"(
material.sand = { density = 2500, youngs_modulus = "9 GPa", friction = 0.5 }
boundary.kind = "periodic"
[packing]
kind = "random"
box = ["10 mm", "12 mm", "14 mm"]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
[loading]
kind = "free"
duration = 1
)";

inline const std::string rock = R"(
material.rock.density = 2500
material.rock.contact = "overlap"
material.rock.friction = 0.3
material.rock.bond = { modulus = "10 GPa", tension = "2 MPa", cohesion = "3 MPa", fracture_energy = 5 }
packing = { kind = "voronoi", box = ["20 mm", "10 mm", "10 mm"], cells = 60 }
loading = { kind = "free", duration = 1 }
)";

/// A scene with changes, as --set takes them.
inline RveScene read(const std::string& text, const std::vector<std::string>& sets = {}, bool cell = false) {
  const Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << text;
  return (cell ? read_unit_cell : read_rve_scene)(file, sets);
}

}  // namespace grus::app::test
