// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/critical_step.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "dem/bond/dashpots.hpp"
#include "dem/bond/kinds.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

struct Stiffness {
  double normal = 0, tangential = 0;
  // N m, of the couples' springs by row; to that of rolling is added force x path of the contact point per radian,
  // which rules where flat faces meet. Sliding has none.
  std::array<double, spring_rows> turning{};

  double of_turns() const { return std::accumulate(turning.begin() + first_couple, turning.end(), 0.0); }
};

/// The stiffnesses of all contacts; `arm`: where each contact of hulls acts, from the mass centres of a and b (m),
/// empty without hulls.
struct Stiffnesses {
  std::vector<Stiffness> of;
  std::vector<std::array<Vec3, 2>> arm;
};

/// What a contact on an edge or a vertex gains on a further overlap beyond modulus x area: at a vertex of a cube 1.37.
constexpr double sharp = 1.4;

/// Hulls: the whole area resists, rocking by its second moment; where it lies is looked up again.
void place_hulls(const Grains& g, const Boundary& boundary, const Contacts& contacts, Stiffnesses& all) {
  if (g.hull.empty()) return;
  std::vector<Stiffness>& k = all.of;
  all.arm.resize(k.size());
  for (const Bin bin : {hull_hull, hull_wall})
    for (std::size_t c = contacts.begin[bin]; c < contacts.begin[bin + 1]; ++c) {
      if (k[c].normal == 0) continue;
      const Pair& p = contacts.pair[c];
      const Overlap o = bin == hull_hull ? overlap_of_pair(g, boundary.cell, p, contacts.touch[c].normal)
                                         : overlap_at_wall(g, boundary.walls[p.b], p.a);
      k[c].normal *= sharp, k[c].tangential *= sharp;
      k[c].turning[roll_spring] = sharp * contacts.contact.radius[c] * o.polar;  // and spin about the normal
      all.arm[c][0] = o.middle;
      if (bin == hull_wall) continue;
      all.arm[c][1] = o.middle - branch(g, boundary.cell, {p.a, p.b, p.image});
    }
}

template <class Law>
Stiffness stiffness_of(const Law& law, const PairLaw& p, const Contact& c, double overlap) {
  Stiffness s;
  if (c.stiffness <= 0) return s;
  s.normal = law(c, overlap).grip;
  s.tangential = p.friction[slide_spring] > 0 ? p.shear_ratio * s.normal : 0;
  for (const SpringRow row : couple_springs)
    s.turning[row] = p.friction[row] > 0 ? s.tangential * c.radius * c.radius : 0;
  return s;
}

/// Bodies of radii H_A, H_B roll on each other by the parallel sum of both; its trace is at most that of the traces.
double rolling_path(const Grains& g, const Contacts& contacts, std::size_t k) {
  const Pair& p = contacts.pair[k];
  const Vec3& n = contacts.touch[k].normal;
  const double a = sum_of_radii(g, p.a, n);
  if (k >= contacts.begin[first_wall]) return a;
  const double b = sum_of_radii(g, p.b, -n);
  return a * b / (a + b);
}

/// Upper bound of the largest eigenvalue of a symmetric positive matrix, at most 6^(1/8) = 1.25 times it: (tr
/// S^8)^(1/8).
double largest_eigenvalue_bound(const Mat6& s) {
  const Mat6 s2 = s * s, s4 = s2 * s2;
  return std::sqrt(std::sqrt(std::sqrt(s4.squaredNorm()))) * (1 + 1e-12);
}

/// Stiffness of every contact.
Stiffnesses stiffnesses(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& g,
                        const Boundary& boundary, const Contacts& contacts) {
  Stiffnesses all;
  std::vector<Stiffness>& k = all.of;
  k.resize(contacts.size());
  const auto fill = [&](const auto& l) {
    for (std::size_t c = 0; c < contacts.size(); ++c)
      k[c] = stiffness_of(l, pairs[contacts.pair[c].law], contacts.contact[c], contacts.touch[c].overlap);
    for (std::size_t bin = 0; bin < bin_count; ++bin)
      if (pair_kind(bin).rolls)
        for (std::size_t c = contacts.begin[bin]; c < contacts.begin[bin + 1]; ++c)
          if (k[c].normal > 0)
            k[c].turning[roll_spring] +=
                l(contacts.contact[c], contacts.touch[c].overlap).force * rolling_path(g, contacts, c);
  };
  std::visit(fill, law);
  place_hulls(g, boundary, contacts, all);
  return all;
}

/// Bonds by grain, each at most as stiff as it will ever be; empty without bonds.
struct BondsOfGrains {
  struct End {
    BondStiffness most;
    Vec3 arm;
  };
  std::vector<std::vector<End>> of, resisting;  // `most` of these: against velocities

  BondsOfGrains(const Grains& g, const Bonds& bonds)
      : of(bonds.empty() ? 0 : g.size()), resisting(bonds.dashpot.empty() ? 0 : g.size()) {
    for (std::size_t k = 0; k < bonds.dashpot.size(); ++k) {
      const FaceBond& bond = bonds.face.row[k];
      const BondStiffness most = resistance(bond, bonds.dashpot[k], g.orientation[bond.ends.a]);
      for (const auto& [i, at] : {std::pair{bond.ends.a, bond.at_a}, std::pair{bond.ends.b, bond.at_b}})
        resisting[i].push_back({most, g.orientation[i] * at});
    }
    for_each_bond(bonds, [&](const auto& bond) {
      const BondStiffness most = stiffest(bond, g.orientation[bond.ends.a]);
      for (const auto& [i, at] : {std::pair{bond.ends.a, bond.at_a}, std::pair{bond.ends.b, bond.at_b}})
        of[i].push_back({most, g.orientation[i] * at});
    });
    for (const FaceBond& bond : bonds.wall) {  // which gives way to nothing: half of what two grains feel
      const BondStiffness most = stiffest(bond, g.orientation[bond.ends.a]);
      of[bond.ends.a].push_back({{0.5 * most.shift, 0.5 * most.turn}, g.orientation[bond.ends.a] * bond.at_a});
    }
  }
};

/// Trace of what bonds do to grain i, scaled by its mass.
double trace_of(const Grains& g, std::span<const BondsOfGrains::End> ends, std::size_t i) {
  double sum = 0;
  for (const auto& [most, arm] : ends)
    sum += 2 * (most.shift.trace() * g.motion[i].inverse_mass +
                (most.shift.trace() * arm.squaredNorm() + most.turn.trace()) / g.inertia[i].moments.minCoeff());
  return sum;
}

/// The frequency, squared, whose step 2 / omega is that of stiffness k with dashpots c whose velocities lag by half a
/// step: k dt^2 + 2 c dt < 4, all scaled by mass.
double with_dashpots(double k, double c) {
  if (c == 0) return k;
  const double omega = 0.5 * (c + std::sqrt(c * c + 4 * k));
  return omega * omega;
}

/// How far a normal of grain i's surface passes by its mass centre, at most: of an ellipsoid the difference of its half
/// axes.
double lever_bound(const Grains& g, std::size_t i) {
  switch (g.kind[i]) {
    case ShapeKind::sphere:
      return 0;
    case ShapeKind::hull:
      return g.motion[i].radius;
    case ShapeKind::polyellipsoid:
      break;
  }
  const PolyEllipsoid& p = g.shape[i];
  return std::max(p.plus.maxCoeff(), p.minus.maxCoeff()) - std::min(p.plus.minCoeff(), p.minus.minCoeff()) +
         0.375 * (p.plus - p.minus).norm();
}

/// How contacts alone resist a grain: stiffness against shifts, and no less than its largest against turns.
struct Resistance {
  double diagonal[3] = {}, beside[3] = {}, turn = 0;

  void add(double weight, const Stiffness& s, const Vec3& n, double arm, double lever) {
    const double more = weight * (s.normal - s.tangential), all = weight * s.tangential;
    for (int j = 0; j < 3; ++j) diagonal[j] += all + more * n[j] * n[j], beside[j] += more * n[j] * n[(j + 1) % 3];
    turn += weight * (s.tangential * arm * arm + std::max(s.normal - s.tangential, 0.0) * lever * lever + s.of_turns());
  }
  /// Frobenius norm of the stiffness against shifts.
  double shift() const {
    double sum = 0;
    for (int j = 0; j < 3; ++j) sum += diagonal[j] * diagonal[j] + 2 * beside[j] * beside[j];
    return std::sqrt(sum);
  }
};

/// A cheap bound for each grain of the largest eigenvalue of its mass-scaled stiffness: that of the part of shifts and
/// that of the part of turns together, and of bonds the trace.
std::vector<double> cheap_bounds(const Grains& g, const Contacts& contacts, const BondsOfGrains& bonds,
                                 const std::vector<Stiffness>& k) {
  const std::size_t walls = contacts.begin[first_wall];
  std::vector<Resistance> of(g.size());
  std::vector<double> lever(g.frame.empty() ? 0 : g.size()), bound(g.size());
  for (std::size_t i = 0; i < lever.size(); ++i) lever[i] = lever_bound(g, i);
  auto add = [&](std::size_t i, double weight, std::size_t c) {
    of[i].add(weight, k[c], contacts.touch[c].normal, g.motion[i].radius, lever.empty() ? 0 : lever[i]);
  };
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (k[c].normal == 0) continue;
    const Pair& p = contacts.pair[c];
    add(p.a, c < walls ? 2 : 1, c);
    if (c < walls) add(p.b, 2, c);
  }
  for (std::size_t i = 0; i < g.size(); ++i)
    bound[i] = (1 + 1e-12) * (of[i].shift() * g.motion[i].inverse_mass + of[i].turn / g.inertia[i].moments.minCoeff());
  for (std::size_t i = 0; i < bonds.of.size(); ++i) bound[i] += trace_of(g, bonds.of[i], i);
  for (std::size_t i = 0; i < bonds.resisting.size(); ++i)
    bound[i] = with_dashpots(bound[i], trace_of(g, bonds.resisting[i], i));
  return bound;
}

/// The same for the hardest impact that a grain's speed allows, against another of its material or a wall.
double impact_bound(const ContactLaw& law, const PairLaw& p, const Grains& g, std::size_t i, bool walled,
                    double speed) {
  // Against a wall all of the grain's mass counts, against a grain half.
  Impact impact{(walled ? 1 : 0.5) * g.mass[i], g.extent[i].equivalent_radius, speed, walled};
  if (g.kind[i] == ShapeKind::hull) {
    const HullRow& hull = g.hulls->row[g.hull[i]];
    impact.surface = 3 * hull.volume / hull.depth, impact.depth = hull.depth;
  }
  return 2 * hardest_impact(law, p, impact) * g.motion[i].inverse_mass;
}

/// Blocks of a grain's 6 x 6 stiffness: sum of w J^T K J, J = [1, -arm x].
struct Blocks {
  Mat3 shift = Mat3::Zero(), mixed = Mat3::Zero(), turn = Mat3::Zero();

  void add(std::span<const BondsOfGrains::End> ends) {
    for (const auto& end : ends) add(2, end.most.shift, end.arm), turn += 2 * end.most.turn;
  }

  void add(double weight, const Mat3& stiffness, const Vec3& arm) {
    const Mat3 lever = cross_matrix(arm), by_turn = stiffness * lever;
    shift += weight * stiffness;
    mixed -= weight * by_turn;
    turn += weight * lever.transpose() * by_turn;
  }
};

Mat6 scaled_by_mass(const Grains& g, std::size_t i, const Blocks& blocks) {
  const double by_mass = std::sqrt(g.motion[i].inverse_mass);
  Mat3 by_inertia = std::sqrt(g.motion[i].inverse_inertia) * Mat3::Identity();
  if (!is_sphere(g, i)) {
    const Mat3 axes = (g.orientation[i] * g.inertia[i].axes).toRotationMatrix();
    by_inertia = axes * g.inertia[i].moments.cwiseSqrt().cwiseInverse().asDiagonal() * axes.transpose();
  }
  Mat6 scaled;
  scaled.topLeftCorner<3, 3>() = by_mass * by_mass * blocks.shift;
  scaled.bottomRightCorner<3, 3>() = by_inertia * blocks.turn * by_inertia;
  scaled.topRightCorner<3, 3>() = by_mass * blocks.mixed * by_inertia;
  scaled.bottomLeftCorner<3, 3>() = scaled.topRightCorner<3, 3>().transpose();
  return scaled;
}

/// Mass-scaled 6 x 6 stiffness of grain i.
Mat6 scaled_stiffness(const Grains& g, const Contacts& contacts, const BondsOfGrains& bonds, const Stiffnesses& all,
                      std::size_t i) {
  const std::vector<Stiffness>& k = all.of;
  Blocks blocks;
  Mat3 &shift = blocks.shift, &mixed = blocks.mixed, &turn = blocks.turn;
  for (Index e = contacts.index.first[i]; e < contacts.index.first[i + 1]; ++e) {
    const std::size_t c = contacts.index.entry[e] >> 1;
    if (k[c].normal == 0) continue;
    const double weight = c < contacts.begin[first_wall] ? 2 : 1, kt = weight * k[c].tangential;
    const Vec3 outward = (contacts.index.entry[e] & 1) ? Vec3(-contacts.touch[c].normal) : contacts.touch[c].normal;
    const Mat3 nn = outward * outward.transpose(), across = Mat3::Identity() - nn;
    if (is_sphere(g, i)) {  // arm = radius x normal: in closed form
      const double radius = g.motion[i].radius;
      shift += weight * k[c].normal * nn + kt * across;
      mixed -= kt * radius * cross_matrix(outward);
      turn += kt * radius * radius * across;
    } else {
      const Vec3 arm = all.arm.empty() ? surface_arm(g, i, outward) : all.arm[c][contacts.index.entry[e] & 1];
      blocks.add(weight, k[c].normal * nn + k[c].tangential * across, arm);
    }
    for (const SpringRow row : couple_springs)
      turn += weight * k[c].turning[row] * (all.arm.empty() ? own_turn(row, outward) : Mat3(Mat3::Identity()));
  }
  if (!bonds.of.empty()) blocks.add(bonds.of[i]);
  return scaled_by_mass(g, i, blocks);
}

/// Largest eigenvalue of the dashpots of grain i, scaled by its mass.
double scaled_resistance(const Grains& g, const BondsOfGrains& bonds, std::size_t i) {
  if (bonds.resisting.empty()) return 0;
  Blocks blocks;
  blocks.add(bonds.resisting[i]);
  return Eigen::SelfAdjointEigenSolver<Mat6>(scaled_by_mass(g, i, blocks), Eigen::EigenvaluesOnly).eigenvalues()[5];
}

}  // namespace

CriticalStep critical_step(const ContactLaw& law, std::span<const PairLaw> pairs, std::size_t materials,
                           const Grains& g, const Boundary& boundary, const Contacts& contacts, const Bonds& bonds) {
  const std::size_t n = g.size();
  CriticalStep critical;
  double wall_speed = 0;
  for (const auto& wall : boundary.walls) wall_speed = std::max(wall_speed, wall.velocity.norm());
  for (const auto& m : g.motion) critical.max_speed = std::max(critical.max_speed, m.velocity.norm());

  const Stiffnesses k = stiffnesses(law, pairs, g, boundary, contacts);
  const BondsOfGrains bonded(g, bonds);
  const std::vector<double> bound = cheap_bounds(g, contacts, bonded, k.of);
  std::vector<double> impact(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double speed = std::max({g.motion[i].velocity.norm() + critical.max_speed, wall_speed, 1e-6});
    impact[i] =
        impact_bound(law, pairs[g.material[i] * materials + g.material[i]], g, i, !boundary.walls.empty(), speed);
  }

  // Exact 6 x 6 eigenvalues only where the bound could set the step.
  std::vector<Index> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    const double x = std::max(bound[a], impact[a]), y = std::max(bound[b], impact[b]);
    return x != y ? x > y : a < b;
  });
  double worst = 0;
  for (const Index i : order) {
    if (std::max(bound[i], impact[i]) <= worst) break;
    const Mat6 scaled = scaled_stiffness(g, contacts, bonded, k, i);
    const double slow = scaled_resistance(g, bonded, i);
    if (std::max(with_dashpots(largest_eigenvalue_bound(scaled), slow), impact[i]) <= worst) continue;
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(scaled, Eigen::EigenvaluesOnly);
    const double value = std::max(with_dashpots(eigen.eigenvalues()[5], slow), impact[i]);
    if (value > worst) worst = value, critical.grain = i;
  }
  if (worst > 0) critical.dt = 2 / std::sqrt(worst);
  // No grain moves by more than a twentieth of its smallest width in a step.
  for (std::size_t i = 0; i < n; ++i) {
    const double speed = g.motion[i].velocity.norm() + g.motion[i].spin.norm() * g.motion[i].radius + wall_speed;
    if (speed > 0) critical.dt = std::min(critical.dt, 0.05 * g.extent[i].least_width / speed);
  }
  return critical;
}

}  // namespace grus::dem
