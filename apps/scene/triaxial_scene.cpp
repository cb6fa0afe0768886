// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/triaxial_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace grus::app {
namespace {

constexpr const char* axes[] = {"x", "y", "z"};

/// What an axis does once it has its stress: it keeps that, goes on at a rate of it, is driven, or follows the others.
struct AxisOrder {
  double stress = 0;                                                 // Pa, compression-positive
  std::optional<double> strain_rate = {}, stress_rate = {}, b = {};  // 1/s, Pa/s
};

AxisOrder read_axis(Table t) {
  AxisOrder order;
  if (t.has("b") && t.has("stress")) t.fail("stress", "follows from b and the other two: leave it out");
  if (!t.has("b")) order.stress = t.number("stress", dimension::pressure, positive);
  if (t.has("strain_rate")) order.strain_rate = t.number("strain_rate", dimension::rate, any);
  if (t.has("stress_rate")) order.stress_rate = t.number("stress_rate", dimension::stress_rate, any);
  if (t.has("b")) order.b = t.number("b", dimension::none, fraction);
  if (order.strain_rate.has_value() + order.stress_rate.has_value() + order.b.has_value() > 1)
    t.fail("", "has strain_rate, stress_rate or b: one of them, or none, and it keeps its stress");
  t.finish();
  return order;
}

/// b is of one axis, between one that is driven and one that is told nothing; its stress begins there.
void begin_at_ratio(const Table& t, std::array<AxisOrder, 3>& orders, std::size_t middle) {
  const std::size_t one = (middle + 1) % 3, other = (middle + 2) % 3;
  const bool first = orders[one].strain_rate.has_value();
  const AxisOrder &driven = orders[first ? one : other], &third = orders[first ? other : one];
  if (!driven.strain_rate || third.strain_rate || third.stress_rate || third.b)
    t.fail(axes[middle], "b is of one axis beside one with strain_rate and one that keeps its stress");
  orders[middle].stress = third.stress + *orders[middle].b * (driven.stress - third.stress);
}

/// The rates in time: final_strain of the axis that goes fastest, or a duration.
double read_length(Table& t, const dem::Programme& test) {
  if (test.strain_rate == 0) return t.number("duration", dimension::time, positive);
  return t.number("final_strain", dimension::none, {0, 0.95, true, true}) / std::abs(test.strain_rate);
}

}  // namespace

void read_true_triaxial(Table& t, dem::Programme& test) {
  std::array<AxisOrder, 3> orders;
  for (std::size_t k = 0; k < 3; ++k) orders[k] = read_axis(t.table(axes[k]));
  dem::Loading& loading = test.loading;
  for (std::size_t k = 0; k < 3; ++k) {
    const AxisOrder& order = orders[k];
    if (order.b) begin_at_ratio(t, orders, k), loading.ratio = order.b, loading.middle = static_cast<int>(k);
    if (order.strain_rate && std::abs(*order.strain_rate) > std::abs(test.strain_rate))
      test.axis = static_cast<int>(k), test.strain_rate = *order.strain_rate;
  }
  const double shearing = read_length(t, test);
  loading.consolidation = t.number_or("consolidation", 0.2 * shearing, dimension::time, positive);
  test.duration = loading.consolidation + shearing;
  loading.holds = true, loading.first.emplace();
  double mean = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const AxisOrder& order = orders[k];
    (*loading.first)[static_cast<int>(k)] = -order.stress;
    mean -= order.stress / 3;
    dem::AxisControl& axis = loading.axes[k];
    axis.max_rate = 6 * std::abs(test.strain_rate);
    if (order.strain_rate) {
      axis.strain_rate = -*order.strain_rate;
      continue;
    }
    axis.stress_rate = -order.stress_rate.value_or(0);
    axis.stress = -order.stress - axis.stress_rate * loading.consolidation;
    if (!(order.stress - axis.stress_rate * shearing >= 0))
      t.fail(axes[k], fmt::format("stress_rate {:g} Pa/s leaves less than no pressure by the end", *order.stress_rate));
  }
  if (!t.flag_or("constant_mean", false)) return;
  if (!loading.ratio) t.fail("constant_mean", "needs b of one axis, by which the other two share what is left");
  loading.mean = mean;
}

}  // namespace grus::app
