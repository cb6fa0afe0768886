// SPDX-License-Identifier: LGPL-3.0-or-later
// When a grain breaks (Zhang et al. 2015, 3.1-3.2). Every criterion answers with a utilisation: >= 1 breaks.
#pragma once

#include <algorithm>
#include <optional>

#include "dem/base/random.hpp"
#include "dem/base/tensor.hpp"

namespace grus::dem {

/// sigma_1 = sigma_3 + s sqrt(m sigma_3 / s + 1), compression-positive (eq 14); s, the compressive strength, in Pa.
struct HoekBrown {
  double compressive_strength = 0, m = 0;

  /// `stress` tension-positive, `factor` multiplies the strength. Below the apex (sigma_3 <= -s/m) the grain has
  /// failed.
  double utilisation(const Mat3& stress, double factor) const {
    Eigen::SelfAdjointEigenSolver<Mat3> eigen;
    eigen.computeDirect(stress, Eigen::EigenvaluesOnly);
    const double s1 = -eigen.eigenvalues()[0], s3 = -eigen.eigenvalues()[2], s = factor * compressive_strength;
    const double root = m * s3 / s + 1;
    if (root <= 0) return std::max(1.0, -s3 * m / s);
    return (s1 - s3) / (s * std::sqrt(root));
  }
};

inline constexpr int most_critical_contacts = 100;

/// Largest tensile stress at the rim of a Hertz contact, (1 - 2 nu)/3 q0 with q0 = 3F/(2 pi a^2) (eq 17).
/// A grain breaks once `critical_contacts` contacts reach the strength (Pa).
struct ContactTension {
  double strength = 0;
  int critical_contacts = 3;

  static double tension(double force, double contact_radius, double poissons_ratio) {
    return (1 - 2 * poissons_ratio) / 3 * 1.5 * force / (pi * contact_radius * contact_radius);
  }
};

/// Strength of a grain = characteristic strength x (ln 1/P)^(1/modulus) (r / reference_radius)^-size_exponent (eq 18,
/// whose exponent -2w is a misprint: -3/w in three dimensions). P is the grain's own uniform draw.
struct Weibull {
  double modulus = 1, reference_radius = 0, size_exponent = 3;

  double factor(double radius, double p) const {
    return std::pow(-std::log(p), 1 / modulus) * std::pow(radius / reference_radius, -size_exponent);
  }
};

/// Springs across a fresh plane (3.4): their number, and the toughness K_Ic (Pa m^1/2) that gives them their energy.
struct CohesiveSprings {
  int per_plane = 4;
  double toughness = 0;
  double max_opening = 0.05;     // of the equivalent radius: bounds the opening of weakly loaded springs from above
  double stiffness_ratio = 0.1;  // stiffness of one spring <= ratio x E* x equivalent radius: bounds the time step
};

/// Which plane the load asks for; the shape has the last word (break_plane.hpp).
enum class BreakPlane {
  criterion,         // that of the criterion that broke the grain: Hoek-Brown the stress, contact tension the contacts
  average_stress,    // normal to the most tensile principal direction
  critical_contacts  // parallel to the plane of the three contacts of largest tension; the stress where there are fewer
};

/// Badly shaped fragments grow back to a breakable shape (3.3.4, made stable): see shape_transition.hpp.
struct ShapeTransition {
  double ratio = 0.25;  // shorter / longer semi-axis that is reached
  double time = 1e-5;   // s from a flat face to that ratio
};

/// Size of the fines that a split leaves: mass below d ~ (d / top)^(3 - dimension), top = largest x parent diameter.
struct FinesGrading {
  double dimension = 2.6, largest = 0.1;
};

/// Fracture of one material.
struct FractureModel {
  std::optional<HoekBrown> hoek_brown;
  std::optional<ContactTension> contact_tension;
  std::optional<Weibull> weibull;
  std::optional<CohesiveSprings> springs;
  BreakPlane plane = BreakPlane::criterion;
  bool turn_spheres = false;  // their principal axes first turn to the ideal plane (geometry only, no motion)
  double slight_rotation =
      0;  // rad: spheres' axes turn by a random angle of [theta/2, theta] about each axis, either sign (3.3.1)
  double rounding = 0.02;  // epsilon of the split geometry; why 0.02: docs/validation/zhang2015.md
  bool keep_mass =
      false;  // children take the lost volume's mass by density / (1 - rounding); otherwise it goes to the fines
  std::optional<ShapeTransition> transition;
  FinesGrading fines;
  double smallest_radius = 0;  // equivalent radius (m) below which grains do not break
  int max_generations = 255;

  double strength_factor(double radius, std::uint64_t seed, std::uint64_t id) const {
    return weibull ? weibull->factor(radius, random_uniform(seed, id, Purpose::strength)) : 1.0;
  }
};

}  // namespace grus::dem
