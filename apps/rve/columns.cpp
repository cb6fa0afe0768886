// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/rve/columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "dem/bond/supports.hpp"
#include "dem/rve/crushing.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/servo.hpp"
#include "dem/rve/step.hpp"

namespace grus::app {
namespace {

const char* const components[6] = {"xx", "yy", "zz", "yz", "xz", "xy"};
constexpr std::size_t most_listed = 16;

bool box_of_walls(const dem::State& s) { return !s.boundary.cell.periodic() && dem::bulk_volume(s.boundary) > 0; }

/// The stress of the sample, from its walls where it has any (Pa, tension-positive).
const dem::Mat3& sample_stress(const dem::State& s, const dem::Measurement& m) {
  return box_of_walls(s) ? m.wall_stress : m.stress;
}

dem::Vec3 wall_force(const dem::State& s, std::size_t wall) {
  dem::Vec3 force = dem::Vec3::Zero();
  for (std::size_t k = s.contacts.begin[dem::first_wall]; k < s.contacts.size(); ++k)
    if (s.contacts.pair[k].b == wall) force += s.contacts.touch[k].force;
  return force + dem::support_force(s.bonds, wall);
}

/// Compression-positive stress (Pa) on the fixed and on the moving face along the test's axis: walls of a box, or
/// platens (force over the square of the initial height).
std::array<double, 2> face_stresses(const RveScene& scene, const dem::State& s) {
  const int axis = scene.test.axis;
  double area = 0;
  if (scene.test.kind == "platens")
    area = std::pow((scene.state.boundary.walls[1].point - scene.state.boundary.walls[0].point)[axis], 2);
  std::array<std::size_t, 2> face{};
  for (std::size_t w = 0; w < s.boundary.walls.size(); ++w)
    for (std::size_t side = 0; side < 2; ++side)
      if (s.boundary.walls[w].normal[axis] == (side ? -1 : 1)) face[side] = w;
  if (area == 0)
    area = dem::bulk_volume(s.boundary) / (s.boundary.walls[face[1]].point - s.boundary.walls[face[0]].point)[axis];
  return {-wall_force(s, face[0])[axis] / area, wall_force(s, face[1])[axis] / area};
}

void add_bonds(const dem::State& s, std::vector<double>& row) {
  const dem::Fragments fragments = dem::fragments_of(s);
  const auto& bonds = s.bonds.face.row;
  const auto damaged = std::count_if(bonds.begin(), bonds.end(), [](const dem::FaceBond& b) { return b.onset > 0; });
  row.insert(row.end(), {static_cast<double>(bonds.size()), static_cast<double>(damaged),
                         static_cast<double>(fragments.size.size()), static_cast<double>(fragments.size.front()),
                         dem::stored_energy(s.bonds), s.ledger.bond_friction, s.ledger.handed});
}

bool gauged(const RveScene& scene) { return scene.cells && scene.cells->gauge; }

double load_of(const RveScene::Gauge& gauge, const dem::State& s) {
  double load = 0;
  for (const auto& [wall, weight] : gauge.walls) load += weight * wall_force(s, wall).dot(gauge.along);
  return load;
}

/// Load, way and stress of what moves: all along its motion.
void add_gauge(const RveScene& scene, const dem::State& s, std::vector<double>& row) {
  const RveScene::Gauge& gauge = *scene.cells->gauge;
  const double load = load_of(gauge, s);
  const dem::Vec3 way = s.boundary.walls[gauge.moving].point - scene.state.boundary.walls[gauge.moving].point;
  row.insert(row.end(), {load, way.dot(gauge.along), load * gauge.stress_per_load});
}

/// A dead load has no wall to tell its way.
bool loaded(const RveScene& scene) { return !gauged(scene) && !scene.state.bonds.load.empty(); }

/// How dead loads pull: along their sum, or along the first of them where they hold each other.
struct Pull {
  dem::Vec3 along = dem::Vec3::Zero();
  bool balanced = false;

  explicit Pull(const dem::Bonds& bonds) {
    double all = 0;
    for (const dem::DeadLoad& load : bonds.load) along += load.force, all += load.force.norm();
    balanced = along.norm() < 1e-6 * all;
    along = (balanced ? bonds.load.front().force : along).normalized();
  }
  /// Its part in the force of all: of loads that hold each other each half counts once.
  double part(const dem::DeadLoad& load, const dem::Vec3& force) const {
    const double f = force.dot(along);
    return !balanced ? f : load.force.dot(along) < 0 ? -0.5 * f : 0.5 * f;
  }
  double of(const dem::Bonds& bonds, dem::Vec3 dem::DeadLoad::*force) const {
    double sum = 0;
    for (const dem::DeadLoad& load : bonds.load) sum += part(load, load.*force);
    return sum;
  }
};

/// Force of the dead loads, and the way on which it does their work: of where they hold, by their shares.
void add_loads(const RveScene& scene, const dem::State& s, std::vector<double>& row) {
  const Pull pull(s.bonds);
  const double whole = pull.of(s.bonds, &dem::DeadLoad::force);
  double way = 0;
  for (std::size_t k = 0; k < s.bonds.load.size(); ++k) {
    const dem::DeadLoad& load = s.bonds.load[k];
    way += load.force.dot(pull.along) / whole * (load.point - scene.state.bonds.load[k].point).dot(pull.along);
  }
  row.insert(row.end(), {pull.of(s.bonds, &dem::DeadLoad::felt), way});
}

bool damps_bonds(const RveScene& scene) { return !scene.state.bonds.dashpot.empty(); }

double deviator(const dem::Mat3& m) { return (m - m.trace() / 3 * dem::Mat3::Identity()).norm(); }

/// p, q, and the strains that go with them, compression-positive.
void add_invariants(const dem::Mat3& stress, const dem::Mat3& gradient, std::vector<double>& row) {
  const dem::Mat3 strain = 0.5 * (gradient + gradient.transpose());
  row.insert(row.end(), {dem::mean_pressure(stress), std::sqrt(1.5) * deviator(stress), -strain.trace(),
                         std::sqrt(2.0 / 3) * deviator(strain)});
}

bool has_faces(const RveScene& scene, const dem::State& s) { return box_of_walls(s) || scene.test.kind == "platens"; }

}  // namespace

double axial_stress(const RveScene& scene, const dem::State& s, const dem::Measurement& m) {
  if (!has_faces(scene, s)) return -m.stress(scene.test.axis, scene.test.axis);
  const auto [back, front] = face_stresses(scene, s);
  return 0.5 * (back + front);
}

double axial_stress(const RveScene& scene, const dem::State& s) {
  dem::Measurement m;
  if (!has_faces(scene, s)) m.stress = dem::love_weber(s, dem::bulk_volume(s.boundary));
  return axial_stress(scene, s, m);
}

bool has_stress(const RveScene& scene, const dem::State& s) {
  return tells_stress(scene) || has_faces(scene, s) || dem::bulk_volume(s.boundary) > 0;
}

std::optional<double> dead_load(const RveScene& scene, const dem::State& s) {
  if (!loaded(scene)) return {};
  return Pull(s.bonds).of(s.bonds, &dem::DeadLoad::felt);
}

bool tells_stress(const RveScene& scene) { return gauged(scene) || scene.test.kind == "constant-p"; }

double test_stress(const RveScene& scene, const dem::State& s, const dem::Measurement& m) {
  if (gauged(scene)) return load_of(*scene.cells->gauge, s) * scene.cells->gauge->stress_per_load;
  return scene.test.kind == "constant-p" ? std::sqrt(1.5) * deviator(sample_stress(s, m)) : 0;
}

std::vector<std::string> rve_columns(const RveScene& scene, const dem::State& state) {
  std::vector<std::string> c{"time_s"};
  for (const char* ij : components) c.push_back(fmt::format("strain_{}", ij));
  for (const char* ij : components) c.push_back(fmt::format("stress_{}_Pa", ij));
  for (const char* name : {"axial_strain", "axial_stress_Pa", "mean_pressure_Pa",
                           "void_ratio",   "coordination",    "grains",
                           "breakages",    "bonds_broken",    "mass_kg",
                           "mass_lost_kg", "inertial_number", "unbalanced_force",
                           "kinetic_J",    "elastic_J",       "friction_J",
                           "damping_J",    "fracture_J",      "work_J",
                           "energy_error", "split_J",         "solid_fraction",
                           "time_step_s",  "steps",           "energy_unexplained_J"})
    c.emplace_back(name);
  for (const char* ij : components) c.push_back(fmt::format("fabric_{}", ij));
  if (dem::attracts(scene.model.law)) c.emplace_back("adhesion_J");
  if (scene.model.reshapes()) c.emplace_back("reshape_J");
  if (scene.model.numerics.scaled_below > 0) c.emplace_back("inertia_J");
  if (scene.model.has_balls())
    for (const char* name : {"void_ratio_all", "k0", "overlap_share_10", "overlap_share_30"}) c.emplace_back(name);
  if (scene.output.grading)
    for (const char* name :
         {"d10_m", "d50_m", "d90_m", "breakage_einav", "breakage_hardin", "fractal_dimension", "fines_fraction",
          "zingg_equant", "zingg_disc", "zingg_rod", "zingg_blade", "elongation", "flatness"})
      c.emplace_back(name);
  if (scene.output.grading && scene.of_hulls())
    for (const char* name : {"sphericity", "angularity"}) c.emplace_back(name);
  if (scene.model.split_statistics)
    for (const char* name : {"split_contacts", "split_contacts_kept", "split_force_N", "split_force_kept_N",
                             "split_instants", "split_pressure_jump"})
      c.emplace_back(name);
  if (scene.bonded())
    for (const char* name :
         {"bonds", "bonds_damaged", "fragments", "largest_fragment", "bond_J", "bond_friction_J", "handed_J"})
      c.emplace_back(name);
  if (damps_bonds(scene)) c.emplace_back("bond_damping_J");
  if (gauged(scene))
    for (const char* name : {"load_N", "displacement_m", "nominal_stress_Pa"}) c.emplace_back(name);
  if (loaded(scene))
    for (const char* name : {"load_N", "displacement_m"}) c.emplace_back(name);
  if (scene.test.kind == "constant-p")
    for (const char* name : {"p_Pa", "q_Pa", "strain_volumetric", "strain_deviatoric"}) c.emplace_back(name);
  if (scene.test.loading.holds) c.emplace_back("lateral_stress_error");
  if (box_of_walls(state))
    for (int k = 0; k < 3; ++k) c.push_back(fmt::format("wall_stress_{}_Pa", components[k]));
  else
    for (std::size_t w = 0; w < state.boundary.walls.size(); ++w)
      for (const char* k : {"x", "y", "z"}) c.push_back(fmt::format("wall{}_f{}_N", w, k));
  if (has_faces(scene, state)) c.insert(c.end(), {"stress_front_Pa", "stress_back_Pa"});
  for (std::size_t g = 0; g < std::min(scene.listed_grains, most_listed); ++g)
    for (const char* name : {"x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s",
                             "fx_N", "fy_N", "fz_N", "tx_N_m", "ty_N_m", "tz_N_m", "qw", "qx", "qy", "qz"})
      c.push_back(fmt::format("g{}_{}", g, name));
  return c;
}

namespace {

void add_listed_grains(const RveScene& scene, const dem::State& s, std::vector<double>& row) {
  for (std::size_t g = 0; g < std::min(scene.listed_grains, most_listed); ++g) {
    // Listed grains keep their ids until they break; then their columns are empty (NaN).
    const auto found = std::find(s.grains.id.begin(), s.grains.id.end(), g);
    const bool there = found != s.grains.id.end();
    const std::size_t i = there ? static_cast<std::size_t>(found - s.grains.id.begin()) : 0;
    const dem::Motion& p = s.grains.motion[i];
    const dem::Quat& q = s.grains.orientation[i];
    for (const auto& v : {p.position, p.velocity, p.spin, s.grains.force[i], s.grains.torque[i]})
      for (int k = 0; k < 3; ++k) row.push_back(there ? v[k] : NAN);
    for (double v : {q.w(), q.x(), q.y(), q.z()}) row.push_back(there ? v : NAN);
  }
}

void add_grading(const RveScene& scene, const dem::State& s, std::vector<double>& row) {
  const dem::Grading first(scene.state, scene.scale), now(s, scene.scale);
  const dem::Zingg z = dem::zingg(s.grains);
  row.insert(row.end(), {now.diameter(0.1), now.diameter(0.5), now.diameter(0.9), dem::einav_breakage(first, now),
                         dem::hardin_breakage(first, now), now.fractal_dimension(), now.fines_fraction(), z.equant,
                         z.disc, z.rod, z.blade, z.elongation, z.flatness});
  if (!scene.of_hulls()) return;
  const dem::Roundness round = dem::roundness(s.grains);
  row.insert(row.end(), {round.sphericity, round.angularity});
}

void add_crushing(const RveScene& scene, const dem::State& s, const dem::Measurement& m, std::vector<double>& row) {
  row.insert(row.end(), {m.volume > 0 ? m.volume / dem::whole_solid(scene.model, s) - 1 : NAN,
                         dem::lateral_ratio(sample_stress(s, m).diagonal(), scene.test.axis), dem::share_deeper(s, 0.1),
                         dem::share_deeper(s, 0.3)});
}

void add_split_statistics(const dem::SplitStatistics& p, std::vector<double>& row) {
  row.insert(row.end(), {static_cast<double>(p.contacts), static_cast<double>(p.contacts_kept), p.force, p.force_kept,
                         static_cast<double>(p.instants), p.pressure_jump});
}

}  // namespace

double axial_strain(const RveScene& scene, const dem::State& s, const dem::Mat3& initial_cell) {
  const int axis = scene.test.axis;
  if (scene.test.kind != "platens") return -dem::displacement_gradient(s, scene.test.loading, initial_cell)(axis, axis);
  const auto gap = [axis](const std::vector<dem::Wall>& w) { return (w[1].point - w[0].point)[axis]; };
  return 1 - gap(s.boundary.walls) / gap(scene.state.boundary.walls);
}

std::vector<double> rve_row(const RveScene& scene, const dem::State& s, const dem::Measurement& m,
                            const dem::Mat3& initial_cell) {
  const dem::Mat3 gradient = dem::displacement_gradient(s, scene.test.loading, initial_cell);
  std::vector<double> row{s.time};
  const dem::Vec6 strain = dem::to_voigt(gradient), stress = dem::to_voigt(m.stress);
  for (int k = 0; k < 6; ++k) row.push_back(strain[k]);
  for (int k = 0; k < 6; ++k) row.push_back(stress[k]);
  const double stored = m.kinetic + m.elastic, pressure = dem::mean_pressure(m.stress);
  const dem::Ledger& l = s.ledger;
  row.insert(row.end(), {axial_strain(scene, s, initial_cell),
                         axial_stress(scene, s, m),
                         pressure,
                         m.void_ratio,
                         m.coordination,
                         static_cast<double>(s.grains.size()),
                         static_cast<double>(l.breakages),
                         static_cast<double>(l.bonds_broken),
                         dem::total_mass(s.grains),
                         l.fines.mass,
                         dem::inertial_number(s, scene.test.strain_rate, pressure),
                         m.unbalanced_force,
                         m.kinetic,
                         m.elastic,
                         l.friction,
                         l.damping,
                         l.fracture,
                         l.work,
                         dem::told_energy_error(s, stored),
                         l.split + l.fines.kinetic,
                         m.solid_fraction,
                         s.dt,
                         static_cast<double>(s.steps),
                         l.unexplained});
  const dem::Vec6 fabric = dem::to_voigt(m.fabric);
  for (int k = 0; k < 6; ++k) row.push_back(fabric[k]);
  if (dem::attracts(scene.model.law)) row.push_back(l.adhesion);
  if (scene.model.reshapes()) row.push_back(l.reshape);
  if (scene.model.numerics.scaled_below > 0) row.push_back(l.inertia);
  if (scene.model.has_balls()) add_crushing(scene, s, m, row);
  if (scene.output.grading) add_grading(scene, s, row);
  if (scene.model.split_statistics) add_split_statistics(l.splits, row);
  if (scene.bonded()) add_bonds(s, row);
  if (damps_bonds(scene)) row.push_back(l.bond_damping);
  if (gauged(scene)) add_gauge(scene, s, row);
  if (loaded(scene)) add_loads(scene, s, row);
  if (scene.test.kind == "constant-p") add_invariants(sample_stress(s, m), gradient, row);
  if (scene.test.loading.holds) row.push_back(dem::stress_error(s, scene.test.loading, m));
  if (box_of_walls(s)) {
    for (int k = 0; k < 3; ++k) row.push_back(m.wall_stress(k, k));
  } else {
    for (std::size_t w = 0; w < s.boundary.walls.size(); ++w) {
      const dem::Vec3 f = wall_force(s, w);
      row.insert(row.end(), {f.x(), f.y(), f.z()});
    }
  }
  if (has_faces(scene, s)) {
    const auto [back, front] = face_stresses(scene, s);
    row.insert(row.end(), {front, back});
  }
  add_listed_grains(scene, s, row);
  return row;
}

}  // namespace grus::app
