// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/cone_steps.hpp"

namespace grus::dem {

void fill_bodies(const Grains& g, Team& team, std::vector<ConeBody>& body) {
  body.resize(g.size());
  team.blocks(g.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Mat3 axes = (g.orientation[i] * g.inertia[i].axes).toRotationMatrix();
      body[i] = {g.motion[i].inverse_mass, axes * g.inertia[i].moments.cwiseInverse().asDiagonal() * axes.transpose()};
    }
  });
}

MotionSettings solved_motion(const Model& model, const State& state) {
  MotionSettings of = model.motion;
  of.gravity.setZero();
  of.affine = state.boundary.cell.gradient();
  return of;
}

void take_changes(const Grains& g, const std::vector<ConeSolver::Change>& change, const Vec3& fall, double dt,
                  std::vector<Vec3>& force, std::vector<Vec3>& torque, double& lost, double& work) {
  force.resize(g.size()), torque.resize(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 kick = change[i].velocity + fall, turn = inertia_tensor(g, i) * change[i].spin;
    lost += 0.5 * (g.mass[i] * kick.squaredNorm() + turn.dot(change[i].spin));
    work += g.mass[i] * fall.dot(g.motion[i].velocity + kick);
    force[i] = 2 / dt * g.mass[i] * kick, torque[i] = 2 / dt * turn;
  }
}

}  // namespace grus::dem
