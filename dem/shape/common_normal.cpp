// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/common_normal.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

struct Side {
  Vec3 squares, point;  // A_i of the octant, support point
  double q;             // support height

  Side(const PolyEllipsoid& s, const Vec3& d) : squares(octant_squares(s, d)) {
    point = squares.cwiseProduct(d);
    q = std::sqrt(point.dot(d));
    point /= q;
  }
  Vec3 hessian(const Vec3& v) const { return (squares.cwiseProduct(v) - point * point.dot(v)) / q; }
  double trace() const { return (squares.sum() - point.squaredNorm()) / q; }
  double determinant() const { return squares.prod() / (q * q * q * q); }
  Mat3 matrix() const {
    Mat3 m = -point * point.transpose();
    m.diagonal() += squares;
    return m / q;
  }
};

struct Evaluation {
  Side a, b;
  Vec3 point_b, g;  // support point of B in A's frame; tangential gradient
  double f;

  Evaluation(const ShapePair& pair, const Vec3& n) : a(pair.a, n), b(pair.b, pair.b_to_a.transpose() * -n) {
    point_b = pair.r + pair.b_to_a * b.point;
    const Vec3 w = a.point - point_b;
    f = w.dot(n);
    g = w - f * n;
  }
};

CommonNormal result(const Vec3& n, const Evaluation& e, bool converged) {
  return {n, e.f, e.a.point, e.point_b, converged};
}

/// Newton step by Cayley and Hamilton (no tangent basis); false where the Hessian is not positive definite.
bool newton_step(const ShapePair& pair, const Evaluation& e, Vec3& step) {
  const double g2 = e.g.squaredNorm();
  if (g2 == 0) return step.setZero(), true;
  const Vec3 gb = pair.b_to_a.transpose() * e.g;
  const Vec3 mg = e.a.hessian(e.g) + pair.b_to_a * e.b.hessian(gb) - e.f * e.g;
  const double t = e.a.trace() + e.b.trace() - 2 * e.f;
  const double det = (e.g.dot(mg) * t - mg.squaredNorm()) / g2;
  if (!(t > 0) || !(det > 1e-12 * t * t)) return false;
  step = (mg - t * e.g) / det;
  return true;
}

CommonNormal line_search(const ShapePair& pair, Vec3 n, double length, int iterations) {
  Evaluation e(pair, n);
  for (int k = 0; k < iterations; ++k) {
    if (e.g.norm() <= 1e-10 * length) return result(n, e, true);
    Vec3 step;
    if (!newton_step(pair, e, step)) {
      const double t = e.a.trace() + e.b.trace() + std::abs(e.f);
      step = -e.g / std::max(t, 1e-3 * length);
    }
    if (step.norm() > 0.7) step *= 0.7 / step.norm();
    step -= n * n.dot(step);
    const double slope = e.g.dot(step);
    double s = 1;
    Vec3 next = n;
    bool lower = false;
    for (int cut = 0; cut < 12 && !lower; ++cut, s *= 0.5) {
      next = (n + s * step).normalized();
      const Evaluation trial(pair, next);
      lower = trial.f <= e.f + 1e-4 * s * slope + 1e-15 * length;
      if (lower) e = trial;
    }
    if (!lower) break;
    n = next;
  }
  return result(n, e, e.g.norm() <= 1e-7 * length);
}

double length_of(const ShapePair& pair) { return std::min(equivalent_radius(pair.a), equivalent_radius(pair.b)); }

/// Search without derivatives around a direction: for the kinks of nearly flat faces and sharp edges, where Newton
/// stalls.
CommonNormal polished(const ShapePair& pair, const CommonNormal& best, double length) {
  Vec3 n = best.normal;
  double f = best.overlap;
  for (double h = 0.05; h > 1e-10;) {
    const Vec3 u = n.unitOrthogonal(), v = n.cross(u);
    bool lower = false;
    for (int k = 0; k < 12; ++k) {
      const Vec3 d = (n + h * (std::cos(pi / 6 * k) * u + std::sin(pi / 6 * k) * v)).normalized();
      const double trial = separation_test(pair, d);
      if (trial < f - 1e-16 * length) f = trial, n = d, lower = true;
    }
    if (!lower) h *= 0.4;
  }
  return result(n, Evaluation(pair, n), true);
}

ContactCurvature curvature(double det_sum, double det_a, double det_b, double trace_a, double trace_b) {
  // Radii matrices H add as curvatures K = H_A^-1 + H_B^-1: det K = det(H_A + H_B) / (det H_A det H_B).
  const double det_k = det_sum / (det_a * det_b);
  const double trace_k = trace_a / det_a + trace_b / det_b;
  const double x = std::max(1.0, trace_k / (2 * std::sqrt(det_k))), l = std::log(x);
  return {1 / std::sqrt(det_k), std::exp(0.1741 * l + 0.0297 * l * l)};
}

}  // namespace

double separation_test(const ShapePair& pair, const Vec3& n) {
  return support_height(pair.a, n) + support_height(pair.b, pair.b_to_a.transpose() * n * -1.0) - n.dot(pair.r);
}

CommonNormal warm_common_normal(const ShapePair& pair, const Vec3& n0) {
  const double scale =
      pair.a.plus.x() + pair.b.plus.x() + pair.a.minus.x() + pair.b.minus.x();  // cheap length of the pair
  Vec3 n = n0;
  Evaluation e(pair, n);
  for (int k = 0; k < 5; ++k) {
    // At 1e-6 of the pair's size the direction errs by 1e-6, the depth by the square of it. Newton's next step would
    // take both to round-off, at half the cost of the pair's whole search: one step serves nearly all then.
    if (e.g.squaredNorm() <= 1e-12 * scale * scale || e.f < 0) return result(n, e, true);
    Vec3 step;
    if (!newton_step(pair, e, step) || step.squaredNorm() > 0.09) break;
    const Vec3 next = (n + step).normalized();
    const Evaluation trial(pair, next);
    if (trial.f > e.f + 1e-12 * scale) break;
    n = next;
    e = trial;
  }
  const double length = length_of(pair);
  if (e.g.norm() <= 1e-7 * length) return result(n, e, true);
  CommonNormal found = line_search(pair, n, length, 60);
  return found.converged ? found : cold_common_normal(pair);
}

CommonNormal cold_common_normal(const ShapePair& pair) {
  const double length = length_of(pair);
  // Two guesses: the line of origins, and the direction scaled by both shapes (Perram-Wertheim like).
  Vec3 guess = pair.r.norm() > 1e-12 * length ? pair.r.normalized() : Vec3(1, 0, 0);
  const Vec3 db = octant_squares(pair.b, pair.b_to_a.transpose() * -guess);
  const Mat3 d =
      Mat3(octant_squares(pair.a, guess).asDiagonal()) + pair.b_to_a * db.asDiagonal() * pair.b_to_a.transpose();
  const Vec3 scaled = d.ldlt().solve(pair.r);
  if (scaled.norm() > 0 && separation_test(pair, scaled.normalized()) < separation_test(pair, guess))
    guess = scaled.normalized();
  CommonNormal best = line_search(pair, guess, length, 100);
  if (best.overlap <= 0 && best.converged) return best;  // a stationary point with f <= 0 is the global one
  const double thin = std::min(smallest_semi_axis(pair.a), smallest_semi_axis(pair.b));
  if (best.converged && best.overlap < 0.02 * thin) return best;
  // Deep, or stuck: many starts, the least f wins (every f bounds the overlap from above). Rare, so plain.
  auto attempt = [&](const Vec3& n) {
    if (n.dot(pair.r) < 0 && pair.r.norm() > length) return;
    const CommonNormal other = line_search(pair, n, length, 60);
    if (other.overlap < best.overlap) best = other;
  };
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k)
        if (i != 0 || j != 0 || k != 0) attempt(Vec3(i, j, k).normalized());
  for (int k = 0; k < 3; ++k)
    attempt(pair.b_to_a.col(k)), attempt(-pair.b_to_a.col(k));  // flat faces of b; those of a are above
  return best.converged || best.overlap < 0 ? best : polished(pair, best, length);
}

ContactCurvature contact_curvature(const ShapePair& pair, const Vec3& n) {
  const Side a(pair.a, n), b(pair.b, pair.b_to_a.transpose() * -n);
  const double ta = a.trace(), tb = b.trace(), da = a.determinant(), db = b.determinant();
  const Mat3 hb = pair.b_to_a * b.matrix() * pair.b_to_a.transpose();
  const double det_sum = da + db + ta * tb - (a.matrix() * hb).trace();
  return curvature(det_sum, da, db, ta, tb);
}

ContactCurvature plane_curvature(const PolyEllipsoid& shape, const Vec3& d) {
  const Side s(shape, d);
  // A plane is a side of infinite radii: K = H^-1.
  const double x = std::max(1.0, s.trace() / (2 * std::sqrt(s.determinant()))), l = std::log(x);
  return {std::sqrt(s.determinant()), std::exp(0.1741 * l + 0.0297 * l * l)};
}

}  // namespace grus::dem
