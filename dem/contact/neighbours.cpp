// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/neighbours.hpp"

#include <algorithm>

#include "dem/contact/broad_phase.hpp"
#include "dem/shape/common_normal.hpp"

namespace grus::dem {
namespace {

/// Contacts of the list before, by grain.
struct Past {
  const NeighbourRoom& old;
  const Contacts& lists;  // whose adjacency and bins are still those of before
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

void fill_adjacency(std::size_t grains, Contacts& contacts, std::vector<Index>& next) {
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

/// What b feels goes to b's own row in the same tile, else to a row for this pair alone, in the order of (b, pair).
void assign_targets(std::size_t grains, Contacts& contacts, std::vector<Index>& next) {
  const std::size_t walls = contacts.begin[sphere_wall];
  contacts.target.assign(contacts.size() + overrun, 0);
  for (std::size_t k = walls; k < contacts.size(); ++k) contacts.target[k] = contacts.pair[k].b;
  contacts.remote.assign(grains + 1, 0);
  const int bits = tile_bits(grains);
  auto elsewhere = [&](const Pair& p) { return p.a >> bits != p.b >> bits; };
  for (std::size_t k = 0; k < walls; ++k)
    if (elsewhere(contacts.pair[k])) ++contacts.remote[contacts.pair[k].b + 1];
  for (std::size_t i = 0; i < grains; ++i) contacts.remote[i + 1] += contacts.remote[i];
  next.assign(contacts.remote.begin(), contacts.remote.end() - 1);
  for (std::size_t k = 0; k < walls; ++k) {
    const Pair& p = contacts.pair[k];
    contacts.target[k] = elsewhere(p) ? static_cast<Index>(grains) + next[p.b]++ : p.b;
  }
  contacts.load.assign(grains + contacts.remote[grains], {});
}

/// Measured: a pair that touches, one that does not, a grain to be moved.
void weigh_tiles(const Grains& grains, Contacts& contacts) {
  const std::size_t tiles = tile_count(grains.size()), size = tile_size(grains.size());
  contacts.pair_work.assign(tiles + 1, 0), contacts.grain_work.assign(tiles + 1, 0);
  for (std::size_t t = 0; t < tiles; ++t) {
    std::uint64_t cost = 0;
    for (std::size_t bin = 0; bin < bin_count; ++bin) {
      const std::uint64_t touching = bin == general ? 60 : bin == polyellipsoid_wall ? 150 : 15, apart = bin == general ? 12 : 2;
      for (std::size_t k = contacts.tile[bin][t]; k < contacts.tile[bin][t + 1]; ++k) cost += contacts.active[k] ? touching : apart;
    }
    contacts.pair_work[t + 1] = contacts.pair_work[t] + cost;
    cost = 0;
    for (std::size_t i = t * size; i < std::min(grains.size(), (t + 1) * size); ++i) cost += grains.round[i] ? 6 : 150;
    contacts.grain_work[t + 1] = contacts.grain_work[t] + cost;
  }
}

void index_images(const Cell& cell, Contacts& contacts) {
  contacts.shift.clear(), contacts.images.assign(1, {0, 0, 0});
  if (!cell.periodic()) return;
  contacts.shift.reserve(contacts.size() + overrun);
  for (std::size_t k = 0; k < contacts.begin[sphere_wall]; ++k) {
    const auto& image = contacts.pair[k].image;
    std::size_t row = 0;
    while (row < contacts.images.size() && contacts.images[row] != image) ++row;
    if (row == contacts.images.size()) contacts.images.push_back(image);
    contacts.shift.push_back(static_cast<Index>(row));
  }
  contacts.shift.resize(contacts.size() + overrun, 0);
}

}  // namespace

void build_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                    std::span<const Index> origin, Contacts& contacts, NeighbourReference& reference, Team& team) {
  NeighbourRoom& room = reference.room;
  find_candidates(grains, boundary.cell, skin, room.candidates, team);
  room.pair.swap(contacts.pair), room.contact.swap(contacts.contact), room.touch.swap(contacts.touch);
  const Past past{room, contacts, origin};
  const auto& candidate = room.candidates.pair;
  const auto& row = room.candidates.row;
  const bool polys = !grains.frame.empty();
  const std::size_t tiles = tile_count(grains.size()), size = tile_size(grains.size());

  // Which candidates go on the list, and where their histories are. In each tile and bin, pairs that touch come first.
  room.listing.resize(candidate.size());
  if (polys) room.normal.assign(candidate.size(), Vec3::Zero());
  room.wall_pairs.resize(tiles);
  room.counts.assign(tiles, {});
  room.work.resize(tiles + 1);
  for (std::size_t t = 0; t <= tiles; ++t) room.work[t] = row[std::min(grains.size(), t * size)];
  auto touched = [&](Index k) { return k != Past::none && room.contact[k].stiffness > 0; };
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * size, end = std::min(grains.size(), begin + size);
      auto& count = room.counts[t];
      for (std::size_t k = row[begin]; k < row[end]; ++k) {
        const Candidate& c = candidate[k];
        auto& listed = room.listing[k];
        listed.old = past.find(c.a, c.b, c.image, false);
        listed.bin = polys && !(grains.round[c.a] && grains.round[c.b]) ? general : sphere_sphere;
        const bool on = touched(listed.old);
        if (listed.bin == general && !on) {
          Vec3 n = listed.old == Past::none ? Vec3(Vec3::Zero()) : room.touch[listed.old].normal;
          if (past.before(c.a) > past.before(c.b)) n = -n;
          if (!near(grains, boundary.cell, c, skin, n)) listed.bin = bin_count;
          room.normal[k] = n;
        }
        if (listed.bin != bin_count) ++count[2 * static_cast<std::size_t>(listed.bin) + !on];
      }
      room.wall_pairs[t].clear();
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
          const Wall& wall = boundary.walls[w];
          const auto& g = grains.motion[i];
          if (wall.normal.dot(g.position - wall.point) > g.radius + skin) continue;
          const auto a = static_cast<Index>(i), b = static_cast<Index>(w), old = past.find(a, b, {}, true);
          room.wall_pairs[t].push_back({a, b, old});
          ++count[2 * static_cast<std::size_t>(grains.round[i] ? sphere_wall : polyellipsoid_wall) + !touched(old)];
        }
    }
  });

  // Contacts that leave the list while touching cannot exist: the skin exceeds any gap they could have opened.
  std::size_t total = 0;
  std::array<std::size_t, bin_count + 1> begins{};
  for (std::size_t bin = 0; bin < bin_count; ++bin) {
    begins[bin] = total;
    contacts.tile[bin].resize(tiles + 1);
    for (std::size_t t = 0; t < tiles; ++t) {
      contacts.tile[bin][t] = static_cast<Index>(total);
      for (std::size_t h = 2 * bin; h < 2 * bin + 2; ++h) {
        const std::size_t pairs = room.counts[t][h];
        room.counts[t][h] = static_cast<Index>(total), total += pairs;
      }
    }
    contacts.tile[bin][tiles] = static_cast<Index>(total);
  }
  begins[bin_count] = total;
  contacts.pair.resize(total);
  contacts.contact.resize(total + overrun), contacts.touch.resize(total + overrun), contacts.active.resize(total + overrun);
  for (auto* column : {&contacts.a, &contacts.b, &contacts.law}) column->resize(total + overrun);
  for (std::size_t k = total; k < total + overrun; ++k) {
    contacts.contact[k] = {}, contacts.touch[k] = {}, contacts.active[k] = 0;
    contacts.a[k] = contacts.b[k] = contacts.law[k] = 0;
  }
  team.pieces(tiles, room.work, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * size, end = std::min(grains.size(), begin + size);
      auto list = [&](std::size_t bin, const Pair& pair, Index old, bool turned, double effective_mass) -> Touch& {
        const bool on = touched(old);
        const std::size_t k = room.counts[t][2 * bin + !on]++;
        contacts.pair[k] = pair;
        contacts.a[k] = pair.a, contacts.b[k] = bin < sphere_wall ? pair.b : 0, contacts.law[k] = pair.law, contacts.active[k] = on;
        Contact& c = contacts.contact[k];
        Touch& touch = contacts.touch[k];
        if (old != Past::none) c = room.contact[old], touch = room.touch[old];
        else c = {}, touch = {};
        if (turned) touch.normal = -touch.normal, c.spring = -c.spring, touch.force = -touch.force;
        c.effective_mass = effective_mass;
        return touch;
      };
      for (std::size_t k = row[begin]; k < row[end]; ++k) {
        const Candidate& c = candidate[k];
        const auto& listed = room.listing[k];
        if (listed.bin == bin_count) continue;
        const Pair pair{c.a, c.b, c.image, static_cast<std::uint16_t>(grains.material[c.a] * materials + grains.material[c.b])};
        Touch& touch = list(static_cast<std::size_t>(listed.bin), pair, listed.old, past.before(c.a) > past.before(c.b),
                            1 / (grains.motion[c.a].inverse_mass + grains.motion[c.b].inverse_mass));
        if (listed.bin == general && !touched(listed.old)) touch.normal = room.normal[k];
      }
      for (const auto& [a, b, old] : room.wall_pairs[t]) {
        const Pair pair{a, b, {}, static_cast<std::uint16_t>(grains.material[a] * materials + boundary.walls[b].material)};
        list(static_cast<std::size_t>(grains.round[a] ? sphere_wall : polyellipsoid_wall), pair, old, false, grains.mass[a]);
      }
    }
  });
  contacts.begin = begins;
  weigh_tiles(grains, contacts);
  contacts.energy.resize(std::max(contacts.energy.size(), tiles));
  assign_targets(grains.size(), contacts, room.candidates.next);
  index_images(boundary.cell, contacts);
  fill_adjacency(grains.size(), contacts, room.candidates.next);

  ++reference.builds;
  reference.skin = skin, reference.grown = 0, reference.travelled = 0;
  reference.cell = boundary.cell.vectors;
  reference.position.resize(grains.size());
  reference.largest = 0;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    reference.position[i] = grains.motion[i].position;
    reference.largest = std::max(reference.largest, grains.motion[i].radius);
  }
  if (polys) reference.orientation = grains.orientation;
  else reference.orientation.clear();
  reference.wall_point.clear();
  for (const auto& wall : boundary.walls) reference.wall_point.push_back(wall.point);
}

bool list_is_stale(const Grains& grains, const Boundary& boundary, NeighbourReference& ref) {
  double budget = ref.skin - 2 * ref.grown;
  const bool periodic = boundary.cell.periodic();
  Mat3 affine = Mat3::Identity();
  if (periodic) {
    affine = boundary.cell.vectors * ref.cell.inverse();
    budget -= (affine - Mat3::Identity()).norm() * (2 * ref.largest + ref.skin);
  }
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
