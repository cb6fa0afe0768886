// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/density.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/measure.hpp"

namespace grus::dem {
namespace {

/// More friction than this leaves no more voids: grains roll.
constexpr double most_friction = 1;

/// Without any friction grains may rattle on; with so little it is next to none.
constexpr double little_friction = 0.02;

/// Tries between which friction is halved or interpolated, at most.
constexpr int most_tries = 25;

/// A friction, and the void ratio that it leaves.
struct Try {
  double friction, void_ratio;
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
    const std::string called = fmt::format("preparation, try {}", found.tries + 1);  // each has a progress of its own
    const StageWatch own = [&](double part, const char*) { return watch(part, called.c_str()); };
    state = compressed(made, model, of, team, watch ? own : StageWatch());
    ++found.tries;
    return Try{friction, void_ratio(state)};
  };
  const auto met = [&](const Try& t) {
    found.friction = t.friction;
    return std::abs(t.void_ratio - asked) <= density_tolerance;
  };
  const auto densest = [&] {
    try {
      return attempt(0);
    } catch (const Unstable&) {
      return attempt(little_friction);
    }
  };
  const Try first = attempt(std::min(p.friction, most_friction));
  if (met(first)) return state;
  const bool looser = first.void_ratio < asked;
  const Try end = looser ? attempt(most_friction) : densest();
  if (met(end)) return state;
  Try low = looser ? first : end, high = looser ? end : first;
  if (!(low.void_ratio < asked && asked < high.void_ratio)) {
    const Try other = looser ? densest() : attempt(most_friction);
    refuse(
        p.place_of_density,
        fmt::format("a void ratio of {:.3f} is not reached at {:.3g} MPa: friction while compressing from {:g} to {:g} "
                    "leaves {:.3f} to {:.3f} from this packing (void ratio {:.3f}); a looser one, or "
                    "rolling_friction, leaves more",
                    asked, p.pressure / 1e6, std::min(end.friction, other.friction), most_friction,
                    std::min(end.void_ratio, other.void_ratio), std::max(end.void_ratio, other.void_ratio),
                    void_ratio(made)));
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
