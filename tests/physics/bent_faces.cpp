// SPDX-License-Identifier: LGPL-3.0-or-later
// Faces that bend until they give way: what is pressed holds, what softening takes never falls, no path makes energy.
#include "dem/bond/face_parts.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A face of an irregular pentagon about its middle, along its principal axes: area, moments and corners.
struct Face {
  FlatPolygon polygon;
  FaceBond bond;

  FaceOutline outline() const { return {nullptr, {polygon.corner.data(), static_cast<std::size_t>(polygon.corners)}}; }
};

Face face_of(const FlatPolygon& p, const BondModel& b) {
  FlatMoments m = moments_of(p);
  const Eigen::Vector2d middle = m.first / m.area;
  const Eigen::Matrix2d about = m.second - m.area * middle * middle.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(about);
  Eigen::Matrix2d turn = axes.eigenvectors().transpose();
  if (turn.determinant() < 0) turn.row(0) *= -1;
  Face f;
  for (int k = 0; k < p.corners; ++k) f.polygon.add(turn * (p.corner[static_cast<std::size_t>(k)] - middle));
  FaceBond& s = f.bond;
  s.ends = {0, 1, {}};
  s.at_a = Vec3(0.5, 0, 0), s.at_b = Vec3(-0.5, 0, 0);
  s.normal = Vec3::UnitX(), s.e1 = Vec3::UnitY(), s.rest = Quat::Identity();
  m = moments_of(f.polygon);
  s.area = m.area, s.i1 = m.second(1, 1), s.i2 = m.second(0, 0);
  s.kn = b.stiffness, s.kt = b.ratio * b.stiffness;
  s.tension = b.tension, s.cohesion = b.cohesion, s.tan_phi = b.tan_phi, s.friction = b.friction;
  s.energy_1 = b.energy_1, s.energy_2 = b.energy_2, s.criterion = b.criterion;
  return f;
}

Face pentagon(const BondModel& b) {
  FlatPolygon p;
  for (const auto& [x, y] : {std::pair{-1.0, -0.6}, {0.8, -0.7}, {1.3, 0.1}, {0.4, 0.9}, {-0.9, 0.5}}) p.add({x, y});
  return face_of(p, b);
}

/// Opening and small turn of b against a in the axes of the face: e1, e2, normal.
using Path = Eigen::Matrix<double, 6, 1>;

Quat turn_at(const Path& x) { return rotation_by(x[3] * Vec3::UnitY() + x[4] * Vec3::UnitZ() + x[5] * Vec3::UnitX()); }

/// What b does on the way from x to y, its turn about its own middle.
Path way_between(const Path& x, const Path& y) {
  const Quat turn = turn_at(y) * turn_at(x).conjugate();
  Path way = y - x;
  way.tail<3>() << 2 * turn.y(), 2 * turn.z(), 2 * turn.x();
  return way;
}

/// Force and couple on b in the same axes: what works against the path.
Path load_at(Face& f, const Path& x) {
  const Vec3 shift = x[0] * Vec3::UnitY() + x[1] * Vec3::UnitZ() + x[2] * Vec3::UnitX();
  const Quat a = Quat::Identity(), b = turn_at(x);
  const Pull p = pull(f.bond, {a, b, Vec3::Zero(), f.bond.at_a + shift - b * f.bond.at_b}, f.outline());
  Path load;
  load << p.force.y(), p.force.z(), p.force.x(), p.couple.y(), p.couple.z(), p.couple.x();
  return load;
}

/// Work done on a face from `from` to `to` in so many steps (J); softening and rubbing never fall on the way.
double work_along(Face& f, const Path& from, const Path& to, int steps) {
  double work = 0;
  Path before = load_at(f, from);
  for (int k = 1; k <= steps; ++k) {
    const double spent = f.bond.spent, rub = f.bond.rubbed;
    const Path x = from + (to - from) * (k - 1) / steps, y = from + (to - from) * k / steps, now = load_at(f, y);
    work -= 0.5 * (before + now).dot(way_between(x, y));
    before = now;
    REQUIRE(f.bond.spent >= spent);
    REQUIRE(f.bond.rubbed >= rub);
  }
  return work;
}

Path drawn(std::uint64_t n, std::uint64_t c, const Path& scale) {
  Path x;
  for (int k = 0; k < 6; ++k)
    x[k] = scale[k] * random_normal(7, n, Purpose::turn, 6 * c + static_cast<std::uint64_t>(k));
  return x;
}

}  // namespace

TEST_CASE("the pressed part of a polygon: area and moments as the cut polygon has them") {
  const Face f = pentagon(elastic());
  const auto& p = f.polygon;
  const std::span<const Eigen::Vector2d> corner{p.corner.data(), static_cast<std::size_t>(p.corners)};
  const FlatMoments whole = moments_of(p);
  int mixed = 0;
  for (std::uint64_t n = 0; n < 500; ++n) {
    const Path x = drawn(n, 0, Path::Ones());
    const FaceOpening o{0.7 * x[0], {x[1], x[2]}};
    const FlatMoments cut = moments_of(clipped(p, o.slope, -o.shift)), found = pressed_part(o, corner);
    CHECK(found.area == Approx(cut.area).margin(1e-13));
    CHECK((found.first - cut.first).norm() < 1e-13);
    CHECK((found.second - cut.second).norm() < 1e-13);
    const FaceParts parts = parts_of(o, whole, corner);
    CHECK(parts.of_open.square(o) > -1e-13);
    // The opening's square over both parts is that over the face.
    CHECK(parts.of_open.square(o) + parts.of_pressed.square(o) == Approx(sums_over(o, whole).square(o)));
    mixed += cut.area > 0.01 && cut.area < whole.area - 0.01;
  }
  CHECK(mixed > 100);
}

TEST_CASE("a damaged face that is partly open: force and couple are the gradient of its energy") {
  double worst = 0;
  int mixed = 0;
  for (std::uint64_t n = 0; n < 400; ++n) {
    Face f = pentagon(cohesive(1e6, 4e3));
    f.bond.damage = 0.2 + 0.7 * static_cast<double>(n % 5) / 4;
    f.bond.onset = 1e-3, f.bond.reached = 1e9, f.bond.rupture = 1e12;  // damage stays
    Path scale;
    scale << 2e-3, 2e-3, 2e-3, 4e-3, 4e-3, 4e-3;
    const Path x = drawn(n, 0, scale);
    const Path load = load_at(f, x);
    const FaceParts parts = parts_of({x[2], {-x[4], x[3]}}, moments_of(f.polygon), f.outline().kept);
    mixed += parts.pressed.area > 0.05 && parts.pressed.area < f.bond.area - 0.05;
    const double h = 1e-7;
    for (int k = 0; k < 3; ++k) {
      double at[2];
      for (int side = 0; side < 2; ++side) {
        Face copy = f;
        load_at(copy, x + (side ? -h : h) * Path::Unit(k));
        at[side] = energy(copy.bond);
      }
      worst = std::max(worst, std::abs(-(at[0] - at[1]) / (2 * h) - load[k]) / load.head<3>().norm());
    }
    // Turns of b from where it is, about the middle of its face.
    const Quat b = turn_at(x);
    const Vec3 shift = x[0] * Vec3::UnitY() + x[1] * Vec3::UnitZ() + x[2] * Vec3::UnitX();
    for (int k = 0; k < 3; ++k) {
      double at[2];
      for (int side = 0; side < 2; ++side) {
        FaceBond copy = f.bond;
        const Quat q = rotation_by((side ? -h : h) * Vec3::Unit(k)) * b, a = Quat::Identity();
        pull(copy, {a, q, Vec3::Zero(), copy.at_a + shift - q * copy.at_b}, f.outline());
        at[side] = energy(copy);
      }
      const double couple = k == 0 ? load[5] : load[k + 2];
      worst = std::max(worst, std::abs(-(at[0] - at[1]) / (2 * h) - couple) / load.tail<3>().norm());
    }
  }
  CHECK(worst < 2e-5);
  CHECK(mixed > 100);
}

TEST_CASE("a turn is that of the shorter way: q and -q open a damaged pentagon alike") {
  for (std::uint64_t n = 0; n < 20; ++n) {
    Face f = pentagon(cohesive(1e6, 4e3));
    f.bond.damage = 0.6, f.bond.onset = 1e-3, f.bond.reached = 1e9, f.bond.rupture = 1e12;  // damage stays
    Path scale;
    scale << 2e-3, 2e-3, 2e-3, 4e-3, 4e-3, 4e-3;
    const Path x = drawn(n, 3, scale);
    const Quat a = Quat::Identity(), q = turn_at(x);
    const Vec3 x_b = f.bond.at_a + x[0] * Vec3::UnitY() + x[1] * Vec3::UnitZ() + x[2] * Vec3::UnitX() - q * f.bond.at_b;
    FaceBond one = f.bond, other = f.bond;
    const Pull p = pull(one, {a, q, Vec3::Zero(), x_b}, f.outline());
    const Pull r = pull(other, {a, Quat(-q.coeffs()), Vec3::Zero(), x_b}, f.outline());
    REQUIRE(p.couple.norm() > 0);
    CHECK((p.force - r.force).norm() <= 1e-12 * p.force.norm());
    CHECK((p.couple - r.couple).norm() <= 1e-12 * p.couple.norm());
    CHECK(energy(one) == Approx(energy(other)).epsilon(1e-12));
  }
}

TEST_CASE("whatever way a face gives way, alone or mixed, back and forth, softening takes G of its area") {
  const BondModel model = cohesive(1e6, 4e3);
  const auto taken = [&](const Path& way, bool returns) {
    Face f = pentagon(model);
    f.bond.energy_2 = f.bond.energy_1;
    Path at = Path::Zero();
    double work = 0;
    for (int k = 1; k <= 12 && !broken(f.bond); ++k) {
      const Path to = way * k / 12.0;
      work += work_along(f, at, to, 2000);
      if (returns) work += work_along(f, to, -0.3 * to, 2000) + work_along(f, -0.3 * to, to, 2000);
      at = to;
    }
    REQUIRE(broken(f.bond));
    CHECK(rubbed(f.bond) == 0);  // no friction here
    CHECK(work == Approx(dissipated(f.bond) + energy(f.bond)).epsilon(2e-3));
    return dissipated(f.bond) / (f.bond.area * f.bond.energy_1);
  };
  for (int k = 0; k < 6; ++k) {  // opening, shear, bending about both axes, twist
    Path way = Path::Zero();
    way[k] = 0.1;
    for (const bool returns : {false, true}) CHECK(taken(way, returns) == Approx(1).epsilon(0.01));
  }
  Path scale;
  scale << 0.04, 0.04, 0.04, 0.08, 0.08, 0.08;
  for (std::uint64_t n = 0; n < 12; ++n) {
    Path way = drawn(n, 1, scale);
    way[2] = std::abs(way[2]) - 0.01;  // some of them pressed at first
    way *= 0.25 / way.norm();
    CHECK(taken(way, n % 2 == 1) == Approx(1).epsilon(0.01));
  }
}

TEST_CASE("extremes: slivers, thirty corners, shear a million times softer or stiffer, ten times the strength on it") {
  FlatPolygon sliver, round;
  for (const auto& [x, y] : {std::pair{-1.0, 0.0}, {0.2, -1e-3}, {1.0, 0.0}, {0.3, 2e-3}}) sliver.add({x, y});
  for (int k = 0; k < 30; ++k) round.add({0.8 * std::cos(pi * k / 15), 1.1 * std::sin(pi * k / 15)});
  struct Case {
    FlatPolygon polygon;
    double ratio, pressed;  // of kt to kn; m
  };
  for (const Case& c : {Case{sliver, 0.5, 0}, {round, 0.5, 0}, {round, 1e-6, 0}, {round, 1e6, 0}, {round, 0.5, 1e-2}})
    for (int k = 0; k < 6; ++k) {
      BondModel model = cohesive(1e6, 4e3);
      model.ratio = c.ratio, model.energy_2 = model.energy_1;
      model.cohesion = std::min(model.cohesion, 0.5 * softening_limit(c.ratio * E0, model.energy_2));
      Face f = face_of(c.polygon, model);
      const FaceBond& s = f.bond;
      Path start = Path::Zero();
      start[2] = -c.pressed;
      // What would take a hundred times G A of an undamaged face, what presses besides, and three times what breaks it.
      const double polar = s.i1 + s.i2,
                   stiff[6] = {s.kt * s.area, s.kt * s.area, s.kn * s.area, s.kn * s.i1, s.kn * s.i2, s.kt * polar};
      const bool bends = k == 3 || k == 4, slides = k < 2 || k == 5;
      const double radius = std::sqrt(polar / s.area);
      Path middle = start, end = start;
      middle[k] += 15 * std::sqrt(2 * s.energy_1 * s.area / stiff[k]) + (bends ? 20 : 1) * c.pressed;
      end[k] = std::max(middle[k], slides ? 6 * s.energy_2 / s.cohesion / (k == 5 ? radius : 1) : 0.0);
      if (end.tail<3>().norm() > 0.5) continue;  // no small turn
      double work = 0.5 * s.kn * s.area * c.pressed * c.pressed;
      work += work_along(f, start, middle, 20000);
      work += work_along(f, middle, end, 2000);
      CAPTURE(c.ratio, c.pressed, k);
      CHECK(broken(f.bond));
      CHECK(work == Approx(dissipated(f.bond) + energy(f.bond)).epsilon(5e-3));
      if (slides && c.pressed > 0)  // holds more than G A where it gives way: it takes all of that
        CHECK(dissipated(f.bond) > f.bond.area * f.bond.energy_1);
      else
        CHECK(dissipated(f.bond) == Approx(f.bond.area * f.bond.energy_1).epsilon(0.01));
    }
}

TEST_CASE("what is pressed rubs by its pressure, whatever has given way") {
  BondModel model = cohesive(1e6, 4e3);
  model.friction = 0.4;
  Face f = pentagon(model);
  Path start = Path::Zero(), end = Path::Zero();
  start[2] = end[2] = -2e-3, end[0] = 0.1;
  double work = 0.5 * f.bond.kn * f.bond.area * 4e-6;
  work += work_along(f, start, end, 20000);
  REQUIRE(broken(f.bond));
  const Path load = load_at(f, end);
  CHECK(load[0] == Approx(-0.4 * f.bond.kn * f.bond.area * 2e-3).epsilon(1e-9));
  CHECK(rubbed(f.bond) > 0.5 * 0.4 * f.bond.kn * f.bond.area * 2e-3 * 0.1);
  CHECK(work == Approx(dissipated(f.bond) + rubbed(f.bond) + energy(f.bond)).epsilon(2e-3));
}

TEST_CASE("a face that holds more than G A where it gives way takes what friction does not go on bearing") {
  // Under the pressure p it gives way at c + tan phi p; then friction f bears mu p of it: the rest of what the spring
  // held is taken, be it more than G A, less, or nothing.
  constexpr double pressed = 1e-2, p = E0 * pressed;
  for (const double friction : {0.0, 0.6, 0.75, 0.9}) {
    BondModel model = cohesive(1e6, 4e3);
    model.friction = friction;
    Face f = pentagon(model);
    const double bears = model.cohesion + model.tan_phi * p, goes_on = std::min(friction * p, bears), kt = f.bond.kt;
    REQUIRE(0.5 * bears * bears / kt > model.energy_2);
    Path start = Path::Zero(), end = Path::Zero();
    start[2] = end[2] = -pressed, end[0] = 1.02 * bears / kt;
    double work = 0.5 * f.bond.kn * f.bond.area * pressed * pressed;
    work += work_along(f, start, end, 2000);
    CAPTURE(friction);
    REQUIRE(broken(f.bond));
    const double taken = dissipated(f.bond) / f.bond.area, expected = 0.5 * (bears * bears - goes_on * goes_on) / kt;
    CHECK(taken == Approx(expected).epsilon(4e-3).margin(2e-3 * model.energy_2));  // two steps beyond the strength
    CHECK((taken > model.energy_2) == (friction < 0.7));
    CHECK(work == Approx(dissipated(f.bond) + rubbed(f.bond) + energy(f.bond)).epsilon(2e-3));
  }
}

TEST_CASE("a face that bends keeps the stiffness of what is pressed, at any damage") {
  Face f = pentagon(cohesive(1e6, 4e3));
  Path way = Path::Zero();
  way[3] = 0.2;
  work_along(f, Path::Zero(), way, 4000);
  REQUIRE(broken(f.bond));
  const FlatMoments part = moments_of(clipped(f.polygon, {0, 1}, 0));  // opening: angle times the distance along e2
  const Path load = load_at(f, way);
  CHECK(load[2] == Approx(-E0 * 0.2 * part.first.y()).epsilon(0.01));
  CHECK(load[3] == Approx(-E0 * 0.2 * part.second(1, 1)).epsilon(0.01));
}

TEST_CASE("no closed path of a face makes energy, with friction and without") {
  int rough = 0;
  for (std::uint64_t n = 0; n < 200; ++n) {
    BondModel model = cohesive(1e6, 4e3);
    model.friction = n % 3 == 0 ? 0.0 : 0.4;
    Face f = pentagon(model);
    Path scale;
    scale << 3e-3, 3e-3, 3e-3, 5e-3, 5e-3, 5e-3;
    if (n % 2) scale *= 3;
    Path at = Path::Zero();
    double work = 0;
    for (std::uint64_t leg = 1; leg <= 6; ++leg) {
      const Path to = leg == 6 ? Path(Path::Zero()) : drawn(n, leg, scale);
      work += work_along(f, at, to, 2000);
      at = to;
    }
    const double spent = dissipated(f.bond) + rubbed(f.bond);
    const double scale_of = spent + 1e-3 * f.bond.area * f.bond.energy_1;
    CHECK(work > -1e-3 * scale_of);
    const double error = std::abs(work - spent - energy(f.bond)) / scale_of;
    CHECK(error < 0.01);  // a face that is all but brittle gives way within some ten of the steps
    rough += error > 1e-3;
  }
  CHECK(rough <= 4);
}

TEST_CASE("two cells bent apart over one face: G A is taken, and nothing is made where a contact goes on") {
  // Bodies that hardly feel the couple turn against each other and may part; what bends is the face.
  struct Case {
    double toughness, turn;  // J/m^2, rad
    bool held;               // bodies that cannot part: one half of the face is pressed as much as the other opens
  };
  for (const Case& c : {Case{15, 0.012, false}, {60, 0.05, false}, {15, 0.03, true}}) {
    const double toughness = c.toughness;
    BondModel b = cohesive(2e6, toughness);
    b.stiffness = 2e12, b.stiffness_given = true, b.energy_2 = b.energy_1, b.friction = 0.3;
    const double side = 1e-2, speed = 4;  // m, rad/s
    Model model = rock(b, 0.3);
    model.materials[0].contact = Foundation::Of{.given = b.stiffness, .shear_ratio = b.ratio};
    model.law = Foundation{}, model.numerics.time_step = 5e-7;
    make_pair_laws(model);
    Team team(1);
    Tessellation cells;
    cells.seed = {Vec3(0.5, 0.5, 0.5) * side, Vec3(1.5, 0.5, 0.5) * side};
    for (int k = 0; k < 2; ++k) cells.body.push_back(box_between(Vec3(k, 0, 0) * side, Vec3(k + 1, 1, 1) * side));
    cells.body[0].face[1].tag = 0, cells.body[1].face[0].tag = 0;
    cells.partner = {{{1, {}}}, {{0, {}}}};
    State s;
    add_voronoi_grains(model, cells, 0, s);
    REQUIRE(s.bonds.size() == 1);
    for (std::size_t i = 0; i < 2; ++i) {
      s.grains.inertia[i].moments *= 1e8;
      if (c.held) s.grains.mass[i] *= 1e9, s.grains.motion[i].inverse_mass /= 1e9;
      s.grains.angular_momentum[i] = (i ? 0.5 : -0.5) * speed * s.grains.inertia[i].moments.x() * Vec3::UnitZ();
    }
    prepare(model, s, team);
    const double start = kinetic_energy(s.grains), whole = toughness * side * side;
    run_for(model, s, c.turn / speed, team);
    CHECK(s.bonds.size() == 0);
    CHECK(s.ledger.fracture == Approx(whole).epsilon(0.01));
    CHECK(s.ledger.handed >= 0);
    CHECK(s.ledger.handed < 0.02 * whole);
    CHECK(std::abs(s.ledger.unexplained) < 0.02 * whole);
    double moving = 0;
    for (const Motion& m : s.grains.motion) moving += 0.5 * m.velocity.squaredNorm() / m.inverse_mass;
    CHECK(moving < 2 * whole);
    const double told = stored_energy(model, s) + s.ledger.spent();
    CHECK(std::abs(told - start - s.ledger.work) < 0.03 * whole);
  }
}
