// SPDX-License-Identifier: LGPL-3.0-or-later
// Where a mesh that looks like one body is none.
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "fem/joined.hpp"
#include "fem/msh_contents.hpp"

namespace grus::fem {
namespace {

Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

std::uint64_t place_of(const Point& x, const Point& low, double width, double shift) {
  std::uint64_t key = 0;
  for (std::size_t k = 0; k < 3; ++k)
    key = key * 0x9e3779b97f4a7c15u +
          static_cast<std::uint64_t>(std::llround(std::floor((x[k] - low[k]) / width + shift)));
  return key;
}

/// Nodes by box of space.
class Boxes {
public:
  Boxes(const std::vector<Point>& at, const Point& low, double width) : low_(low), width_(width) {
    for (std::size_t n = 0; n < at.size(); ++n) nodes_[place_of(at[n], low, width, 0)].push_back(n);
  }
  template <class F>
  void each(const Point& from, const Point& to, F&& found) const {
    Point x;
    for (x[0] = start(from, 0); x[0] < to[0] + width_; x[0] += width_)
      for (x[1] = start(from, 1); x[1] < to[1] + width_; x[1] += width_)
        for (x[2] = start(from, 2); x[2] < to[2] + width_; x[2] += width_)
          if (const auto box = nodes_.find(place_of(x, low_, width_, 0)); box != nodes_.end())
            for (const auto n : box->second) found(n);
  }

private:
  /// Middle of the first box.
  double start(const Point& from, std::size_t k) const {
    return low_[k] + (std::floor((from[k] - low_[k]) / width_) + 0.5) * width_;
  }
  Point low_;
  double width_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> nodes_;
};

/// Distance of a point from a triangle, or from a segment where a = c, if its foot lies within; else infinite.
double distance(const Point& x, const Point& a, const Point& b, const Point& c) {
  const Point u = minus(b, a), v = minus(c, a), w = minus(x, a);
  const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
  const double d = uu * vv - uv * uv;
  double s = uw / uu, t = 0;
  if (d > 1e-20 * uu * uu) s = (vv * uw - uv * vw) / d, t = (uu * vw - uv * uw) / d;
  if (s < -1e-6 || t < -1e-6 || s + t > 1 + 1e-6) return INFINITY;
  const Point off{w[0] - s * u[0] - t * v[0], w[1] - s * u[1] - t * v[1], w[2] - s * u[2] - t * v[2]};
  return std::sqrt(dot(off, off));
}

/// Nodes that coincide with an earlier one, and it; close: in one box of at least one of four grids.
std::vector<std::array<std::size_t, 2>> coincident(const std::vector<Point>& at, const Point& low, double close) {
  std::vector<std::array<std::size_t, 2>> found;
  std::vector<std::uint8_t> told(at.size(), 0);
  for (int grid = 0; grid < 4; ++grid) {
    std::unordered_map<std::uint64_t, std::size_t> first;
    for (std::size_t n = 0; n < at.size(); ++n) {
      const auto [box, fresh] = first.emplace(place_of(at[n], low, 4 * close, 0.25 * grid), n);
      if (fresh || told[n]) continue;
      const Point d = minus(at[n], at[box->second]);
      if (dot(d, d) < close * close) told[n] = 1, found.push_back({box->second, n});
    }
  }
  return found;
}

std::size_t parts(const MshMesh& mesh) {
  Joined nodes(mesh.nodes.size());
  const auto width = static_cast<std::size_t>(corners(mesh.kind));
  for (std::size_t k = 0; k < mesh.cells.size(); ++k)
    nodes.join(static_cast<std::size_t>(mesh.cells[k]), static_cast<std::size_t>(mesh.cells[k - k % width]));
  return nodes.roots().size();
}

/// Nodes of outer sides that lie on another outer side without being a corner of it.
std::vector<std::size_t> hanging(const MshMesh& mesh, const std::vector<CellSide>& sides, const Point& low) {
  std::vector<const CellSide*> outer;
  for (std::size_t k = 0; k < sides.size(); ++k)
    if ((k == 0 || sides[k - 1].corner != sides[k].corner) &&
        (k + 1 == sides.size() || sides[k + 1].corner != sides[k].corner))
      outer.push_back(&sides[k]);
  std::vector<std::size_t> node;
  double width = 0;
  const auto bounds = [&](const CellSide& side) {
    Point from{INFINITY, INFINITY, INFINITY}, to{-INFINITY, -INFINITY, -INFINITY};
    for (const auto n : side.corner)
      for (std::size_t k = 0; n >= 0 && k < 3; ++k)
        from[k] = std::min(from[k], mesh.nodes[static_cast<std::size_t>(n)][k]),
        to[k] = std::max(to[k], mesh.nodes[static_cast<std::size_t>(n)][k]);
    return std::pair{from, to};
  };
  for (const CellSide* side : outer) {
    const auto [from, to] = bounds(*side);
    width += std::sqrt(dot(minus(to, from), minus(to, from))) / static_cast<double>(outer.size());
    for (const auto n : side->corner)
      if (n >= 0) node.push_back(static_cast<std::size_t>(n));
  }
  std::sort(node.begin(), node.end());
  node.erase(std::unique(node.begin(), node.end()), node.end());
  std::vector<Point> at;
  for (const auto n : node) at.push_back(mesh.nodes[n]);
  const Boxes boxes(at, low, width);
  std::vector<std::uint8_t> found(node.size(), 0);
  for (const CellSide* side : outer) {
    std::vector<Point> corner;
    for (const auto n : side->corner)
      if (n >= 0) corner.push_back(mesh.nodes[static_cast<std::size_t>(n)]);
    const auto [from, to] = bounds(*side);
    const double size = std::sqrt(dot(minus(to, from), minus(to, from)));
    boxes.each(from, to, [&](std::size_t k) {
      for (const Point& c : corner)
        if (const Point d = minus(at[k], c); dot(d, d) < 1e-12 * size * size) return;
      double least = INFINITY;  // the corners of a quadrilateral are sorted: all its four triangles are tried
      for (std::size_t i = 0; i < corner.size(); ++i)
        least = std::min(least,
                         distance(at[k], corner[i], corner[(i + 1) % corner.size()], corner[(i + 2) % corner.size()]));
      if (least < 1e-6 * size) found[k] = 1;
    });
  }
  std::vector<std::size_t> nodes;
  for (std::size_t k = 0; k < node.size(); ++k)
    if (found[k]) nodes.push_back(node[k]);
  return nodes;
}

}  // namespace

std::vector<std::string> openings(const MshMesh& mesh, const std::vector<CellSide>& sides,
                                  const std::vector<long long>& number) {
  std::vector<std::string> notes;
  Point low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (const auto& x : mesh.nodes)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
  const Point across = minus(high, low);
  if (const std::size_t n = parts(mesh); n > 1)
    notes.push_back(
        std::to_string(n) +
        " parts share no node: each moves without the others (in Gmsh: BooleanFragments, or Coherence Mesh)");
  if (const auto pairs = coincident(mesh.nodes, low, 1e-9 * std::sqrt(dot(across, across))); !pairs.empty())
    notes.push_back(std::to_string(pairs.size()) +
                    " nodes lie where another one lies (the first: " + std::to_string(number[pairs[0][0]]) + " and " +
                    std::to_string(number[pairs[0][1]]) + "): nothing holds them together");
  if (const auto nodes = hanging(mesh, sides, low); !nodes.empty())
    notes.push_back(std::to_string(nodes.size()) +
                    " nodes lie on sides of elements that do not have them (the first: " +
                    std::to_string(number[nodes[0]]) + "): nothing holds them there");
  return notes;
}

}  // namespace grus::fem
