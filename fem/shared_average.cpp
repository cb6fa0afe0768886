// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/shared_average.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace grus::fem {
namespace {

constexpr int digits = 40;       // of the quantum
constexpr double room = 0x1p50;  // quanta of one contribution, of which 2^12 may meet
constexpr std::size_t most_columns = 6;

std::array<double, 2> over_all(MPI_Comm comm, const std::array<double, 2>& mine) {
  std::array<double, 2> all{};
  MPI_Allreduce(mine.data(), all.data(), 2, MPI_DOUBLE, MPI_MAX, comm);
  return all;
}

}  // namespace

SharedAverage::SharedAverage(const AverageElements& of, double length, double promised, int most_degree)
    : of_(of),
      width_(of.columns.size()),
      sum_(of.p.mesh->geometry().index_map(), static_cast<int>(width_)),
      mean_(of.p.mesh->geometry().index_map(), static_cast<int>(width_)) {
  std::array<double, 2> bounds{INFINITY, 0};
  const bool turned = of_.p.discretisation.kinematics == Kinematics::axisymmetric;
  of_.each([&](std::size_t first, std::size_t end) {
    const AverageElements::Element e = of_.element(first, end, length);
    of_.widen(bounds, e);
    cells_.push_back({first, end, plain_.size()});
    plain_.insert(plain_.end(), e.plain.data(), e.plain.data() + e.plain.size());
    if (turned) turning_.insert(turning_.end(), e.turning.data(), e.turning.data() + e.turning.size());
  });
  const auto all = over_all(of_.p.comm, {-bounds[0], bounds[1]});
  steps_.emplace(std::array{-all[0], all[1]}, promised, most_degree);
  right_.assign(cells_.size() * static_cast<std::size_t>(of_.corners) * width_, 0);
  const auto owned = static_cast<std::size_t>(of_.p.mesh->geometry().index_map()->size_local()) * width_;
  residual_.assign(owned, 0), change_ = residual_;
  mean_.set(0);
  find_scales();
}

/// Diagonals and weights of the nodes, which owners tell those who share them.
void SharedAverage::find_scales() {
  const auto corners = static_cast<std::size_t>(of_.corners);
  const auto map = of_.p.mesh->geometry().index_map();
  std::vector<Contribution> diagonal, weight;
  for (const Cell& cell : cells_) {
    const std::int32_t* at = of_.nodes.data() + cell.first * corners;
    for (std::size_t a = 0; a < corners; ++a)
      for (std::size_t c = 0; c < width_; ++c) {
        const std::size_t entry = cell.matrix + a * (corners + 1);
        const double turned = turning_.empty() ? 0 : of_.columns[c].turns * turning_[entry];
        diagonal.push_back({static_cast<std::int32_t>(place(at[a], c)), plain_[entry] + turned});
      }
    for (std::size_t i = cell.first; i < cell.end; ++i)
      for (std::size_t a = 0; a < corners; ++a)
        for (std::size_t c = 0; c < width_; ++c)
          weight.push_back({static_cast<std::int32_t>(place(at[a], c)), of_.volumes[i] * of_.shares[i * corners + a]});
  }
  const auto inverted = [&](const std::vector<Contribution>& parts) {
    Numbers sums(map, static_cast<int>(width_));
    NodalQuanta(of_.p.comm, map, static_cast<int>(width_))
        .add_up(parts, sums.mutable_array().subspan(0, residual_.size()));
    sums.scatter_fwd();
    std::vector<double> inverse;
    for (const double s : sums.array()) inverse.push_back(s > 0 ? 1 / s : 0);
    return inverse;
  };
  inverse_ = inverted(diagonal), lightness_ = inverted(weight);
}

/// What elements `give(add)` to places of nodes, over all ranks, on the owners.
template <class Give>
void SharedAverage::add_up(std::vector<double>& owned, Give&& give) {
  sum_.set(0);
  auto sum = sum_.mutable_array();
  give([&](std::size_t at, double value) {
    const double quanta = value * up_;
    too_big_ = too_big_ || !(std::abs(quanta) < room);
    sum[at] += std::llrint(std::clamp(quanta, -room, room));
  });
  sum_.scatter_rev(std::plus<std::int64_t>());
  for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = static_cast<double>(sum[i]) / up_;
}

/// The right side's sums, each scaled before it is rounded.
void SharedAverage::give_to_nodes(const std::vector<double>& scale, std::vector<double>& owned) {
  const auto corners = static_cast<std::size_t>(of_.corners);
  add_up(owned, [&](auto&& add) {
    const double* right = right_.data();
    for (const Cell& cell : cells_)
      for (std::size_t a = 0; a < corners; ++a)
        for (std::size_t c = 0; c < width_; ++c) {
          const std::size_t at = place(of_.nodes[cell.first * corners + a], c);
          add(at, scale[at] * *right++);
        }
  });
}

void SharedAverage::mean_of_nearest() {
  give_to_nodes(lightness_, residual_);
  std::copy(residual_.begin(), residual_.end(), mean_.mutable_array().begin());
  mean_.scatter_fwd();
}

/// Right side less matrix x mean, over the diagonal.
void SharedAverage::find_residual() {
  const auto corners = static_cast<std::size_t>(of_.corners);
  const auto mean = mean_.array();
  add_up(residual_, [&](auto&& add) {
    const double* right = right_.data();
    std::array<double, most_columns> left{};
    for (const Cell& cell : cells_) {
      const std::int32_t* at = of_.nodes.data() + cell.first * corners;
      for (std::size_t a = 0; a < corners; ++a, right += width_) {
        std::copy_n(right, width_, left.begin());
        for (std::size_t b = 0; b < corners; ++b) {
          const std::size_t entry = cell.matrix + a * corners + b;
          const double turning = turning_.empty() ? 0 : turning_[entry];
          const double* m = mean.data() + place(at[b], 0);
          for (std::size_t c = 0; c < width_; ++c) left[c] -= (plain_[entry] + of_.columns[c].turns * turning) * m[c];
        }
        for (std::size_t c = 0; c < width_; ++c) add(place(at[a], c), inverse_[place(at[a], c)] * left[c]);
      }
    }
  });
}

bool SharedAverage::operator()(std::span<const double> field, std::span<double> mean, bool asks) {
  const auto corners = static_cast<std::size_t>(of_.corners);
  double most = too_big_ ? INFINITY : 0;
  std::fill(right_.begin(), right_.end(), 0);
  for (std::size_t k = 0; k < cells_.size(); ++k)
    for (std::size_t i = cells_[k].first; i < cells_[k].end; ++i) {
      const double* tensor = field.data() + 6 * i;
      for (std::size_t c = 0; c < width_; ++c) {
        const double value = std::abs(of_.columns[c](tensor));
        most = std::isfinite(value) ? std::max(most, value) : INFINITY;
      }
      of_.load(i, tensor, [&](std::size_t a, std::size_t c, double v) { right_[(k * corners + a) * width_ + c] += v; });
    }
  const auto all = over_all(of_.p.comm, {most, asks ? 1.0 : 0.0});
  if (!std::isfinite(all[0])) {
    std::fill(mean.begin(), mean.end(), std::numeric_limits<double>::quiet_NaN());
    up_ = 0;
    return all[1] != 0;
  }
  int exponent = 0;
  std::frexp(all[0], &exponent);
  up_ = std::ldexp(1.0, digits - std::max(exponent, -900));  // the quantum itself must be a number
  mean_of_nearest();
  steps_->each([&](double by, double share) {
    find_residual();
    auto m = mean_.mutable_array();
    for (std::size_t i = 0; i < change_.size(); ++i) {
      change_[i] = by * change_[i] + share * residual_[i];
      m[i] += change_[i];
    }
    mean_.scatter_fwd();
  });
  const auto m = mean_.array();
  for (std::size_t i = 0; i < of_.points.size(); ++i)
    of_.read(i, mean.data() + 6 * i,
             [&](std::size_t a, std::size_t c) { return m[place(of_.nodes[i * corners + a], c)]; });
  return all[1] != 0;
}

/// Of numbers over the diagonal, in the norm of the residual's bound; a sum over all ranks.
double SharedAverage::squared(const std::vector<double>& scaled) const {
  return of_.p.sums<1>([&](auto& sum) {
    for (std::size_t i = 0; i < scaled.size(); ++i)
      if (inverse_[i] > 0) sum[0] += scaled[i] * scaled[i] / inverse_[i];
  })[0];
}

double SharedAverage::left_over() {
  if (up_ == 0) return 0;
  const std::vector<double> answer(mean_.array().begin(), mean_.array().end());
  find_residual();
  const double now = std::sqrt(squared(residual_));
  mean_of_nearest();
  find_residual();
  const double first = std::sqrt(squared(residual_));
  give_to_nodes(inverse_, residual_);
  const double all = std::sqrt(squared(residual_));
  std::copy(answer.begin(), answer.end(), mean_.mutable_array().begin());
  return first > 1e-10 * all ? now / first : 0;  // an even field leaves nothing but round-off
}

}  // namespace grus::fem
