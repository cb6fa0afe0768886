// SPDX-License-Identifier: LGPL-3.0-or-later
// Results of grus-bvp: history.csv, macro frames, summary.json. Every member is called on all ranks; one writes.
#pragma once

#include "apps/probes.hpp"
#include "apps/run.hpp"
#include "apps/scene/bvp_scene.hpp"
#include "coupling/rve_material.hpp"

namespace grus::app {

class BvpOutput {
public:
  BvpOutput(std::string directory, const BvpScene& scene, fem::Problem& problem, const coupling::RveMaterial& rves, bool writes);

  /// One row, and a frame if one is due.
  void add(const fem::IncrementReport& report, double wall);
  void finish(int status, const std::string& ending, const fem::StaticsResult& result, const Options& options, int ranks, double preparation, double wall);

  /// Where things stand, for the progress line (no communication).
  std::string line(std::uint64_t sweeps) const;
  std::string closing(int status, const fem::StaticsResult& result, double wall) const;

private:
  void frame(double load_factor);

  std::string directory_;
  const BvpScene& scene_;
  fem::Problem& problem_;
  const coupling::RveMaterial& rves_;
  bool writes_;
  Probes probes_;
  std::optional<History> history_;
  std::vector<std::pair<std::string, double>> series_;
  double strain_ = 0, stress_ = 0, breakages_ = 0, steps_ = 0;
  int iterations_ = 0, cutbacks_ = 0;
};

}  // namespace grus::app
