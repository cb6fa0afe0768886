// SPDX-License-Identifier: LGPL-3.0-or-later
// Benchmarks: one table of measured figures; with a file name, also as CSV.
//   grus_bench [results.csv | quick]
#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <functional>

#include "dem/contact/forces.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/shape/common_normal.hpp"
#include "dem/state/order.hpp"

using namespace grus::dem;

namespace {

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Row {
  std::string work, unit;
  double value, contacts;
};

/// Dense polydisperse spheres in a box, top wall at 500/s: the work that peers are measured on.
State dense_box(Model& model, std::size_t grains) {
  Material sand;
  sand.friction = 0.5, sand.restitution = 0.5;
  model.materials = {sand};
  model.numerics.time_step = 2e-8;
  model.motion.turn_spheres = false;
  make_pair_laws(model);
  const double fraction = 0.55, size = std::cbrt(static_cast<double>(grains) * 1.225e-10 / fraction);
  const Packing packing = random_packing(Vec3::Constant(size), {"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4}, fraction, grains, false, 1);
  State state;
  for (const auto& s : packing.spheres)
    set_grain(state.grains, state.grains.size(), {.shape = PolyEllipsoid::sphere(s.radius), .position = s.position, .density = 2650});
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      Wall wall;
      wall.normal = Vec3::Zero(), wall.point = Vec3::Zero();
      wall.normal[k] = side ? -1 : 1;
      if (side) wall.point[k] = size;
      if (side && k == 2) wall.velocity = Vec3(0, 0, -500 * size);
      state.boundary.walls.push_back(wall);
    }
  return state;
}

Row dense(std::size_t grains, int threads, std::uint64_t steps, double strain) {
  Model model;
  State state = dense_box(model, grains);
  Team team(threads);
  prepare(model, state, team);
  run_steps(model, state, static_cast<std::uint64_t>(strain / 500 / state.dt), team);
  double best = INFINITY;
  for (int repeat = 0; repeat < 3; ++repeat) {
    State copy = state;
    best = std::min(best, seconds([&] { run_steps(model, copy, steps, team); }));
  }
  const Measurement m = measure(model, state);
  return {fmt::format("dense Hertz-Mindlin spheres, {} grains, {} thread(s)", grains, threads), "1e6 grain-steps/s",
          static_cast<double>(grains) * static_cast<double>(steps) / best / 1e6, static_cast<double>(m.contacts) / static_cast<double>(grains)};
}

Row warm_pair() {
  std::vector<ShapePair> pairs;
  std::vector<PolyEllipsoid> shapes;
  shapes.reserve(2048);
  std::vector<Vec3> normals;
  for (std::uint64_t i = 0; i < 1024; ++i) {
    for (int k = 0; k < 2; ++k) {
      PolyEllipsoid s;
      for (int a = 0; a < 3; ++a) {
        s.plus[a] = 0.6 + 0.4 * random_uniform(1, 2 * i + k, Purpose::radius, 2 * a);
        s.minus[a] = 0.6 + 0.4 * random_uniform(1, 2 * i + k, Purpose::radius, 2 * a + 1);
      }
      shapes.push_back(halves(s, static_cast<int>(i % 3), 0.1)[0].shape);
    }
    const Mat3 r = random_rotation(2, i).toRotationMatrix();
    const Vec3 n = random_rotation(3, i) * Vec3(1, 0, 0);
    ShapePair p{shapes[2 * i], shapes[2 * i + 1], r, Vec3::Zero()};
    p.r = support(p.a, n) - r * support(p.b, r.transpose() * -n) - 1e-3 * n;
    pairs.push_back(p);
    normals.push_back((n + 1e-4 * (random_rotation(4, i) * Vec3(1, 0, 0))).normalized());
  }
  double sum = 0, best = INFINITY;
  for (int repeat = 0; repeat < 5; ++repeat)
    best = std::min(best, seconds([&] {
                      for (int round = 0; round < 20; ++round)
                        for (std::size_t i = 0; i < pairs.size(); ++i) sum += warm_common_normal(pairs[i], normals[i]).overlap;
                    }));
  if (!(sum > 0)) fmt::print("no overlaps: the benchmark is broken\n");
  return {"poly-ellipsoid pair, warm start 1e-4 rad stale", "ns", best / (20.0 * static_cast<double>(pairs.size())) * 1e9, 1};
}

/// The peers' own packing ("N L", then "x y z r") and loading.
int packed(const char* file, std::uint64_t steps, int threads, double skin) {
  std::ifstream in(file);
  std::size_t n;
  double size;
  in >> n >> size;
  Model model;
  Material sand;
  sand.friction = 0.5, sand.restitution = 0.5;
  model.materials = {sand};
  model.numerics.time_step = 2e-8;
  model.motion.turn_spheres = false;
  model.numerics.skin = skin;
  make_pair_laws(model);
  State fresh;
  Vec3 x;
  double r;
  while (in >> x[0] >> x[1] >> x[2] >> r)
    set_grain(fresh.grains, fresh.grains.size(), {.shape = PolyEllipsoid::sphere(r), .position = x, .density = 2650});
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      Wall wall;
      wall.normal = Vec3::Zero(), wall.point = Vec3::Zero();
      wall.normal[k] = side ? -1 : 1;
      if (side) wall.point[k] = size;
      if (side && k == 2) wall.velocity = Vec3(0, 0, -500 * size);
      fresh.boundary.walls.push_back(wall);
    }
  Team team(threads);
  sort_in_space(fresh.grains);
  double best = INFINITY;
  Measurement m;
  for (int repeat = 0; repeat < 3; ++repeat) {
    State state = fresh;
    prepare(model, state, team);
    run_steps(model, state, 100, team);
    best = std::min(best, seconds([&] { run_steps(model, state, steps, team); }));
    m = measure(model, state);
  }
  fmt::print("{} grains {} threads: {:.3f} M grain-steps/s, Z {:.3f}, top {:.4g} MPa, szz {:.4g}\n", n, threads,
             static_cast<double>(n * steps) / best / 1e6, 2.0 * static_cast<double>(m.contacts) / static_cast<double>(n), -m.wall_stress(2, 2) / 1e6, -m.stress(2, 2) / 1e6);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Row> rows;
  if (argc > 3 && std::string(argv[1]) == "w1") return packed(argv[2], std::stoul(argv[3]), argc > 4 ? std::stoi(argv[4]) : 1, argc > 5 ? std::stod(argv[5]) : 0.12);
  if (argc > 1 && std::string(argv[1]) == "quick") {
    const Row r = dense(1000, 1, 4000, 0.12);
    fmt::print("{:.3f} million grain-steps/s, {:.2f} contacts a grain; warm pair {:.0f} ns\n", r.value, r.contacts, warm_pair().value);
    return 0;
  }
  rows.push_back(dense(1000, 1, 4000, 0.12));
  rows.push_back(dense(1000, 2, 4000, 0.12));
  rows.push_back(dense(10000, 1, 400, 0.12));
  rows.push_back(dense(10000, 2, 400, 0.12));
  rows.push_back(warm_pair());
  fmt::print("{:<62} {:>12} {:<20} {}\n", "work", "figure", "unit", "contacts a grain");
  for (const auto& r : rows) fmt::print("{:<62} {:>12.3f} {:<20} {:.2f}\n", r.work, r.value, r.unit, r.contacts);
  if (argc > 1) {
    std::ofstream csv(argv[1]);
    csv << "work,figure,unit,contacts_a_grain\n";
    for (const auto& r : rows) csv << fmt::format("\"{}\",{:.6g},{},{:.3f}\n", r.work, r.value, r.unit, r.contacts);
  }
}
