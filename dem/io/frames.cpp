// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/frames.hpp"

#include <algorithm>
#include <optional>

#include "dem/fracture/grain_stress.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/wall_force.hpp"
#include "dem/state/images.hpp"
#include "dem/state/shape_kinds.hpp"

namespace grus::dem {
namespace {

struct Triangulation {
  std::vector<Vec3> directions;
  std::vector<std::array<int, 3>> triangles;
};

/// Octahedron, every face cut into n^2 triangles: vertices lie on the octant planes, where the surface has its seams.
Triangulation unit_sphere(int n) {
  Triangulation t;
  std::map<std::array<int, 3>, int> index;
  auto vertex = [&](const std::array<int, 3>& p) {
    auto [it, fresh] = index.try_emplace(p, static_cast<int>(t.directions.size()));
    if (fresh) t.directions.push_back(Vec3(p[0], p[1], p[2]).normalized());
    return it->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    auto at = [&](int i, int j) { return vertex({sx * i, sy * j, sz * (n - i - j)}); };
    auto add = [&](int a, int b, int c) {
      if (sx * sy * sz > 0)
        t.triangles.push_back({a, b, c});
      else
        t.triangles.push_back({a, c, b});
    };
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j < n - 1) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  return t;
}

/// One grain's surface, by the grain's own points.
using Faces = std::vector<std::array<int, 3>>;

void add_point(const Vec3& x, VtkGrid& grid) {
  for (int k = 0; k < 3; ++k) grid.points.push_back(static_cast<float>(x[k]));
}

/// A hull's vertices as points; its triangles.
Faces add_hull(const Grains& g, std::size_t i, const Frame& frame, VtkGrid& grid) {
  const HullView hull = (*g.hulls)[g.hull[i]];
  for (int v = 0; v < hull.vertices; ++v) add_point(frame.origin + frame.axes * hull.vertex[v], grid);
  Faces triangles;
  for (int f = 0; f < hull.faces; ++f)
    for (int k = hull.begin[f] + 1; k + 1 < hull.begin[f + 1]; ++k)
      triangles.push_back({hull.loop[hull.begin[f]], hull.loop[k], hull.loop[k + 1]});
  return triangles;
}

/// Where a grain is drawn, from where it is: unless it is to be wrapped, periodic grains leave the cell as they move.
Vec3 image_shift(const Cell& cell, const Vec3& position, bool wrapped) {
  if (!wrapped || !cell.periodic()) return Vec3::Zero();
  Vec3 whole = (cell.vectors.inverse() * position).array().floor().eval();
  if (cell.walled) whole.z() = 0;
  return -cell.vectors * whole;
}

/// Corner and edges of the periodic cell or of the box of walls; nothing where there is neither.
std::optional<std::pair<Vec3, Mat3>> outline(const Boundary& boundary) {
  const Cell& cell = boundary.cell;
  if (cell.walled) {
    const double low = boundary.walls[0].point.z(), high = boundary.walls[1].point.z();
    return std::pair{Vec3(0, 0, low), Mat3(Vec3(cell.vectors(0, 0), cell.vectors(1, 1), high - low).asDiagonal())};
  }
  if (cell.periodic()) return std::pair{Vec3(Vec3::Zero()), cell.vectors};
  if (boundary.walls.size() < 6 || boundary.walls[0].name.empty()) return std::nullopt;
  Vec3 low, edges;
  for (int k = 0; k < 3; ++k) {
    const auto side = 2 * static_cast<std::size_t>(k);
    low[k] = boundary.walls[side].point[k];
    edges[k] = boundary.walls[side + 1].point[k] - low[k];
  }
  return std::pair{low, Mat3(edges.asDiagonal())};
}

void add_line(std::int64_t from, std::int64_t to, VtkGrid& grid) {
  grid.connectivity.insert(grid.connectivity.end(), {from, to});
  grid.offsets.push_back(static_cast<std::int64_t>(grid.connectivity.size()));
  grid.types.push_back(3);
}

/// Twelve lines that no field says anything of.
void add_outline(const Boundary& boundary, VtkGrid& grid) {
  const auto box = outline(boundary);
  if (!box) return;
  const auto first = static_cast<std::int64_t>(grid.points.size() / 3);
  for (int corner = 0; corner < 8; ++corner)
    add_point(box->first + box->second * Vec3(corner & 1, corner >> 1 & 1, corner >> 2), grid);
  for (int corner = 0; corner < 8; ++corner)
    for (const int bit : {1, 2, 4})
      if (!(corner & bit)) add_line(first + corner, first + (corner | bit), grid);
  for (auto& [name, field] : grid.cell_fields)
    field.values.resize(field.values.size() + 12 * static_cast<std::size_t>(field.components), NAN);
}

}  // namespace

void write_grains(const std::string& path, const State& state, bool wrapped) {
  const Grains& g = state.grains;
  const Triangulation surface = unit_sphere(g.size() <= 2000 ? 8 : g.size() <= 20000 ? 4 : 2);
  VtkGrid grid;
  grid.offsets.push_back(0);
  auto field = [&](const char* name) { return &grid.cell_fields[name].values; };
  auto *id = field("id"), *radius = field("radius"), *speed = field("speed"), *material = field("material"),
       *coordination = field("coordination"), *pressure = field("mean_pressure_Pa");
  VtkField& velocity = grid.cell_fields["velocity"];
  velocity.components = 3;
  auto *elongation = g.frame.empty() ? nullptr : field("elongation"),
       *flatness = g.frame.empty() ? nullptr : field("flatness");
  auto* generation = g.generation.empty() ? nullptr : field("generation");
  auto* fragment = g.hull.empty() ? nullptr : field("fragment");
  auto *sphericity = g.hull.empty() ? nullptr : field("sphericity"),
       *angularity = g.hull.empty() ? nullptr : field("angularity");
  const Fragments fragments = fragment ? fragments_of(state) : Fragments{};
  for (std::size_t i = 0; i < g.size(); ++i) {
    const ShapeFunctions& shape = shape_functions(g.kind[i]);
    Frame frame = frame_of(g, i);
    frame.origin += image_shift(state.boundary.cell, g.motion[i].position, wrapped);
    const auto first = static_cast<std::int64_t>(grid.points.size() / 3);
    Faces own;
    if (g.kind[i] == ShapeKind::hull)
      own = add_hull(g, i, frame, grid);
    else
      for (const auto& d : surface.directions) add_point(shape.drawn(g, i, frame, d), grid);
    const Faces& triangles = g.kind[i] == ShapeKind::hull ? own : surface.triangles;
    const int touching = dem::coordination(state.contacts, i);
    const double p = touching > 0 ? mean_pressure(grain_stress(g, state.contacts, i)) : 0;
    const Vec3 widths = shape.sorted_widths(g, i);
    const Roundness round = g.hull.empty() ? Roundness{} : roundness(g, i);
    for (const auto& triangle : triangles) {
      for (int v : triangle) grid.connectivity.push_back(first + v);
      grid.offsets.push_back(static_cast<std::int64_t>(grid.connectivity.size()));
      grid.types.push_back(5);
      id->push_back(static_cast<float>(g.id[i]));
      radius->push_back(static_cast<float>(g.extent[i].equivalent_radius));
      speed->push_back(static_cast<float>(g.motion[i].velocity.norm()));
      for (int k = 0; k < 3; ++k) velocity.values.push_back(static_cast<float>(g.motion[i].velocity[k]));
      material->push_back(g.material[i]);
      coordination->push_back(static_cast<float>(touching));
      pressure->push_back(static_cast<float>(p));
      if (elongation)
        elongation->push_back(static_cast<float>(widths[1] / widths[0])),
            flatness->push_back(static_cast<float>(widths[2] / widths[1]));
      if (generation) generation->push_back(g.generation[i]);
      if (fragment) fragment->push_back(static_cast<float>(fragments.of[i]));
      if (sphericity)
        sphericity->push_back(static_cast<float>(round.sphericity)),
            angularity->push_back(static_cast<float>(round.angularity));
    }
  }
  add_outline(state.boundary, grid);
  write_vtkhdf(path, grid);
}

bool has_meshes(const State& state) {
  const auto& walls = state.boundary.walls;
  return std::any_of(walls.begin(), walls.end(), [](const Wall& w) { return w.mesh() != nullptr; });
}

void write_walls(const std::string& path, const State& state) {
  VtkGrid grid;
  grid.offsets.push_back(0);
  auto* number = &grid.cell_fields["wall"].values;
  VtkField &velocity = grid.cell_fields["velocity"], &force = grid.cell_fields["wall_force_N"];
  velocity.components = force.components = 3;
  for (std::size_t w = 0; w < state.boundary.walls.size(); ++w) {
    const Wall& wall = state.boundary.walls[w];
    if (!wall.mesh()) continue;
    const Vec3 pressed = wall_force(state, w);
    const auto first = static_cast<std::int64_t>(grid.points.size() / 3);
    for (const Vec3& x : wall.mesh()->corner) add_point(wall.point + x, grid);
    for (const auto& triangle : wall.mesh()->triangle) {
      for (const Index corner : triangle) grid.connectivity.push_back(first + corner);
      grid.offsets.push_back(static_cast<std::int64_t>(grid.connectivity.size()));
      grid.types.push_back(5);
      number->push_back(static_cast<float>(w));
      for (int i = 0; i < 3; ++i)
        velocity.values.push_back(static_cast<float>(wall.velocity[i])),
            force.values.push_back(static_cast<float>(pressed[i]));
    }
  }
  write_vtkhdf(path, grid);
}

void write_contacts(const std::string& path, const State& state, bool wrapped) {
  const Grains& g = state.grains;
  const Contacts& c = state.contacts;
  VtkGrid grid;
  grid.offsets.push_back(0);
  auto field = [&](const char* name) { return &grid.cell_fields[name].values; };
  auto *normal = field("normal_force_N"), *tangential = field("tangential_force_N"), *force = field("force_N"),
       *overlap = field("overlap_m");
  grid.cell_fields["force_N"].components = 3;
  for (std::size_t k = 0; k < c.size(); ++k) {
    if (!c.contact.touching(k)) continue;
    const Pair& pair = c.pair[k];
    const Touch& touch = c.touch[k];
    const Vec3 from = g.motion[pair.a].position;
    const Vec3 shift = image_shift(state.boundary.cell, from, wrapped);
    const Vec3 to = k < c.begin[first_wall]
                        ? Vec3(g.motion[pair.b].position + at_image(state.boundary.cell.vectors, pair.image))
                        : Vec3(from + contact_arm(g, c, k, false));
    add_point(from + shift, grid), add_point(to + shift, grid);
    const auto last = static_cast<std::int64_t>(grid.points.size() / 3);
    add_line(last - 2, last - 1, grid);
    const double along = touch.force.dot(touch.normal);
    normal->push_back(static_cast<float>(along));
    tangential->push_back(static_cast<float>((touch.force - along * touch.normal).norm()));
    for (int i = 0; i < 3; ++i) force->push_back(static_cast<float>(touch.force[i]));
    overlap->push_back(static_cast<float>(touch.overlap));
  }
  write_vtkhdf(path, grid);
}

void write_lattice(const std::string& path, const CrackedGrain& grain) {
  const CrackedLattice& l = *grain.lattice;
  VtkGrid grid;
  grid.offsets.push_back(0);
  auto *damage = &grid.point_fields["damage"].values, *piece = &grid.point_fields["piece"].values,
       *dilation = &grid.point_fields["dilation"].values;
  VtkField& moved = grid.point_fields["displacement_m"];
  moved.components = 3;
  for (std::size_t i = 0; i < l.points.size(); ++i) {
    add_point(grain.position + grain.axes * l.points[i], grid);
    grid.connectivity.push_back(static_cast<std::int64_t>(i));
    grid.offsets.push_back(static_cast<std::int64_t>(i + 1));
    grid.types.push_back(1);
    damage->push_back(static_cast<float>(l.damage[i]));
    piece->push_back(static_cast<float>(l.piece[i]));
    dilation->push_back(static_cast<float>(l.dilation[i]));
    const Vec3 u = grain.axes * l.moved[i];
    for (int k = 0; k < 3; ++k) moved.values.push_back(static_cast<float>(u[k]));
  }
  write_vtkhdf(path, grid);
}

}  // namespace grus::dem
