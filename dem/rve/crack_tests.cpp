// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/crack_tests.hpp"

#include "dem/fracture/shatter.hpp"

namespace grus::dem {
namespace {

const FractureModel& fracture_of(const Model& model, const State& state, std::size_t i) {
  return *model.materials[state.grains.material[i]].fracture;
}

/// Forces on a grain, in sums.
struct Borne {
  HeldLoad load;
  double largest = 0, forces = 0, moments = 0;  // N, N, N m: the largest, and sums of force and of force x arm
};

Borne borne_by(const LoadedHull& grain) {
  Borne b;
  const Mat3 axes = grain.axes();
  grain.each_load([&](const HullLoad& l) {
    const double force = l.force.norm();
    b.largest = std::max(b.largest, force), b.forces += force, b.moments += force * l.at.norm();
    b.load.moment += (axes.transpose() * l.force) * (axes.transpose() * l.at).transpose();
    ++b.load.contacts;
  });
  return b;
}

/// What a test of one grain has found.
struct Tested {
  CrackVerdict verdict = CrackVerdict::untested;
  double bond_energy = 0;  // J
  std::optional<Pieces> pieces = {};
  std::shared_ptr<const CrackedLattice> lattice = {};
};

Tested test(const Model& model, const State& state, std::size_t i) {
  const FractureModel& fracture = fracture_of(model, state, i);
  CrackResult found = ask_for_cracks(model, state, i);
  Tested out{found.verdict};
  if (found.verdict != CrackVerdict::cracks || !found.cracked) return out;
  const CrackedLattice& cracked = *found.cracked;
  Pieces pieces = pieces_by_labels(std::get<Shatter>(fracture.splitter), state.grains, i, cracked.points, cracked.piece,
                                   static_cast<std::size_t>(cracked.pieces + cracked.crumbs), nullptr,
                                   static_cast<std::size_t>(cracked.crumbs));
  if (pieces.piece.empty()) return {CrackVerdict::stalled};
  out.bond_energy = cracked.bond_energy, out.pieces = std::move(pieces);
  if (fracture.cracks->lattice.tells_points)
    out.lattice = std::make_shared<const CrackedLattice>(std::move(*found.cracked));
  return out;
}

}  // namespace

LoadedHull loaded_hull(const Model& model, const State& state, std::size_t i) {
  const double nu = model.materials[state.grains.material[i]].poissons_ratio;
  return {model.law, nu, state.grains, state.boundary, state.contacts, state.bonds, state.break_room.bonds, i};
}

CrackResult ask_for_cracks(const Model& model, const State& state, std::size_t i) {
  const Grains& g = state.grains;
  const CrackTests& tests = *fracture_of(model, state, i).cracks;
  const LoadedHull grain = loaded_hull(model, state, i);
  const Mat3 back = grain.axes().transpose();
  std::vector<PatchLoad> loads;
  grain.each_load([&](const HullLoad& l) {
    loads.push_back({back * l.at, back * l.force, back * l.couple, l.face.area});
  });
  const LatticeSolid solid = lattice_hull(*g.hulls, g.hull[i]);
  const double stretch = tests.toughness.stretch(tests.lattice.lattice, tests.lattice.youngs_modulus,
                                                 tests.lattice.poissons_ratio, solid.diameter(), g.strength[i]);
  return crack_test(solid, loads, tests.lattice, stretch, model.seed, g.id[i]);
}

bool worth_a_test(const Model& model, const State& state, std::size_t i, double utilisation) {
  const CrackTests& tests = *fracture_of(model, state, i).cracks;
  if (!(utilisation >= tests.force_screen)) return false;
  const Grains& g = state.grains;
  const Borne now = borne_by(loaded_hull(model, state, i));
  const HeldLoad& held = g.held[i];
  if (g.force[i].norm() * now.load.contacts > tests.unbalanced_force * now.forces) return false;
  if (g.torque[i].norm() * now.load.contacts > tests.unbalanced_moment * now.moments) return false;
  return now.load.contacts > held.contacts ||
         (now.load.moment - held.moment).norm() > tests.changed_force * now.largest * g.extent[i].equivalent_radius;
}

std::vector<Break> crack_breaks(const Model& model, State& state, const std::vector<Index>& asked, Team& team) {
  std::vector<Tested> tested(asked.size());
  team.each(asked.size(), [&](std::size_t k) { tested[k] = test(model, state, asked[k]); });
  CrackCounts& counts = state.ledger.cracks;
  std::vector<Break> breaks;
  for (std::size_t k = 0; k < asked.size(); ++k) {
    const Index i = asked[k];
    ++counts.tests;
    counts.bond_energy += tested[k].bond_energy;
    switch (tested[k].verdict) {
      case CrackVerdict::cracks:
        ++counts.cracks;
        breaks.push_back({i, {Mat3::Zero(), std::nullopt}, std::move(tested[k].pieces), std::move(tested[k].lattice)});
        continue;
      case CrackVerdict::core_holds:
      case CrackVerdict::holds:
        ++counts.holds;
        break;
      case CrackVerdict::untested:
      case CrackVerdict::stalled:
        ++counts.stalled;
    }
    state.grains.held[i] = borne_by(loaded_hull(model, state, i)).load;
  }
  return breaks;
}

}  // namespace grus::dem
