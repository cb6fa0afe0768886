// SPDX-License-Identifier: LGPL-3.0-or-later
// The table of columns of a probe: docs/make_site.py makes their page from it.
#include "apps/bvp/probe_columns.hpp"

namespace grus::app {
namespace {

using K = std::size_t;
using Row = ProbeRow;
using Told = ProbeTold;

/// Of every probe.
bool always(const Told&) { return true; }
/// Of a place, and of a point with grains.
bool grainy(const Told& t) { return t.place || t.cell; }
/// Of a point with grains.
bool alone(const Told& t) { return !t.place && t.cell; }
/// Of a point with grains, where `grading` asks for it.
bool graded(const Told& t) { return alone(t) && t.grading; }

std::vector<std::string> components(const Told&) { return {"xx", "yy", "zz", "yz", "xz", "xy"}; }
std::vector<std::string> shares(const Told&) { return {"10", "50", "90"}; }

const std::vector<ColumnEntry<Row, Told>> table{
    {"strain_{}", "", "tensor component, shear half of mean_strain's; of a place its mean over the present volume",
     always, [](const Row& r, K k) { return r.strain[k]; }, components},
    {"stress_{}_Pa", "Pa", "tension-positive, of a place its mean over the present volume", always,
     [](const Row& r, K k) { return r.stress[k]; }, components},
    {"void_ratio", "", "of the RVE; of a place the mean of its RVEs", grainy,
     [](const Row& r, K) { return r.void_ratio; }},
    {"coordination", "", "mean contacts of a grain of the RVE", alone, [](const Row& r, K) { return r.coordination; }},
    {"grains", "", "of the RVE; of a place the sum of its RVEs", grainy, [](const Row& r, K) { return r.grains; }},
    {"breakages", "", "of the RVE; of a place the sum of its RVEs", grainy,
     [](const Row& r, K) { return r.breakages; }},
    {"d{}_m", "m", "diameter that 10, 50, 90 % of the mass pass", graded,
     [](const Row& r, K k) { return r.diameter[k]; }, shares},
    {"breakage_einav", "", "Einav's breakage against the start of the RVE", graded,
     [](const Row& r, K) { return r.einav; }},
    {"fines_fraction", "", "share of the mass that is fines", graded, [](const Row& r, K) { return r.fines; }},
};

}  // namespace

std::vector<ProbeColumn> probe_columns(const std::string& name, const ProbeTold& told) {
  std::vector<ProbeColumn> columns = columns_of(table, told);
  for (ProbeColumn& c : columns) c.name = fmt::format("probe_{}_{}", name, c.name);
  return columns;
}

}  // namespace grus::app
