// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/density.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/measure.hpp"

namespace grus::dem {
namespace {

/// More friction than this leaves no more voids: grains roll.
constexpr double most_friction = 1;

/// Tries between which friction is halved or interpolated, at most.
constexpr int most_tries = 25;

/// A friction, and the void ratio that it leaves.
struct Try {
  double friction = 0, void_ratio = 0;
};

/// Between two tries on either side: by their void ratios, but not next to one of them.
double between(const Try& low, const Try& high, double asked) {
  const double straight = (asked - low.void_ratio) / (high.void_ratio - low.void_ratio);
  return low.friction + std::clamp(straight, 0.2, 0.8) * (high.friction - low.friction);
}

}  // namespace

State compressed_to_density(const State& made, const Model& model, const Preparation& p, Team& team,
                            const StageWatch& watch, FoundDensity& found) {
  const double asked = *p.void_ratio;
  State state;
  const auto attempt = [&](double friction) {
    Preparation of = p;
    of.friction = friction, of.void_ratio = {};
    state = compressed(made, model, of, team, watch);
    ++found.tries;
    return Try{friction, void_ratio(state)};
  };
  const auto met = [&](const Try& t) {
    found.friction = t.friction;
    return std::abs(t.void_ratio - asked) <= density_tolerance;
  };
  const Try first = attempt(std::min(p.friction, most_friction));
  if (met(first)) return state;
  const bool looser = first.void_ratio < asked;
  const Try end = attempt(looser ? most_friction : 0);
  if (met(end)) return state;
  Try low = looser ? first : end, high = looser ? end : first;
  if (!(low.void_ratio < asked && asked < high.void_ratio)) {
    const Try other = attempt(looser ? 0 : most_friction);
    refuse(p.place_of_density,
           fmt::format("a void ratio of {:.3f} is not reached at {:.3g} MPa: friction while compressing from 0 to {:g} "
                       "leaves {:.3f} to {:.3f} from this packing (void ratio {:.3f}); a looser one, or "
                       "rolling_friction, leaves more",
                       asked, p.pressure / 1e6, most_friction, std::min(end.void_ratio, other.void_ratio),
                       std::max(end.void_ratio, other.void_ratio), void_ratio(made)));
  }
  while (found.tries < most_tries) {
    const Try t = attempt(between(low, high, asked));
    if (met(t)) return state;
    (t.void_ratio < asked ? low : high) = t;
  }
  refuse(p.place_of_density,
         fmt::format("a void ratio of {:.3f} is jumped over: a friction of {:.4g} leaves {:.4f}, one "
                     "of {:.4g} {:.4f}; take more grains",
                     asked, low.friction, low.void_ratio, high.friction, high.void_ratio));
}

}  // namespace grus::dem
