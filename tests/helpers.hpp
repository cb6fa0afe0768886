// SPDX-License-Identifier: LGPL-3.0-or-later
// Small models and states for the tests.
#pragma once

#include "dem/fracture/replace_grain.hpp"
#include "dem/fracture/split_polyellipsoid.hpp"
#include "dem/rve/breakage.hpp"
#include "dem/rve/model.hpp"
#include "dem/rve/state.hpp"
#include "dem/rve/step.hpp"
#include "dem/rve/stepper.hpp"
#include "dem/state/shape_kinds.hpp"
#include "tests/catch.hpp"

namespace grus::dem::test {

/// By this thread alone.
inline void update_time_step(const Model& model, State& state) {
  Team alone(1);
  update_time_step(model, state, alone);
}

inline Material solid(double E, double nu, double density, double friction = 0, double restitution = 1) {
  Material m;
  m.name = "solid", m.youngs_modulus = E, m.poissons_ratio = nu, m.density = density, m.friction = friction,
  m.restitution = restitution;
  return m;
}

/// Materials: 0 the grains', 1 rigid walls.
inline Model model_of(const Material& material) {
  Model model;
  Material rigid;
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.materials = {material, rigid};
  make_pair_laws(model);
  return model;
}

inline Model linear_model(double kn, double ratio, double density, double friction) {
  Model model;
  Material m = solid(60e9, 0.2, density, friction);
  m.contact = LinearSpring::Of{.stiffness = kn, .shear_ratio = ratio};
  Material rigid;
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.law = LinearSpring{};
  model.materials = {m, rigid};
  make_pair_laws(model);
  return model;
}

inline std::size_t add(State& s, const PolyEllipsoid& shape, const Vec3& x, double density,
                       const Vec3& v = Vec3::Zero(), const Vec3& spin = Vec3::Zero(),
                       const Quat& q = Quat::Identity()) {
  set_grain(s.grains, s.grains.size(), {shape, x, v, spin, q, 0, density});
  return s.grains.size() - 1;
}

/// Rigid walls around a cube that begins at the origin, the highest last.
inline void add_box(State& s, double size) {
  for (int k = 0; k < 3; ++k)
    for (int side = 0; side < 2; ++side) {
      Wall wall;
      PlaneWall plane;  // its zeros have no sign
      plane.normal[k] = side ? -1 : 1;
      wall.material = 1, wall.shape = plane;
      if (side) wall.point[k] = size;
      s.boundary.walls.push_back(wall);
    }
}

inline void add_floor(State& s) {
  Wall wall;
  wall.shape = PlaneWall{Vec3::UnitZ()}, wall.material = 1;
  s.boundary.walls.push_back(wall);
}

/// Runs until `time` with breaks handled as run_steps does.
inline void run_for(const Model& model, State& s, double time, Team& team) {
  const double end = s.time + time;
  while (s.time < end - 0.5 * s.dt) {
    update_time_step(model, s);
    run_steps(model, s,
              std::max<std::uint64_t>(
                  1, std::min<std::uint64_t>(50, static_cast<std::uint64_t>((end - s.time) / s.dt + 0.5))),
              team);
  }
}

/// The criterion of a material that is of one kind, to be changed.
template <class C>
C& criterion(Model& model) {
  for (Criterion& c : model.materials[0].fracture->criteria)
    if (auto* found = std::get_if<C>(&c)) return *found;
  throw std::logic_error("no such criterion");
}

inline Halves& halves_in(FractureModel& f) { return std::get<Halves>(f.splitter); }

/// Splits grain i in two along an axis.
inline void split_grain(Grains& g, std::size_t i, int axis, const FractureModel& f, Fines& fines) {
  replace_grain(g, i, halves_of(std::get<Halves>(f.splitter), g, i, axis, g.orientation[i]), f.fines, fines);
}

/// What a break makes of its grain.
inline Pieces pieces_of(const Model& model, const State& s, const Break& b) {
  const FractureModel& f = *model.materials[s.grains.material[b.grain]].fracture;
  return dem::pieces_of(f.splitter, s.grains, b.grain, b.wanted, model.seed);
}

/// A load that wants grain i to break across an axis of its geometry frame.
inline Break across(const State& s, std::size_t i, int axis) {
  return {i, {Mat3::Zero(), Vec3(s.grains.orientation[i] * Vec3::Unit(axis))}};
}

/// Fragments of this material grow to a ratio of 1 : 4 within a time (s); nothing breaks.
inline Model growing(double time) {
  Material m = solid(60e9, 0.17, 2650);
  m.fracture = FractureModel{};
  m.fracture->criteria.emplace_back(ContactTension{1e15, 3});
  m.fracture->transition = ShapeTransition{0.25, time};
  return model_of(m);
}

inline PolyEllipsoid random_shape(std::uint64_t seed, std::uint64_t id, double low = 0.6, double high = 1) {
  PolyEllipsoid p;
  for (int k = 0; k < 3; ++k) {
    const auto draw = 2 * static_cast<std::uint64_t>(k);
    p.plus[k] = low + (high - low) * random_uniform(seed, id, Purpose::radius, draw);
    p.minus[k] = low + (high - low) * random_uniform(seed, id, Purpose::radius, draw + 1);
  }
  return p;
}

}  // namespace grus::dem::test
