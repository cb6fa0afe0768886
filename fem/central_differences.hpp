// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: what explicit solvers share. A step of central differences on lumped masses, and its energies.
#pragma once

#include "fem/dynamics.hpp"
#include "fem/material_energy.hpp"
#include "fem/problem_impl.hpp"

namespace grus::fem {

/// True only if all eigenvalues of a symmetric matrix lie below `limit`, by more than round-off: limit x 1 - m has a
/// Cholesky factor, which takes a tenth of the time that the eigenvalues take.
bool all_below(const Problem::Impl::Matrix& m, double limit);

/// Lumped mass of an element's nodes: diagonal of the consistent mass, scaled to the element's mass (Hinton, Rock,
/// Zienkiewicz). `density(point)`, kg/m^3.
template <class Density>
Eigen::VectorXd cell_mass(const Problem::Impl& p, std::int32_t c, Density&& density) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(p.nodes);
  double mass = 0;
  for (int q = 0; q < p.nq; ++q) {
    const auto& l = p.local(c, q);
    const double dm = density(p.point(c, q)) * l.dv;
    mass += dm;
    diagonal.array() += dm * l.value.array().square();
  }
  return diagonal * (mass / diagonal.sum());
}

/// One element's stiffness against its lumped mass (1/s^2), its symmetric part.
template <class Density>
Problem::Impl::Matrix stiffness_over_mass(const Problem::Impl& p, std::int32_t c, Density&& density) {
  Problem::Impl::Matrix k;
  p.cell_tangent(c, k);
  const Eigen::VectorXd m = cell_mass(p, c, density);
  const int width = p.components;
  for (int a = 0; a < p.nodes; ++a)
    for (int b = 0; b < p.nodes; ++b) {
      const double both = m[a] * m[b], mean = both > 0 ? std::sqrt(both) : INFINITY;  // nodes without a say: no part
      for (int i = 0; i < width; ++i)
        for (int j = 0; j < width; ++j) k(width * a + i, width * b + j) /= mean;
    }
  return 0.5 * (k + k.transpose());
}

/// Its largest eigenvalue; and the same if that is above `limit`, else some number that is not.
inline double largest_eigenvalue(const Problem::Impl::Matrix& m) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}
inline double eigenvalue_above(double limit, const Problem::Impl::Matrix& m) {
  return all_below(m, limit) ? 0 : largest_eigenvalue(m);
}

/// One step of central differences: how long, between which times of the boundary histories, and what there was before.
struct Stride {
  double dt = 0, last_dt = 0;  // s; 0 before the first
  double time = 0, next = 0;   // of boundary histories, at its ends
  double damping = 0;  // local, non-viscous: of a free node's unbalanced force, against its departure from the drift
  bool first = false;  // driven nodes start with the speed they are given
  double drift = 0;    // of the running mean of the velocity: how much of it is the load's motion now
  double memory = 0;   // steps of that mean; 0: none is kept
};

struct CentralDifferences {
  Problem::Impl& p;
  Material& material;
  std::vector<double> mass, volumes;  // of owned and ghost nodes (kg); of points (m^3)
  std::vector<std::int8_t> fixed;     // components
  std::vector<double> moved;          // components, by the last step (m)
  std::vector<double>& velocity;      // owned and ghost components (m/s), half a step behind
  /// Forces from outside and inside a step ago, and inside now, bulk viscosity included (N).
  std::vector<double>&last_load, &last_internal, &now_internal;
  std::vector<double>* drift = nullptr;  // running mean of the velocity, for those who keep one
  double viscous = 0;                    // taken by bulk viscosity in the last step, on all ranks (J)
  std::string reason;
  bool external_ready = false;  // external forces are those of the positions and the time that respond was told
  double most = 0;              // a number of this rank; after respond, with exact sums, the largest of all ranks
  Wishes wishes;

  CentralDifferences(Problem::Impl& p, Material& material);

  /// Sums `of(element)`, masses of an element's nodes, into `mass`.
  void set_mass(const std::function<Eigen::VectorXd(std::int32_t)>& of);
  /// Stress at the present displacement, committed, and the internal forces; before those are assembled `also()` may
  /// add to the stress. With exact sums also the external forces at time `next`, all in one reduction.
  bool respond(double dt, bool want_tangent, double next, const std::function<void()>& also = {});
  /// Forces at the present instant kick the velocities, which move the nodes; energies of the instant go into `total`.
  /// Call assemble_external before, respond after.
  void step(const Stride& stride, MacroEnergy& total);
  /// With exact sums: the same, and further sums in the same reduction.
  std::array<double, 6> step(const Stride& stride, MacroEnergy& total, const std::array<ExactSum, 6>& also);
  /// The step that has been answered becomes the committed state, its internal forces included.
  void keep();
  /// Restores what is not kept in the problem's snapshot.
  void go_on(double last_dt);

private:
  bool respond_together(double dt, bool want_tangent, double next, const std::function<void()>& also);
  bool new_tangent = false;  // since the last commit
  void book(std::array<double, 6> all, MacroEnergy& total);
  template <class Sum>
  void go(const Stride& stride, std::array<Sum, 6>& sums);
  std::vector<double> energies;  // of the points (J); exact sums only
};

}  // namespace grus::fem
