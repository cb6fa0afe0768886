// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/lattice_crack.hpp"

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/fracture/crack_run.hpp"

namespace grus::dem {
namespace {

/// Points whose bonds lie away from all patches, bit by bit.
std::vector<std::uint8_t> core_of(const PointLattice& lattice, std::span<const PatchLoad> loads,
                                  const LatticeModel& model, double diameter) {
  std::vector<std::uint8_t> core(lattice.octet.size() - 1);
  const double horizon = model.lattice.horizon * lattice.spacing * diameter;
  for (std::size_t k = 0; k < core.size(); ++k)
    for (std::uint32_t i = lattice.octet[k].point; i < lattice.octet[k + 1].point; ++i) {
      bool away = true;
      for (const PatchLoad& load : loads)
        away =
            away && (lattice.point[i] - load.at).norm() > patch_radius(load, model.lattice.patch, diameter) + horizon;
      if (away) core[k] = static_cast<std::uint8_t>(core[k] | 1u << (i - lattice.octet[k].point));
    }
  return core;
}

/// `stretch`, `joule`: units of strain and energy; `told`: with displacements and dilations.
CrackedLattice cracked(const PeridynamicSolid& solid, const PointColumns& u, CrackRun& run, double stretch,
                       double joule, double diameter, bool told) {
  const PointLattice& lattice = solid.lattice();
  attach(solid, run.clusters);
  CrackedLattice c;
  c.points = lattice.point, c.piece = std::move(run.clusters.piece), c.damage = damage_of(solid);
  for (std::size_t i = 0; told && i < lattice.size(); ++i) {
    c.moved.push_back(stretch * diameter * (lattice.axes * Vec3(u(i, 0), u(i, 1), u(i, 2))));
    c.dilation.push_back(stretch * solid.dilation(i));
  }
  c.pieces = run.clusters.pieces, c.crumbs = run.clusters.crumbs;
  c.spacing = lattice.spacing * diameter, c.bond_energy = joule * run.lost;
  return c;
}

}  // namespace

CrackResult crack_test(const LatticeSolid& solid, std::span<const PatchLoad> loads, const LatticeModel& model,
                       double stretch, std::uint64_t seed, std::uint64_t id) {
  if (!(stretch > 0) || !(model.youngs_modulus > 0))
    throw InputError("a grain's critical stretch and Young's modulus must be above 0");
  CrackResult result;
  const PointLattice lattice = make_lattice(solid, model.lattice, seed, id);
  if (lattice.size() == 0) return result;
  result.points = static_cast<int>(lattice.size());
  // At one fracture energy a finer lattice breaks at the larger stretch.
  const double d = solid.diameter(), limit = stretch * std::sqrt(lattice.nominal_spacing / lattice.spacing);
  const double newton = model.youngs_modulus * d * d * limit;
  const PointColumns load = columns_of(point_forces(lattice, loads, model.lattice.patch, d), 1 / newton);
  PointColumns u(lattice.size());
  PeridynamicSolid body(lattice, model.poissons_ratio);
  if (model.keep_patches) body.keep(points_near(lattice, loads, model.lattice.patch * d));
  long sweeps = 0;
  const int took = solve(body, load, u, 1e-5, 500, sweeps);
  result.solves = 1, result.iterations = static_cast<int>(sweeps);
  if (took < 0) return result;
  body.dilate(u);
  result.core_stretch = body.largest_stretch(core_of(lattice, loads, model, d));
  if (result.core_stretch < model.core_screen) {
    result.verdict = CrackVerdict::core_holds;
    return result;
  }
  PointColumns at = u;
  HoldTest hold = hold_test(body, load, at);
  const auto count = [&](const HoldTest& test) {
    result.rounds += test.rounds, result.solves += test.solves, result.iterations += test.iterations;
  };
  count(hold);
  if (hold.holds()) {
    result.verdict = CrackVerdict::holds;
    return result;
  }
  double share = 1;
  if (hold.verdict == Hold::fails || hold.work > HoldLimits{}.work) {  // it cracked when its load was first too large
    const LastHold last = last_hold(body, load, u, at);
    count(last.test);
    if (!last.test.holds()) {
      result.verdict = CrackVerdict::stalled;
      return result;
    }
    hold = last.test, share = std::min(1.0, CrackChoice::raise * last.share);
  }
  CrackRun run = crack_run(body, load, at, {model.damping, model.time, model.smallest_piece, model.crumbs}, share);
  run.lost += hold.lost;
  result.steps = run.steps, result.load_factor = run.load_factor;
  result.verdict = run.end == CrackEnd::holds ? CrackVerdict::holds : CrackVerdict::stalled;
  if (run.end != CrackEnd::parts) return result;
  result.verdict = CrackVerdict::cracks;
  result.cracked = cracked(body, at, run, limit, newton * d * limit, d, model.tells_points);
  return result;
}

}  // namespace grus::dem
