// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs: one for each Gauss point of this rank, advanced by threads.
#pragma once

#include <memory>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/rve/rve.hpp"
#include "fem/material.hpp"

namespace grus::coupling {

/// Figures of the last response and of all so far, this rank's points only.
struct SweepReport {
  std::uint64_t dem_steps = 0, advanced = 0;  // since the start: DEM steps, RVE advances
  double seconds = 0;                         // wall time in RVE sweeps
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the committed responses
  std::size_t deepest_breakage = 0;           // breakages of the point that broke most
};

class RveMaterial {
public:
  /// `states[i]` is the prepared state of owned point i.
  RveMaterial(std::shared_ptr<const dem::Model> model, const dem::QuasiStatic& options, std::vector<dem::State> states, int threads);

  /// Valid as long as this object.
  fem::Material material();

  const std::vector<dem::Rve>& rves() const { return rves_; }
  const SweepReport& report() const { return report_; }
  std::size_t breakages() const;  // of the committed states

private:
  bool respond(const fem::Points& points);
  void commit();

  dem::QuasiStatic options_;
  std::vector<dem::Rve> rves_;
  std::vector<dem::Response> responses_;
  dem::Team team_;
  SweepReport report_;
  std::string reason_;
};

}  // namespace grus::coupling
