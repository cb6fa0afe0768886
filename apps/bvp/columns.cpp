// SPDX-License-Identifier: LGPL-3.0-or-later
// The table of columns of grus-bvp: docs/make_site.py makes their page from it.
#include "apps/bvp/columns.hpp"

namespace grus::app {

namespace macro_column {
double external_work(const MacroRow& r, std::size_t) { return r.energy->external; }
double damped(const MacroRow& r, std::size_t) { return r.explicit_statics->energy.damped; }
double scaled(const MacroRow& r, std::size_t) { return r.explicit_statics->energy.scaled; }
double energy_error(const MacroRow& r, std::size_t) { return r.energy_error; }
double correction(const MacroRow& r, std::size_t) { return r.correction; }
double worst_unbalanced(const MacroRow& r, std::size_t) { return r.sweep.worst_unbalanced; }
double worst_stress_change(const MacroRow& r, std::size_t) { return r.sweep.worst_stress_change; }
}  // namespace macro_column

namespace {

using K = std::size_t;
using Row = MacroRow;
using Told = MacroTold;

template <class T>
double number(T x) {
  return static_cast<double>(x);
}

/// In every problem.
bool always(const Told&) { return true; }
/// Of RVEs with bonds.
bool bonded(const Told& t) { return t.bonded; }
/// In explicit runs.
bool explicitly(const Told& t) { return t.scene.is_explicit(); }
/// In explicit-quasi-static runs.
bool steadily(const Told& t) { return t.scene.explicit_statics.has_value(); }
/// Of RVEs that are told an average over a length.
bool regularised(const Told& t) { return t.scene.regularisation.has_value(); }
/// Where there are elastic regions beside those with grains.
bool in_part(const Told& t) { return !t.scene.regions.empty() && t.scene.has_rve; }

std::vector<std::string> components(const Told&) { return {"xx", "yy", "zz", "yz", "xz", "xy"}; }

/// Strain and stress in turn, but for those along z, which stand before them.
std::vector<std::string> others(const Told&) {
  std::vector<std::string> names;
  for (const char* ij : {"xx", "yy", "yz", "xz", "xy"})
    for (const char* what : {"strain_{}", "stress_{}_Pa"}) names.push_back(fmt::format(fmt::runtime(what), ij));
  return names;
}

double other(const Row& r, K k) {
  const K component = k / 2 < 2 ? k / 2 : k / 2 + 1;
  return k % 2 == 0 ? r.strain[component] : r.stress[component];
}

std::vector<std::string> boundaries(const Told& t) {
  std::vector<std::string> names;
  for (const auto& b : t.problem.boundaries())
    for (const char k : {'x', 'y', 'z'}) names.push_back(fmt::format("{}_{}", b.name, k));
  return names;
}

const std::vector<ColumnEntry<Row, Told>> table{
    {"increment", "", "number of the increment; in explicit runs of the step", always,
     [](const Row& r, K) { return r.increment; }},
    {"time_s", "s", "time; in increments and explicit-quasi-static runs the load factor", always,
     [](const Row& r, K) { return r.time; }},
    {"newton_iterations", "", "of this increment", always, [](const Row& r, K) { return r.iterations; }},
    {"cutbacks", "", "of this increment", always, [](const Row& r, K) { return r.cutbacks; }},
    {"residual", "", "out of balance, over the forces; explicit-quasi-static: mean unbalanced force", always,
     [](const Row& r, K) { return r.residual; }},
    {"reaction_{}_N", "N", "sum of the forces on a boundary", always, [](const Row& r, K k) { return r.reaction[k]; },
     boundaries},
    {"mean_strain_zz", "", "mean over the volume", always, [](const Row& r, K) { return r.strain[2]; }},
    {"mean_stress_zz_Pa", "Pa", "mean over the volume, tension-positive", always,
     [](const Row& r, K) { return r.stress[2]; }},
    {"rves", "", "Gauss points with grains", always, [](const Row& r, K) { return r.rves; }},
    {"rves_advanced", "", "since the start", always, [](const Row& r, K) { return number(r.sweep.advanced); }},
    {"dem_steps", "", "since the start", always, [](const Row& r, K) { return number(r.sweep.dem_steps); }},
    {"breakages", "", "grains broken in all RVEs", always, [](const Row& r, K) { return r.breakages; }},
    {"wall_s", "s", "wall time since the start", always, [](const Row& r, K) { return r.wall; }},
    {"mean_{}", "", "the other means over the volume (Pa), tension-positive; shear strains are twice the tensor's",
     always, other, others},
    {"correction", "", "last correction of Newton's iteration", always, macro_column::correction},
    {"rve_noise", "", "of the RVEs' answers, as the meter finds it", always, [](const Row& r, K) { return r.noise; }},
    {"volume_m3", "m^3", "present volume of the mesh", always, [](const Row& r, K) { return r.volume; }},
    {"worst_unbalanced_force", "", "of all RVEs", always, macro_column::worst_unbalanced},
    {"worst_stress_change", "", "of all RVEs over a window", always, macro_column::worst_stress_change},
    {"worst_rve_energy_error", "", "of all RVEs", always, [](const Row& r, K) { return r.worst_energy_error; }},
    {"mass_lost_fraction", "", "share of the grains' mass taken away as fines", always,
     [](const Row& r, K) { return r.mass_lost; }},
    {"macro_work_J", "J", "of the stresses at all points", always, [](const Row& r, K) { return r.macro_work; }},
    {"rve_work_J", "J", "of the RVEs, by the volumes that they stand for", always,
     [](const Row& r, K) { return r.work; }},
    {"rves_distinct", "", "RVEs that points have between them", always,
     [](const Row& r, K) { return number(r.sweep.distinct); }},
    {"rves_deferred", "", "not asked, since the start", always,
     [](const Row& r, K) { return number(r.sweep.deferred); }},
    {"energy_unexplained_J", "J", "of all RVEs, by the volumes that they stand for", always,
     [](const Row& r, K) { return r.unexplained; }},
    {"p_Pa", "Pa", "mean pressure of the points with grains, compression-positive", always,
     [](const Row& r, K) { return r.p; }},
    {"q_Pa", "Pa", "sqrt(3/2) of the deviator's norm", always, [](const Row& r, K) { return r.q; }},
    {"strain_volumetric", "", "1 - V / V0 of the points with grains, compression-positive", always,
     [](const Row& r, K) { return r.volumetric; }},
    {"unbalanced_macro_force", "", "the residual", always, [](const Row& r, K) { return r.residual; }},
    {"kinetic_over_internal", "", "kinetic over internal energy", always,
     [](const Row& r, K) { return r.kinetic_over_internal; }},
    {"energy_error", "", "of the macro balance", always, macro_column::energy_error},
    {"bonds_broken", "", "of all points", bonded, [](const Row& r, K) { return r.bonds_broken; }},
    {"moved_{}_m", "m", "mean displacement of a boundary's nodes", always, [](const Row& r, K k) { return r.moved[k]; },
     boundaries},
    {"macro_kinetic_J", "J", "kinetic energy of the mesh", explicitly,
     [](const Row& r, K) { return r.energy->kinetic; }},
    {"macro_internal_J", "J", "what the materials have taken", always,
     [](const Row& r, K) { return r.energy->internal; }},
    {"macro_external_J", "J", "work of loads and reactions", always, macro_column::external_work},
    {"macro_viscous_J", "J", "taken by bulk viscosity", explicitly, [](const Row& r, K) { return r.energy->viscous; }},
    {"macro_energy_error", "", "the same as energy_error", explicitly,
     [](const Row& r, K) { return r.energy->error(); }},
    {"macro_damped_J", "J", "taken by macro damping", steadily, macro_column::damped},
    {"macro_scaled_J", "J", "put in by scaled masses", steadily, macro_column::scaled},
    {"largest_unbalanced_macro_force", "", "the worst node's", steadily,
     [](const Row& r, K) { return r.explicit_statics->largest_unbalanced; }},
    {"cells_haste_J", "J", "what the rate costs the RVEs", steadily, [](const Row& r, K) { return r.haste; }},
    {"inertial_number", "", "mean of the RVEs", steadily,
     [](const Row& r, K) { return r.explicit_statics->inertial_number; }},
    {"load_rate", "1/s", "of the load factor", steadily, [](const Row& r, K) { return r.explicit_statics->rate; }},
    {"rate_governor", "", "what bounds it: 0 none, 1 balance, 2 kinetic, 3 inertial number", steadily,
     [](const Row& r, K) { return number(r.explicit_statics->governor); }},
    {"rves_given_up", "", "RVEs that are elastic from then on", steadily,
     [](const Row& r, K) { return number(r.sweep.given_up); }},
    {"regularisation_J", "J", "of macro_internal_J: what the stresses have done beyond what RVEs were told",
     regularised, [](const Row& r, K) { return r.regularised; }},
    {"grains_strain_{}", "", "mean over the points with grains, of shear twice the tensor's", in_part,
     [](const Row& r, K k) { return r.grains_strain[k]; }, components},
    {"grains_stress_{}_Pa", "Pa", "mean over the points with grains", in_part,
     [](const Row& r, K k) { return r.grains_stress[k]; }, components},
};

}  // namespace

std::vector<MacroColumn> macro_columns(const MacroTold& told) { return columns_of(table, told); }

}  // namespace grus::app
