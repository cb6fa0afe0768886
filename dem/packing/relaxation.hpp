// SPDX-License-Identifier: LGPL-3.0-or-later
// Soft spheres without friction that push each other apart: what makes random packings.
#pragma once

#include "dem/contact/broad_phase.hpp"
#include "dem/packing/packing.hpp"

namespace grus::dem {

/// Energy 1/2 overlap^2, unit mass, minimised by FIRE (Bitzek et al. 2006). Sums are taken in one order, whatever the
/// threads.
class Relaxation {
public:
  Relaxation(const Vec3& box, Container container, std::vector<Sphere>& spheres, Team& team)
      : box_(box), container_(container), s_(spheres), team_(team) {}

  /// Worst overlap relative to the smaller radius after at most `iterations`. `watch(iteration)` is asked in each.
  double run(int iterations, double good_enough, const std::function<void(int)>& watch);

  /// Lets pairs of spheres drawn by `seed` change places where that lowers the energy, `attempts` times; how many did.
  std::size_t swap(std::uint64_t seed, std::size_t attempts);

private:
  void refresh(double skin);
  bool moved() const;
  double forces();
  double energy_of(std::size_t i, double radius) const;  // of sphere i, were it of this radius
  /// The first axis that has walls across it; 3: none.
  int first_wall() const { return container_ == Container::box ? 0 : container_ == Container::periodic ? 3 : 2; }
  /// Calls f(how far sphere i, were it of this radius, is beyond a wall, unit normal to the inside).
  template <class F>
  void each_wall(std::size_t i, double radius, F&& f) const;

  Vec3 box_;
  Container container_;
  std::vector<Sphere>& s_;
  Team& team_;
  Grains grains_;
  Candidates near_;
  SearchRoom search_;
  struct Neighbour {
    Index other;
    bool second;  // the other comes first in the pair
    Vec3 image;   // to be added to b - a (m)
  };
  std::vector<Neighbour> neighbours_;  // of sphere i: from row_[i] to row_[i + 1], by the other
  std::vector<std::size_t> row_, next_;
  std::vector<Vec3> v_, f_, at_;
  std::vector<double> worst_;  // of each block
  double skin_ = 0;
};

}  // namespace grus::dem
