// SPDX-License-Identifier: LGPL-3.0-or-later
// The elastic response of a sample at rest: its contact network as springs, grains free to move and turn. Good as long
// as no contact slides, opens or closes and no grain breaks, which it can tell beforehand.
#pragma once

#include <memory>

#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct LinearResponse {
  /// A contact and what a strain (Voigt, engineering shear) does to its force.
  struct Link {
    Vec3 normal, spring;                 // unit, a to b; tangential force (N)
    double force, friction;              // normal force (N)
    Eigen::Matrix<double, 3, 6> change;  // of the force on b, N; compression is along +normal
  };
  /// The part of a couple's spring in a link.
  struct Couple {
    Vec3 spring;  // N
    double friction;
    Eigen::Matrix<double, 3, 6> change;  // N
  };
  /// A pair that does not touch: its gap (m) and what a strain does to it.
  struct Gap {
    double width;
    Vec6 change;
  };
  /// A grain that can break: its stress and the links on it.
  struct Grain {
    std::size_t material;
    double strength, poissons_ratio, radius;  // radius: equivalent (m)
    Mat3 stress;
    std::array<Mat3, 6> change;  // of the stress for a unit of each strain component (Pa)
    struct Contact {
      std::size_t link;
      double radius;  // of the circle of contact (m)
      Vec3 arm;       // m
    };
    std::vector<Contact> contact;
  };

  Mat3 stress = Mat3::Zero();   // of the state (Pa)
  Mat6 tangent = Mat6::Zero();  // d stress / d strain, relaxed (Pa)
  std::vector<Link> links;
  std::array<std::vector<Couple>, spring_rows> couples;  // of the links, by spring; empty where it is not kept
  std::vector<Gap> gaps;
  std::vector<Grain> grains;
  double total_force = 0;  // sum of the links' forces (N)

  /// True while the links that a strain would make slide, open or close carry no more than `share` of all forces, no
  /// grain would break, and forces change by no more than a tenth in the mean: Hertz's curvature is then below 1/600 of
  /// the stress.
  bool holds(const Model& model, const Vec6& strain, double share) const;
};

/// Null where the state is not elastic to begin with: contacts at their Coulomb limit that carry more than `share`, or
/// springs; and where contacts attract, since it foretells of none that snaps on or off.
std::unique_ptr<const LinearResponse> linear_response(const Model& model, const State& state, double share);

/// The tangent alone, of any state: contacts at their Coulomb limit without k_t, grains free to move and turn (Pa).
/// Zero without contacts.
Mat6 network_tangent(const Model& model, const State& state);

}  // namespace grus::dem
