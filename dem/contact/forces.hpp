// SPDX-License-Identifier: LGPL-3.0-or-later
// The contact pass: one loop for each bin, forces left per contact; grains add theirs up in a fixed order.
#pragma once

#include <span>

#include "dem/base/parallel.hpp"
#include "dem/contact/laws.hpp"
#include "dem/contact/sleeping_hulls.hpp"
#include "dem/kernel/contact_pass.hpp"
#include "dem/state/boundary.hpp"
#include "dem/state/grains.hpp"
#include "dem/state/ledger.hpp"

namespace grus::dem {

/// One pass over all near pairs at the present positions and half-step velocities: advances contact histories by dt and
/// adds forces and torques to contacts.plan.load, which must be clear. Tiles may be taken in any order by any threads.
/// Dissipation and work of a moving boundary go to contacts.plan.energy, one entry a tile; the work is that of this
/// step's forces over a whole dt, so that a run books half of `boundary_power` for its first and last instant. `shown`:
/// fills contacts.touch for every pair. `sleep`: pairs of hulls sleep as it says; without it all are looked at.
class ContactPass {
public:
  ContactPass(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains, const Boundary& boundary,
              double dt, bool shown, Contacts& contacts, SleepingHulls* sleep = nullptr);
  /// `room`: where the tile's grains collect, one row a grain of the tile; their rows of contacts.plan.load unless said
  /// otherwise.
  void tile(std::size_t t, Load* room = nullptr) const;

private:
  const ContactLaw& law_;
  std::span<const PairLaw> pairs_;
  const Grains& grains_;
  const Boundary& boundary_;
  Contacts& contacts_;
  SleepingHulls* sleep_;
  ContactRows rows_;
};

/// The whole pass.
void contact_forces(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                    const Boundary& boundary, double dt, bool shown, Contacts& contacts, Team& team);

/// Work of moving walls and cell on the contacts in a second, at the forces shown (W).
double boundary_power(const Boundary& boundary, Contacts& contacts);

/// Clears the loads of a contact pass that no sweep has taken.
void drop_loads(Contacts& contacts);

/// Adds up the tiles' energies and clears them.
BlockEnergy flush(Contacts& contacts);

/// Adds what contacts took, and what of their springs' losses is left unexplained.
void book(const BlockEnergy& contacts, Ledger& ledger);

/// Elastic energy of all contacts (J).
double elastic_energy(const ContactLaw& law, const Contacts& contacts);

}  // namespace grus::dem
