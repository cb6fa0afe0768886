// SPDX-License-Identifier: LGPL-3.0-or-later
// Grains that break into many hulls at once: what the pieces keep of their parent, what acts on them, how strong they
// are.
#include "dem/fracture/shatter.hpp"
#include "dem/packing/random_hulls.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/bonded.hpp"
#include "tests/held_grains.hpp"
#include "tests/loaded_body.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

Model shattering_rock() {
  Model model = hull_model(0.5);
  FractureModel f;
  f.splitter = Shatter{};
  model.materials[0].fracture = f;
  return model;
}

/// Points in a grain, each of the nearest of some seeds.
struct Cracked {
  std::vector<Vec3> point;
  std::vector<int> label;
  std::size_t count;
};
Cracked cracked(const Grains& g, std::size_t i, std::size_t count, std::uint64_t id) {
  Cracked out{{}, {}, count};
  const HullView hull = (*g.hulls)[g.hull[i]];
  const double r = g.motion[i].radius, step = g.extent[i].equivalent_radius / 6;
  std::vector<Vec3> seed;
  for (std::size_t s = 0; s < count; ++s)
    seed.push_back(0.4 * g.extent[i].equivalent_radius * random_vector(id, s).normalized());
  int face = 0;
  for (double x = -r; x < r; x += step)
    for (double y = -r; y < r; y += step)
      for (double z = -r; z < r; z += step) {
        const Vec3 p(x, y, z);
        if (!(depth_below(hull, p, face) > 0)) continue;
        const auto nearest = std::min_element(seed.begin(), seed.end(), [&](const Vec3& a, const Vec3& b) {
          return (p - a).squaredNorm() < (p - b).squaredNorm();
        });
        out.point.push_back(p), out.label.push_back(static_cast<int>(nearest - seed.begin()));
      }
  return out;
}

Break break_of(const State& s, std::size_t i, std::size_t count, std::uint64_t id, std::size_t crumbs = 0) {
  const Cracked c = cracked(s.grains, i, count, id);
  return {i,
          {Mat3::Zero(), std::nullopt},
          pieces_by_labels(Shatter{}, s.grains, i, c.point, c.label, c.count, nullptr, crumbs)};
}

/// Volume that two grains share, by planes.
double shared_volume(const Grains& g, std::size_t a, std::size_t b) {
  const auto stands = [&](std::size_t i) {
    Polyhedron body = body_of((*g.hulls)[g.hull[i]]);
    place(body, g.orientation[i].toRotationMatrix(), g.motion[i].position);
    return body;
  };
  Polyhedron common = stands(a);
  const Polyhedron other = stands(b);
  for (const Polyhedron::Face& f : other.face)
    if (!common.empty()) cut(common, f.normal, f.offset, 0, 0);
  return common.face.size() < 4 ? 0 : std::abs(moments_of(common).volume);
}

Mat3 second_about_origin(const Grains& g) {
  Mat3 sum = Mat3::Zero();
  for (std::size_t i = 0; i < g.size(); ++i) {
    const Vec3 x = g.motion[i].position;
    sum += inertia_tensor(g, i) + g.mass[i] * (x.squaredNorm() * Mat3::Identity() - x * x.transpose());
  }
  return sum;
}

}  // namespace

TEST_CASE("a spinning hull that falls into k pieces keeps mass, momenta, energy and inertia; no two pieces overlap") {
  Team team(1);
  std::size_t most = 0;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const Model model = shattering_rock();
    State s;
    const Polyhedron body = k % 2 ? some_cells(64).body[k] : ball_of_planes(Vec3(1, 0.8, 1.2)).body;
    add_body(s, body, random_vector(k, 0), random_rotation(3, k), random_vector(k, 1), random_vector(k, 2));
    prepare(model, s, team);
    const Grains before = s.grains;
    const Break b = break_of(s, 0, 2 + k % 4, k);
    if (b.pieces->piece.empty()) continue;
    double area = 0;
    for (const FreshFace& face : b.pieces->face) area += face.moments.area;
    for (std::size_t i = 0; i < b.pieces->piece.size(); ++i)  // as balls of their volume they are told their inertia
      CHECK(4 * pi / 3 * std::pow(equivalent_radius(b.pieces->piece[i].shape), 3) ==
            Approx(moments_of(b.pieces->body[i]).volume).epsilon(1e-12));
    apply_breaks(model, s, {b}, team);
    const Grains& g = s.grains;
    REQUIRE(g.size() == b.pieces->piece.size());
    most = std::max(most, g.size());
    CHECK(std::abs(total_mass(g) / total_mass(before) - 1) < 1e-12);
    CHECK((momentum(g) - momentum(before)).norm() < 1e-12 * momentum(before).norm());
    CHECK((angular_momentum(g) - angular_momentum(before)).norm() < 1e-12 * angular_momentum(before).norm());
    CHECK(std::abs(kinetic_energy(g) / kinetic_energy(before) - 1) < 1e-12);
    CHECK((second_about_origin(g) - second_about_origin(before)).norm() < 1e-12 * second_about_origin(before).norm());
    for (std::size_t i = 0; i < g.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) CHECK(shared_volume(g, i, j) < 1e-12 * before.extent[0].volume);
    for (const Vec3& f : g.force) CHECK(f.norm() == 0);  // siblings touch, and do not press
    CHECK(s.ledger.fracture_area == Approx(area).epsilon(1e-12));
    CHECK(area > 0);
    CHECK(std::abs(s.ledger.fines.mass) < 1e-13);
    CHECK(s.ledger.breakages == 1);
    CHECK(s.bonds.empty());
    for (std::size_t i = 0; i < g.size(); ++i) CHECK(g.generation[i] == 1);
    // They go on apart: the balance of energy holds.
    s.dt = 1e-4;
    run_steps(model, s, 50, team);
    CHECK(std::abs(told_energy_error(s, stored_energy(model, s))) < 1e-3);
  }
  CHECK(most >= 4);
}

TEST_CASE("crumbs become fines: with them mass, momenta and energy are kept, and what is left tiles the rest") {
  Team team(1);
  const Model model = shattering_rock();
  for (std::uint64_t k = 0; k < 6; ++k) {
    State s;
    add_body(s, ball_of_planes(Vec3(1, 0.8, 1.2)).body, random_vector(k, 0), random_rotation(3, k), random_vector(k, 1),
             random_vector(k, 2));
    prepare(model, s, team);
    const Cracked c = cracked(s.grains, 0, 4, k);
    const std::size_t crumbs = 1 + k % 2;
    const HullView hull = (*s.grains.hulls)[s.grains.hull[0]];
    const Parting all = part_by_labels(body_of(hull), c.point, c.label, 4, hull.faces, {});
    double crumbled = 0, area = 0;
    std::size_t kept = 0;
    for (std::size_t a = 0; a < all.part.size(); ++a) {
      if (all.of[a] + crumbs < 4)
        ++kept;
      else
        crumbled += moments_of(all.part[a]).volume;
      for (const Polyhedron::Face& face : all.part[a].face)
        if (all.of[a] + crumbs < 4 && face.tag >= hull.faces &&
            all.of[static_cast<std::size_t>(face.tag - hull.faces)] + crumbs < 4)
          area += 0.5 * moments_of(all.part[a], face).area;
    }
    const Grains before = s.grains;
    Pieces pieces = pieces_by_labels(Shatter{}, before, 0, c.point, c.label, 4, nullptr, crumbs);
    REQUIRE(kept > 0);
    CHECK(pieces.piece.size() == kept);
    CHECK(pieces.loses_mass == (crumbled > 0));
    apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt}, std::move(pieces)}}, team);
    const Grains& g = s.grains;
    const Fines& f = s.ledger.fines;
    const double dense = before.mass[0] / before.extent[0].volume;
    CHECK(g.size() == kept);
    CHECK(std::abs(f.mass - dense * crumbled) < 1e-12 * before.mass[0]);
    CHECK(std::abs((total_mass(g) + f.mass) / total_mass(before) - 1) < 1e-12);
    CHECK((momentum(g) + f.momentum - momentum(before)).norm() < 1e-12 * momentum(before).norm());
    CHECK((angular_momentum(g) + f.angular_momentum - angular_momentum(before)).norm() <
          1e-12 * angular_momentum(before).norm());
    CHECK(std::abs((kinetic_energy(g) + f.kinetic) / kinetic_energy(before) - 1) < 1e-12);
    CHECK(s.ledger.fracture_area == Approx(area).epsilon(1e-12));
  }
}

TEST_CASE("what is left of a chipped hull bears its dead loads where they act, as their moments say") {
  Team team(1);
  const Model model = shattering_rock();
  std::size_t chipped = 0;
  for (std::uint64_t k = 0; k < 6; ++k) {
    PointLoads loads;
    for (std::uint64_t l = 0; l < 5; ++l)
      loads.emplace_back(0.4 * random_vector(k, l).normalized(), random_vector(k, 9 + l));
    State s = loaded_body(model, unit_cube(), loads);
    Break b = break_of(s, 0, 2, k, 1);
    if (b.pieces->piece.size() != 1) continue;
    ++chipped;
    CHECK(b.pieces->face.empty());
    apply_breaks(model, s, {std::move(b)}, team);
    REQUIRE(s.grains.size() == 1);
    for (std::size_t l = 0; l < loads.size(); ++l)
      CHECK((s.grains.motion[0].position + s.grains.orientation[0] * s.bonds.load[l].at - loads[l].first).norm() <
            1e-9);
  }
  CHECK(chipped > 3);
}

TEST_CASE("dead loads of a hull that falls to pieces go to the piece that they act on") {
  Team team(1);
  Model model = shattering_rock();
  for (std::uint64_t k = 0; k < 8; ++k) {
    std::vector<std::pair<Vec3, Vec3>> loads;
    for (std::uint64_t l = 0; l < 12; ++l) {
      const Vec3 x = random_vector(k, 20 + l);
      loads.emplace_back(0.499 / x.cwiseAbs().maxCoeff() * x, random_vector(k, 40 + l));
    }
    State s = loaded_body(model, unit_cube(), loads);
    apply_breaks(model, s, {break_of(s, 0, 4, k)}, team);
    REQUIRE(s.grains.size() > 1);
    for (std::size_t l = 0; l < loads.size(); ++l) {
      const DeadLoad& load = s.bonds.load[l];
      const std::size_t i = load.grain;
      CHECK((s.grains.motion[i].position + s.grains.orientation[i] * load.at - loads[l].first).norm() < 1e-9);
      int face = 0;
      CHECK(depth_below((*s.grains.hulls)[s.grains.hull[i]], load.at, face) > -1e-9);
    }
  }
}

TEST_CASE("pressed hulls that fall to pieces, many in one instant: the balance of energy closes at the instant") {
  Team team(2);
  const Model model = shattering_rock();
  State s = deforming_cube(model, 20, 10, team);
  for (int k = 0; k < 4; ++k) {
    update_time_step(model, s);
    run_steps(model, s, 20, team);
  }
  const double mass = total_mass(s.grains), before = told_energy_error(s, stored_energy(model, s));
  const Vec3 linear = momentum(s.grains);
  std::vector<Break> breaks;
  for (std::size_t i = 0; i < 64; i += 3)
    if (Break b = break_of(s, i, 2 + i % 4, i); !b.pieces->piece.empty()) breaks.push_back(std::move(b));
  REQUIRE(breaks.size() > 15);
  apply_breaks(model, s, breaks, team);
  CHECK(s.grains.size() > 64 + 25);
  CHECK(std::abs(total_mass(s.grains) / mass - 1) < 1e-12);
  CHECK((momentum(s.grains) - linear).norm() < 1e-11 * mass);
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s)) - before) < 1e-9);
  // Once more, and a part of each becomes fines: contacts go with it.
  const std::size_t grains = s.grains.size();
  std::vector<Break> chips;
  for (std::size_t i = 1; i < 64; i += 3)
    if (Break b = break_of(s, i, 2 + i % 3, i, 1); !b.pieces->piece.empty()) chips.push_back(std::move(b));
  REQUIRE(chips.size() > 15);
  apply_breaks(model, s, chips, team);
  const Fines& fines = s.ledger.fines;
  CHECK(s.grains.size() > grains);
  CHECK(fines.mass > 0.01 * mass);
  CHECK(std::abs((total_mass(s.grains) + fines.mass) / mass - 1) < 1e-12);
  CHECK((momentum(s.grains) + fines.momentum - linear).norm() < 1e-11 * mass);
  CHECK(std::abs(told_energy_error(s, stored_energy(model, s)) - before) < 1e-9);
}

TEST_CASE("linear survival and strengths that fragments inherit (Zhu & Zhao 2019, eqs 12 and 15)") {
  const Weibull linear{3.1, 1e-3, 3 / 3.1, true, true};
  CHECK(linear.drawn(0) == Approx(1.486842).epsilon(1e-6));
  CHECK(linear.drawn(0.37) == Approx(1).epsilon(1e-6));
  CHECK(linear.drawn(1) == Approx(0.171053).epsilon(1e-5));
  CHECK(Weibull{3.1, 1e-3, 3 / 3.1}.drawn(std::exp(-1.0)) == Approx(1).epsilon(1e-12));
  FractureModel f;
  f.strength_law = linear;
  CHECK(*f.inherited(0.7, 1e-3, 0.5e-3) == Approx(0.7 * 1.955777).epsilon(1e-6));
  CHECK(linear.factor(0.5e-3, 0.37) == Approx(1.955777).epsilon(1e-6));
  f.strength_law = Weibull{3.1, 1e-3, 3 / 3.1};
  CHECK(!f.inherited(0.7, 1e-3, 0.5e-3));
  // The mean over all draws, 0.829, and a grain's own.
  double sum = 0;
  for (std::uint64_t id = 0; id < 20000; ++id) sum += linear(1e-3, 3, id);
  CHECK(sum / 20000 == Approx((1.13 - 0.5) / 0.76).epsilon(4 * 0.38 / 0.829 / std::sqrt(20000.0)));
  // In a break.
  for (const bool inherits : {true, false}) {
    Model model = shattering_rock();
    model.materials[0].fracture->strength_law = Weibull{3.1, 0.5, 3 / 3.1, true, inherits};
    State s;
    add_body(s, unit_cube(), Vec3::Zero(), Quat::Identity());
    Team team(1);
    prepare(model, s, team);
    const double parents = s.grains.strength[0], radius = s.grains.extent[0].equivalent_radius;
    apply_breaks(model, s, {break_of(s, 0, 3, 1)}, team);
    REQUIRE(s.grains.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
      const double own = parents * std::pow(s.grains.extent[i].equivalent_radius / radius, -3 / 3.1);
      const double relative = std::abs(s.grains.strength[i] / own - 1);
      CHECK((inherits ? relative < 1e-12 : relative > 1e-3));
    }
  }
}
