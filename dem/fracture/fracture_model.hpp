// SPDX-License-Identifier: LGPL-3.0-or-later
// Fracture of one material, made of values that know nothing of each other: criteria say when, a splitter says into
// what, a strength law scatters, a limit says who may. Any of them goes with any other.
#pragma once

#include "dem/base/random.hpp"
#include "dem/fracture/criteria.hpp"
#include "dem/fracture/lattice_crack.hpp"
#include "dem/fracture/splitter.hpp"

namespace grus::dem {

/// All grains are as strong as the material.
struct UniformStrength {
  double operator()(double, std::uint64_t, std::uint64_t) const { return 1; }
};

/// Strength of a grain = characteristic strength x (ln 1/P)^(1/modulus) (r / reference_radius)^-size_exponent (eq 18,
/// whose exponent -2w is a misprint: -3/w in three dimensions). P, the share that survives, is the grain's own uniform
/// draw.
struct Weibull {
  double modulus = 1, reference_radius = 0, size_exponent = 3;
  bool linear = false;    // the straight line that Zhu & Zhao 2019 (eq 12) lay through survival
  bool inherits = false;  // fragments have their parent's draw (their eq 15), not one of their own

  double operator()(double radius, std::uint64_t seed, std::uint64_t id) const {
    return factor(radius, random_uniform(seed, id, Purpose::strength));
  }
  double factor(double radius, double p) const { return drawn(p) * of_size(radius / reference_radius); }
  double drawn(double p) const {
    constexpr double slope = -0.76, at_none = 1.13;
    return linear ? (p - at_none) / slope : std::pow(-std::log(p), 1 / modulus);
  }
  /// Strength over that of a grain whose radius is that many times smaller.
  double of_size(double ratio) const { return std::pow(ratio, -size_exponent); }
};

/// Strength of a grain = strength x draw x (diameter / reference_diameter)^-size_exponent (Ciantia et al. 2015, eqs 7
/// and 8). Draws have the mean 1 and the given coefficient of variation: log-normal, or normal, drawn anew below
/// `least`, where the paper's would be negative in 1.9 to 15.9 % of cases (mean then 1.03 to 1.31).
struct Scatter {
  bool normal = false;
  double variation = 0, reference_diameter = 0, size_exponent = 0;

  static constexpr double least = 0.05;

  double operator()(double radius, std::uint64_t seed, std::uint64_t id) const {
    return draw(seed, id) * std::pow(2 * radius / reference_diameter, -size_exponent);
  }
  double draw(std::uint64_t seed, std::uint64_t id) const {
    if (!normal) {
      const double spread2 = std::log1p(variation * variation);
      return std::exp(std::sqrt(spread2) * random_normal(seed, id, Purpose::strength) - 0.5 * spread2);
    }
    for (std::uint64_t k = 0;; ++k)
      if (const double x = 1 + variation * random_normal(seed, id, Purpose::strength, k); x >= least) return x;
  }
};

/// (equivalent radius in m, seed, id) -> factor on the characteristic strengths of a grain.
using StrengthLaw = std::variant<UniformStrength, Weibull, Scatter>;

/// Who may break.
struct Limit {
  double smallest_radius = 0;  // equivalent radius (m) below which grains do not break
  int max_generations = 255;   // splits since the start
  int rest = 0;  // steps from birth in which a fragment does not break, nor later while its resultant is half of its
                 // largest force: it would break by where it was put, not by load

  bool allows(double radius, int generation) const {
    return generation < max_generations && !(radius < smallest_radius);
  }
};

/// Which plane a grain breaks along; the splitter has the last word.
enum class BreakPlane {
  criterion,         // that of the criterion that broke the grain: Hoek-Brown the stress, contact tension the contacts
  average_stress,    // normal to the most tensile principal direction
  critical_contacts  // of the three contacts of largest tension; the stress where there are fewer
};

/// Springs across a fresh plane (3.4): their number, and the toughness K_Ic (Pa m^1/2) that gives them their energy.
struct CohesiveSprings {
  int per_plane = 4;
  double toughness = 0;
  double max_opening = 0.05;     // of the equivalent radius: bounds the opening of weakly loaded springs from above
  double stiffness_ratio = 0.1;  // stiffness of one spring <= ratio x E* x equivalent radius: bounds the time step
};

/// Badly shaped fragments grow back to a breakable shape (3.3.4, made stable): see shape_transition.hpp.
struct ShapeTransition {
  double ratio = 0.25;  // shorter / longer semi-axis that is reached
  double time = 1e-5;   // s from a flat face to that ratio
};

/// Size of the fines that a split leaves: mass below d ~ d^(3 - dimension) - smallest^(3 - dimension), up to largest x
/// parent diameter.
struct FinesGrading {
  double dimension = 2.6, largest = 0.1;
  double smallest = 0;  // m
};

/// How the crystal of a grain lies at the start, global: any way, or turned about an axis by one of some angles.
struct Crystal {
  std::optional<Vec3> axis = {};
  std::vector<double> angles = {};  // rad

  Quat draw(std::uint64_t seed, std::uint64_t id) const {
    if (!axis) return random_rotation(~seed, id);  // not as grains are turned
    const double u = random_uniform(seed, id, Purpose::orientation);
    const auto k = static_cast<std::size_t>(u * static_cast<double>(angles.size()));
    return Quat(Eigen::AngleAxisd(angles[k], *axis));
  }
};

/// Grains that are tested for cracks (lattice_crack.hpp), and when a test is worth its cost: `PlatenForce` says how
/// near a grain is to its strength.
struct CrackTests {
  LatticeModel lattice;
  LatticeToughness toughness;
  double force_screen = 0.45;      // of the platen strength: less breaks no grain
  double unbalanced_force = 0.02;  // resultant over the mean force on the grain; beyond it, it is in motion: no test
  double unbalanced_moment = 0.2;  // the same of its moment, over the mean of force x arm
  double changed_force = 0.1;      // of the largest, by which some force has changed since the grain held
};

/// Fracture of one material.
struct FractureModel {
  std::vector<Criterion> criteria;  // asked in this order
  Splitter splitter;
  StrengthLaw strength_law;
  Limit limit;
  BreakPlane plane = BreakPlane::criterion;
  std::optional<CohesiveSprings> springs;
  std::optional<ShapeTransition> transition;
  FinesGrading fines;
  std::optional<Crystal> crystal;    // of grains that cleave along planes of their own
  std::optional<CrackTests> cracks;  // of grains that fall into as many pieces as their cracks say

  bool of_hulls() const { return std::holds_alternative<Cut>(splitter) || std::holds_alternative<Shatter>(splitter); }

  double strength_factor(double radius, std::uint64_t seed, std::uint64_t id) const {
    return std::visit([&](const auto& law) { return law(radius, seed, id); }, strength_law);
  }

  /// Factor of a fragment that has its parent's draw; none: it has one of its own.
  std::optional<double> inherited(double parents_factor, double parents_radius, double radius) const {
    const auto* weibull = std::get_if<Weibull>(&strength_law);
    if (!weibull || !weibull->inherits) return std::nullopt;
    return parents_factor * weibull->of_size(radius / parents_radius);
  }
};

}  // namespace grus::dem
