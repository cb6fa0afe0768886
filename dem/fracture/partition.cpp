// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/partition.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

namespace grus::dem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vec4 = Eigen::Vector4d;

/// Weight of half the squared parameters, a point.
constexpr double held_back = 1e-8;
/// In a plane, of the body's size.
constexpr double flush = 1e-10;
/// Two conditions on the planes are one where this part of the second is not new: they would move them far.
constexpr double same_condition = 0.05;

double size_of(const Polyhedron& body) {
  double size = 0;
  for (const Vec3& x : body.vertex) size = std::max(size, (x - body.vertex[0]).norm());
  return size;
}

Vec3 middle_of(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : points) sum += x;
  return sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
}

/// -log likelihood a point of rows of four parameters a class, and the weight that holds them back.
class Likelihood {
public:
  Likelihood(std::span<const Vec3> points, std::span<const int> label, std::size_t count, const Vec3& middle,
             double size)
      : points_(points), label_(label), count_(static_cast<Eigen::Index>(count)), middle_(middle), size_(size) {
    for (const int l : label) told_ += l >= 0;
  }

  double operator()(const VectorXd& w) const { return look(w, nullptr, nullptr); }
  double operator()(const VectorXd& w, VectorXd& gradient, MatrixXd& hessian) const {
    gradient = held_back * w;
    hessian = held_back * MatrixXd::Identity(w.size(), w.size());
    return look(w, &gradient, &hessian);
  }

private:
  double look(const VectorXd& w, VectorXd* gradient, MatrixXd* hessian) const {
    double sum = 0.5 * held_back * w.squaredNorm();
    VectorXd share(count_);
    const double part = 1 / told_;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (label_[i] < 0) continue;
      Vec4 x;
      x << (points_[i] - middle_) / size_, 1;
      for (Eigen::Index a = 0; a < count_; ++a) share[a] = w.segment<4>(4 * a).dot(x);
      const double own = share[label_[i]], top = share.maxCoeff();
      share = (share.array() - top).exp();
      const double all = share.sum();
      sum += part * (std::log(all) + top - own);
      if (!gradient) continue;
      share /= all;
      const Eigen::Matrix4d xx = part * x * x.transpose();
      for (Eigen::Index a = 0; a < count_; ++a) {
        gradient->segment<4>(4 * a) += part * (share[a] - (a == label_[i])) * x;
        for (Eigen::Index b = 0; b < count_; ++b)
          hessian->block<4, 4>(4 * a, 4 * b) += share[a] * ((a == b) - share[b]) * xx;
      }
    }
    return sum;
  }

  std::span<const Vec3> points_;
  std::span<const int> label_;
  Eigen::Index count_;
  Vec3 middle_;
  double size_, told_ = 0;
};

/// A corner of some part.
struct Corner {
  Vec3 at;
  std::size_t of;  // its class
  int own_faces;   // of the body
};

std::vector<Corner> corners_of(const std::vector<Polyhedron>& parts, std::int64_t fresh) {
  std::vector<Corner> corners;
  for (std::size_t a = 0; a < parts.size(); ++a) {
    std::vector<int> own(parts[a].vertex.size(), 0);
    for (const Polyhedron::Face& face : parts[a].face)
      if (face.tag < fresh)
        for (const int v : face.loop) ++own[static_cast<std::size_t>(v)];
    for (std::size_t v = 0; v < own.size(); ++v) corners.push_back({parts[a].vertex[v], a, own[v]});
  }
  return corners;
}

/// Classes that shall be as high as one another at a point, and how far apart the corners there are now (m).
struct Tie {
  Vec3 at;
  std::vector<std::size_t> of;
  double apart;
};

/// Ties of corners nearer than `least` that are not one yet: at the corner of the body, if one is among them, else on
/// its edge.
std::vector<Tie> ties_of(const std::vector<Corner>& corners, double least, double same) {
  std::vector<Tie> ties;
  std::vector<char> taken(corners.size(), 0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (taken[i]) continue;
    std::vector<std::size_t> group{i};
    taken[i] = 1;
    Tie tie{corners[i].at, {}, 0};
    for (std::size_t k = 0; k < group.size(); ++k)
      for (std::size_t j = i + 1; j < corners.size(); ++j) {
        const double apart = (corners[group[k]].at - corners[j].at).norm();
        if (taken[j] || !(apart < least)) continue;
        taken[j] = 1, group.push_back(j), tie.apart = std::max(tie.apart, apart);
      }
    if (!(tie.apart > same)) continue;
    int most = corners[i].own_faces;
    for (const std::size_t k : group) {
      if (corners[k].own_faces > most) most = corners[k].own_faces, tie.at = corners[k].at;
      if (std::find(tie.of.begin(), tie.of.end(), corners[k].of) == tie.of.end()) tie.of.push_back(corners[k].of);
    }
    if (tie.of.size() > 1) ties.push_back(std::move(tie));
  }
  std::stable_sort(ties.begin(), ties.end(), [](const Tie& a, const Tie& b) { return a.apart < b.apart; });
  return ties;
}

/// Labels of class `from` become `to`, higher ones one less.
void join(std::vector<int>& label, std::size_t from, std::size_t to) {
  const int gone = static_cast<int>(from);
  for (int& l : label) {
    if (l == gone) l = static_cast<int>(to);
    if (l > gone) --l;
  }
}

/// The class that part a shares most area with; its points lie in most often, where it has no part.
std::size_t nearest_class(const std::vector<Polyhedron>& parts, std::size_t a, std::int64_t fresh,
                          std::span<const Vec3> points, std::span<const int> label,
                          std::span<const LinearClass> classes) {
  std::vector<double> shared(parts.size(), 0);
  for (const Polyhedron::Face& face : parts[a].face)
    if (face.tag >= fresh) shared[static_cast<std::size_t>(face.tag - fresh)] += moments_of(parts[a], face).area;
  if (parts[a].empty())
    for (std::size_t i = 0; i < points.size(); ++i)
      if (label[i] == static_cast<int>(a)) ++shared[class_at(classes, points[i])];
  shared[a] = -1;
  return static_cast<std::size_t>(std::max_element(shared.begin(), shared.end()) - shared.begin());
}

}  // namespace

std::size_t class_at(std::span<const LinearClass> classes, const Vec3& x) {
  std::size_t best = 0;
  for (std::size_t a = 1; a < classes.size(); ++a)
    if (classes[a].height(x) > classes[best].height(x)) best = a;
  return best;
}

std::vector<LinearClass> fit_classes(std::span<const Vec3> points, std::span<const int> label, std::size_t count,
                                     double size) {
  const Vec3 middle = middle_of(points);
  const Likelihood likelihood(points, label, count, middle, size);
  VectorXd w = VectorXd::Zero(4 * static_cast<Eigen::Index>(count)), gradient;
  MatrixXd hessian;
  for (int k = 0; k < 100; ++k) {
    const double now = likelihood(w, gradient, hessian);
    const VectorXd step = -hessian.ldlt().solve(gradient);
    const double slope = gradient.dot(step);
    if (!(-slope > 1e-12)) break;
    double way = 1;
    while (way > 1e-6 && likelihood(w + way * step) > now + 1e-4 * way * slope) way *= 0.5;
    if (!(way > 1e-6)) break;
    w += way * step;
  }
  std::vector<LinearClass> classes;
  for (std::size_t a = 0; a < count; ++a) {
    const Vec4 of = w.segment<4>(4 * static_cast<Eigen::Index>(a));
    const Vec3 s = of.head<3>() / size;
    classes.push_back({s, of[3] - s.dot(middle)});
  }
  return classes;
}

std::vector<Polyhedron> parts_of(const Polyhedron& body, std::span<const LinearClass> classes, std::int64_t fresh) {
  const double tolerance = flush * size_of(body);
  std::vector<Polyhedron> parts(classes.size(), body);
  for (std::size_t a = 0; a < classes.size(); ++a)
    for (std::size_t b = a + 1; b < classes.size(); ++b) {  // the same plane for both
      const Vec3 n = classes[b].slope - classes[a].slope;
      const double rise = classes[a].bias - classes[b].bias, length = n.norm();
      if (!(length > 0)) {
        parts[rise < 0 ? a : b] = {};
        continue;
      }
      for (const bool above : {false, true}) {
        Polyhedron& part = parts[above ? b : a];
        const double sign = above ? -1 : 1;
        if (!part.empty())
          cut(part, sign / length * n, sign * rise / length, fresh + static_cast<std::int64_t>(above ? a : b),
              tolerance);
      }
    }
  return parts;
}

void join_corners(const Polyhedron& body, std::int64_t fresh, double least, std::vector<LinearClass>& classes) {
  const double size = size_of(body);
  const Vec3 middle = middle_of(body.vertex);
  const auto count = static_cast<Eigen::Index>(classes.size());
  for (int round = 0; round < 4; ++round) {
    const auto ties = ties_of(corners_of(parts_of(body, classes, fresh), fresh), least, 2 * flush * size);
    if (ties.empty()) return;
    VectorXd w(4 * count);
    for (Eigen::Index a = 0; a < count; ++a) {
      const LinearClass& c = classes[static_cast<std::size_t>(a)];
      w.segment<4>(4 * a) << size * c.slope, c.height(middle);
    }
    std::vector<VectorXd> met;  // orthonormal: w has no part along any
    for (const Tie& tie : ties)
      for (std::size_t k = 1; k < tie.of.size(); ++k) {
        VectorXd row = VectorXd::Zero(4 * count);
        Vec4 x;
        x << (tie.at - middle) / size, 1;
        row.segment<4>(4 * static_cast<Eigen::Index>(tie.of[0])) = x;
        row.segment<4>(4 * static_cast<Eigen::Index>(tie.of[k])) = -x;
        row.normalize();
        for (int twice = 0; twice < 2; ++twice)
          for (const VectorXd& q : met) row -= q.dot(row) * q;
        if (!(row.norm() > same_condition)) continue;
        row.normalize();
        met.push_back(row);
      }
    for (int twice = 0; twice < 2; ++twice)
      for (const VectorXd& q : met) w -= q.dot(w) * q;
    for (Eigen::Index a = 0; a < count; ++a) {
      const Vec3 s = w.segment<3>(4 * a) / size;
      classes[static_cast<std::size_t>(a)] = {s, w[4 * a + 3] - s.dot(middle)};
    }
  }
}

double stoutness(const Polyhedron& body) {
  double length = 0;
  for (std::size_t i = 0; i < body.vertex.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) length = std::max(length, (body.vertex[i] - body.vertex[j]).norm());
  return least_width(body) / length;
}

Parting part_by_labels(const Polyhedron& body, std::span<const Vec3> points, std::vector<int> label, std::size_t count,
                       std::int64_t fresh, const PartingRules& rules) {
  const double size = size_of(body);
  Parting out;
  out.of.resize(count);
  std::iota(out.of.begin(), out.of.end(), std::size_t{0});
  for (; count > 1; --count, ++out.joined) {
    std::vector<LinearClass> classes = fit_classes(points, label, count, 0.5 * size);
    join_corners(body, fresh, rules.least_edge * size, classes);
    out.part = parts_of(body, classes, fresh);
    std::size_t worst = 0;
    double least = INFINITY;
    for (std::size_t a = 0; a < count; ++a)
      if (const double now = out.part[a].empty() ? 0 : stoutness(out.part[a]); now < least) least = now, worst = a;
    if (least >= rules.least_stoutness) {
      std::size_t told = 0, off = 0;
      for (std::size_t i = 0; i < points.size(); ++i)
        if (label[i] >= 0) ++told, off += class_at(classes, points[i]) != static_cast<std::size_t>(label[i]);
      out.misfit = static_cast<double>(off) / static_cast<double>(told);
      return out;
    }
    const std::size_t to = nearest_class(out.part, worst, fresh, points, label, classes);
    join(label, worst, to);
    out.of[to] = std::min(out.of[to], out.of[worst]);
    out.of.erase(out.of.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  out.part.clear(), out.of.clear();
  return out;
}

}  // namespace grus::dem
