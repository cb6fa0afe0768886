// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/check_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "dem/base/error.hpp"
#include "dem/contact/mesh_pairs.hpp"

namespace grus::dem {
namespace {

void need(bool good, const char* what) {
  if (!good) throw InputError(fmt::format("checkpoint is damaged: {}", what));
}

/// All numbers are finite, of rows that hold doubles and nothing else.
template <class Row>
bool finite(const std::vector<Row>& column) {
  constexpr std::size_t width =
      sizeof(Row) / sizeof(double);  // NOLINT(bugprone-sizeof-expression): Row may be a pointer
  static_assert(width * sizeof(double) == sizeof(Row));
  const auto* v = reinterpret_cast<const double*>(column.data());
  return std::all_of(v, v + column.size() * width, [](double x) { return std::isfinite(x); });
}

bool finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

bool unit(const Quat& q) { return std::abs(q.squaredNorm() - 1) < 1e-6; }

template <class Column>
bool rising(const Column& starts) {
  return std::is_sorted(starts.begin(), starts.end());
}

void check_hull(const HullStore& s, const HullRow& r) {
  const auto fits = [](std::size_t at, std::size_t count, std::size_t size) {
    return at <= size && count <= size - at;
  };
  need(r.vertices >= 4 && r.vertices <= most_hull_vertices && r.faces >= 4 && r.faces <= most_hull_faces &&
           fits(r.vertex, r.vertices, s.vertex.size()) && fits(r.plane, r.faces, s.plane.size()) &&
           fits(r.begin, r.faces + 1, s.begin.size()) && fits(r.edge, std::size_t{4} * r.edges, s.edge.size()) &&
           fits(std::size_t{3} * r.vertex, std::size_t{3} * r.vertices, s.at.size()) &&
           r.edges == r.vertices + r.faces - 2,
       "a hull");
  const auto room = static_cast<std::size_t>(in_eights(static_cast<int>(r.vertices)));
  const auto space = static_cast<std::size_t>(in_eights(static_cast<int>(r.faces)));
  need(fits(r.column, 3 * room + 8 * space + std::size_t{4} * r.vertices, s.column.size()), "columns of a hull");
  const auto* begin = &s.begin[r.begin];
  need(std::is_sorted(begin, begin + r.faces + 1) && begin[0] == 0 && fits(r.loop, begin[r.faces], s.loop.size()),
       "faces of a hull");
  for (std::size_t k = 0; k < begin[r.faces]; ++k) need(s.loop[r.loop + k] < r.vertices, "vertices of a face");
  for (std::size_t k = 0; k < r.edges; ++k) {
    const std::uint8_t* edge = &s.edge[r.edge + 4 * k];
    need(edge[0] < r.vertices && edge[1] < r.vertices && edge[2] < r.faces && edge[3] < r.faces, "edges of a hull");
  }
  const std::vector<std::uint64_t> rows = belongings(&s.edge[r.edge], r.edges, r.vertices);
  need(std::equal(rows.begin(), rows.end(), &s.at[std::size_t{3} * r.vertex]), "edges of a hull");
  const double* column = &s.column[r.column];
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t v = 0; v < room; ++v)
      need(*column++ == s.vertex[r.vertex + (v < r.vertices ? v : 0)][static_cast<int>(k)], "columns of a hull");
  const auto of_plane = [&](std::size_t f, std::size_t k) {
    if (f >= r.faces) return k < 3 ? 0.0 : std::numeric_limits<double>::infinity();
    const Plane& p = s.plane[r.plane + f];
    return k < 3 ? p.normal[static_cast<int>(k)] : p.offset;
  };
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t f = 0; f < space; ++f) need(*column++ == of_plane(f, k), "columns of a hull");
  for (std::size_t f = 0; f < space; ++f)
    for (std::size_t k = 0; k < 4; ++k) need(*column++ == of_plane(f, k), "columns of a hull");
  for (std::size_t v = 0; v < r.vertices; ++v)
    for (int k = 0; k < 4; ++k) need(*column++ == (k < 3 ? s.vertex[r.vertex + v][k] : 0), "columns of a hull");
  for (std::size_t f = 0; f < r.faces; ++f) {
    const Plane& p = s.plane[r.plane + f];
    need(std::abs(p.normal.squaredNorm() - 1) < 1e-9, "planes of a hull");
    for (std::size_t k = begin[f]; k < begin[f + 1]; ++k)
      need(std::abs(p.normal.dot(s.vertex[r.vertex + s.loop[r.loop + k]]) - p.offset) < 1e-6 * r.bounding_radius,
           "planes of a hull");
  }
  Polyhedron body;  // what follows from its corners and faces: a hull of no depth would stop time
  body.vertex.assign(&s.vertex[r.vertex], &s.vertex[r.vertex] + r.vertices);
  double surface = 0;
  for (std::size_t f = 0; f < r.faces; ++f) {
    const Plane& p = s.plane[r.plane + f];
    body.face.push_back({p.normal, p.offset, 0, {}});
    for (std::size_t k = begin[f]; k < begin[f + 1]; ++k) body.face.back().loop.push_back(s.loop[r.loop + k]);
    surface += moments_of(body, body.face.back()).area;
  }
  const SolidMoments moments = moments_of(body);
  const auto is = [](double told, double found) { return std::abs(told - found) < 1e-6 * std::abs(found); };
  double furthest = 0;
  for (const Vec3& x : body.vertex) furthest = std::max(furthest, x.norm());
  need(is(r.volume, moments.volume) && is(r.depth, 3 * moments.volume / surface) && is(r.bounding_radius, furthest) &&
           r.least_width < 2 * furthest && r.least_width > 1e-6 * furthest,
       "measures of a hull");
  need(finite({r.volume, r.depth, r.bounding_radius, r.least_width}) && r.volume > 0 && r.depth > 0 &&
           r.bounding_radius > 0 && r.least_width > 0 && r.principal.moments.minCoeff() > 0,
       "measures of a hull");
}

void check_sizes(const Model& model, const State& s) {
  const Grains& g = s.grains;
  const std::size_t n = g.size();
  const bool round = g.frame.empty(), whole = !s.resting;
  need(n > 0 && n < std::numeric_limits<Index>::max() / 2, "number of grains");
  const auto all = [&](const auto& column, bool kept) { return column.size() == (kept ? n : 0); };
  const auto some = [&](const auto& column) { return column.empty() || column.size() == n; };
  const bool bodies = s.resting ? !g.shape.empty() : !round;
  need(g.orientation.size() == n && g.mass.size() == n && g.kind.size() == n && g.material.size() == n &&
           g.id.size() == n && all(g.force, whole) && all(g.torque, whole) && all(g.inertia, whole) &&
           all(g.extent, whole) && all(g.shape, whole || bodies) && all(g.angular_momentum, whole || bodies) &&
           all(g.frame, whole && bodies),
       "columns of grains");
  need(some(g.strength) && some(g.generation) && some(g.utilisation) && some(g.born) && some(g.solid_mass) &&
           some(g.turn_mass) && some(g.hull) && some(g.crystal) && some(g.held),
       "columns of grains");
  need(!model.breakable() || (g.strength.size() == n && g.generation.size() == n && g.utilisation.size() == n),
       "columns of breakable grains");
  for (std::size_t i = 0; i < n; ++i) {
    need(g.kind[i] <= ShapeKind::hull && g.material[i] < model.materials.size() && g.id[i] < g.next_id,
         "kind, material or number of a grain");
    need(bodies || g.kind[i] == ShapeKind::sphere, "shape of a grain");
    need((g.kind[i] == ShapeKind::hull) == !g.hull.empty(), "hull of a grain");
    if (!g.hull.empty()) need(g.hulls && g.hull[i] < g.hulls->row.size(), "hull of a grain");
  }
  if (g.hulls)
    for (const HullRow& row : g.hulls->row) check_hull(*g.hulls, row);
}

void check_values(const Model& model, const State& s) {
  const Grains& g = s.grains;
  need(finite(g.motion) && finite(g.orientation) && finite(g.angular_momentum) && finite(g.force) && finite(g.torque) &&
           finite(g.mass) && finite(g.inertia) && finite(g.shape) && finite(g.frame) && finite(g.strength) &&
           finite(g.extent) && finite(g.solid_mass) && finite(g.turn_mass) && finite(g.crystal) && finite(g.held),
       "a number of a grain");
  constexpr double light = 3e8;  // m/s
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Motion& m = g.motion[i];
    const bool fixed = m.inverse_mass == 0 && m.inverse_inertia == 0 && model.materials[g.material[i]].fixed;
    need(m.radius > 0 && g.mass[i] > 0 && (fixed || std::abs(m.inverse_mass * g.mass[i] - 1) < 1e-6) &&
             m.inverse_inertia >= 0,
         "size or mass of a grain");
    need(m.velocity.norm() < light && m.spin.norm() * m.radius < light && unit(g.orientation[i]), "motion of a grain");
    const double solid = solid_mass(g, i);
    need(g.mass[i] > 0.999999 * solid && turn_mass(g, i) > 0.999999 * solid, "mass of a grain");
    const double ratio = solid / (model.materials[g.material[i]].density * 4.18879 * std::pow(m.radius, 3));
    need(solid > 0 && ratio < 1.001e3 && ratio > 1e-9, "size or mass of a grain");
    if (!g.shape.empty()) {
      const PolyEllipsoid& p = g.shape[i];
      need(std::min(p.plus.minCoeff(), p.minus.minCoeff()) > 0 && volume(p) < 1.001 * 8 * std::pow(m.radius, 3),
           "shape of a grain");
      need(g.kind[i] != ShapeKind::sphere || std::abs(p.plus.x() - m.radius) < 1e-6 * m.radius, "radius of a grain");
    }
    if (!g.extent.empty()) {
      const Extent& e = g.extent[i];
      need(e.volume > 0 && e.equivalent_radius > 0 && e.least_width > 0 && e.least_width < 2.001 * m.radius &&
               e.equivalent_radius < 1.001 * m.radius &&
               std::abs(e.volume / (4.1887902047863905 * std::pow(e.equivalent_radius, 3)) - 1) < 1e-6,
           "size of a grain");
    }
    if (!g.inertia.empty()) need(g.inertia[i].moments.minCoeff() > 0, "inertia of a grain");
  }
  for (const Quat& q : g.crystal) need(unit(q), "crystal of a grain");
  const Cell& cell = s.boundary.cell;
  need(cell.vectors.allFinite() && cell.rate.allFinite(), "the cell");
  if (!cell.vectors.isZero(0)) {
    const double volume = cell.volume();
    double solid = 0;
    for (std::size_t i = 0; i < g.size(); ++i) solid += solid_mass(g, i) / model.materials[g.material[i]].density;
    need(volume > 0 && cell.height() > 0 && volume < 1e6 * solid && solid < 1e3 * volume, "the cell");
    const Mat3 inverse = cell.vectors.inverse();
    for (const Motion& m : g.motion)  // an image is a small number
      need((inverse * m.position).cwiseAbs().maxCoeff() < 3e4, "place of a grain");
  }
  for (const Wall& w : s.boundary.walls) {
    need(w.point.allFinite() && w.velocity.allFinite() && w.velocity.norm() < light, "a wall");
    need(w.material < model.materials.size(), "a wall");
    for (const std::uint8_t material : w.grains)
      need(material < model.materials.size() && model.materials[material].fixed, "a wall");
    need(std::visit([&](const auto& shape) { return shape.sound(g.hulls.get()); }, w.shape), "a wall");
  }
}

void check_reference(const Model& model, const State& s) {
  const Grains& g = s.grains;
  const std::size_t n = g.size(), walls = s.boundary.walls.size();
  const NeighbourReference& r = s.reference;
  need(r.position.size() == n && r.orientation.size() == (g.frame.empty() ? 0 : n) &&
           r.radius.size() == (model.swells() ? n : 0) && r.wall_point.size() == walls,
       "where the list was made");
  need(finite(r.position) && finite(r.orientation) && finite(r.radius) && finite(r.wall_point) && r.cell.allFinite() &&
           finite({r.skin, r.grown, r.largest, r.travelled}) && r.skin >= 0,
       "where the list was made");
}

void check_contacts(const Model& model, const State& s) {
  const Grains& g = s.grains;
  const Contacts& c = s.contacts;
  const std::size_t n = g.size(), walls = s.boundary.walls.size(), total = c.size(), materials = model.materials.size();
  need(rising(c.begin) && c.begin.front() == 0 && c.begin.back() == total && total < (std::size_t{1} << 31),
       "bins of the list");
  const std::size_t rows = s.resting ? total : total + overrun;
  for_each_contact_column(
      c.contact, [&](const auto& column) { need(column.size() == rows && finite(column), "columns of contacts"); });
  need(c.contact.keeps == model.springs() && c.contact.reaches == (attracts(model.law) || of_hulls(model.law)),
       "columns of contacts");
  if (s.resting) {
    need(c.resting_normal.size() == (g.shape.empty() ? 0 : total) && finite(c.resting_normal), "columns of contacts");
  } else {
    need(c.touch.size() == rows && c.active.size() == rows && c.spot.size() == (c.spots ? total : 0) &&
             finite(c.touch) && finite(c.spot),
         "columns of contacts");
    need(std::all_of(c.active.begin(), c.active.end(), [](std::uint8_t v) { return v <= 1; }), "columns of contacts");
  }
  for (std::size_t bin = 0; bin < bin_count; ++bin)
    for (std::size_t k = c.begin[bin]; k < c.begin[bin + 1]; ++k) {
      const Pair& p = c.pair[k];
      const bool wall = bin >= first_wall;
      need(p.a < n && p.b < (wall ? walls : n) && (wall || p.a < p.b), "a pair of the list");
      if (const Triangles* mesh = wall ? s.boundary.walls[p.b].mesh() : nullptr)
        need(p.image[0] >= 0 && p.image[1] >= 0 && triangle_of(p) < mesh->triangle.size(), "a triangle of the list");
      const std::size_t other = wall ? s.boundary.walls[p.b].material : g.material[p.b];
      need(p.law == g.material[p.a] * materials + other, "law of a pair");
      need((wall ? wall_bin(g.kind[p.a], s.boundary.walls[p.b]) : pair_bin(g.kind[p.a], g.kind[p.b])) == bin,
           "bin of a pair");
      need(c.contact.stiffness[k] >= 0 && c.contact.compliance[k] >= 0 && c.contact.radius[k] >= 0, "a contact");
    }
}

void check_bonds(const State& s) {
  const std::size_t n = s.grains.size(), walls = s.boundary.walls.size();
  for_each_bond(s.bonds, [&](const auto& bond) {
    need(bond.ends.a < n && bond.ends.b < n && bond.ends.a != bond.ends.b && bond.force.allFinite(),
         "grains of a bond");
  });
  for (const CohesiveSpring& b : s.bonds.cohesive.row)
    need(finite({b.peak, b.onset, b.rupture, b.reached}) && b.peak >= 0 && b.onset > 0 && b.rupture >= b.onset &&
             b.at_a.allFinite() && b.at_b.allFinite() && b.normal_a.allFinite() && b.preload.allFinite(),
         "a cohesive spring");
  const auto face = [&](const FaceBond& b) {
    need(b.criterion <= FaceCriterion::rod && b.at_a.allFinite() && b.at_b.allFinite() && b.normal.allFinite() &&
             b.e1.allFinite() && unit(b.rest) && b.force.allFinite() && b.shear.allFinite(),
         "a bond");
    need(finite({b.area, b.i1, b.i2, b.kn, b.kt, b.tan_phi, b.friction, b.reached, b.onset, b.rupture, b.slip_1,
                 b.slip_2, b.slip_3, b.spent, b.rubbed, b.held, b.damage}) &&
             b.area > 0 && b.i1 > 0 && b.i2 > 0 && b.kn > 0 && b.kt >= 0 && b.friction >= 0 && b.damage >= 0 &&
             b.damage <= 1 && b.onset >= 0 && b.reached >= b.onset && b.rubbed >= 0,
         "a bond");
    need(!std::isnan(b.tension) && !std::isnan(b.cohesion) && !std::isnan(b.energy_1) && !std::isnan(b.energy_2),
         "a bond");
  };
  for (const FaceBond& b : s.bonds.face.row) face(b);
  for (const FaceBond& b : s.bonds.wall) face(b), need(b.ends.a < n && b.ends.b < walls, "a support");
  need(s.bonds.dashpot.empty() || s.bonds.dashpot.size() == s.bonds.face.row.size(), "dashpots of bonds");
  need(finite(s.bonds.dashpot), "dashpots of bonds");
  for (const DeadLoad& l : s.bonds.load)
    need(l.grain < n && l.at.allFinite() && l.force.allFinite() && l.felt.allFinite() && std::isfinite(l.ramp),
         "a load");
  for (const Handed& h : s.bonds.handed)
    need(h.ends.a < n && h.ends.b < n && h.at_a.allFinite() && h.shear.allFinite() && h.normal.allFinite() &&
             finite({h.modulus, h.area, h.fresh, h.compliance, h.held, h.spent, h.kept, h.sliding}) && h.modulus > 0 &&
             h.area > 0 && h.fresh >= 0 && h.fresh <= h.area && h.compliance >= 0,
         "what a bond has left");
  for (const BrokenBond& b : s.bonds.broken)
    need(finite({b.time, b.area, b.energy, b.sliding}) && b.at.allFinite() && b.normal.allFinite(), "a broken bond");
  for (const Pair& p : s.reference.bonded) need(p.a < n && p.b < n, "pairs of bonds");
  for (const Pair& p : s.reference.walled) need(p.a < n && p.b < walls, "pairs of supports");
}

void check_course(const Model& model, const State& s) {
  const Ledger& l = s.ledger;
  need(finite({l.adhesion,          l.work,           l.friction,   l.damping,       l.local_damping,
               l.bond_damping,      l.bond_friction,  l.fracture,   l.handed,        l.split,
               l.split_added,       l.reshape,        l.inertia,    l.unexplained,   l.most_friction,
               l.most_damping,      l.most_fracture,  l.most_work,  l.start,         l.floor,
               l.fracture_area,     l.residual_force, l.fines.mass, l.fines.kinetic, l.fines.volume,
               l.cracks.bond_energy}) &&
           l.fines.momentum.allFinite() && l.fines.angular_momentum.allFinite(),
       "the ledger");
  for (const FinesClass& c : l.fines.classes) need(finite({c.dimension, c.smallest, c.mass}), "the fines");
  constexpr std::uint64_t endless = std::uint64_t{1} << 60;
  need(finite({s.time, s.dt, s.skin, s.mean_radius, s.grain_pressure}) && s.time >= 0 && s.dt > 0 && s.skin > 0 &&
           s.mean_radius > 0 && s.skin < 1e3 * s.mean_radius,
       "time, step or skin");
  need(s.steps < endless && s.listed_at <= s.steps && s.tested_at <= s.steps && l.breakages < endless &&
           l.bonds_broken < endless && s.sorted < endless && s.reference.mends < endless,
       "numbers of steps");
  const auto every = static_cast<std::uint64_t>(std::max(5, model.numerics.estimate_every));
  need(model.numerics.time_step > 0 ||
           (s.next_estimate <= s.steps + every && s.estimate_interval >= 1 && s.estimate_interval <= every),
       "numbers of steps");
}

}  // namespace

void check_state(const Model& model, const State& s) {
  check_sizes(model, s);
  check_values(model, s);
  check_contacts(model, s);
  if (!s.resting) check_reference(model, s);
  check_bonds(s);
  check_course(model, s);
}

}  // namespace grus::dem
