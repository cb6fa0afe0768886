// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs: one for each Gauss point of this rank, advanced by threads.
#pragma once

#include <memory>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/rve/rve.hpp"
#include "fem/material.hpp"

#include <mpi.h>

namespace grus::coupling {

/// Figures of the last response and of all so far, this rank's points only.
struct SweepReport {
  std::uint64_t dem_steps = 0, advanced = 0;  // since the start: DEM steps, RVE advances
  double seconds = 0;                         // wall time in RVE sweeps
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the committed responses
};

class RveMaterial {
public:
  /// `states[i]` is the prepared state of owned point i.
  RveMaterial(std::shared_ptr<const dem::Model> model, const dem::QuasiStatic& options, std::vector<dem::State> states, int threads);

  /// Valid as long as this object. The material's noise is collective over `comm`.
  fem::Material material(MPI_Comm comm);

  /// Relative error of the stress of the last response: what the RVEs' own equilibrium leaves, and, measured, by how
  /// much points whose breakage differs between two iterations miss the stress that their tangent predicts. Breakage
  /// makes the response a staircase: no residual goes below its steps. At most max_noise. Sums over `comm`.
  double noise(MPI_Comm comm) const;
  static constexpr double max_noise = 0.03;

  const std::vector<dem::Rve>& rves() const { return rves_; }
  const SweepReport& report() const { return report_; }
  std::size_t breakages() const;  // of the committed states

private:
  bool respond(const fem::Points& points);
  void commit();

  dem::QuasiStatic options_;
  std::vector<dem::Rve> rves_;
  std::vector<dem::Response> responses_, previous_;   // of this trial and of the one before it in the same increment
  std::vector<double> deformation_, previous_deformation_;
  bool has_previous_ = false;
  dem::Team team_;
  SweepReport report_;
  std::string reason_;
};

}  // namespace grus::coupling
