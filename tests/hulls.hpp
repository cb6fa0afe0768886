// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls for the tests: bodies, and without bonds states of them.
#pragma once

#include "dem/packing/voronoi.hpp"
#include "dem/shape/hull_store.hpp"
#include "tests/helpers.hpp"

namespace grus::dem::test {

inline constexpr double modulus = 1e6;  // Pa/m

inline Model hull_model(double friction = 0, double c = modulus, double restitution = 1) {
  Model model;
  Material m = solid(60e9, 0, 1, friction, restitution), rigid;
  m.name = "rock", m.contact = Foundation::Of{.given = c, .shear_ratio = 0.5};
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.law = Foundation{};
  model.materials = {m, rigid};
  make_pair_laws(model);
  return model;
}

/// Unit mass density; `body` about the origin, its frame turned back so that it stands as it is given.
inline std::size_t add_body(State& s, const Polyhedron& body, const Vec3& x, const Quat& q,
                            const Vec3& v = Vec3::Zero(), const Vec3& spin = Vec3::Zero()) {
  HullStore store = s.grains.hulls ? *s.grains.hulls : HullStore{};
  HullPlace place;
  GrainSpec spec;
  spec.hull = add_hull(store, body, place);
  spec.position = x, spec.velocity = v, spec.spin = spin, spec.density = 1;
  spec.orientation = q * place.axes;
  s.grains.hulls = std::make_shared<HullStore>(std::move(store));
  set_grain(s.grains, s.grains.size(), spec);
  return s.grains.size() - 1;
}

inline Polyhedron unit_cube() { return box_between(Vec3::Constant(-0.5), Vec3::Constant(0.5)); }

inline Vec3 random_vector(std::uint64_t id, std::uint64_t counter) {
  Vec3 v;
  for (int k = 0; k < 3; ++k)
    v[k] = random_normal(7, id, Purpose::position, 3 * counter + static_cast<std::uint64_t>(k));
  return v;
}

/// Convex bodies of many faces: cells about random seeds.
inline Tessellation some_cells(std::size_t count, std::uint64_t seed = 3) {
  Team team(1);
  return voronoi_packing(periodic_space(Vec3::Ones()), count, 2, seed, team);
}

/// A hull, and where its body frame is.
struct Shape {
  HullStore store;
  HullPlace place;
  explicit Shape(const Polyhedron& body) { add_hull(store, body, place); }
  HullView view() const { return store[0]; }
};

}  // namespace grus::dem::test
