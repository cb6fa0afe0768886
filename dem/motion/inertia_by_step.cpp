// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/inertia_by_step.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace grus::dem {
namespace {

/// Factors on what a grain has against shifts and turns.
struct Factors {
  double shift, turn;
};

/// A matrix scaled by mass, once shifts and turns are resisted by other masses.
Mat6 rescaled(const Mat6& s, const Factors& f) {
  Eigen::Matrix<double, 6, 1> by;
  by << Vec3::Constant(1 / std::sqrt(f.shift)), Vec3::Constant(1 / std::sqrt(f.turn));
  return by.asDiagonal() * s * by.asDiagonal();
}

/// What contacts and bonds do to a grain, scaled by the masses that it has.
struct Held {
  Mat6 stiffness, resistance = Mat6::Zero();
  bool resisted;

  Held(const HeldGrains& held, std::size_t i) : stiffness(held.stiffness(i)), resisted(held.resisted()) {
    if (resisted) resistance = held.resistance(i);
  }
  double slow(const Factors& f) const { return resisted ? largest_eigenvalue(rescaled(resistance, f)) : 0; }

  /// Whether so many times its masses leave the eigenvalue at `most`.
  bool at_most(double most, const Factors& f) const {
    const Mat6 s = rescaled(stiffness, f);
    if (resisted) return with_dashpots(largest_eigenvalue(s), slow(f)) <= most;
    return (most * Mat6::Identity() - s).llt().info() == Eigen::Success;  // positive definite: all are below
  }
};

/// The least factors from `f` on with which contacts and bonds leave the eigenvalue at `most`: each time those masses
/// rise that take part in the fastest motion, as they take part. Alone, shifts or turns end in one go.
Factors enough(const Held& held, double most, Factors f) {
  for (int round = 0; round < 100; ++round) {
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(rescaled(held.stiffness, f));
    const double excess = with_dashpots(eigen.eigenvalues()[5], held.slow(f)) / most;
    if (!(excess > 1 + 1e-9)) break;
    const double turns = eigen.eigenvectors().col(5).tail<3>().squaredNorm(), shifts = 1 - turns;
    const double way = std::log(excess) / (shifts * shifts + turns * turns);
    f.shift *= std::exp(shifts * way), f.turn *= std::exp(turns * way);
  }
  return f;
}

/// The mass (kg) from `mass` on with which the hardest impact leaves it there.
double enough_for_impact(const HeldGrains& held, std::size_t i, double most, double mass) {
  for (int round = 0; round < 100; ++round) {
    const double excess = held.impact(i, mass) / most;
    if (!(excess > 1 + 1e-9)) break;
    mass *= excess;
  }
  return mass;
}

/// Whether grain i has enough, and no more than `least` of which half would do: most grains of most estimates, which
/// are so spared the search for what they need.
bool suits(const Held& on, const HeldGrains& held, std::size_t i, double most, double least, bool flies) {
  const Grains& g = held.grains();
  const double mass = g.mass[i], bound = (1 + 1e-7) * most;  // what was searched for ends at `most` itself
  if (!on.at_most(bound, {1, 1}) || (flies && held.impact(i, mass) > bound)) return false;
  if (flies) return true;
  const bool less_mass = mass > 2 * least && on.at_most(bound, {0.5, 1}) && held.impact(i, 0.5 * mass) <= bound;
  return !less_mass && !(turn_mass(g, i) > 2 * least && on.at_most(bound, {1, 0.5}));
}

/// What a grain gets that has `now` and needs `need`, round-off apart; it gives up what is over once `rest` is less
/// than half of it.
double settled(double now, double need, double rest) {
  return need > (1 + 1e-7) * now ? need : 2 * rest < now ? rest : now;
}

/// Grain i gets these masses (kg). Where they grow its momentum stays, against the affine field, and its angular
/// momentum; where they fall its velocity and spin: motion never gains energy of it, or fast grains would get mass,
/// mass would drive others, and these would be fast.
void change(Grains& g, std::size_t i, double mass, double turning, const Mat3& affine) {
  const double keep = std::min(1.0, g.mass[i] / mass), keep_turn = std::min(1.0, turn_mass(g, i) / turning);
  set_inertia(g, i, mass, turning);
  Motion& m = g.motion[i];
  const Vec3 field = affine * m.position;
  if (keep < 1) m.velocity = field + keep * (m.velocity - field);
  if (keep_turn < 1) m.spin *= keep_turn, g.angular_momentum[i] *= keep_turn;
}

}  // namespace

GivenInertia give_inertia(const HeldGrains& held, double most, const std::vector<double>& floor, Grains& g) {
  const std::vector<double> bound = held.cheap_bounds();
  const std::vector<std::uint8_t> touched = held.touched();
  const Mat3 affine = held.cell().gradient();
  std::vector<std::uint8_t> asked(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) {
    const bool bare = g.mass[i] <= floor[i] && turn_mass(g, i) <= floor[i];
    asked[i] = !(bare && bound[i] <= most && (touched[i] || held.impact(i, g.mass[i]) <= most));
  }
  held.look_at(asked);
  std::vector<std::array<double, 2>> settles(g.size());
  held.team().blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      settles[i] = {g.mass[i], turn_mass(g, i)};
      if (!asked[i]) continue;
      const auto [mass, turning] = settles[i];
      const double least = floor[i];
      const bool flies = !touched[i];
      const Held on(held, i);
      if (suits(on, held, i, most, least, flies)) continue;
      const Factors need = enough(on, most, {std::min(1.0, least / mass), std::min(1.0, least / turning)});
      const double shift = std::max(least, mass * need.shift), turn = std::max(least, turning * need.turn);
      const double impact = enough_for_impact(held, i, most, shift);
      // A hull that nothing touches keeps what it has: nobody knows how it will be met.
      settles[i] = {settled(mass, flies ? impact : shift, flies ? INFINITY : impact),
                    settled(turning, turn, flies ? INFINITY : turn)};
    }
  });
  GivenInertia given;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const double mass = g.mass[i], turning = turn_mass(g, i);
    const auto [new_mass, new_turning] = settles[i];
    if (new_mass == mass && new_turning == turning) continue;
    given.rise = std::max({given.rise, new_mass / mass, new_turning / turning});
    given.kinetic -= kinetic_energy(g, i);
    change(g, i, new_mass, new_turning, affine);
    given.kinetic += kinetic_energy(g, i);
  }
  return given;
}

AddedInertia added_inertia(const Grains& g) {
  AddedInertia added;
  double solid = 0, moments = 0;
  std::size_t heavier = 0, slower = 0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    const double m = solid_mass(g, i), turning = turn_mass(g, i), now = g.inertia[i].moments.sum();
    const double own = turning > m ? now * m / turning : now;
    solid += m, moments += own;
    added.mass += g.mass[i] - m, added.moment += now - own;
    heavier += g.mass[i] > m, slower += turning > m;
  }
  const double all = static_cast<double>(g.size());
  added.mass /= solid, added.moment /= moments;
  added.heavier = static_cast<double>(heavier) / all, added.slower = static_cast<double>(slower) / all;
  return added;
}

double largest_inertial_number(const Grains& g, double rate, double pressure) {
  double most = 0;
  for (std::size_t i = 0; i < g.size(); ++i)
    most = std::max(most, 2 * g.extent[i].equivalent_radius * std::sqrt(g.mass[i] / (g.extent[i].volume * pressure)));
  return rate * most;
}

}  // namespace grus::dem
