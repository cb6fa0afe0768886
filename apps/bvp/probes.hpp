// SPDX-License-Identifier: LGPL-3.0-or-later
// Probes of grus-bvp: what one Gauss point and its RVE go through.
#pragma once

#include "apps/bvp/across_ranks.hpp"
#include "apps/bvp/points.hpp"
#include "apps/bvp/probe_columns.hpp"

namespace grus::app {

class Probes {
public:
  /// Each probe sits at the Gauss point nearest to its place in the reference mesh, of equals the lowest key; or at all
  /// points of a place.
  Probes(const std::string& directory, const BvpScene& scene, const fem::Problem& problem, const BvpPoints& points,
         const std::vector<dem::State>& states, const coupling::RveMaterial* rves, AcrossRanks& across);

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
  /// The point nearest to a place, of equals the lowest key: its rank, and where that rank has it.
  std::pair<int, std::size_t> nearest(const fem::Point& place) const;
  struct Found {
    const Probe* probe;
    int rank;                        // that has it
    std::size_t point;               // there
    std::vector<std::uint8_t> some;  // points of a place
    std::vector<ProbeColumn> columns;
    std::vector<std::pair<std::string, double>> series;
  };

  std::string directory_;
  const BvpScene& scene_;
  const fem::Problem& problem_;
  const BvpPoints& points_;
  const std::vector<dem::State>& states_;  // prepared, of the starts
  const coupling::RveMaterial* rves_;      // null: no grains anywhere
  AcrossRanks& across_;
  std::vector<Found> probes_;
};

}  // namespace grus::app
