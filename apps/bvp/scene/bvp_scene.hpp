// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene of grus-bvp: tables -> option structs of fem and dem.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <variant>

#include "apps/scene/prepare_sample.hpp"
#include "coupling/rve_material.hpp"
#include "fem/dynamics.hpp"
#include "fem/explicit_statics.hpp"
#include "fem/regularisation.hpp"
#include "fem/statics.hpp"

namespace grus::app {

/// A Gauss point whose story is told, or the mean over those of a place.
struct Probe {
  std::string name;
  fem::Point at{};                               // m, in the reference mesh
  std::function<bool(const fem::Point&)> where;  // empty: the point nearest to `at`
  bool frames = false, grading = false;
};

/// Elements that are a solid instead of grains: linear elastic, or with von Mises plasticity.
struct Region {
  std::function<bool(const fem::Point&)> where;  // of Gauss points; empty: those of elements with one of the tags
  std::vector<int> tags;
  double youngs_modulus = 0, poissons_ratio = 0, density = 0;
  bool j2 = false;
  double yield_stress = 0, hardening = 0;               // Pa
  std::optional<std::array<double, 6>> initial_stress;  // Pa, Voigt
};

/// Ground at rest: what is horizontal is k0 times what is vertical, which grows with depth by the weight.
struct Ground {
  double k0 = 0, surface = 0, surcharge = 0;  // surface: its height (m); surcharge: on it (Pa)
  int axis = 1;
  double tolerance = 0.01;  // points whose stresses are so alike start from one state
};

/// A split Hopkinson bar: which probes are the gauges, and what turns bar strains into a test.
struct Hopkinson {
  std::string incident, transmitted;  // probes on the bars
  double bar_modulus = 0, bar_density = 0, bar_area = 0, specimen_length = 0, specimen_area = 0;
  double incident_distance = 0, transmitted_distance = 0;  // m from gauge to specimen
  int axis = 1;
};

struct BvpScene {
  std::string file, title;
  std::variant<fem::BoxMesh, fem::MshMesh> mesh;
  fem::Point low{}, high{};  // extent of the mesh (m)
  double element = 0;        // mean longest side of its elements (m)
  fem::Discretisation discretisation;
  std::vector<fem::BoundaryCondition> boundaries;
  std::vector<Region> regions;
  fem::Point gravity{};  // m/s^2
  std::optional<Ground> ground;
  fem::StaticsOptions solve;
  std::optional<fem::DynamicsOptions> dynamics;                 // instead of solve
  std::optional<fem::ExplicitStaticsOptions> explicit_statics;  // instead of solve
  bool spread = false;                                          // the macro problem lies on all ranks, not on rank 0
  double patience = 600;                                        // s for which ranks wait for one that is silent
  std::optional<fem::Regularisation> regularisation;            // of the points with grains
  std::optional<Hopkinson> hopkinson;
  bool has_rve = false;
  coupling::RveOptions rve;
  std::optional<double>
      damping;       // local, of the grains in the run; empty: that of their material, or none in explicit runs
  int variants = 1;  // different packings, dealt to the Gauss points in turn
  std::vector<RveScene> unit_cells;                 // one for each variant
  std::vector<std::optional<dem::Sample>> samples;  // of these; random packings are made later
  int frames = 0;
  bool costs = false;                // costs.csv: what every RVE cost in every sweep
  double checkpoint_interval = 300;  // s of wall time; an interrupted run writes one in any case
  std::vector<Probe> probes;
  std::shared_ptr<const nlohmann::json> record;  // the scene as used, defaults included
  std::vector<std::string> notes;                // what the user should know before it runs

  /// No residual can be asked to go below this: the equilibrium of the RVEs themselves; 0 without grains.
  double residual_floor() const {
    const dem::QuasiStatic& q = rve.response.quasi_static;
    return has_rve && !is_explicit() ? std::max(q.unbalanced_force, q.stress_change) : 0;
  }
  /// Quadrilaterals or hexahedra.
  bool bricks() const {
    if (const auto* box = std::get_if<fem::BoxMesh>(&mesh)) return box->hexahedron;
    return fem::bricks(std::get<fem::MshMesh>(mesh).kind);
  }
  bool flat() const { return discretisation.kinematics != fem::Kinematics::solid; }
  /// Its sides, "0.12 x 0.05 m".
  std::string extent() const;
  bool weighs() const { return gravity != fem::Point{}; }
  bool dynamic() const { return dynamics.has_value(); }
  bool is_explicit() const { return dynamics || explicit_statics; }
  double end_time() const { return dynamics ? dynamics->duration : 1; }
};

/// Reads a scene and its unit cells. Throws InputError with file, line and key.
BvpScene read_bvp_scene(const std::string& file, const std::vector<std::string>& overrides);

}  // namespace grus::app
