// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene of grus-bvp: tables -> option structs of fem and dem.
#pragma once

#include "apps/scene/rve_scene.hpp"
#include "coupling/rve_material.hpp"
#include "fem/statics.hpp"

namespace grus::app {

/// A Gauss point whose story is told.
struct Probe {
  std::string name;
  fem::Point at{};  // m, in the reference mesh
  bool frames = false, grading = false;
};

struct BvpScene {
  std::string file, title;
  fem::BoxMesh mesh;
  fem::Discretisation discretisation;
  std::vector<fem::BoundaryCondition> boundaries;
  fem::StaticsOptions solve;
  dem::QuasiStatic quasi_static;
  coupling::RveOptions rve;
  int variants = 1;                  // different packings, dealt to the Gauss points in turn
  std::vector<RveScene> unit_cells;  // one for each variant
  int frames = 0;
  std::vector<Probe> probes;
  nlohmann::json record;
};

/// Reads a scene and its unit cells. Throws InputError with file, line and key.
BvpScene read_bvp_scene(const std::string& file, const std::vector<std::string>& overrides);

/// "z=max", "x=min and y=0", "z>0.01": planes and half-spaces of the mesh's box, joined by `and`.
/// Throws std::invalid_argument with what is wrong.
std::function<bool(const fem::Point&)> parse_where(const std::string& text, const fem::Point& box);

}  // namespace grus::app
