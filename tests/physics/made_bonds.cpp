// SPDX-License-Identifier: LGPL-3.0-or-later
// Bonds as scenes make them, and what runs do with them: strengths and openings, glue near a wall, damage of dashpots
// and friction, order in space, reversed pairs and seams, torsion until it breaks.
#include "dem/bond/dashpots.hpp"
#include "dem/bond/face_parts.hpp"
#include "dem/contact/forces.hpp"
#include "dem/packing/prisms.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/resting.hpp"
#include "dem/sample/stages.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Boxes of a length along x and unit width in a row, from x = 0, all but the last one bonded to the next. `images`: of
/// the last one, at the seam of a cell, to the first.
Tessellation row_of(std::size_t count, double length, bool images = false) {
  Tessellation cells;
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 low(length * static_cast<double>(k), 0, 0);
    cells.body.push_back(box_between(low, low + Vec3(length, 1, 1)));
    cells.seed.emplace_back(low + 0.5 * Vec3(length, 1, 1));
    auto& partners = cells.partner.emplace_back();
    const auto meets = [&](std::size_t face, std::size_t other, std::int16_t image) {
      cells.body[k].face[face].tag = static_cast<std::int64_t>(partners.size());
      partners.push_back({static_cast<Index>(other), {image, 0, 0}});
    };
    if (k > 0 || images) meets(0, k > 0 ? k - 1 : count - 1, k > 0 ? 0 : -1);
    if (k + 1 < count || images) meets(1, k + 1 < count ? k + 1 : 0, k + 1 < count ? 0 : 1);
  }
  return cells;
}

State state_of_voronoi(const Model& model, const Tessellation& cells) {
  State s;
  add_voronoi_grains(model, cells, 0, s);
  return s;
}

Polyhedron unit_box() { return box_between(Vec3::Zero(), Vec3::Ones()); }

BondFrame frame(const State& s, const FaceBond& b) { return frame_of(s.grains, s.boundary.cell, b.ends); }

/// The only bond, b drawn away from a by `shift`.
Pull drawn(State& s, const Vec3& shift) {
  FaceBond& b = s.bonds.face.row.at(0);
  BondFrame at = frame(s, b);
  at.x_b += shift;
  return pull(b, at, {&s.grains});
}

}  // namespace

TEST_CASE("Weibull strengths have the given mean and Weibull's scatter; tension and cohesion are drawn together") {
  BondModel bond = cohesive(5e3, 1);
  bond.criterion = FaceCriterion::parallel, bond.weibull = 2;
  const State s = state_of_voronoi(rock(bond), hexagonal_prisms(Vec3(12, 12, 14), 0.5, 1, 0));
  const auto n = static_cast<double>(s.bonds.size());
  REQUIRE(n > 8000);
  double mean = 0, square = 0, below = 0;
  for (const FaceBond& b : s.bonds.face.row) {
    mean += b.tension / n, square += b.tension * b.tension / n, below += (b.tension < bond.tension) / n;
    REQUIRE(std::abs(b.cohesion / b.tension - 2) < 1e-12);
  }
  const double scatter = std::sqrt(4 / pi - 1);  // relative, of m = 2
  CHECK(mean / bond.tension == Approx(1).margin(4 * scatter / std::sqrt(n)));
  CHECK(std::sqrt(square - mean * mean) / mean == Approx(scatter).margin(4 / std::sqrt(n)));
  CHECK(below == Approx(1 - std::exp(-pi / 4)).margin(2 / std::sqrt(n)));
}

TEST_CASE("a strain is that of the bond's length: the cells' distance, or what the material says") {
  BondModel bond = elastic(0.5);
  bond.criterion = FaceCriterion::strain_sum, bond.tension = 0.01, bond.cohesion = 0.1;
  for (const double length : {0.0, 0.4}) {
    bond.length = length;
    const double opens = 0.01 * (length > 0 ? length : 2), kn = E0 / (length > 0 ? length : 2);
    for (const double share : {0.99, 1.01}) {
      State s = state_of_voronoi(rock(bond), row_of(2, 2));
      CHECK(s.bonds.face.row[0].kn == Approx(kn));
      CHECK(drawn(s, Vec3(0.5 * share * opens, 0, 0)).force.x() == Approx(-kn * 0.5 * share * opens));
      drawn(s, Vec3(share * opens, 0, 0));
      CHECK(broken(s.bonds.face.row[0]) == (share > 1));
    }
  }
}

TEST_CASE("weaker bonds hold as much less: opening by their share, energy by its square") {
  BondModel bond = cohesive(1e5, 40);
  bond.between = 2.5e4;
  Tessellation cells = row_of(2, 1);
  for (const bool apart : {false, true}) {
    cells.cluster = {0, apart ? 1u : 0u};
    State s = state_of_voronoi(rock(bond), cells);
    double most = 0, work = 0, before = 0;
    const double tension = apart ? 2.5e4 : 1e5, taken = apart ? 40.0 / 16 : 40, step = 1.2 * 2 * taken / tension / 4000;
    for (int k = 1; k <= 4000; ++k) {
      const double force = -drawn(s, Vec3(k * step, 0, 0)).force.x();
      work += 0.5 * (force + before) * step, before = force, most = std::max(most, force);
    }
    CAPTURE(apart);
    CHECK(broken(s.bonds.face.row[0]));
    CHECK(most == Approx(tension).epsilon(5e-3));
    CHECK(work == Approx(taken).epsilon(5e-3));
  }
}

TEST_CASE("glue of a cell whose seed is at the wall is no stiffer than over a tenth of the cell's size") {
  const Model model = rock(elastic(0.5));
  const double size = 2 * std::cbrt(0.75 / pi);  // of the unit cube
  for (const double depth : {0.5, 0.11 * size, 0.09 * size, 1e-9}) {
    State s = state_of_voronoi(model, row_of(1, 1));
    add_floor(s);
    std::vector<OuterFace> faces{{0, moments_of(unit_box(), unit_box().face[4]), -Vec3::UnitZ(), depth}};
    glue(model, faces, 0, false, s);
    REQUIRE(s.bonds.wall.size() == 1);
    CHECK(s.bonds.wall[0].kn == Approx(E0 / std::max(depth, 0.1 * size)).epsilon(1e-9));
    CHECK(s.bonds.wall[0].kt == Approx(0.5 * s.bonds.wall[0].kn).epsilon(1e-12));
  }
}

TEST_CASE("a damaged bond: dashpots, friction and stiffness by their share of it") {
  BondModel model = cohesive(1e6, 4e3);
  model.friction = 0.4, model.damping = 0.1;
  State s = state_of_voronoi(rock(model, 0.4), row_of(2, 1));
  FaceBond& b = s.bonds.face.row[0];
  FaceDashpot& dashpot = s.bonds.dashpot.at(0);
  for (const double opening : {1.001e-3, 1.6e-3}) drawn(s, Vec3(opening, 0, 0));
  const double damage = b.damage, kn = b.kn, kt = b.kt;
  REQUIRE(damage > 0.3);
  REQUIRE(damage < 0.9);
  const BondStiffness c = resistance(b, dashpot, s.grains.orientation[0]);
  CHECK(c.shift(0, 0) == Approx((1 - damage) * dashpot.normal).epsilon(1e-12));
  CHECK(c.shift(1, 1) == Approx((1 - damage) * dashpot.shear).epsilon(1e-12));
  CHECK(c.turn.trace() == Approx((1 - damage) * dashpot.turn.sum()).epsilon(1e-12));
  // Pressed by 0.2 mm, slid by less than softens it on: the part that has given way rubs, the other one is a spring.
  const double pressed = 2e-4, slid = 1e-3;
  REQUIRE(std::sqrt(model.ratio) * slid < b.reached);
  drawn(s, Vec3(-pressed, 0, 0));
  const Pull p = drawn(s, Vec3(-pressed, slid, 0));
  REQUIRE(b.damage == damage);
  CHECK(p.force.x() == Approx(kn * pressed).epsilon(1e-9));
  CHECK(p.force.y() == Approx(-(1 - damage) * kt * slid - damage * 0.4 * kn * pressed).epsilon(1e-9));
  CHECK(b.shear.norm() == Approx(damage * 0.4 * kn * pressed).epsilon(1e-9));
}

TEST_CASE("a bond that is made stiffer to bear its birth's load is so in shear as well") {
  State s = state_of_voronoi(rock(elastic(0.5)), row_of(2, 1));
  FaceBond b = s.bonds.face.row[0];
  b.energy_1 = b.energy_2 = 40, b.criterion = FaceCriterion::cohesive, b.tension = b.cohesion = INFINITY;
  const double most = std::sqrt(2 * 0.5 * 40 * b.kn), before = b.kn;  // held: half of the energy
  FaceBond light = b;
  REQUIRE(bear(light, Vec3(0, 0, -0.9 * most), Vec3::Zero(), {&s.grains}));
  CHECK(light.kn == before);
  for (const Vec3& along : {Vec3(0, 0, -1), Vec3(std::sqrt(0.5), 0, 0)}) {
    FaceBond heavy = b;
    REQUIRE(bear(heavy, 1.5 * most * along, Vec3::Zero(), {&s.grains}));
    CHECK(heavy.kn == Approx(2.25 * before).epsilon(1e-6));
    CHECK(heavy.kt == Approx(0.5 * heavy.kn).epsilon(1e-12));
    const Vec3 force = pull(heavy, frame(s, heavy), {&s.grains}).force;
    CHECK(force.norm() == Approx(1.5 * most * along.norm()).epsilon(1e-6));
  }
  CHECK_FALSE(bear(b, Vec3(0, 0, -2.1 * most), Vec3::Zero(), {&s.grains}));
}

TEST_CASE("q and -q are one orientation: a damaged bond that is bent opens on the same side for either") {
  State s = state_of_voronoi(rock(cohesive(1e6, 4e3)), row_of(2, 1));
  for (const double opening : {1.001e-3, 1.6e-3}) drawn(s, Vec3(opening, 0, 0));
  const FaceBond b = s.bonds.face.row[0];
  REQUIRE(b.damage > 0.3);
  for (const Vec3& turn : {Vec3(0, 1e-3, 0), Vec3(3e-4, -5e-4, 8e-4)}) {
    const BondFrame at = frame(s, b);
    const Quat turned = rotation_by(turn) * at.b, same(-turned.w(), -turned.x(), -turned.y(), -turned.z());
    FaceBond plus = b, minus = b;
    const Vec3 shift(4e-4, 0, 0);  // partly open
    const Pull one = pull(plus, {at.a, turned, at.x_a, at.x_b + shift}, {&s.grains});
    const Pull other = pull(minus, {at.a, same, at.x_a, at.x_b + shift}, {&s.grains});
    CHECK((one.couple - other.couple).norm() < 1e-9 * one.couple.norm());
    CHECK((one.force - other.force).norm() < 1e-9 * one.force.norm());
    CHECK(energy(plus) == Approx(energy(minus)).epsilon(1e-12));
    CHECK(one.couple.dot(turn) < 0);
  }
}

TEST_CASE("order in space: bonds, glue, dead loads and what broken bonds left go with their cells") {
  const Model model = rock(elastic(0.5));
  State s = state_of_voronoi(model, row_of(4, 1));
  add_floor(s);
  glue(model, std::vector<OuterFace>{{2, moments_of(unit_box(), unit_box().face[4]), -Vec3::UnitZ(), 0.5}}, 0, false,
       s);
  s.bonds.load.push_back({3, Vec3(0.5, 0, 0), Vec3(7, 0, 0)});
  const double held = stored_energy(s.bonds);
  s.bonds.handed.push_back({{0, 1, {}}, Vec3::Zero(), E0, 1, 1, Vec3::Zero(), 1, 0, 0, 2.5});
  CHECK(stored_energy(s.bonds) == Approx(held + 2.5));  // what its contact will hold: nobody else has it until then
  const std::vector<FaceBond> before = s.bonds.face.row;
  const std::vector<Index> place{2, 0, 3, 1};
  renumber(s.bonds, place);
  for (std::size_t k = 0; k < before.size(); ++k) {
    CHECK(s.bonds.face.row[k].ends.a == place[before[k].ends.a]);
    CHECK(s.bonds.face.row[k].ends.b == place[before[k].ends.b]);
  }
  CHECK(s.bonds.wall[0].ends.a == 3);
  CHECK(s.bonds.wall[0].ends.b == 0);
  CHECK(s.bonds.load[0].grain == 1);
  CHECK(s.bonds.handed[0].ends.a == 2);
  CHECK(s.bonds.handed[0].ends.b == 0);
}

TEST_CASE("what a broken bond leaves is the contact's, whichever of the two comes first, and across a seam") {
  Team team(1);
  const Model model = rock(elastic(0.5), 0.4);
  struct Case {
    bool reversed, seam;
  };
  for (const Case& c : {Case{false, false}, {true, false}, {false, true}, {true, true}}) {
    State s = state_of_voronoi(model, row_of(4, 1 - 1e-3));
    s.bonds.face.row.clear();
    if (c.seam) s.boundary.cell.vectors = Vec3(4 * (1 - 2e-3), 5, 5).asDiagonal();
    for (std::size_t k = 0; k < 4; ++k) s.grains.motion[k].position.x() = (static_cast<double>(k) + 0.5) * (1 - 2e-3);
    const Vec3 on_b(0, 1e3, -2e3);  // the second of the two as the bond has them
    BondEnds ends{0, 1, {}};
    if (c.seam) ends = {0, 3, {-1, 0, 0}};
    if (c.reversed) {
      std::swap(ends.a, ends.b);
      for (auto& v : ends.image) v = static_cast<std::int16_t>(-v);
    }
    Handed h{.ends = ends,
             .at_a = Vec3::Zero(),
             .modulus = 2e8,
             .area = 1,
             .fresh = 1,
             .shear = on_b,
             .compliance = 1e-8,
             .held = 0,
             .spent = 0};
    prepare(model, s, team);
    s.bonds.handed.push_back(h);
    // As the list is made anew, and as a state that rests with it awakes.
    State rested = resting_copy(s);
    awaken(model, rested, team);
    take_over(s);
    for (const State* now : {&s, &rested}) {
      CHECK(now->bonds.handed.empty());
      std::size_t found = 0;
      for (std::size_t k = 0; k < now->contacts.size(); ++k) {
        const Pair& p = now->contacts.pair[k];
        if (p.a != 0 || p.b != (c.seam ? 3u : 1u) || crosses(p) != c.seam) continue;
        ++found;
        const Contact contact = now->contacts.contact[k];
        const Vec3 spring = c.reversed ? Vec3(-on_b) : on_b;
        CAPTURE(c.reversed, c.seam, now == &rested, contact.spring[slide_spring].transpose());
        CHECK((contact.spring[slide_spring] - spring).norm() <
              1e-2 * spring.norm());  // the pass that awakes turns it by round-off
        CHECK(contact.radius == 2e8);
      }
      CHECK(found == 1);
    }
  }
}

TEST_CASE("fragments: the largest first, and each cell's number is its fragment's place") {
  const Model model = rock(elastic());
  State s = state_of_voronoi(model, row_of(9, 1));
  auto& rows = s.bonds.face.row;
  for (const Index cut : {0u, 2u, 6u}) std::erase_if(rows, [&](const FaceBond& b) { return b.ends.a == cut; });
  const Fragments f = fragments_of(s);  // 0 | 1 2 | 3 4 5 6 | 7 8
  CHECK(f.size == std::vector<std::size_t>{4, 2, 2, 1});
  CHECK(f.of == std::vector<Index>{3, 1, 1, 0, 0, 0, 0, 2, 2});
  State t = state_of_voronoi(model, row_of(4, 1));
  auto& few = t.bonds.face.row;
  few.erase(few.begin());
  REQUIRE(few.size() == 2);
  few[0].ends.a = 1, few[0].ends.b = 2, few[1].ends.a = 0, few[1].ends.b = 3;
  const Fragments g = fragments_of(t);  // 0 3 | 1 2: of those of one size the one with the first cell comes first
  CHECK(g.size == std::vector<std::size_t>{2, 2});
  CHECK(g.of == std::vector<Index>{0, 1, 1, 0});
}

TEST_CASE("two cells twisted, and sheared, until their bond is gone: G_II of its area, and the books close") {
  Team team(1);
  BondModel bond = cohesive(1e6, 4e3);
  bond.energy_2 = 6e3;
  for (const bool twisted : {true, false}) {
    Model model = rock(bond);
    model.numerics.time_step = 2e-6;
    State s = state_of_voronoi(model, row_of(2, 1));
    if (twisted) {
      for (const std::size_t i : {0u, 1u}) {
        s.grains.motion[i].spin = Vec3(i == 1 ? 30 : -30, 0, 0);
        s.grains.angular_momentum[i] = inertia_tensor(s.grains, i) * s.grains.motion[i].spin;
      }
    } else {  // so heavy that they do not turn
      for (const std::size_t i : {0u, 1u})
        s.grains.inertia[i].moments *= 1e9, s.grains.motion[i].inverse_inertia /= 1e9;
      for (const std::size_t i : {0u, 1u}) s.grains.motion[i].velocity = Vec3(0, i == 1 ? 4 : -4, 0);
    }
    prepare(model, s, team);
    const double start = stored_energy(model, s);
    double fracture = 0;
    for (int k = 0; k < 400 && !s.bonds.empty(); ++k) {
      run_steps(model, s, 20, team);
      CHECK(s.ledger.fracture >= fracture);
      fracture = s.ledger.fracture;
    }
    CAPTURE(twisted);
    CHECK(s.bonds.empty());
    CHECK(s.ledger.fracture == Approx(6e3).epsilon(0.01));
    CHECK(start - stored_energy(model, s) == Approx(s.ledger.fracture).epsilon(0.01));
    CHECK(std::abs(energy_error(s.ledger, stored_energy(model, s))) < 2e-3);
    CHECK(s.ledger.fracture_area == Approx(1).epsilon(1e-9));
  }
}

TEST_CASE("bonds and glue count in the mean force and in the tangent of contacts") {
  Team team(1);
  const Model model = rock(elastic(0.5));
  State s = state_of_voronoi(model, row_of(2, 1));
  prepare(model, s, team);
  s.grains.motion[1].position.x() += 1e-4;  // the bond bears 1e5 N, on either cell
  refresh_forces(model, s, team);
  const Measurement m = measure(model, s);
  CHECK(m.contacts == 0);
  CHECK(m.unbalanced_force == Approx(1).epsilon(1e-9));

  // One cube between two plates, both glued: springs E0 / 0.5 over arms of 0.5, on each side.
  State box = state_of_voronoi(model, row_of(1, 1));
  add_box(box, 1);
  for (Index w = 0; w < 6; ++w) {
    const Polyhedron cube = unit_box();
    glue(model, std::vector<OuterFace>{{0, moments_of(cube, cube.face[w]), cube.face[w].normal, 0.5}}, w, false, box);
  }
  prepare(model, box, team);
  box.grains.motion[0].position.x() += 1e-4;  // all six faces pull it back: their sum over their mean
  refresh_forces(model, box, team);
  CHECK(unbalanced_force(box) == Approx(6).epsilon(1e-9));
  CHECK(unbalanced_force(box) == Approx(measure(model, box).unbalanced_force).epsilon(1e-12));
  box.grains.motion[0].position.x() -= 1e-4;
  refresh_forces(model, box, team);
  const Mat6 c = contact_stiffness_tangent(model, box);
  for (int k = 0; k < 3; ++k) {
    CHECK(c(k, k) == Approx(2 * (E0 / 0.5) * 0.25).epsilon(1e-9));
    // Shear of half the angle each: four of the six faces move along themselves, at half of the stiffness.
    CHECK(c(3 + k, 3 + k) == Approx(4 * 0.5 * (E0 / 0.5) * 0.25 * 0.25).epsilon(1e-9));
  }
}
