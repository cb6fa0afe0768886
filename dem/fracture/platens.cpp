// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/platens.hpp"

#include "dem/base/error.hpp"
#include "dem/fracture/crack_run.hpp"

namespace grus::dem {
namespace {

/// The k-th bracket of forces begins here: 1.1^k / 2.
double bracket(int k) {
  double low = 0.5;
  for (; k > 0; --k) low *= 1.1;
  for (; k < 0; ++k) low /= 1.1;
  return low;
}

}  // namespace

double platen_number(const LatticeModel& model, int lattices) {
  // No crack run settles what is left open. What holds does no more than 1.1 times the work of the intact sphere.
  constexpr HoldLimits patient{.rounds = 2000, .work = 1e9, .failed = 1.3};
  const std::vector<PatchLoad> pressed{{Vec3(0, 0, 0.5), Vec3(0, 0, -1)}, {Vec3(0, 0, -0.5), Vec3(0, 0, 1)}};
  double sum = 0;
  int at = 2;  // of brackets: where the last lattice failed
  for (int k = 0; k < lattices; ++k) {
    const PointLattice lattice = make_lattice(lattice_sphere(0.5), model.lattice, 1, static_cast<std::uint64_t>(k));
    if (lattice.size() == 0) throw InputError("a sphere's lattice has too few points");
    PeridynamicSolid solid(lattice, model.poissons_ratio);
    if (model.keep_patches) solid.keep(points_near(lattice, pressed, model.lattice.patch));
    const PointColumns load = columns_of(point_forces(lattice, pressed, model.lattice.patch, 1));
    PointColumns whole(lattice.size()), part = load, u = load;
    long sweeps = 0;
    solve(solid, load, whole, 1e-5, 500, sweeps);
    const auto holds = [&](double force) {
      for (std::size_t c = 0; c < u.size(); ++c) part[c] = force * load[c], u[c] = force * whole[c];
      solid.mend();
      return hold_test(solid, part, u, patient).holds();
    };
    // Ends of a bracket are asked last, where all between them say the same.
    for (bool held = false, failed = false;;) {
      double low = bracket(at), high = bracket(at + 1);
      while (high > 1.01 * low) {
        const double middle = std::sqrt(low * high);
        if (holds(middle))
          low = middle, held = true;
        else
          high = middle, failed = true;
      }
      if (!held && !holds(low))
        failed = true, --at;
      else if (!failed && holds(high))
        held = true, ++at;
      else {
        sum += std::sqrt(low * high) / lattices;
        break;
      }
    }
  }
  return sum;
}

}  // namespace grus::dem
