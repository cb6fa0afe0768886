// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/voronoi_grains.hpp"

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/bond/dashpots.hpp"
#include "dem/bond/face_bond.hpp"
#include "dem/bond/faces.hpp"
#include "dem/packing/bond_strength.hpp"
#include "dem/rve/measure.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

constexpr double least_face = 1e-6;  // of the squared distance of the seeds
constexpr double least_depth = 0.1;  // of a Voronoi cell's size: a random seed may be as near to a wall as it likes

}  // namespace

double stiffer_than_endless(const State& state, const BondModel& model, int axis) {
  if (model.stiffness_given || model.length > 0) return 1;
  Mat6 whole = Mat6::Zero();
  double volume = 0;  // of all faces' area times distance the share that looks along the axis
  const auto add = [&](const FaceBond& s) {
    const Quat& q = state.grains.orientation[s.ends.a];
    const Vec3 n = q * s.normal;
    const double apart = model.stiffness / s.kn;
    const auto moved = displacement_of_strain(apart * n);
    whole += moved.transpose() * stiffest(s, q).shift * moved;
    volume += s.area * apart * n[axis] * n[axis];
  };
  for (const FaceBond& s : state.bonds.face.row) add(s);
  for (const FaceBond& s : state.bonds.wall) add(s);
  if (!(volume > 0)) return 1;
  const Mat6 inverse = whole.completeOrthogonalDecomposition().pseudoInverse();
  const double endless = model.stiffness * (2 + 3 * model.ratio) / (4 + model.ratio);
  return 1 / (inverse(axis, axis) * volume) / endless;
}

namespace {

/// Bodies as hulls at rest, in the frame in which they are given; the number of the first.
std::size_t add_hulls(const Model& model, std::span<const Polyhedron> bodies, std::span<const std::uint8_t> materials,
                      Grains& g) {
  HullStore store = g.hulls ? *g.hulls : HullStore{};
  std::vector<GrainSpec> specs;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    HullPlace place;
    GrainSpec spec;
    spec.hull = add_hull(store, bodies[i], place);
    spec.position = place.origin, spec.orientation = place.axes;
    spec.material = materials[i % materials.size()], spec.density = model.materials[spec.material].density;
    specs.push_back(spec);
  }
  g.hulls = std::make_shared<HullStore>(std::move(store));
  const std::size_t first = g.size();
  for (const GrainSpec& spec : specs) set_grain(g, g.size(), spec);
  return first;
}

/// Where two grains meet face to face, before they are bonded.
struct Joint {
  Index a, b;
  std::array<std::int16_t, 3> image;
  FaceMoments face;
  Vec3 normal;          // of a
  double apart, depth;  // m, of both middles, and of that of a from the face
  double share = 1;     // of the strength
};

void bond(const Model& model, const Joint& joint, State& state, BondedFaces& count) {
  Grains& g = state.grains;
  const auto &of_a = model.materials[g.material[joint.a]].bond, &of_b = model.materials[g.material[joint.b]].bond;
  if (!of_a || !of_b) return;
  if (joint.face.area < least_face * joint.apart * joint.apart) {
    ++count.unbonded;
    return;
  }
  const BondModel& weaker = weaker_of(*of_a, *of_b);
  const Vec3 shift = at_image(state.boundary.cell.vectors, joint.image);
  FaceBond s = bond_at(g, joint.a, joint.face, joint.normal);
  s.ends.b = joint.b, s.ends.image = joint.image;
  const Quat& qb = g.orientation[s.ends.b];
  s.at_b = qb.conjugate() * (joint.face.centre - shift - g.motion[s.ends.b].position);
  s.rest = (g.orientation[s.ends.a].conjugate() * qb).conjugate();
  if (g.material[joint.a] == g.material[joint.b])
    set_stiffness(weaker, joint.apart, s);
  else
    set_stiffness(*of_a, joint.depth, *of_b, joint.apart - joint.depth, s);
  bool coarse = false;
  give_strength(weaker, joint.share, model.seed, state.bonds.face.row.size(), bond_length(weaker, joint.apart), s,
                coarse);
  count.coarse += coarse;
  state.bonds.face.row.push_back(s);
  if (weaker.damping == 0) return;
  state.bonds.dashpot.resize(state.bonds.face.row.size());
  state.bonds.dashpot.back() = dashpot_of(s, g, weaker.damping);
}

void end_bonds(State& state, BondedFaces& count) {
  count.bonds = state.bonds.face.row.size();
  if (!state.bonds.dashpot.empty()) state.bonds.dashpot.resize(count.bonds);
}

}  // namespace

BondedFaces add_voronoi_grains(const Model& model, const Tessellation& cells, std::uint8_t material, State& state) {
  const std::size_t first = add_hulls(model, cells.body, {&material, 1}, state.grains);
  BondedFaces count;
  for (std::size_t i = 0; i < cells.body.size(); ++i)
    for (const auto& face : cells.body[i].face)
      if (face.tag < 0)
        count.outer.push_back({static_cast<Index>(first + i), moments_of(cells.body[i], face), face.normal,
                               face.offset - face.normal.dot(cells.seed[i])});
  const auto& model_of = model.materials[material].bond;
  if (!model_of) return count;
  for (std::size_t i = 0; i < cells.body.size(); ++i)
    for (const auto& face : cells.body[i].face) {
      if (face.tag < 0) continue;
      const auto& partner = cells.partner[i][static_cast<std::size_t>(face.tag)];
      if (partner.cell == i)
        throw InputError("a Voronoi cell meets its own image: more cells, or a larger periodic box, are needed");
      if (partner.cell < i) continue;
      const std::size_t j = partner.cell;
      const bool apart = !cells.cluster.empty() && cells.cluster[i] != cells.cluster[j];
      if (apart && model_of->between == 0) continue;
      const Vec3 shift = at_image(state.boundary.cell.vectors, partner.image);
      const double h = (cells.seed[j] + shift - cells.seed[i]).norm();
      bond(
          model,
          {static_cast<Index>(first + i), static_cast<Index>(first + j), partner.image, moments_of(cells.body[i], face),
           face.normal, h, 0.5 * h, apart ? model_of->between / model_of->tension : 1},
          state, count);
    }
  end_bonds(state, count);
  return count;
}

BondedFaces add_bodies(const Model& model, std::span<const Polyhedron> bodies, std::span<const Vec3> middles,
                       std::span<const std::uint8_t> materials, const SharedFaces& shared, State& state) {
  const std::size_t first = add_hulls(model, bodies, materials, state.grains);
  BondedFaces count;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t f = 0; f < bodies[i].face.size(); ++f)
      if (const auto& face = bodies[i].face[f]; !shared.shared[i][f])
        count.outer.push_back({static_cast<Index>(first + i), moments_of(bodies[i], face), face.normal,
                               face.offset - face.normal.dot(middles[i])});
  for (const SharedFace& s : shared.face) {
    const Vec3 shift = at_image(state.boundary.cell.vectors, s.image);
    const double depth = s.normal.dot(s.face.centre - middles[s.a]);
    bond(model,
         {static_cast<Index>(first + s.a), static_cast<Index>(first + s.b), s.image, s.face, s.normal,
          s.normal.dot(middles[s.b] + shift - middles[s.a]), depth},
         state, count);
  }
  end_bonds(state, count);
  return count;
}

std::vector<OuterFace> faces_towards(std::span<const OuterFace> outer, const Vec3& direction, double& offset) {
  std::vector<OuterFace> found;
  offset = -INFINITY;
  double size = 0;
  for (const OuterFace& f : outer) {
    offset = std::max(offset, f.face.centre.dot(direction)), size = std::max(size, f.depth);
  }
  for (const OuterFace& f : outer)
    if (f.normal.dot(direction) > 1 - 1e-9 && f.face.centre.dot(direction) > offset - 1e-6 * size) found.push_back(f);
  return found;
}

void glue(const Model& model, std::span<const OuterFace> faces, Index wall, bool slides, State& state) {
  const Grains& g = state.grains;
  for (const OuterFace& f : faces) {
    FaceBond s = bond_at(g, f.grain, f.face, f.normal);
    const double least = least_depth * 2 * g.extent[f.grain].equivalent_radius;
    set_stiffness(*model.materials[g.material[f.grain]].bond, 2 * std::max(f.depth, least), s);
    s.ends.b = wall;
    s.at_b = f.face.centre - state.boundary.walls[wall].point;
    s.rest = g.orientation[f.grain];
    s.kn *= 2;
    s.kt *= slides ? 0 : 2;
    s.criterion = FaceCriterion::parallel;
    s.tension = s.cohesion = INFINITY, s.tan_phi = s.friction = 0;
    s.energy_1 = s.energy_2 = INFINITY;
    state.bonds.wall.push_back(s);
  }
}

void add_load(std::span<const OuterFace> faces, const Vec3& force, double ramp, State& state) {
  const Grains& g = state.grains;
  double area = 0;
  for (const OuterFace& f : faces) area += f.face.area;
  for (const OuterFace& f : faces) {
    DeadLoad load{f.grain, g.orientation[f.grain].conjugate() * (f.face.centre - g.motion[f.grain].position),
                  f.face.area / area * force, ramp};
    load.point = f.face.centre;
    state.bonds.load.push_back(load);
  }
}

}  // namespace grus::dem
