// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/hopkinson.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "dem/io/whole_file.hpp"

namespace grus::app {

double GaugeSignal::at(double t) const {
  if (time.empty() || t <= time.front()) return 0;
  const auto next = std::upper_bound(time.begin(), time.end(), t);
  if (next == time.end()) return strain.back();
  const auto i = static_cast<std::size_t>(next - time.begin());
  const double part = (t - time[i - 1]) / (time[i] - time[i - 1]);
  return strain[i - 1] + part * (strain[i] - strain[i - 1]);
}

std::vector<HopkinsonRow> analyse_hopkinson(const Hopkinson& bar, const GaugeSignal& incident,
                                            const GaugeSignal& transmitted) {
  const double wave = std::sqrt(bar.bar_modulus / bar.bar_density), there = bar.incident_distance / wave,
               beyond = bar.transmitted_distance / wave;
  double peak = 0;
  for (const double e : incident.strain) peak = std::max(peak, std::abs(e));
  double arrival = 0;  // of the incident wave at its gauge, at a hundredth of the peak
  for (std::size_t i = 0; i < incident.time.size(); ++i)
    if (std::abs(incident.strain[i]) > 0.01 * peak) {
      arrival = incident.time[i];
      break;
    }
  const double parting = arrival + 2 * there;  // from here on the gauge sees the reflected wave
  std::vector<HopkinsonRow> rows;
  double last = 0;
  for (const double t : incident.time) {
    if (t < arrival + there || t + std::max(there, beyond) > incident.time.back()) continue;
    HopkinsonRow r{};
    r.time = t;
    r.incident = t - there < parting ? incident.at(t - there) : 0;
    r.reflected = t + there >= parting ? incident.at(t + there) : 0;
    r.transmitted = transmitted.at(t + beyond);
    const double force = bar.bar_modulus * bar.bar_area / bar.specimen_area;
    r.rate_1 = -2 * wave * r.reflected / bar.specimen_length;
    r.rate_3 = wave * (r.incident - r.reflected - r.transmitted) / bar.specimen_length;
    r.stress_1 = force * r.transmitted;
    r.stress_2 = force * (r.incident + r.reflected);
    r.stress_3 = 0.5 * (r.stress_1 + r.stress_2);
    if (!rows.empty()) {
      r.strain_1 = rows.back().strain_1 + 0.5 * (rows.back().rate_1 + r.rate_1) * (t - last);
      r.strain_3 = rows.back().strain_3 + 0.5 * (rows.back().rate_3 + r.rate_3) * (t - last);
    }
    last = t;
    rows.push_back(r);
  }
  return rows;
}

void write_hopkinson(const std::string& path, const Hopkinson& bar, const std::string& history) {
  std::istringstream lines(history);
  std::string line, cell;
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::getline(lines, line);
  for (std::istringstream in(line); std::getline(in, cell, ',');) names.push_back(cell);
  columns.resize(names.size());
  while (std::getline(lines, line)) {
    std::size_t k = 0;
    for (std::istringstream in(line); std::getline(in, cell, ',') && k < names.size();)
      columns[k++].push_back(std::strtod(cell.c_str(), nullptr));
  }
  auto has = [&](const std::string& name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  auto column = [&](const std::string& name) -> const std::vector<double>& {
    if (!has(name)) throw std::runtime_error("history.csv has no column " + name);
    return columns[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())];
  };
  const std::string axis = fmt::format("{0}{0}", "xyz"[bar.axis]);
  auto gauge = [&](const std::string& name) {
    GaugeSignal g{column("time_s"), column(fmt::format("probe_{}_strain_{}", name, axis))};
    for (double& e : g.strain) e = -e;
    return g;
  };
  // The specimen's own averages, where grains are the specimen.
  const bool own = has("grains_strain_" + axis);
  const GaugeSignal own_strain = own ? GaugeSignal{column("time_s"), column("grains_strain_" + axis)} : GaugeSignal{};
  const GaugeSignal own_stress =
      own ? GaugeSignal{column("time_s"), column("grains_stress_" + axis + "_Pa")} : GaugeSignal{};
  std::string text =
      "time_s,incident_strain,reflected_strain,transmitted_strain,rate_1wave,strain_1wave,stress_1wave_Pa,stress_2wave_"
      "Pa,rate_3wave,strain_3wave,stress_3wave_Pa";
  text += own ? ",specimen_strain,specimen_stress_Pa\n" : "\n";
  for (const HopkinsonRow& r : analyse_hopkinson(bar, gauge(bar.incident), gauge(bar.transmitted))) {
    text += fmt::format("{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}",
                        r.time, r.incident, r.reflected, r.transmitted, r.rate_1, r.strain_1, r.stress_1, r.stress_2,
                        r.rate_3, r.strain_3, r.stress_3);
    text += own ? fmt::format(",{:.10g},{:.10g}\n", -own_strain.at(r.time), -own_stress.at(r.time)) : "\n";
  }
  dem::write_whole(path, text);
}

}  // namespace grus::app
