// SPDX-License-Identifier: LGPL-3.0-or-later
// Probes of grus-bvp: what one Gauss point and its RVE go through.
#pragma once

#include "apps/bvp/points.hpp"
#include "apps/bvp/probe_columns.hpp"

namespace grus::app {

class Probes {
public:
  /// Each probe sits at the Gauss point nearest to its place in the reference mesh, of equals the lowest key; or at all
  /// points of a place.
  Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem, const BvpPoints& points,
         const std::vector<dem::State>& states, const coupling::RveMaterial* rves);

  std::vector<std::string> columns() const;
  std::vector<double> row() const;
  /// Grains of the probes that ask for frames.
  void frame(std::size_t number, double time);
  /// Stress along an axis (Pa, tension-positive) at the probe of this name.
  double stress(const std::string& name, int component) const;
  std::vector<std::vector<std::pair<std::string, double>>> series() const;
  void restore(const std::vector<std::vector<std::pair<std::string, double>>>& series);

private:
  ProbeRow of_place(const std::vector<std::uint8_t>& some) const;
  ProbeRow of_point(std::size_t point, bool grading) const;
  struct Found {
    const Probe* probe;
    std::size_t point;
    std::vector<std::uint8_t> some;  // points of a place; empty: the one above
    std::vector<ProbeColumn> columns;
    std::vector<std::pair<std::string, double>> series;
  };

  std::string directory_;
  const BvpScene& scene_;
  const fem::Problem& problem_;
  const BvpPoints& points_;
  const std::vector<dem::State>& states_;  // prepared, of the starts
  const coupling::RveMaterial* rves_;      // null: no grains anywhere
  std::vector<Found> probes_;
};

}  // namespace grus::app
