// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/forces.hpp"

#include <algorithm>

#include "dem/shape/common_normal.hpp"

namespace grus::dem {
namespace {

struct Scene {
  const Grains& grains;
  const Boundary& boundary;
  std::span<const PairLaw> pairs;
  double dt;
  bool periodic;

  Vec3 shift(const Pair& p) const { return boundary.cell.vectors * Vec3(p.image[0], p.image[1], p.image[2]); }
};

inline void apart(Contacts& contacts, std::size_t k, BlockEnergy& e) {
  if (!contacts.contact.touching(k)) return;
  Contact c = contacts.contact[k];
  part_contact(c, contacts.touch[k], e);
  contacts.contact.set(k, c);
}

template <class Law>
void begin_contact(const Law& law, const PairLaw& p, double radius, double volume_radius, double ellipse, Contact& c) {
  c.radius = std::clamp(radius, 0.1 * volume_radius, 4 * volume_radius);
  c.stiffness = law.stiffness_at_birth(p, c.radius);
  if constexpr (std::is_same_v<Law, HertzMindlin>) c.stiffness *= ellipse;
}

/// What ContactRows::solve needs.
struct Solver {
  const ContactLaw& law;
  const Scene& scene;
  Contacts& contacts;
  BlockEnergy& energy;
};

/// One pair of shapes, whatever has become of it; see ContactRows::solve.
bool solve_pair(const void* context, std::size_t k, double* found_row) {
  const Solver& solver = *static_cast<const Solver*>(context);
  const Scene& s = solver.scene;
  Contacts& contacts = solver.contacts;
  BlockEnergy& e = solver.energy;
  const Pair& pair = contacts.pair[k];
  const bool fresh_contact = !contacts.contact.touching(k);
  Touch& touch = contacts.touch[k];
  const Frame &fa = s.grains.frame[pair.a], &fb = s.grains.frame[pair.b];
  Vec3 r = fb.origin - fa.origin;
  if (s.periodic && crosses(pair)) r += s.shift(pair);
  const ShapePair shapes{s.grains.shape[pair.a], s.grains.shape[pair.b], fa.axes.transpose() * fb.axes,
                         fa.axes.transpose() * r};
  CommonNormal found = warm_common_normal(shapes, fa.axes.transpose() * touch.normal);
  if (fresh_contact &&
      found.overlap > 0) {  // a new contact is checked from scratch: a trap of the warm start shows here
    const CommonNormal fresh = cold_common_normal(shapes);
    if (fresh.overlap < found.overlap) found = fresh;
  }
  const Vec3 n = fa.axes * found.normal;
  touch.normal = n;
  contacts.active[k] = found.overlap > 0;
  if (!(found.overlap > 0)) {
    apart(contacts, k, e);
    return false;
  }
  if (fresh_contact) {
    const ContactCurvature curvature = contact_curvature(shapes, found.normal);
    const double ra = equivalent_radius(shapes.a), rb = equivalent_radius(shapes.b);
    Contact c = contacts.contact[k];
    const auto born = [&](const auto& law) {
      begin_contact(law, s.pairs[pair.law], curvature.radius, ra * rb / (ra + rb), curvature.ellipse_factor, c);
    };
    std::visit(born, solver.law);
    contacts.contact.set(k, c);
  }
  const Vec3 point = fa.origin + fa.axes * (0.5 * (found.point_a + found.point_b));
  for (int j = 0; j < 3; ++j) found_row[j] = n[j], found_row[4 + j] = point[j];
  found_row[3] = found.overlap;
  return true;
}

template <class Law>
void polyellipsoid_walls(const Law& law, const Scene& s, Contacts& contacts, Load* load, std::size_t first,
                         std::size_t begin, std::size_t end, BlockEnergy& e) {
  for (std::size_t k = begin; k < end; ++k) {
    const Pair& pair = contacts.pair[k];
    Touch& touch = contacts.touch[k];
    const Motion& a = s.grains.motion[pair.a];
    const Frame& frame = s.grains.frame[pair.a];
    const Wall& wall = s.boundary.walls[pair.b];
    const Vec3 n = -wall.normal, d = frame.axes.transpose() * n;
    const Vec3 tip = frame.origin + frame.axes * support(s.grains.shape[pair.a], d);
    const double overlap = wall.normal.dot(wall.point - tip);
    if (!(overlap > 0)) {
      apart(contacts, k, e);
      continue;
    }
    const Vec3 arm = tip - 0.5 * overlap * n - a.position;
    const PairLaw& p = s.pairs[pair.law];
    Contact c = contacts.contact[k];
    if (c.stiffness == 0) {
      const ContactCurvature curvature = plane_curvature(s.grains.shape[pair.a], d);
      begin_contact(law, p, curvature.radius, equivalent_radius(s.grains.shape[pair.a]), curvature.ellipse_factor, c);
    }
    const Vec3 v = wall.velocity - a.velocity - a.spin.cross(arm);
    const Vec3 force =
        advance_contact(law, p, 1 / a.inverse_mass, c, touch, n, overlap, v, 0.5 * n.dot(a.spin), s.dt, e);
    contacts.contact.set(k, c);
    Load& mine = load[pair.a - first];
    mine.force -= force, mine.torque += force.cross(arm);
    e.work -= s.dt * force.dot(wall.velocity);
  }
}

/// The columns as the kernel wants them; laws, images and walls as rows.
ContactRows rows_of(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                    const Boundary& boundary, double dt, bool shown, Contacts& c) {
  static_assert(sizeof(Motion) == 96 && sizeof(Touch) == 64 && sizeof(Load) == 64);
  ContactRows pass{};
  c.law_rows.assign(pairs.size() * law_columns, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairLaw& p = pairs[k];
    double* row = &c.law_rows[k * law_columns];
    row[law_youngs] = p.youngs, row[law_dashpot] = p.dashpot, row[law_stiffness] = p.normal_stiffness;
    row[law_shear_ratio] = p.friction > 0 ? p.shear_ratio : 1, row[law_friction] = p.friction;
    pass.friction = pass.friction || p.friction > 0, pass.dashpot = pass.dashpot || p.dashpot > 0;
  }
  const bool periodic = boundary.cell.periodic();
  auto put = [](double* to, const Vec3& v) { to[0] = v.x(), to[1] = v.y(), to[2] = v.z(); };
  if (periodic) {
    c.shift_rows.assign(8 * c.images.size(), 0);
    for (std::size_t k = 0; k < c.images.size(); ++k) {
      const Vec3 image(c.images[k][0], c.images[k][1], c.images[k][2]);
      put(&c.shift_rows[8 * k], boundary.cell.vectors * image),
          put(&c.shift_rows[8 * k + 4], boundary.cell.rate * image);
    }
  }
  c.wall_rows.assign(8 * boundary.walls.size(), 0);
  for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
    const Wall& wall = boundary.walls[w];
    put(&c.wall_rows[8 * w], wall.normal), put(&c.wall_rows[8 * w + 4], wall.velocity);
    c.wall_rows[8 * w + 3] = wall.normal.dot(wall.point);
  }
  pass.motion = reinterpret_cast<const double*>(grains.motion.data());
  pass.a = c.a.data(), pass.b = c.b.data(), pass.law = c.law.data(), pass.target = c.target.data();
  pass.shift = periodic ? c.shift.data() : nullptr, pass.shifts = c.shift_rows.data();
  pass.walls = c.wall_rows.data(), pass.laws = c.law_rows.data(), pass.law_count = pairs.size();
  pass.dt = dt;
  ContactColumns& h = c.contact;
  pass.spring_x = h.spring_x.data(), pass.spring_y = h.spring_y.data(), pass.spring_z = h.spring_z.data(),
  pass.compliance = h.compliance.data();
  pass.viscous = h.viscous.data(), pass.stiffness = h.stiffness.data(), pass.radius = h.radius.data();
  pass.touch = shown ? reinterpret_cast<double*>(c.touch.data()) : nullptr;
  pass.active = c.active.data();
  pass.frame = reinterpret_cast<const double*>(grains.frame.data()),
  pass.shape = reinterpret_cast<const double*>(grains.shape.data());
  static_assert(sizeof(Frame) == 96 && sizeof(PolyEllipsoid) == 48);
  pass.elsewhere = reinterpret_cast<double*>(c.load.data()), pass.grains = static_cast<std::uint32_t>(grains.size());
  pass.hertz = std::holds_alternative<HertzMindlin>(law);
  return pass;
}

}  // namespace

ContactPass::ContactPass(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                         const Boundary& boundary, double dt, bool shown, Contacts& contacts)
    : law_(law),
      pairs_(pairs),
      grains_(grains),
      boundary_(boundary),
      contacts_(contacts),
      rows_(rows_of(law, pairs, grains, boundary, dt, shown, contacts)),
      spheres_(sphere_pairs()),
      walls_(sphere_walls()),
      polyellipsoids_(polyellipsoid_pairs()) {}

void ContactPass::tile(std::size_t t, Load* room) const {
  const std::size_t first = t * tile_size(grains_.size());
  Load* const load = room ? room : contacts_.load.data() + first;
  ContactRows pass = rows_;
  pass.load = reinterpret_cast<double*>(load), pass.first = static_cast<std::uint32_t>(first);
  BlockEnergy& e = contacts_.energy[t];
  auto range = [&](Bin bin) {
    return std::pair<std::size_t, std::size_t>(contacts_.tile[bin][t], contacts_.tile[bin][t + 1]);
  };
  auto rows = [&](Bin bin, PairLoop loop) {
    const auto [begin, end] = range(bin);
    if (begin == end) return;
    const PassEnergy spent = loop(pass, begin, end);
    e.friction += spent.friction, e.springs += spent.springs, e.viscous += spent.viscous,
        e.work -= rows_.dt * spent.power;
  };
  rows(sphere_sphere, spheres_);
  rows(sphere_wall, walls_);
  const std::pair<std::size_t, std::size_t> at_walls = range(polyellipsoid_wall);
  if (grains_.frame.empty()) return;
  const Scene scene{grains_, boundary_, pairs_, rows_.dt, boundary_.cell.periodic()};
  const Solver solver{law_, scene, contacts_, e};
  pass.touch = reinterpret_cast<double*>(contacts_.touch.data());
  pass.solve = solve_pair, pass.context = &solver;
  rows(general, polyellipsoids_);
  std::visit(
      [&](const auto& law) {
        polyellipsoid_walls(law, scene, contacts_, load, first, at_walls.first, at_walls.second, e);
      },
      law_);
}

void contact_forces(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                    const Boundary& boundary, double dt, bool shown, Contacts& contacts, Team& team) {
  const ContactPass pass(law, pairs, grains, boundary, dt, shown, contacts);
  team.pieces(tile_count(grains.size()), [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) pass.tile(t);
  });
}

double boundary_power(const Boundary& boundary, const Contacts& contacts) {
  double power = 0;
  for (std::size_t k = contacts.begin[sphere_wall]; k < contacts.size(); ++k)
    power -= contacts.touch[k].force.dot(boundary.walls[contacts.pair[k].b].velocity);
  if (!boundary.cell.periodic() || boundary.cell.rate.isZero(0)) return power;
  for (std::size_t k = 0; k < contacts.begin[sphere_wall]; ++k) {
    const Pair& p = contacts.pair[k];
    if (crosses(p) && contacts.contact.touching(k))
      power -= contacts.touch[k].force.dot(boundary.cell.rate * Vec3(p.image[0], p.image[1], p.image[2]));
  }
  return power;
}

void drop_loads(Contacts& contacts) { std::fill(contacts.load.begin(), contacts.load.end(), Load{}); }

BlockEnergy flush(Contacts& contacts) {
  BlockEnergy sum;
  for (auto& e : contacts.energy) {
    sum.friction += e.friction, sum.springs += e.springs, sum.viscous += e.viscous, sum.work += e.work;
    e = {};
  }
  return sum;
}

void book(const BlockEnergy& contacts, Ledger& l) {
  l.friction += contacts.friction, l.unexplained += contacts.springs - contacts.friction;
  l.damping += contacts.viscous, l.work += contacts.work;
  l.most_friction = std::max(l.most_friction, l.friction), l.most_damping = std::max(l.most_damping, l.damping);
}

double elastic_energy(const ContactLaw& law, const Contacts& contacts) {
  double sum = 0;
  std::visit(
      [&](const auto& l) {
        for (std::size_t k = 0; k < contacts.size(); ++k)
          sum += elastic_energy(l, contacts.contact[k], contacts.touch[k].overlap);
      },
      law);
  return sum;
}

DeepestContact deepest_contact(const Grains& grains, const Contacts& contacts) {
  DeepestContact deepest;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!contacts.contact.touching(k)) continue;
    const Pair& p = contacts.pair[k];
    double r = equivalent_radius(grains.shape[p.a]);
    if (k < contacts.begin[sphere_wall]) r = std::min(r, equivalent_radius(grains.shape[p.b]));
    if (contacts.touch[k].overlap > deepest.ratio * r) deepest = {contacts.touch[k].overlap / r, k};
  }
  return deepest;
}

}  // namespace grus::dem
