// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/laws.hpp"

#include <algorithm>

namespace grus::dem {

double restitution_of(const ContactLaw& law, double dashpot) {
  // m = k = v0 = 1: x'' = -max(F(x) + c sqrt(S(x)) x', 0). Runge-Kutta of order 4 until the overlap or the force ends.
  return std::visit(
      [&](const auto& l) {
        Contact c;
        c.stiffness = 1;
        const auto acceleration = [&](double x, double v) {
          if (x <= 0) return 0.0;
          const Elastic e = l(c, x);
          return -std::max(e.force + dashpot * std::sqrt(e.grip) * v, 0.0);
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
      },
      law);
}

double dashpot_for(const ContactLaw& law, double restitution) {
  if (restitution >= 1) return 0;
  const auto too_bouncy = [&](double dashpot) { return restitution_of(law, dashpot) - restitution; };
  double low = 0, high = 1;
  while (too_bouncy(high) > 0 && high < 64) high *= 2;
  // Secants say where it is; halving, which has no bad cases, asks near there alone.
  double near = high, before = low, f_before = 1 - restitution;
  for (int i = 0; i < 12; ++i) {
    const double f = too_bouncy(near), slope = (f - f_before) / (near - before);
    if (!(std::abs(f) > 1e-13) || !(slope < 0)) break;
    before = near, f_before = f;
    near = std::clamp(near - f / slope, low, high);
  }
  const bool found = std::abs(too_bouncy(near)) < 1e-11;
  for (int i = 0; i < 40; ++i) {
    const double mid = 0.5 * (low + high);
    const bool known = found && std::abs(mid - near) > 1e-8 * high;
    ((known ? mid < near : too_bouncy(mid) > 0) ? low : high) = mid;
  }
  return 0.5 * (low + high);
}

void mix(const ContactLaw& law, const Solid& a, const LawConstants& of_a, const Solid& b, const LawConstants& of_b,
         PairLaw& p) {
  std::visit(
      [&]<class Law>(const Law&) { p.own = Law::mix(partner<Law>(a, of_a), partner<Law>(b, of_b), p.shear_ratio); },
      law);
}

double force_at(const ContactLaw& law, const PairLaw& p, double effective_radius, double overlap) {
  return std::visit(
      [&]<class Law>(const Law& l) {
        if constexpr (Law::of_hulls) return static_cast<double>(INFINITY);
        Contact c;
        Law::begin(own<Law>(p), effective_radius, 1, c);
        return l(c, overlap).force;
      },
      law);
}

double reach_of(const ContactLaw& law, std::span<const PairLaw> pairs, double largest_radius) {
  return std::visit(
      [&]<class Law>(const Law&) {
        double reach = 0;
        if constexpr (Law::attracts)
          for (const PairLaw& p : pairs) {
            Contact c;
            Law::begin(own<Law>(p), largest_radius, 1, c);
            reach = std::max(reach, c.reach);
          }
        return reach;
      },
      law);
}

double hardest_impact(const ContactLaw& law, const PairLaw& p, const Impact& impact) {
  return std::visit([&]<class Law>(const Law&) { return Law::hardest_impact(own<Law>(p), impact); }, law);
}

double stiffness_between(const ContactLaw& law, const Solid& solid, const LawConstants& of, double radius) {
  return std::visit(
      [&]<class Law>(const Law&) { return Law::stiffness_between(solid, partner<Law>(solid, of).own, radius); }, law);
}

double energy_of_strain(const ContactLaw& law, const Solid& solid, const LawConstants& of, double volume) {
  return std::visit(
      [&]<class Law>(const Law&) { return Law::energy_of_strain(solid, partner<Law>(solid, of).own, volume); }, law);
}

void scale(const ContactLaw& law, LawConstants& of, double factor) {
  std::visit(
      [&]<class Law>(const Law&) {
        if (auto* found = std::get_if<typename Law::Of>(&of)) Law::scale(*found, factor);
      },
      law);
}

std::optional<Attraction> attraction(const Solid& solid, const LawConstants& of, double radius, double part) {
  std::optional<Attraction> found;
  AllLaws::of(of, [&]<class Law>(const Law&) {
    if constexpr (Law::attracts) found = Law::attraction(solid, std::get<typename Law::Of>(of), radius, part);
  });
  return found;
}

bool attracts(const ContactLaw& law) {
  return std::visit([]<class Law>(const Law&) { return Law::attracts; }, law);
}
bool of_hulls(const ContactLaw& law) {
  return std::visit([]<class Law>(const Law&) { return Law::of_hulls; }, law);
}
bool stiffens(const ContactLaw& law) {
  return std::visit([]<class Law>(const Law&) { return Law::stiffens; }, law);
}

double reduced_modulus(const PairLaw& p) {
  return std::visit(
      []<class Own>(const Own& own) {
        if constexpr (requires { own.youngs; }) return own.youngs;
        return 0.0;
      },
      p.own);
}

}  // namespace grus::dem
