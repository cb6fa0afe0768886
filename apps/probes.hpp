// SPDX-License-Identifier: LGPL-3.0-or-later
// Probes of grus-bvp: what one Gauss point and its RVE go through. Every member is called on all ranks.
#pragma once

#include "apps/scene/bvp_scene.hpp"
#include "coupling/rve_material.hpp"

namespace grus::app {

class Probes {
public:
  /// Each probe sits at the Gauss point nearest to its place in the reference mesh; of equals the lowest key.
  Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem, const coupling::RveMaterial& rves);

  std::vector<std::string> columns() const;
  std::vector<double> row() const;
  /// Grains of the probes that ask for frames.
  void frame(std::size_t number, double load_factor);

private:
  struct Found {
    const Probe* probe;
    std::ptrdiff_t point;  // owned point, or -1: another rank's
    std::vector<std::pair<std::string, double>> series;
  };

  std::string directory_;
  const BvpScene& scene_;
  const fem::Problem& problem_;
  const coupling::RveMaterial& rves_;
  std::vector<Found> probes_;
};

}  // namespace grus::app
