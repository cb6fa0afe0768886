// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/cells.hpp"

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/bond/face_bond.hpp"

namespace grus::dem {
namespace {

constexpr double least_face = 1e-6;  // of the squared distance of the seeds

/// Axes of a face along which its second moments are principal: turns about e1 meet i1.
struct FaceAxes {
  Vec3 e1;
  double i1, i2;
};

FaceAxes principal_axes(const FaceMoments& m, const Vec3& normal) {
  Eigen::Index least;
  normal.cwiseAbs().minCoeff(&least);
  const Vec3 u = normal.cross(Vec3::Unit(least)).normalized(), v = normal.cross(u);
  const double uu = u.dot(m.second * u), vv = v.dot(m.second * v), uv = u.dot(m.second * v);
  const double angle = 0.5 * std::atan2(2 * uv, uu - vv), c = std::cos(angle), s = std::sin(angle);
  const double along = c * c * uu + 2 * c * s * uv + s * s * vv;
  return {c * u + s * v, uu + vv - along, along};  // a turn about e1 opens by the distance from it
}

/// Strengths of one bond: drawn about the material's, and no more than its energy lets it soften.
void give_strength(const BondModel& model, std::uint64_t seed, std::uint64_t id, double h, FaceBond& s, bool& coarse) {
  double factor = 1;
  if (model.weibull > 0) {
    const double mean = std::tgamma(1 + 1 / model.weibull);
    factor = std::pow(-std::log(random_uniform(seed, id, Purpose::strength, 1)), 1 / model.weibull) / mean;
  }
  s.criterion = model.criterion;
  s.tension = factor * model.tension, s.cohesion = factor * model.cohesion;
  s.tan_phi = model.tan_phi, s.friction = model.friction;
  s.energy_1 = model.energy_1, s.energy_2 = model.energy_2;
  if (s.criterion == FaceCriterion::strain_sum) s.tension *= h;  // an opening
  if (s.criterion != FaceCriterion::cohesive) return;
  const double share = 0.95, limit = share * softening_limit(s.kn, s.energy_1);
  const double limit_shear = share * softening_limit(s.kt, s.energy_2);
  coarse = s.tension > limit || s.cohesion > limit_shear;
  s.tension = std::min(s.tension, limit), s.cohesion = std::min(s.cohesion, limit_shear);
}

}  // namespace

BondedFaces add_cells(const Model& model, const VoronoiCells& cells, std::uint8_t material, State& state) {
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
  if (!m.bond) return count;
  for (std::size_t i = 0; i < cells.body.size(); ++i)
    for (const auto& face : cells.body[i].face) {
      if (face.tag < 0) continue;
      const auto& partner = cells.partner[i][static_cast<std::size_t>(face.tag)];
      if (partner.cell == i)
        throw InputError("a cell meets its own image: more cells, or a larger periodic box, are needed");
      if (partner.cell < i) continue;
      const std::size_t j = partner.cell;
      const Vec3 image(partner.image[0], partner.image[1], partner.image[2]);
      const Vec3 shift =
          state.boundary.cell.periodic() ? Vec3(state.boundary.cell.vectors * image) : Vec3(Vec3::Zero());
      const FaceMoments moments = moments_of(cells.body[i], face);
      const double h = (cells.seed[j] + shift - cells.seed[i]).norm(), length = m.bond->length > 0 ? m.bond->length : h;
      if (moments.area < least_face * h * h) {
        ++count.unbonded;
        continue;
      }
      FaceBond s;
      const Quat &qa = g.orientation[first + i], &qb = g.orientation[first + j];
      const FaceAxes axes = principal_axes(moments, face.normal);
      s.ends = {static_cast<Index>(first + i), static_cast<Index>(first + j), partner.image};
      s.at_a = qa.conjugate() * (moments.centre - g.motion[first + i].position);
      s.at_b = qb.conjugate() * (moments.centre - shift - g.motion[first + j].position);
      s.normal = qa.conjugate() * face.normal, s.e1 = qa.conjugate() * axes.e1;
      s.rest = (qa.conjugate() * qb).conjugate();
      s.area = moments.area, s.i1 = axes.i1, s.i2 = axes.i2;
      s.kn = m.bond->stiffness_given ? m.bond->stiffness : m.bond->stiffness / length;
      s.kt = m.bond->ratio * s.kn;
      bool coarse = false;
      give_strength(*m.bond, model.seed, state.bonds.face.row.size(), length, s, coarse);
      count.coarse += coarse;
      state.bonds.face.row.push_back(s);
    }
  count.bonds = state.bonds.face.row.size();
  return count;
}

}  // namespace grus::dem
