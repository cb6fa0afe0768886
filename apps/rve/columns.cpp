// SPDX-License-Identifier: LGPL-3.0-or-later
// The table of columns of grus-rve: docs/make_site.py makes their page from it.
#include "apps/rve/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "dem/bond/bonds.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/servo.hpp"
#include "dem/rve/step.hpp"
#include "dem/sample/gauge.hpp"

namespace grus::app {
namespace {

using K = std::size_t;

template <class T>
double number(T x) {
  return static_cast<double>(x);
}

/// In every test.
bool always(const Told&) { return true; }
/// With a contact law with attraction.
bool attracts(const Told& k) { return dem::attracts(k.scene.model.law); }
/// With a shape transition, or fragments that swell.
bool reshapes(const Told& k) { return k.scene.model.reshapes(); }
/// With scaled inertia.
bool scales(const Told& k) { return k.scene.model.numerics.scales_inertia(); }
/// With inertia by step.
bool by_step(const Told& k) { return k.scene.model.numerics.inertia_step > 0; }
/// With `output.critical_grain`.
bool critical(const Told& k) { return k.scene.output.critical_grain; }
/// With fourteen balls.
bool balls(const Told& k) { return k.scene.model.has_balls(); }
/// With grains that are tested for cracks.
bool tests_cracks(const Told& k) { return k.scene.model.tests_cracks(); }
/// With `output.grading`.
bool graded(const Told& k) { return k.scene.output.grading; }
/// With `output.grading`, of hulls.
bool rounded(const Told& k) { return k.scene.output.grading && k.scene.recipe.of_hulls(); }
/// With `output.split_statistics`.
bool splits(const Told& k) { return k.scene.model.split_statistics; }
/// Bonded Voronoi cells.
bool bonded(const Told& k) { return k.sample.bonded(); }
/// Where bonds have `damping`.
bool dashpots(const Told& k) { return !k.sample.state.bonds.dashpot.empty(); }
/// Voronoi cells between platens, under rollers, or with a clamp that moves.
bool gauged(const Told& k) { return k.scene.test.gauge.has_value(); }
/// Where dead loads alone move the Voronoi cells.
bool dead_loads(const Told& k) { return dem::dead_loaded(k.scene.test, k.sample.state); }
/// With `[[stage]]`.
bool staged(const Told& k) { return !k.scene.test.stages.empty(); }
/// With a stage of cycles.
bool cycled(const Told& k) {
  const auto& all = k.scene.test.stages;
  return std::any_of(all.begin(), all.end(), [](const auto& s) { return s.kind == dem::StageKind::cyclic; });
}
/// In a true triaxial test.
bool three_stresses(const Told& k) { return k.scene.test.kind == dem::TestKind::true_triaxial; }
/// At a constant mean stress, in a true triaxial test, or with `[[stage]]`.
bool invariants(const Told& k) { return dem::tells_q(k.scene.test) || staged(k); }
/// With `[[wall]] control = "stress"`.
bool pressed(const Told& k) { return !k.scene.test.loading.walls.empty(); }
/// Where a stress is held against an axis that is driven, or by a wall.
bool holds(const Told& k) {
  const auto& all = k.scene.test.stages;
  return k.scene.test.loading.holds || pressed(k) ||
         std::any_of(all.begin(), all.end(), [](const auto& s) { return s.holds(); });
}
/// In a box or cylinder of walls.
bool boxed(const Told& k) { return dem::box_of_walls(k.sample.state); }
/// With other walls.
bool walled(const Told& k) { return !boxed(k); }
/// In a box or cylinder of walls, with `output.wall_forces`.
bool sided(const Told& k) { return k.scene.output.wall_forces && boxed(k); }
/// Between platens, with `output.strain_gauges`.
bool strain_gauged(const Told& k) { return k.scene.output.strain_gauges; }
/// In a box of walls, or between platens.
bool faced(const Told& k) { return dem::has_faces(k.scene.test, k.sample.state); }
/// With `[[grain]]`.
bool listed(const Told& k) { return k.scene.listed_grains() > 0; }

std::vector<std::string> components(const Told&) { return {"xx", "yy", "zz", "yz", "xz", "xy"}; }
std::vector<std::string> axes(const Told&) { return {"xx", "yy", "zz"}; }

std::vector<std::string> walls(const Told& k) {
  std::vector<std::string> names;
  for (std::size_t w = 0; w < k.sample.state.boundary.walls.size(); ++w)
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("wall{}_f{}", w, axis));
  return names;
}

std::vector<std::string> sides(const Told& k) {
  std::vector<std::string> names;
  for (const dem::Wall& wall : k.sample.state.boundary.walls)
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("force_{}_{}", wall.name, axis));
  return names;
}

std::vector<std::string> pressing(const Told& k) {
  std::vector<std::string> names;
  for (const dem::WallControl& c : k.scene.test.loading.walls) {
    const std::string& name = k.sample.state.boundary.walls[c.wall].name;
    names.push_back(name.empty() ? fmt::format("wall{}", c.wall) : name);
  }
  return names;
}

constexpr const char* of_a_grain[] = {"x_m",      "y_m",      "z_m",  "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s",
                                      "wy_rad_s", "wz_rad_s", "fx_N", "fy_N",   "fz_N",   "tx_N_m", "ty_N_m",
                                      "tz_N_m",   "qw",       "qx",   "qy",     "qz"};

std::vector<std::string> grains(const Told& k) {
  std::vector<std::string> names;
  for (std::size_t g = 0; g < listed_of(k.scene); ++g)
    for (const char* name : of_a_grain) names.push_back(fmt::format("g{}_{}", g, name));
  return names;
}

/// Listed grains keep their ids until they break; then their columns are empty (NaN).
double motion_of(const Row& r, std::size_t k) {
  const std::size_t part = k % std::size(of_a_grain);
  const auto at = r.grain(k / std::size(of_a_grain));
  if (!at) return NAN;
  const dem::Grains& g = r.state.grains;
  const dem::Motion& m = g.motion[*at];
  const dem::Quat& q = g.orientation[*at];
  if (part >= 15) return std::array{q.w(), q.x(), q.y(), q.z()}[part - 15];
  const dem::Vec3* rows[] = {&m.position, &m.velocity, &m.spin, &g.force[*at], &g.torque[*at]};
  return (*rows[part / 3])[static_cast<int>(part % 3)];
}

std::size_t damaged(const dem::State& s) {
  const auto& bonds = s.bonds.face.row;
  return static_cast<std::size_t>(
      std::count_if(bonds.begin(), bonds.end(), [](const dem::FaceBond& b) { return b.onset > 0; }));
}

const std::vector<ColumnEntry<Row, Told>> table{
    {"time_s", "s", "since the test began", always, [](const Row& r, K) { return r.state.time; }},
    {"stage", "", "number of the stage, from 1", staged,
     [](const Row& r, K) { return number(std::min<K>(r.scene.test.now.stage + 1, r.scene.test.stages.size())); }},
    {"cycle", "", "cycles of the stage that are over, in halves", cycled,
     [](const Row& r, K) { return 0.5 * number(r.scene.test.now.leg); }},
    {"strain_{}", "", "of the box or cell since the test began, tension-positive (of a gradient the component itself)",
     always, [](const Row& r, K k) { return dem::to_voigt(r.gradient)[static_cast<int>(k)]; }, components},
    {"stress_{}_Pa", "Pa", "Love-Weber stress, tension-positive", always,
     [](const Row& r, K k) { return dem::to_voigt(r.measured.stress)[static_cast<int>(k)]; }, components},
    {"axial_strain", "", "compression along the test's axis, of the box or cell, or of the gap between platens", always,
     [](const Row& r, K) { return dem::axial_strain(r.scene.test, r.first, r.state, r.initial_cell); }},
    {"axial_stress_Pa", "Pa", "compression-positive: walls and platens by their force, cells by Love-Weber", always,
     [](const Row& r, K) { return dem::axial_stress(r.scene.test, r.first, r.state, r.measured); }},
    {"mean_pressure_Pa", "Pa", "mean of the Love-Weber stress, compression-positive", always,
     [](const Row& r, K) { return r.pressure(); }},
    {"void_ratio", "", "volume of voids over that of grains", always,
     [](const Row& r, K) { return r.measured.void_ratio; }},
    {"coordination", "", "touching contacts a grain, walls included", always,
     [](const Row& r, K) { return r.measured.coordination; }},
    {"grains", "", "how many there are", always, [](const Row& r, K) { return number(r.state.grains.size()); }},
    {"breakages", "", "grains broken since the test began", always,
     [](const Row& r, K) { return number(r.ledger().breakages); }},
    {"bonds_broken", "", "bonds broken since the test began", always,
     [](const Row& r, K) { return number(r.ledger().bonds_broken); }},
    {"mass_kg", "kg", "of the grains", always, [](const Row& r, K) { return dem::total_mass(r.state.grains); }},
    {"mass_lost_kg", "kg", "taken away as fines", always, [](const Row& r, K) { return r.ledger().fines.mass; }},
    {"inertial_number", "", "rate x mean diameter x sqrt(density / pressure)", always,
     [](const Row& r, K) { return dem::inertial_number(r.state, r.scene.test.strain_rate, r.pressure()); }},
    {"unbalanced_force", "", "mean resultant on a grain over mean contact force", always,
     [](const Row& r, K) { return r.measured.unbalanced_force; }},
    {"kinetic_J", "J", "kinetic energy", always, [](const Row& r, K) { return r.measured.kinetic; }},
    {"elastic_J", "J", "held by contacts and bonds", always, [](const Row& r, K) { return r.measured.elastic; }},
    {"friction_J", "J", "dissipated by friction", always, [](const Row& r, K) { return r.ledger().friction; }},
    {"damping_J", "J", "dissipated by dashpots of contacts and local damping", always,
     [](const Row& r, K) { return r.ledger().damping; }},
    {"fracture_J", "J", "taken by fresh surfaces and bonds that soften", always,
     [](const Row& r, K) { return r.ledger().fracture; }},
    {"work_J", "J", "of walls, cell, loads and gravity on the grains", always,
     [](const Row& r, K) { return r.ledger().work; }},
    {"energy_error", "", "what the balance of energy lacks, over the energy exchanged", always,
     [](const Row& r, K) { return dem::told_energy_error(r.state, r.measured.kinetic + r.measured.elastic); }},
    {"split_J", "J", "taken by splits: elastic energy of lost contacts, kinetic energy of fines", always,
     [](const Row& r, K) { return r.ledger().split + r.ledger().fines.kinetic; }},
    {"solid_fraction", "", "volume of grains over that of the sample", always,
     [](const Row& r, K) { return r.measured.solid_fraction; }},
    {"time_step_s", "s", "time step", always, [](const Row& r, K) { return r.state.dt; }},
    {"steps", "", "time steps since the test began", always, [](const Row& r, K) { return number(r.state.steps); }},
    {"energy_unexplained_J", "J", "part of the energy error that springs, splits and spins lost for no known reason",
     always, [](const Row& r, K) { return r.ledger().unexplained; }},
    {"fabric_{}", "", "mean of n n over contacts", always,
     [](const Row& r, K k) { return dem::to_voigt(r.measured.fabric)[static_cast<int>(k)]; }, components},
    {"adhesion_J", "J", "taken and given by attraction as contacts snap on and off", attracts,
     [](const Row& r, K) { return r.ledger().adhesion; }},
    {"reshape_J", "J", "spin x change of inertia x spin of fragments that change their shape", reshapes,
     [](const Row& r, K) { return r.ledger().reshape; }},
    {"inertia_J", "J", "kinetic energy put in by births with scaled inertia, and as inertia by step is given", scales,
     [](const Row& r, K) { return r.ledger().inertia; }},
    {"added_mass", "", "mass that grains were given for the step, over that of the solids", by_step,
     [](const Row& r, K) { return r.added().mass; }},
    {"added_moment", "", "the same of their moments of inertia", by_step,
     [](const Row& r, K) { return r.added().moment; }},
    {"critical_grain", "", "id of the grain that sets the time step", critical,
     [](const Row& r, K) { return number(r.critical().id); }},
    {"critical_diameter_m", "m", "its diameter, of the sphere of equal volume", critical,
     [](const Row& r, K) { return r.critical().diameter; }},
    {"critical_width_m", "m", "its least width", critical, [](const Row& r, K) { return r.critical().width; }},
    {"critical_turning", "", "share of turning in its fastest motion: 0 a shift or an impact, 1 a turn", critical,
     [](const Row& r, K) { return r.critical().turning; }},
    {"pd_tests", "", "grains tested for cracks since the test began", tests_cracks,
     [](const Row& r, K) { return number(r.ledger().cracks.tests); }},
    {"pd_holds", "", "of these such that held", tests_cracks,
     [](const Row& r, K) { return number(r.ledger().cracks.holds); }},
    {"pd_cracks", "", "such that fell to pieces", tests_cracks,
     [](const Row& r, K) { return number(r.ledger().cracks.cracks); }},
    {"pd_stalled", "", "such that neither held nor parted: left whole", tests_cracks,
     [](const Row& r, K) { return number(r.ledger().cracks.stalled); }},
    {"fragment_area_m2", "m^2", "of the fresh faces between pieces", tests_cracks,
     [](const Row& r, K) { return r.ledger().fracture_area; }},
    {"bond_energy_J", "J", "that bonds in cracked grains gave up: beside the balance, for rigid grains never held it",
     tests_cracks, [](const Row& r, K) { return r.ledger().cracks.bond_energy; }},
    {"void_ratio_all", "", "the same with fines counted as grains", balls,
     [](const Row& r, K) {
       return r.measured.volume > 0 ? r.measured.volume / dem::whole_solid(r.scene.model, r.state) - 1 : NAN;
     }},
    {"k0", "", "mean lateral over axial stress", balls,
     [](const Row& r, K) { return dem::lateral_ratio(r.sample_stress().diagonal(), r.scene.test.axis); }},
    {"overlap_share_10", "", "share of contacts deeper than a tenth of the smaller radius", balls,
     [](const Row& r, K) { return dem::share_deeper(r.state, 0.1); }},
    {"overlap_share_30", "", "share of contacts deeper than three tenths of the smaller radius", balls,
     [](const Row& r, K) { return dem::share_deeper(r.state, 0.3); }},
    {"d10_m", "m", "diameter that a tenth of the mass passes", graded,
     [](const Row& r, K) { return r.grading().diameter(0.1); }},
    {"d50_m", "m", "diameter that half of the mass passes", graded,
     [](const Row& r, K) { return r.grading().diameter(0.5); }},
    {"d90_m", "m", "diameter that nine tenths of the mass pass", graded,
     [](const Row& r, K) { return r.grading().diameter(0.9); }},
    {"breakage_einav", "", "Einav's breakage", graded,
     [](const Row& r, K) { return dem::einav_breakage(*r.first_grains.grading, r.grading()); }},
    {"breakage_hardin", "", "Hardin's relative breakage", graded,
     [](const Row& r, K) { return dem::hardin_breakage(*r.first_grains.grading, r.grading()); }},
    {"fractal_dimension", "", "of the grading", graded,
     [](const Row& r, K) { return r.grading().fractal_dimension(); }},
    {"fines_fraction", "", "share of the mass that is fines", graded,
     [](const Row& r, K) { return r.grading().fines_fraction(); }},
    {"zingg_equant", "", "share of the mass in Zingg's class of equant grains", graded,
     [](const Row& r, K) { return r.zingg().equant; }},
    {"zingg_disc", "", "of discs", graded, [](const Row& r, K) { return r.zingg().disc; }},
    {"zingg_rod", "", "of rods", graded, [](const Row& r, K) { return r.zingg().rod; }},
    {"zingg_blade", "", "of blades", graded, [](const Row& r, K) { return r.zingg().blade; }},
    {"elongation", "", "mean of intermediate over longest axis, by mass", graded,
     [](const Row& r, K) { return r.zingg().elongation; }},
    {"flatness", "", "mean of shortest over intermediate axis, by mass", graded,
     [](const Row& r, K) { return r.zingg().flatness; }},
    {"sphericity", "", "of hulls, mean by mass", rounded, [](const Row& r, K) { return r.roundness().sphericity; }},
    {"angularity", "", "of hulls, mean by mass", rounded, [](const Row& r, K) { return r.roundness().angularity; }},
    {"split_contacts", "", "contacts that parents had at splits, summed", splits,
     [](const Row& r, K) { return number(r.ledger().splits.contacts); }},
    {"split_contacts_kept", "", "of these kept by the pieces", splits,
     [](const Row& r, K) { return number(r.ledger().splits.contacts_kept); }},
    {"split_force_N", "N", "normal force of the parents' contacts at splits, summed", splits,
     [](const Row& r, K) { return r.ledger().splits.force; }},
    {"split_force_kept_N", "N", "of this kept by the pieces", splits,
     [](const Row& r, K) { return r.ledger().splits.force_kept; }},
    {"split_instants", "", "breakage tests in which grains split", splits,
     [](const Row& r, K) { return number(r.ledger().splits.instants); }},
    {"split_pressure_jump", "", "relative jumps of the sample's pressure there, summed", splits,
     [](const Row& r, K) { return r.ledger().splits.pressure_jump; }},
    {"bonds", "", "bonds that are left", bonded, [](const Row& r, K) { return number(r.state.bonds.face.row.size()); }},
    {"bonds_damaged", "", "of these such that have begun to soften", bonded,
     [](const Row& r, K) { return number(damaged(r.state)); }},
    {"fragments", "", "groups of Voronoi cells that bonds hold together, and cells alone", bonded,
     [](const Row& r, K) { return number(r.fragments().size.size()); }},
    {"largest_fragment", "", "Voronoi cells of the largest", bonded,
     [](const Row& r, K) { return number(r.fragments().size.front()); }},
    {"bond_J", "J", "held by bonds, part of elastic_J", bonded,
     [](const Row& r, K) { return dem::stored_energy(r.state.bonds); }},
    {"bond_friction_J", "J", "rubbed by what has given way of faces, part of friction_J", bonded,
     [](const Row& r, K) { return r.ledger().bond_friction; }},
    {"handed_J", "J", "held by the pressed part of bonds that broke, and by no contact after them", bonded,
     [](const Row& r, K) { return r.ledger().handed; }},
    {"bond_damping_J", "J", "dissipated by dashpots of bonds, part of damping_J", dashpots,
     [](const Row& r, K) { return r.ledger().bond_damping; }},
    {"load_N", "N", "of platens, rollers or a moving clamp, along their motion", gauged,
     [](const Row& r, K) { return r.load(); }},
    {"displacement_m", "m", "way of what moves", gauged,
     [](const Row& r, K) { return dem::way_of(*r.scene.test.gauge, r.first, r.state); }},
    {"nominal_stress_Pa", "Pa",
     "load over the section; of a disc across its axis 2 P / (pi D t); of a beam the fibre's", gauged,
     [](const Row& r, K) { return r.load() * r.scene.test.gauge->stress_per_load; }},
    {"load_N", "N", "of dead loads, along their sum", dead_loads,
     [](const Row& r, K) { return *dem::dead_load(r.scene.test, r.state); }},
    {"displacement_m", "m", "way on which dead loads work", dead_loads,
     [](const Row& r, K) { return dem::dead_way(r.first, r.state); }},
    {"p_Pa", "Pa", "mean stress, compression-positive", invariants,
     [](const Row& r, K) { return dem::mean_pressure(r.sample_stress()); }},
    {"q_Pa", "Pa", "sqrt(3/2) of the deviator's norm", invariants,
     [](const Row& r, K) { return std::sqrt(1.5) * dem::deviator(r.sample_stress()); }},
    {"strain_volumetric", "", "compression-positive", invariants, [](const Row& r, K) { return -r.strain().trace(); }},
    {"strain_deviatoric", "", "sqrt(2/3) of the deviator's norm", invariants,
     [](const Row& r, K) { return std::sqrt(2.0 / 3) * dem::deviator(r.strain()); }},
    {"lode_angle_rad", "rad", "Lode's angle of the stress: 0 in triaxial compression, pi / 3 in extension",
     three_stresses, [](const Row& r, K) { return dem::lode_angle(r.sample_stress()); }},
    {"lateral_stress_error", "", "how far the stresses that are held are off what is asked", holds,
     [](const Row& r, K) {
       const dem::Loading& now = r.scene.test.loading;
       return now.holds || !now.walls.empty() ? dem::stress_error(r.state, now, r.measured) : NAN;
     }},
    {"wall_stress_{}_Pa", "Pa", "force over area of the walls of a box, tension-positive", boxed,
     [](const Row& r, K k) { return r.measured.wall_stress(static_cast<int>(k), static_cast<int>(k)); }, axes},
    {"{}_N", "N", "force of the grains on each wall of the box or cylinder", sided,
     [](const Row& r, K k) { return r.wall_force(k / 3)[static_cast<int>(k % 3)]; }, sides},
    {"{}_N", "N", "force on each wall", walled,
     [](const Row& r, K k) { return r.wall_force(k / 3)[static_cast<int>(k % 3)]; }, walls},
    {"way_{}_m", "m", "of a wall that seeks a stress, inward since the test began", pressed,
     [](const Row& r, K k) { return r.way(r.scene.test.loading.walls[k].wall); }, pressing},
    {"gauge_strain_{}", "", "of the middle half of the height, by the grains that began there; tension-positive",
     strain_gauged, [](const Row& r, K k) { return r.gauged()(static_cast<int>(k), static_cast<int>(k)); }, axes},
    {"stress_front_Pa", "Pa", "on the moving face along the test's axis, compression-positive", faced,
     [](const Row& r, K) { return r.face_stresses()[1]; }},
    {"stress_back_Pa", "Pa", "on the fixed face", faced, [](const Row& r, K) { return r.face_stresses()[0]; }},
    {"{}", "",
     "of each listed grain, of 16 at most: position, velocity, spin, force, torque and orientation; empty once it "
     "has broken",
     listed, motion_of, grains},
};

}  // namespace

std::vector<Column<Row>> rve_columns(const Told& told) { return columns_of(table, told); }

}  // namespace grus::app
