// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/state_hash.hpp"

#include "dem/base/members.hpp"

namespace grus::dem {

std::uint64_t hash(const State& s) {
  // No padding, whose bytes are anything.
  static_assert(sizeof(Motion) == 96 && sizeof(Inertia) == 56 && sizeof(PolyEllipsoid) == 48 && sizeof(Frame) == 96 &&
                sizeof(Vec3) == 24);
  static_assert(sizeof(Quat) == 32 && sizeof(Pair) == 16 && sizeof(BondEnds) == 16);
  std::uint64_t h = 0xcbf29ce484222325ULL;
  auto add = [&](const void* data, std::size_t bytes) {
    for (std::size_t k = 0; k < bytes; ++k) h = (h ^ static_cast<const unsigned char*>(data)[k]) * 0x100000001b3ULL;
  };
  auto rows = [&](const auto& column, std::size_t count) { add(column.data(), count * sizeof(column[0])); };
  for_each_column(s.grains, [&](const auto& column) {
    if constexpr (!std::is_same_v<decltype(column), const std::vector<Extent>&>)  // follows from the shapes
      rows(column, column.size());
  });
  add(&s.grains.next_id, sizeof s.grains.next_id);
  const std::size_t pairs = s.contacts.size();  // columns go on beyond
  rows(s.contacts.pair, pairs);
  for_each_contact_column(s.contacts.contact, [&](const auto& column) { rows(column, pairs); });
  for (const CohesiveSpring& b : s.bonds.cohesive.row) {
    add(&b.ends, 2 * sizeof(Index));
    if (b.ends.image != std::array<std::int16_t, 3>{}) add(b.ends.image.data(), 6);
    for (const Vec3& v : {b.at_a, b.at_b, b.normal_a, b.preload}) add(v.data(), sizeof v);
    for (const double v : {b.peak, b.onset, b.rupture, b.reached}) add(&v, sizeof v);
    add(b.force.data(), sizeof b.force);
  }
  // What changes of face bonds: the rest follows from the grains.
  for (const FaceBond& b : s.bonds.face.row) {
    add(&b.ends, 2 * sizeof(Index));
    add(b.ends.image.data(), 6);
    for (const double v :
         {b.area, b.tension, b.reached, b.onset, b.slip_1, b.slip_2, b.slip_3, b.spent, b.rubbed, b.held, b.damage})
      add(&v, sizeof v);
    add(b.force.data(), sizeof b.force);
  }
  for (const FaceDashpot& d : s.bonds.dashpot)
    add(d.force.data(), sizeof d.force), add(d.couple.data(), sizeof d.couple);
  for (const FaceBond& b : s.bonds.wall) add(b.force.data(), sizeof b.force);
  for (const DeadLoad& load : s.bonds.load) add(load.felt.data(), sizeof load.felt);
  for (const Wall& wall : s.boundary.walls) {
    for (const Vec3& v : {wall.point, wall.facing(), wall.velocity}) add(v.data(), sizeof v);
    const auto shape = [&](const auto& kind) {
      for_each_member(kind, [&](const auto& member) { add(&member, sizeof member); });
    };
    if (const Triangles* mesh = wall.mesh()) {
      for (const Vec3& x : mesh->corner) add(x.data(), sizeof x);
      for (const auto& t : mesh->triangle) add(t.data(), sizeof t);
      continue;
    }
    if (!std::holds_alternative<PlaneWall>(wall.shape)) std::visit(shape, wall.shape);
  }
  const Cell& cell = s.boundary.cell;
  for (const Mat3* m : {&cell.vectors, &cell.rate}) add(m->data(), sizeof *m);
  if (!cell.whole.isIdentity(0)) add(cell.whole.data(), sizeof cell.whole);
  if (!s.servo.drift.isZero(0)) add(s.servo.drift.data(), sizeof s.servo.drift);
  add(&s.time, sizeof s.time);
  return h;
}

}  // namespace grus::dem
