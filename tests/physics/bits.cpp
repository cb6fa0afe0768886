// SPDX-License-Identifier: LGPL-3.0-or-later
// Three small runs whose every bit is known: for any number of threads, width of the kernels and compiler.
#include "dem/packing/packing.hpp"
#include "dem/rve/state_hash.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// Grains on a cubic grid a little closer than touching, each with its own speed, spin and, if asked, shape.
State crowd(int n, bool shapes, bool periodic) {
  State s;
  const double r = 3e-4, pitch = 1.97 * r;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(n * n * n); ++i) {
    const auto m = static_cast<std::uint64_t>(n);
    const Vec3 x = pitch * Vec3(0.5 + static_cast<double>(i % m), 0.5 + static_cast<double>(i / m % m),
                                0.5 + static_cast<double>(i / (m * m)));
    PolyEllipsoid shape = PolyEllipsoid::sphere(r);
    if (shapes && i % 2) shape = random_shape(3, i, 0.8, 1.1), shape.plus *= r, shape.minus *= r;
    Vec3 v, w;
    for (int k = 0; k < 3; ++k) {
      v[k] = 2 * random_uniform(4, i, Purpose::position, static_cast<std::uint64_t>(k)) - 1;
      w[k] = 4000 * random_uniform(5, i, Purpose::position, static_cast<std::uint64_t>(k)) - 2000;
    }
    add(s, shape, x, 2650, v, w);
  }
  if (periodic)
    s.boundary.cell.vectors = n * pitch * Mat3::Identity();
  else
    add_box(s, n * pitch);
  return s;
}

std::uint64_t after(const Model& model, State s, std::uint64_t steps, int threads, const Mat3& rate,
                    std::size_t& breakages) {
  Team team(threads);
  prepare(model, s, team);
  if (!rate.isZero(0)) set_cell_rate(s, rate * s.boundary.cell.vectors);
  for (std::uint64_t done = 0; done < steps;)
    update_time_step(model, s), done += run_steps(model, s, std::min<std::uint64_t>(50, steps - done), team);
  breakages = s.ledger.breakages;
  return hash(s);
}

}  // namespace

// Who changes what a run does changes these numbers; who does not, must not.
TEST_CASE("three small runs end in known bits") {
  Material m = solid(60e9, 0.17, 2650, 0.5, 0.6);
  m.damping = 0.1;
  Material brittle = m;
  brittle.fracture = FractureModel{};
  brittle.fracture->criteria.emplace_back(HoekBrown{60e6, 20.56});
  brittle.fracture->strength_law = Weibull{3.1, 3e-4, 3 / 3.1};
  brittle.fracture->springs = CohesiveSprings{4, 1.77e6};
  Mat3 shear = Mat3::Zero();
  shear(0, 2) = 3000, shear(2, 2) = -2000;
  std::size_t breakages = 0;
  for (const int threads : {1, 2, 3}) {
    INFO("threads " << threads);
    CHECK(after(model_of(m), crowd(6, false, true), 400, threads, shear, breakages) == 0xd86c7cae63f5c9d8);
    CHECK(after(model_of(m), crowd(6, true, false), 400, threads, Mat3::Zero(), breakages) == 0x77c626a86562fb41);
    CHECK(after(model_of(brittle), crowd(5, false, true), 600, threads, shear, breakages) == 0x0e9dcfbcba3bf735);
    CHECK(breakages == 128);
  }
}
