// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/bond/supports.hpp"

#include <algorithm>

#include "dem/bond/face_bond.hpp"

namespace grus::dem {
namespace {

const Quat not_turned = Quat::Identity();

/// Half the sum of the forces before and after over the way between: exact for constant ones, and for a ramp to its
/// square.
void push(Grains& g, DeadLoad& load, Ledger& ledger, double time) {
  const Vec3 arm = g.orientation[load.grain] * load.at, point = g.motion[load.grain].position + arm;
  const Vec3 force = load.ramp > 0 ? Vec3(std::min(1.0, time / load.ramp) * load.force) : load.force;
  ledger.work += 0.5 * (load.felt + force).dot(point - load.point);
  load.felt = force, load.point = point;
  g.force[load.grain] += force, g.torque[load.grain] += arm.cross(force);
}

}  // namespace

BondFrame frame_at_wall(const Grains& g, const Boundary& boundary, const BondEnds& e) {
  return {g.orientation[e.a], not_turned, g.motion[e.a].position, boundary.walls[e.b].point};
}

void clear_supported(Grains& g, const Bonds& bonds) {
  for (const FaceBond& row : bonds.wall) g.force[row.ends.a].setZero(), g.torque[row.ends.a].setZero();
  for (const DeadLoad& load : bonds.load) g.force[load.grain].setZero(), g.torque[load.grain].setZero();
}

double support_forces(Grains& g, const Boundary& boundary, Bonds& bonds, Ledger& ledger, double time) {
  for (FaceBond& row : bonds.wall) {
    const Pull p = pull_of_plate(row, frame_at_wall(g, boundary, row.ends));
    g.force[row.ends.a] -= p.force, g.torque[row.ends.a] -= p.arm_a.cross(p.force) + p.couple;
  }
  for (DeadLoad& load : bonds.load) push(g, load, ledger, time);
  return support_power(boundary, bonds);
}

double support_power(const Boundary& boundary, const Bonds& bonds) {
  double power = 0;
  for (const FaceBond& row : bonds.wall) power -= row.force.dot(boundary.walls[row.ends.b].velocity);
  return power;
}

Vec3 support_force(const Bonds& bonds, std::size_t wall) {
  Vec3 force = Vec3::Zero();
  for (const FaceBond& row : bonds.wall)
    if (row.ends.b == wall) force += row.force;
  return force;
}

}  // namespace grus::dem
