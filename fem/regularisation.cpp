// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/regularisation.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "fem/problem_impl.hpp"
#include "fem/stretch_average.hpp"

namespace grus::fem {
namespace {

using Mat3 = Eigen::Matrix3d;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// A tensor's components xx yy zz yz xz xy, none doubled; and back.
Vec6 components(const Mat3& t) { return {t(0, 0), t(1, 1), t(2, 2), t(1, 2), t(0, 2), t(0, 1)}; }

Mat3 tensor(const double* t) {
  Mat3 m;
  m << t[0], t[5], t[4], t[5], t[1], t[3], t[4], t[3], t[2];
  return m;
}

/// exp(e) of a symmetric tensor: by its series where that is exact to the last digit.
Mat3 exponential(const Mat3& e) {
  if (e.squaredNorm() < 1e-4) {
    const Mat3 e2 = e * e;
    return Mat3::Identity() + e + e2 / 2 + e2 * e / 6 + e2 * e2 / 24 + e2 * e2 * e / 120 + e2 * e2 * e2 / 720;
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> by(e);
  return by.eigenvectors() * by.eigenvalues().array().exp().matrix().asDiagonal() * by.eigenvectors().transpose();
}

/// log(U) of F = R U; small strains keep their digits.
Mat3 logarithmic(const Mat3& f) {
  const Mat3 h = f - Mat3::Identity(), d = h + h.transpose() + h.transpose() * h;  // U^2 - 1
  if (d.squaredNorm() < 1e-5) {
    const Mat3 d2 = d * d;
    return 0.5 * (d - d2 / 2 + d2 * d / 3 - d2 * d2 / 4 + d2 * d2 * d / 5 - d2 * d2 * d2 / 6);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> by(Mat3::Identity() + d);
  return 0.5 * by.eigenvectors() * by.eigenvalues().array().log().matrix().asDiagonal() * by.eigenvectors().transpose();
}

/// All that a point keeps: doubles and nothing else.
struct Kept {
  Eigen::Vector4d turn{0, 0, 0, 1};                // since the start: a quaternion, x y z w
  Vec6 rest = Vec6::Zero();                        // stress of what was left out, in the frame of the start (Pa)
  Vec6 told = Vec6::Zero();                        // the material's stress (Pa)
  double volume = 1, told_volume = 1, energy = 0;  // over the start's: the point's, and as told; taken (J/m^3)
};

void check_finite(const std::vector<double>& numbers) {
  if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument("the saved regularisation is damaged");
}

Mat3 matrix_of(const Eigen::Vector4d& turn) { return Eigen::Quaterniond(turn).toRotationMatrix(); }

/// R of F = R exp(E), and the stretches of an increment: the point's, and what the material is told.
struct Increment {
  Mat3 turn, own, told;
};

}  // namespace

struct RegularisedMaterial::Impl {
  Problem::Impl& problem;
  fem::Material inner;
  StretchAverage average;
  std::vector<Mat6> stiffness;
  std::vector<double> volumes;  // m^3 of the reference
  double memory, worst = 0;
  std::vector<Kept> committed, trial;
  std::vector<Increment> now;
  std::vector<double> stretch, mean, deformation;

  Impl(Problem& of, fem::Material material, const std::vector<std::size_t>& points, const Regularisation& by)
      : problem(of.impl()), inner(std::move(material)), average(of, points, by.length), memory(by.memory) {
    for (const std::size_t i : points) volumes.push_back(of.point_volume(i));
    committed.resize(points.size()), now.resize(points.size());
    trial = committed;
    stretch.resize(6 * points.size()), mean = stretch, deformation.resize(9 * points.size());
  }

  std::size_t bytes() const { return committed.size() * sizeof(Kept) + sizeof(double); }
  void tell(const Points& p);
  Kept answer(std::size_t i, const Vec6& told) const;
  bool respond(const Points& p);
};

/// What the material is told instead of each point's own increment.
void RegularisedMaterial::Impl::tell(const Points& p) {
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Mat3 f = Eigen::Map<const RowMat3>(p.deformation.data() + 9 * i);
    now[i].own = logarithmic(f);
    now[i].turn = f * exponential(-now[i].own);
    Eigen::Map<Vec6>(stretch.data() + 6 * i) = components(now[i].own);
  }
  if (average(stretch, mean, !p.tangent.empty())) worst = std::max(worst, average.left_over());
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i].told = tensor(mean.data() + 6 * i);
    Eigen::Map<RowMat3>(deformation.data() + 9 * i) = now[i].turn * exponential(now[i].told);
  }
}

/// A point after the increment that `now` holds, to which the material has answered `told`.
Kept RegularisedMaterial::Impl::answer(std::size_t i, const Vec6& told) const {
  const Kept& before = committed[i];
  const Increment& by = now[i];
  Kept after = before;
  const Mat3 frame = matrix_of(before.turn);
  Vec6 left_out = components(frame.transpose() * (by.own - by.told) * frame);
  left_out.tail<3>() *= 2;
  // By what the material hears: a point that strains more than its neighbours is held the more, not forgotten the
  // sooner, and what all points give and take in a steady flow cancels.
  const double forgotten = by.told.norm() / memory;
  // Exact for a stretch that goes on as it does within the increment.
  const double share = forgotten > 1e-8 ? -std::expm1(-forgotten) / forgotten : 1 - 0.5 * forgotten;
  after.rest = std::exp(-forgotten) * before.rest + share * (stiffness[i] * left_out);
  after.turn = Eigen::Quaterniond(Mat3(by.turn * frame)).normalized().coeffs();
  after.told = told;
  after.volume *= std::exp(by.own.trace()), after.told_volume *= std::exp(by.told.trace());
  // Both stresses in the frame from which the increment sets out, by the trapezoidal rule.
  const Mat3 last = tensor(before.told.data()), next = by.turn.transpose() * tensor(told.data()) * by.turn;
  const Mat3 last_rest = frame * tensor(before.rest.data()) * frame.transpose(),
             next_rest = frame * tensor(after.rest.data()) * frame.transpose();
  const Mat3 own = before.volume * (last + last_rest) + after.volume * (next + next_rest),
             heard = before.told_volume * last + after.told_volume * next;
  after.energy += 0.5 * (own.cwiseProduct(by.own).sum() - heard.cwiseProduct(by.told).sum());
  return after;
}

bool RegularisedMaterial::Impl::respond(const Points& p) {
  tell(p);
  if (!inner.respond({deformation, p.stress, p.tangent, p.duration})) return false;
  for (std::size_t i = 0; i < now.size(); ++i) {
    Eigen::Map<Vec6> stress(p.stress.data() + 6 * i);
    trial[i] = answer(i, stress);
    const Mat3 frame = matrix_of(trial[i].turn);
    stress += components(frame * tensor(trial[i].rest.data()) * frame.transpose());
  }
  return true;
}

RegularisedMaterial::RegularisedMaterial(Problem& problem, fem::Material material,
                                         const std::vector<std::size_t>& points,
                                         const std::vector<std::array<double, 36>>& stiffness, const Regularisation& by)
    : impl_(std::make_unique<Impl>(problem, std::move(material), points, by)) {
  for (const auto& c : stiffness) impl_->stiffness.emplace_back(Eigen::Map<const Mat6>(c.data()));
}
RegularisedMaterial::~RegularisedMaterial() = default;

fem::Material RegularisedMaterial::material() {
  fem::Material m = impl_->inner;
  m.respond = [this](const Points& p) { return impl_->respond(p); };
  m.commit = [this] {
    impl_->inner.commit();
    impl_->committed = impl_->trial;
  };
  m.save = [this] {
    const std::string own = save();
    return own + impl_->inner.save();
  };
  m.load = [this](const std::string& bytes) {
    const std::size_t own = std::min(impl_->bytes(), bytes.size());
    load(bytes.substr(0, own));
    impl_->inner.load(bytes.substr(own));
  };
  m.energy = [this](std::span<const double> volumes) { return impl_->inner.energy(volumes) + energy(); };
  if (m.energies)
    m.energies = [this](std::span<const double> volumes, std::span<double> energies) {
      impl_->inner.energies(volumes, energies);
      for (std::size_t i = 0; i < energies.size(); ++i) energies[i] += impl_->volumes[i] * impl_->committed[i].energy;
    };
  return m;
}

double RegularisedMaterial::energy() const {
  return impl_->problem.sums<1>([&](auto& sum) {
    for (std::size_t i = 0; i < impl_->volumes.size(); ++i) sum[0] += impl_->volumes[i] * impl_->committed[i].energy;
  })[0];
}

std::string RegularisedMaterial::save_point(std::size_t i) const {
  return {reinterpret_cast<const char*>(&impl_->committed.at(i)), sizeof(Kept)};
}

std::size_t RegularisedMaterial::load_point(std::size_t i, const std::string& bytes) {
  std::vector<double> numbers(sizeof(Kept) / sizeof(double));
  if (bytes.size() < sizeof(Kept)) throw std::invalid_argument("the saved regularisation is of another problem");
  std::memcpy(numbers.data(), bytes.data(), sizeof(Kept));
  check_finite(numbers);
  std::memcpy(static_cast<void*>(&impl_->committed.at(i)), bytes.data(), sizeof(Kept));
  return sizeof(Kept);
}

std::string RegularisedMaterial::save() const {
  std::string bytes(reinterpret_cast<const char*>(impl_->committed.data()), impl_->committed.size() * sizeof(Kept));
  return bytes.append(reinterpret_cast<const char*>(&impl_->worst), sizeof impl_->worst);
}

void RegularisedMaterial::load(const std::string& bytes) {
  static_assert(sizeof(Kept) % sizeof(double) == 0);
  if (bytes.size() != impl_->bytes()) throw std::invalid_argument("the saved regularisation is of another problem");
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  check_finite(numbers);
  std::memcpy(static_cast<void*>(impl_->committed.data()), bytes.data(), bytes.size() - sizeof(double));
  impl_->worst = numbers.back();
}

int RegularisedMaterial::degree() const { return impl_->average.degree(); }
double RegularisedMaterial::worst_left_over() const { return impl_->worst; }
void RegularisedMaterial::go_on_from(double worst) { impl_->worst = worst; }

}  // namespace grus::fem
