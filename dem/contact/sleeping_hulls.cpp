// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/sleeping_hulls.hpp"

#include <algorithm>
#include <cmath>

namespace grus::dem {

namespace {

/// Of lengths of a sample, what thousands of sums of them do not miss by.
constexpr double blur_share = 1e-11;

}  // namespace

void SleepingHulls::wake(const Grains& grains, const Cell& cell, std::size_t pairs, double reach) {
  double far = cell.vectors.norm();
  pose_.resize(grains.size());
  for (std::size_t i = 0; i < grains.size(); ++i) {
    pose_[i] = {grains.motion[i].position, grains.orientation[i]};
    far = std::max(far, pose_[i].position.norm());
  }
  way_.assign(grains.size(), 0);
  until_.assign(pairs, 0);
  cell_ = cell.vectors, reach_ = reach, blur_ = blur_share * (far + reach);
}

void SleepingHulls::go(const Grains& grains, const Cell& cell, Team& team) {
  // Two points of one pair are moved by the cell against each other by no more than this, half of it for each.
  const Mat3 affine = cell.periodic() ? Mat3((cell.vectors - cell_) * cell_.inverse()) : Mat3(Mat3::Zero());
  const double of_cell = 0.5 * affine.norm() * reach_ * (1 + 1e-9);
  cell_ = cell.vectors;
  team.blocks(grains.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      auto& [position, orientation] = pose_[i];
      const Motion& m = grains.motion[i];
      const auto &p = grains.orientation[i].coeffs(), &q = orientation.coeffs();
      // A chord of the quaternions is half the angle: points of the surface move by at most radius * angle.
      const double turned = 2.01 * std::min((p - q).norm(), (p + q).norm()) * m.radius;
      way_[i] += (m.position - position - affine * position).norm() + turned + of_cell;
      position = m.position, orientation = grains.orientation[i];
    }
  });
}

}  // namespace grus::dem
