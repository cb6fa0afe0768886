// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/neighbours.hpp"

#include <algorithm>

#include "dem/contact/broad_phase.hpp"
#include "dem/shape/common_normal.hpp"

namespace grus::dem {
namespace {

/// Contacts of the list before, by grain.
struct Past {
  const Contacts& old;
  std::span<const Index> origin;

  Index before(Index i) const { return origin.empty() ? i : origin[i]; }

  /// Index in the old list, or -1.
  std::ptrdiff_t find(Index a, Index b, std::array<std::int16_t, 3> image, bool wall) const {
    Index p = before(a), q = wall ? b : before(b);
    if (!wall && p == q) return -1;  // siblings
    if (!wall && p > q) {
      std::swap(p, q);
      for (auto& v : image) v = static_cast<std::int16_t>(-v);
    }
    if (static_cast<std::size_t>(p) + 1 >= old.first.size()) return -1;
    for (Index e = old.first[p]; e < old.first[p + 1]; ++e) {
      const std::size_t k = old.entry[e] >> 1;
      const Pair& pair = old.pair[k];
      if (pair.a == p && pair.b == q && (k >= old.begin[sphere_wall]) == wall && (wall || pair.image == image))
        return static_cast<std::ptrdiff_t>(k);
    }
    return -1;
  }

  /// History of the pair, turned to its present order.
  void carry(Index a, Index b, const std::array<std::int16_t, 3>& image, bool wall, Contact& c, Touch& touch) const {
    const std::ptrdiff_t k = find(a, b, image, wall);
    if (k < 0) return;
    c = old.contact[static_cast<std::size_t>(k)], touch = old.touch[static_cast<std::size_t>(k)];
    if (!wall && before(a) > before(b)) touch.normal = -touch.normal, c.spring = -c.spring, touch.force = -touch.force;
  }
};

/// Exact-gap test for pairs that involve a poly-ellipsoid; leaves a search direction in the contact.
bool near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, const Contact& c, Touch& touch) {
  const Frame &fa = g.frame[pair.a], &fb = g.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (cell.periodic()) r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
  if (c.stiffness > 0) return true;
  if (touch.normal != Vec3::Zero()) return separation_test(shapes, fa.axes.transpose() * touch.normal) > -skin;
  // Any direction whose separation exceeds the skin settles it: most candidates go here, before the full search.
  const Vec3 line = shapes.r.normalized();
  if (separation_test(shapes, line) < -skin) return false;
  const Vec3 scaled = line.cwiseQuotient(octant_squares(shapes.a, line)).normalized();
  if (separation_test(shapes, scaled) < -skin) return false;
  const CommonNormal found = cold_common_normal(shapes);
  touch.normal = fa.axes * found.normal;
  return !found.converged || found.overlap > -skin;
}

void fill_adjacency(std::size_t grains, Contacts& contacts) {
  contacts.first.assign(grains + 1, 0);
  const std::size_t walls = contacts.begin[sphere_wall];
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    ++contacts.first[contacts.pair[k].a + 1];
    if (k < walls) ++contacts.first[contacts.pair[k].b + 1];
  }
  for (std::size_t i = 0; i < grains; ++i) contacts.first[i + 1] += contacts.first[i];
  contacts.entry.resize(contacts.first[grains]);
  std::vector<Index> next(contacts.first.begin(), contacts.first.end() - 1);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contacts.entry[next[contacts.pair[k].a]++] = static_cast<Index>(2 * k);
    if (k < walls) contacts.entry[next[contacts.pair[k].b]++] = static_cast<Index>(2 * k + 1);
  }
}

/// A pair that goes on the list, with its history.
struct Listed {
  Pair pair;
  Contact contact;
  Touch touch;
};

/// What b feels goes to b's own row in the same tile, else to a row for this pair alone, in the order of (b, pair).
void assign_targets(std::size_t grains, Contacts& contacts) {
  const std::size_t walls = contacts.begin[sphere_wall];
  contacts.target.resize(contacts.size());
  contacts.remote.assign(grains + 1, 0);
  auto elsewhere = [](const Pair& p) { return p.a / tile_size != p.b / tile_size; };
  for (std::size_t k = 0; k < walls; ++k)
    if (elsewhere(contacts.pair[k])) ++contacts.remote[contacts.pair[k].b + 1];
  for (std::size_t i = 0; i < grains; ++i) contacts.remote[i + 1] += contacts.remote[i];
  std::vector<Index> next(contacts.remote.begin(), contacts.remote.end() - 1);
  for (std::size_t k = 0; k < walls; ++k) {
    const Pair& p = contacts.pair[k];
    contacts.target[k] = elsewhere(p) ? static_cast<Index>(grains) + next[p.b]++ : p.b;
  }
  contacts.load.assign(grains + contacts.remote[grains], {});
}

void index_images(const Cell& cell, Contacts& contacts) {
  contacts.shift.clear(), contacts.images.clear();
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
  const Candidates candidates = find_candidates(grains, boundary.cell, skin, team);
  const Past past{contacts, origin};  // reads the old columns until they are replaced below
  const bool polys = !grains.frame.empty();
  const std::size_t tiles = tile_count(grains.size());

  // Each tile's pairs with their histories, bin by bin; those that touch first.
  std::vector<std::array<std::vector<Listed>, bin_count>> listed(tiles);
  team.pieces(tiles, [&](std::size_t first, std::size_t last) {
    std::vector<Listed> still;
    for (std::size_t t = first; t < last; ++t) {
      const std::size_t begin = t * tile_size, end = std::min(grains.size(), begin + tile_size);
      auto take = [&](std::vector<Listed>& bin, const Listed& pair) { (pair.contact.stiffness > 0 ? bin : still).push_back(pair); };
      auto add_still = [&](std::vector<Listed>& bin) { bin.insert(bin.end(), still.begin(), still.end()), still.clear(); };
      for (const Bin bin : {sphere_sphere, general}) {
        if (bin == general && !polys) continue;
        for (std::size_t k = candidates.row[begin]; k < candidates.row[end]; ++k) {
          const Candidate& c = candidates.pair[k];
          if (polys && (grains.round[c.a] && grains.round[c.b]) != (bin == sphere_sphere)) continue;
          Listed l{{c.a, c.b, c.image, static_cast<std::uint16_t>(grains.material[c.a] * materials + grains.material[c.b])}, {}, {}};
          past.carry(c.a, c.b, c.image, false, l.contact, l.touch);
          l.contact.effective_mass = 1 / (grains.motion[c.a].inverse_mass + grains.motion[c.b].inverse_mass);
          if (bin == general && !near(grains, boundary.cell, c, skin, l.contact, l.touch)) continue;
          take(listed[t][bin], l);
        }
        add_still(listed[t][bin]);
      }
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
          const Wall& wall = boundary.walls[w];
          const auto& g = grains.motion[i];
          if (wall.normal.dot(g.position - wall.point) > g.radius + skin) continue;
          const auto a = static_cast<Index>(i), b = static_cast<Index>(w);
          Listed l{{a, b, {}, static_cast<std::uint16_t>(grains.material[i] * materials + wall.material)}, {}, {}};
          past.carry(a, b, {}, true, l.contact, l.touch);
          l.contact.effective_mass = grains.mass[i];
          listed[t][grains.round[i] ? sphere_wall : polyellipsoid_wall].push_back(l);
        }
    }
  });

  // Contacts that leave the list while touching cannot exist: the skin exceeds any gap they could have opened.
  std::size_t total = 0;
  for (int bin = 0; bin < bin_count; ++bin) {
    contacts.begin[static_cast<std::size_t>(bin)] = total;
    auto& starts = contacts.tile[static_cast<std::size_t>(bin)];
    starts.resize(tiles + 1);
    for (std::size_t t = 0; t < tiles; ++t) starts[t] = static_cast<Index>(total), total += listed[t][static_cast<std::size_t>(bin)].size();
    starts[tiles] = static_cast<Index>(total);
  }
  contacts.begin[bin_count] = total;
  contacts.pair.resize(total);
  contacts.contact.assign(total + overrun, {}), contacts.touch.assign(total + overrun, {}), contacts.active.assign(total + overrun, 0);
  for (auto* column : {&contacts.a, &contacts.b, &contacts.law}) column->assign(total + overrun, 0);
  team.pieces(tiles, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t)
      for (std::size_t bin = 0; bin < bin_count; ++bin) {
        std::size_t k = contacts.tile[bin][t];
        for (const Listed& l : listed[t][bin]) {
          contacts.pair[k] = l.pair, contacts.contact[k] = l.contact, contacts.touch[k] = l.touch;
          contacts.a[k] = l.pair.a, contacts.b[k] = l.pair.b, contacts.law[k] = l.pair.law;
          contacts.active[k++] = l.contact.stiffness > 0;
        }
      }
  });
  contacts.energy.resize(std::max(contacts.energy.size(), tiles));
  assign_targets(grains.size(), contacts);
  index_images(boundary.cell, contacts);
  fill_adjacency(grains.size(), contacts);

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
