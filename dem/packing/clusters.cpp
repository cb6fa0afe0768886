// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/clusters.hpp"

namespace grus::dem {
namespace {

constexpr int rounds_of_clusters = 5;

/// The Voronoi cells of one grain go behind those of the others.
void append(Tessellation part, const Mat3& axes, const Vec3& origin, Index cluster, Tessellation& all) {
  const auto first = static_cast<Index>(all.seed.size());
  for (std::size_t i = 0; i < part.seed.size(); ++i) {
    for (auto& p : part.partner[i]) p.cell += first;
    place(part.body[i], axes, origin);
    all.seed.push_back(axes * part.seed[i] + origin);
    all.body.push_back(std::move(part.body[i]));
    all.partner.push_back(std::move(part.partner[i]));
    all.cluster.push_back(cluster);
  }
}

}  // namespace

Tessellation fill_grains(const Grains& parents, std::size_t count, int rounds, std::uint64_t seed, Team& team) {
  Tessellation all;
  for (std::size_t i = 0; i < parents.size(); ++i) {
    const PolyEllipsoid& shape = parents.shape[i];
    const TessellationSpace space = polyellipsoid_space(shape, static_cast<double>(count));
    const Mat3 axes = parents.orientation[i].toRotationMatrix();
    append(voronoi_packing(space, count, rounds, seed + i, team), axes,
           parents.motion[i].position - axes * centre_of_mass(shape), static_cast<Index>(i), all);
  }
  return all;
}

void deal_to_clusters(const TessellationSpace& space, std::size_t count, std::uint64_t seed, Team& team,
                      Tessellation& cells) {
  const Tessellation coarse = voronoi_packing(space, count, rounds_of_clusters, seed + 1, team);
  cells.cluster.assign(cells.seed.size(), 0);
  team.pieces(cells.seed.size(), [&](std::size_t first, std::size_t last, int) {
    for (std::size_t i = first; i < last; ++i) {
      double nearest = INFINITY;
      for (std::size_t c = 0; c < coarse.seed.size(); ++c) {
        Vec3 to = coarse.seed[c] - cells.seed[i];
        for (int k = 0; k < 3; ++k)
          if (space.periodic[k] > 0) to[k] -= space.periodic[k] * std::round(to[k] / space.periodic[k]);
        if (to.squaredNorm() < nearest) nearest = to.squaredNorm(), cells.cluster[i] = static_cast<Index>(c);
      }
    }
  });
}

}  // namespace grus::dem
