// SPDX-License-Identifier: LGPL-3.0-or-later
// The model: all that never changes in a run; shared by all RVEs of a scene.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "dem/contact/laws.hpp"
#include "dem/fracture/fracture_model.hpp"
#include "dem/motion/integrate.hpp"
#include "dem/state/bonds.hpp"

namespace grus::dem {

/// Bonds of the faces that Voronoi cells of a material share, or of its spheres.
struct BondModel {
  double stiffness = 0;  // modulus of the network (Pa); given: per area (Pa/m)
  bool stiffness_given = false;
  double ratio = 1;   // shear / normal
  double length = 0;  // m, of all bonds alike; 0: the distance of the Voronoi cells' seeds
  FaceCriterion criterion = FaceCriterion::cohesive;
  double tension = INFINITY, cohesion = INFINITY;  // Pa; strain-sum: strain, and angle (rad)
  double tan_phi = 0, friction = 0;
  double energy_1 = INFINITY, energy_2 = INFINITY;  // J/m^2
  double between = 0;                               // tension of bonds between clusters; 0: there are none
  double damping = 0;                               // fraction of critical of each mode of a face
  double weibull = 0;                               // modulus of the strengths' scatter, of mean 1; 0: none
  double radius_ratio = 1, gap = 0.1;  // of rods, over the smaller sphere's radius: their own; between the spheres
};

struct Material {
  std::string name;
  double density = 2650;         // kg/m^3
  double youngs_modulus = 60e9;  // Pa; infinite: rigid
  double poissons_ratio = 0.17;
  double friction = 0;
  double rolling_friction = 0;  // of the effective radius
  double restitution = 1;       // normal
  double damping = 0;           // local, non-viscous; of this material's grains
  LawConstants contact;         // what the contact law asks beside the solid; of a rigid one nothing
  bool turns = true;            // false: spheres of it keep their orientation
  bool fixed = false;           // its grains move with a wall: nothing damps them
  std::optional<FractureModel> fracture;
  std::optional<BondModel> bond;

  /// Limit of a couple's spring, over the normal force.
  double couple_friction(SpringRow) const { return rolling_friction; }
  Solid solid() const { return {youngs_modulus, poissons_ratio}; }
  const Balls* balls() const { return fracture ? std::get_if<Balls>(&fracture->splitter) : nullptr; }
  bool swells() const { return balls() && balls()->swells; }
};

/// Choices of the numerics; the defaults serve every shipped scene.
struct Numerics {
  double safety = 0.3;       // of the critical time step, which is a strict bound
  double time_step = 0;      // s; 0: from the critical step
  double max_time_step = 0;  // s; 0: no bound
  double skin = 0.12;        // of the mean radius
  int estimate_every = 50;   // steps between estimates of the critical step
  int fracture_every = 10;   // steps between tests of the fracture criteria
  double max_energy_error = 0.05;
  std::optional<double> max_overlap;  // of the smaller equivalent radius; see overlap_limit
  double reduce_cell_at = 1.5;        // a sheared cell is cut anew where its least height then grows by this factor
  double scaled_below = 0;            // diameter (m) below which grains resist motion as if denser
  double inertia_step = 0;            // s, time step that grains are given the inertia for; 0: they keep their own
  std::string place_of_step = {};     // of that key, for what is refused

  bool scales_inertia() const { return scaled_below > 0 || inertia_step > 0; }

  /// Mass that resists motion over that of the solid: with a density ~ d^-2 all sizes have one m / k and one inertial
  /// number, and the time step does not follow the smallest fragment. Quasi-static motion alone.
  double inertia_factor(double radius) const { return std::max(1.0, std::pow(0.5 * scaled_below / radius, 2)); }
};

struct Break;
struct State;
struct Stepper;
extern const Stepper explicit_stepper;  // rve/stepper.hpp

struct Model {
  std::vector<Material> materials;
  ContactLaw law;
  std::vector<PairLaw> pairs;   // row a * materials + b
  MotionSettings motion;        // its `damping` is set by the step loop, from the column below
  std::vector<double> damping;  // by material
  Numerics numerics;
  std::uint64_t seed = 1;
  bool split_statistics = false;
  bool records_bonds = false;  // when and where each breaks
  const Stepper* stepper = &explicit_stepper;
  // Hears of the state in which grains give way, and how they will.
  std::function<void(const State&, std::span<const Break>)> before_breaks = {};

  /// Contacts deeper than this end a run: 0.2, far beyond Hertz's range; 2 where grains break: small fragments that may
  /// not break again are pressed into their neighbours, up to 1.25 of their radius at 45 % of strain (docs/studies).
  double overlap_limit() const { return numerics.max_overlap.value_or(breakable() ? 2 : 0.2); }

  /// The springs that some pair needs; the first is always kept.
  SpringSet springs() const {
    SpringSet some{true};
    for (const PairLaw& p : pairs)
      for (const SpringRow row : couple_springs) some[row] = some[row] || p.friction[row] > 0;
    return some;
  }
  bool reshapes() const {
    for (const auto& m : materials)
      if (m.fracture && m.fracture->transition) return true;
    return swells();
  }
  bool swells() const {
    for (const auto& m : materials)
      if (m.swells()) return true;
    return false;
  }
  bool has_balls() const {
    for (const auto& m : materials)
      if (m.balls()) return true;
    return false;
  }
  bool tests_cracks() const {
    for (const auto& m : materials)
      if (m.fracture && m.fracture->cracks) return true;
    return false;
  }
  bool breakable() const {
    for (const auto& m : materials)
      if (m.fracture) return true;
    return false;
  }
};

/// Fills model.pairs and model.damping from the materials: the friction of a pair is the smaller one, so is its rolling
/// friction, its restitution the mean. A rigid partner (infinite modulus) takes the other's restitution, and its own
/// friction wins unless it is NaN.
void make_pair_laws(Model& model);

/// Renews the friction of the pairs and the damping alone, once these have changed in the materials.
void renew_friction(Model& model);

/// The same local damping for the grains of all materials.
void set_damping(Model& model, double damping);

}  // namespace grus::dem
