// SPDX-License-Identifier: LGPL-3.0-or-later
// Hulls without bonds for the tests.
#pragma once

#include "dem/shape/polyhedron.hpp"
#include "tests/helpers.hpp"

namespace grus::dem::test {

inline constexpr double modulus = 1e6;  // Pa/m

inline Model hull_model(double friction = 0, double c = modulus, double restitution = 1) {
  Model model;
  Material m = solid(60e9, 0, 1, friction, restitution), rigid;
  m.name = "rock", m.normal_stiffness = c, m.shear_ratio = 0.5;
  rigid.youngs_modulus = INFINITY, rigid.friction = NAN;
  model.law = Foundation{true};
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

}  // namespace grus::dem::test
