// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/cut_bonds.hpp"

#include <algorithm>

#include "dem/bond/dashpots.hpp"
#include "dem/bond/face_bond.hpp"
#include "dem/bond/faces.hpp"
#include "dem/contact/hull_pairs.hpp"

namespace grus::dem {
namespace {

/// Less of a face than this is no part of its own.
constexpr double least_part = 1e-6;

/// The plane of a cut in the axes of a bond's face: it has height + slope . y above it.
struct Height {
  double at_middle;
  Eigen::Vector2d slope;
};

Height height_of(const FaceBond& s, int end, const Vec3& normal, double offset) {
  const Vec3 n = end == 1 ? Vec3(s.rest.conjugate() * normal) : normal;
  return {normal.dot(end == 1 ? s.at_b : s.at_a) - offset, {n.dot(s.e1), n.dot(s.normal.cross(s.e1))}};
}

/// A bond goes over to the pieces: the row to the first that has a part of it, and what the other has is the result.
std::vector<FaceBond> share_bond(const Grains& g, const Pieces& pieces, const std::array<Index, 2>& slot, bool walled,
                                 FaceBond& s) {
  const FreshFace& face = pieces.face.front();
  const int end = s.ends.a == slot[0] ? 0 : 1;
  const Height h = height_of(s, end, face.normal, face.normal.dot(face.moments.centre));
  const FlatPolygon whole = polygon_of(g, s, walled);
  std::array<FlatMoments, 2> part{moments_of(clipped(whole, h.slope, -h.at_middle)),
                                  moments_of(clipped(whole, -h.slope, h.at_middle))};
  const double area = part[0].area + part[1].area, exact = s.area / area;
  for (FlatMoments& m : part) m.area *= exact, m.first *= exact, m.second *= exact;
  const auto hang = [&](FaceBond& row, std::size_t k) {
    rehang(row, end, slot[k], pieces.place[k].axes, pieces.place[k].origin);
  };
  for (std::size_t k = 0; k < 2; ++k)
    if (!(part[k].area > least_part * s.area)) {
      hang(s, 1 - k);
      return {};
    }
  const Quat b = walled ? Quat::Identity() : g.orientation[s.ends.b];
  const Quat turn = g.orientation[s.ends.a].conjugate() * b * s.rest;
  const FaceBond first = part_of(s, part[0], turn);
  FaceBond other = part_of(s, part[1], turn);
  s = first;
  hang(s, 0), hang(other, 1);
  return {other};
}

/// Force on a piece, and moment about the middle of the fresh face, that let it go on with its parent.
FaceWrench demand(const Grains& g, std::size_t piece, const ParentMotion& parent, const Vec3& middle) {
  const Vec3 d = g.motion[piece].position - parent.position;
  const Vec3 a = parent.acceleration + parent.spin_rate.cross(d) + parent.spin.cross(parent.spin.cross(d));
  const Vec3 force = g.mass[piece] * a - g.force[piece];
  const Vec3 torque =
      inertia_tensor(g, piece) * parent.spin_rate + parent.spin.cross(g.angular_momentum[piece]) - g.torque[piece];
  return {force, torque + (g.motion[piece].position - middle).cross(force)};
}

FaceBond* bond_between(Bonds& bonds, std::size_t a, std::size_t b) {
  const auto at = std::find_if(bonds.face.row.rbegin(), bonds.face.row.rend(),
                               [&](const FaceBond& s) { return s.ends.a == a && s.ends.b == b; });
  return at == bonds.face.row.rend() ? nullptr : &*at;
}

}  // namespace

void cut_bonds(const Pieces& pieces, Index i, Index second, State& state) {
  const Grains& g = state.grains;
  const std::array<Index, 2> slot{i, second};
  Bonds& bonds = state.bonds;
  std::vector<FaceBond> more;
  const auto share = [&](std::vector<FaceBond>& rows, bool walled) {
    more.clear();
    for (FaceBond& s : rows)
      if (s.ends.a == i || (!walled && s.ends.b == i))
        for (FaceBond& other : share_bond(g, pieces, slot, walled, s)) more.push_back(other);
    rows.insert(rows.end(), more.begin(), more.end());
  };
  share(bonds.face.row, false), share(bonds.wall, true);
  bonds.outline.clear();
  bonds.face.tiles.grains = 0;
  if (!bonds.dashpot.empty()) bonds.dashpot.resize(bonds.face.row.size());
  const FreshFace& face = pieces.face.front();
  for (DeadLoad& load : bonds.load)
    if (load.grain == i) {
      const std::size_t k = face.normal.dot(load.at - face.moments.centre) > 0;
      load.grain = slot[k];
      load.at = pieces.place[k].axes.conjugate() * (load.at - pieces.place[k].origin);
    }
}

void share_out(const Pieces& pieces, Index i, Index second, State& state) {
  for (const FreshFace& face : pieces.face) state.ledger.fracture_area += face.moments.area;
  for (DeadLoad& load : state.bonds.load) {
    if (load.grain != i) continue;
    std::size_t in = 0;
    double deepest = -INFINITY;
    for (std::size_t k = 0; k < pieces.body.size(); ++k) {
      double depth = INFINITY;
      for (const Polyhedron::Face& face : pieces.body[k].face)
        depth = std::min(depth, face.offset - face.normal.dot(load.at));
      if (depth > deepest) deepest = depth, in = k;
    }
    load.grain = in == 0 ? i : second + static_cast<Index>(in) - 1;
    load.at = pieces.place[in].axes.conjugate() * (load.at - pieces.place[in].origin);
  }
}

void join_pieces(const Model& model, const Pieces& pieces, std::span<const std::size_t> slots, State& state) {
  Grains& g = state.grains;
  Bonds& bonds = state.bonds;
  const Material& material = model.materials[g.material[slots[0]]];
  const Cut& how = std::get<Cut>(material.fracture->splitter);
  state.ledger.fracture_area += pieces.face.front().moments.area;
  if (how.cohesive) {
    const FreshFace& face = pieces.face.front();
    const auto a = static_cast<Index>(slots[0]), b = static_cast<Index>(slots[1]);
    // The parent's frame, as the first piece has it.
    const Quat q = g.orientation[a] * pieces.place[0].axes.conjugate();
    const Mat3 axes = q.toRotationMatrix();
    const Vec3 origin = g.motion[a].position - axes * pieces.place[0].origin;
    const FaceMoments moments{face.moments.area, origin + axes * face.moments.centre,
                              axes * face.moments.second * axes.transpose()};
    FaceBond s = bond_at(g, a, moments, axes * face.normal);
    s.ends.b = b;
    s.at_b = g.orientation[b].conjugate() * (moments.centre - g.motion[b].position);
    s.rest = g.orientation[b].conjugate() * g.orientation[a];
    const PairLaw& p = model.pairs[g.material[a] * (model.materials.size() + 1)];
    s.kn = foundation_of(p, g, a, b);
    s.kt = (p.shear_ratio > 0 ? p.shear_ratio : 1) * s.kn;
    s.tension = s.cohesion = INFINITY, s.tan_phi = 0, s.friction = material.friction;
    s.energy_1 = s.energy_2 = how.energy;
    bonds.face.row.push_back(s);
    bonds.face.tiles.grains = 0;
    const bool damped = material.bond && material.bond->damping > 0;
    if (damped || !bonds.dashpot.empty()) bonds.dashpot.resize(bonds.face.row.size());
  }
  if (bonds.dashpot.empty()) return;
  for (std::size_t k = 0; k < bonds.face.row.size(); ++k) {
    const FaceBond& s = bonds.face.row[k];
    const auto of_piece = [&](Index end) { return end == slots[0] || end == slots[1]; };
    if (!of_piece(s.ends.a) && !of_piece(s.ends.b)) continue;
    const auto& bond = model.materials[g.material[s.ends.a]].bond;
    bonds.dashpot[k] = dashpot_of(s, g, bond ? bond->damping : 0);
  }
}

double load_cap(State& state, const ParentMotion& parent, const FreshFace& face, std::span<const std::size_t> slots) {
  const Grains& g = state.grains;
  FaceBond* s = bond_between(state.bonds, slots[face.below], slots[face.above]);
  if (!s) return 0;
  const Vec3 middle = parent.position + parent.axes * face.moments.centre;
  const FaceWrench above = demand(g, slots[face.above], parent, middle);
  const FaceWrench below = demand(g, slots[face.below], parent, middle);
  state.ledger.residual_force += 0.5 * (above.force + below.force).norm();
  Mat3 axes;  // of the face: e1, e2, normal
  axes << s->e1, s->normal.cross(s->e1), s->normal;
  axes = g.orientation[s->ends.a].toRotationMatrix() * axes;
  const Vec3 force = 0.5 * (above.force - below.force), couple = 0.5 * (above.couple - below.couple);
  if (!bear(*s, axes.transpose() * force, axes.transpose() * couple, {&g})) state.ledger.residual_force += force.norm();
  return energy(*s);
}

double bond_energy_of(const State& state, std::span<const std::uint8_t> among) {
  double sum = 0;
  for (const FaceBond& s : state.bonds.face.row)
    if (among[s.ends.a] || among[s.ends.b]) sum += energy(s);
  for (const FaceBond& s : state.bonds.wall)
    if (among[s.ends.a]) sum += energy(s);
  for (const Handed& h : state.bonds.handed)
    if (among[h.ends.a] || among[h.ends.b]) sum += h.kept;
  return sum;
}

void draw_crystals(const Model& model, Grains& g) {
  const auto crystal_of = [&](std::size_t i) -> const Crystal* {
    const auto& fracture = model.materials[g.material[i]].fracture;
    return fracture && fracture->crystal ? &*fracture->crystal : nullptr;
  };
  bool any = false;
  for (std::size_t i = 0; i < g.size() && !any; ++i) any = crystal_of(i);
  if (!any || !g.crystal.empty()) return;
  g.crystal.assign(g.size(), Quat::Identity());
  for (std::size_t i = 0; i < g.size(); ++i)
    if (const Crystal* crystal = crystal_of(i))
      g.crystal[i] = g.orientation[i].conjugate() * crystal->draw(model.seed, g.id[i]);
}

}  // namespace grus::dem
