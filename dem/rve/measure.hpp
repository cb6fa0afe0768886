// SPDX-License-Identifier: LGPL-3.0-or-later
// Measures of the material that a state is: stress, density, fabric, quality of equilibrium.
#pragma once

#include <vector>

#include "dem/base/parallel.hpp"
#include "dem/contact/deepest_contact.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

struct Measurement {
  double volume = 0;                // m^3 of the cell, or between the walls of a box; 0: neither
  Mat3 stress = Mat3::Zero();       // Love-Weber, tension-positive (Pa)
  Mat3 wall_stress = Mat3::Zero();  // force / area of the box's walls, tension-positive (Pa); diagonal
  Mat3 fabric = Mat3::Zero();       // mean of n (x) n over contacts
  double solid_fraction = 0, void_ratio = 0;
  double coordination = 0;  // touching contacts a grain, walls included
  std::size_t contacts = 0;
  double unbalanced_force = 0;      // mean |resultant on a grain| / mean |contact force|; 0 without contacts
  double kinetic = 0, elastic = 0;  // J; elastic includes springs
};

Measurement measure(const Model& model, const State& state);

/// Measures that a row of results asks for besides, all in one pass over the contacts and one over the grains.
struct Survey : Measurement {
  DeepestContact deepest;
  /// Standard error of the mean pressure of this sample, relative to it, if its grains were independent draws: each
  /// grain's share of the stress is half of what its contacts carry. Force chains make the true scatter larger,
  /// equilibrium with the boundary smaller (docs/studies: cell size). 0 without pressure.
  double pressure_scatter = 0;
};
/// Room that one survey leaves to the next.
struct SurveyRoom {
  std::vector<double> carried, share;  // by contact, by grain
};
Survey survey(const Model& model, const State& state, Team& team, SurveyRoom& room);

/// Branch of pair k: from the centre of a to that of b, images included (m); of a contact with a wall the arm to it; of
/// one with a grain of a rough wall to the plane that the grain stands for.
Vec3 branch(const State& state, std::size_t pair);

/// Strain -> relative displacement across a branch: column e is eps_e * l for a unit strain (engineering shear).
Eigen::Matrix<double, 3, 6> displacement_of_strain(const Vec3& branch);

/// Love-Weber stress alone (Pa): -(1/V) sum of sym(force on b (x) branch from a to b, images included).
Mat3 love_weber(const State& state, double volume);

/// The Love-Weber stress of a periodic cell in two parts (Pa): what would be left at rest, and what contact dashpots
/// carry.
struct PartedStress {
  Mat3 rest = Mat3::Zero(), dashpots = Mat3::Zero();
};
PartedStress parted_stress(const State& state);

/// Stresses along the axes (Pa, tension-positive): of a periodic cell Love-Weber's, of a box its walls'.
Vec3 normal_stresses(const State& state);

double bulk_volume(const Boundary& boundary);

/// Voids over solids, by volume, of cell or box.
double void_ratio(const State& state);

/// Rate x mean diameter x sqrt(density / pressure).
double inertial_number(const State& state, double strain_rate, double pressure);

double mean_diameter(const Grains& grains);

/// Contact-stiffness tangent (Voigt bound, full tangential projector): C_ijkl = (1/V) sum of
/// k_n n_i l_j n_k l_l + k_t (delta_ik - n_i n_k) l_j l_l, minor symmetries by symmetrising; contacts at the Coulomb
/// limit without k_t. Pa, Voigt order with engineering shear.
Mat6 contact_stiffness_tangent(const Model& model, const State& state);

/// By axis, the stress that the dashpots of the contacts add for each 1/s of strain rate along it (Pa s), were grains
/// to move with the cell: (1/V) sum of c n_k^2 l_k^2, c = dashpot x sqrt(m* k_n), m* of both whole masses, which is
/// most.
Vec3 contact_viscosity(const Model& model, const State& state);

}  // namespace grus::dem
