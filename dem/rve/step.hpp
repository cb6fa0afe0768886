// SPDX-License-Identifier: LGPL-3.0-or-later
// Runs of steps; what is done to a state between them, and asked of it.
#pragma once

#include "dem/contact/deepest_contact.hpp"
#include "dem/rve/stepper.hpp"

namespace grus::dem {

/// Changes the rate of the cell; grains get the change of the affine velocity at their place, booked as work.
void set_cell_rate(State& state, const Mat3& rate);

/// Turns everything by a rotation about the origin: the frame changes, nothing else.
void rotate(State& state, const Mat3& rotation);

/// Forces and torques of this instant, of contacts and bonds, with what contacts show. Returns what contacts took,
/// which nobody has booked: springs that exceed their limit now, contacts that have parted.
BlockEnergy refresh_forces(const Model& model, State& state, Team& team);

/// Whether contacts of any two materials rub.
bool grains_rub(const Model& model);

/// Takes the springs along the plane off all contacts: where none rubs any more, nobody looks at them.
void drop_slide_springs(Contacts& contacts);

/// Kinetic, contact and spring energy (J).
double stored_energy(const Model& model, const State& state);

/// Whether enough has been exchanged since the ledger began to measure an error against. Forces that set in (a load, a
/// wall that hits) are not resolved by their first steps: half a kick is all that there is, and the trapezoid of a
/// load that grows from nothing has not begun.
bool exchanged(const State& state);

/// The energy error of rows and results; 0 as long as nothing has been exchanged.
double told_energy_error(const State& state, double stored);

/// Throws Unstable if the overlap or energy error has passed the model's bounds, or a number is not finite.
void check_sanity(const Model& model, const State& state);
/// The same where the stored energy (J) and the deepest contact are known.
void check_sanity(const Model& model, const State& state, double stored, const DeepestContact& deepest);

}  // namespace grus::dem
