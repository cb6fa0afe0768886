// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/mesh_pairs.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

/// A row of planes as the kernels read walls: normal towards the sphere, normal . point | velocity, 0.
constexpr std::size_t mesh_columns = 8;
constexpr double nowhere = -1e300;  // normal . point of a plane that nothing touches

constexpr double same_direction = 0.9659258262890683;  // cosine of one_surface

/// Corners nearer to one another than this, of the radius, are one.
constexpr double together = 1e-6;

struct Mesh {
  const TileWork& work;
  Contacts& c;
  std::size_t first;  // pair of the bin

  explicit Mesh(const TileWork& w) : work(w), c(w.contacts), first(w.contacts.begin[sphere_mesh]) {}

  double* row(std::size_t k) const { return c.plan.mesh_rows.data() + mesh_columns * (k - first); }
  MeshTouch& touch(std::size_t k) const { return c.plan.mesh_touch[k - first]; }
  const Wall& wall(std::size_t k) const { return work.boundary.walls[c.pair[k].b]; }
  const Triangles& surface(std::size_t k) const { return *std::get<MeshWall>(wall(k).shape).surface; }
  const Motion& sphere(std::size_t k) const { return work.grains.motion[c.pair[k].a]; }
};

/// Where the nearest place of each triangle is, seen from its sphere.
void look(const Mesh& m, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const Motion& sphere = m.sphere(k);
    const Vec3 x = sphere.position - m.wall(k).point;
    MeshTouch& t = m.touch(k);
    t.place = nearest_on(m.surface(k), triangle_of(m.c.pair[k]), x);
    const Vec3 away = x - t.place;
    t.distance = away.norm();
    t.normal = t.distance > 0 ? Vec3(away / t.distance) : Vec3::UnitZ();
    t.touches = t.distance < sphere.radius;
    t.presses = t.touches;
  }
}

bool same_surface(const Contacts& c, std::size_t k, std::size_t j) {
  return c.pair[k].a == c.pair[j].a && c.pair[k].b == c.pair[j].b;
}

/// Whether triangle j of a sphere is before k: nearer, or the first of two that are as near.
bool before(const Mesh& m, std::size_t j, std::size_t k) {
  const double near = m.touch(j).distance, far = m.touch(k).distance;
  return near < far || (near == far && triangle_of(m.c.pair[j]) < triangle_of(m.c.pair[k]));
}

/// Whether the contact of k is that of j, which is before it.
bool covered(const Mesh& m, std::size_t k, std::size_t j) {
  const MeshTouch &is = m.touch(k), &other = m.touch(j);
  if (is.normal.dot(other.normal) > same_direction) return true;
  const double slack = together * m.sphere(k).radius;
  return (nearest_on(m.surface(k), triangle_of(m.c.pair[j]), is.place) - is.place).squaredNorm() <= slack * slack;
}

/// The history of k goes on as that of j.
void hand_on(Contacts& c, std::size_t k, std::size_t j) {
  c.contact.set(j, c.contact[k]), c.contact.set(k, {});
  c.active[j] = 1, c.active[k] = 0;
}

/// f(j) of all pairs of the same sphere and surface as k, which lie about it in both halves of the tile's pairs.
template <class F>
void each_beside(const Contacts& c, std::size_t k, std::size_t begin, std::size_t half, std::size_t end, F&& f) {
  const auto same = [&](const Pair& p) { return std::pair{p.a, p.b}; };
  const auto walk = [&](std::size_t from, std::size_t to) {
    const auto first = c.pair.begin();
    const auto low =
        std::lower_bound(first + static_cast<std::ptrdiff_t>(from), first + static_cast<std::ptrdiff_t>(to),
                         same(c.pair[k]), [&](const Pair& p, const auto& of) { return same(p) < of; });
    for (auto j = static_cast<std::size_t>(low - first); j < to && same_surface(c, j, k); ++j)
      if (j != k) f(j);
  };
  walk(begin, half), walk(half, end);
}

}  // namespace

void make_mesh_room(Contacts& c) {
  const std::size_t pairs = c.begin[sphere_mesh + 1] - c.begin[sphere_mesh];
  c.plan.mesh_touch.resize(pairs);
  c.plan.mesh_rows.assign(pairs > 0 ? mesh_columns * (pairs + overrun) : 0, 0);
}

void spheres_at_meshes(const TileWork& work, std::size_t begin, std::size_t end) {
  const Mesh m(work);
  Contacts& c = work.contacts;
  const std::size_t half = c.apart[sphere_mesh][work.first >> tile_bits(work.grains.size())];
  look(m, begin, end);
  for (std::size_t k = begin; k < end; ++k)
    if (m.touch(k).touches)
      each_beside(c, k, begin, half, end, [&](std::size_t j) {
        if (m.touch(j).touches && before(m, j, k) && covered(m, k, j)) m.touch(k).presses = false;
      });
  for (std::size_t k = begin; k < end; ++k)  // what pressed and does so no more goes on as what has taken its place
    if (c.active[k] && !m.touch(k).presses && m.touch(k).touches)
      each_beside(c, k, begin, half, end, [&](std::size_t j) {
        if (c.active[k] && m.touch(j).presses && !c.active[j] && covered(m, k, j)) hand_on(c, k, j);
      });
  for (std::size_t k = begin; k < end; ++k) {
    const MeshTouch& t = m.touch(k);
    double* row = m.row(k);
    const Wall& wall = m.wall(k);
    for (int i = 0; i < 3; ++i) row[i] = t.normal[i], row[4 + i] = wall.velocity[i];
    row[3] = t.presses ? t.normal.dot(wall.point + t.place) : nowhere;
  }
  ContactRows rows = work.rows;
  rows.walls = c.plan.mesh_rows.data(), rows.rounds = nullptr;
  run_rows(work, rows, sphere_walls(), begin, end);
}

}  // namespace grus::dem
