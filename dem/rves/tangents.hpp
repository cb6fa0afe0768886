// SPDX-License-Identifier: LGPL-3.0-or-later
// Two answers of one increment tell of each other: the noise of the material, and tangents that are kept from iteration
// to iteration.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "dem/rves/host.hpp"

namespace grus::dem {

/// The answer that one point hears.
struct Answer {
  Mat3 stress = Mat3::Zero();
  Mat6 tangent = Mat6::Zero();
  std::size_t breakages = 0;
};

/// A response: what the points were told, and what they heard. Empty: there was none in this increment.
struct Sweep {
  std::vector<Mat3> deformation;
  std::vector<Answer> answer;
};

/// How far two responses are from any tangent between none and the elastic one (from the elastic one where breakage
/// differs), relative to the stress: sliding and breakage make the response a staircase, and no residual goes below its
/// steps. Yielding makes the stress change anything from nothing to the elastic change; what misses by more is no
/// function of strain.
double disagreement(const Sweep& before, const Sweep& now);

/// Squares of what misses and of the stress, and how many pairs of responses there are: sums over points.
using Misses = std::array<double, 3>;
/// Makes them the sums over the points of all who have some.
using Joining = std::function<void(Misses&)>;

/// One pair of iterations is a small sample: what earlier pairs of the increment showed fades slowly.
struct NoiseMeter {
  double measured = 0;
  void read(const Sweep& before, const Sweep& now, const Joining& join = {});
};

/// Tangents that do not follow the RVEs' own: those of the first response (elastic), improved by Broyden's update
/// (quasi-Newton). Other kinds are left as they are.
void choose_tangents(TangentKind kind, const Sweep& before, Sweep& now, std::vector<Mat6>& kept);

}  // namespace grus::dem
