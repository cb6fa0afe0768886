// SPDX-License-Identifier: LGPL-3.0-or-later
#include "tests/bench/works.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <stdexcept>

#include "dem/contact/forces.hpp"
#include "dem/io/archive.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/step.hpp"
#include "dem/state/order.hpp"

namespace grus::bench {
namespace {

using namespace dem;

template <class F>
double seconds(F&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Model sand() {
  Material m;
  m.friction = 0.5, m.restitution = 0.5;
  Model model;
  model.materials = {m};
  model.motion.turn_spheres = false;
  make_pair_laws(model);
  return model;
}

void add_box(State& state, double size) {
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      Wall wall;
      wall.shape = PlaneWall{(side ? -1 : 1) * Vec3::Unit(k)};
      if (side) wall.point[k] = size;
      state.boundary.walls.push_back(wall);
    }
}

/// "x y z r" of n grains.
void read_grains(std::istream& in, const std::string& file, std::size_t n, Packing& p) {
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 x;
    double r;
    if (!(in >> x[0] >> x[1] >> x[2] >> r))
      throw std::runtime_error(fmt::format("{}: ends after {} of {} grains", file, i, n));
    p.centre.push_back(x), p.radius.push_back(r);
  }
}

void put_grains(const Packing& p, State& state) {
  for (std::size_t i = 0; i < p.radius.size(); ++i)
    set_grain(state.grains, i, {.shape = PolyEllipsoid::sphere(p.radius[i]), .position = p.centre[i], .density = 2650});
  sort_in_space(state.grains);
}

}  // namespace

Packing read_packing(const std::string& file) {
  std::ifstream in(file);
  std::size_t n = 0;
  Packing p;
  if (!(in >> n >> p.size)) throw std::runtime_error(file + ": no packing (\"N L\", then \"x y z r\")");
  read_grains(in, file, n, p);
  return p;
}

void write_packing(const std::string& file, const Packing& p) {
  std::ofstream out(file);
  out << fmt::format("{} {:.12e}\n", p.radius.size(), p.size);
  for (std::size_t i = 0; i < p.radius.size(); ++i)
    out << fmt::format("{:.12e} {:.12e} {:.12e} {:.12e}\n", p.centre[i][0], p.centre[i][1], p.centre[i][2],
                       p.radius[i]);
}

Packing make_packing(std::size_t grains, double ratio) {
  // Radii even between low and ratio x low; at 4.5 the sand of the peers' figures, mean 0.3 mm.
  RadiusDistribution radii{"truncated-normal", 3e-4, 5e-5, 1e-4, 4.5e-4};
  double volume = 1.225e-10;
  if (ratio != 4.5) {
    const double low = 3e-4 / std::sqrt(ratio);
    radii = {"uniform", 0.5 * (low + ratio * low), 0, low, ratio * low};
    volume = 4 * pi / 3 * (std::pow(ratio * low, 4) - std::pow(low, 4)) / 4 / (ratio * low - low);
  }
  const double fraction = 0.55, size = std::cbrt(static_cast<double>(grains) * volume / fraction);
  const auto made = random_packing(Vec3::Constant(size), radii, fraction, 0, false, 1);
  Sample s{sand(), {}};
  for (const auto& sphere : made.spheres)
    set_grain(s.state.grains, s.state.grains.size(),
              {.shape = PolyEllipsoid::sphere(sphere.radius), .position = sphere.position, .density = 2650});
  add_box(s.state, size);
  sort_in_space(s.state.grains);
  set_damping(s.model, 0.3);
  Team team(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  prepare(s.model, s.state, team);
  const double pressed = 0.01;  // so little that 4 % more leave overlaps below a fifth of a radius
  Loading loading;
  loading.driven = true;
  for (auto& axis : loading.axes) axis.strain_rate = -2000;
  begin_loading(s.model, s.state, loading);
  load(s.model, s.state, loading, s.state.time + pressed / 2000, team);
  for (auto& axis : loading.axes) axis.strain_rate = 0;
  begin_loading(s.model, s.state, loading);
  load(s.model, s.state, loading, s.state.time + 0.04 / 2000, team);  // comes to rest
  Packing p;
  p.size = s.state.boundary.walls[1].point[0];
  for (const auto& m : s.state.grains.motion) p.centre.push_back(m.position), p.radius.push_back(m.radius);
  return p;
}

Packing lattice(int layers) {
  const double r = 3e-4;
  const auto made = simple_cubic(r, {layers, layers, layers});
  Packing p;
  p.size = made.box[0];
  for (const auto& sphere : made.spheres) p.centre.push_back(sphere.position), p.radius.push_back(1.001 * r);
  return p;
}

Sample boxed(const Packing& p) {
  Sample s{sand(), {}};
  s.model.numerics.time_step = 2e-8;
  put_grains(p, s.state);
  add_box(s.state, p.size);
  s.state.boundary.walls.back().velocity = Vec3(0, 0, -500 * p.size);
  return s;
}

Sample celled(std::size_t grains, bool shapes, double pressure) {
  Sample s{sand(), {}};
  set_damping(s.model, 0.3);
  s.model.numerics.max_overlap = 0.5;
  const double fraction = 0.55, size = std::cbrt(static_cast<double>(grains) * 1.17e-10 / fraction);
  const auto made =
      random_packing(Vec3::Constant(size), {"uniform", 3e-4, 0, 2.2e-4, 3.8e-4}, fraction, grains, true, 5);
  for (std::size_t i = 0; i < made.spheres.size(); ++i) {
    PolyEllipsoid shape = PolyEllipsoid::sphere(made.spheres[i].radius);
    if (shapes)
      for (int k = 0; k < 3; ++k)
        shape.plus[k] *= random_uniform(3, i, Purpose::radius, static_cast<std::uint64_t>(k)) * 0.4 + 0.6,
            shape.minus[k] *= random_uniform(4, i, Purpose::radius, static_cast<std::uint64_t>(k)) * 0.4 + 0.6;
    set_grain(
        s.state.grains, i,
        {.shape = shape, .position = made.spheres[i].position, .orientation = random_rotation(5, i), .density = 2650});
  }
  sort_in_space(s.state.grains);
  s.state.boundary.cell.vectors = size * Mat3::Identity();
  Team team(1);
  prepare(s.model, s.state, team);
  Model slippery = s.model;  // dense: friction comes after the preparation
  for (auto& m : slippery.materials) m.friction = 0.05;
  make_pair_laws(slippery);
  compress_isotropically(slippery, QuasiStatic{}, s.state, pressure, team);
  return s;
}

double list_nanoseconds(const Sample& sample) {
  Team team(1);
  State s = sample.state;
  prepare(sample.model, s, team);
  double best = INFINITY;
  for (int k = 0; k < 3; ++k)
    best = std::min(
        best, seconds([&] { build_contacts(s.grains, s.boundary, s.skin, 1, {}, s.contacts, s.reference, team); }));
  return 1e9 * best / static_cast<double>(s.grains.size());
}

double bytes_of(const Sample& sample) {
  Team team(1);
  State s = sample.state;
  prepare(sample.model, s, team);
  return static_cast<double>(dem::bytes_of(s).size());
}

Timed time_steps(const Sample& sample, std::uint64_t steps, int threads, std::uint64_t warm) {
  Team team(threads);
  Timed out;
  State& state = out.state = sample.state;
  const double volume = state.boundary.walls.empty() ? 0 : std::pow(state.boundary.walls[1].point[0], 3);
  if (state.contacts.size() == 0) prepare(sample.model, state, team);
  run_steps(sample.model, state, warm, team);
  state.reference.builds = 0;
  out.seconds = seconds([&] {
    if (steps > 0) run_steps(sample.model, state, steps, team);
  });
  out.contacts = static_cast<double>(measure(sample.model, state).contacts) / static_cast<double>(state.grains.size());
  const Contacts& c = state.contacts;
  for (std::size_t k = 0; k < c.begin[first_wall]; ++k)
    if (volume > 0 && c.contact.touching(k)) out.stress += c.touch[k].force.z() * branch(state, k).z() / volume;
  return out;
}

double seconds_of_steps(const Sample& sample, std::uint64_t steps, int threads, std::uint64_t warm) {
  return time_steps(sample, steps, threads, warm).seconds;
}

double share_of_lists(const Sample& sample, Timed& run) {
  Team team(1);
  State& s = run.state;
  const auto count = static_cast<double>(s.reference.builds);
  double each = INFINITY;
  for (int k = 0; k < 3; ++k)
    each = std::min(each, seconds([&] {
                      build_contacts(s.grains, s.boundary, s.skin, sample.model.materials.size(), {}, s.contacts,
                                     s.reference, team);
                    }));
  return count * each / run.seconds;
}

double contact_nanoseconds(Sample& sample) {
  Team team(1);
  State& s = sample.state;
  std::size_t touching = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) touching += s.contacts.contact.touching(k);
  double best = INFINITY;
  for (int repeat = 0; repeat < 30; ++repeat) {
    best = std::min(best, seconds([&] {
                      contact_forces(sample.model.law, sample.model.pairs, s.grains, s.boundary, 0, false, s.contacts,
                                     team);
                    }));
    drop_loads(s.contacts), flush(s.contacts);
  }
  return 1e9 * best / static_cast<double>(touching);
}

double seconds_of_bare_steps(const Sample& sample, std::uint64_t steps) {
  Team team(1);
  State s = sample.state;
  if (s.contacts.size() == 0) prepare(sample.model, s, team);
  const MotionSettings settings = sample.model.motion;
  sweep(Kick::open, s.grains, s.contacts, settings, false, s.dt, s.grain_energy, team);
  return seconds([&] {
    for (std::uint64_t k = 0; k < steps; ++k) {
      s.reference.travelled += 1.1 * s.dt * take_speed(s.grain_energy);
      move_boundary(s.boundary, s.dt);
      if (look_at_list(s.grains, s.boundary, s.reference) != ListState::holds)
        build_contacts(s.grains, s.boundary, s.skin, 1, {}, s.contacts, s.reference, team);
      const ContactPass contacts(sample.model.law, sample.model.pairs, s.grains, s.boundary, s.dt, false, s.contacts);
      const SweepPass grains(Kick::both, s.grains, s.contacts, settings, false, s.dt, s.grain_energy);
      for (std::size_t t = 0; t < tile_count(s.grains.size()); ++t) contacts.tile(t), grains.tile(t);
    }
  });
}

Sample read_cell(const std::string& file) {
  std::ifstream in(file);
  std::size_t n = 0;
  Mat3 cell;
  in >> n;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) in >> cell(i, j);
  if (!in) throw std::runtime_error(file + ": no cell (\"N\", nine numbers, then \"x y z r\")");
  Sample s{sand(), {}};
  s.model.materials[0].restitution = 1;
  set_damping(s.model, 0.2);
  make_pair_laws(s.model);
  Packing p;
  read_grains(in, file, n, p);
  put_grains(p, s.state);
  s.state.boundary.cell.vectors = cell;
  Team team(1);
  prepare(s.model, s.state, team);
  return s;
}

Path increments(const Sample& cell, double safety, int count) {
  Team team(1);
  Model model = cell.model;
  const QuasiStatic usual, strict{.unbalanced_force = 1e-6, .stress_change = 1e-7, .max_hold = 400000};
  Increment step;
  step.deformation(2, 2) = 1 - 1e-3;
  State state = cell.state;
  hold(model, strict, state, team);
  std::vector<double> took;
  Path out{0, 0, 0, 0};
  for (int k = 0; k < count; ++k) {
    model.numerics.safety = safety;
    State trial = state;
    Response r;
    took.push_back(seconds([&] { r = deform(model, usual, trial, step, team); }));
    if (!r.stable) throw std::runtime_error("increment: " + r.failure);
    model.numerics.safety = cell.model.numerics.safety;
    const Response closed = deform(model, strict, state, step, team);
    out.steps += static_cast<double>(r.steps) / count;
    out.error = std::max(out.error, (r.stress - closed.stress).norm() / closed.stress.norm());
    out.stress = -r.stress(2, 2);
  }
  std::sort(took.begin(), took.end());
  out.seconds = took[took.size() / 2];
  return out;
}

double farm_speed_up(const Sample& sample, std::size_t count) {
  double took[2] = {INFINITY, INFINITY};
  for (const int threads : {1, 2, 1, 2, 1, 2}) {  // in turn: the machine may not be ours alone
    std::vector<State> cells(count, sample.state);
    Team farm(threads);
    const double now = seconds([&] {
      farm.each(count, [&](std::size_t i) {
        Team own(1);
        Increment step;
        step.deformation(2, 2) = 1 - 1e-4 * (1 + 1e-4 * static_cast<double>(i));  // no two alike
        deform(sample.model, {}, cells[i], step, own);
      });
    });
    took[threads - 1] = std::min(took[threads - 1], now);
  }
  return took[0] / took[1];
}

}  // namespace grus::bench
