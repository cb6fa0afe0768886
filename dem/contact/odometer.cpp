// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/odometer.hpp"

#include <algorithm>
#include <limits>

#include "dem/contact/pair_kinds.hpp"

namespace grus::dem {
namespace {

/// Round-off of a sum of few numbers, in units of the largest of them: of one gap; of one step of a position.
constexpr double of_gap = 64 * std::numeric_limits<double>::epsilon(), of_step = 0.5 * of_gap;

/// The spin of a free body changes by less than its square in a second: one that turns by less in a step has the spin
/// that its speed is told by to the tenth by which speeds are raised (rad).
constexpr double small_turn = 0.1;

/// How fast a wall comes nearer to what it faces (m/s).
double speed_of(const Wall& wall) {
  return std::visit([&](const auto& shape) { return shape.travel(wall.velocity); }, wall.shape);
}

}  // namespace

void Odometer::wake(const Grains& grains, const Boundary& boundary, const NeighbourReference& reference,
                    const Contacts& contacts) {
  double far2 = 0;
  least_body_ = INFINITY;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Motion& m = grains.motion[i];
    far2 = std::max(far2, m.position.squaredNorm());
    if (!is_sphere(grains, i)) least_body_ = std::min(least_body_, m.radius);
  }
  wall_speed_ = 0;
  for (const Wall& wall : boundary.walls) {
    far2 = std::max(far2, wall.point.squaredNorm());
    wall_speed_ = std::max(wall_speed_, speed_of(wall));
  }
  far_ = std::sqrt(far2), largest_ = reference.largest;
  // Pairs are put on the list within 2.2 of its skin at most (mend.cpp), and part by less than two while it holds.
  reach_ = 2 * largest_ + 6 * reference.skin;
  // Kernels begin their groups anew with each tile and bin.
  tiles_ = tile_count(grains.size());
  first_.resize(bin_count * tiles_);
  std::size_t groups = 0;
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    const auto width = static_cast<std::size_t>(pair_kind(bin).one_by_one ? 1 : lanes());
    for (std::size_t t = 0; t < tiles_; ++t) {
      first_[bin * tiles_ + t] = groups;
      groups += (contacts.tile[bin][t + 1] - contacts.tile[bin][t] + width - 1) / width;
    }
  }
  until_.assign(groups, 0);
}

double Odometer::blur() const { return of_gap * (far_ + reach_ + pairs_ + walls_); }

void Odometer::step(std::uint64_t k, double speed) {
  const double strain = static_cast<double>(k) * dt_ * rate_, now = rate_ > 0 ? rate_ / std::max(1 - strain, 0.0) : 0;
  double way = dt_ * speed;
  if (way > small_turn * least_body_) way += 2 * largest_;  // nobody knows how bodies have turned in between
  // Speeds are told against the affine motion as it was when the run began; the cell has its own of now.
  const double affine = rate_ > 0 ? dt_ * now * (reach_ + 2 * strain * far_) : 0, with_cell = dt_ * rate_ * far_;
  const double round_off = of_step * (far_ + reach_ + pairs_ + walls_);  // readings grow, whatever is added to them
  pairs_ += 2 * way + affine + round_off;
  walls_ += way + with_cell + dt_ * wall_speed_ + round_off;
  far_ += way + with_cell + dt_ * wall_speed_;
}

}  // namespace grus::dem
