// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/breakage.hpp"

#include <numeric>

#include "dem/bond/cohesive.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/break_plane.hpp"
#include "dem/fracture/grain_stress.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"

namespace grus::dem {
namespace {

/// Normal (geometry frame) of the plane of three critical contacts, if the grain has enough that are not in line.
std::optional<Vec3> critical_plane(const Model& model, const State& state, std::size_t i, const ContactTension& criterion,
                                   double nu) {
  const Contacts& contacts = state.contacts;
  std::vector<std::pair<double, Vec3>> critical;
  const double strength = criterion.strength * state.grains.strength[i];
  for (Index e = contacts.first[i]; e < contacts.first[i + 1]; ++e) {
    const std::size_t k = contacts.entry[e] >> 1;
    const Contact& c = contacts.contact[k];
    if (c.stiffness <= 0) continue;
    const double force = std::visit([&](const auto& law) { return law(c.stiffness, c.overlap).force; }, model.law);
    const double tension = ContactTension::tension(force, std::sqrt(c.radius * c.overlap), nu);
    if (tension >= strength) critical.emplace_back(tension, contact_arm(state.grains, contacts, k, contacts.entry[e] & 1));
  }
  if (critical.size() < static_cast<std::size_t>(std::max(criterion.critical_contacts, 3))) return std::nullopt;
  std::stable_sort(critical.begin(), critical.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  const Vec3 &p = critical[0].second, &q = critical[1].second;
  for (std::size_t k = 2; k < critical.size(); ++k) {
    const Vec3 u = q - p, v = critical[k].second - p, n = u.cross(v);
    if (n.norm() > 1e-3 * u.norm() * v.norm()) return state.grains.orientation[i].conjugate() * n.normalized();
  }
  return std::nullopt;
}

std::optional<int> breaking_axis(const Model& model, const State& state, std::size_t i) {
  const Grains& g = state.grains;
  const auto& fracture = model.materials[g.material[i]].fracture;
  if (!fracture || g.generation[i] >= fracture->max_generations) return std::nullopt;
  if (equivalent_radius(g.shape[i]) < fracture->smallest_radius) return std::nullopt;
  if (!choose_axis(g.shape[i], Vec3::Zero())) return std::nullopt;
  if (fracture->hoek_brown) {
    const Mat3 stress = grain_stress(g, state.contacts, i);
    if (fracture->hoek_brown->utilisation(stress, g.strength[i]) >= 1) {
      const Mat3 axes = g.orientation[i].toRotationMatrix();
      return choose_axis(g.shape[i], (axes.transpose() * stress * axes).diagonal());
    }
  }
  if (fracture->contact_tension) {
    const auto plane = critical_plane(model, state, i, *fracture->contact_tension, model.materials[g.material[i]].poissons_ratio);
    if (plane) return choose_axis(g.shape[i], plane->cwiseAbs());
  }
  return std::nullopt;
}

/// The parent's rigid motion: what the children should go on with.
struct ParentMotion {
  Vec3 position, acceleration, spin, spin_rate, origin;
  Mat3 axes;
  PolyEllipsoid shape;
};

ParentMotion motion_of(const Grains& g, std::size_t i) {
  const Frame frame = frame_of(g, i);
  const Vec3 spin = spin_of(g, i);
  return {g.motion[i].position,
          g.motion[i].inverse_mass * g.force[i],
          spin,
          inertia_tensor(g, i).inverse() * (g.torque[i] - spin.cross(g.angular_momentum[i])),
          frame.origin,
          frame.axes,
          g.shape[i]};
}

/// Force on a child, and moment about the plane's centre, that its springs must supply.
std::pair<Vec3, Vec3> demand(const Grains& g, std::size_t child, const ParentMotion& parent) {
  const Vec3 d = g.motion[child].position - parent.position;
  const Vec3 a = parent.acceleration + parent.spin_rate.cross(d) + parent.spin.cross(parent.spin.cross(d));
  const Vec3 force = g.mass[child] * a - g.force[child];
  const Vec3 torque = inertia_tensor(g, child) * parent.spin_rate + parent.spin.cross(g.angular_momentum[child]) - g.torque[child];
  return {force, torque + (g.motion[child].position - parent.origin).cross(force)};
}

void add_springs(const Model& model, State& state, const ParentMotion& parent, int axis, std::size_t plus, std::size_t minus) {
  const Grains& g = state.grains;
  const Material& material = model.materials[g.material[plus]];
  const CohesiveSprings& options = *material.fracture->springs;
  const double E = material.youngs_modulus, nu = material.poissons_ratio;
  const int n = options.per_plane, y = (axis + 1) % 3, z = (axis + 2) % 3;
  const double area = pi / 4 * (parent.shape.plus[y] + parent.shape.minus[y]) * (parent.shape.plus[z] + parent.shape.minus[z]);
  const double energy = options.toughness * options.toughness * (1 - nu * nu) / E * area / n;  // G_c A of one spring
  const double radius = equivalent_radius(parent.shape);

  // Springs act from the - half (a) on the + half (b); unknown forces on b at points of the plane, least norm.
  const auto [fp, mp] = demand(g, plus, parent);
  const auto [fm, mm] = demand(g, minus, parent);
  Vec6 target;
  target << 0.5 * (fp - fm), 0.5 * (mp - mm) / radius;
  state.ledger.residual_force += 0.5 * (fp + fm).norm();
  std::vector<Vec3> at(static_cast<std::size_t>(n));
  Eigen::MatrixXd balance(6, 3 * n);
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * pi * (k + 0.5) / n, c = std::cos(angle), s = std::sin(angle);
    Vec3 p = Vec3::Zero();  // geometry frame of the parent, from its octant origin
    p[y] = 0.6 * c * (c >= 0 ? parent.shape.plus[y] : parent.shape.minus[y]);
    p[z] = 0.6 * s * (s >= 0 ? parent.shape.plus[z] : parent.shape.minus[z]);
    at[k] = parent.axes * p;
    balance.block<3, 3>(0, 3 * k).setIdentity();
    balance.block<3, 3>(3, 3 * k) = cross_matrix(at[k]) / radius;
  }
  const Eigen::VectorXd forces = balance.completeOrthogonalDecomposition().solve(target);

  Vec3 normal = Vec3::Zero();  // from - to +
  normal[axis] = 1;
  for (int k = 0; k < n; ++k) {
    Vec3 force = parent.axes.transpose() * forces.segment<3>(3 * k);  // on the + half, geometry frame
    const double push = force.dot(normal);
    if (push > 0) {  // the halves press on each other: the contact's work, not the spring's
      force -= push * normal;
      state.ledger.residual_force += push;
    }
    const double stiffest = options.stiffness_ratio * model.pairs[g.material[plus] * (model.materials.size() + 1)].youngs * radius;
    const double softest_peak = 2 * energy / (options.max_opening * radius);
    CohesiveSpring s;
    s.a = static_cast<Index>(minus), s.b = static_cast<Index>(plus);
    // A spring of peak f and energy G has stiffness >= f^2 / G: the peak is capped where that meets the stiffest.
    s.peak = std::max(softest_peak, std::min(force.norm(), stiffest > 0 ? std::sqrt(stiffest * energy) : force.norm()));
    s.rupture = 2 * energy / s.peak;
    s.onset = stiffest > 0 ? std::clamp(s.peak / stiffest, 0.05 * s.rupture, 0.5 * s.rupture) : 0.05 * s.rupture;
    s.reached = s.onset;
    if (force.norm() > s.peak) {
      state.ledger.residual_force += force.norm() - s.peak;
      force *= s.peak / force.norm();
    }
    s.preload = -force * (s.onset / s.peak);  // force on b = -stiffness * opening
    s.normal_a = normal;
    const Vec3 point = parent.origin + at[k];
    s.at_a = g.orientation[minus].conjugate() * (point - g.motion[minus].position);
    s.at_b = g.orientation[plus].conjugate() * (point - g.motion[plus].position);
    state.bonds.push_back(s);
  }
  state.ledger.fracture_area += area;
}

void refresh_forces(const Model& model, State& state, Team& team) {
  contact_forces(model.law, model.pairs, state.grains, state.boundary, 0, state.contacts, team);
  flush(state.contacts);  // what the lost contacts held is booked by the caller's balance
  if (!state.bonds.empty()) bond_forces(state.grains, state.bonds, state.ledger);
  std::vector<BlockEnergy> none;
  MotionSettings settings = model.motion;
  settings.local_damping = 0;
  close_step(state.grains, state.contacts, settings, !state.bonds.empty(), 0, none, team);
}

}  // namespace

void draw_strength(const Model& model, Grains& g, std::size_t i) {
  const auto& fracture = model.materials[g.material[i]].fracture;
  g.strength[i] = fracture ? fracture->strength_factor(equivalent_radius(g.shape[i]), model.seed, g.id[i]) : 1;
}

std::vector<Break> find_breaks(const Model& model, const State& state, Team& team) {
  std::vector<std::uint8_t> bonded(state.grains.size(), 0);
  for (const auto& s : state.bonds) bonded[s.a] = bonded[s.b] = 1;
  std::vector<std::int8_t> axis(state.grains.size(), -1);
  team.blocks(state.grains.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!bonded[i]) axis[i] = static_cast<std::int8_t>(breaking_axis(model, state, i).value_or(-1));
  });
  std::vector<Break> breaks;
  for (std::size_t i = 0; i < axis.size(); ++i)
    if (axis[i] >= 0) breaks.push_back({i, axis[i]});
  return breaks;
}

void apply_breaks(const Model& model, State& state, const std::vector<Break>& breaks, Team& team) {
  Grains& g = state.grains;
  Ledger& ledger = state.ledger;
  const double elastic_before = elastic_energy(model.law, state.contacts);
  const double bonds_before = stored_energy(state.bonds), fracture_before = ledger.fracture;
  std::vector<Index> origin(g.size() + breaks.size());
  std::iota(origin.begin(), origin.begin() + static_cast<std::ptrdiff_t>(g.size()), 0u);
  std::vector<ParentMotion> parents;
  std::vector<std::size_t> minus;
  for (const auto& b : breaks) {
    parents.push_back(motion_of(g, b.grain));
    minus.push_back(g.size());
    origin[g.size()] = static_cast<Index>(b.grain);
    split_grain(g, b.grain, b.axis, model.materials[g.material[b.grain]].fracture->rounding, ledger.fines);
    draw_strength(model, g, b.grain);
    draw_strength(model, g, minus.back());
  }
  update_frames(g);
  build_contacts(g, state.boundary, state.skin, model.materials.size(), origin, state.contacts, state.reference);
  refresh_forces(model, state, team);
  for (std::size_t k = 0; k < breaks.size(); ++k)
    if (model.materials[g.material[breaks[k].grain]].fracture->springs)
      add_springs(model, state, parents[k], breaks[k].axis, breaks[k].grain, minus[k]);
  if (!state.bonds.empty()) refresh_forces(model, state, team);
  ledger.breakages += breaks.size();
  ledger.split += elastic_before + bonds_before - elastic_energy(model.law, state.contacts) - stored_energy(state.bonds) -
                  (ledger.fracture - fracture_before);
}

}  // namespace grus::dem
