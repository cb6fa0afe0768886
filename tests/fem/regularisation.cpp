// SPDX-License-Identifier: LGPL-3.0-or-later
// A material that is told an average, against closed forms: elastic answers, memory, turns, energy, and a bar that
// softens.
#include "fem/regularisation.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "fem/explicit_statics.hpp"
#include "fem/problem_impl.hpp"
#include "fem/stretch_average.hpp"
#include "tests/fem/boxes.hpp"
#include "tests/helpers.hpp"

namespace grus {  // DOLFINx has a namespace fem, too
namespace {

using fem::ElementKind;
using fem::Kinematics;
using fem::Point;
using fem::test::all_of;
using fem::test::box;
using fem::test::largest_difference;
using fem::test::plane;
using Mat3 = Eigen::Matrix3d;
using Row = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr double pi = 3.14159265358979323846;

/// exp and log of symmetric tensors, by their principal values.
Mat3 exp_of(const Mat3& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> by(m);
  return by.eigenvectors() * by.eigenvalues().array().exp().matrix().asDiagonal() * by.eigenvectors().transpose();
}
Mat3 log_of(const Mat3& m) {
  const Eigen::SelfAdjointEigenSolver<Mat3> by(m);
  return by.eigenvectors() * by.eigenvalues().array().log().matrix().asDiagonal() * by.eigenvectors().transpose();
}

/// Increments whose strain differs from point to point, of this size.
std::vector<Mat3> uneven(const fem::Problem& p, double size) {
  std::vector<Mat3> f;
  for (std::size_t i = 0; i < p.owned_points(); ++i) {
    const Point x = p.point_position(i);
    Mat3 e;
    e << std::sin(3 * x[1]), 0.4 * x[0], 0, 0.4 * x[0], -1 + x[0] * x[1], 0, 0, 0, 0;
    f.push_back(exp_of(size * e));
  }
  return f;
}

struct Answer {
  std::vector<double> deformation, stress;
  explicit Answer(const std::vector<Mat3>& f) : stress(6 * f.size()) {
    for (const Mat3& m : f) {
      const Row row = m;
      deformation.insert(deformation.end(), row.data(), row.data() + 9);
    }
  }
};

std::vector<double> take(fem::Material& m, const std::vector<Mat3>& f) {
  Answer a(f);
  REQUIRE(m.respond({a.deformation, a.stress, {}, 0}));
  m.commit();
  return a.stress;
}

/// A material that bears nothing.
fem::Material nothing() {
  return {[](const fem::Points& p) {
            std::fill(p.stress.begin(), p.stress.end(), 0.0);
            return true;
          },
          [] {}, [] { return std::string(); }, [](const std::string&) {}, [](std::span<const double>) { return 0.0; }};
}

std::vector<std::array<double, 36>> everywhere(const fem::Problem& p, const Mat6& c) {
  std::array<double, 36> rows;
  std::copy_n(c.data(), 36, rows.data());
  return std::vector<std::array<double, 36>>(p.owned_points(), rows);
}

Mat6 isotropic() {
  const auto c = fem::elastic_stiffness(1e8, 0.25);
  return Eigen::Map<const Mat6>(c.data());
}

/// Stiffer along x than along y.
Mat6 layered() {
  Mat6 c = isotropic();
  c(0, 0) *= 2, c(5, 5) *= 1.5;
  return c;
}

Vec6 doubled(const Mat3& t) { return {t(0, 0), t(1, 1), t(2, 2), 2 * t(1, 2), 2 * t(0, 2), 2 * t(0, 1)}; }

}  // namespace

TEST_CASE("an elastic material of the remainder's stiffness answers as without, whatever the length") {
  for (const double length : {1e-9, 0.1, 1.0}) {
    fem::Problem p = box({1, 1, 1}, {4, 4, 1}, Kinematics::plane_strain);
    const std::size_t n = p.owned_points();
    fem::Material plain = fem::elastic_material(n, 1e8, 0.25);
    fem::RegularisedMaterial by(p, fem::elastic_material(n, 1e8, 0.25), all_of(p), everywhere(p, isotropic()),
                                {length, INFINITY});
    fem::Material m = by.material();
    for (int k = 0; k < 3; ++k) {
      const auto f = uneven(p, 1e-7);
      CHECK(largest_difference(take(m, f), take(plain, f)) < 1e-6);  // squares of the strain
    }
    // Its energy is theirs to the same digits: what it takes is no more than what was left out.
    std::vector<double> volumes;
    for (std::size_t i = 0; i < n; ++i) volumes.push_back(p.point_volume(i));
    CHECK(m.energy(volumes) == Approx(plain.energy(volumes)).epsilon(1e-5));
    CHECK(by.energy() > 0);
  }
}

namespace {

/// Force on an elastic block between rough platens that near by 0.1 % (N a metre); `length` zero: as it is.
double pressed(double length, double memory) {
  fem::BoxMesh mesh;
  mesh.size = {1, 1, 1}, mesh.cells = {8, 8, 1};
  fem::Problem p(MPI_COMM_SELF, mesh, {1, 2, true, Kinematics::plane_strain, 1, ElementKind::standard},
                 {plane("base", 1, 0, 1, 0), plane("top", 1, 1, 1, -1e-3), plane("base x", 1, 0, 0, 0),
                  plane("top x", 1, 1, 0, 0)});
  fem::Material plain = fem::elastic_material(p.owned_points(), 1e8, 0.25);
  std::optional<fem::RegularisedMaterial> by;
  if (length > 0) by.emplace(p, plain, all_of(p), everywhere(p, isotropic()), fem::Regularisation{length, memory});
  fem::Material m = by ? by->material() : plain;
  fem::ExplicitStaticsOptions o;
  o.crossings = 60;
  REQUIRE(fem::solve_explicit_statics(p, m, o, [](const fem::ExplicitStaticsReport&) { return true; }).finished);
  return std::abs(p.reaction(1)[1]);
}

}  // namespace

TEST_CASE("an elastic block between rough platens bears the same, whatever the length: no layer at its boundary") {
  const double plain = pressed(0, INFINITY);
  for (const double length : {0.125, 0.625}) {
    CHECK(pressed(length, INFINITY) == Approx(plain).epsilon(2e-5));  // squares of strains, large at the corners
    CHECK(pressed(length, 0.01) == Approx(plain).epsilon(2e-3));      // a tenth of the memory in strain
  }
}

TEST_CASE("what was left out is forgotten by 1/e over the memory, exactly, in one increment or in many") {
  constexpr double memory = 0.004, size = 0.01;
  fem::Problem p = box({1, 1, 1}, {3, 3, 1}, Kinematics::plane_strain);
  const auto points = all_of(p);
  const auto total = uneven(p, size);
  std::vector<double> stretch(6 * points.size()), mean(stretch.size());
  for (const std::size_t i : points) {
    const Mat3 e = log_of(total[i]);
    Eigen::Map<Vec6>(stretch.data() + 6 * i) << e(0, 0), e(1, 1), e(2, 2), e(1, 2), e(0, 2), e(0, 1);
  }
  fem::StretchAverage average(p, points, 0.3);
  average(stretch, mean);
  for (const int increments : {1, 8, 400}) {
    fem::RegularisedMaterial by(p, nothing(), points, everywhere(p, layered()), {0.3, memory});
    fem::Material m = by.material();
    std::vector<double> stress;
    for (int k = 0; k < increments; ++k) stress = take(m, uneven(p, size / increments));
    double worst = 0;
    for (const std::size_t i : points) {
      const double gone = fem::symmetric(mean.data() + 6 * i).norm();
      const Vec6 left = doubled(fem::symmetric(stretch.data() + 6 * i) - fem::symmetric(mean.data() + 6 * i));
      const Vec6 expected = memory / gone * (1 - std::exp(-gone / memory)) * (layered() * left);
      worst = std::max(worst, (Eigen::Map<const Vec6>(stress.data() + 6 * i) - expected).norm());
    }
    CHECK(worst < 1e-10 * 1e8 * size);
  }
}

TEST_CASE("a body that turns takes along what was left out, and its stiffness") {
  fem::Problem p = box({1, 1, 1}, {3, 3, 1}, Kinematics::plane_strain);
  const auto first = uneven(p, 2e-3);
  const Mat3 quarter = Eigen::AngleAxisd(pi / 2, Eigen::Vector3d(0, 0, 1)).toRotationMatrix();
  for (const int steps : {1, 90}) {
    fem::RegularisedMaterial still(p, nothing(), all_of(p), everywhere(p, layered()), {0.3, 0.01}),
        turning(p, nothing(), all_of(p), everywhere(p, layered()), {0.3, 0.01});
    fem::Material a = still.material(), b = turning.material();
    take(a, first), take(b, first);
    const Mat3 part = Eigen::AngleAxisd(pi / 2 / steps, Eigen::Vector3d(0, 0, 1)).toRotationMatrix();
    for (int k = 0; k < steps; ++k) take(b, std::vector<Mat3>(first.size(), part));
    std::vector<Mat3> turned;
    for (const Mat3& f : first) turned.push_back(quarter * f * quarter.transpose());
    const auto in_place = take(a, first), aside = take(b, turned);
    double worst = 0, size = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const Mat3 s = fem::symmetric(in_place.data() + 6 * i), t = fem::symmetric(aside.data() + 6 * i);
      worst = std::max(worst, (t - quarter * s * quarter.transpose()).norm()), size = std::max(size, s.norm());
    }
    CHECK(worst < 1e-11 * size);
    CHECK(turning.energy() == Approx(still.energy()).epsilon(1e-10));
  }
}

TEST_CASE(
    "energy: nothing of even strain; of uneven what the stresses did at the points less what the material heard") {
  fem::Problem p = box({1, 1, 1}, {3, 3, 1}, Kinematics::plane_strain);
  const auto points = all_of(p);
  fem::RegularisedMaterial even(p, fem::elastic_material(points.size(), 1e8, 0.25), points, everywhere(p, isotropic()),
                                {0.3, 0.01});
  fem::Material m = even.material();
  Mat3 f = Mat3::Identity();
  f(0, 0) = 1.01, f(0, 1) = 0.02;
  for (int k = 0; k < 5; ++k) take(m, std::vector<Mat3>(points.size(), f));
  std::vector<double> volumes;
  for (const std::size_t i : points) volumes.push_back(p.point_volume(i));
  CHECK(std::abs(even.energy()) < 1e-12 * m.energy(volumes));
  // Of a material that bears nothing: e C left / 2, by the volumes; the remainder never fades.
  fem::RegularisedMaterial by(p, nothing(), points, everywhere(p, layered()), {0.3, INFINITY});
  fem::Material alone = by.material();
  const auto total = uneven(p, 1e-5);
  std::vector<double> stretch(6 * points.size()), mean(stretch.size());
  for (const std::size_t i : points) {
    const Mat3 e = log_of(total[i]);
    Eigen::Map<Vec6>(stretch.data() + 6 * i) << e(0, 0), e(1, 1), e(2, 2), e(1, 2), e(0, 2), e(0, 1);
  }
  fem::StretchAverage(p, points, 0.3)(stretch, mean);
  double expected = 0;
  for (const std::size_t i : points) {
    const Mat3 e = fem::symmetric(stretch.data() + 6 * i), left = e - fem::symmetric(mean.data() + 6 * i);
    expected += 0.5 * volumes[i] * doubled(e).dot(layered() * doubled(left));
  }
  for (int k = 0; k < 4; ++k) take(alone, uneven(p, 0.25e-5));
  CHECK(by.energy() == Approx(expected).epsilon(1e-4));
  CHECK(alone.energy(volumes) == by.energy());
}

TEST_CASE("its state goes on as it was, and bytes of another problem are refused") {
  fem::Problem p = box({1, 1, 1}, {3, 3, 1}, Kinematics::plane_strain);
  const auto points = all_of(p);
  const auto fresh = [&] {
    return std::make_unique<fem::RegularisedMaterial>(p, fem::elastic_material(points.size(), 1e8, 0.25), points,
                                                      everywhere(p, layered()), fem::Regularisation{0.3, 0.01});
  };
  const auto whole = fresh(), first = fresh(), second = fresh();
  fem::Material a = whole->material(), b = first->material(), c = second->material();
  const auto f = uneven(p, 3e-3);
  take(a, f), take(b, f);
  c.load(b.save());
  CHECK(take(a, f) == take(c, f));
  CHECK(whole->energy() == second->energy());
  CHECK_THROWS_AS(second->load(first->save().substr(8)), std::invalid_argument);
  std::string damaged = first->save();
  std::fill_n(damaged.begin() + 48, 8, '\xff');
  CHECK_THROWS_AS(second->load(damaged), std::invalid_argument);
}

namespace {

constexpr double stiff = 1e8, falls = 1e7, peak_at = 1e-3;  // Pa, Pa, strain

/// Along y: the stress of point i at a strain; nothing else but the same stiffness.
fem::Material along_y(std::size_t n, const std::function<double(std::size_t, double)>& stress_at) {
  struct State {
    std::vector<Mat3> committed, trial;
  };
  auto state = std::make_shared<State>();
  state->committed.assign(n, Mat3::Zero()), state->trial = state->committed;
  const auto respond = [=](const fem::Points& p) {
    for (std::size_t i = 0; i < n; ++i) {
      const Mat3 e = state->committed[i] + log_of(Eigen::Map<const Row>(p.deformation.data() + 9 * i));
      state->trial[i] = e;
      const double s[6] = {stiff * e(0, 0), stress_at(i, e(1, 1)), stiff * e(2, 2),
                           stiff * e(1, 2), stiff * e(0, 2),       stiff * e(0, 1)};
      std::copy_n(s, 6, p.stress.data() + 6 * i);
      if (p.tangent.empty()) continue;
      Eigen::Map<Mat6> c(p.tangent.data() + 36 * i);
      c.setZero();
      for (int k = 0; k < 6; ++k) c(k, k) = k < 3 ? stiff : 0.5 * stiff;
    }
    return true;
  };
  const auto energy = [=](std::span<const double> volumes) {
    double sum = 0;
    for (std::size_t i = 0; i < volumes.size(); ++i) sum += volumes[i] * stiff * state->committed[i].squaredNorm() / 2;
    return sum;
  };
  return {respond, [=] { state->committed = state->trial; }, [] { return std::string(); }, [](const std::string&) {},
          energy};
}

/// A bar drawn out from one end to the other: strain along y of its elements; energies a square metre of it (J).
struct Drawn {
  std::vector<double> strain;
  double regularisation, work;
};

/// `stress_at(element, y, strain)`; `memory` infinity: nothing is forgotten.
Drawn drawn(double size, int elements, double stretch, double length, double memory,
            const std::function<double(std::size_t, double, double)>& stress_at) {
  fem::BoxMesh mesh;
  mesh.size = {size / elements, size, 1}, mesh.cells = {1, elements, 1};
  fem::Problem p(MPI_COMM_SELF, mesh, {1, 2, true, Kinematics::plane_strain, 1, ElementKind::standard},
                 {plane("base", 1, 0, 1, 0), plane("top", 1, size, 1, stretch * size), plane("left", 0, 0, 0, 0),
                  plane("right", 0, size / elements, 0, 0)});
  std::vector<double> at;
  for (std::size_t i = 0; i < p.owned_points(); ++i) at.push_back(p.point_position(i)[1]);
  const auto element = [&](std::size_t i) { return static_cast<std::size_t>(at[i] / size * elements); };
  fem::Material plain =
      along_y(p.owned_points(), [&](std::size_t i, double strain) { return stress_at(element(i), at[i], strain); });
  Mat6 c = Mat6::Zero();
  for (int k = 0; k < 6; ++k) c(k, k) = k < 3 ? stiff : 0.5 * stiff;
  std::optional<fem::RegularisedMaterial> by;
  if (length > 0) by.emplace(p, plain, all_of(p), everywhere(p, c), fem::Regularisation{length, memory});
  fem::Material m = by ? by->material() : plain;
  fem::ExplicitStaticsOptions o;
  o.balance = 0.5, o.kinetic = 0.5, o.max_energy_error = 1e9, o.crossings = 300;
  const double width = size / elements;
  Drawn result{std::vector<double>(static_cast<std::size_t>(elements), 0), 0, 0};
  REQUIRE(fem::solve_explicit_statics(p, m, o, [&](const fem::ExplicitStaticsReport& r) {
            result.work = r.energy.external / width;
            return true;
          }).finished);
  if (by) result.regularisation = by->energy() / width;
  for (std::size_t i = 0; i < p.owned_points(); ++i) result.strain[element(i)] += p.deformation()[9 * i + 4] / 4 - 0.25;
  return result;
}

/// To thrice the strain of the peak: softer and softer past it by `falls`; a tenth of the bar reaches it a thousandth
/// earlier.
std::vector<double> softened(double size, int elements, double length) {
  return drawn(size, elements, 3 * peak_at, length, INFINITY,
               [=](std::size_t, double y, double strain) {
                 const double top = peak_at * (y < 0.1 * size ? 0.999 : 1);
                 return strain < top ? stiff * strain
                                     : std::max(stiff * top - falls * (strain - top), 0.1 * stiff * top);
               })
      .strain;
}

/// Length of bar (elements) that has more than half of the way from the least to the largest strain.
double width(const std::vector<double>& strain) {
  const auto [least, most] = std::minmax_element(strain.begin(), strain.end());
  double n = 0;
  for (const double e : strain) n += e > 0.5 * (*least + *most);
  return n;
}

}  // namespace

TEST_CASE("a bar that softens stays even below pi l sqrt(C / H), and localises above; in a band of its own width") {
  constexpr double length = 0.1;
  const double first = pi * length * std::sqrt(stiff / falls);
  const auto spread = [](const std::vector<double>& strain) {
    const auto [least, most] = std::minmax_element(strain.begin(), strain.end());
    return (*most - *least) / (3 * peak_at);
  };
  CHECK(spread(softened(0.85 * first, 24, length)) < 0.05);
  CHECK(spread(softened(1.2 * first, 24, length)) > 0.3);
  // A long bar: the band keeps its width as elements become smaller; a local one is of the elements' size.
  std::vector<double> wide;
  for (const int n : {32, 48}) wide.push_back(width(softened(4 * first, n, length)) / n);
  CHECK(wide[0] == Approx(wide[1]).epsilon(0.15));
  // Half of a band stands at the weak end, half a wave of the shortest that grows; wider where it softens no more.
  CHECK(wide[1] * 4 == Approx(0.65).margin(0.25));
  CHECK(width(softened(4 * first, 48, 0)) <= 2);
}

TEST_CASE("weak and strong elements in turn that flow: what is left out holds them together, and gives nothing") {
  // Perfectly plastic beyond the peak. The stress is the same along the bar: weak elements have what strong ones lack,
  // s = memory C (E - mean) / mean in a flow. Half of memory C beside the mean strength: 1.5 and 0.5 of the mean
  // strain.
  constexpr double memory = 5e-4, aside = 0.5 * memory * stiff, strength = peak_at * stiff;
  constexpr int elements = 16;
  const auto flow = [&](double stretch) {
    return drawn(1, elements, stretch, 0.2, memory, [=](std::size_t element, double, double strain) {
      return std::min(stiff * strain, strength + (element % 2 ? aside : -aside));
    });
  };
  const Drawn first = flow(8e-3), last = flow(16e-3);
  const auto gone = [&](std::size_t e) { return last.strain[e] - first.strain[e]; };
  for (std::size_t e = 1; e + 1 < elements; ++e) {  // the mean leans a little, as the ends differ
    INFO("element " << e);
    const double mean = 0.25 * gone(e - 1) + 0.5 * gone(e) + 0.25 * gone(e + 1);
    CHECK(gone(e) / mean == Approx(e % 2 ? 0.5 : 1.5).epsilon(0.02));
  }
  CHECK(last.work - first.work == Approx(strength * 8e-3).epsilon(0.02));
  CHECK(std::abs(last.regularisation - first.regularisation) < 0.01 * (last.work - first.work));
}

}  // namespace grus
