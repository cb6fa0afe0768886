// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: the equation mean - l^2 Laplace(mean) = field of tensors, element by element on the mesh's corners.
#pragma once

#include <array>

#include "fem/problem_impl.hpp"

namespace grus::fem {

/// One number of a tensor as a sum of its components, and back; and the multiple of l^2 / r^2 that axial symmetry gives
/// it in Laplace's operator: 4 where it turns with the radius twice (rr less hoop), 1 where once (ry).
struct TensorColumn {
  std::array<double, 6> of;  // xx yy zz yz xz xy
  double turns = 0, back = 1;

  double operator()(const double* tensor) const {
    double value = 0;
    for (std::size_t k = 0; k < 6; ++k) value += of[k] * tensor[k];
    return value;
  }
};

struct AverageElements {
  using Matrix = Problem::Impl::Matrix;
  /// An element's matrices: mass and l^2 x stiffness, and l^2 x mass / r^2.
  struct Element {
    Matrix plain, turning;
    Matrix sum(double turns) const { return plain + turns * turning; }
  };

  Problem::Impl& p;
  std::vector<std::size_t> points;
  std::vector<TensorColumn> columns;
  int corners;
  std::vector<std::int32_t> nodes;  // of a point's element in the mesh's geometry, `corners` a point
  std::vector<double> shares;       // of the corners at a point: the linear basis
  std::vector<double> volumes;      // of the points, m^3

  AverageElements(Problem& problem, const std::vector<std::size_t>& which);

  /// Calls `take(first, end)` for the points of each element.
  template <class F>
  void each(F&& take) const {
    const auto nq = static_cast<std::size_t>(p.nq);
    for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
      while (end < points.size() && points[end] / nq == points[first] / nq) ++end;
      take(first, end);
    }
  }
  /// Of one element, whose points are those from `first` to before `end`.
  Element element(std::size_t first, std::size_t end, double length) const;
  /// Widens `bounds`, least and largest, by an element's spectrum over its diagonal: that of the whole lies between
  /// those of the elements (Wathen 1987).
  void widen(std::array<double, 2>& bounds, const Element& e) const;
  /// Adds what a point gives to the right side: `add(corner, column, value)`.
  template <class Add>
  void load(std::size_t point, const double* tensor, Add&& add) const {
    const auto first = point * static_cast<std::size_t>(corners);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = columns[c](tensor) * volumes[point];
      for (std::size_t a = 0; a < static_cast<std::size_t>(corners); ++a) add(a, c, shares[first + a] * value);
    }
  }
  /// The tensor at a point, by the mean of a corner and a column: `at(corner, column)`.
  template <class At>
  void read(std::size_t point, double* tensor, At&& at) const {
    std::fill_n(tensor, 6, 0.0);
    const auto first = point * static_cast<std::size_t>(corners);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double value = 0;
      for (std::size_t a = 0; a < static_cast<std::size_t>(corners); ++a) value += shares[first + a] * at(a, c);
      for (std::size_t k = 0; k < 6; ++k) tensor[k] += columns[c].back * columns[c].of[k] * value;
    }
  }
};

/// Chebyshev's polynomial that stands for the inverse between two bounds, term by term.
struct ChebyshevSteps {
  int degree;  // the least whose polynomial is below `promised` everywhere between the bounds
  double middle, half;

  /// Throws std::invalid_argument where that needs more than `most`.
  ChebyshevSteps(const std::array<double, 2>& bounds, double promised, int most);

  /// Calls `step(by, share)` for each degree: change = by x change + share x residual over the diagonal.
  template <class F>
  void each(F&& step) const {
    const double sigma = middle / half;
    double rho = 1 / sigma;
    for (int k = 0; k < degree; ++k) {
      if (k == 0) {
        step(0, 1 / middle);
        continue;
      }
      const double next = 1 / (2 * sigma - rho);
      step(next * rho, 2 * next / half);
      rho = next;
    }
  }
};

}  // namespace grus::fem
