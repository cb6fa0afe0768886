// SPDX-License-Identifier: LGPL-3.0-or-later
// Parallel bonds of spheres against closed forms of a round rod: tension, shear, bending and twist, with what they bear
// and what breaking takes; which spheres are bonded; agglomerates.
#include "dem/base/random.hpp"
#include "dem/bond/kinds.hpp"
#include "dem/packing/sphere_bonds.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/sample/make.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 2e-3, S = 1e-3, E = 3e9, gap = 1e-4, ratio = 0.4, lambda = 0.8;
constexpr double length = R + S + gap, radius = lambda * S, kn = E / length, kt = ratio * kn;
const double area = pi * radius * radius, inertia = 0.25 * pi * std::pow(radius, 4), twist = 2 * inertia;

Model rods_of(double tension = 1e300, double shear = 1e300) {
  Model m;
  Material& rock = m.materials.emplace_back();
  rock.name = "rock", rock.density = 2500, rock.youngs_modulus = 10e9;
  BondModel& b = rock.bond.emplace();
  b.criterion = FaceCriterion::rod, b.stiffness = E, b.ratio = ratio;
  b.tension = tension, b.cohesion = shear, b.radius_ratio = lambda, b.gap = 0.11;
  make_pair_laws(m);
  return m;
}

/// A large sphere and a small one along a way of no axis.
const Vec3 way = Vec3(1, 2, -2) / 3, side = Vec3(2, 1, 2) / 3;

Sample two(const Model& model) {
  Recipe recipe;
  recipe.grains = Spheres{{{Vec3(0.1, 0.2, 0.3), R}, {Vec3(0.1, 0.2, 0.3) + length * way, S}}};
  Team alone(1);
  return make(model, recipe, alone);
}

/// What the small sphere feels, about the middle of the rod.
struct Felt {
  Vec3 force, couple;
};

struct Pair2 {
  Model model;
  State state;
  Index large, small;

  explicit Pair2(const Model& m) : model(m), state(two(m).state) {
    large = state.grains.motion[0].radius > state.grains.motion[1].radius ? 0 : 1, small = 1 - large;
  }
  /// The small sphere moved as a body about the rod's middle.
  void move(const Vec3& shift, double angle, const Vec3& axis) {
    Grains& g = state.grains;
    const Quat turn(Eigen::AngleAxisd(angle, axis));
    const Vec3 middle = g.motion[large].position + (R + 0.5 * gap) * way;
    g.motion[small].position = middle + turn * (g.motion[small].position - middle) + shift;
    g.orientation[small] = turn * g.orientation[small];
  }
  Felt felt() {
    Team alone(1);
    bond_forces(state.grains, state.boundary.cell, state.bonds, state.ledger, alone);
    const Grains& g = state.grains;
    const Vec3 middle = g.motion[large].position + (R + 0.5 * gap) * way;
    const Vec3 arm = middle - g.motion[small].position;
    CHECK((g.force[small] + g.force[large]).norm() <= 1e-14 * g.force[small].norm());
    return {g.force[small], g.torque[small] - arm.cross(g.force[small])};
  }
};

constexpr double w = 1e-9, angle = 1e-6;

}  // namespace

TEST_CASE("two spheres are bonded by a rod: tension, shear, bending and twist in closed form, and their energies") {
  const auto energy = [](const Pair2& p) { return stored_energy(p.state.bonds); };
  {
    Pair2 p(rods_of());
    REQUIRE(p.state.bonds.face.row.size() == 1);
    const Felt none = p.felt();
    CHECK((none.force.norm() < 1e-12 && none.couple.norm() < 1e-15));
    p.move(w * way, 0, way);
    const Felt f = p.felt();
    CHECK((f.force + kn * area * w * way).norm() < 1e-6 * kn * area * w);
    CHECK(energy(p) == Approx(0.5 * kn * area * w * w).epsilon(1e-6));
    p.move(-2 * w * way, 0, way);  // pressed as it is drawn: the contact is beside it
    CHECK((p.felt().force - kn * area * w * way).norm() < 1e-6 * kn * area * w);
  }
  {
    Pair2 p(rods_of());
    p.move(w * side, 0, way);
    const Felt f = p.felt();
    CHECK((f.force + kt * area * w * side).norm() < 1e-6 * kt * area * w);
    CHECK(energy(p) == Approx(0.5 * kt * area * w * w).epsilon(1e-6));
  }
  {
    Pair2 p(rods_of());
    p.move(Vec3::Zero(), angle, side);
    const Felt f = p.felt();
    CHECK((f.couple + kn * inertia * angle * side).norm() < 1e-5 * kn * inertia * angle);
    CHECK(energy(p) == Approx(0.5 * kn * inertia * angle * angle).epsilon(1e-5));
  }
  {
    Pair2 p(rods_of());
    p.move(Vec3::Zero(), angle, way);
    const Felt f = p.felt();
    CHECK((f.couple + kt * twist * angle * way).norm() < 1e-5 * kt * twist * angle);
    CHECK(energy(p) == Approx(0.5 * kt * twist * angle * angle).epsilon(1e-5));
  }
}

TEST_CASE("a rod breaks at its rim's stress, F/A + M r/I or V/A + T r/J, and takes all that it held") {
  struct Case {
    Vec3 shift;
    double angle;
    Vec3 axis;
    double tension, shear;  // Pa, at the rim
  };
  const double press = 3 * kn * w, phi = 0.5;
  const Case cases[] = {{w * way, 0, way, kn * w, 1e300},
                        {w * side, 0, way, 1e300, kt * w},
                        {Vec3::Zero(), angle, side, kn * radius * angle, 1e300},
                        {Vec3::Zero(), angle, way, 1e300, kt * radius * angle},
                        {w * way, angle, side, kn * (w + radius * angle), 1e300},
                        {w * side, angle, way, 1e300, kt * (w + radius * angle)},
                        {w * side - 3 * w * way, 0, way, 1e300, kt * w - std::tan(phi) * press}};
  for (const Case& c : cases)
    for (const double share : {1.001, 0.999}) {
      const bool pressed = c.shift.dot(way) < 0;
      Model model =
          rods_of(c.tension > 1e200 ? 1e300 : share * c.tension, c.shear > 1e200 ? 1e300 : share * std::abs(c.shear));
      if (pressed)
        model.materials[0].bond->cohesion = 0.5 * share * kt * w,
        model.materials[0].bond->tan_phi = 0.5 * kt * w / press * share;
      Pair2 p(model);
      p.move(c.shift, c.angle, c.axis);
      Pair2 whole(rods_of());
      whole.move(c.shift, c.angle, c.axis);
      whole.felt();
      const Felt f = p.felt();
      const bool breaks = share < 1;
      CHECK((f.force.norm() + f.couple.norm() == 0) == breaks);
      CHECK(p.state.bonds.face.row.size() == (breaks ? 0u : 1u));
      CHECK(p.state.ledger.fracture == Approx(breaks ? stored_energy(whole.state.bonds) : 0).epsilon(1e-9));
      if (!breaks) continue;
      REQUIRE(p.state.bonds.handed.size() == 1);
      book_broken(p.state, true);
      CHECK((p.state.bonds.handed.empty() && p.state.reference.stale == State().reference.stale));
      CHECK(p.state.ledger.handed + p.state.ledger.unexplained == 0);
      REQUIRE(p.state.bonds.broken.size() == 1);
      const bool shears = c.tension > 1e200;
      if (c.shift.isZero(0) || c.angle == 0) CHECK((p.state.bonds.broken[0].sliding > 0.5) == (shears && !pressed));
      CHECK(p.state.bonds.broken[0].area == Approx(area));
    }
}

TEST_CASE("spheres are bonded up to the gap, within their body, through a cell's side, as stiff as half of each") {
  Model model = rods_of();
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3(20 * S, 20 * S, 20 * S);
  const auto at = [](double x) { return Sphere{Vec3(x * S, 5 * S, 5 * S), S}; };
  // Gaps of 0.05, 0.15 and, across the side, -0.05; for the large one, far from all, neighbours are looked for further.
  recipe.grains = Spheres{{at(1), at(3.05), at(5.2), at(19.05), Sphere{Vec3(10 * S, 15 * S, 15 * S), 3 * S}}};
  Team alone(1);
  const Sample made = make(model, recipe, alone);
  REQUIRE(made.state.bonds.face.row.size() == 2);
  CHECK(made.faces->bonds == 2);
  std::size_t across = 0;
  for (const FaceBond& b : made.state.bonds.face.row) {
    across += b.ends.image[0] != 0;
    const double apart = b.ends.image[0] != 0 ? 1.95 : 2.05;
    CHECK(b.kn == Approx(E / (apart * S)));
    CHECK(branch(made.state.grains, made.state.boundary.cell, b.ends).norm() == Approx(apart * S));
  }
  CHECK(across == 1);
  model.materials.push_back(model.materials[0]);
  model.materials[1].bond->stiffness = 3 * E, model.materials[1].bond->tension = 1e290;
  make_pair_laws(model);
  recipe.grains = Spheres{.spheres = {at(1), at(3.05)}, .materials = {0, 1}};
  const Sample mixed = make(model, recipe, alone);
  REQUIRE(mixed.state.bonds.face.row.size() == 1);
  CHECK(mixed.state.bonds.face.row[0].kn == Approx(1.5 * E / (2.05 * S)));
  CHECK(mixed.state.bonds.face.row[0].tension == Approx(1e290));
}

TEST_CASE("agglomerates lie in their spheres, are no two alike, and are bonded within themselves alone") {
  Model model = rods_of();
  model.materials[0].bond->gap = 3;  // across to the other one, too
  Recipe recipe;
  recipe.box = Vec3(44 * S, 22 * S, 22 * S);
  Agglomerates a;
  a.parents = Lattice{.hexagonal = false, .radius = 11 * S, .layers = {2, 1, 1}};
  a.radius = {.kind = "uniform", .mean = 1.5 * S, .min = S, .max = 2 * S};
  recipe.grains = a;
  Team alone(1);
  const Sample made = make(model, recipe, alone);
  const Grains& g = made.state.grains;
  const Vec3 middle[] = {Vec3(11, 11, 11) * S, Vec3(33, 11, 11) * S};
  std::array<double, 2> solid{};
  for (std::size_t i = 0; i < g.size(); ++i) {
    const int of = g.motion[i].position.x() > 22 * S;
    CHECK((g.motion[i].position - middle[of]).norm() + g.motion[i].radius <= 11 * S * (1 + 1e-12));
    solid[static_cast<std::size_t>(of)] += std::pow(g.motion[i].radius / (11 * S), 3);
  }
  CHECK(solid[0] != solid[1]);
  for (const double part : solid)
    CHECK((part > 0.3 && part < 0.6));  // 0.6 inside, less where spheres end at the surface
  REQUIRE(made.state.bonds.face.row.size() > 2 * g.size());
  std::size_t near = 0;  // pairs of both that would be bonded
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Motion &one = g.motion[i], &other = g.motion[j];
      const bool apart = (one.position.x() > 22 * S) != (other.position.x() > 22 * S);
      near += apart && (one.position - other.position).norm() <
                           one.radius + other.radius + 3 * std::min(one.radius, other.radius);
    }
  CHECK(near > 0);
  for (const FaceBond& b : made.state.bonds.face.row)
    CHECK((g.motion[b.ends.a].position.x() > 22 * S) == (g.motion[b.ends.b].position.x() > 22 * S));
}

TEST_CASE("a contact goes on beside its rod and after it: times to and fro, and the speed that breaking leaves") {
  constexpr double kc = 4e6, k = E / (2 * S) * pi * S * S;  // N/m, of the contact and of the rod
  Model model = linear_model(kc, 0.4, 2500, 0);
  BondModel& b = model.materials[0].bond.emplace();
  b.criterion = FaceCriterion::rod, b.stiffness = E, b.ratio = ratio, b.cohesion = 1e300;
  const double mass = 2500 * 4 * pi / 3 * S * S * S, reduced = 0.5 * mass, v = 0.02;
  const double most = v * std::sqrt(reduced / k), breaks = 0.6 * most;  // of what the rod would open by
  b.tension = k * breaks / (pi * S * S);
  model.numerics.safety = 0.005;
  Recipe recipe;
  recipe.grains = Spheres{{{Vec3::Zero(), S}, {2 * S * side, S}}};
  Team alone(1);
  State s = make(model, recipe, alone).state;
  REQUIRE(s.bonds.face.row.size() == 1);
  const auto apart = [&] { return (s.grains.motion[1].position - s.grains.motion[0].position).dot(side); };
  const double sign = apart() > 0 ? 1 : -1;
  for (std::size_t i = 0; i < 2; ++i) s.grains.motion[i].velocity = (i == 0 ? 0.5 : -0.5) * v * sign * side;
  prepare(model, s, alone);
  run_for(model, s, 0.5 * pi * std::sqrt(reduced / (k + kc)), alone);
  CHECK(2 * S - sign * apart() == Approx(v * std::sqrt(reduced / (k + kc))).epsilon(2e-3));
  run_for(model, s, 0.5 * pi * std::sqrt(reduced / (k + kc)), alone);
  CHECK(std::abs(sign * apart() - 2 * S) < 0.02 * most);
  const double dt = s.dt;
  run_for(model, s, 0.5 * pi * std::sqrt(reduced / k), alone);
  CHECK(s.bonds.face.row.empty());
  CHECK(s.ledger.bonds_broken == 1);
  CHECK(s.ledger.fracture == Approx(0.5 * k * breaks * breaks).epsilon(0.03));
  const double leaves = (s.grains.motion[1].velocity - s.grains.motion[0].velocity).norm();
  CHECK(0.5 * reduced * leaves * leaves + s.ledger.fracture ==
        Approx(0.5 * reduced * v * v).margin(k * breaks * v * dt));  // a step's work
}
