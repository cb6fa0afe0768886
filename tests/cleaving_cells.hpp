// SPDX-License-Identifier: LGPL-3.0-or-later
// Rock that cleaves, and cells of it that are crushed.
#pragma once

#include "dem/fracture/cleavage.hpp"
#include "dem/io/archive.hpp"
#include "tests/bonded.hpp"
#include "tests/held_grains.hpp"

namespace grus::dem::test {

inline constexpr double flaw = 1e-2, toughness = 2e5;  // m, Pa m^1/2
inline const double strength = toughness / std::sqrt(pi * flaw);

inline FractureModel cleaving(bool cohesive, std::vector<Cleavage::Plane> planes = {}) {
  FractureModel f;
  Cleavage c;
  c.toughness = toughness, c.flaw = flaw, c.planes = std::move(planes);
  if (!c.planes.empty()) f.crystal = Crystal{Vec3::UnitZ(), {0.0}};
  f.criteria.emplace_back(std::move(c));
  f.splitter = Cut{cohesive, 50};
  return f;
}

inline Model cleaving_rock(bool cohesive, std::vector<Cleavage::Plane> planes = {},
                           const BondModel& bond = elastic(0.4)) {
  Model model = rock(bond, 0.5);
  model.materials[0].fracture = cleaving(cohesive, std::move(planes));
  make_pair_laws(model);
  return model;
}

/// Cells that cleave while they are compressed; what of them there is after some steps.
inline State crushed(const Model& model, int threads, std::uint64_t steps, bool saved = false) {
  Team team(threads);
  State s = deforming_cube(model, 40, 30, team);
  for (std::uint64_t done = 0; done < steps;) {
    if (saved && done > steps / 2) {
      s = state_of(bytes_of(s)), saved = false;
    }
    update_time_step(model, s);
    done += run_steps(model, s, std::min<std::uint64_t>(50, steps - done), team);
  }
  return s;
}

}  // namespace grus::dem::test
