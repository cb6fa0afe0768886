// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/voronoi.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"

namespace grus::dem {
namespace {

constexpr int cylinder_sides = 48;
constexpr double least_volume = 0.1;  // of the mean; a tiny Voronoi cell rules the time step
constexpr double least_apart = 1e-9;  // of the space's size: seeds in one place
constexpr double flush = 1e-12;       // of the Voronoi cell size: in the plane

struct Bounds {
  Vec3 low, high;
};

Bounds bounds_of(const TessellationSpace& space) {
  Bounds b{Vec3::Zero(), space.periodic};
  if (space.body.empty()) return b;
  b = {space.body.vertex[0], space.body.vertex[0]};
  for (const Vec3& x : space.body.vertex) b.low = b.low.cwiseMin(x), b.high = b.high.cwiseMax(x);
  return b;
}

bool inside(const TessellationSpace& space, const Vec3& x) {
  return std::all_of(space.body.face.begin(), space.body.face.end(),
                     [&](const auto& f) { return f.normal.dot(x) < f.offset; });
}

/// Seeds by the boxes of a coarse grid; an edge holds one seed or so.
struct Grid {
  Bounds bounds;
  Eigen::Array3i count = Eigen::Array3i::Ones();
  double edge = 0;  // of the narrowest side (m): what is r rings away is more than r edges away
  std::vector<Index> first, seed;
  bool periodic;

  Grid(const TessellationSpace& space, const std::vector<Vec3>& seeds)
      : bounds(bounds_of(space)), periodic(space.body.empty()) {
    const Vec3 size = bounds.high - bounds.low;
    const double n = static_cast<double>(seeds.size());
    const double wide = space.extruded ? std::sqrt(size.x() * size.y() / n) : std::cbrt(size.prod() / n);
    edge = INFINITY;
    for (int k = 0; k < 3; ++k) {
      if (!(space.extruded && k == 2)) count[k] = std::max(1, static_cast<int>(size[k] / wide));
      if (count[k] > 1 || periodic) edge = std::min(edge, size[k] / count[k]);
    }
    if (!std::isfinite(edge)) edge = size.maxCoeff();
    first.assign(static_cast<std::size_t>(count.prod()) + 1, 0);
    for (const Vec3& x : seeds) ++first[row(place(x)) + 1];
    for (std::size_t k = 0; k + 1 < first.size(); ++k) first[k + 1] += first[k];
    std::vector<Index> next(first.begin(), first.end() - 1);
    seed.resize(seeds.size());
    for (std::size_t i = 0; i < seeds.size(); ++i) seed[next[row(place(seeds[i]))]++] = static_cast<Index>(i);
  }
  Eigen::Array3i place(const Vec3& x) const {
    const Vec3 size = bounds.high - bounds.low;
    Eigen::Array3i at;
    for (int k = 0; k < 3; ++k)
      at[k] = std::clamp(static_cast<int>((x[k] - bounds.low[k]) / size[k] * count[k]), 0, count[k] - 1);
    return at;
  }
  std::size_t row(const Eigen::Array3i& at) const {
    return static_cast<std::size_t>((at[2] * count[1] + at[1]) * count[0] + at[0]);
  }

  /// Calls f(seed, image) for all that are exactly `ring` boxes of the grid away from `at`. False: there are none, nor
  /// further out.
  template <class F>
  bool over_ring(const Eigen::Array3i& at, int ring, F&& f) const {
    bool any = periodic;
    Eigen::Array3i d;
    for (d[2] = -ring; d[2] <= ring; ++d[2])
      for (d[1] = -ring; d[1] <= ring; ++d[1])
        for (d[0] = -ring; d[0] <= ring; ++d[0]) {
          if (d.abs().maxCoeff() != ring) continue;
          Eigen::Array3i to = at + d, image = Eigen::Array3i::Zero();
          if (periodic)
            for (int k = 0; k < 3; ++k) {
              image[k] = (to[k] >= 0 ? to[k] : to[k] - count[k] + 1) / count[k];
              to[k] -= image[k] * count[k];
            }
          else if ((to < 0).any() || (to >= count).any())
            continue;
          any = true;
          for (Index n = first[row(to)]; n < first[row(to) + 1]; ++n) f(seed[n], image);
        }
    return any;
  }
};

struct Neighbour {
  double distance;
  Vec3 to;  // from the seed
  Tessellation::Partner partner;
};

double reach(const Polyhedron& body, const Vec3& seed) {
  double most = 0;
  for (const Vec3& x : body.vertex) most = std::max(most, (x - seed).squaredNorm());
  return std::sqrt(most);
}

void cut_out(const TessellationSpace& space, const Grid& grid, std::size_t i, Tessellation& cells) {
  const Vec3& seed = cells.seed[i];
  Polyhedron& body = cells.body[i];
  auto& partner = cells.partner[i];
  body = space.body.empty() ? box_between(seed - space.periodic, seed + space.periodic) : space.body;
  partner.clear();
  const Eigen::Array3i at = grid.place(seed);
  std::vector<Neighbour> ring;
  bool more = true;
  for (int r = 0; more && (r == 0 || 2 * reach(body, seed) > (r - 1) * grid.edge); ++r) {
    ring.clear();
    more = grid.over_ring(at, r, [&](Index j, const Eigen::Array3i& image) {
      if (j == i && (image == 0).all()) return;
      const Vec3 to = cells.seed[j] + image.cast<double>().matrix().cwiseProduct(space.periodic) - seed;
      const auto short_image = [&](int k) { return static_cast<std::int16_t>(image[k]); };
      ring.push_back({to.norm(), to, {j, {short_image(0), short_image(1), short_image(2)}}});
    });
    std::sort(ring.begin(), ring.end(), [](const Neighbour& a, const Neighbour& b) { return a.distance < b.distance; });
    for (const Neighbour& n : ring) {
      if (n.distance > 2 * reach(body, seed)) break;
      const Vec3 normal = n.to / n.distance;
      if (!cut(body, normal, normal.dot(seed) + 0.5 * n.distance, static_cast<std::int64_t>(partner.size()),
               flush * grid.edge))
        continue;
      partner.push_back(n.partner);
    }
  }
}

std::vector<Vec3> random_seeds(const TessellationSpace& space, std::size_t count, std::uint64_t seed) {
  const Bounds b = bounds_of(space);
  std::vector<Vec3> seeds;
  for (std::uint64_t tried = 0; seeds.size() < count; ++tried) {
    if (tried > 1000 * (count + 100)) throw InputError("the space has no room for Voronoi cells");
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const double share = random_uniform(seed, tried, Purpose::position, static_cast<std::uint64_t>(k));
      x[k] = b.low[k] + (space.extruded && k == 2 ? 0.5 : share) * (b.high[k] - b.low[k]);
    }
    if (space.body.empty() || inside(space, x)) seeds.push_back(x);
  }
  return seeds;
}

/// Seeds of a drawn-out mesh lie in the plane across its middle: in a long body the round-off of a centre would grow
/// from round to round until Voronoi cells end on each other.
void to_one_plane(const TessellationSpace& space, std::vector<Vec3>& centre) {
  constexpr double round_off = 1e-12;  // of the height
  const Bounds b = bounds_of(space);
  const double middle = 0.5 * (b.low.z() + b.high.z()), off = round_off * (b.high.z() - b.low.z());
  for (Vec3& x : centre)
    if (std::abs(x.z() - middle) > off) x.z() = middle;
}

}  // namespace

double TessellationSpace::volume() const { return body.empty() ? periodic.prod() : moments_of(body).volume; }

TessellationSpace box_space(const Vec3& box) { return {box_between(Vec3::Zero(), box)}; }
TessellationSpace periodic_space(const Vec3& box) { return {{}, box}; }

TessellationSpace cylinder_space(double diameter, double length) {
  std::vector<Vec3> corners;
  const double radius = 0.5 * diameter, outer = radius / std::cos(pi / cylinder_sides);
  for (int k = 0; k < cylinder_sides; ++k) {
    const double angle = 2 * pi * (k + 0.5) / cylinder_sides;
    corners.emplace_back(radius + outer * std::cos(angle), radius + outer * std::sin(angle), 0);
  }
  return {prism_over(corners, 0, length)};
}

TessellationSpace prism_space(std::span<const Vec3> corners, double height) { return {prism_over(corners, 0, height)}; }

TessellationSpace polyellipsoid_space(const PolyEllipsoid& shape, double cells) {
  TessellationSpace space;
  const int directions = static_cast<int>(std::clamp(12 * std::pow(cells, 2.0 / 3), 32.0, 200.0));
  const auto made_of = [&](double scale) {
    space.body = box_between(-1.1 * scale * shape.minus, 1.1 * scale * shape.plus);
    for (int k = 0; k < directions; ++k) {  // a spiral that takes equal steps of area
      const double z = 1 - (2 * k + 1.0) / directions, angle = k * pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
      const Vec3 n(r * std::cos(angle), r * std::sin(angle), z);
      cut(space.body, n, scale * support_height(shape, n), -7 - k, flush * shape.plus.minCoeff());
    }
  };
  made_of(1);
  made_of(std::cbrt(dem::volume(shape) / space.volume()));
  return space;
}

Tessellation voronoi(const TessellationSpace& space, std::vector<Vec3> seeds, Team& team) {
  Tessellation cells;
  const Grid grid(space, seeds);
  cells.seed = std::move(seeds);
  cells.body.resize(cells.seed.size()), cells.partner.resize(cells.seed.size());
  team.pieces(cells.seed.size(), [&](std::size_t first, std::size_t last, int) {
    for (std::size_t i = first; i < last; ++i) cut_out(space, grid, i, cells);
  });
  return cells;
}

namespace {

Tessellation relaxed(const TessellationSpace& space, std::vector<Vec3> seeds, int rounds, Team& team) {
  Tessellation cells = voronoi(space, std::move(seeds), team);
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vec3> centre;
    for (const Polyhedron& body : cells.body) centre.push_back(moments_of(body).centre);
    if (space.extruded) to_one_plane(space, centre);
    for (Vec3& x : centre)
      for (int k = 0; k < 3; ++k)
        if (space.body.empty()) x[k] -= space.periodic[k] * std::floor(x[k] / space.periodic[k]);
    cells = voronoi(space, std::move(centre), team);
  }
  return cells;
}

}  // namespace

Tessellation relaxed_voronoi(const TessellationSpace& space, std::vector<Vec3> seeds, int rounds, Team& team) {
  const Bounds b = bounds_of(space);
  std::vector<std::pair<Vec3, std::size_t>> order;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    Vec3& x = seeds[i];
    const bool within = space.body.empty() || inside(space, x);
    if (!within)
      throw InputError(
          fmt::format("seed {}, {:g}, {:g}, {:g} m, is not inside of what the cells fill", i + 1, x.x(), x.y(), x.z()));
    for (int k = 0; k < 3; ++k)
      if (space.body.empty()) x[k] -= space.periodic[k] * std::floor(x[k] / space.periodic[k]);
    order.emplace_back(x, i);
  }
  const double least = least_apart * (b.high - b.low).maxCoeff();
  std::sort(order.begin(), order.end(), [](const auto& p, const auto& q) {
    return std::tie(p.first.x(), p.second) < std::tie(q.first.x(), q.second);
  });
  for (std::size_t k = 0; k < order.size(); ++k)
    for (std::size_t m = k + 1; m < order.size() && order[m].first.x() - order[k].first.x() <= least; ++m)
      if ((order[m].first - order[k].first).norm() <= least)
        throw InputError(fmt::format("seeds {} and {} are in one place", std::min(order[k].second, order[m].second) + 1,
                                     std::max(order[k].second, order[m].second) + 1));
  return relaxed(space, std::move(seeds), rounds, team);
}

Tessellation voronoi_packing(const TessellationSpace& space, std::size_t count, int rounds, std::uint64_t seed,
                             Team& team) {
  Tessellation cells = relaxed(space, random_seeds(space, count, seed), rounds, team);
  const double least = least_volume * space.volume() / static_cast<double>(count);
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < cells.seed.size(); ++i)
    if (moments_of(cells.body[i]).volume >= least) kept.push_back(cells.seed[i]);
  return kept.size() == cells.seed.size() ? cells : voronoi(space, std::move(kept), team);
}

}  // namespace grus::dem
