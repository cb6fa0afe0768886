// SPDX-License-Identifier: LGPL-3.0-or-later
// The seam between the finite elements and what answers at a Gauss point.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace grus::fem {

/// A block of Gauss points; row-major, tension-positive, Voigt order xx yy zz yz xz xy, engineering shear.
struct Points {
  std::span<const double> deformation;  // (n, 9): F of this increment against the committed state, F_n+1 F_n^-1
  std::span<double> stress;             // (n, 6) Cauchy, Pa
  std::span<double> tangent;            // (n, 36) d stress / d strain, Pa; empty where it is not asked for
  double duration = 0;                  // s of real time that the increment takes; 0: quasi-static
};

/// Answers for all points of a rank. Always starts from the committed state. All five of the first must be given: a
/// material that forgets its state in a checkpoint goes on wrong without a word, and one that cannot tell its energy
/// makes a balance blind.
struct Material {
  Material(std::function<bool(const Points&)> responds, std::function<void()> commits,
           std::function<std::string()> saves, std::function<void(const std::string&)> loads,
           std::function<double(std::span<const double>)> tells_energy)
      : respond(std::move(responds)),
        commit(std::move(commits)),
        save(std::move(saves)),
        load(std::move(loads)),
        energy(std::move(tells_energy)) {}

  std::function<bool(const Points&)> respond;    // false: this increment cannot be taken; `reason` says why
  std::function<void()> commit;                  // the last response becomes the committed state
  std::function<std::string()> save;             // bytes of the committed state, for a checkpoint
  std::function<void(const std::string&)> load;  // throws std::invalid_argument for bytes of another problem
  /// The energy that the committed state holds and has spent of the work done on it since the start (J), the points
  /// having these reference volumes (m^3): from the state, not from the work of the stresses.
  std::function<double(std::span<const double>)> energy;
  /// Relative error of the stress, below which no residual can go; the same on all ranks.
  std::function<double()> noise = [] { return 0.0; };
  /// A dearer, better tangent from the next response on, for this increment and some after it; false: there is none, or
  /// it is given already.
  std::function<bool()> sharpen = [] { return false; };
  std::function<double()> inertial_number = [] { return 0.0; };  // mean of its points in the last response; of grains
  std::function<std::string()> reason = [] { return std::string(); };
  /// For exact sums: `energy` of each point by itself (J); and the inertial numbers of the points that have one, in the
  /// last response. Empty: this material cannot tell.
  std::function<void(std::span<const double> volumes, std::span<double> energies)> energies;
  std::function<std::span<const double>()> inertial_numbers = [] { return std::span<const double>(); };
};

/// Stress that points have before they are strained (Pa, Voigt), one for each; empty: none.
using InitialStress = std::vector<std::array<double, 6>>;

/// Stiffness of linear isotropic elasticity (Pa), row by row: Voigt xx, yy, zz, yz, xz, xy, engineering shear.
std::array<double, 36> elastic_stiffness(double youngs_modulus, double poissons_ratio);

/// Linear isotropic elasticity in the strain U - 1 of the whole deformation F = R U, its stress turned by R: objective,
/// and the same whatever the increments.
Material elastic_material(std::size_t points, double youngs_modulus, double poissons_ratio,
                          const InitialStress& initial = {});

/// Von Mises plasticity with linear isotropic hardening (Pa) in the same strain; radial return, consistent tangent.
Material j2_material(std::size_t points, double youngs_modulus, double poissons_ratio, double yield_stress,
                     double hardening, const InitialStress& initial = {});

/// One material for each group of points; `group[i]` says whose point i is. A group's points keep their order.
Material composite_material(std::vector<Material> parts, const std::vector<std::size_t>& group);

}  // namespace grus::fem
