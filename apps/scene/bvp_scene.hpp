// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene of grus-bvp: tables -> option structs of fem and dem.
#pragma once

#include <variant>

#include "apps/scene/rve_scene.hpp"
#include "coupling/rve_material.hpp"
#include "fem/dynamics.hpp"
#include "fem/statics.hpp"

namespace grus::app {

/// A Gauss point whose story is told.
struct Probe {
  std::string name;
  fem::Point at{};  // m, in the reference mesh
  bool frames = false, grading = false;
};

/// Cells that are a linear elastic solid instead of grains.
struct Region {
  std::function<bool(const fem::Point&)> where;  // of Gauss points; empty: tag of the cell
  int tag = 0;
  double youngs_modulus = 0, poissons_ratio = 0, density = 0;
};

/// A split Hopkinson bar: which probes are the gauges, and what turns bar strains into a test.
struct Hopkinson {
  std::string incident, transmitted;    // probes on the bars
  double bar_modulus = 0, bar_density = 0, bar_area = 0, specimen_length = 0, specimen_area = 0;
  double incident_distance = 0, transmitted_distance = 0;  // m from gauge to specimen
  int axis = 1;
};

struct BvpScene {
  std::string file, title;
  std::variant<fem::BoxMesh, fem::MshMesh> mesh;
  fem::Point low{}, high{};          // extent of the mesh (m)
  fem::Discretisation discretisation;
  std::vector<fem::BoundaryCondition> boundaries;
  std::vector<Region> regions;
  fem::StaticsOptions solve;
  std::optional<fem::DynamicsOptions> dynamics;  // instead of solve
  std::optional<Hopkinson> hopkinson;
  bool has_rve = false;
  coupling::RveOptions rve;
  int variants = 1;                  // different packings, dealt to the Gauss points in turn
  std::vector<RveScene> unit_cells;  // one for each variant
  int frames = 0;
  bool costs = false;                // costs.csv: what every RVE cost in every sweep
  double checkpoint_interval = 300;  // s of wall time; an interrupted run writes one in any case
  std::vector<Probe> probes;
  nlohmann::json record;
  std::vector<std::string> notes;    // what the user should know before it runs

  /// What no residual can be asked to go below: the equilibrium of the cells themselves; 0 without grains.
  double residual_floor() const {
    const dem::QuasiStatic& q = rve.response.quasi_static;
    return has_rve && !dynamics ? std::max(q.unbalanced_force, q.stress_change) : 0;
  }
  bool flat() const { return discretisation.kinematics != fem::Kinematics::solid; }
  bool dynamic() const { return dynamics.has_value(); }
  double end_time() const { return dynamics ? dynamics->duration : 1; }
};

/// Reads a scene and its unit cells. Throws InputError with file, line and key.
BvpScene read_bvp_scene(const std::string& file, const std::vector<std::string>& overrides);

}  // namespace grus::app
