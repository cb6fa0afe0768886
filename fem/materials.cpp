// SPDX-License-Identifier: LGPL-3.0-or-later
#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <stdexcept>
#include <vector>

#include "fem/material.hpp"

namespace grus::fem {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

Mat6 elasticity(double E, double nu) {
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  Mat6 c = Mat6::Zero();
  c.topLeftCorner<3, 3>().setConstant(lambda);
  for (int k = 0; k < 3; ++k) c(k, k) += 2 * mu, c(k + 3, k + 3) = mu;
  return c;
}

/// Strain of the increment, engineering shear.
Vec6 strain(const double* f) {
  Vec6 e;
  e << f[0] - 1, f[4] - 1, f[8] - 1, f[5] + f[7], f[2] + f[6], f[1] + f[3];
  return e;
}

struct PlasticPoint {
  Vec6 strain = Vec6::Zero(), plastic = Vec6::Zero();
  double hardening = 0;  // accumulated plastic strain
};

struct PlasticState {
  std::vector<PlasticPoint> committed, trial;
};

}  // namespace

Material elastic_material(std::size_t points, double E, double nu) {
  auto state = std::make_shared<PlasticState>();
  state->committed.resize(points);
  state->trial.resize(points);
  const Mat6 c = elasticity(E, nu);
  Material m;
  m.respond = [state, c](const Points& p) {
    for (std::size_t i = 0; i < state->committed.size(); ++i) {
      const Vec6 e = state->committed[i].strain + strain(p.deformation.data() + 9 * i);
      state->trial[i].strain = e;
      Eigen::Map<Vec6>(p.stress.data() + 6 * i) = c * e;
      if (!p.tangent.empty()) Eigen::Map<Mat6>(p.tangent.data() + 36 * i) = c;
    }
    return true;
  };
  m.commit = [state] { state->committed = state->trial; };
  m.save = [state] {
    std::vector<double> v;
    for (const auto& p : state->committed) v.insert(v.end(), p.strain.begin(), p.strain.end());
    return v;
  };
  m.load = [state](const std::vector<double>& v) {
    if (v.size() != 6 * state->committed.size()) throw std::invalid_argument("the saved material is of another problem");
    for (std::size_t i = 0; i < state->committed.size(); ++i) state->committed[i].strain = Eigen::Map<const Vec6>(v.data() + 6 * i);
  };
  return m;
}

Material j2_material(std::size_t points, double E, double nu, double yield, double hardening) {
  auto state = std::make_shared<PlasticState>();
  state->committed.resize(points);
  state->trial.resize(points);
  const Mat6 c = elasticity(E, nu);
  const double mu = E / (2 * (1 + nu)), bulk = E / (3 * (1 - 2 * nu));
  Material m;
  m.respond = [=](const Points& p) {
    for (std::size_t i = 0; i < state->committed.size(); ++i) {
      PlasticPoint now = state->committed[i];
      now.strain += strain(p.deformation.data() + 9 * i);
      Eigen::Map<Vec6> stress(p.stress.data() + 6 * i);
      Mat6 tangent = c;
      stress = c * (now.strain - now.plastic);
      Vec6 s = stress;
      s.head<3>().array() -= stress.head<3>().sum() / 3;
      const double norm = std::sqrt(s.head<3>().squaredNorm() + 2 * s.tail<3>().squaredNorm()), mises = std::sqrt(1.5) * norm;
      const double over = mises - (yield + hardening * now.hardening);
      if (over > 0) {
        const double step = over / (3 * mu + hardening);
        const Vec6 n = s / norm;  // tensor components
        Vec6 flow = std::sqrt(1.5) * n;
        flow.tail<3>() *= 2;  // engineering shear
        now.plastic += step * flow;
        now.hardening += step;
        stress -= 2 * mu * std::sqrt(1.5) * step * n;
        const double theta = 1 - 3 * mu * step / mises, bar = 3 * mu / (3 * mu + hardening) - (1 - theta);
        Mat6 deviator = Mat6::Zero();
        deviator.topLeftCorner<3, 3>().setConstant(-1.0 / 3);
        for (int k = 0; k < 3; ++k) deviator(k, k) += 1, deviator(k + 3, k + 3) = 0.5;
        tangent = 2 * mu * theta * deviator - 2 * mu * bar * n * n.transpose();
        tangent.topLeftCorner<3, 3>().array() += bulk;
      }
      if (!p.tangent.empty()) Eigen::Map<Mat6>(p.tangent.data() + 36 * i) = tangent;
      state->trial[i] = now;
    }
    return true;
  };
  m.commit = [state] { state->committed = state->trial; };
  return m;
}

Material composite_material(std::vector<Material> parts, const std::vector<std::size_t>& group) {
  struct Part {
    Material material;
    std::vector<std::size_t> points;
    std::vector<double> deformation, stress, tangent;
  };
  auto all = std::make_shared<std::vector<Part>>();
  for (auto& m : parts) all->push_back({std::move(m), {}, {}, {}, {}});
  for (std::size_t i = 0; i < group.size(); ++i) (*all)[group[i]].points.push_back(i);
  auto failed = std::make_shared<std::string>();
  Material m;
  m.respond = [all, failed](const Points& p) {
    bool good = true;
    for (Part& part : *all) {  // every part answers even if one has failed: parts may be collective
      const std::size_t n = part.points.size();
      part.deformation.resize(9 * n), part.stress.resize(6 * n), part.tangent.resize(p.tangent.empty() ? 0 : 36 * n);
      for (std::size_t i = 0; i < n; ++i) std::copy_n(p.deformation.data() + 9 * part.points[i], 9, part.deformation.data() + 9 * i);
      if (!part.material.respond({part.deformation, part.stress, part.tangent, p.duration})) {
        if (good) *failed = part.material.reason();
        good = false;
      }
      for (std::size_t i = 0; i < n; ++i) {
        std::copy_n(part.stress.data() + 6 * i, 6, p.stress.data() + 6 * part.points[i]);
        if (!p.tangent.empty()) std::copy_n(part.tangent.data() + 36 * i, 36, p.tangent.data() + 36 * part.points[i]);
      }
    }
    return good;
  };
  m.commit = [all] {
    for (Part& part : *all) part.material.commit();
  };
  m.noise = [all] {
    double most = 0;
    for (const Part& part : *all) most = std::max(most, part.material.noise());
    return most;
  };
  m.reason = [failed] { return *failed; };
  return m;
}

}  // namespace grus::fem
