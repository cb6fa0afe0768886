// SPDX-License-Identifier: LGPL-3.0-or-later
// The average of stretches against closed forms: even fields, waves, Bessel functions; its polynomial.
#include "fem/stretch_average.hpp"

#include <cstring>

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

constexpr double pi = 3.14159265358979323846;

/// The mean of a field in one component, and the largest error against `exact` at the points.
double error_of(fem::Problem& p, double length, std::size_t component, const std::function<double(const Point&)>& field,
                const std::function<double(const Point&)>& exact, double* left_over = nullptr) {
  const auto points = all_of(p);
  fem::StretchAverage average(p, points, length);
  std::vector<double> in(6 * points.size(), 0), out(in.size());
  for (const std::size_t i : points) in[6 * i + component] = field(p.point_position(i));
  average(in, out);
  if (left_over) *left_over = average.left_over();
  double worst = 0;
  for (const std::size_t i : points)
    worst = std::max(worst, std::abs(out[6 * i + component] - exact(p.point_position(i))));
  return worst;
}

}  // namespace

TEST_CASE("an even field is its own mean, whatever the elements and the length") {
  const auto bent = [](const Point& x) { return Point{x[0] * (0.3 + 0.7 * x[0]), x[1] + 0.2 * x[0] * x[1], x[2]}; };
  struct Kind {
    Kinematics kinematics;
    bool brick;
    ElementKind element;
    int order, degree;
  };
  for (const Kind& k : {Kind{Kinematics::plane_strain, true, ElementKind::fbar, 1, 2},
                        Kind{Kinematics::plane_strain, false, ElementKind::standard, 1, 1},
                        Kind{Kinematics::plane_strain, true, ElementKind::standard, 1, 1},
                        Kind{Kinematics::plane_strain, false, ElementKind::standard, 2, 2},
                        Kind{Kinematics::plane_strain, true, ElementKind::serendipity, 2, 2},
                        Kind{Kinematics::solid, true, ElementKind::serendipity, 2, 2},
                        Kind{Kinematics::solid, true, ElementKind::standard, 1, 2},
                        Kind{Kinematics::solid, false, ElementKind::standard, 1, 2}})
    for (const double length : {1e-9, 0.1, 1.0}) {
      fem::Problem p = box({1, 1, 1}, {3, 3, 2}, k.kinematics, k.brick, k.element, k.order, k.degree, bent);
      const auto points = all_of(p);
      fem::StretchAverage average(p, points, length);
      const std::array<double, 6> even{0.3, -1, 0.2, 0.1, -0.4, 0.5};
      std::vector<double> in, out(6 * points.size());
      for (std::size_t i = 0; i < points.size(); ++i) in.insert(in.end(), even.begin(), even.end());
      if (k.kinematics != Kinematics::solid)
        for (std::size_t i = 0; i < points.size(); ++i) in[6 * i + 3] = in[6 * i + 4] = 0;
      average(in, out);
      CHECK(largest_difference(out, in) < 1e-13);
      CHECK(average.left_over() == 0);
    }
  // About an axis rr and hoop are even together.
  fem::Problem p = box({1, 1, 1}, {4, 3, 1}, Kinematics::axisymmetric);
  const auto points = all_of(p);
  fem::StretchAverage average(p, points, 0.4);
  std::vector<double> in(6 * points.size(), 0), out(in.size());
  for (const std::size_t i : points) in[6 * i] = in[6 * i + 2] = 0.3, in[6 * i + 1] = -1;
  average(in, out);
  CHECK(largest_difference(out, in) < 1e-13);
}

TEST_CASE("waves are damped by 1 / (1 + l^2 k^2), to the square of the element's size") {
  // In each direction, and each component in its place.
  for (const std::size_t axis : {0u, 1u, 2u})
    for (const double length : {0.05, 0.4}) {
      const auto wave = [&](const Point& x) { return std::cos(2 * pi * x[axis]); };
      const auto mean = [&](const Point& x) { return wave(x) / (1 + length * length * 4 * pi * pi); };
      double before = 0;
      for (const int n : {8, 16}) {
        std::array<long, 3> cells{2, 2, 2};
        cells[axis] = n;
        fem::Problem p = box({1, 1, 1}, cells, Kinematics::solid);
        const double error = error_of(p, length, axis == 1 ? 5 : axis, wave, mean);
        const double h = 1.0 / n;
        CHECK(error < 4 * pi * pi * h * h / 4);    // of linear elements: a fourth of the curvature h^2 at most
        if (n == 16) CHECK(before / error > 3.5);  // second order at least
        before = error;
      }
    }
}

TEST_CASE("one element: its corners bear a linear field, damped by 1 / (1 + 12 (l / side)^2) for every length") {
  for (const double length : {1e-9, 0.1, 1.0, 100.0})
    for (const std::size_t axis : {0u, 1u}) {
      fem::Problem p = box({1, 1, 1}, {1, 1, 1}, Kinematics::plane_strain);
      const double damping = 1 / (1 + 12 * length * length);
      const auto field = [&](const Point& x) { return 3 + 2 * (x[axis] - 0.5); };
      const auto mean = [&](const Point& x) { return 3 + 2 * damping * (x[axis] - 0.5); };
      CHECK(error_of(p, length, axis, field, mean) < 1e-3);  // of the polynomial
    }
}

TEST_CASE("a band along a boundary is half of one inside: nothing flows through the surface") {
  const auto band = [](double y) { return std::exp(-50 * y * y); };
  for (const double length : {0.05, 0.3}) {
    fem::Problem whole = box({1, 2, 1}, {3, 24, 1}, Kinematics::plane_strain),
                 half = box({1, 1, 1}, {3, 12, 1}, Kinematics::plane_strain);
    std::vector<double> in, mean(6 * whole.owned_points()), in_half, mean_half(6 * half.owned_points());
    const auto fill = [&](fem::Problem& p, double middle, std::vector<double>& to) {
      to.assign(6 * p.owned_points(), 0);
      for (const std::size_t i : all_of(p)) to[6 * i + 1] = band(p.point_position(i)[1] - middle);
    };
    fill(whole, 1, in), fill(half, 0, in_half);
    fem::StretchAverage(whole, all_of(whole), length)(in, mean);
    fem::StretchAverage(half, all_of(half), length)(in_half, mean_half);
    std::size_t met = 0;
    for (const std::size_t i : all_of(half))
      for (const std::size_t k : all_of(whole)) {
        const Point a = half.point_position(i), b = whole.point_position(k);
        if (std::hypot(a[0] - b[0], a[1] + 1 - b[1]) > 1e-9) continue;
        CHECK(mean_half[6 * i + 1] == Approx(mean[6 * k + 1]).margin(1e-12));
        ++met;
      }
    CHECK(met == half.owned_points());
  }
}

TEST_CASE("the polynomial is the inverse to a thousandth: against the closed form of a wave on even elements") {
  constexpr int n = 12;
  constexpr double h = 1.0 / n;
  for (const double length : {1e-9, 0.3 * h, h, 5 * h, 1.0})
    for (const int waves : {1, 5}) {
      const double k = 2 * pi * waves;
      fem::Problem p = box({1, h, 1}, {n, 1, 1}, Kinematics::plane_strain);
      double load = 0;
      for (const double q : {0.5 - 0.5 / std::sqrt(3), 0.5 + 0.5 / std::sqrt(3)}) load += (1 - q) * std::cos(k * h * q);
      const double at_nodes =
          load / ((2 + std::cos(k * h)) / 3 + length * length * 2 * (1 - std::cos(k * h)) / (h * h));
      double left_over = 1;
      const double error = error_of(
          p, length, 0, [&](const Point& x) { return std::cos(k * x[0]); },
          [&](const Point& x) {
            const double first = std::floor(x[0] / h) * h, share = (x[0] - first) / h;
            return at_nodes * ((1 - share) * std::cos(k * first) + share * std::cos(k * (first + h)));
          },
          &left_over);
      CHECK(error < 2e-3);
      CHECK(left_over <= fem::StretchAverage::promised * (1 + 1e-6));
      // The wave is a mode of the matrix over its diagonal, and modes of a square element bound it: what is left is the
      // polynomial's value at the wave's.
      const double mass = h * h / 9, stiffness = 2 * length * length / 3, all = mass + stiffness;
      const std::array<double, 3> modes{2.25 * mass / all, (0.75 * mass + 1.5 * stiffness) / all,
                                        (0.25 * mass + stiffness) / all};
      const auto [low, high] = std::minmax_element(modes.begin(), modes.end());
      const double middle = (*high + *low) / (*high - *low);
      const double degree = std::ceil(std::acosh(1 / fem::StretchAverage::promised) / std::acosh(middle));
      const double own = (h * h * (2 + std::cos(k * h)) / 6 + length * length * (1 - std::cos(k * h))) / (2 * all);
      const double at = middle - 2 * own / (*high - *low);
      const double left = std::abs(std::cos(degree * std::acos(at))) / std::cosh(degree * std::acosh(middle));
      CHECK(left_over == Approx(left).margin(1e-9));
    }
}

TEST_CASE("about an axis tensors are averaged, not numbers: rr less hoop turns twice, ry once") {
  constexpr double length = 0.2;
  fem::Problem p = box({1, 0.1, 1}, {32, 1, 1}, Kinematics::axisymmetric);
  const auto points = all_of(p);
  fem::StretchAverage average(p, points, length);
  // Bessel functions whose slope is nothing at r = 1.
  const double k0 = 3.8317059702075, k1 = 1.8411837813407, k2 = 3.0542369282271;
  const auto less = [&](double k) { return 1 / (1 + length * length * k * k); };
  std::vector<double> in(6 * points.size(), 0), out(in.size());
  for (const std::size_t i : points) {
    const double r = p.point_position(i)[0];
    in[6 * i] = std::cyl_bessel_j(2, k2 * r), in[6 * i + 2] = -in[6 * i];
    in[6 * i + 1] = std::cyl_bessel_j(0, k0 * r);
    in[6 * i + 5] = std::cyl_bessel_j(1, k1 * r);
  }
  average(in, out);
  double worst = 0;
  for (const std::size_t i : points)
    for (const auto& [component, factor] :
         {std::pair<std::size_t, double>{0, less(k2)}, {2, less(k2)}, {1, less(k0)}, {5, less(k1)}})
      worst = std::max(worst, std::abs(out[6 * i + component] - factor * in[6 * i + component]));
  CHECK(worst < 4e-3);  // k^2 h^2 / 4 and a thousandth
}

namespace {

struct Cut {
  Kinematics kinematics;
  bool brick;
  int order, degree;
  bool part;  // of the points
};

/// Means of a rough field at points of a bent block, by point, and what they leave: of this rank's points, others 0.
std::vector<double> means(MPI_Comm comm, const Cut& cut, bool exact, double length, int& degree) {
  const bool flat = cut.kinematics != Kinematics::solid;
  fem::BoxMesh mesh;
  mesh.size = {1, 1, 1}, mesh.cells = {3, 4, flat ? 1 : 2}, mesh.hexahedron = cut.brick;
  mesh.map = [](const Point& x) { return Point{0.2 + x[0] * (0.3 + 0.7 * x[0]), x[1] + 0.2 * x[0] * x[1], x[2]}; };
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const int elements = (flat ? 12 : 24) * (cut.brick ? 1 : flat ? 2 : 6);
  for (int k = 0; k < elements && ranks > 1; ++k) mesh.owner.push_back(k * k % 7 % ranks);  // torn apart
  fem::Discretisation d{cut.order, cut.degree, true, cut.kinematics, 1};
  d.exact_sums = exact;
  fem::Problem p(comm, mesh, d, {plane("base", 1, 0, 1, 0)});
  std::vector<std::size_t> points;
  for (const std::size_t i : all_of(p))
    if (!cut.part || p.point_position(i)[1] < 0.6) points.push_back(i);
  fem::StretchAverage average(p, points, length);
  degree = average.degree();
  std::vector<double> in(6 * points.size()), out(in.size());
  std::vector<double> all(6 * static_cast<std::size_t>(p.global_points()) + 1, 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k)
      in[6 * i + k] = 1e-5 * std::sin(static_cast<double>(p.point_key(points[i]) * 7 + static_cast<std::int64_t>(k)));
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  for (int call = 0; call < 2; ++call) CHECK(average(in, out, rank == ranks - 1));  // one asks for all
  for (std::size_t i = 0; i < points.size(); ++i)
    std::copy_n(out.data() + 6 * i, 6, all.data() + 6 * static_cast<std::size_t>(p.point_key(points[i])));
  all.back() = average.left_over();
  if (ranks == 1) return all;
  const double left = all.back();
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, comm);  // 0 elsewhere
  all.back() = left;
  return all;
}

}  // namespace

TEST_CASE(
    "with exact sums means are the same bits on one rank and on all, and those of a sparse matrix but for digits") {
  for (const Cut& cut :
       {Cut{Kinematics::solid, true, 1, 2, false}, Cut{Kinematics::solid, false, 1, 1, true},
        Cut{Kinematics::plane_strain, true, 1, 2, true}, Cut{Kinematics::plane_strain, false, 2, 2, false},
        Cut{Kinematics::axisymmetric, true, 1, 2, true}})
    for (const double length : {1e-9, 0.1, 1.0}) {
      int of_all = 0, of_one = 0, of_plain = 0;
      const auto spread = means(MPI_COMM_WORLD, cut, true, length, of_all),
                 whole = means(MPI_COMM_SELF, cut, true, length, of_one),
                 plain = means(MPI_COMM_SELF, cut, false, length, of_plain);
      CHECK((of_all == of_one && of_one == of_plain));
      CHECK((spread.size() == whole.size() && std::memcmp(spread.data(), whole.data(), 8 * whole.size()) == 0));
      REQUIRE(plain.size() == whole.size());
      // A quantum is 2^-40 of the field; a residual of that is no more than 2^-40 / (1 - spectral radius) of the mean.
      for (std::size_t k = 0; k + 1 < plain.size(); ++k) CHECK(std::abs(whole[k] - plain[k]) < 1e-9 * 1e-5);
      CHECK(std::abs(whole.back() - plain.back()) < 1e-6);
      CHECK((plain.back() < fem::StretchAverage::promised && (length < 0.1 || plain.back() > 1e-9)));
    }
}

TEST_CASE("with exact sums an even field is its own mean, and no number has no mean on any rank") {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank), MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  fem::BoxMesh mesh;
  mesh.size = {1, 1, 1}, mesh.cells = {3, 3, 2};
  fem::Discretisation d{1, 2, true, Kinematics::solid, 1};
  d.exact_sums = true;
  fem::Problem p(MPI_COMM_WORLD, mesh, d, {plane("base", 1, 0, 1, 0)});
  const auto points = all_of(p);
  fem::StretchAverage average(p, points, 0.3);
  const std::array<double, 6> even{0.3, -1, 0.2, 0.1, -0.4, 0.5};
  std::vector<double> in, out(6 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) in.insert(in.end(), even.begin(), even.end());
  CHECK_FALSE(average(in, out));
  for (std::size_t i = 0; i < in.size(); ++i) CHECK(std::abs(out[i] - in[i]) < 1e-11);
  CHECK(average.left_over() == 0);
  if (rank == ranks - 1) in.back() = NAN;
  CHECK_FALSE(average(in, out));
  for (const double v : out) CHECK(std::isnan(v));
  if (rank == ranks - 1) in.back() = even.back();
  average(in, out);
  for (std::size_t i = 0; i < in.size(); ++i) CHECK(std::abs(out[i] - in[i]) < 1e-11);
  std::fill(in.begin(), in.end(), 0);
  average(in, out);
  for (const double v : out) CHECK(v == 0);
}

TEST_CASE("what cannot be averaged is refused") {
  fem::Problem p = box({1, 1, 1}, {2, 2, 1}, Kinematics::plane_strain);
  CHECK_THROWS_AS(fem::StretchAverage(p, all_of(p), 1e7), std::invalid_argument);
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (ranks == 1) return;
  fem::BoxMesh mesh;
  mesh.size = {1, 1, 1}, mesh.cells = {4, 4, 1};
  fem::Problem cut(MPI_COMM_WORLD, mesh, {1, 2, true, Kinematics::plane_strain, 1}, {plane("base", 1, 0, 1, 0)});
  CHECK_THROWS_AS(fem::StretchAverage(cut, all_of(cut), 0.1), std::invalid_argument);
}

}  // namespace grus
