// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/tangent.hpp"

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"

namespace grus::dem {

Mat6 perturbation_tangent(const Model& model, const QuasiStatic& options, const State& state, double strain,
                          bool central, std::uint64_t& steps, Team& team, const std::function<void()>& told) {
  const Vec6 base = to_voigt(love_weber(state, state.boundary.cell.volume()));
  const int sides = central ? 2 : 1;
  std::vector<Vec6> stress(static_cast<std::size_t>(6 * sides));
  std::vector<std::uint8_t> rested(stress.size(), 0);
  std::vector<std::uint64_t> spent(stress.size(), 0);
  team.each(stress.size(), [&](std::size_t job) {
    Team alone(1);
    Vec6 unit = Vec6::Zero();
    const auto column = static_cast<int>(job) / sides;
    unit[column] = column < 3 ? 1 : 0.5;  // tensor component of an engineering strain
    const double signed_strain =
        job % static_cast<std::size_t>(sides) == 0 ? -strain : strain;  // compression first: it keeps contacts
    State scratch = state;
    try {
      const Response r =
          deform(model, options, scratch, {Mat3::Identity() + signed_strain * from_voigt(unit)}, alone, told);
      stress[job] = to_voigt(r.stress), rested[job] = r.stable;
    } catch (const Unstable&) {
    }
    spent[job] = scratch.steps - state.steps;
  });
  for (const auto s : spent) steps += s;
  Mat6 tangent = contact_stiffness_tangent(model, state);
  for (int k = 0; k < 6; ++k) {
    const auto job = static_cast<std::size_t>(sides * k);
    if (!central) {
      if (rested[job]) tangent.col(k) = (base - stress[job]) / strain;
    } else if (rested[job] && rested[job + 1]) {
      tangent.col(k) = (stress[job + 1] - stress[job]) / (2 * strain);
    }
  }
  return tangent;
}

void broyden_update(const Vec6& strain_step, const Vec6& stress_step, Mat6& tangent) {
  const double length2 = strain_step.squaredNorm();
  if (length2 < 1e-24) return;
  tangent += (stress_step - tangent * strain_step) * strain_step.transpose() / length2;
}

}  // namespace grus::dem
