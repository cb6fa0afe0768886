// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/grading.hpp"

#include <algorithm>

#include "dem/shape/hull_measures.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {

Grading::Grading(const State& state, double scale) {
  const Grains& g = state.grains;
  for (std::size_t i = 0; i < g.size(); ++i)
    grains_.emplace_back(2 * g.extent[i].equivalent_radius / scale, solid_mass(g, i));
  std::sort(grains_.begin(), grains_.end());
  for (auto& [d, m] : grains_) m = mass_ += m;
  for (const auto& c : state.ledger.fines.classes) {
    fines_.push_back(
        {std::exp2(static_cast<double>(c.octave8) / 8.0) / scale, c.smallest / scale, c.mass, 3 - c.dimension});
    fines_mass_ += c.mass;
  }
  mass_ += fines_mass_;
}

double Grading::Fines::passing(double d) const {
  if (d >= top) return 1;
  if (d <= smallest) return 0;
  const double least = std::pow(smallest / top, slope);
  return (std::pow(d / top, slope) - least) / (1 - least);
}

double Grading::Fines::mean_log(double reference) const {
  const double least = std::pow(smallest / top, slope);
  const double tail = smallest > 0 ? least * std::log(top / smallest) / (1 - least) : 0;
  return std::log(reference / top) + 1 / slope - tail;
}

double Grading::Fines::mean_log_above(double cut) const {
  if (top <= cut) return 0;
  const double least = std::pow(smallest / top, slope), from = std::max(cut, smallest);
  const double at = std::pow(from / top, slope);
  return (std::log(top / cut) - at * std::log(from / cut) - (1 - at) / slope) / (1 - least);
}

double Grading::passing(double d) const {
  const auto above =
      std::upper_bound(grains_.begin(), grains_.end(), d, [](double x, const auto& g) { return x < g.first; });
  double sum = above == grains_.begin() ? 0 : std::prev(above)->second;
  for (const auto& f : fines_) sum += f.mass * f.passing(d);
  return sum / mass_;
}

double Grading::diameter(double fraction) const {
  double top = largest();
  for (const auto& f : fines_) top = std::max(top, f.top);
  double low = std::log(1e-6 * smallest()), high = std::log(top);
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (passing(std::exp(middle)) < fraction ? low : high) = middle;
  }
  return std::exp(high);
}

double Grading::mean_log(double reference) const {
  double sum = 0, before = 0;
  for (const auto& [d, m] : grains_) sum += (m - before) * std::log(reference / d), before = m;
  for (const auto& f : fines_) sum += f.mass * f.mean_log(reference);
  return sum / mass_;
}

double Grading::hardin_potential(double cut) const {
  double sum = 0, before = 0;
  for (const auto& [d, m] : grains_) sum += (m - before) * std::max(0.0, std::log10(d / cut)), before = m;
  for (const auto& f : fines_) sum += f.mass * f.mean_log_above(cut) / std::log(10.0);
  return sum / mass_;
}

double Grading::fractal_dimension() const {
  const double low = std::log(diameter(0.02)), high = std::log(diameter(0.6));
  if (!(high > low)) return NAN;
  constexpr int points = 24;
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int k = 0; k < points; ++k) {
    const double x = low + (high - low) * k / (points - 1), y = std::log(passing(std::exp(x)));
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return 3 - (points * sxy - sx * sy) / (points * sxx - sx * sx);
}

double einav_breakage(const Grading& first, const Grading& now, double dimension) {
  const double reference = first.largest(), ultimate = 1 / (3 - dimension);
  return (now.mean_log(reference) - first.mean_log(reference)) / (ultimate - first.mean_log(reference));
}

double hardin_breakage(const Grading& first, const Grading& now) {
  const double potential = first.hardin_potential();
  return potential > 0 ? 1 - now.hardin_potential() / potential : 0;
}

Zingg zingg(const Grains& g) {
  Zingg z;
  double mass = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 w = sorted_widths(g, i);
    const double long_ratio = w[1] / w[0], flat_ratio = w[2] / w[1], m = solid_mass(g, i);
    const bool wide = long_ratio > 2.0 / 3, thick = flat_ratio > 2.0 / 3;
    double* const shape[2][2] = {{&z.blade, &z.rod}, {&z.disc, &z.equant}};
    *shape[wide][thick] += m;
    z.elongation += m * long_ratio;
    z.flatness += m * flat_ratio;
    mass += m;
  }
  for (double* v : {&z.equant, &z.disc, &z.rod, &z.blade, &z.elongation, &z.flatness}) *v /= mass;
  return z;
}

Roundness roundness(const Grains& g, std::size_t i) {
  return {sphericity(g.hulls->row[g.hull[i]]), angularity((*g.hulls)[g.hull[i]])};
}

Roundness roundness(const Grains& g) {
  Roundness r;
  double mass = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const double m = solid_mass(g, i);
    const Roundness one = roundness(g, i);
    r.sphericity += m * one.sphericity, r.angularity += m * one.angularity;
    mass += m;
  }
  return {r.sphericity / mass, r.angularity / mass};
}

std::vector<SizeClass> size_classes(const State& state, double smallest, double largest, std::size_t count) {
  const Grains& g = state.grains;
  std::vector<SizeClass> classes(count);
  const double step = std::log(largest / smallest) / static_cast<double>(count);
  for (std::size_t k = 0; k < count; ++k) classes[k].upper = smallest * std::exp(step * static_cast<double>(k + 1));
  for (std::size_t i = 0; i < g.size(); ++i) {
    const double at = std::ceil(std::log(2 * g.extent[i].equivalent_radius / smallest) / step - 1e-9) - 1;
    SizeClass& c = classes[static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)))];
    const Vec3 w = sorted_widths(g, i);
    ++c.grains;
    c.mass += solid_mass(g, i);
    c.elongation += w[1] / w[0];
    c.flatness += w[2] / w[1];
    if (!g.generation.empty()) c.generation += g.generation[i];
    c.coordination += coordination(state.contacts, i);
  }
  for (auto& c : classes)
    if (c.grains > 0)
      for (double* v : {&c.coordination, &c.elongation, &c.flatness, &c.generation})
        *v /= static_cast<double>(c.grains);
  return classes;
}

}  // namespace grus::dem
