// SPDX-License-Identifier: LGPL-3.0-or-later
// A neo-Hookean solid for tests: energy, stress and tangent in closed form, exact in large strain.
#pragma once

#include <Eigen/Dense>
#include <memory>

#include "fem/material.hpp"

namespace grus::fem::test {

/// w = mu/2 (tr FF^T - 3) - mu ln J + lambda/2 (ln J)^2; `told` multiplies the energy it tells (1: the truth).
inline Material hyperelastic(std::size_t points, double mu, double lambda, double told = 1) {
  using Row = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  struct State {
    std::vector<Eigen::Matrix3d> committed, trial;
  };
  auto state = std::make_shared<State>();
  state->committed.assign(points, Eigen::Matrix3d::Identity());
  state->trial = state->committed;
  const auto respond = [=](const Points& p) {
    for (std::size_t i = 0; i < points; ++i) {
      const Eigen::Matrix3d f = Eigen::Map<const Row>(p.deformation.data() + 9 * i) * state->committed[i];
      state->trial[i] = f;
      const double J = f.determinant();
      const Eigen::Matrix3d s = (mu * (f * f.transpose() - Eigen::Matrix3d::Identity()) +
                                 lambda * std::log(J) * Eigen::Matrix3d::Identity()) /
                                J;
      const double voigt[6] = {s(0, 0), s(1, 1), s(2, 2), s(1, 2), s(0, 2), s(0, 1)};
      std::copy_n(voigt, 6, p.stress.data() + 6 * i);
      if (p.tangent.empty()) continue;
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> c(p.tangent.data() + 36 * i);
      c.setZero();
      c.topLeftCorner<3, 3>().setConstant(lambda / J);
      const double shear = (mu - lambda * std::log(J)) / J;
      for (int k = 0; k < 3; ++k) c(k, k) += 2 * shear, c(k + 3, k + 3) = shear;
    }
    return true;
  };
  const auto energy = [=](std::span<const double> volumes) {
    double sum = 0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
      const Eigen::Matrix3d& f = state->committed[i];
      const double log_J = std::log(f.determinant());
      sum += volumes[i] * (0.5 * mu * (f.squaredNorm() - 3) - mu * log_J + 0.5 * lambda * log_J * log_J);
    }
    return told * sum;
  };
  return {respond, [=] { state->committed = state->trial; },
          [=] {
            return std::string(reinterpret_cast<const char*>(state->committed.data()),
                               points * sizeof(Eigen::Matrix3d));
          },
          [=](const std::string& bytes) {
            std::memcpy(static_cast<void*>(state->committed.data()), bytes.data(), bytes.size());
          },
          energy};
}

}  // namespace grus::fem::test
