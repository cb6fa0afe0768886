// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/platens.hpp"

#include "dem/base/error.hpp"
#include "dem/fracture/crack_run.hpp"

namespace grus::dem {

double platen_number(const LatticeModel& model, int lattices) {
  constexpr HoldLimits patient{.rounds = 2000, .work = 1e9};  // no crack run settles what is left open
  const std::vector<PatchLoad> pressed{{Vec3(0, 0, 0.5), Vec3(0, 0, -1)}, {Vec3(0, 0, -0.5), Vec3(0, 0, 1)}};
  double sum = 0;
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
    double low = 0.5;
    while (!holds(low)) low /= 1.1;
    double high = 1.1 * low;
    while (holds(high)) low = high, high *= 1.1;
    while (high > 1.01 * low) {
      const double middle = std::sqrt(low * high);
      (holds(middle) ? low : high) = middle;
    }
    sum += std::sqrt(low * high) / lattices;
  }
  return sum;
}

}  // namespace grus::dem
