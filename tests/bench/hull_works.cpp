// SPDX-License-Identifier: LGPL-3.0-or-later
#include "tests/bench/hull_works.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/rve/loading.hpp"
#include "dem/sample/prepare.hpp"

namespace grus::bench {
namespace {

using namespace dem;

Model rock(double modulus, double friction) {
  Material m;
  m.density = 2650, m.youngs_modulus = modulus, m.friction = friction, m.restitution = 0.3;
  m.contact = Foundation::Of{.modulus = modulus, .shear_ratio = 0.5};
  Model model;
  model.materials = {m}, model.law = Foundation{};
  make_pair_laws(model);
  return model;
}

Recipe angular_grains(double pressure) {
  RandomPacking grains;
  grains.radius = {.kind = "uniform", .mean = 0.5e-3, .min = 0.35e-3, .max = 0.65e-3};
  grains.solid_fraction = 0.14, grains.hulls = RandomHulls{.rounds = 3, .aspect = Vec3(1, 0.8, 0.6)};
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(8e-3), recipe.grains = grains;
  recipe.preparation = Preparation{.pressure = pressure, .friction = 0.2};
  return recipe;
}

/// All axes or the last alone go on with this rate (1/s, compression-positive).
Loading compressed_by(Sample& s, double rate, bool all) {
  Loading loading;
  loading.driven = true;
  for (std::size_t k = all ? 0 : 2; k < 3; ++k) loading.axes[k].strain_rate = -rate;
  begin_loading(s.model, s.state, loading);
  return loading;
}

}  // namespace

Sample angular() {
  Team team(1);
  Sample s{rock(2e9, 0.5), {}};
  s.state = make_ready(s.model, angular_grains(1e5), team);
  compressed_by(s, 20, false);
  return s;
}

Sample broken() {
  Team team(1);
  Sample s{rock(10e9, 0.5), {}};
  FractureModel f;
  f.criteria.emplace_back(Cleavage{.toughness = 0.3e6, .flaw = 50e-6});
  f.splitter = Cut{.cohesive = false};
  f.strength_law = Weibull{.modulus = 4, .reference_radius = 0.5e-3};
  f.limit.smallest_radius = 0.25e-3;
  s.model.materials[0].fracture = f;
  s.state = make_ready(s.model, angular_grains(1e5), team);
  const std::size_t whole = s.state.grains.size();
  const double rate = 100;
  const Loading loading = compressed_by(s, rate, false);
  for (int k = 1; k <= 100 && s.state.grains.size() < 3 * whole; ++k)
    load(s.model, s.state, loading, s.state.time + 0.005 / rate, team);
  s.model.materials[0].fracture.reset();
  compressed_by(s, 20, false);
  return s;
}

Sample cells() {
  Team team(1);
  Sample s{rock(2e9, 0.5), {}};
  Recipe recipe;
  recipe.bounds = Bounds::periodic, recipe.box = Vec3::Constant(8e-3);
  recipe.grains = VoronoiPacking{.count = 300, .rounds = 5};
  s.state = make_ready(s.model, recipe, team);
  const Loading loading = compressed_by(s, 50, true);
  load(s.model, s.state, loading, s.state.time + 0.01 / 50, team);
  compressed_by(s, 20, false);
  return s;
}

void time_hulls(std::uint64_t steps, const std::function<void(Row)>& tell) {
  const auto time = [&](const char* name, Sample sample) {
    const auto grains = static_cast<double>(sample.state.grains.size());
    double best = INFINITY, contacts = 0;
    for (int repeat = 0; repeat < 3; ++repeat) {
      const Timed run = time_steps(sample, steps, 1, 100);
      best = std::min(best, run.seconds), contacts = run.contacts;
    }
    tell({fmt::format("{} ({:.0f}), 1 thread", name, grains), "10^6 grain-steps/s",
          1e-6 * grains * static_cast<double>(steps) / best});
    tell({"... its contacts a grain", "", contacts});
    tell({"... its contact pass, a touching pair", "ns", contact_nanoseconds(sample)});
  };
  time("angular hulls, angular_rve.toml", angular());
  time("broken hulls", broken());
  time("Voronoi cells, unbonded, pressed by 1 %", cells());
}

}  // namespace grus::bench
