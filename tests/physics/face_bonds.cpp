// SPDX-License-Identifier: LGPL-3.0-or-later
// A bond of a face: closed forms, gradients, energies of every mix, criteria.
#include "tests/bonded.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Its corners along e1 and e2.
const std::array<Eigen::Vector2d, 4> corners{Eigen::Vector2d(-1, -0.5), {1, -0.5}, {1, 0.5}, {-1, 0.5}};
const FaceOutline outline{nullptr, corners};

/// A face of 2 x 1 between two bodies, unit distance.
FaceBond face(const BondModel& b) {
  FaceBond s;
  s.ends = {0, 1, {}};
  s.at_a = Vec3(0.5, 0.1, 0), s.at_b = Vec3(-0.5, 0.2, 0.1);
  s.normal = Vec3::UnitX(), s.e1 = Vec3::UnitY(), s.rest = Quat::Identity();
  s.area = 2, s.i1 = 2 * 1 / 12.0, s.i2 = 2 * 4 / 12.0;  // 2 along y
  s.kn = b.stiffness, s.kt = b.ratio * b.stiffness;
  s.tension = b.tension, s.cohesion = b.cohesion, s.tan_phi = b.tan_phi, s.friction = b.friction;
  s.energy_1 = b.energy_1, s.energy_2 = b.energy_2, s.criterion = b.criterion;
  return s;
}

/// Poses of both bodies; `shift` and `turn` of b from the bond's rest.
struct Poses {
  Quat a = Quat::Identity(), b = Quat::Identity();
  Vec3 x_a = Vec3::Zero(), x_b = Vec3(1, -0.1, -0.1);  // where the faces' middles meet

  BondFrame frame() const { return {a, b, x_a, x_b}; }
};

/// The middle of b's face moves by `shift`, b turns about it.
Poses moved(const FaceBond& s, const Vec3& shift, const Vec3& angle) {
  Poses p;
  p.b = rotation_by(angle);
  p.x_b = s.at_a + shift - p.b * s.at_b;
  return p;
}

Pull at(FaceBond& s, const Vec3& shift, const Vec3& angle = Vec3::Zero()) {
  const Poses p = moved(s, shift, angle);
  return pull(s, p.frame(), outline);
}

}  // namespace

TEST_CASE("one face: opening, shear, bending and twist by its area and moments") {
  FaceBond s = face(elastic(0.5));
  CHECK((at(s, Vec3(1e-3, 0, 0)).force - Vec3(-1e-3 * E0 * 2, 0, 0)).norm() < 1e-6);
  CHECK((at(s, Vec3(0, 1e-3, 0)).force - Vec3(0, -0.5e-3 * E0 * 2, 0)).norm() < 1e-6);
  CHECK(at(s, Vec3::Zero(), Vec3(0, 1e-4, 0)).couple.y() == Approx(-1e-4 * E0 / 6).epsilon(1e-6));
  CHECK(at(s, Vec3::Zero(), Vec3(0, 0, 1e-4)).couple.z() == Approx(-1e-4 * E0 * 2 / 3).epsilon(1e-6));
  CHECK(at(s, Vec3::Zero(), Vec3(1e-4, 0, 0)).couple.x() == Approx(-1e-4 * 0.5 * E0 * 5 / 6).epsilon(1e-6));
}

TEST_CASE("force and couple of a face are the gradient of its energy, whatever both bodies do") {
  double worst = 0;
  for (std::uint64_t n = 0; n < 500; ++n) {
    FaceBond s = face(elastic(0.5));
    const auto draw = [&](std::uint64_t c) {
      Vec3 v;
      for (int k = 0; k < 3; ++k) v[k] = random_normal(3, n, Purpose::turn, 3 * c + static_cast<std::uint64_t>(k));
      return v;
    };
    Poses p;
    p.a = random_rotation(n, 1), p.b = rotation_by(0.2 * draw(0)) * p.a;
    p.x_b = p.a * p.x_b + 0.05 * draw(1);
    const Pull found = pull(s, p.frame(), outline);
    const auto energy_of = [&](const Vec3& shift_a, const Vec3& turn_a, const Vec3& shift_b, const Vec3& turn_b) {
      Poses q = p;
      q.a = rotation_by(turn_a) * p.a, q.b = rotation_by(turn_b) * p.b, q.x_a += shift_a, q.x_b += shift_b;
      FaceBond copy = s;
      pull(copy, q.frame(), outline);
      return energy(copy);
    };
    const double h = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Vec3 d = h * Vec3::Unit(k), o = Vec3::Zero();
      const double on_a = -(energy_of(d, o, o, o) - energy_of(-d, o, o, o)) / (2 * h);
      const double on_b = -(energy_of(o, o, d, o) - energy_of(o, o, -d, o)) / (2 * h);
      const double turn_a = -(energy_of(o, d, o, o) - energy_of(o, -d, o, o)) / (2 * h);
      const double turn_b = -(energy_of(o, o, o, d) - energy_of(o, o, o, -d)) / (2 * h);
      worst = std::max({worst, std::abs(on_a + found.force[k]), std::abs(on_b - found.force[k])});
      worst = std::max(worst, std::abs(turn_a + (found.arm_a.cross(found.force) + found.couple)[k]));
      worst = std::max(worst, std::abs(turn_b - (found.arm_b.cross(found.force) + found.couple)[k]));
    }
  }
  CHECK(worst < 1e-6 * E0);
}

TEST_CASE("a cohesive face carries sigma_t A, starts to give way in bending at sigma_t sqrt(I A) / 2, and takes G A") {
  const BondModel b = cohesive(1e6, 4e3);
  const auto drawn = [&](const Vec3& way, const Vec3& angle, double& peak) {
    FaceBond s = face(b);
    double work = 0;
    Vec3 force = Vec3::Zero();
    peak = 0;
    constexpr int steps = 40000;
    for (int k = 1; k <= steps && !broken(s); ++k) {
      const Pull p = at(s, k / double{steps} * way, k / double{steps} * angle);
      const Vec3 load = p.force + (angle.norm() > 0 ? Vec3(p.couple) : Vec3(Vec3::Zero()));
      work -= 0.5 * (force + load).dot(way + angle) / steps;
      force = load, peak = std::max(peak, load.norm());
    }
    CHECK(broken(s));
    CHECK(energy(s) == Approx(0).margin(1e-9));
    CHECK(work == Approx(dissipated(s)).epsilon(1e-3));
    return dissipated(s);
  };
  double peak;
  CHECK(drawn(Vec3(0.02, 0, 0), Vec3::Zero(), peak) == Approx(2 * 4e3).epsilon(1e-4));
  CHECK(peak == Approx(2e6).epsilon(1e-3));
  CHECK(drawn(Vec3(0, 0, 0.05), Vec3::Zero(), peak) == Approx(2 * 12e3).epsilon(5e-4));  // begins within a step
  CHECK(peak == Approx(4e6).epsilon(1e-3));
  CHECK(drawn(Vec3(0.02, 0.01, 0), Vec3::Zero(), peak) > 2 * 4e3);
  // The rim is at sigma_t when the moment is sigma_t sqrt(I A) / 2: that is where it begins, not the peak.
  FaceBond s = face(b);
  const double angle = 1e6 * std::sqrt(s.i2 * s.area) / 2 / (E0 * s.i2);
  at(s, Vec3::Zero(), Vec3(0, 0, 0.999 * angle));
  CHECK(s.onset == 0);
  at(s, Vec3::Zero(), Vec3(0, 0, 1.001 * angle));
  CHECK(s.onset > 0);
}

TEST_CASE("pressure is never softened and raises the shear that a face bears") {
  const BondModel b = cohesive(1e6, 4e3);
  const auto begins = [&](double pressed) {
    FaceBond s = face(b);
    for (int k = 1; k < 100000; ++k) {
      at(s, Vec3(-pressed / E0, k * 1e-6, 0));
      if (s.onset > 0) return 0.5 * E0 * k * 1e-6;
    }
    return 0.0;
  };
  CHECK(begins(0) == Approx(2e6).epsilon(1e-3));
  CHECK(begins(5e6) == Approx(2e6 + 0.6 * 5e6).epsilon(1e-3));
  FaceBond s = face(b);
  for (int k = 1; k < 2000; ++k) at(s, Vec3(k * 1e-5, 0, 0));
  CHECK(broken(s));
  CHECK(at(s, Vec3(-1e-3, 0, 0)).force.x() == Approx(1e-3 * E0 * 2));
}

TEST_CASE(
    "what has given way rubs: sheared under pressure to the end, a face ends at Coulomb's limit and its energy is "
    "told") {
  BondModel b = cohesive(1e6, 16e3);
  b.friction = 0.4;
  FaceBond s = face(b);
  const double pressed = 2e6;
  at(s, Vec3(-pressed / E0, 0, 0));
  const double held = energy(s);
  double work = 0, shear = 0, biggest_jump = 0;
  const double step = 2e-6;
  for (int k = 1; k < 60000; ++k) {
    const double now = -at(s, Vec3(-pressed / E0, k * step, 0)).force.y();
    work += 0.5 * (shear + now) * step;
    biggest_jump = std::max(biggest_jump, std::abs(now - shear));
    shear = now;
  }
  CHECK(broken(s));
  CHECK(shear == Approx(0.4 * pressed * 2).epsilon(1e-6));
  CHECK(s.shear.norm() == Approx(shear).epsilon(1e-9));
  CHECK(biggest_jump < 1.01 * E0 * step);  // never more than elastic
  CHECK(work == Approx(energy(s) + dissipated(s) + rubbed(s) - held).epsilon(1e-3));
  // What softening takes is G A, the rubbing is apart: Coulomb's limit over the way that is left of the slip.
  CHECK(dissipated(s) == Approx(2 * 3 * 16e3).epsilon(1e-3));
  CHECK(rubbed(s) > 0.4 * pressed * 2 * 0.05);
}

TEST_CASE("brittle faces break where their criteria say, and give back what they held") {
  BondModel b = elastic(0.5);
  b.criterion = FaceCriterion::parallel, b.tension = 1e6, b.cohesion = 2e6, b.tan_phi = 0.5;
  FaceBond s = face(b);
  at(s, Vec3(0.999e-3, 0, 0));
  CHECK(!broken(s));
  at(s, Vec3(1.001e-3, 0, 0));
  CHECK(broken(s));
  CHECK(dissipated(s) == Approx(0.5 * E0 * 2 * 1.001e-3 * 1.001e-3).epsilon(1e-9));
  CHECK(energy(s) == Approx(0).margin(1e-12));
  s = face(b);
  at(s, Vec3(0, 3.99e-3, 0));
  CHECK(!broken(s));
  at(s, Vec3(0, 4.01e-3, 0));
  CHECK(broken(s));

  b.criterion = FaceCriterion::strain_sum, b.tension = 0.01, b.cohesion = 0.1;  // an opening, an angle
  s = face(b);
  at(s, Vec3(0.004, 0.0059, 0));
  CHECK(!broken(s));
  at(s, Vec3(0.004, 0.0061, 0));
  CHECK(broken(s));
  s = face(b);
  at(s, Vec3(-0.02, 0, 0));
  CHECK(!broken(s));  // pressed: no strain counts
  at(s, Vec3(0.005, 0, 0), Vec3(0, 0.051, 0));
  CHECK(broken(s));
}

TEST_CASE("the share of shear and twist in what parts a face, by closed forms; its normal goes along") {
  FaceBond s = face(elastic(0.5));
  const auto share = [&](const Vec3& shift, const Vec3& angle) {
    const Poses p = moved(s, shift, angle);
    return handed_by(s, p.frame(), outline).sliding;
  };
  CHECK(share(Vec3(1e-3, 0, 0), Vec3::Zero()) == 0);
  CHECK(share(Vec3(1e-3, 2e-3, 1e-3), Vec3::Zero()) == Approx(0.5 * 5 / (1 + 0.5 * 5)));
  CHECK(share(Vec3(-1e-3, 2e-3, 0), Vec3::Zero()) == 1);  // what presses does not part
  CHECK(share(Vec3::Zero(), Vec3(1e-4, 0, 0)) == Approx(1).epsilon(1e-6));
  CHECK(share(Vec3::Zero(), Vec3(0, 1e-4, 0)) == Approx(0).margin(1e-6));
  // Bent about e1 while it opens all over, and twisted: i1 = 1/6, i2 = 2/3, A = 2.
  const double open = 1e-6 + 1e-6 / 12, twist = 0.5 * 0.25e-6 * 5 / 12;
  CHECK(share(Vec3(1e-3, 0, 0), Vec3(5e-4, 1e-3, 0)) == Approx(twist / (open + twist)).epsilon(1e-3));
  CHECK(handed_by(s, moved(s, Vec3::Zero(), Vec3::Zero()).frame(), outline).sliding == 0);  // nothing is parted
  CHECK(handed_by(s, Poses().frame(), outline).normal == Vec3::UnitX());
}
