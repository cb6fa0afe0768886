// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/motion/grain_stiffness.hpp"

#include <algorithm>

#include "dem/bond/dashpots.hpp"
#include "dem/bond/kinds.hpp"
#include "dem/contact/hull_pairs.hpp"
#include "dem/contact/springs.hpp"
#include "dem/motion/contact_stiffness.hpp"
#include "dem/shape/contact_patch.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

/// The planes of a hull or a wall in the frame of A.
void planes_in(const HullView& b, const Mat3& turn, const Vec3& shift, std::vector<Plane>& planes) {
  planes.clear();
  for (int f = 0; f < b.faces; ++f) {
    const Vec3 normal = turn * b.plane[f].normal;
    planes.push_back({normal, b.plane[f].offset + normal.dot(shift)});
  }
}

/// The same of a wall whose point is `to` from A's mass centre; of kinds that hulls do not meet none.
void planes_of_wall(const auto&, const Grains&, const Mat3&, const Vec3&, std::vector<Plane>& planes) {
  planes.clear();
}

void planes_of_wall(const PlaneWall& wall, const Grains&, const Mat3& back, const Vec3& to,
                    std::vector<Plane>& planes) {
  planes = {{back * wall.normal, wall.normal.dot(to)}};
}

void planes_of_wall(const RollerWall& wall, const Grains& g, const Mat3& back, const Vec3& to,
                    std::vector<Plane>& planes) {
  planes_in((*g.hulls)[wall.hull], back, back * to, planes);
}

/// Trace of what bonds do to grain i, scaled by its mass.
double trace_of(const Grains& g, std::span<const BondsOfGrains::End> ends, std::size_t i) {
  double sum = 0;
  for (const auto& [most, arm] : ends)
    sum += 2 * (most.shift.trace() * g.motion[i].inverse_mass +
                (most.shift.trace() * arm.squaredNorm() + most.turn.trace()) / g.inertia[i].moments.minCoeff());
  return sum;
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

}  // namespace

BondsOfGrains::BondsOfGrains(const Grains& g, const Bonds& bonds)
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

HeldGrains::HeldGrains(const ContactLaw& law, std::span<const PairLaw> pairs, std::size_t materials, const Grains& g,
                       const Boundary& boundary, const Contacts& contacts, const Bonds& bonds, double ahead, Team& team)
    : law_(law),
      pairs_(pairs),
      materials_(materials),
      g_(g),
      boundary_(boundary),
      contacts_(contacts),
      team_(team),
      contact_(stiffnesses(law, pairs, g, boundary, contacts, ahead, team)),
      turning_(contact_.firm.size()),
      bonds_(g, bonds) {
  for (const auto& wall : boundary.walls) wall_speed_ = std::max(wall_speed_, wall.velocity.norm());
  for (const auto& m : g.motion) max_speed_ = std::max(max_speed_, m.velocity.norm());
}

std::vector<double> HeldGrains::cheap_bounds() const {
  const std::vector<Stiffness>& k = contact_.of;
  const std::size_t walls = contacts_.begin[first_wall];
  std::vector<Resistance> of(g_.size());
  std::vector<double> lever(g_.frame.empty() ? 0 : g_.size()), bound(g_.size());
  for (std::size_t i = 0; i < lever.size(); ++i) lever[i] = lever_bound(g_, i);
  auto add = [&](std::size_t i, double weight, std::size_t c) {
    of[i].add(weight, k[c], contacts_.touch[c].normal, g_.motion[i].radius, lever.empty() ? 0 : lever[i]);
  };
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (k[c].normal == 0) continue;
    const Pair& p = contacts_.pair[c];
    add(p.a, c < walls ? 2 : 1, c);
    if (c < walls) add(p.b, 2, c);
  }
  for (std::size_t i = 0; i < g_.size(); ++i)
    bound[i] =
        (1 + 1e-12) * (of[i].shift() * g_.motion[i].inverse_mass + of[i].turn / g_.inertia[i].moments.minCoeff());
  for (std::size_t i = 0; i < bonds_.of.size(); ++i) bound[i] += trace_of(g_, bonds_.of[i], i);
  for (std::size_t i = 0; i < bonds_.resisting.size(); ++i)
    bound[i] = with_dashpots(bound[i], trace_of(g_, bonds_.resisting[i], i));
  return bound;
}

Vec3 HeldGrains::arm(std::size_t i, std::size_t c, bool is_b) const {
  if (!contact_.arm.empty()) return contact_.arm[c][is_b];
  const Vec3& n = contacts_.touch[c].normal;
  return surface_arm(g_, i, is_b ? Vec3(-n) : n);
}

const Mat3& HeldGrains::turning(std::size_t c) const {
  std::optional<Mat3>& known = turning_[c];
  if (known) return *known;
  if (!(contact_.firm[c] > 0)) return known.emplace(Mat3::Zero());
  const Pair& p = contacts_.pair[c];
  const Mat3 &axes = g_.frame[p.a].axes, back = axes.transpose();
  std::vector<Plane> planes;
  if (c < contacts_.begin[first_wall]) {
    const Vec3 shift = branch(g_, boundary_.cell, {p.a, p.b, p.image});
    planes_in((*g_.hulls)[g_.hull[p.b]], back * g_.frame[p.b].axes, back * shift, planes);
  } else {
    const Wall& wall = boundary_.walls[p.b];
    const Vec3 to = wall.point - g_.motion[p.a].position;
    std::visit([&](const auto& shape) { planes_of_wall(shape, g_, back, to, planes); }, wall.shape);
  }
  const Vec3& n = contacts_.touch[c].normal;
  const Stiffness& k = contact_.of[c];
  const Mat3 patch = axes * turning_of_patch((*g_.hulls)[g_.hull[p.a]], planes, back * contact_.arm[c][0]) * back;
  const double without = (1 - k.tangential / k.normal) * n.dot(patch * n);  // of spin about it: friction's
  return known.emplace(contact_.firm[c] * (patch - without * n * n.transpose()));
}

void HeldGrains::look_at(const std::vector<std::uint8_t>& grains) const {
  if (contact_.arm.empty()) return;
  const std::size_t walls = contacts_.begin[first_wall];
  team_.blocks(contacts_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c)
      if (contact_.of[c].normal > 0 && (grains[contacts_.pair[c].a] || (c < walls && grains[contacts_.pair[c].b])))
        turning(c);
  });
}

Mat6 HeldGrains::stiffness(std::size_t i) const {
  const std::vector<Stiffness>& k = contact_.of;
  Blocks blocks;
  Mat3 &shift = blocks.shift, &mixed = blocks.mixed, &turn = blocks.turn;
  for (Index e = contacts_.index.first[i]; e < contacts_.index.first[i + 1]; ++e) {
    const std::size_t c = contacts_.index.entry[e] >> 1;
    if (k[c].normal == 0) continue;
    const double weight = c < contacts_.begin[first_wall] ? 2 : 1, kt = weight * k[c].tangential;
    const Vec3 outward = (contacts_.index.entry[e] & 1) ? Vec3(-contacts_.touch[c].normal) : contacts_.touch[c].normal;
    const Mat3 nn = outward * outward.transpose(), across = Mat3::Identity() - nn;
    if (is_sphere(g_, i)) {  // arm = radius x normal: in closed form
      const double radius = g_.motion[i].radius;
      shift += weight * k[c].normal * nn + kt * across;
      mixed -= kt * radius * cross_matrix(outward);
      turn += kt * radius * radius * across;
    } else {
      blocks.add(weight, k[c].normal * nn + k[c].tangential * across, arm(i, c, contacts_.index.entry[e] & 1));
    }
    if (!contact_.arm.empty())
      turn += weight * turning(c);
    else
      for (const SpringRow row : couple_springs) turn += weight * k[c].couple[row] * own_turn(row, outward);
  }
  if (!bonds_.of.empty()) blocks.add(bonds_.of[i]);
  return scaled_by_mass(g_, i, blocks);
}

Mat6 HeldGrains::resistance(std::size_t i) const {
  Blocks blocks;
  blocks.add(bonds_.resisting[i]);
  return scaled_by_mass(g_, i, blocks);
}

Mat6 HeldGrains::drag(std::size_t i) const {
  Blocks blocks;
  for (Index e = contacts_.index.first[i]; e < contacts_.index.first[i + 1]; ++e) {
    const std::size_t c = contacts_.index.entry[e] >> 1;
    const Vec3& n = contacts_.touch[c].normal;
    const double weight = c < contacts_.begin[first_wall] ? 2 : 1;
    if (contact_.viscous[c] > 0)
      blocks.add(weight * contact_.viscous[c], n * n.transpose(), arm(i, c, contacts_.index.entry[e] & 1));
  }
  return scaled_by_mass(g_, i, blocks);
}

std::vector<double> HeldGrains::cheap_drags() const {
  std::vector<double> drag(g_.size(), 0), most(contact_.arm.empty() ? g_.size() : 0);
  for (std::size_t i = 0; i < most.size(); ++i) {
    const double lever = g_.frame.empty() ? 0 : lever_bound(g_, i);
    most[i] = g_.motion[i].inverse_mass + lever * lever / g_.inertia[i].moments.minCoeff();
  }
  const auto yields = [&](Index i, std::size_t c, bool is_b) {
    return most.empty() ? mobility(g_, i, contact_.arm[c][is_b], contacts_.touch[c].normal) : most[i];
  };
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (!(contact_.viscous[c] > 0)) continue;
    const Pair& p = contacts_.pair[c];
    const bool walled = c >= contacts_.begin[first_wall];
    drag[p.a] += (walled ? 1 : 2) * contact_.viscous[c] * yields(p.a, c, false);
    if (!walled) drag[p.b] += 2 * contact_.viscous[c] * yields(p.b, c, true);
  }
  return drag;
}

double HeldGrains::alone(std::size_t c) const {
  const Pair& p = contacts_.pair[c];
  const Stiffness& k = contact_.of[c];
  const bool walled = c >= contacts_.begin[first_wall];
  const Vec3& n = contacts_.touch[c].normal;
  const double yields = std::max(mobility(g_, p.a, contact_.arm[c][0], n),
                                 walled ? 0 : mobility(g_, p.b, contact_.arm[c][1], n)),
               turned = std::max(turned_apart(g_, p.a), walled ? 0 : turned_apart(g_, p.b));
  return (walled ? 1 : 2) * std::max(k.normal * yields, k.couple[roll_spring] * turned);
}

double HeldGrains::impact(std::size_t i, double mass) const {
  const double speed = std::max({g_.motion[i].velocity.norm() + max_speed_, wall_speed_, 1e-6});
  const bool walled = !boundary_.walls.empty();
  const PairLaw& p = pairs_[g_.material[i] * materials_ + g_.material[i]];
  // Against a wall all of the grain's mass counts, against a grain half.
  Impact impact{(walled ? 1 : 0.5) * mass, g_.extent[i].equivalent_radius, speed, walled};
  if (g_.kind[i] == ShapeKind::hull) {
    const HullRow& hull = g_.hulls->row[g_.hull[i]];
    impact.surface = 3 * hull.volume / hull.depth, impact.depth = hull.depth;
  }
  return 2 * hardest_impact(law_, p, impact) * (mass == g_.mass[i] ? g_.motion[i].inverse_mass : 1 / mass);
}

std::vector<std::uint8_t> HeldGrains::touched() const {
  std::vector<std::uint8_t> touched(g_.size(), 0);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (contact_.of[c].normal == 0) continue;
    touched[contacts_.pair[c].a] = 1;
    if (c < contacts_.begin[first_wall]) touched[contacts_.pair[c].b] = 1;
  }
  for (std::size_t i = 0; i < bonds_.of.size(); ++i) touched[i] |= !bonds_.of[i].empty();
  for (std::size_t i = 0; i < g_.size(); ++i) touched[i] &= g_.kind[i] == ShapeKind::hull;
  return touched;
}

double with_dashpots(double k, double c) {
  if (c == 0) return k;
  const double omega = 0.5 * (c + std::sqrt(c * c + 4 * k));
  return omega * omega;
}

double largest_eigenvalue_bound(const Mat6& s) {
  const Mat6 s2 = s * s, s4 = s2 * s2;
  return std::sqrt(std::sqrt(std::sqrt(s4.squaredNorm()))) * (1 + 1e-12);
}

double largest_eigenvalue(const Mat6& s) {
  return Eigen::SelfAdjointEigenSolver<Mat6>(s, Eigen::EigenvaluesOnly).eigenvalues()[5];
}

}  // namespace grus::dem
