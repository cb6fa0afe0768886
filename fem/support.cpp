// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/support.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "fem/joined.hpp"
#include "fem/problem_impl.hpp"

namespace grus::fem {
namespace {

constexpr double nothing = 1e-12;  // of the largest eigenvalue: far below a lever of a hundred-thousandth of the body

using Motions = Eigen::Matrix<double, 6, 1>;
using Gram = Eigen::Matrix<double, 6, 6>;

/// Displacement of a component at a place by unit translations along the axes and unit turns about them.
Motions motions_at(std::size_t component, const Eigen::Vector3d& x) {
  Motions m = Motions::Zero();
  m[static_cast<Eigen::Index>(component)] = 1;
  for (int axis = 0; axis < 3; ++axis)
    m[3 + axis] = Eigen::Vector3d::Unit(axis).cross(x)[static_cast<Eigen::Index>(component)];
  return m;
}

/// The motions of a body that are none of its strain, of six.
std::vector<int> rigid(const Problem::Impl& p) {
  if (p.discretisation.kinematics == Kinematics::axisymmetric) return {1};
  if (p.dim == 2) return {0, 1, 5};
  return {0, 1, 2, 3, 4, 5};
}

/// How many of some motions nothing stops.
int free_among(const Gram& held, const std::vector<int>& some) {
  const Eigen::MatrixXd part = held(some, some);
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(part, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = values.maxCoeff();
  return static_cast<int>((values.array() <= nothing * largest).count());
}

std::string told(const Gram& held, const std::vector<int>& all) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : " and ") + what; };
  std::vector<int> along;
  int left = free_among(held, all);
  for (const int k : all)
    if (k < 3) {
      along.push_back(k);
      if (held(k, k) == 0) add(std::string("moving along ") + "xyz"[k]), --left;
    }
  const int moving = free_among(held, along);
  for (const int k : all) {
    if (k < 3) continue;
    std::vector<int> with = along;
    with.push_back(k);
    if (left > 0 && free_among(held, with) > moving) add(std::string("turning about ") + "xyz"[k - 3]), --left;
  }
  if (left > 0) add("turning about the line through what is held");
  return text;
}

/// The sums over what is prescribed of a part's products of motions, in lengths of the body.
Gram held_of(const Problem::Impl& p, const std::vector<std::size_t>& part, std::size_t which) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {INFINITY, INFINITY, INFINITY};  // high: of -x
  for (std::size_t n = 0; n < p.node_at.size(); ++n)
    for (std::size_t k = 0; k < 3 && part[n] == which; ++k)
      low[k] = std::min(low[k], p.node_at[n][k]), high[k] = std::min(high[k], -p.node_at[n][k]);
  MPI_Allreduce(MPI_IN_PLACE, low, 3, MPI_DOUBLE, MPI_MIN, p.comm);
  MPI_Allreduce(MPI_IN_PLACE, high, 3, MPI_DOUBLE, MPI_MIN, p.comm);
  Eigen::Vector3d middle, size;
  for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (low[k] - high[k]), size[k] = -high[k] - low[k];
  Gram held = Gram::Zero();
  for (const Prescribed& c : p.prescribed) {
    const auto node = static_cast<std::size_t>(c.dof) / p.width();
    if (node >= static_cast<std::size_t>(p.owned_nodes()) || part[node] != which) continue;
    const Eigen::Vector3d x(p.node_at[node][0], p.node_at[node][1], p.node_at[node][2]);
    const Motions m = motions_at(static_cast<std::size_t>(c.dof) % p.width(), (x - middle) / size.maxCoeff());
    held += m * m.transpose();
  }
  MPI_Allreduce(MPI_IN_PLACE, held.data(), 36, MPI_DOUBLE, MPI_SUM, p.comm);
  return held;
}

}  // namespace

std::string loose_motions(Problem& problem) {
  const Problem::Impl& p = problem.impl();
  int ranks = 1;
  MPI_Comm_size(p.comm, &ranks);
  std::vector<std::size_t> part(p.node_at.size(), 0), parts{0};  // of each local node; on many ranks the whole is one
  if (ranks == 1) {
    Joined nodes(part.size());
    for (std::int32_t c = 0; c < p.cells; ++c)
      for (const std::int32_t n : p.cell_nodes(c))
        nodes.join(static_cast<std::size_t>(n), static_cast<std::size_t>(p.cell_nodes(c)[0]));
    for (std::size_t n = 0; n < part.size(); ++n) part[n] = nodes.root(n);
    parts = nodes.roots();
  }
  for (const std::size_t which : parts) {
    const std::string motions = told(held_of(p, part, which), rigid(p));
    if (!motions.empty())
      return motions + (parts.size() == 1 ? "" : " of a part of the mesh that shares no node with the rest");
  }
  return "";
}

}  // namespace grus::fem
