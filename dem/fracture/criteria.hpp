// SPDX-License-Identifier: LGPL-3.0-or-later
// When a grain breaks (Zhang et al. 2015, 3.1-3.2). A criterion is a value that is asked of a grain under load, whoever
// tells of it: the grains themselves (loaded_grain.hpp), or a linear response that foretells. It answers with a
// utilisation, >= 1 breaks, and the plane that it wants. A new criterion is a struct here and a name in `Criterion`.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "dem/base/tensor.hpp"
#include "dem/fracture/cleavage.hpp"

namespace grus::dem {

/// Whoever tells of a grain under load. `each_contact(f)` calls f(force, radius, at) for its touching contacts;
/// `arm(at)`.
template <class G>
concept GrainUnderLoad = requires(const G& grain, Index at) {
  { grain.stress() } -> std::convertible_to<Mat3>;  // Pa, tension-positive, global
  { grain.poissons_ratio() } -> std::convertible_to<double>;
  { grain.radius() } -> std::convertible_to<double>;  // equivalent (m)
  { grain.arm(at) } -> std::convertible_to<Vec3>;     // from the centre of mass to the contact (m, global)
  grain.each_contact([](double /*force, N*/, double /*contact radius, m*/, Index /*at*/) {});
};

/// sigma_1 = sigma_3 + s sqrt(m sigma_3 / s + 1), compression-positive (eq 14); s, the compressive strength, in Pa.
/// Breaks across the most tensile direction.
struct HoekBrown {
  double compressive_strength = 0, m = 0;

  /// `stress` tension-positive, `factor` multiplies the strength. Below the apex (sigma_3 <= -s/m) the grain has
  /// failed.
  double utilisation(const Mat3& stress, double factor) const {
    const Vec3 tension = principal_values(stress);
    const double s1 = -tension[0], s3 = -tension[2], s = factor * compressive_strength;
    const double root = m * s3 / s + 1;
    if (root <= 0) return std::max(1.0, -s3 * m / s);
    return (s1 - s3) / (s * std::sqrt(root));
  }

  double utilisation(const GrainUnderLoad auto& grain, double factor) const {
    return utilisation(Mat3(grain.stress()), factor);
  }
  std::optional<Vec3> plane(const GrainUnderLoad auto&, double) const { return std::nullopt; }
};

inline constexpr int most_critical_contacts = 100;

/// Largest tensile stress at the rim of a Hertz contact, (1 - 2 nu)/3 q0 with q0 = 3F/(2 pi a^2) (eq 17).
/// A grain breaks once `critical_contacts` contacts that are not in line reach the strength (Pa), along their plane.
struct ContactTension {
  double strength = 0;
  int critical_contacts = 3;

  static double tension(double force, double contact_radius, double poissons_ratio) {
    return (1 - 2 * poissons_ratio) / 3 * 1.5 * force / (pi * contact_radius * contact_radius);
  }

  double utilisation(const GrainUnderLoad auto& grain, double factor) const;
  std::optional<Vec3> plane(const GrainUnderLoad auto& grain, double factor) const;
};

/// Normal (global) of the plane of the three contacts of largest tension that are not in line, among those of at least
/// `strength`; none if fewer than `count` reach it.
template <GrainUnderLoad G>
std::optional<Vec3> contact_plane(const G& grain, double strength, int count) {
  struct Critical {
    double tension;  // Pa
    Index at;
  };
  std::vector<Critical> critical;
  grain.each_contact([&](double force, double radius, Index at) {
    const double tension = ContactTension::tension(force, radius, grain.poissons_ratio());
    if (tension >= strength) critical.push_back({tension, at});
  });
  if (critical.size() < static_cast<std::size_t>(std::max(count, 3))) return std::nullopt;
  std::stable_sort(critical.begin(), critical.end(),
                   [](const auto& a, const auto& b) { return a.tension > b.tension; });
  const Vec3 p = grain.arm(critical[0].at), q = grain.arm(critical[1].at);
  for (std::size_t k = 2; k < critical.size(); ++k) {
    const Vec3 u = q - p, v = grain.arm(critical[k].at) - p, n = u.cross(v);
    if (n.norm() > 1e-3 * u.norm() * v.norm()) return n.normalized();
  }
  return std::nullopt;
}

/// The tension that the asked number of contacts reach, over the strength; 0 where there are fewer, or all in line.
double ContactTension::utilisation(const GrainUnderLoad auto& grain, double factor) const {
  std::array<double, most_critical_contacts> largest;
  const auto count = static_cast<std::size_t>(critical_contacts);
  std::size_t found = 0;
  grain.each_contact([&](double force, double radius, Index) {
    const double here = tension(force, radius, grain.poissons_ratio());
    std::size_t to = std::min(found, count);
    for (; to > 0 && largest[to - 1] < here; --to)
      if (to < count) largest[to] = largest[to - 1];
    if (to < count) largest[to] = here, found = std::min(found + 1, count);
  });
  if (found < count) return 0;
  const double reached = largest[count - 1] / (strength * factor);
  return reached >= 1 && !plane(grain, factor) ? 0 : reached;
}

std::optional<Vec3> ContactTension::plane(const GrainUnderLoad auto& grain, double factor) const {
  return contact_plane(grain, strength * factor, critical_contacts);
}

/// Largest normal force of a contact over the area it acts on against a strength (Pa): Russell & Muir Wood (2009) as
/// used by Ciantia et al. (2015), eq 6. The area is pi (R sin angle)^2, the same for all loads, or that of the Hertz
/// contact, pi a^2 = pi R_e overlap.
struct ContactStrength {
  double strength = 0;
  std::optional<double> angle = std::nullopt;  // rad; none: the Hertz contact

  double utilisation(const GrainUnderLoad auto& grain, double factor) const {
    const double side = angle ? grain.radius() * std::sin(*angle) : 0;
    double largest = 0;
    grain.each_contact([&](double force, double radius, Index) {
      const double a = angle ? side : radius;
      largest = std::max(largest, force / (pi * a * a));
    });
    return largest / (strength * factor);
  }
  std::optional<Vec3> plane(const GrainUnderLoad auto&, double) const { return std::nullopt; }

  /// The limit of the contact stress that a compressive and a tensile strength (Pa, both positive) stand for: kappa / f
  /// of eqs 3-5, whose denominator of chi is misprinted.
  static double limit(double compressive, double tensile, double poissons_ratio) {
    const double chi = compressive / tensile - 1, nu = poissons_ratio, root2 = std::sqrt(2.0), root3 = std::sqrt(3.0);
    const double kappa = (1 + chi) * compressive / root3;
    const double shape = 3.0 / 32 + root2 / 24 + (root2 / 12 - 0.25) * nu + (0.5 - root2 / 3) * nu * nu;
    return kappa / (root3 * (1 + chi) * (1 + chi) / chi * shape / ((2 - root2) * (1 + nu)));
  }
};

/// The contact of a grain that bears the largest force; none where nothing touches.
struct LargestContact {
  double force = 0;  // N
  std::optional<Index> at = std::nullopt;
};
LargestContact largest_contact(const GrainUnderLoad auto& grain) {
  LargestContact largest;
  grain.each_contact([&](double force, double, Index at) {
    if (force > largest.force) largest = {force, at};
  });
  return largest;
}

/// Direction from the centre to that contact (global, unit); zero where nothing touches.
Vec3 load_direction(const GrainUnderLoad auto& grain) {
  const LargestContact largest = largest_contact(grain);
  return largest.at ? Vec3(Vec3(grain.arm(*largest.at)).normalized()) : Vec3(Vec3::Zero());
}

/// Largest force on a grain over the square of its diameter, against that at which grains break between two platens
/// (Pa): what decides most (Zhu & Zhao 2019, stage 1).
struct PlatenForce {
  double strength = 0;

  double utilisation(const GrainUnderLoad auto& grain, double factor) const {
    double largest = 0;
    if constexpr (requires { grain.largest_force(); })
      largest = grain.largest_force();
    else
      largest = largest_contact(grain).force;
    return largest / (4 * grain.radius() * grain.radius() * strength * factor);
  }
  std::optional<Vec3> plane(const GrainUnderLoad auto&, double) const { return std::nullopt; }
};

using Criterion = std::variant<HoekBrown, ContactTension, ContactStrength, Cleavage, PlatenForce>;

/// The verdict of a material's criteria on a grain: the largest utilisation, and which of them it fails.
struct Verdict {
  double utilisation = 0;
  std::size_t by = 0;  // the first that the grain fails, if it does
};

/// `factor`: of the grain's own strength. Asked in their order, until one fails.
Verdict judge(const std::vector<Criterion>& criteria, const GrainUnderLoad auto& grain, double factor) {
  Verdict verdict;
  for (std::size_t k = 0; k < criteria.size(); ++k) {
    const double now = std::visit([&](const auto& c) { return c.utilisation(grain, factor); }, criteria[k]);
    verdict.utilisation = std::max(verdict.utilisation, now);
    verdict.by = k;
    if (now >= 1) break;
  }
  return verdict;
}

}  // namespace grus::dem
