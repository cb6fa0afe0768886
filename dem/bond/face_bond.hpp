// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds of shared faces: an elastic foundation between two Voronoi cells that gives way by one of three criteria
// (Galindo-Torres et al. 2012, made total and given an energy).
//   cohesive    softens from sigma_t, s = c + tan phi <-sigma> to nothing; takes exactly G A, whatever the mix of
//               opening and shear
//   strain_sum  (<w_n> + |w_t|) / (h e) + |theta| / theta_max > 1 (their eq. 15, opening alone); breaks at once
//   parallel    largest tension or shear of the rim beyond its strength; breaks at once
//   rod         the same of a round rod between two spheres, which is beside their contact: all that it held is gone
// A face that bends is parted by the line where it neither opens nor presses. Of the open part damage D leaves 1 - D;
// what is pressed keeps all of its stiffness at any damage, and rubs: potential k_n / 2 (integral of (1 - D) <g>^2 +
// <-g>^2), g the opening, exact for the polygon. At D = 1 that is the energy of the contact that goes on.
#pragma once

#include "dem/bond/bonds.hpp"
#include "dem/bond/faces.hpp"

namespace grus::dem {

inline bool broken(const FaceBond& s) { return s.damage >= 1; }
inline double dissipated(const FaceBond& s) { return s.spent; }
inline double rubbed(const FaceBond& s) { return s.rubbed; }
inline double energy(const FaceBond& s) { return s.held; }

/// The stiffness now; that of a damaged face that is partly pressed leaves out what a shift does to the couple.
BondStiffness stiffness(const FaceBond& s, const BondFrame& at, const FaceOutline& outline);
BondStiffness stiffest(const FaceBond& s, const Quat& a);

Pull pull(FaceBond& s, const BondFrame& at, const FaceOutline& outline);

/// The same of a face glued to a plate, b, which never gives way. Opening and slip are along the plate's axes, and the
/// plate's force is where the face is: a plate that holds by the normal alone has no part along itself, whatever
/// slides.
Pull pull_of_plate(FaceBond& s, const BondFrame& at);

/// A fresh bond, at rest where it is, carries a force on b (N) and a couple (N m; axes e1, e2, normal) from now on, and
/// gives way from there. It is made stiffer where it would hold more than half of its energy, up to four times: beyond
/// that it is broken at once (false).
bool bear(FaceBond& s, const Vec3& force, const Vec3& couple, const FaceOutline& outline);

/// A broken bond as it is handed over to a contact, where its grains are as it breaks.
Handed handed_by(const FaceBond& s, const BondFrame& at, const FaceOutline& outline);

/// Largest tension that lets a bond soften at all: beyond it, it would give less energy back than it holds (Pa).
double softening_limit(double kn, double energy);

}  // namespace grus::dem
