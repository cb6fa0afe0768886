// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/shape/common_normal.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Integrals over the body by Gauss-Legendre in spherical coordinates, octant by octant: independent of the closed
/// forms.
struct Integral {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
};

Integral integrate(const PolyEllipsoid& s) {
  constexpr int n = 12;  // degree 23: the integrands are polynomials times smooth trigonometry
  double x[n], w[n];
  for (int i = 0; i < n; ++i) {  // Newton on the Legendre polynomial
    double z = std::cos(pi * (i + 0.75) / (n + 0.5)), d = 1;
    for (int it = 0; it < 50; ++it) {
      double p0 = 1, p1 = z;
      for (int k = 2; k <= n; ++k) std::swap(p0, p1), p1 = ((2 * k - 1) * z * p0 - (k - 1) * p1) / k;
      d = n * (z * p1 - p0) / (z * z - 1);
      z -= p1 / d;
    }
    x[i] = 0.5 * (1 + z), w[i] = 1 / ((1 - z * z) * d * d);
  }
  Integral sum;
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    const Vec3 a(sign.x() > 0 ? s.plus.x() : s.minus.x(), sign.y() > 0 ? s.plus.y() : s.minus.y(),
                 sign.z() > 0 ? s.plus.z() : s.minus.z());
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          const double r = x[i], theta = 0.5 * pi * x[j], phi = 0.5 * pi * x[k];
          const double dv = w[i] * w[j] * w[k] * 0.25 * pi * pi * r * r * std::sin(theta) * a.prod();
          const Vec3 p = r * Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta))
                                 .cwiseProduct(a)
                                 .cwiseProduct(sign);
          sum.volume += dv, sum.first += dv * p, sum.second += dv * p * p.transpose();
        }
  }
  return sum;
}

/// Least f(n) by a dense scan of directions, then pattern search: slow, plain, and without derivatives.
double brute_force_overlap(const ShapePair& pair) {
  double best = INFINITY;
  Vec3 at;
  const int n = 24;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      const double theta = pi * i / n, phi = pi * j / n;
      const Vec3 d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      const double f = separation_test(pair, d);
      if (f < best) best = f, at = d;
    }
  const Vec3 start = at.unitOrthogonal();
  for (double h = 0.1; h > 1e-9;) {
    bool lower = false;
    const Vec3 u = (start - at * at.dot(start)).normalized(), v = at.cross(u);
    for (int k = 0; k < 8; ++k) {
      const Vec3 d = (at + h * (std::cos(pi / 4 * k) * u + std::sin(pi / 4 * k) * v)).normalized();
      const double f = separation_test(pair, d);
      if (f < best) best = f, at = d, lower = true;
    }
    if (!lower) h *= 0.5;
  }
  return best;
}

}  // namespace

TEST_CASE("volume, centre of mass and inertia of poly-ellipsoids equal an independent integration") {
  for (std::uint64_t i = 0; i < 20; ++i) {
    const PolyEllipsoid s = random_shape(1, i, 0.1, 1);
    const Integral exact = integrate(s);
    CHECK(volume(s) == Approx(exact.volume).epsilon(1e-12));
    const Vec3 c = exact.first / exact.volume;
    CHECK((centre_of_mass(s) - c).norm() < 1e-12);
    CHECK((second_moment(s) - (exact.second / exact.volume - c * c.transpose())).norm() < 1e-12);
    const PrincipalFrame p = principal_frame(s);
    const Mat3 inertia = second_moment(s).trace() * Mat3::Identity() - second_moment(s);
    const Mat3 r = p.axes.toRotationMatrix();
    CHECK((r * p.moments.asDiagonal() * r.transpose() - inertia).norm() < 1e-12);
  }
}

TEST_CASE("mass properties of the published example are met") {
  PolyEllipsoid s;
  s.plus = {1.2, 1.0, 0.9}, s.minus = {0.8, 0.6, 0.5};
  CHECK(volume(s) == Approx(2.34572251).epsilon(1e-8));
  CHECK((centre_of_mass(s) - Vec3::Constant(0.15)).norm() < 1e-15);
  const Mat3 inertia = volume(s) * (second_moment(s).trace() * Mat3::Identity() - second_moment(s));
  CHECK(inertia(0, 0) == Approx(0.53717046).epsilon(1e-7));
  CHECK(inertia(0, 1) == Approx(0.00499209).epsilon(1e-5));
  Vec3 moments = volume(s) * principal_frame(s).moments;
  std::sort(moments.data(), moments.data() + 3);
  CHECK(moments[0] == Approx(0.536925).epsilon(1e-5));
  CHECK(moments[2] == Approx(0.776905).epsilon(1e-5));
}

TEST_CASE("the bounding sphere holds every surface point") {
  for (std::uint64_t i = 0; i < 200; ++i) {
    const PolyEllipsoid s = random_shape(2, i, 0.05, 1);
    for (std::uint64_t k = 0; k < 100; ++k) {
      const Vec3 p = support(s, random_rotation(3, 1000 * i + k) * Vec3(1, 0, 0)) - centre_of_mass(s);
      REQUIRE(p.norm() <= bounding_radius(s) * (1 + 1e-14));
    }
  }
}

TEST_CASE("depth and normal of 1e5 random pairs equal brute force, split children included") {
  int pairs = 0, higher = 0, touching = 0, worse_than_brute = 0;
  double worst_gradient = 0;
  for (std::uint64_t i = 0; i < 100000; ++i) {
    PolyEllipsoid a = random_shape(4, 2 * i), b = random_shape(4, 2 * i + 1);
    for (std::uint64_t k = 0; k < i % 4; ++k) a = halves(a, static_cast<int>((i + k) % 3), 0.1)[k % 2].shape;
    for (std::uint64_t k = 0; k < i / 4 % 3; ++k) b = halves(b, static_cast<int>((i + 2 * k) % 3), 0.1)[k % 2].shape;
    const Mat3 r = random_rotation(5, i).toRotationMatrix();
    const Vec3 n = random_rotation(6, i) * Vec3(1, 0, 0);
    const double size = std::min(equivalent_radius(a), equivalent_radius(b));
    const double depth = (i % 2 ? 1 : -1) * size * std::pow(10.0, -2 - static_cast<double>(i % 5));
    ShapePair pair{a, b, r, support(a, n) - r * support(b, r.transpose() * -n) - depth * n};
    // n is stationary by construction; it is the global minimum for shallow pairs of these shapes.
    const CommonNormal found = cold_common_normal(pair);
    ++pairs;
    touching += found.overlap > 0;
    REQUIRE(found.converged);
    if (found.overlap > depth + 1e-10 * size) ++higher;
    const Vec3 w = found.point_a - found.point_b;
    worst_gradient = std::max(worst_gradient, (w - found.overlap * found.normal).norm() / size);
    if (i % 100 == 0 && found.overlap > brute_force_overlap(pair) + 1e-7 * size) ++worse_than_brute;
  }
  CHECK(pairs == 100000);
  CHECK(touching > 45000);
  CHECK(higher == 0);            // never above the constructed stationary value
  CHECK(worse_than_brute == 0);  // 1000 of them against a search without derivatives
  CHECK(worst_gradient < 1e-7);  // support points lie on the common normal
}

TEST_CASE("a warm start finds what a cold start finds") {
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const PolyEllipsoid a = halves(random_shape(7, i), static_cast<int>(i % 3), 0.1)[0].shape, b = random_shape(8, i);
    const Mat3 r = random_rotation(9, i).toRotationMatrix();
    const Vec3 n = random_rotation(10, i) * Vec3(1, 0, 0);
    const ShapePair pair{a, b, r, support(a, n) - r * support(b, r.transpose() * -n) - 1e-3 * n};
    const CommonNormal cold = cold_common_normal(pair);
    const CommonNormal warm =
        warm_common_normal(pair, (cold.normal + 3e-3 * (random_rotation(11, i) * Vec3(1, 0, 0))).normalized());
    REQUIRE(warm.converged);
    REQUIRE(std::abs(warm.overlap - cold.overlap) < 1e-11);
  }
}

TEST_CASE("equal semi-axes make a sphere to round-off") {
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const double ra = 0.5 + random_uniform(12, i, Purpose::radius), rb = 0.5 + random_uniform(13, i, Purpose::radius);
    const PolyEllipsoid a = PolyEllipsoid::sphere(ra), b = PolyEllipsoid::sphere(rb);
    const Vec3 d = (ra + rb) * 0.999 * (random_rotation(14, i) * Vec3(1, 0, 0));
    const ShapePair pair{a, b, random_rotation(15, i).toRotationMatrix(), d};
    const CommonNormal found = cold_common_normal(pair);
    REQUIRE(std::abs(found.overlap - 0.001 * (ra + rb)) < 2e-15 * (ra + rb));
    REQUIRE((found.normal - d.normalized()).norm() < 1e-9);
    REQUIRE(contact_curvature(pair, found.normal).radius == Approx(ra * rb / (ra + rb)).epsilon(1e-12));
    REQUIRE(contact_curvature(pair, found.normal).ellipse_factor == Approx(1).epsilon(1e-12));
  }
}

TEST_CASE("overlap and normal are continuous where the contact crosses an octant plane") {
  const PolyEllipsoid a = halves(PolyEllipsoid::sphere(1), 0, 0.1)[0].shape, b = PolyEllipsoid::sphere(0.3);
  CommonNormal before{};
  bool crossed = false;
  for (int k = 0; k <= 2000; ++k) {  // slide b over the flank of a, where the semi-axis jumps from 0.9 to 0.1
    const double x = -1e-3 + 1e-6 * k;
    const ShapePair pair{a, b, Mat3::Identity(), Vec3(x, 0, a.plus.z() + 0.3 - 1e-3)};
    const CommonNormal now = cold_common_normal(pair);
    if (k > 0) {
      REQUIRE(std::abs(now.overlap - before.overlap) < 1e-6);  // |d overlap| <= |dx|
      REQUIRE((now.normal - before.normal).norm() < 4e-5);  // |dn| <= |dx| / smallest radius of the sum (0.0105 + 0.3)
      crossed = crossed || before.normal.x() * now.normal.x() <= 0;
    }
    before = now;
  }
  CHECK(crossed);
}
