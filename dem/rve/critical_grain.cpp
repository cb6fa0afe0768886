// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/critical_grain.hpp"

#include "dem/motion/critical_step.hpp"

namespace grus::dem {

CriticalGrain critical_grain(const Model& model, const State& s) {
  Team alone(1);
  const HeldGrains held(model.law, model.pairs, model.materials.size(), s.grains, s.boundary, s.contacts, s.bonds, 0,
                        alone);
  const CriticalStep step = critical_step(held, model.numerics.inertia_step > 0);
  const Extent& e = s.grains.extent[step.grain];
  return {s.grains.id[step.grain], 2 * e.equivalent_radius, e.least_width, share_of_turning(held, step)};
}

}  // namespace grus::dem
