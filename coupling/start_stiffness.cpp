// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/start_stiffness.hpp"

#include "dem/base/error.hpp"
#include "dem/rve/linear_response.hpp"

namespace grus::coupling {

std::vector<std::array<double, 36>> start_stiffness(const dem::Model& model, const std::vector<dem::State>& states,
                                                    std::span<const std::size_t> start) {
  std::vector<std::array<double, 36>> of_states(states.size()), of_points;
  std::vector<std::uint8_t> wanted(states.size(), 0);
  for (const std::size_t s : start) wanted.at(s) = 1;
  for (std::size_t s = 0; s < states.size(); ++s) {
    if (wanted[s] == 0) continue;
    const dem::Mat6 tangent = dem::network_tangent(model, states[s]), even = 0.5 * (tangent + tangent.transpose());
    if (!(even.trace() > 0))
      throw dem::InputError("the RVEs have no stiffness at the start; give their scene a [preparation]");
    for (std::size_t k = 0; k < 36; ++k)
      of_states[s][k] = even(static_cast<Eigen::Index>(k / 6), static_cast<Eigen::Index>(k % 6));
  }
  for (const std::size_t s : start) of_points.push_back(of_states[s]);
  return of_points;
}

}  // namespace grus::coupling
