// SPDX-License-Identifier: LGPL-3.0-or-later
// Anderson acceleration of a fixed-point iteration x <- x + g(x), here Newton with a tangent that is not consistent:
// the last iterations' differences stand in for the tangent's error. With an exact tangent it changes nothing.
#pragma once

#include <Eigen/Dense>
#include <deque>
#include <vector>

#include "fem/problem_impl.hpp"

namespace grus::fem {

class Acceleration {
public:
  Acceleration(MPI_Comm comm, std::size_t depth) : comm_(comm), depth_(depth) {}

  /// The step to take, given the step `g` that the iteration proposes at the present point.
  std::vector<double> step(const std::vector<double>& g) {
    std::vector<double> out = g;
    if (again_) {
      std::vector<double> dg(g.size());
      for (std::size_t i = 0; i < g.size(); ++i) dg[i] = g[i] - last_g_[i];
      pairs_.push_back({last_move_, std::move(dg)});
      if (pairs_.size() > depth_) pairs_.pop_front();
      const auto m = static_cast<Eigen::Index>(pairs_.size());
      Eigen::MatrixXd gram(m, m + 1);
      for (Eigen::Index a = 0; a < m; ++a) {
        for (Eigen::Index b = 0; b < m; ++b)
          gram(a, b) = dot(pairs_[static_cast<std::size_t>(a)].change, pairs_[static_cast<std::size_t>(b)].change);
        gram(a, m) = dot(pairs_[static_cast<std::size_t>(a)].change, g);
      }
      Eigen::MatrixXd total(m, m + 1);
      MPI_Allreduce(gram.data(), total.data(), static_cast<int>(gram.size()), MPI_DOUBLE, MPI_SUM, comm_);
      Eigen::MatrixXd normal = total.leftCols(m);
      normal.diagonal().array() += 1e-8 * normal.trace() + 1e-300;
      const Eigen::VectorXd weight = normal.ldlt().solve(total.col(m));
      for (Eigen::Index a = 0; a < m; ++a) {
        const Pair& p = pairs_[static_cast<std::size_t>(a)];
        for (std::size_t i = 0; i < g.size(); ++i) out[i] -= weight[a] * (p.moved[i] + p.change[i]);
      }
    }
    last_g_ = g, again_ = true;
    return out;
  }
  /// Hears what was really done of it.
  void moved(const std::vector<double>& step, double part) {
    last_move_ = step;
    for (double& v : last_move_) v *= part;
  }
  void forget() { pairs_.clear(), again_ = false; }

private:
  struct Pair {
    std::vector<double> moved, change;  // of the point, of g
  };
  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double s = 0;
    for (std::size_t i = 0; i < a.size(); ++i) s += a[i] * b[i];
    return s;
  }

  MPI_Comm comm_;
  std::size_t depth_;
  std::deque<Pair> pairs_;
  std::vector<double> last_g_, last_move_;
  bool again_ = false;  // there is a last step; of ranks without nodes, too
};

}  // namespace grus::fem
