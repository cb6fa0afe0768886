// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/measure.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "dem/base/renew.hpp"
#include "dem/bond/kinds.hpp"
#include "dem/bond/supports.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/rve/rough_walls.hpp"
#include "dem/state/images.hpp"

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
    if (boundary.walls[w].facing()[axis] == 1) found.plus = w;
    if (boundary.walls[w].facing()[axis] == -1) found.minus = w;
  }
  return found;
}

double width(const Boundary& boundary, const Faces& of, int axis) {
  return boundary.walls[of.minus].point[axis] - boundary.walls[of.plus].point[axis];
}

/// Branch of a pair of grains.
inline Vec3 between(const State& s, const Pair& p) {
  const Motion &a = s.grains.motion[p.a], &b = s.grains.motion[p.b];
  Vec3 l = b.position - a.position;
  if (a.inverse_mass == 0) l -= to_plane(s, p.a);
  if (b.inverse_mass == 0) l += to_plane(s, p.b);
  if (s.boundary.cell.periodic()) l += at_image(s.boundary.cell.vectors, p.image);
  return l;
}

}  // namespace

Vec3 branch(const State& s, std::size_t k) {
  return k < s.contacts.begin[first_wall] ? between(s, s.contacts.pair[k])
                                          : contact_arm(s.grains, s.contacts, k, false);
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
  const Cell& cell = boundary.cell;
  if (cell.everywhere()) return cell.volume();
  double v = 1;
  const CylinderWall* round = cylinder(boundary);
  for (int k = 0; k < 3; ++k) {
    if (round && round->axis[k] == 0) {  // two axes across: pi R^2
      v *= std::sqrt(pi) * round->radius;
      continue;
    }
    if (cell.walled && k < 2) {
      v *= cell.vectors(k, k);
      continue;
    }
    const Faces of = faces(boundary, k);
    if (of.plus == Faces::none || of.minus == Faces::none) return 0;
    v *= width(boundary, of, k);
  }
  return v;
}

double void_ratio(const State& s) { return bulk_volume(s.boundary) / solid_volume(s.grains) - 1; }

namespace {

/// `virial`: of the contacts.
Mat3 stress_of(const Mat3& virial, const State& s, double volume) {
  Mat3 sum = virial;
  if (volume <= 0) return Mat3::Zero();
  for_each_bond(
      s.bonds, [&](const auto& bond) { sum -= bond.force * branch(s.grains, s.boundary.cell, bond.ends).transpose(); });
  for (const FaceBond& bond : s.bonds.wall)
    sum -= bond.force * (s.grains.orientation[bond.ends.a] * bond.at_a).transpose();
  return 0.5 / volume * (sum + sum.transpose());
}

}  // namespace

Mat3 love_weber(const State& s, double volume) {
  Mat3 sum = Mat3::Zero();
  if (volume <= 0) return sum;
  for (std::size_t k = 0; k < s.contacts.size(); ++k)
    if (s.contacts.contact.touching(k)) sum -= s.contacts.touch[k].force * branch(s, k).transpose();
  return stress_of(sum, s, volume);
}

PartedStress parted_stress(const State& s) {
  const Cell& cell = s.boundary.cell;
  PartedStress sum;
  for (std::size_t k = 0; k < s.contacts.begin[first_wall]; ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Pair& p = s.contacts.pair[k];
    const auto& touch = s.contacts.touch[k];
    const Vec3 apart = s.grains.motion[p.b].position - s.grains.motion[p.a].position;
    const Vec3 l = apart + at_image(cell.vectors, p.image);  // faster than to ask whether they cross
    const double viscous = s.contacts.contact.viscous[k];
    sum.rest -= (touch.force - viscous * touch.normal) * l.transpose();
    if (viscous != 0) sum.dashpots -= viscous * touch.normal * l.transpose();
  }
  for_each_bond(s.bonds,
                [&](const auto& bond) { sum.rest -= bond.force * branch(s.grains, cell, bond.ends).transpose(); });
  for (Mat3* m : {&sum.rest, &sum.dashpots}) *m = Mat3(0.5 / cell.volume() * (*m + m->transpose()));
  return sum;
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
    const auto* round = std::get_if<CylinderWall>(&s.boundary.walls[s.contacts.pair[c].b].shape);
    if (!round) continue;
    force += s.contacts.touch[c].force.dot(s.contacts.touch[c].normal);
    radius = round->radius;
  }
  return 0.5 * force * radius / volume;
}

}  // namespace

namespace {

/// Sums are kept by so many contacts or grains, and added in order: the same bits for any number of threads, and those
/// of one plain sum where there are no more.
constexpr std::size_t chunk = 8192;

struct ContactSums {
  Mat3 virial = Mat3::Zero(), fabric = Mat3::Zero();
  double force = 0, elastic = 0;
  std::size_t touching = 0, ends = 0;
  DeepestContact deepest;

  void add(const ContactSums& o) {
    virial += o.virial, fabric += o.fabric, force += o.force, elastic += o.elastic;
    touching += o.touching, ends += o.ends;
    if (o.deepest.ratio > deepest.ratio) deepest = o.deepest;
  }
};

struct GrainSums {
  double resultant = 0, kinetic = 0, solid = 0;
  std::size_t fixed = 0;  // of rough walls

  void add(const GrainSums& o) { resultant += o.resultant, kinetic += o.kinetic, solid += o.solid, fixed += o.fixed; }
};

/// What the sums read of a pair's grains lies anywhere: it is asked for so many pairs ahead.
constexpr std::size_t ahead = 24;

void ask_for_grains(const State& s, std::size_t k) {
  const Pair& p = s.contacts.pair[k];
  const char* const motion = reinterpret_cast<const char*>(&s.grains.motion[p.b]);
  __builtin_prefetch(motion), __builtin_prefetch(motion + 64);
  __builtin_prefetch(&s.grains.extent[p.b]);
}

/// `carried`: by contact, force along the branch (N m), and the deepest overlap is looked for; empty: neither.
template <class Law>
ContactSums sum_contacts(const Law& law, const State& s, std::size_t begin, std::size_t end,
                         std::span<double> carried) {
  ContactSums sum;
  Mat3 virial = Mat3::Zero(), fabric = Mat3::Zero();
  double force = 0, elastic = 0;
  const Contacts& contacts = s.contacts;
  const std::size_t walls = contacts.begin[first_wall];
  for (std::size_t k = begin; k < end; ++k) {
    if (k + ahead < walls) ask_for_grains(s, k + ahead);
    if (!contacts.contact.touching(k)) continue;
    const Touch& touch = contacts.touch[k];
    const bool walled = k >= walls;
    const Vec3 l = walled ? branch(s, k) : between(s, contacts.pair[k]);
    virial -= touch.force * l.transpose();
    fabric += touch.normal * touch.normal.transpose();
    force += touch.force.norm();
    elastic += elastic_energy(law, contacts.contact[k], touch);
    ++sum.touching, sum.ends += walled ? 1u : 2u;
    if (carried.empty()) continue;
    carried[k] = touch.force.dot(l);
    const double r = smaller_radius(s.grains, contacts.pair[k], walled);
    if (touch.overlap > sum.deepest.ratio * r) sum.deepest = {touch.overlap / r, k};
  }
  sum.virial = virial, sum.fabric = fabric, sum.force = force, sum.elastic = elastic;
  return sum;
}

GrainSums sum_grains(const Grains& g, std::size_t begin, std::size_t end) {
  GrainSums sum;
  for (std::size_t i = begin; i < end; ++i) {
    if (g.motion[i].inverse_mass == 0)
      ++sum.fixed;
    else
      sum.resultant += g.force[i].norm();
    sum.kinetic += kinetic_energy(g, i);
    sum.solid += g.extent[i].volume;
  }
  return sum;
}

/// f(begin, end) of all chunks, by whoever of the team has time, added in order.
template <class Sums, class F>
Sums in_chunks(std::size_t n, Team* team, F&& f) {
  if (n <= chunk) return f(std::size_t{0}, n);
  std::vector<Sums> part((n + chunk - 1) / chunk);
  const auto one = [&](std::size_t c) { part[c] = f(c * chunk, std::min(n, (c + 1) * chunk)); };
  if (team)
    team->each(part.size(), one);
  else
    for (std::size_t c = 0; c < part.size(); ++c) one(c);
  for (std::size_t c = 1; c < part.size(); ++c) part[0].add(part[c]);
  return part[0];
}

Mat3 wall_stress(const State& s, double volume) {
  Mat3 stress = Mat3::Zero();
  const CylinderWall* round = cylinder(s.boundary);
  const double radial = round ? radial_stress(s, volume) : 0;
  if (s.boundary.cell.walled) stress = love_weber(s, volume).diagonal().asDiagonal();  // of what has no walls
  for (int k = s.boundary.cell.walled ? 2 : 0; k < 3; ++k) {
    if (round && round->axis[k] == 0) {
      stress(k, k) = -radial;
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
    if (any_rough(s.boundary)) force += (rough_force(s, of.minus) - rough_force(s, of.plus))[k];
    if (!s.bonds.wall.empty()) force += (support_force(s.bonds, of.minus) - support_force(s.bonds, of.plus))[k];
    stress(k, k) = -0.5 * force * width(s.boundary, of, k) / volume;
  }
  return stress;
}

/// Standard error of the mean pressure over its value, from what each contact carries.
double scatter_of(const State& s, SurveyRoom& room) {
  if (s.grains.size() < 2) return 0;
  room.share.assign(s.grains.size(), 0.0);
  std::vector<double>& share = room.share;
  double sum = 0, squares = 0;
  const std::size_t walls = s.contacts.begin[first_wall];
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const Pair& p = s.contacts.pair[k];
    const double carried = room.carried[k];
    sum += carried;
    if (k >= walls)
      share[p.a] += carried;
    else
      share[p.a] += 0.5 * carried, share[p.b] += 0.5 * carried;
  }
  if (sum == 0) return 0;
  const double n = static_cast<double>(share.size()), mean = sum / n;
  for (const double v : share) squares += (v - mean) * (v - mean);
  return std::sqrt(n / (n - 1) * squares) / std::abs(sum);
}

Measurement measured(const Model& model, const State& s, Team* team, std::span<double> carried,
                     DeepestContact* deepest) {
  Measurement m;
  m.volume = bulk_volume(s.boundary);
  const ContactSums contacts = std::visit(
      [&](const auto& law) {
        return in_chunks<ContactSums>(s.contacts.size(), team, [&](std::size_t begin, std::size_t end) {
          return sum_contacts(law, s, begin, end, carried);
        });
      },
      model.law);
  const GrainSums grains = in_chunks<GrainSums>(
      s.grains.size(), team, [&](std::size_t begin, std::size_t end) { return sum_grains(s.grains, begin, end); });
  m.stress = stress_of(contacts.virial, s, m.volume);
  if (m.volume > 0 && !s.boundary.cell.everywhere()) m.wall_stress = wall_stress(s, m.volume);
  const double n = static_cast<double>(std::max<std::size_t>(s.grains.size(), 1));
  m.contacts = contacts.touching;
  if (m.contacts > 0) m.fabric = contacts.fabric / static_cast<double>(m.contacts);
  double force = contacts.force;
  for (const FaceBond& bond : s.bonds.face.row) force += bond.force.norm();  // as contacts do
  for (const FaceBond& bond : s.bonds.wall) force += bond.force.norm();
  if (force > 0) {
    const auto links = static_cast<double>(m.contacts + s.bonds.face.row.size() + s.bonds.wall.size());
    m.unbalanced_force = grains.resultant / (n - static_cast<double>(grains.fixed)) / (force / links);
  }
  m.coordination = static_cast<double>(contacts.ends) / n;
  if (m.volume > 0) m.solid_fraction = grains.solid / m.volume, m.void_ratio = m.volume / grains.solid - 1;
  m.kinetic = grains.kinetic;
  m.elastic = contacts.elastic + stored_energy(s.bonds);
  if (deepest) *deepest = contacts.deepest;
  return m;
}

}  // namespace

Vec3 normal_stresses(const State& s) {
  const double volume = bulk_volume(s.boundary);
  if (volume <= 0) return Vec3::Zero();
  return (s.boundary.cell.everywhere() ? love_weber(s, volume) : wall_stress(s, volume)).diagonal();
}

Measurement measure(const Model& model, const State& s) { return measured(model, s, nullptr, {}, nullptr); }

Survey survey(const Model& model, const State& s, Team& team, SurveyRoom& room) {
  renew(room.carried, s.contacts.size());
  Survey all;
  static_cast<Measurement&>(all) = measured(model, s, &team, room.carried, &all.deepest);
  all.pressure_scatter = scatter_of(s, room);
  return all;
}

Mat6 contact_stiffness_tangent(const Model& model, const State& s) {
  Mat6 tangent = Mat6::Zero();
  const double volume = bulk_volume(s.boundary);
  if (volume <= 0) return tangent;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Contact c = s.contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const PairLaw& p = model.pairs[s.contacts.pair[k].law];
    const Elastic elastic = elastic_response(model.law, s.contacts, k);
    const double borne = elastic.bears(elastic.force + c.viscous);
    const bool slides = c.spring[slide_spring].norm() >= p.friction[slide_spring] * borne * (1 - 1e-9);
    const double kt = p.friction[slide_spring] > 0 && !slides ? p.shear_ratio * elastic.grip : 0;
    const Vec3 l = branch(s, k), &n = s.contacts.touch[k].normal;
    const auto b = displacement_of_strain(l);
    const Mat3 stiffness = (elastic.normal_stiffness - kt) * n * n.transpose() + kt * Mat3::Identity();
    tangent += b.transpose() * stiffness * b;
  }
  for_each_bond(s.bonds, [&](const auto& bond) {
    const auto b = displacement_of_strain(branch(s.grains, s.boundary.cell, bond.ends));
    tangent += b.transpose() * stiffness(bond, frame_of(s.grains, s.boundary.cell, bond.ends), {&s.grains}).shift * b;
  });
  for (const FaceBond& bond : s.bonds.wall) {
    const Quat& q = s.grains.orientation[bond.ends.a];
    const auto b = displacement_of_strain(q * bond.at_a);
    tangent += b.transpose() * stiffest(bond, q).shift * b;  // it never gives way
  }
  return tangent / volume;
}

Vec3 contact_viscosity(const Model& model, const State& s) {
  Vec3 viscosity = Vec3::Zero();
  const double volume = bulk_volume(s.boundary);
  if (volume <= 0) return viscosity;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Pair& p = s.contacts.pair[k];
    const double dashpot = model.pairs[p.law].dashpot;
    if (!(dashpot > 0) || s.contacts.contact.stiffness[k] <= 0) continue;
    double yields = s.grains.motion[p.a].inverse_mass;
    if (k < s.contacts.begin[first_wall]) yields += s.grains.motion[p.b].inverse_mass;
    const double c = dashpot * std::sqrt(elastic_response(model.law, s.contacts, k).grip / yields);
    viscosity += c * s.contacts.touch[k].normal.cwiseProduct(branch(s, k)).cwiseAbs2();
  }
  return viscosity / volume;
}

}  // namespace grus::dem
