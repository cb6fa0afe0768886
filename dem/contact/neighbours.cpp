// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/neighbours.hpp"

#include <algorithm>
#include <tuple>

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

  /// History and last force of the pair, turned to its present order.
  std::pair<Contact, Vec3> carried(Index a, Index b, const std::array<std::int16_t, 3>& image, bool wall) const {
    const std::ptrdiff_t k = find(a, b, image, wall);
    if (k < 0) return {Contact{}, Vec3::Zero()};
    Contact c = old.contact[k];
    Vec3 force = old.force[k].force;
    if (!wall && before(a) > before(b)) c.normal = -c.normal, c.spring = -c.spring, force = -force;
    return {c, force};
  }
};

/// Exact-gap test for pairs that involve a poly-ellipsoid; leaves a search direction in the contact.
bool near(const Grains& g, const Cell& cell, const Candidate& pair, double skin, bool known, Contact& c) {
  const Frame &fa = g.frame[pair.a], &fb = g.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (cell.periodic()) r += cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]);
  const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes, fa.axes.transpose() * r};
  if (c.stiffness > 0) return true;
  if (known) return separation_test(shapes, fa.axes.transpose() * c.normal) > -skin;
  // Any direction whose separation exceeds the skin settles it: most candidates go here, before the full search.
  const Vec3 line = shapes.r.normalized();
  if (separation_test(shapes, line) < -skin) return false;
  const Vec3 scaled = line.cwiseQuotient(octant_squares(shapes.a, line)).normalized();
  if (separation_test(shapes, scaled) < -skin) return false;
  const CommonNormal found = cold_common_normal(shapes);
  c.normal = fa.axes * found.normal;
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

}  // namespace

void build_contacts(const Grains& grains, const Boundary& boundary, double skin, std::size_t materials,
                    std::span<const Index> origin, Contacts& contacts, NeighbourReference& reference, Team& team) {
  const std::vector<Candidate> candidates = find_candidates(grains, boundary.cell, skin, team);
  const Past past{contacts, origin};  // reads the old columns until they are replaced below
  const bool polys = !grains.frame.empty();
  std::array<std::vector<Pair>, bin_count> pairs;
  std::array<std::vector<Contact>, bin_count> kept;
  std::array<std::vector<ContactForce>, bin_count> forces;
  auto add = [&](Bin bin, const Pair& pair, Contact c, const Vec3& force, double effective_mass) {
    c.effective_mass = effective_mass;
    pairs[bin].push_back(pair);
    kept[bin].push_back(c);
    forces[bin].push_back({force, Vec3::Zero(), Vec3::Zero()});
  };

  struct Judged {
    Contact contact;
    Vec3 force;
    bool keep;
  };
  std::vector<Judged> judged(candidates.size());
  const auto bin_of = [&](const Candidate& c) { return polys && !(grains.round[c.a] && grains.round[c.b]) ? general : sphere_sphere; };
  team.blocks(candidates.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Candidate& pair = candidates[k];
      Judged& j = judged[k];
      std::tie(j.contact, j.force) = past.carried(pair.a, pair.b, pair.image, false);
      j.keep = bin_of(pair) == sphere_sphere || near(grains, boundary.cell, pair, skin, j.contact.normal != Vec3::Zero(), j.contact);
    }
  });
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (!judged[k].keep) continue;
    const auto& [a, b, image] = candidates[k];
    const auto law = static_cast<std::uint16_t>(grains.material[a] * materials + grains.material[b]);
    add(bin_of(candidates[k]), {a, b, image, law}, judged[k].contact, judged[k].force,
        1 / (grains.motion[a].inverse_mass + grains.motion[b].inverse_mass));
  }
  for (std::size_t i = 0; i < grains.size(); ++i)
    for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
      const Wall& wall = boundary.walls[w];
      const auto& g = grains.motion[i];
      const double distance = wall.normal.dot(g.position - wall.point);
      if (distance > g.radius + skin) continue;
      const auto a = static_cast<Index>(i), b = static_cast<Index>(w);
      const auto law = static_cast<std::uint16_t>(grains.material[i] * materials + wall.material);
      const auto [c, force] = past.carried(a, b, {}, true);
      add(grains.round[i] ? sphere_wall : polyellipsoid_wall, {a, b, {}, law}, c, force, grains.mass[i]);
    }

  // Contacts that leave the list while touching cannot exist: the skin exceeds any gap they could have opened.
  std::size_t total = 0;
  for (int bin = 0; bin < bin_count; ++bin) contacts.begin[bin] = total, total += pairs[bin].size();
  contacts.begin[bin_count] = total;
  contacts.pair.clear(), contacts.contact.clear(), contacts.force.clear();
  for (int bin = 0; bin < bin_count; ++bin) {
    contacts.pair.insert(contacts.pair.end(), pairs[bin].begin(), pairs[bin].end());
    contacts.contact.insert(contacts.contact.end(), kept[bin].begin(), kept[bin].end());
    contacts.force.insert(contacts.force.end(), forces[bin].begin(), forces[bin].end());
  }
  fill_adjacency(grains.size(), contacts);

  reference.skin = skin, reference.grown = 0;
  reference.cell = boundary.cell.vectors;
  reference.position.resize(grains.size());
  for (std::size_t i = 0; i < grains.size(); ++i) reference.position[i] = grains.motion[i].position;
  if (polys) reference.orientation = grains.orientation;
  else reference.orientation.clear();
  reference.wall_point.clear();
  for (const auto& wall : boundary.walls) reference.wall_point.push_back(wall.point);
}

bool list_is_stale(const Grains& grains, const Boundary& boundary, const NeighbourReference& ref) {
  double budget = ref.skin - 2 * ref.grown, largest = 0;
  const bool periodic = boundary.cell.periodic();
  Mat3 affine = Mat3::Identity();
  if (periodic) {
    affine = boundary.cell.vectors * ref.cell.inverse();
    for (const auto& g : grains.motion) largest = std::max(largest, g.radius);
    budget -= (affine - Mat3::Identity()).norm() * (2 * largest + ref.skin);
  }
  double walls = 0;
  for (std::size_t w = 0; w < boundary.walls.size(); ++w)
    walls = std::max(walls, std::abs(boundary.walls[w].normal.dot(boundary.walls[w].point - ref.wall_point[w])));
  const double limit = std::min(0.5 * budget, budget - walls);
  if (limit <= 0) return true;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const Vec3 moved = grains.motion[i].position - (periodic ? Vec3(affine * ref.position[i]) : ref.position[i]);
    double path2 = moved.squaredNorm();
    if (!ref.orientation.empty() && !grains.round[i]) {
      // Chord of the quaternion difference is half the angle: surface points move by at most radius * angle.
      const auto &p = grains.orientation[i].coeffs(), &q = ref.orientation[i].coeffs();
      const double turn = 2.01 * std::min((p - q).norm(), (p + q).norm()) * grains.motion[i].radius;
      const double path = std::sqrt(path2) + turn;
      path2 = path * path;
    }
    if (!(path2 <= limit * limit)) return true;
  }
  return false;
}

}  // namespace grus::dem
