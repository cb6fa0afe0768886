// SPDX-License-Identifier: LGPL-3.0-or-later
// Size, shape and breakage of the grains of a state, by mass; the fines that splits booked are part of the grading.
#pragma once

#include "dem/rve/state.hpp"

namespace grus::dem {

/// Grading by mass against the equivalent diameter (m).
class Grading {
public:
  /// `scale`: of the grains over what they stand for, which the grading is told of.
  explicit Grading(const State& state, double scale = 1);

  /// Mass fraction finer than d: whole grains below it, and of each class of fines its share.
  double passing(double d) const;
  /// Diameter (m) that the given fraction passes.
  double diameter(double fraction) const;
  double fines_fraction() const { return fines_mass_ / mass_; }
  double largest() const { return grains_.back().first; }
  double smallest() const { return grains_.front().first; }
  /// Mean of ln(reference / d) over the mass: the area under the grading curve left of the reference, on a log scale.
  double mean_log(double reference) const;
  /// Mean of max(0, log10(d / cut)) over the mass: Hardin's (1985) breakage potential.
  double hardin_potential(double cut = 74e-6) const;
  /// 3 - slope of log passing against log d between the 2 % and the 60 % passing sizes (least squares, 24 points). With
  /// more than 2 % of fines the lower part of the curve is what was assumed of them.
  double fractal_dimension() const;

private:
  std::vector<std::pair<double, double>> grains_;  // diameter, mass up to it
  struct Fines {
    double top, smallest, mass, slope;  // m, m, kg, 3 - fractal dimension

    double passing(double d) const;           // of their mass
    double mean_log(double reference) const;  // of ln(reference / d)
    double mean_log_above(double cut) const;  // of max(0, ln(d / cut))
  };
  std::vector<Fines> fines_;
  double mass_ = 0, fines_mass_ = 0;
};

/// Einav's (2007) breakage: area between the first and the present grading over that between the first and the ultimate
/// one, a fractal of `dimension` up to the first largest grain. 0 unbroken, 1 ultimate.
double einav_breakage(const Grading& first, const Grading& now, double dimension = 2.6);

/// Hardin's (1985) relative breakage: the lost part of the first potential.
double hardin_breakage(const Grading& first, const Grading& now);

/// Mass fractions of Zingg's (1935) shapes by the ratios of the three widths along the octant axes, limit 2/3.
struct Zingg {
  double equant = 0, disc = 0, rod = 0, blade = 0;
  double elongation = 0, flatness = 0;  // mass means of intermediate/longest and shortest/intermediate
};
Zingg zingg(const Grains& grains);

/// How round a hull is (shape/hull_measures.hpp), or hulls are in the mean, by mass.
struct Roundness {
  double sphericity = 0, angularity = 0;
};
Roundness roundness(const Grains& grains, std::size_t i);
Roundness roundness(const Grains& grains);

/// The grains of one size class: how many, and what they are like.
struct SizeClass {
  double upper = 0;  // m
  std::size_t grains = 0;
  double mass = 0, coordination = 0, elongation = 0, flatness = 0, generation = 0;  // means over the grains
};

/// `count` classes, log-spaced between the two diameters; smaller and larger grains are in the end classes.
std::vector<SizeClass> size_classes(const State& state, double smallest, double largest, std::size_t count);

}  // namespace grus::dem
