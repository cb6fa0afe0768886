// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/laws.hpp"

#include <algorithm>

namespace grus::dem {

double restitution_of(const ContactLaw& law, double dashpot) {
  // m = k = v0 = 1: x'' = -max(F(x) + c sqrt(S(x)) x', 0). Runge-Kutta of order 4 until the overlap or the force ends.
  auto acceleration = [&](double x, double v) {
    if (x <= 0) return 0.0;
    return std::visit(
        [&](const auto& l) {
          const Elastic e = l(1.0, x);
          return -std::max(e.force + dashpot * std::sqrt(e.normal_stiffness) * v, 0.0);
        },
        law);
  };
  double x = 0, v = 1;
  const double h = 2e-4;
  for (int step = 0; step < 2000000; ++step) {
    const double a1 = acceleration(x, v);
    const double a2 = acceleration(x + h / 2 * v, v + h / 2 * a1);
    const double a3 = acceleration(x + h / 2 * (v + h / 2 * a1), v + h / 2 * a2);
    const double a4 = acceleration(x + h * (v + h / 2 * a2), v + h * a3);
    x += h * (v + h / 6 * (a1 + a2 + a3));
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    if (v < 0 && (x <= 0 || acceleration(x, v) == 0)) break;
    if (v > 0 && v < 1e-9 && x > 0 && acceleration(x, v) == 0) break;
  }
  return std::max(-v, 0.0);
}

double dashpot_for(const ContactLaw& law, double restitution) {
  if (restitution >= 1) return 0;
  double low = 0, high = 1;
  while (restitution_of(law, high) > restitution && high < 64) high *= 2;
  for (int i = 0; i < 40; ++i) {
    const double mid = 0.5 * (low + high);
    (restitution_of(law, mid) > restitution ? low : high) = mid;
  }
  return 0.5 * (low + high);
}

}  // namespace grus::dem
