// SPDX-License-Identifier: LGPL-3.0-or-later
// When a grain cleaves (Saleme Ruiz 2016, chapter 3, corrected): the tractions on planes through it, as flaws feel
// them.
#pragma once

#include <optional>
#include <type_traits>
#include <vector>

#include "dem/base/tensor.hpp"

namespace grus::dem {

class LoadedHull;

/// K_I / K_Ic + (K_II / (C K_Ic))^2 >= 1 on a plane (the thesis squares the first term, which is unsafe by up to a
/// third), K = Y x traction x sqrt(pi a). Linear in the load: the load over that at which it breaks.
inline double mixed_mode(double opening, double sliding) {
  return 0.5 * (opening + std::sqrt(opening * opening + 4 * sliding * sliding));
}

/// A plane that a grain may cleave along, seen from its mass centre (global).
struct Cleft {
  double utilisation = 0;
  Vec3 normal = Vec3::Zero();
  double offset = 0;              // m
  double tension = 0, shear = 0;  // largest on it (Pa)
};

struct Cleavage {
  /// A plane of a crystal.
  struct Plane {
    Vec3 normal;       // unit, crystal frame
    double toughness;  // Pa m^1/2
  };

  double toughness = 0;                 // Pa m^1/2, of planes where the crystal has none of its own
  double flaw = 0;                      // half length (m)
  double geometry = 1;                  // Y: 1 in the middle, 1.12 at an edge
  double mode_ratio = 0.816;            // C = K_IIc / K_Ic
  std::vector<Plane> planes = {};       // none: across the most tensile direction, and where the shear is largest
  std::vector<double> offsets = {0.0};  // of the mass centre's distance from the surface, -1 to 1
  std::optional<double> gate = {};      // mean stress (Pa, tension-positive) that a grain must have to cleave at all

  /// Smaller parts than this, of the grain's volume, are not split off.
  static constexpr double least_share = 0.01;
  /// Planes are looked at once the stress of the grain is this near to what the weakest needs.
  static constexpr double worth_a_look = 0.3;

  /// The plane nearest to failing, tractions by all that acts on one side less its inertia. A grain far from failing:
  /// an estimate by its stress, no plane.
  Cleft worst(const LoadedHull& grain, double factor) const;

  /// How near a grain is to its cleft, 1 at it. A grain that is no hull, which nobody can cut, may break at any time.
  template <class G>
  double utilisation(const G& grain, double factor) const {
    if constexpr (std::is_same_v<G, LoadedHull>)
      return worst(grain, factor).utilisation;
    else
      return 1;
  }
  std::optional<Vec3> plane(const auto&, double) const { return std::nullopt; }
};

}  // namespace grus::dem
