// SPDX-License-Identifier: LGPL-3.0-or-later
#include <Eigen/Dense>
#include <algorithm>
#include <cstdint>
#include <cstring>
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

using Mat3 = Eigen::Matrix3d;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};  // Voigt

/// F = R U; strain U - 1, engineering shear.
struct Polar {
  Mat3 rotation;
  Vec6 strain;

  explicit Polar(const Mat3& f) {
    const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    rotation = svd.matrixU() * svd.matrixV().transpose();
    const Mat3 u = rotation.transpose() * f - Mat3::Identity();  // small strains keep their digits
    for (int k = 0; k < 6; ++k) strain[k] = 0.5 * (u(row[k], column[k]) + u(column[k], row[k])) * (k < 3 ? 1 : 2);
  }
};

/// R t R^T of a stress.
Vec6 turned(const Mat3& r, const Vec6& t) {
  Mat3 m;
  for (int k = 0; k < 6; ++k) m(row[k], column[k]) = m(column[k], row[k]) = t[k];
  m = Mat3(r * m * r.transpose());
  Vec6 out;
  for (int k = 0; k < 6; ++k) out[k] = m(row[k], column[k]);
  return out;
}

/// A tangent in the turned frame: Q C Q^T, Q what the turn does to stresses.
Mat6 in_frame(const Mat3& r, const Mat6& tangent) {
  Mat6 q;
  for (int k = 0; k < 6; ++k) q.col(k) = turned(r, Vec6::Unit(k));
  return q * tangent * q.transpose();
}

Vec6 initial_of(const InitialStress& initial, std::size_t i) {
  if (initial.empty()) return Vec6::Zero();
  return Eigen::Map<const Vec6>(initial[i].data());
}

/// A column of plain values, committed and tried.
template <class T>
struct Kept {
  std::vector<T> committed, trial;
  explicit Kept(std::size_t n) : committed(n), trial(n) {}
};

template <class T>
Material material_of(std::shared_ptr<Kept<T>> state, std::function<bool(const Points&)> respond) {
  Material m{std::move(respond), [state] { state->committed = state->trial; },
             [state] {
               return std::string(reinterpret_cast<const char*>(state->committed.data()),
                                  state->committed.size() * sizeof(T));
             },
             [state](const std::string& bytes) {
               if (bytes.size() != state->committed.size() * sizeof(T))
                 throw std::invalid_argument("the saved material is of another problem");
               static_assert(sizeof(T) % sizeof(double) == 0);  // points are doubles and nothing else
               std::vector<double> numbers(bytes.size() / sizeof(double));
               std::memcpy(numbers.data(), bytes.data(), bytes.size());
               if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }))
                 throw std::invalid_argument("the saved material is damaged");
               std::memcpy(static_cast<void*>(state->committed.data()), bytes.data(), bytes.size());
             },
             [state](std::span<const double> volumes) {
               double sum = 0;
               for (std::size_t i = 0; i < volumes.size(); ++i) sum += volumes[i] * state->committed[i].energy;
               return sum;
             }};
  m.energies = [state](std::span<const double> volumes, std::span<double> energies) {
    for (std::size_t i = 0; i < volumes.size(); ++i) energies[i] = volumes[i] * state->committed[i].energy;
  };
  return m;
}

/// An elastic point: F since the start, and energy (J per m^3 of the reference configuration).
struct ElasticPoint {
  Mat3 f = Mat3::Identity();
  double energy = 0;
};

/// A J2 point; plastic strain in the frame of the body before it turned; energy held and spent (J/m^3).
struct PlasticPoint {
  Mat3 f = Mat3::Identity();
  Vec6 plastic = Vec6::Zero();
  double hardening = 0, energy = 0;  // accumulated plastic strain
};

}  // namespace

std::array<double, 36> elastic_stiffness(double youngs_modulus, double poissons_ratio) {
  std::array<double, 36> c;
  Eigen::Map<Mat6>(c.data()) = elasticity(youngs_modulus, poissons_ratio);
  return c;
}

Material elastic_material(std::size_t points, double E, double nu, const InitialStress& initial) {
  auto state = std::make_shared<Kept<ElasticPoint>>(points);
  const Mat6 c = elasticity(E, nu);
  return material_of<ElasticPoint>(state, [state, c, initial](const Points& p) {
    for (std::size_t i = 0; i < state->committed.size(); ++i) {
      const Mat3 f = Eigen::Map<const RowMat3>(p.deformation.data() + 9 * i) * state->committed[i].f;
      const Polar polar(f);
      const Vec6 first = initial_of(initial, i), stress = first + c * polar.strain;
      state->trial[i] = {f, 0.5 * (first + stress).dot(polar.strain)};
      Eigen::Map<Vec6>(p.stress.data() + 6 * i) = turned(polar.rotation, stress);
      if (!p.tangent.empty()) Eigen::Map<Mat6>(p.tangent.data() + 36 * i) = c;
    }
    return true;
  });
}

Material j2_material(std::size_t points, double E, double nu, double yield, double hardening,
                     const InitialStress& initial) {
  auto state = std::make_shared<Kept<PlasticPoint>>(points);
  const Mat6 c = elasticity(E, nu);
  const double mu = E / (2 * (1 + nu)), bulk = E / (3 * (1 - 2 * nu));
  return material_of<PlasticPoint>(state, [=](const Points& p) {
    for (std::size_t i = 0; i < state->committed.size(); ++i) {
      PlasticPoint now = state->committed[i];
      now.f = Eigen::Map<const RowMat3>(p.deformation.data() + 9 * i) * now.f;
      const Polar polar(now.f);
      Mat6 tangent = c;
      const Vec6 first = initial_of(initial, i);
      Vec6 stress = first + c * (polar.strain - now.plastic);
      Vec6 s = stress;
      s.head<3>().array() -= stress.head<3>().sum() / 3;
      const double norm = std::sqrt(s.head<3>().squaredNorm() + 2 * s.tail<3>().squaredNorm()),
                   mises = std::sqrt(1.5) * norm;
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
      now.energy = 0.5 * (first + stress).dot(polar.strain - now.plastic) +
                   (yield + 0.5 * hardening * now.hardening) * now.hardening;
      Eigen::Map<Vec6>(p.stress.data() + 6 * i) = turned(polar.rotation, stress);
      if (!p.tangent.empty()) Eigen::Map<Mat6>(p.tangent.data() + 36 * i) = in_frame(polar.rotation, tangent);
      state->trial[i] = now;
    }
    return true;
  });
}

namespace {

/// Materials side by side, each for points of its own.
struct Composite {
  struct Part {
    Material material;
    std::vector<std::size_t> points;
    std::vector<double> deformation, stress, tangent, volumes, energies;
  };
  std::vector<Part> parts;
  std::vector<double> numbers;  // inertial, of all parts
  std::string failed;

  static bool respond(Part& part, const Points& p) {
    const std::size_t n = part.points.size();
    part.deformation.resize(9 * n);
    part.stress.resize(6 * n);
    part.tangent.resize(p.tangent.empty() ? 0 : 36 * n);
    for (std::size_t i = 0; i < n; ++i)
      std::copy_n(p.deformation.data() + 9 * part.points[i], 9, part.deformation.data() + 9 * i);
    const bool good = part.material.respond({part.deformation, part.stress, part.tangent, p.duration});
    for (std::size_t i = 0; i < n; ++i) {
      std::copy_n(part.stress.data() + 6 * i, 6, p.stress.data() + 6 * part.points[i]);
      if (!p.tangent.empty()) std::copy_n(part.tangent.data() + 36 * i, 36, p.tangent.data() + 36 * part.points[i]);
    }
    return good;
  }

  bool respond(const Points& p) {
    bool good = true;
    for (Part& part : parts)  // every part answers even if one has failed: parts may be collective
      if (!respond(part, p)) {
        if (good) failed = part.material.reason();
        good = false;
      }
    return good;
  }

  std::string save() const {
    std::string bytes;
    for (const Part& part : parts) {
      const std::string own = part.material.save();
      const std::uint64_t size = own.size();
      bytes.append(reinterpret_cast<const char*>(&size), sizeof size), bytes += own;
    }
    return bytes;
  }

  void load(const std::string& bytes) {
    std::size_t at = 0;
    for (Part& part : parts) {
      std::uint64_t size = 0;
      if (bytes.size() - at < sizeof size) throw std::invalid_argument("the saved material is of another problem");
      std::memcpy(&size, bytes.data() + at, sizeof size), at += sizeof size;
      if (bytes.size() - at < size) throw std::invalid_argument("the saved material is of another problem");
      part.material.load(bytes.substr(at, size)), at += size;
    }
  }

  double energy(std::span<const double> volumes) {
    double sum = 0;
    for (Part& part : parts) {
      part.volumes.clear();
      for (const std::size_t i : part.points) part.volumes.push_back(volumes[i]);
      sum += part.material.energy(part.volumes);
    }
    return sum;
  }

  void energies(std::span<const double> volumes, std::span<double> all) {
    for (Part& part : parts) {
      part.volumes.clear();
      for (const std::size_t i : part.points) part.volumes.push_back(volumes[i]);
      part.energies.resize(part.points.size());
      part.material.energies(part.volumes, part.energies);
      for (std::size_t k = 0; k < part.points.size(); ++k) all[part.points[k]] = part.energies[k];
    }
  }

  std::span<const double> inertial_numbers() {
    numbers.clear();
    for (const Part& part : parts) {
      const auto theirs = part.material.inertial_numbers();
      numbers.insert(numbers.end(), theirs.begin(), theirs.end());
    }
    return numbers;
  }

  using Asked = std::function<double()> Material::*;
  double most(Asked of) const {
    double most = 0;
    for (const Part& part : parts) most = std::max(most, (part.material.*of)());
    return most;
  }
};

}  // namespace

Material composite_material(std::vector<Material> parts, const std::vector<std::size_t>& group) {
  auto all = std::make_shared<Composite>();
  for (auto& m : parts) all->parts.push_back({std::move(m), {}, {}, {}, {}, {}, {}});
  for (std::size_t i = 0; i < group.size(); ++i) all->parts[group[i]].points.push_back(i);
  const auto commit = [all] {
    for (auto& part : all->parts) part.material.commit();
  };
  Material m([all](const Points& p) { return all->respond(p); }, commit, [all] { return all->save(); },
             [all](const std::string& bytes) { all->load(bytes); },
             [all](std::span<const double> volumes) { return all->energy(volumes); });
  m.noise = [all] { return all->most(&Material::noise); };
  m.sharpen = [all] {
    bool any = false;
    for (const auto& part : all->parts) any = part.material.sharpen() || any;
    return any;
  };
  m.inertial_number = [all] { return all->most(&Material::inertial_number); };
  m.reason = [all] { return all->failed; };
  if (std::all_of(all->parts.begin(), all->parts.end(), [](const auto& part) { return bool(part.material.energies); }))
    m.energies = [all](std::span<const double> volumes, std::span<double> energies) {
      all->energies(volumes, energies);
    };
  m.inertial_numbers = [all] { return all->inertial_numbers(); };
  return m;
}

}  // namespace grus::fem
