// SPDX-License-Identifier: LGPL-3.0-or-later
// A stage of a test that has several: what it does and when it ends; and where such a test is. Plain data, SI units,
// stresses and strains compression-positive.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "dem/base/tensor.hpp"

namespace grus::dem {

enum class StageKind : std::uint8_t { deposit, compress, hold, shear, unload, reload, cyclic, relax };

/// The axes that are not driven: they stand, keep a stress, or keep the volume.
enum class Lateral : std::uint8_t { fixed, held, volume };

/// A cycle turns back where this has its amplitude.
enum class Swing : std::uint8_t { strain, stress, deviator };

/// A stage is over once the first of these is met.
struct StageEnds {
  std::optional<double> stress, deviator;  // Pa: of the axis; of it less the mean of the others
  std::optional<double> strain;            // way of the axis in this stage, of the first size
  std::optional<double> void_ratio;
  std::optional<double> time;              // s, in this stage
  std::optional<double> unbalanced_force;  // of the mean contact force
};

struct Stage {
  std::string name = {}, place = {};
  StageKind kind = StageKind::relax;
  int axis = 2;
  bool all = false;                              // all three axes alike
  std::optional<std::array<int, 2>> plane = {};  // simple shear: along the first, across the second
  double strain_rate = 0;                        // 1/s, of the axis; where a stress is sought a bound
  std::optional<double> stress_rate = {};        // Pa/s, instead
  Lateral lateral = Lateral::fixed;
  std::optional<double> lateral_stress = {};          // Pa, held; none: as the stage finds it
  std::optional<double> friction = {}, damping = {};  // between the grains, and local, in this stage alone
  std::optional<Vec3> gravity = {};                   // m/s^2, from this stage on
  StageEnds until = {};
  bool to_turn = false;                 // ends at the stress from which the last unloading began
  double max_strain = 0, max_time = 0;  // a stage that gets there without its end has failed (s); 0: no bound
  Swing swing = Swing::strain;
  double amplitude = 0;                 // of the swing
  std::uint64_t cycles = 0, rows = 25;  // rows of a leg

  /// A cycle has two legs; the first and the last of all are halves of one.
  std::uint64_t legs() const { return kind == StageKind::cyclic ? 2 * cycles + 1 : 1; }
  /// Its axis goes one way, as far as it goes.
  bool one_way() const { return kind == StageKind::compress || kind == StageKind::unload || kind == StageKind::reload; }
  /// A stress stays, or follows a rate of its own.
  bool holds() const { return kind == StageKind::hold || lateral == Lateral::held || stress_rate.has_value(); }
  /// The axis follows a rate of strain, so that times are known.
  bool by_strain() const { return strain_rate != 0 && !stress_rate && !all; }
};

/// Where a test of several stages is: with the state all that it takes to go on.
struct StageNow {
  std::uint64_t stage = 0, leg = 0, row = 0, level = 0;  // rows and levels of stress of the leg so far
  std::uint64_t first_row = 0;                           // the last one before the stage
  bool begun = false, leg_begun = false;
  double began = 0, leg_began = 0;    // s
  double strain = 0, void_ratio = 0;  // as the stage began
  double leg_from = 0;                // as the leg began: what it turns back by, or is ended by
  double turned = 0;                  // Pa, stress at which the last unloading began
  double row_time = 0;                // s, of the last row
  Vec3 stress = Vec3::Zero();         // Pa, along the axes, as the stage began
};

}  // namespace grus::dem
