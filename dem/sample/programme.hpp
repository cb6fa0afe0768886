// SPDX-License-Identifier: LGPL-3.0-or-later
// The programme of a test: what it does with its sample, and when it ends. Plain data.
#pragma once

#include <optional>
#include <vector>

#include "dem/rve/loading.hpp"
#include "dem/sample/stage.hpp"

namespace grus::dem {

enum class TestKind : std::uint8_t {
  uniaxial_strain,
  oedometric_stress,
  isotropic_stress,
  triaxial,
  constant_p,
  true_triaxial,
  velocity_gradient,
  platens,
  rollers,
  staged,
  free
};

/// The gauge that tells the load of a test on Voronoi cells.
struct Gauge {
  std::vector<std::pair<std::size_t, double>> walls;  // and their weights
  Vec3 along = Vec3::Zero();                          // unit, of the motion
  std::size_t moving = 0;                             // wall whose way is the displacement
  double stress_per_load = 0;                         // 1/m^2
};

struct Programme {
  TestKind kind = TestKind::free;
  int axis = 2;
  double strain_rate = 0;                   // 1/s, compression-positive, of the driven axis
  double duration = 0;                      // s; an upper bound where final_stress decides
  double final_strain = 0;                  // between platens, whose times follow from the sample: see `fitted`
  std::optional<double> final_stress = {};  // Pa, compression-positive: ends the test when reached
  std::optional<double> stress_time = {};   // s, at which a stress that is controlled gets there
  Loading loading = {};
  std::optional<Gauge> gauge = {};  // known once the sample is made
  std::vector<Stage> stages = {};   // of a test that is staged: they set axis, rate and loading one after the other
  StageNow now = {};                // which of them
};

}  // namespace grus::dem
