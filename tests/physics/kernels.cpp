// SPDX-License-Identifier: LGPL-3.0-or-later
// The vector kernels against the plain form of the same physics, one contact at a time; and what the step loop costs.
#include <atomic>
#include <cstdlib>
#include <new>

#include "dem/base/error.hpp"
#include "dem/contact/forces.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/step.hpp"
#include "dem/state/order.hpp"
#include "tests/hulls.hpp"
#include "tests/physics/plain_contacts.hpp"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t n) {
  ++allocations;
  if (void* p = std::malloc(n)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t n, std::align_val_t a) {
  ++allocations;
  const std::size_t align = static_cast<std::size_t>(a);
  if (void* p = std::aligned_alloc(align, (n + align - 1) / align * align)) return p;
  throw std::bad_alloc();
}
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A dense sheared cell or a box being closed: two materials, friction and dashpots, every third grain a half.
struct Case {
  Model model;
  State state;
  Team team{1};
};

/// `work`: of adhesion (J/m^2); above 0 the law is JKR's.
void make(Case& c, bool periodic, bool shapes, bool friction, bool dashpot, bool hertz, double rolling = 0,
          double work = 0) {
  Model& model = c.model;
  Material hard, soft;
  hard.friction = friction ? 0.3 : 0, hard.restitution = dashpot ? 0.5 : 1;
  soft = hard;
  soft.youngs_modulus = 20e9, soft.friction = friction ? 0.5 : 0;
  hard.rolling_friction = rolling, soft.rolling_friction = 1.5 * rolling;
  hard.contact = LinearSpring::Of{.stiffness = 2e6, .shear_ratio = 0.8};
  soft.contact = LinearSpring::Of{.stiffness = 1e6, .shear_ratio = 0.8};
  if (work > 0) model.law = Jkr{}, hard.contact = Jkr::Of{work}, soft.contact = Jkr::Of{2 * work};
  model.materials = {hard, soft};
  if (!hertz) model.law = LinearSpring{};
  model.numerics.time_step = 3e-8;
  make_pair_laws(model);
  const std::size_t n = 300;
  const double fraction = 0.55, size = std::cbrt(static_cast<double>(n) * 1.225e-10 / fraction);
  const Packing packing =
      random_packing(Vec3::Constant(size), {"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4}, fraction, n, periodic, 7);
  Grains& g = c.state.grains;
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const auto& s = packing.spheres[i];
    PolyEllipsoid shape = PolyEllipsoid::sphere(s.radius);
    if (shapes && i % 3 == 0)
      for (int k = 0; k < 3; ++k)
        shape.plus[k] *= 0.8 + 0.2 * random_uniform(3, i, Purpose::radius, static_cast<std::uint64_t>(k)),
            shape.minus[k] *= 0.8 + 0.2 * random_uniform(4, i, Purpose::radius, static_cast<std::uint64_t>(k));
    set_grain(g, g.size(),
              {.shape = shape,
               .position = s.position,
               .orientation = random_rotation(5, i),
               .material = static_cast<std::uint8_t>(i % 2),
               .density = 2650});
  }
  sort_in_space(g);
  const double squeeze = 2000;  // 1/s
  if (periodic) {
    c.state.boundary.cell.vectors = size * Mat3::Identity();
  } else {
    for (int k = 0; k < 3; ++k)
      for (int side = 0; side < 2; ++side) {
        Wall wall;
        wall.shape = PlaneWall{(side ? -1 : 1) * Vec3::Unit(k)};
        if (side) wall.point[k] = size, wall.velocity[k] = -squeeze * size;
        c.state.boundary.walls.push_back(wall);
      }
  }
  prepare(model, c.state, c.team);
  if (periodic) set_cell_rate(c.state, -squeeze * size * Mat3::Identity());
  run_steps(model, c.state, shapes ? 1500 : 900, c.team);
  const double on = work > 0 ? -0.5 : 0.1;  // what attracts is drawn
  for (auto& wall : c.state.boundary.walls) wall.velocity *= on;
  if (periodic) {
    Mat3 rate = Mat3::Zero();
    rate.diagonal() = Vec3(-100, 50, -200) * size, rate(0, 1) = 100 * size;
    if (work > 0) rate.diagonal().setConstant(1000 * size);
    set_cell_rate(c.state, rate);
  }
}

/// What grain i has collected, from its own tile and from others.
Load collected(const Contacts& c, std::size_t i) {
  Load sum = c.plan.load[i];
  for (Index e = c.plan.remote[i]; e < c.plan.remote[i + 1]; ++e) {
    const Load& elsewhere = c.plan.load[c.plan.remote_row[e]];
    sum.force += elsewhere.force, sum.torque += elsewhere.torque;
  }
  return sum;
}

void compare(Case& c) {
  const State before = c.state;
  const Plain plain = plain_pass(c.model, before, c.state.dt);
  State& s = c.state;
  flush(s.contacts);
  contact_forces(c.model.law, c.model.pairs, s.grains, s.boundary, s.dt, true, s.contacts, c.team);
  double scale = 0, arm = 0;
  for (const auto& t : plain.touch) scale = std::max(scale, t.force.norm());
  for (const auto& m : s.grains.motion) arm = std::max(arm, m.radius);
  REQUIRE(scale > 0);
  std::size_t touching = 0, sliding = 0, rolling = 0, drawn = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Contact p = plain.contact[k], q = s.contacts.contact[k];
    INFO("pair " << k << ", walls from " << s.contacts.begin[first_wall] << ", poly-ellipsoids from "
                 << s.contacts.begin[general]);
    // The search for a common normal stops at a gradient of 1e-6 of the pair's four semi-axes: 1e-5 rad at most.
    const double tolerance =
        (k >= s.contacts.begin[general] && k < s.contacts.begin[first_wall] ? 1e-5 : 1e-12) * scale;
    if (p.stiffness > 0 && std::abs(plain.touch[k].overlap) < 1e-6 * arm) continue;  // just born: round-off decides
    drawn += p.stiffness > 0 && plain.touch[k].overlap < 0;
    REQUIRE((p.stiffness > 0) == (q.stiffness > 0));
    REQUIRE((plain.touch[k].force - s.contacts.touch[k].force).norm() <= tolerance);
    if (p.stiffness == 0) continue;
    ++touching;
    const PairLaw& law = c.model.pairs[s.contacts.pair[k].law];
    sliding += law.friction[slide_spring] > 0 &&
               q.spring[slide_spring].norm() >
                   0.999 * law.friction[slide_spring] * s.contacts.touch[k].force.dot(s.contacts.touch[k].normal);
    REQUIRE(p.stiffness == Approx(q.stiffness).epsilon(1e-7));
    REQUIRE((p.spring[slide_spring] - q.spring[slide_spring]).norm() <= tolerance);
    REQUIRE((p.spring[roll_spring] - q.spring[roll_spring]).norm() <= tolerance);
    rolling += law.friction[roll_spring] > 0 &&
               q.spring[roll_spring].norm() >
                   0.999 * law.friction[roll_spring] * s.contacts.touch[k].force.dot(s.contacts.touch[k].normal);
    REQUIRE(p.compliance == Approx(q.compliance).epsilon(1e-6));
  }
  CHECK(touching > s.grains.size());
  INFO("drawn " << drawn);
  CHECK((drawn > 3) == attracts(c.model.law));
  if (c.model.pairs[0].friction[slide_spring] > 0) CHECK(sliding > 0);
  if (c.model.springs()[roll_spring]) CHECK((rolling > 10 && rolling < touching - 10));
  for (std::size_t i = 0; i < s.grains.size(); ++i) {
    const Load load = collected(s.contacts, i);
    const double tolerance = s.grains.frame.empty() ? 1e-11 : 1e-4;  // of some ten contacts
    REQUIRE((load.force - plain.load[i].force).norm() <= tolerance * scale);
    REQUIRE((load.torque - plain.load[i].torque).norm() <= tolerance * scale * arm);
  }
  const BlockEnergy energy = flush(s.contacts);
  CHECK(energy.friction == Approx(plain.energy.friction).epsilon(1e-6).margin(1e-12 * scale * arm));
  CHECK(energy.adhesion == Approx(plain.energy.adhesion).epsilon(1e-12));
  CHECK(energy.viscous == Approx(plain.energy.viscous).epsilon(1e-6).margin(1e-12 * scale * arm));
  CHECK(energy.work == Approx(-s.dt * plain.power).epsilon(1e-7).margin(1e-12 * scale * arm));
  s = before;
}

/// A torque-free body after dt: symmetric-top splitting.
Quat freely_turned(const Quat& orientation, const Inertia& inertia, const Vec3& momentum, double dt) {
  const Vec3& I = inertia.moments;
  const double split = 1 / I.x() - 1 / I.y(), spin = 1 / I.z() - 1 / I.y();
  Quat q = orientation * inertia.axes;
  auto about_x = [&] {
    if (split == 0) return;
    const double p = (q.conjugate() * momentum).x();
    q = q * rotation_by({0.5 * dt * p * split, 0, 0});
  };
  about_x();
  const double pz = (q.conjugate() * momentum).z();  // a top keeps it
  q = rotation_by(dt / I.y() * momentum) * q * rotation_by({0, 0, dt * pz * spin});
  about_x();
  return unit(q * inertia.axes.conjugate());
}

/// What a sweep does to a grain with this force and torque, half kick by half kick; `lost` and `won`: J.
struct PlainGrain {
  Motion motion;
  Quat orientation;
  Vec3 momentum;
  double lost = 0, won = 0;

  void half_kick(const Grains& g, std::size_t i, const MotionSettings& s, Vec3 force, Vec3 torque, double h) {
    const double damping = s.damping.empty() ? 0 : s.damping[g.material[i]];
    auto opposing = [&](const Vec3& f, const Vec3& v) {
      return v.isZero(0) ? Vec3(Vec3::Zero()) : Vec3(-damping * f.norm() * v.normalized());
    };
    const Vec3 df = opposing(force, motion.velocity - s.affine * motion.position), dm = opposing(torque, motion.spin);
    force += df, torque += dm;
    const Vec3 between = motion.velocity + 0.5 * h * motion.inverse_mass * force;
    lost -= h * (df.dot(between) + dm.dot(motion.spin));
    won += h * g.mass[i] * s.gravity.dot(between);
    motion.velocity += h * motion.inverse_mass * force;
    momentum += h * torque;
    spin(g, i);
  }
  void spin(const Grains& g, std::size_t i) {
    const Quat q = orientation * g.inertia[i].axes;
    motion.spin = q * (q.conjugate() * momentum).cwiseQuotient(g.inertia[i].moments);
  }
  void drift(const Grains& g, std::size_t i, double dt) {
    motion.position += dt * motion.velocity;
    orientation = freely_turned(orientation, g.inertia[i], momentum, dt);
    spin(g, i);
  }
};

}  // namespace

TEST_CASE("kicks and turns of many grains at a time are those of one") {
  for (const int variant : {0, 1, 2, 3, 4})
    for (const Kick kick : {Kick::close, Kick::open, Kick::both}) {
      INFO("variant " << variant << ", kick " << static_cast<int>(kick));
      Case c;
      make(c, variant == 2, true, true, true, true);
      Grains& g = c.state.grains;
      MotionSettings settings;
      const std::vector<double> damping{0.4, 0.1, 0.25};  // each grain by its own material
      if (variant == 1 || variant == 4) settings.damping = damping;
      if (variant == 2) settings.affine = 300 * Mat3(Mat3::Identity() + cross_matrix({1, 2, 3}));
      if (variant == 3 || variant == 4) settings.gravity = Vec3(3e4, -2e4, 5e4);
      const bool bonded = variant == 4;
      const double dt = 1e-7;
      for (std::size_t i = 0; i < g.size(); ++i) {
        if (is_sphere(g, i))
          g.angular_momentum[i] = g.motion[i].spin / g.motion[i].inverse_inertia;
        else if (i % 5 == 0)
          g.angular_momentum[i] *= 3e6 / (1 + g.motion[i].spin.norm()),
              g.motion[i].spin = spin_of(g, i);  // 0.3 rad a step
      }
      contact_forces(c.model.law, c.model.pairs, g, c.state.boundary, c.state.dt, true, c.state.contacts, c.team);
      std::vector<PlainGrain> plain;
      double lost = 0, won = 0;
      for (std::size_t i = 0; i < g.size(); ++i) {
        Vec3 force = bonded || kick == Kick::open ? g.force[i] : Vec3(Vec3::Zero()),
             torque = bonded || kick == Kick::open ? g.torque[i] : Vec3(Vec3::Zero());
        if (kick != Kick::open) {
          const Load load = collected(c.state.contacts, i);
          force += load.force + g.mass[i] * settings.gravity, torque += load.torque;
        }
        PlainGrain p{g.motion[i], g.orientation[i], g.angular_momentum[i]};
        if (kick != Kick::open) p.half_kick(g, i, settings, force, torque, 0.5 * dt);
        if (kick != Kick::close) p.half_kick(g, i, settings, force, torque, 0.5 * dt), p.drift(g, i, dt);
        lost += p.lost, won += p.won;
        plain.push_back(p);
      }
      std::vector<SweepEnergy> energy;
      sweep(kick, g, c.state.contacts, settings, bonded, dt, energy, c.team);
      SweepEnergy spent;
      for (const auto& e : energy) spent.viscous += e.viscous, spent.work += e.work;
      CHECK(spent.viscous == Approx(lost).epsilon(1e-10));
      CHECK(spent.work == Approx(won).epsilon(1e-10));
      std::size_t bodies = 0;
      for (std::size_t i = 0; i < g.size(); ++i) {
        INFO("grain " << i << " round " << int(is_sphere(g, i)));
        const PlainGrain& p = plain[i];
        const double speed = p.motion.velocity.norm() + p.motion.radius * p.motion.spin.norm();
        REQUIRE((g.motion[i].position - p.motion.position).norm() <= 1e-12 * p.motion.radius);
        REQUIRE((g.motion[i].velocity - p.motion.velocity).norm() <= 1e-12 * speed);
        REQUIRE((g.motion[i].spin - p.motion.spin).norm() * p.motion.radius <= 1e-11 * speed);
        REQUIRE(g.motion[i].inverse_inertia == p.motion.inverse_inertia);
        REQUIRE((g.orientation[i].coeffs() - p.orientation.coeffs()).norm() < 1e-13);
        bodies += !is_sphere(g, i);
        if (!is_sphere(g, i)) REQUIRE((g.angular_momentum[i] - p.momentum).norm() <= 1e-12 * p.momentum.norm());
        if (kick == Kick::close) continue;
        const Frame frame = frame_of(g, i);
        REQUIRE((g.frame[i].origin - frame.origin).norm() <= 1e-13 * p.motion.radius);
        REQUIRE((g.frame[i].axes - frame.axes).norm() <= 1e-13);
      }
      CHECK(bodies > 50);
    }
}

TEST_CASE("vector kernels do what one contact at a time does") {
  for (const bool periodic : {true, false})
    for (const bool shapes : {false, true})
      for (const int variant : {0, 1, 2, 3, 4, 5, 6, 7}) {
        if (shapes && variant > 4) continue;  // attraction is of spheres
        INFO("periodic " << periodic << ", shapes " << shapes << ", variant " << variant);
        Case c;
        make(c, periodic, shapes, variant != 1 && variant != 6, variant != 2 && variant != 7, variant != 3,
             variant == 4 || variant == 5 ? 0.1 : 0, variant > 4 ? 5000 : 0);
        for (int stage = 0; stage < 3; ++stage) {
          run_steps(c.model, c.state, 150, c.team);
          // A state in the middle of a step: positions of now, velocities of half a step before.
          sweep(Kick::open, c.state.grains, c.state.contacts, c.model.motion, false, c.state.dt, c.state.grain_energy,
                c.team);
          compare(c);
        }
      }
}

TEST_CASE("a step allocates nothing") {
  for (const bool shapes : {false, true}) {
    Case c;
    make(c, true, shapes, true, true, true);
    run_steps(c.model, c.state, 400, c.team);
    build_contacts(c.state.grains, c.state.boundary, c.state.skin, 2, {}, c.state.contacts, c.state.reference, c.team);
    FractureModel tested;  // every fifth step, and never reached
    tested.criteria.emplace_back(HoekBrown{1e15, 20});
    for (auto& m : c.model.materials) m.fracture = tested;
    c.model.numerics.fracture_every = 5;
    c.state.grains.strength.assign(c.state.grains.size(), 1),
        c.state.grains.generation.assign(c.state.grains.size(), 0),
        c.state.grains.utilisation.assign(c.state.grains.size(), NAN);
    run_steps(c.model, c.state, 6, c.team);
    build_contacts(c.state.grains, c.state.boundary, c.state.skin, 2, {}, c.state.contacts, c.state.reference, c.team);
    const Mat3 built_at = c.state.reference.cell;
    const long before = allocations;
    run_steps(c.model, c.state, 25, c.team);
    CHECK(allocations == before);
    REQUIRE(c.state.reference.cell == built_at);  // the list held
  }
}

TEST_CASE("a step of hulls that sleep allocates nothing") {
  Team team(1);
  Model model = hull_model(0.5);
  model.numerics.time_step = 1e-4, model.numerics.skin = 0.5;
  State s;
  for (std::uint64_t i = 0; i < 27; ++i)
    add_body(s, unit_cube(),
             1.6 * Vec3(static_cast<double>(i % 3), static_cast<double>(i / 3 % 3), static_cast<double>(i / 9)),
             random_rotation(2, i), random_rotation(3, i) * Vec3(1, 0, 0));
  prepare(model, s, team);
  run_steps(model, s, 25, team);
  const std::uint64_t lists = s.reference.builds;
  const long before = allocations;
  run_steps(model, s, 25, team);
  CHECK(allocations == before);
  REQUIRE(s.reference.builds == lists);
}

TEST_CASE("rebuilding the list reuses its room") {
  Case c;
  make(c, true, false, true, true, true);
  run_steps(c.model, c.state, 2000, c.team);
  build_contacts(c.state.grains, c.state.boundary, c.state.skin, 2, {}, c.state.contacts, c.state.reference, c.team);
  build_contacts(c.state.grains, c.state.boundary, c.state.skin, 2, {}, c.state.contacts, c.state.reference, c.team);
  const long before = allocations;
  build_contacts(c.state.grains, c.state.boundary, c.state.skin, 2, {}, c.state.contacts, c.state.reference, c.team);
  CHECK(allocations - before <= 1);
}
