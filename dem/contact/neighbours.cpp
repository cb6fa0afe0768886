// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/neighbours.hpp"

#include <algorithm>
#include <atomic>

#include "dem/contact/broad_phase.hpp"
#include "dem/contact/tiles.hpp"
#include "dem/shape/common_normal.hpp"

namespace grus::dem {
namespace {

/// Contacts of the list before, where grains were split since: looked up by grain.
struct Past {
  const NeighbourRoom& old;
  const Contacts& lists;  // whose index of grains and bins are still those of before
  std::span<const Index> origin;

  Index before(Index i) const { return origin.empty() ? i : origin[i]; }

  /// Index in the old list, or `none`.
  Index find(Index a, Index b, std::array<std::int16_t, 3> image, bool wall) const {
    Index p = before(a), q = wall ? b : before(b);
    if (!wall && p == q) return none;  // siblings
    if (!wall && p > q) {
      std::swap(p, q);
      for (auto& v : image) v = static_cast<std::int16_t>(-v);
    }
    if (static_cast<std::size_t>(p) + 1 >= lists.first.size()) return none;
    for (Index e = lists.first[p]; e < lists.first[p + 1]; ++e) {
      if (lists.entry[e] & 1) break;  // pairs of which p is a come first
      const Index k = lists.entry[e] >> 1;
      const Pair& pair = old.pair[k];
      if (pair.b == q && (k >= lists.begin[sphere_wall]) == wall && (wall || pair.image == image)) return k;
    }
    return none;
  }

  static constexpr Index none = ~Index{0};
};

/// Contacts of a tile of the list before, where grains are the same: both lists are sorted, so one walk finds all.
struct Walk {
  std::span<const Pair> old;
  std::array<Index, 2 * bin_count> at, end;

  Walk(std::span<const Pair> old, const std::array<std::vector<Index>, bin_count>& tile, const std::array<std::vector<Index>, bin_count>& apart, std::size_t t) : old(old) {
    for (std::size_t bin = 0; bin < bin_count; ++bin) {
      at[2 * bin] = tile[bin][t], end[2 * bin] = at[2 * bin + 1] = apart[bin][t], end[2 * bin + 1] = tile[bin][t + 1];
    }
  }

  /// Index in the old list, or Past::none. Pairs are asked for in ascending order.
  Index find(Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) {
    for (std::size_t h = 2 * static_cast<std::size_t>(bin); h < 2 * static_cast<std::size_t>(bin) + 2; ++h) {
      Index& k = at[h];
      while (k < end[h] && before(old[k], a, b, image)) ++k;
      if (k < end[h] && old[k].a == a && old[k].b == b && old[k].image == image) return k;
    }
    return Past::none;
  }

  static bool before(const Pair& p, Index a, Index b, const std::array<std::int16_t, 3>& image) {
    if (p.a != a) return p.a < a;
    return p.b != b ? p.b < b : p.image < image;
  }
};

bool close(const Grains& g, const Cell& cell, const Candidate& pair, double skin) {
  const Motion &a = g.motion[pair.a], &b = g.motion[pair.b];
  Vec3 r = b.position - a.position;
  if ((pair.image[0] | pair.image[1] | pair.image[2]) != 0) r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const double reach = a.radius + b.radius + skin;
  return r.squaredNorm() < reach * reach;
}

/// Exact-gap test for pairs that involve a poly-ellipsoid; `normal`: the last search direction if there is one; left for the next.
bool near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, Vec3& normal) {
  const Frame &fa = g.frame[pair.a], &fb = g.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (cell.periodic()) r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
  if (normal != Vec3::Zero()) return separation_test(shapes, fa.axes.transpose() * normal) > -skin;
  // Any direction whose separation exceeds the skin settles it: most candidates go here, before the full search.
  const Vec3 line = shapes.r.normalized();
  if (separation_test(shapes, line) < -skin) return false;
  const Vec3 scaled = line.cwiseQuotient(octant_squares(shapes.a, line)).normalized();
  if (separation_test(shapes, scaled) < -skin) return false;
  const CommonNormal found = cold_common_normal(shapes);
  normal = fa.axes * found.normal;
  return !found.converged || found.overlap > -skin;
}

/// What the affine motion of a cell since `before` may take off the gap of pairs at the end of their reach.
double affine_loss(const Cell& cell, const Mat3& before, double reach) {
  if (!cell.periodic()) return 0;
  return (cell.vectors * before.inverse() - Mat3::Identity()).norm() * reach;
}

/// True while the candidates hold every pair within `skin`: no grain has gone or grown by what is left of the reserve.
bool candidates_hold(const Grains& grains, const Cell& cell, double skin, NeighbourRoom& room, Team& team) {
  const std::size_t n = grains.size();
  if (room.anchor.size() != n || cell.periodic() != (room.cell(0, 0) != 0)) return false;
  const double budget = 0.5 * (room.skin - skin - affine_loss(cell, room.cell, 2 * room.largest + room.skin));
  if (!(budget > 0)) return false;
  const Mat3 affine = cell.periodic() ? Mat3(cell.vectors * room.cell.inverse()) : Mat3(Mat3::Identity());
  std::atomic<bool> hold{true};
  team.blocks(n, [&](std::size_t begin, std::size_t end) {
    bool all = true;
    for (std::size_t i = begin; i < end; ++i) {
      const Motion& m = grains.motion[i];
      const auto& [position, radius] = room.anchor[i];
      const double way = budget - std::max(0.0, m.radius - radius);
      all = all && way > 0 && (m.position - (cell.periodic() ? Vec3(affine * position) : position)).squaredNorm() <= way * way;
    }
    if (!all) hold.store(false, std::memory_order_relaxed);
  });
  return hold;
}

/// Candidates are searched with a reserve beyond the skin, and serve as long as it lasts. Lists that end with a breakage, and
/// the first, have none: nobody knows yet that they will last.
void renew_candidates(const Grains& grains, const Cell& cell, double skin, bool lasting, NeighbourRoom& room, Team& team) {
  if (lasting && candidates_hold(grains, cell, skin, room, team)) return;
  room.skin = lasting && !room.anchor.empty() ? 2.5 * skin : skin;
  room.cell = cell.vectors, room.largest = 0;
  for (const Motion& m : grains.motion) room.largest = std::max(room.largest, m.radius);
  if (cell.periodic()) room.skin = std::max(skin, std::min(room.skin, 1 / cell.vectors.inverse().rowwise().norm().maxCoeff() - 2 * room.largest));
  room.anchor.clear();  // should the search fail, nothing vouches for what it leaves
  find_candidates(grains, cell, room.skin, room.candidates, team);
  for (const Motion& m : grains.motion) room.anchor.push_back({m.position, m.radius});
}

}  // namespace

void index_grains(std::size_t grains, Contacts& contacts, std::vector<Index>& next) {
  contacts.first.assign(grains + 1, 0);
  const std::size_t walls = contacts.begin[sphere_wall];
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ++contacts.first[contacts.pair[k].a + 1];
    if (k < walls) ++contacts.first[contacts.pair[k].b + 1];
  }
  for (std::size_t i = 0; i < grains; ++i) contacts.first[i + 1] += contacts.first[i];
  contacts.entry.resize(contacts.first[grains]);
  next.assign(contacts.first.begin(), contacts.first.end() - 1);
  for (std::size_t k = 0; k < contacts.size(); ++k) contacts.entry[next[contacts.pair[k].a]++] = static_cast<Index>(2 * k);
  for (std::size_t k = 0; k < walls; ++k) contacts.entry[next[contacts.pair[k].b]++] = static_cast<Index>(2 * k + 1);
}

void build_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                    std::span<const Index> origin, Contacts& contacts, NeighbourReference& reference, Team& team, bool indexed) {
  NeighbourRoom& room = reference.room;
  renew_candidates(grains, boundary.cell, skin, origin.empty(), room, team);
  const std::size_t tiles = tile_count(grains.size()), size = tile_size(grains.size());
  const bool same = origin.empty() && reference.position.size() == grains.size() && contacts.tile[0].size() == tiles + 1;
  if (!same && contacts.first.empty()) index_grains(reference.position.size(), contacts, room.next);
  room.pair.swap(contacts.pair), std::swap(room.contact, contacts.contact), room.touch.swap(contacts.touch);
  const Past past{room, contacts, origin};
  const auto& candidate = room.candidates.pair;
  const auto& row = room.candidates.row;
  const bool polys = !grains.frame.empty();

  // Which candidates go on the list, and where their histories are. In each tile and bin, pairs that touch come first.
  room.listing.resize(candidate.size());
  if (polys) room.normal.assign(candidate.size(), Vec3::Zero());
  room.wall_pairs.resize(tiles), room.crossing.resize(tiles);
  room.counts.assign(tiles, {});
  room.work.resize(tiles + 1);
  for (std::size_t t = 0; t <= tiles; ++t) room.work[t] = row[std::min(grains.size(), t * size)];
  auto touched = [&](Index k) { return k != Past::none && room.contact.touching(k); };
  auto look_up = [&](std::size_t first, std::size_t last, auto&& finder) {
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * size, end = std::min(grains.size(), begin + size);
      auto find = finder(t);
      auto& count = room.counts[t];
      for (std::size_t k = row[begin]; k < row[end]; ++k) {
        const Candidate& c = candidate[k];
        auto& listed = room.listing[k];
        listed.bin = bin_count;
        if (!close(grains, boundary.cell, c, skin)) continue;
        const Bin bin = polys && !(grains.round[c.a] && grains.round[c.b]) ? general : sphere_sphere;
        listed.old = find(bin, c.a, c.b, c.image);
        const bool on = touched(listed.old);
        if (bin == general && !on) {
          Vec3 n = listed.old == Past::none ? Vec3(Vec3::Zero()) : room.touch[listed.old].normal;
          if (past.before(c.a) > past.before(c.b)) n = -n;
          if (!near(grains, boundary.cell, c, skin, n)) continue;
          room.normal[k] = n;
        }
        listed.bin = bin;
        ++count[2 * static_cast<std::size_t>(bin) + !on];
      }
      room.wall_pairs[t].clear();
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
          const Wall& wall = boundary.walls[w];
          const auto& g = grains.motion[i];
          if (wall.normal.dot(g.position - wall.point) > g.radius + skin) continue;
          const Bin bin = grains.round[i] ? sphere_wall : polyellipsoid_wall;
          const auto a = static_cast<Index>(i), b = static_cast<Index>(w), old = find(bin, a, b, {});
          room.wall_pairs[t].push_back({a, b, old});
          ++count[2 * static_cast<std::size_t>(bin) + !touched(old)];
        }
    }
  };
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    if (same)
      look_up(first, last, [&](std::size_t t) {
        return [walk = Walk(room.pair, contacts.tile, contacts.apart, t)](Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) mutable { return walk.find(bin, a, b, image); };
      });
    else
      look_up(first, last, [&](std::size_t) {
        return [&](Bin bin, Index a, Index b, const std::array<std::int16_t, 3>& image) { return past.find(a, b, image, bin >= sphere_wall); };
      });
  });

  // Contacts that leave the list while touching cannot exist: the skin exceeds any gap they could have opened.
  std::size_t total = 0;
  std::array<std::size_t, bin_count + 1> begins{};
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    begins[bin] = total;
    contacts.tile[bin].resize(tiles + 1), contacts.apart[bin].resize(tiles);
    for (std::size_t t = 0; t < tiles; ++t) {
      contacts.tile[bin][t] = static_cast<Index>(total);
      for (std::size_t h = 2 * bin; h < 2 * bin + 2; ++h) {
        const std::size_t pairs = room.counts[t][h];
        if (h & 1) contacts.apart[bin][t] = static_cast<Index>(total);
        room.counts[t][h] = static_cast<Index>(total), total += pairs;
      }
    }
    contacts.tile[bin][tiles] = static_cast<Index>(total);
  }
  begins[bin_count] = total;
  contacts.pair.resize(total);
  for_each_contact_column(contacts.contact, [&](auto& column) { column.resize(total + overrun); });
  contacts.touch.resize(total + overrun), contacts.active.resize(total + overrun);
  for (auto* column : {&contacts.a, &contacts.b, &contacts.law, &contacts.target}) column->resize(total + overrun);
  for (std::size_t k = total; k < total + overrun; ++k) {
    contacts.contact.set(k, {}), contacts.touch[k] = {}, contacts.active[k] = 0;
    contacts.a[k] = contacts.b[k] = contacts.law[k] = contacts.target[k] = 0;
  }
  contacts.tile_work.resize(tiles + 1);
  const int bits = tile_bits(grains.size());
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * size, end = std::min(grains.size(), begin + size);
      room.crossing[t].clear();
      auto list = [&](Bin bin, const Pair& pair, Index old, bool turned) -> std::size_t {
        const bool on = touched(old), wall = bin >= sphere_wall;
        const std::size_t k = room.counts[t][2 * static_cast<std::size_t>(bin) + !on]++;
        contacts.pair[k] = pair;
        contacts.a[k] = pair.a, contacts.b[k] = wall ? 0 : pair.b, contacts.law[k] = pair.law, contacts.active[k] = on;
        contacts.target[k] = pair.b;
        if (!wall && pair.b >> bits != t) room.crossing[t].push_back(static_cast<Index>(k));
        Contact c = on ? room.contact[old] : Contact{};
        if (turned) c.spring = -c.spring;
        contacts.contact.set(k, c);
        if (bin == sphere_sphere || bin == sphere_wall) return k;  // what spheres show is of the last observed step
        Touch& touch = contacts.touch[k];
        touch = old != Past::none ? room.touch[old] : Touch{};
        if (turned) touch.normal = -touch.normal, touch.force = -touch.force;
        return k;
      };
      for (std::size_t k = row[begin]; k < row[end]; ++k) {
        const Candidate& c = candidate[k];
        const auto& listed = room.listing[k];
        if (listed.bin == bin_count) continue;
        const Pair pair{c.a, c.b, c.image, static_cast<std::uint16_t>(grains.material[c.a] * materials + grains.material[c.b])};
        const std::size_t to = list(listed.bin, pair, listed.old, past.before(c.a) > past.before(c.b));
        if (listed.bin == general && !touched(listed.old)) contacts.touch[to].normal = room.normal[k];
      }
      for (const auto& [a, b, old] : room.wall_pairs[t]) {
        const Pair pair{a, b, {}, static_cast<std::uint16_t>(grains.material[a] * materials + boundary.walls[b].material)};
        list(grains.round[a] ? sphere_wall : polyellipsoid_wall, pair, old, false);
      }
      weigh_tile(grains, t, begin, end, contacts);
    }
  });
  contacts.begin = begins;
  contacts.tile_work[0] = 0;
  for (std::size_t t = 0; t < tiles; ++t) contacts.tile_work[t + 1] += contacts.tile_work[t];
  contacts.energy.resize(std::max(contacts.energy.size(), tiles));
  assign_targets(grains.size(), room.crossing, contacts, room.receivers, room.next);
  index_images(boundary.cell, contacts);
  contacts.first.clear();
  if (indexed) index_grains(grains.size(), contacts, room.next);

  ++reference.builds;
  reference.skin = skin, reference.grown = 0, reference.travelled = 0;
  reference.cell = boundary.cell.vectors;
  reference.position.resize(grains.size());
  reference.largest = room.largest;
  if (polys)  // radii of spheres never change
    for (const auto& m : grains.motion) reference.largest = std::max(reference.largest, m.radius);
  team.blocks(grains.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) reference.position[i] = grains.motion[i].position;
  });
  if (polys) reference.orientation = grains.orientation;
  else reference.orientation.clear();
  reference.wall_point.clear();
  for (const auto& wall : boundary.walls) reference.wall_point.push_back(wall.point);
}

bool list_is_stale(const Grains& grains, const Boundary& boundary, NeighbourReference& ref) {
  double budget = ref.skin - 2 * ref.grown;
  const bool periodic = boundary.cell.periodic();
  budget -= affine_loss(boundary.cell, ref.cell, 2 * ref.largest + ref.skin);
  const Mat3 affine = periodic ? Mat3(boundary.cell.vectors * ref.cell.inverse()) : Mat3(Mat3::Identity());
  double walls = 0;
  for (std::size_t w = 0; w < boundary.walls.size(); ++w)
    walls = std::max(walls, std::abs(boundary.walls[w].normal.dot(boundary.walls[w].point - ref.wall_point[w])));
  const double limit = std::min(0.5 * budget, budget - walls);
  if (limit <= 0) return true;
  if (ref.travelled <= limit) return false;  // not even the fastest, straight on
  double furthest = 0;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Vec3 moved = grains.motion[i].position - (periodic ? Vec3(affine * ref.position[i]) : ref.position[i]);
    double path = moved.norm();
    // Chord of the quaternion difference is half the angle: surface points move by at most radius * angle.
    if (!ref.orientation.empty() && !grains.round[i]) {
      const auto &p = grains.orientation[i].coeffs(), &q = ref.orientation[i].coeffs();
      path += 2.01 * std::min((p - q).norm(), (p + q).norm()) * grains.motion[i].radius;
    }
    if (!(path <= limit)) return true;
    furthest = std::max(furthest, path);
  }
  ref.travelled = furthest;
  return false;
}

}  // namespace grus::dem
