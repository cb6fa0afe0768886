// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/contact/forces.hpp"

#include <algorithm>
#include <functional>

#include "dem/contact/deepest_contact.hpp"
#include "dem/contact/pair_kinds.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

/// What the kernels ask of the law, seldom: a pair begins to touch; what springs do not hold of one that parts.
template <class Law>
void begin_touch(const void* context, std::size_t k, double effective_radius) {
  const TileWork& s = *static_cast<const TileWork*>(context);
  Contact c = s.contacts.contact[k];
  begin_contact<Law>(s.pairs[s.contacts.plan.law[k]], effective_radius, 1, c, s.energy);
  s.contacts.contact.set(k, c);
}
template <class Law>
void part_touch(const void* context, std::size_t k) {
  const TileWork& s = *static_cast<const TileWork*>(context);
  part_from<Law>(s.contacts.contact[k], s.energy);
}

void put_vector(double* to, const Vec3& v) { to[0] = v.x(), to[1] = v.y(), to[2] = v.z(); }

/// How fast the images of a cell go, in their rows.
void put_image_speeds(const Cell& cell, Plan& plan) {
  plan.shift_rows.resize(8 * plan.images.size());
  for (std::size_t k = 0; k < plan.images.size(); ++k)
    put_vector(&plan.shift_rows[8 * k + 4], at_image(cell.rate, plan.images[k]));
}

/// The columns as the kernel wants them; laws, images and walls as rows.
ContactRows rows_of(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                    const Boundary& boundary, double dt, bool shown, Contacts& c) {
  static_assert(sizeof(Motion) == 96 && sizeof(Touch) == 64 && sizeof(Load) == 64);
  ContactRows pass{};
  c.plan.law_rows.assign(pairs.size() * law_columns, 0);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairLaw& p = pairs[k];
    double* row = &c.plan.law_rows[k * law_columns];
    row[law_dashpot] = p.dashpot;
    const bool slides = p.friction[slide_spring] > 0;  // with a limit
    row[law_shear_ratio] = slides ? p.shear_ratio : 1;
    std::copy(p.friction.begin(), p.friction.end(), row + law_friction);
    pass.friction = pass.friction || slides, pass.dashpot = pass.dashpot || p.dashpot > 0;
  }
  const bool periodic = boundary.cell.periodic();
  if (periodic) {
    put_image_speeds(boundary.cell, c.plan);
    for (std::size_t k = 0; k < c.plan.images.size(); ++k)
      put_vector(&c.plan.shift_rows[8 * k], at_image(boundary.cell.vectors, c.plan.images[k]));
  }
  // Groups look beyond the pairs of a bin, at those of triangles, which have other rows.
  const std::size_t walls = std::max(boundary.walls.size(), c.begin[sphere_mesh + 1] - c.begin[sphere_mesh]);
  c.plan.wall_rows.assign(8 * walls, 0);
  for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
    const Wall& wall = boundary.walls[w];
    put_vector(&c.plan.wall_rows[8 * w], wall.facing()), put_vector(&c.plan.wall_rows[8 * w + 4], wall.velocity);
    c.plan.wall_rows[8 * w + 3] = wall.facing().dot(wall.point);
  }
  c.plan.round_rows.clear();
  if (cylinder(boundary)) {
    c.plan.round_rows.assign(8 * walls, 0);
    for (std::size_t w = 0; w < boundary.walls.size(); ++w) {
      const Wall& wall = boundary.walls[w];
      const auto* round = std::get_if<CylinderWall>(&wall.shape);
      if (!round) continue;
      put_vector(&c.plan.round_rows[8 * w], wall.point), put_vector(&c.plan.round_rows[8 * w + 4], round->axis);
      c.plan.round_rows[8 * w + 3] = round->radius;
    }
  }
  pass.motion = reinterpret_cast<const double*>(grains.motion.data());
  pass.a = c.plan.a.data();
  pass.b = c.plan.b.data();
  pass.law = c.plan.law.data();
  pass.target = c.plan.target.data();
  pass.shift = periodic ? c.plan.shift.data() : nullptr, pass.shifts = c.plan.shift_rows.data();
  pass.walls = c.plan.wall_rows.data();
  pass.rounds = c.plan.round_rows.empty() ? nullptr : c.plan.round_rows.data();
  pass.laws = c.plan.law_rows.data();
  pass.law_count = pairs.size();
  pass.dt = dt;
  ContactColumns& h = c.contact;
  for (std::size_t row = 0; row < spring_rows; ++row)
    for (std::size_t j = 0; j < 3 && h.keeps[row]; ++j) pass.spring[row][j] = h.spring[row][j].data();
  pass.compliance = h.compliance.data();
  pass.viscous = h.viscous.data();
  pass.stiffness = h.stiffness.data();
  pass.radius = h.radius.data();
  pass.couples = pass.friction && std::any_of(h.keeps.begin() + first_couple, h.keeps.end(), std::identity());
  pass.touch = shown ? reinterpret_cast<double*>(c.touch.data()) : nullptr;
  pass.active = c.active.data();
  pass.frame = reinterpret_cast<const double*>(grains.frame.data()),
  pass.shape = reinterpret_cast<const double*>(grains.shape.data());
  static_assert(sizeof(Frame) == 96 && sizeof(PolyEllipsoid) == 48);
  pass.elsewhere = reinterpret_cast<double*>(c.plan.load.data()),
  pass.grains = static_cast<std::uint32_t>(grains.size());
  if (h.reaches) pass.reach = h.reach.data();
  std::visit([&]<class Law>(
                 const Law&) { pass.kernel = Law::kernel, pass.begin = begin_touch<Law>, pass.part = part_touch<Law>; },
             law);
  return pass;
}

}  // namespace

ContactPass::ContactPass(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                         const Boundary& boundary, double dt, bool shown, Contacts& contacts, SleepingHulls* sleep)
    : law_(law),
      pairs_(pairs),
      grains_(grains),
      boundary_(boundary),
      contacts_(contacts),
      sleep_(sleep),
      rows_(rows_of(law, pairs, grains, boundary, dt, shown, contacts)) {}

void ContactPass::tile(std::size_t t, Load* room) const {
  const std::size_t first = t * tile_size(grains_.size());
  Load* const load = room ? room : contacts_.plan.load.data() + first;
  ContactRows rows = rows_;
  rows.load = reinterpret_cast<double*>(load), rows.first = static_cast<std::uint32_t>(first);
  const TileWork work{law_, pairs_, grains_, boundary_, contacts_, rows, load, first, contacts_.plan.energy[t], sleep_};
  rows.context = &work;
  for (const Bin bin : pass_order) {
    const std::size_t begin = contacts_.tile[bin][t], end = contacts_.tile[bin][t + 1];
    if (begin != end) pair_kind(bin).pass(work, begin, end);
  }
}

void contact_forces(const ContactLaw& law, std::span<const PairLaw> pairs, const Grains& grains,
                    const Boundary& boundary, double dt, bool shown, Contacts& contacts, Team& team) {
  const ContactPass pass(law, pairs, grains, boundary, dt, shown, contacts);
  team.pieces(tile_count(grains.size()), [&](std::size_t first, std::size_t last, int) {
    for (std::size_t t = first; t < last; ++t) pass.tile(t);
  });
}

double boundary_power(const Boundary& boundary, Contacts& contacts) {
  double power = 0;
  for (std::size_t k = contacts.begin[first_wall]; k < contacts.size(); ++k)
    power -= contacts.touch[k].force.dot(boundary.walls[contacts.pair[k].b].velocity);
  if (!boundary.cell.periodic() || boundary.cell.rate.isZero(0)) return power;
  Plan& plan = contacts.plan;
  put_image_speeds(boundary.cell, plan);
  // Pairs within the cell add nothing. Of few pairs most cross, and asking takes longer; of many their forces are far.
  const bool few = contacts.begin[first_wall] < 4096;
  for (std::size_t k = 0; k < contacts.begin[first_wall]; ++k)
    if (contacts.contact.touching(k) && (few || plan.shift[k] != 0))
      power -= contacts.touch[k].force.dot(Eigen::Map<const Vec3>(&plan.shift_rows[8 * plan.shift[k] + 4]));
  return power;
}

void drop_loads(Contacts& contacts) { std::fill(contacts.plan.load.begin(), contacts.plan.load.end(), Load{}); }

BlockEnergy flush(Contacts& contacts) {
  BlockEnergy sum;
  for (auto& e : contacts.plan.energy) {
    sum.friction += e.friction;
    sum.springs += e.springs;
    sum.viscous += e.viscous;
    sum.work += e.work;
    sum.adhesion += e.adhesion;
    e = {};
  }
  return sum;
}

void book(const BlockEnergy& contacts, Ledger& l) {
  l.friction += contacts.friction, l.unexplained += contacts.springs - contacts.friction;
  l.damping += contacts.viscous, l.work += contacts.work;
  l.adhesion += contacts.adhesion;
  l.most_friction = std::max(l.most_friction, l.friction), l.most_damping = std::max(l.most_damping, l.damping);
}

double elastic_energy(const ContactLaw& law, const Contacts& contacts) {
  double sum = 0;
  std::visit(
      [&](const auto& l) {
        for (std::size_t k = 0; k < contacts.size(); ++k)
          sum += elastic_energy(l, contacts.contact[k], contacts.touch[k]);
      },
      law);
  return sum;
}

DeepestContact deepest_contact(const Grains& grains, const Contacts& contacts) {
  DeepestContact deepest;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (!contacts.contact.touching(k)) continue;
    const double r = smaller_radius(grains, contacts.pair[k], k >= contacts.begin[first_wall]);
    if (contacts.touch[k].overlap > deepest.ratio * r) deepest = {contacts.touch[k].overlap / r, k};
  }
  return deepest;
}

}  // namespace grus::dem
