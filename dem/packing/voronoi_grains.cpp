// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/voronoi_grains.hpp"

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/bond/dashpots.hpp"
#include "dem/bond/face_bond.hpp"
#include "dem/bond/faces.hpp"
#include "dem/rve/measure.hpp"

namespace grus::dem {
namespace {

constexpr double least_face = 1e-6;  // of the squared distance of the seeds
constexpr double least_depth = 0.1;  // of a Voronoi cell's size: a random seed may be as near to a wall as it likes

/// Strengths of one bond: drawn about the material's, of which it has a share, and no more than its energy lets it
/// soften. A weaker bond gives way at as much smaller openings: energies go with the square.
void give_strength(const BondModel& model, double share, std::uint64_t seed, std::uint64_t id, double h, FaceBond& s,
                   bool& coarse) {
  double factor = share;
  if (model.weibull > 0) {
    const double mean = std::tgamma(1 + 1 / model.weibull);
    factor *= std::pow(-std::log(random_uniform(seed, id, Purpose::strength, 1)), 1 / model.weibull) / mean;
  }
  s.criterion = model.criterion;
  s.tension = factor * model.tension, s.cohesion = factor * model.cohesion;
  s.tan_phi = model.tan_phi, s.friction = model.friction;
  s.energy_1 = share * share * model.energy_1, s.energy_2 = share * share * model.energy_2;
  if (s.criterion == FaceCriterion::strain_sum) s.tension *= h;  // an opening
  if (s.criterion != FaceCriterion::cohesive) return;
  const double room = 0.95, limit = room * softening_limit(s.kn, s.energy_1);
  const double limit_shear = room * softening_limit(s.kt, s.energy_2);
  coarse = s.tension > limit || s.cohesion > limit_shear;
  s.tension = std::min(s.tension, limit), s.cohesion = std::min(s.cohesion, limit_shear);
}

double bond_length(const BondModel& model, double apart) { return model.length > 0 ? model.length : apart; }

void set_stiffness(const BondModel& model, double apart, FaceBond& s) {
  s.kn = model.stiffness_given ? model.stiffness : model.stiffness / bond_length(model, apart);
  s.kt = model.ratio * s.kn;
}

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

BondedFaces add_voronoi_grains(const Model& model, const Tessellation& cells, std::uint8_t material, State& state) {
  Grains& g = state.grains;
  const Material& m = model.materials[material];
  HullStore store = g.hulls ? *g.hulls : HullStore{};
  std::vector<GrainSpec> specs;
  for (const Polyhedron& body : cells.body) {
    HullPlace place;
    GrainSpec spec;
    spec.hull = add_hull(store, body, place);
    spec.position = place.origin, spec.orientation = place.axes;
    spec.material = material, spec.density = m.density;
    specs.push_back(spec);
  }
  g.hulls = std::make_shared<HullStore>(std::move(store));
  const std::size_t first = g.size();
  for (const GrainSpec& spec : specs) set_grain(g, g.size(), spec);
  BondedFaces count;
  for (std::size_t i = 0; i < cells.body.size(); ++i)
    for (const auto& face : cells.body[i].face)
      if (face.tag < 0)
        count.outer.push_back({static_cast<Index>(first + i), moments_of(cells.body[i], face), face.normal,
                               face.offset - face.normal.dot(cells.seed[i])});
  if (!m.bond) return count;
  for (std::size_t i = 0; i < cells.body.size(); ++i)
    for (const auto& face : cells.body[i].face) {
      if (face.tag < 0) continue;
      const auto& partner = cells.partner[i][static_cast<std::size_t>(face.tag)];
      if (partner.cell == i)
        throw InputError("a Voronoi cell meets its own image: more cells, or a larger periodic box, are needed");
      if (partner.cell < i) continue;
      const std::size_t j = partner.cell;
      const bool apart = !cells.cluster.empty() && cells.cluster[i] != cells.cluster[j];
      if (apart && m.bond->between == 0) continue;
      const Vec3 image(partner.image[0], partner.image[1], partner.image[2]);
      const Vec3 shift =
          state.boundary.cell.periodic() ? Vec3(state.boundary.cell.vectors * image) : Vec3(Vec3::Zero());
      const FaceMoments moments = moments_of(cells.body[i], face);
      const double h = (cells.seed[j] + shift - cells.seed[i]).norm(), length = bond_length(*m.bond, h);
      if (moments.area < least_face * h * h) {
        ++count.unbonded;
        continue;
      }
      FaceBond s = bond_at(g, static_cast<Index>(first + i), moments, face.normal);
      s.ends.b = static_cast<Index>(first + j), s.ends.image = partner.image;
      const Quat& qb = g.orientation[s.ends.b];
      s.at_b = qb.conjugate() * (moments.centre - shift - g.motion[s.ends.b].position);
      s.rest = (g.orientation[s.ends.a].conjugate() * qb).conjugate();
      set_stiffness(*m.bond, h, s);
      bool coarse = false;
      give_strength(*m.bond, apart ? m.bond->between / m.bond->tension : 1, model.seed, state.bonds.face.row.size(),
                    length, s, coarse);
      count.coarse += coarse;
      state.bonds.face.row.push_back(s);
      if (m.bond->damping == 0) continue;
      state.bonds.dashpot.resize(state.bonds.face.row.size());
      state.bonds.dashpot.back() = dashpot_of(s, g, m.bond->damping);
    }
  count.bonds = state.bonds.face.row.size();
  if (!state.bonds.dashpot.empty()) state.bonds.dashpot.resize(count.bonds);
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
