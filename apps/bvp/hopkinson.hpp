// SPDX-License-Identifier: LGPL-3.0-or-later
// A split Hopkinson bar read as the laboratory reads it: from strain gauges on the bars, by one-dimensional waves.
#pragma once

#include "apps/bvp/scene/bvp_scene.hpp"

namespace grus::app {

/// A gauge's record: time (s) and axial strain, compression-positive.
struct GaugeSignal {
  std::vector<double> time, strain;
  double at(double t) const;  // linear between samples; 0 before the first, the last one after it
};

/// Specimen histories from the bars, compression-positive.
struct HopkinsonRow {
  double time;                              // s, at the specimen's faces
  double incident, reflected, transmitted;  // strains moved to the faces
  double rate_1, strain_1, stress_1, stress_2, rate_3, strain_3,
      stress_3;  // one-, two- and three-wave analysis (1/s, -, Pa)
};

/// Incident and reflected waves are told apart by the arrival of the reflected one: the pulse must be shorter than
/// twice the way from gauge to specimen.
std::vector<HopkinsonRow> analyse_hopkinson(const Hopkinson& bar, const GaugeSignal& incident,
                                            const GaugeSignal& transmitted);

/// hopkinson.csv from the text of history.csv: the analysis beside the specimen's own averages.
void write_hopkinson(const std::string& path, const Hopkinson& bar, const std::string& history);

}  // namespace grus::app
