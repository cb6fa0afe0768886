// SPDX-License-Identifier: LGPL-3.0-or-later
// Softening whose band has a width of its own: a material is told the average over a length of the stretch of each
// increment, and answers; what the average leaves out is answered elastically and forgotten with strain.
#pragma once

#include <memory>

#include "fem/material.hpp"
#include "fem/problem.hpp"

namespace grus::fem {

struct Regularisation {
  double length = 0;      // m
  double memory = 0.002;  // strain of what the material hears, over which the rest is forgotten to 1/e; infinity: never
};

class RegularisedMaterial {
public:
  /// `material` answers at `points` of the problem, in this order; `stiffness` (Pa, 36 row by row, Voigt as in
  /// fem/material.hpp) is one for each of them, of the unstrained material. Throws std::invalid_argument where
  /// StretchAverage does.
  RegularisedMaterial(Problem& problem, Material material, const std::vector<std::size_t>& points,
                      const std::vector<std::array<double, 36>>& stiffness, const Regularisation& by);
  ~RegularisedMaterial();

  /// Valid as long as this object; its energy is that of the material and of what the regularisation has taken.
  Material material();

  /// What the stresses have done at the points beyond what the material was told (J, committed): held and spent by what
  /// is answered elastically, and the average's share. Of all ranks, which must ask together.
  double energy() const;
  /// The regularisation's own committed state, without the material's; and back. Throws std::invalid_argument for bytes
  /// of another problem.
  std::string save() const;
  void load(const std::string& bytes);

  /// The same of one point, to the front of other bytes of it; how many of `bytes` were its own. Of points that are
  /// spread, whose worst remainder is kept apart.
  std::string save_point(std::size_t i) const;
  std::size_t load_point(std::size_t i, const std::string& bytes);
  void go_on_from(double worst_left_over);

  int degree() const;              // of the average's polynomial
  double worst_left_over() const;  // of its equation (StretchAverage::left_over), where tangents were asked for

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace grus::fem
