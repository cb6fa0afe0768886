// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs: one for each Gauss point of this rank, advanced by threads. Points that start from the
// same state and have had the same increments share one RVE until an increment differs.
#pragma once

#include <memory>
#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/rve/rve.hpp"
#include "fem/material.hpp"

#include <mpi.h>

namespace grus::coupling {

enum class TangentKind {
  contact_stiffness,  // elastic contacts, sliding ones without k_t
  elastic,            // that of the first response, kept
  perturbation,       // from scratch copies
  quasi_newton        // Broyden's update from iteration to iteration and from increment to increment
};

struct RveOptions {
  TangentKind tangent = TangentKind::contact_stiffness;
  double perturbation = 1e-4;  // strain of the scratch copies
  bool central = false;
  bool share = true;           // exact sharing; off gives the same bits
};

/// Figures of the last response and of all so far, this rank's points only.
struct SweepReport {
  std::uint64_t dem_steps = 0, asked = 0, advanced = 0;  // since the start: DEM steps, points asked, RVEs advanced
  std::size_t distinct = 0;                   // committed RVEs now
  double seconds = 0;                         // wall time in RVE sweeps
  double worst_unbalanced = 0, worst_stress_change = 0;  // of the committed responses
};

class RveMaterial {
public:
  /// Owned point i starts from the prepared state `states[start[i]]`.
  RveMaterial(std::shared_ptr<const dem::Model> model, const dem::QuasiStatic& quasi_static, std::vector<dem::State> states,
              std::vector<std::size_t> start, int threads, const RveOptions& options = {});

  /// Valid as long as this object. The material's noise is collective over `comm`.
  fem::Material material(MPI_Comm comm);

  /// Relative error of the stress of the last response: what the RVEs' own equilibrium leaves, and, measured, by how
  /// much points whose breakage differs between two iterations miss the stress that their tangent predicts. Breakage
  /// makes the response a staircase: no residual goes below its steps. At most max_noise. Sums over `comm`.
  double noise(MPI_Comm comm) const;
  static constexpr double max_noise = 0.03;

  std::size_t points() const { return slot_.size(); }
  const dem::State& committed(std::size_t point) const { return pool_[slot_[point]]->committed(); }
  const SweepReport& report() const { return report_; }
  std::size_t breakages() const;  // of the committed states, every point counted

private:
  /// One RVE to advance: the committed one of a slot, or a copy of it for points that part from it.
  struct Job {
    std::size_t slot;
    dem::Increment increment;
    std::unique_ptr<dem::Rve> copy;  // null: the slot's own
    dem::Response response;
  };

  bool respond(const fem::Points& points);
  void choose_tangents();
  void commit();

  std::shared_ptr<const dem::Model> model_;
  dem::QuasiStatic quasi_static_;
  RveOptions options_;
  std::vector<std::unique_ptr<dem::Rve>> pool_;
  std::vector<std::size_t> slot_, job_;               // of each point: its committed RVE, its job in the last response
  std::vector<Job> jobs_;
  std::vector<dem::Response> responses_, previous_;   // of this trial and of the one before it in the same increment
  std::vector<dem::Mat3> deformation_, previous_deformation_;
  std::vector<dem::Mat6> kept_tangent_;               // elastic, quasi-Newton
  bool has_previous_ = false;
  dem::Team team_;
  SweepReport report_;
  std::string reason_;
};

}  // namespace grus::coupling
