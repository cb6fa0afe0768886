// SPDX-License-Identifier: LGPL-3.0-or-later
// What a run of grus-rve says at its end: notes and summary.json.
#include <fmt/format.h>

#include <filesystem>

#include "apps/rve/bursts.hpp"
#include "apps/rve/rve_run.hpp"
#include "dem/bond/cohesive.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/step.hpp"
#include "dem/rve/stepper.hpp"
#include "dem/sample/gauge.hpp"

namespace grus::app {
namespace {

nlohmann::json ledger_json(const dem::Ledger& l, double error, const dem::State& s, const dem::Measurement& m) {
  double whole = 0;  // with fracture_J this is G_c times the area made
  for (const auto& spring : s.bonds.cohesive.row) whole += 0.5 * spring.peak * spring.rupture - dem::dissipated(spring);
  return {{"work_J", l.work},
          {"kinetic_J", m.kinetic},
          {"elastic_J", m.elastic},
          {"start_J", l.start},
          {"friction_J", l.friction},
          {"damping_J", l.damping},
          {"local_damping_J", l.local_damping},
          {"fracture_J", l.fracture},
          {"bond_friction_J", l.bond_friction},
          {"handed_J", l.handed},
          {"split_elastic_J", l.split},
          {"fines_kinetic_J", l.fines.kinetic},
          {"fracture_left_in_springs_J", whole},
          {"reshape_J", l.reshape},
          {"split_added_J", l.split_added},
          {"fracture_area_m2", l.fracture_area},
          {"split_force_residual_N", l.residual_force},
          {"energy_unexplained_J", l.unexplained},
          {"energy_error", error}};
}

}  // namespace

/// The scene's, and what the run has shown.
std::vector<std::string> RveRun::notes() const {
  std::vector<std::string> all = scene_.notes;
  const bool solved = scene_.model.stepper->long_steps;
  if (course_.overfull >= 0)
    all.push_back(
        fmt::format("from {:.4g} MPa on the fines no longer fit into the voids (void_ratio_all is below 0): the "
                    "sample is softer than with them; see lost_mass",
                    course_.overfull / 1e6));
  if (const ErrorEstimates& e = course_.errors; e.mean_stress_error() > most_stress_error)
    all.push_back(fmt::format("the {} was off what is asked by {:.2g} % on average and {:.2g} % at worst: {}",
                              e.holds ? "lateral stress" : "stress sought", 100 * e.mean_stress_error(),
                              100 * e.stress.worst, e.advice(solved, !scene_.test.loading.walls.empty())));
  if (const double share = course_.errors.before_peak.devices(); has_peak() && share > most_devices)
    all.push_back(fmt::format(
        "local damping and the dashpots of bonds took {:.2g} % of the work before the peak, which is partly "
        "theirs: lower material.NAME.damping and material.NAME.bond.damping, or load more slowly",
        100 * share));
  if (const double share = split_share(); share > most_split)
    all.push_back(
        fmt::format("splits put {:.2g} % of the work into the sample (split_J): bonds of fresh faces begin with what "
                    "the plane bore, which a rigid grain has not held; it is the model's, not the loads'",
                    100 * share));
  for (std::size_t k = 0; k < stages_.size(); ++k)
    if (stages_[k].at("began_s") == stages_[k].at("ended_s"))
      all.push_back(fmt::format("stage {} ({}) has no length: its end ({}) was met as it began", k + 1,
                                stages_[k].at("name").get<std::string>(),
                                stages_[k].at("ended_by").get<std::string>()));
  const bool by_step = scene_.model.numerics.inertia_step > 0;
  for (std::string& note : course_.step.notes(by_step, solved)) all.push_back(std::move(note));
  if (status_ == finished && state_.steps > 0 && !dem::exchanged(state_))
    all.push_back(
        "the run is shorter than 20 steps: its energy error is not known, and is told as 0; go on for longer, or lower "
        "numerics.time_step");
  return all;
}

/// Energy that splits put in on balance, of what was exchanged; 0 where they took.
double RveRun::split_share() const {
  const double scale = dem::energy_scale(ledger_, now_.kinetic + now_.elastic);
  return scale > 0 ? std::max(0.0, -ledger_.split / scale) : 0;
}

/// Bonded Voronoi cells have a peak unless dead loads alone load them, whose stress is not told.
bool RveRun::has_peak() const { return sample_.bonded() && !dem::dead_loaded(scene_.test, sample_.state); }

nlohmann::json RveRun::summary() const {
  nlohmann::json summary = provenance();
  summary["title"] = scene_.title;
  if (const auto all = notes(); !all.empty()) summary["notes"] = all;
  summary["scene_file"] = std::filesystem::path(scene_.file).filename().string();
  summary["scene"] = *scene_.record;
  summary["status"] = status_;
  summary["ending"] = ending_;
  summary["seed"] = scene_.model.seed;
  summary["threads"] = options_.threads;
  summary["counts"] = {{"grains_start", first_grains_.count},
                       {"grains", state_.grains.size()},
                       {"breakages", state_.ledger.breakages},
                       {"bonds_broken", state_.ledger.bonds_broken},
                       {"steps", state_.steps},
                       {"grain_steps", state_.grain_steps},
                       {"history_rows", history_.rows()}};
  if (scene_.recipe.of_hulls() && scene_.model.breakable())
    summary["counts"]["planes_dropped"] = state_.ledger.planes_dropped;
  if (const double bulk = course_.bulk; bulk > 0)
    summary["sample"] = {{"bulk_density_kg_m3", course_.mass / bulk},
                         {"solid_fraction", course_.solid / bulk},
                         {"void_ratio", bulk / course_.solid - 1}};
  if (staged()) summary["stages"] = stages_;
  if (!prepared_.is_null()) summary["preparation"] = prepared_;
  summary["mass"] = {{"start_kg", first_grains_.mass},
                     {"grains_kg", dem::total_mass(state_.grains)},
                     {"lost_kg", state_.ledger.fines.mass}};
  if (scene_.recipe.of_hulls()) {
    const dem::Roundness round = dem::roundness(state_.grains);
    summary["shape"] = {{"sphericity", round.sphericity}, {"angularity", round.angularity}};
  }
  if (sample_.faces) {
    const dem::BondedFaces& f = *sample_.faces;
    const auto fragments = dem::fragments_of(state_).size;
    summary["counts"]["fragments"] = fragments.size();
    summary["cells"] = {{"cells", first_grains_.count},
                        {"bonds_start", f.bonds},
                        {"unbonded_faces", f.unbonded},
                        {"too_coarse_for_energy", f.coarse},
                        {"fragments", fragments}};
  }
  if (scene_.model.breakable()) {
    const dem::Fines& f = state_.ledger.fines;
    auto vector = [](const dem::Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
    summary["fines"] = {{"mass_kg", f.mass},
                        {"kinetic_J", f.kinetic},
                        {"momentum_kg_m_s", vector(f.momentum)},
                        {"angular_momentum_kg_m2_s", vector(f.angular_momentum)}};
  }
  summary["energy"] = ledger_json(ledger_, error_, state_, now_);
  if (dem::attracts(scene_.model.law)) summary["energy"]["adhesion_J"] = ledger_.adhesion;
  summary["errors"] = course_.errors.json(state_);
  const auto device = [&](const char* name, double joule) {
    if (joule != 0) summary["errors"][name] = joule / dem::energy_scale(ledger_, now_.kinetic + now_.elastic);
  };
  device("local_damping", ledger_.local_damping), device("bond_damping", ledger_.bond_damping);
  device("scaled_inertia", ledger_.inertia);
  if (const double share = split_share(); share > 0) summary["errors"]["put_in_by_splits"] = share;
  if (has_peak()) {
    const BeforePeak& p = course_.errors.before_peak;
    summary["errors"]["local_damping_before_peak"] = p.share(p.local_damping);
    summary["errors"]["bond_damping_before_peak"] = p.share(p.bond_damping);
    summary["errors"]["devices_before_peak"] = p.devices();
    summary["errors"]["kinetic_before_peak"] = p.share(p.kinetic);
  }
  if (scene_.model.numerics.inertia_step > 0) summary["inertia"] = course_.step.json();
  summary["errors"]["packing_overlap"] = sample_.packing_overlap;
  nlohmann::json& results = summary["results"];
  results = {{"final_time_s", state_.time}};
  if (dem::has_stress(scene_.test, state_)) {
    results["peak_axial_stress_Pa"] = course_.peak, results["peak_axial_stress_is_last"] = course_.peak_is_last;
    results["final_axial_stress_Pa"] = course_.axial;
  }
  if (const auto load = dem::dead_load(scene_.test, state_)) results["final_load_N"] = *load;
  if (now_.volume > 0) results["final_void_ratio"] = now_.void_ratio;
  if (dem::tells_stress(scene_.test))
    results["peak_stress_Pa"] = course_.reading, results["peak_stress_is_last"] = course_.reading_is_last;
  if (scene_.output.bursts > 0) summary["bursts"] = bursts_json(scene_, state_, good_until());
  // A strength is what a grain broke at; one that did not is stronger than the peak.
  if (state_.ledger.breakages > 0) results["peak_before_breakage_Pa"] = course_.intact;
  summary["seconds"] = {
      {"preparation_wall", ready_}, {"loading_wall", earlier_ + end_ - ready_}, {"cpu", earlier_cpu_ + cpu_seconds()}};
  return summary;
}

}  // namespace grus::app
