// SPDX-License-Identifier: LGPL-3.0-or-later
// How stiffly contacts and bonds hold each grain, as the critical step and the inertia by step ask for it.
#pragma once

#include <array>
#include <numeric>
#include <optional>
#include <span>

#include "dem/base/parallel.hpp"
#include "dem/bond/bonds.hpp"
#include "dem/contact/laws.hpp"
#include "dem/state/bonds.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"

namespace grus::dem {

struct Stiffness {
  double normal = 0, tangential = 0;
  // N m, of the couples' springs by row; to that of rolling is added force x path of the contact point per radian,
  // which rules where flat faces meet. Sliding has none.
  std::array<double, spring_rows> couple{};

  double of_turns() const { return std::accumulate(couple.begin() + first_couple, couple.end(), 0.0); }
};

/// The stiffnesses of all contacts. Of hulls alone: where each acts, from the mass centres of a and b (m), the modulus
/// of its foundation with what sharp contacts resist more (Pa/m; 0: none).
struct Stiffnesses {
  std::vector<Stiffness> of;
  std::vector<std::array<Vec3, 2>> arm;
  std::vector<double> firm;
  std::vector<double> viscous;  // of the dashpots along the normals (N s/m), but spheres'; empty where there is none
};

/// Bonds by grain, each at most as stiff as it will ever be; empty without bonds.
struct BondsOfGrains {
  struct End {
    BondStiffness most;
    Vec3 arm;
  };
  std::vector<std::vector<End>> of, resisting;  // `most` of these: against velocities

  BondsOfGrains(const Grains& grains, const Bonds& bonds);
};

/// What holds the grains of a state; the masses are asked for anew with every question. Must not outlive what it was
/// made of.
class HeldGrains {
public:
  /// `ahead` (s): hulls that may meet within that time hold each other already. `team`: who finds it all, and must
  /// stay.
  HeldGrains(const ContactLaw& law, std::span<const PairLaw> pairs, std::size_t materials, const Grains& grains,
             const Boundary& boundary, const Contacts& contacts, const Bonds& bonds, double ahead, Team& team);

  /// Finds how the contacts of these grains resist turns, by the whole team; of others that is found when it is asked
  /// for.
  void look_at(const std::vector<std::uint8_t>& grains) const;

  /// Of each grain a bound of its largest eigenvalue (1/s^2), found at once.
  std::vector<double> cheap_bounds() const;

  /// Mass-scaled 6 x 6 stiffness of grain i (1/s^2), and the same of what resists its velocities (1/s).
  Mat6 stiffness(std::size_t i) const;
  Mat6 resistance(std::size_t i) const;
  bool resisted() const { return !bonds_.resisting.empty(); }

  /// What dashpots of contacts resist, but those of spheres: the mass-scaled 6 x 6 matrix of grain i, and a bound of
  /// the largest eigenvalue of each grain, found at once (1/s).
  bool damped() const { return !contact_.viscous.empty(); }
  Mat6 drag(std::size_t i) const;
  std::vector<double> cheap_drags() const;

  /// The eigenvalue (1/s^2) of the hardest impact that the speed of grain i allows, against another of its material or
  /// a wall, if it had this mass (kg).
  double impact(std::size_t i, double mass) const;

  /// The eigenvalue (1/s^2) that contact c of hulls alone gives to either, as the contacts watch it step by step.
  double alone(std::size_t c) const;

  /// By grain whether it is a hull that a contact or a bond holds: impacts of hulls, whatever their speed, are those of
  /// their mean shadow. Those of other grains go by their speed, and always count.
  std::vector<std::uint8_t> touched() const;

  const Grains& grains() const { return g_; }
  Team& team() const { return team_; }
  const Cell& cell() const { return boundary_.cell; }
  double max_speed() const { return max_speed_; }    // of a grain (m/s)
  double wall_speed() const { return wall_speed_; }  // of a wall (m/s)

private:
  /// Where contact c acts on grain i, from its mass centre (m).
  Vec3 arm(std::size_t i, std::size_t c, bool is_b) const;
  /// How contact c of hulls resists turns about where it acts, by axis (N m).
  const Mat3& turning(std::size_t c) const;

  const ContactLaw& law_;
  std::span<const PairLaw> pairs_;
  std::size_t materials_;
  const Grains& g_;
  const Boundary& boundary_;
  const Contacts& contacts_;
  Team& team_;
  double max_speed_ = 0, wall_speed_ = 0;
  Stiffnesses contact_;
  mutable std::vector<std::optional<Mat3>> turning_;  // by contact, found once it is asked for: of few grains
  BondsOfGrains bonds_;
};

/// The frequency, squared, whose step 2 / omega is that of stiffness k with dashpots c whose velocities lag by half a
/// step: k dt^2 + 2 c dt < 4, all scaled by mass.
double with_dashpots(double k, double c);

/// Upper bound of the largest eigenvalue of a symmetric positive matrix, at most 6^(1/8) = 1.25 times it: (tr
/// S^8)^(1/8).
double largest_eigenvalue_bound(const Mat6& s);

/// The largest eigenvalue itself.
double largest_eigenvalue(const Mat6& s);

}  // namespace grus::dem
