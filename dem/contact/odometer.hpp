// SPDX-License-Identifier: LGPL-3.0-or-later
// Groups of listed pairs that are apart sleep until one of them could touch. Readings tell what gaps may have lost
// since the run began; they only grow, so that a pair whose gap was measured at one reading does not touch before the
// reading has grown by that gap. What sleeps decides no bit of what is found, and is of one run: no state keeps it.
#pragma once

#include <cstdint>
#include <vector>

#include "dem/contact/neighbours.hpp"

namespace grus::dem {

/// All is bound by the fastest surface: its way against the affine motion, twice for two grains; what the cell does to
/// two grains that are as far apart as any on the list; walls; growth; round-off.
class Odometer {
public:
  /// `affine`: velocity gradient of the cell as the run begins (1/s), against which speeds are told.
  Odometer(const Mat3& affine, double dt) : dt_(dt), rate_(affine.norm()) {}
  /// The run begins, or the list is new: everything wakes. How far grains and walls are from the origin, and pairs from
  /// each other.
  void wake(const Grains& grains, const Boundary& boundary, const NeighbourReference& reference,
            const Contacts& contacts);
  /// Step `k` of the run has moved grains and boundary; `speed` (m/s): a bound of any surface's, against the affine
  /// motion.
  void step(std::uint64_t k, double speed);
  /// Surfaces have grown by up to so much (m).
  void grow(double by) { pairs_ += 2 * by, walls_ += by; }

  double pairs() const { return pairs_; }  // what gaps of two grains have lost, or more (m)
  double walls() const { return walls_; }  // the same of grains and walls
  double blur() const;                     // round-off of a gap, and of one added to a reading, or more (m)
  /// Of the groups of a tile's pairs in a bin, one after the other: the reading at which each is looked at again.
  double* until(std::size_t bin, std::size_t tile) { return until_.data() + first_[bin * tiles_ + tile]; }

private:
  double dt_, rate_;                             // s; norm of the gradient (1/s)
  double pairs_ = 0, walls_ = 0;                 // m
  double far_ = 0, reach_ = 0, wall_speed_ = 0;  // m, m, m/s
  double largest_ = 0, least_body_ = 0;          // radii (m); of no body: infinite
  std::size_t tiles_ = 0;
  std::vector<std::size_t> first_;  // group of each bin and tile
  std::vector<double> until_;
};

}  // namespace grus::dem
