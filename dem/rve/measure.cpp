// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/measure.hpp"

#include <array>

#include "dem/bond/kinds.hpp"
#include "dem/bond/supports.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/grain_stress.hpp"

namespace grus::dem {
namespace {

/// The walls of a box that face + and - along an axis, by index; `none` where there is none.
struct Faces {
  static constexpr std::size_t none = SIZE_MAX;
  std::size_t plus = none, minus = none;
};

Faces faces(const Boundary& boundary, int axis) {
  Faces found;
  for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
    if (boundary.walls[w].normal[axis] == 1) found.plus = w;
    if (boundary.walls[w].normal[axis] == -1) found.minus = w;
  }
  return found;
}

double width(const Boundary& boundary, const Faces& of, int axis) {
  return boundary.walls[of.minus].point[axis] - boundary.walls[of.plus].point[axis];
}

}  // namespace

Vec3 branch(const State& s, std::size_t k) {
  const Pair& p = s.contacts.pair[k];
  if (k >= s.contacts.begin[first_wall]) return contact_arm(s.grains, s.contacts, k, false);
  Vec3 l = s.grains.motion[p.b].position - s.grains.motion[p.a].position;
  if (s.boundary.cell.periodic()) l += s.boundary.cell.vectors * Vec3(p.image[0], p.image[1], p.image[2]);
  return l;
}

Eigen::Matrix<double, 3, 6> displacement_of_strain(const Vec3& l) {
  Eigen::Matrix<double, 3, 6> b = Eigen::Matrix<double, 3, 6>::Zero();
  for (int e = 0; e < 6; ++e) {
    const int i = voigt_row[e], j = voigt_col[e];
    if (i == j)
      b(i, e) = l[i];
    else
      b(i, e) = 0.5 * l[j], b(j, e) = 0.5 * l[i];
  }
  return b;
}

double bulk_volume(const Boundary& boundary) {
  if (boundary.cell.periodic()) return boundary.cell.volume();
  double v = 1;
  const Wall* round = cylinder(boundary);
  for (int k = 0; k < 3; ++k) {
    if (round && round->axis[k] == 0) {  // two axes across: pi R^2
      v *= std::sqrt(pi) * round->radius;
      continue;
    }
    const Faces of = faces(boundary, k);
    if (of.plus == Faces::none || of.minus == Faces::none) return 0;
    v *= width(boundary, of, k);
  }
  return v;
}

Mat3 love_weber(const State& s, double volume) {
  Mat3 sum = Mat3::Zero();
  if (volume <= 0) return sum;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) sum -= s.contacts.touch[k].force * branch(s, k).transpose();
  for_each_bond(
      s.bonds, [&](const auto& bond) { sum -= bond.force * branch(s.grains, s.boundary.cell, bond.ends).transpose(); });
  for (const FaceBond& bond : s.bonds.wall)
    sum -= bond.force * (s.grains.orientation[bond.ends.a] * bond.at_a).transpose();
  return 0.5 / volume * (sum + sum.transpose());
}

PartedStress parted_stress(const State& s) {
  const Cell& cell = s.boundary.cell;
  PartedStress sum;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Pair& p = s.contacts.pair[k];
    const auto& touch = s.contacts.touch[k];
    const Vec3 apart = s.grains.motion[p.b].position - s.grains.motion[p.a].position;
    const Vec3 l = crosses(p) ? Vec3(apart + cell.vectors * Vec3(p.image[0], p.image[1], p.image[2])) : apart;
    const double viscous = s.contacts.contact.viscous[k];
    sum.rest -= (touch.force - viscous * touch.normal) * l.transpose();
    if (viscous != 0) sum.dashpots -= viscous * touch.normal * l.transpose();
  }
  for_each_bond(s.bonds,
                [&](const auto& bond) { sum.rest -= bond.force * branch(s.grains, cell, bond.ends).transpose(); });
  for (Mat3* m : {&sum.rest, &sum.dashpots}) *m = Mat3(0.5 / cell.volume() * (*m + m->transpose()));
  return sum;
}

double pressure_scatter(const State& s, double volume) {
  if (volume <= 0 || s.grains.size() < 2) return 0;
  std::vector<double> share(s.grains.size(), 0.0);
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const double carried = s.contacts.touch[k].force.dot(branch(s, k));
    const Pair& p = s.contacts.pair[k];
    sum += carried;
    if (k >= s.contacts.begin[first_wall])
      share[p.a] += carried;
    else
      share[p.a] += 0.5 * carried, share[p.b] += 0.5 * carried;
  }
  if (sum == 0) return 0;
  const double n = static_cast<double>(share.size()), mean = sum / n;
  for (const double v : share) squares += (v - mean) * (v - mean);
  return std::sqrt(n / (n - 1) * squares) / std::abs(sum);
}

double mean_diameter(const Grains& g) {
  double sum = 0;
  for (const Extent& e : g.extent) sum += 2 * e.equivalent_radius;
  return g.size() > 0 ? sum / static_cast<double>(g.size()) : 0;
}

double inertial_number(const State& s, double strain_rate, double pressure) {
  if (pressure <= 0) return 0;
  const double density = total_mass(s.grains) / solid_volume(s.grains);
  return std::abs(strain_rate) * mean_diameter(s.grains) * std::sqrt(density / pressure);
}

namespace {

/// Pressure on a cylinder of volume V = pi R^2 h: what pushes outward over 2 pi R h = 2 V / R (Pa).
double radial_stress(const State& s, double volume) {
  double force = 0, radius = 0;
  for (std::size_t c = s.contacts.begin[first_wall]; c < s.contacts.size(); ++c) {
    const Wall& wall = s.boundary.walls[s.contacts.pair[c].b];
    if (!wall.round()) continue;
    force += s.contacts.touch[c].force.dot(s.contacts.touch[c].normal);
    radius = wall.radius;
  }
  return 0.5 * force * radius / volume;
}

}  // namespace

Measurement measure(const Model& model, const State& s) {
  Measurement m;
  m.volume = bulk_volume(s.boundary);
  m.stress = love_weber(s, m.volume);
  if (m.volume > 0 && !s.boundary.cell.periodic()) {
    const Wall* round = cylinder(s.boundary);
    const double radial = round ? radial_stress(s, m.volume) : 0;
    for (int k = 0; k < 3; ++k) {
      if (round && round->axis[k] == 0) {
        m.wall_stress(k, k) = -radial;
        continue;
      }
      const Faces of = faces(s.boundary, k);
      // Mean of both faces; the force on the + wall points outward, along +k.
      double force = 0;
      for (std::size_t c = s.contacts.begin[first_wall]; c < s.contacts.size(); ++c) {
        const std::size_t w = s.contacts.pair[c].b;
        if (w == of.plus) force -= s.contacts.touch[c].force[k];
        if (w == of.minus) force += s.contacts.touch[c].force[k];
      }
      if (!s.bonds.wall.empty()) force += (support_force(s.bonds, of.minus) - support_force(s.bonds, of.plus))[k];
      m.wall_stress(k, k) = -0.5 * force * width(s.boundary, of, k) / m.volume;
    }
  }
  double contact_force = 0;
  std::size_t ends = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Vec3& n = s.contacts.touch[k].normal;
    ++m.contacts;
    ends += k < s.contacts.begin[first_wall] ? 2u : 1u;
    m.fabric += n * n.transpose();
    contact_force += s.contacts.touch[k].force.norm();
  }
  const double n = static_cast<double>(std::max<std::size_t>(s.grains.size(), 1));
  if (m.contacts > 0) m.fabric /= static_cast<double>(m.contacts);
  for (const FaceBond& bond : s.bonds.face.row) contact_force += bond.force.norm();  // as contacts do
  for (const FaceBond& bond : s.bonds.wall) contact_force += bond.force.norm();
  if (contact_force > 0) {
    double resultant = 0;
    for (const auto& f : s.grains.force) resultant += f.norm();
    const auto links = static_cast<double>(m.contacts + s.bonds.face.row.size() + s.bonds.wall.size());
    m.unbalanced_force = resultant / n / (contact_force / links);
  }
  m.coordination = static_cast<double>(ends) / n;
  const double solid = solid_volume(s.grains);
  if (m.volume > 0) m.solid_fraction = solid / m.volume, m.void_ratio = m.volume / solid - 1;
  m.kinetic = kinetic_energy(s.grains);
  m.elastic = elastic_energy(model.law, s.contacts) + stored_energy(s.bonds);
  return m;
}

Mat6 contact_stiffness_tangent(const Model& model, const State& s) {
  Mat6 tangent = Mat6::Zero();
  const double volume = bulk_volume(s.boundary);
  if (volume <= 0) return tangent;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Contact c = s.contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const PairLaw& p = model.pairs[s.contacts.pair[k].law];
    const Elastic elastic =
        std::visit([&](const auto& law) { return law(c.stiffness, s.contacts.touch[k].overlap); }, model.law);
    const double normal_force = elastic.force + c.viscous;
    const bool slides = c.spring.norm() >= p.friction * normal_force * (1 - 1e-9);
    const double kt = p.friction > 0 && !slides ? p.shear_ratio * elastic.normal_stiffness : 0;
    const Vec3 l = branch(s, k), &n = s.contacts.touch[k].normal;
    const auto b = displacement_of_strain(l);
    const Mat3 stiffness = (elastic.normal_stiffness - kt) * n * n.transpose() + kt * Mat3::Identity();
    tangent += b.transpose() * stiffness * b;
  }
  for_each_bond(s.bonds, [&](const auto& bond) {
    const auto b = displacement_of_strain(branch(s.grains, s.boundary.cell, bond.ends));
    tangent += b.transpose() * stiffness(bond, s.grains.orientation[bond.ends.a]).shift * b;
  });
  for (const FaceBond& bond : s.bonds.wall) {
    const Quat& q = s.grains.orientation[bond.ends.a];
    const auto b = displacement_of_strain(q * bond.at_a);
    tangent += b.transpose() * stiffness(bond, q).shift * b;
  }
  return tangent / volume;
}

}  // namespace grus::dem
