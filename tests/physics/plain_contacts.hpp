// SPDX-License-Identifier: LGPL-3.0-or-later
// The contact pass in its plain form, one contact at a time: what the vector kernels are measured by.
#pragma once

#include "dem/contact/forces.hpp"
#include "dem/rve/step.hpp"
#include "dem/shape/common_normal.hpp"

namespace grus::dem::test {

/// Forces, histories and loads of all pairs, one contact at a time.
struct Plain {
  std::vector<Contact> contact;
  std::vector<Touch> touch;
  std::vector<Load> load;  // of the grains
  BlockEnergy energy;
  double power = 0;
};

inline Plain plain_pass(const Model& model, const State& state, double dt) {
  Plain out{{}, state.contacts.touch, std::vector<Load>(state.grains.size()), {}, 0};
  for (std::size_t k = 0; k < state.contacts.size(); ++k) out.contact.push_back(state.contacts.contact[k]);
  const Grains& g = state.grains;
  const Cell& cell = state.boundary.cell;
  for (std::size_t k = 0; k < state.contacts.size(); ++k) {
    const Pair& pair = state.contacts.pair[k];
    Contact& c = out.contact[k];
    Touch& touch = out.touch[k];
    const PairLaw& law = model.pairs[pair.law];
    const Motion& a = g.motion[pair.a];
    const bool wall = k >= state.contacts.begin[first_wall];
    Vec3 n, arm_a, arm_b = Vec3::Zero(), moving = Vec3::Zero(), shift = Vec3::Zero();
    double overlap, radius = 0, ellipse = 1;
    if (wall) {
      const Wall& w = state.boundary.walls[pair.b];
      n = -w.facing(), moving = w.velocity;
      const Frame frame = frame_of(g, pair.a);
      const Vec3 d = frame.axes.transpose() * n, tip = frame.origin + frame.axes * support(g.shape[pair.a], d);
      overlap = -n.dot(w.point - tip);
      arm_a = tip - 0.5 * overlap * n - a.position;
      const ContactCurvature curvature = plane_curvature(g.shape[pair.a], d);
      radius = curvature.radius, ellipse = curvature.ellipse_factor;
    } else {
      const Motion& b = g.motion[pair.b];
      if (cell.periodic())
        shift = cell.vectors * Vec3(pair.image[0], pair.image[1], pair.image[2]),
        moving = cell.rate * Vec3(pair.image[0], pair.image[1], pair.image[2]);
      const Frame fa = frame_of(g, pair.a), fb = frame_of(g, pair.b);
      const ShapePair shapes{g.shape[pair.a], g.shape[pair.b], fa.axes.transpose() * fb.axes,
                             fa.axes.transpose() * (fb.origin + shift - fa.origin)};
      const CommonNormal found = cold_common_normal(shapes);
      n = fa.axes * found.normal, overlap = found.overlap;
      const Vec3 point = fa.origin + fa.axes * (0.5 * (found.point_a + found.point_b));
      arm_a = point - a.position, arm_b = point - b.position - shift;
      const ContactCurvature curvature = contact_curvature(shapes, found.normal);
      radius = curvature.radius, ellipse = curvature.ellipse_factor;
    }
    if (!(overlap > -c.reach)) {
      if (c.stiffness > 0) {
        std::visit([&]<class L>(const L&) { part_from<L>(c, out.energy); }, model.law);
        part_contact(c, touch, out.energy);
      }
      continue;
    }
    std::visit(
        [&]<class L>(const L& l) {
          if (c.stiffness == 0) begin_contact<L>(law, radius, ellipse, c, out.energy);
          const Vec3 vb =
              wall ? Vec3(Vec3::Zero()) : Vec3(g.motion[pair.b].velocity + g.motion[pair.b].spin.cross(arm_b));
          const Vec3 wb = wall ? Vec3(Vec3::Zero()) : g.motion[pair.b].spin;
          const Vec3 v = vb + moving - a.velocity - a.spin.cross(arm_a);
          const Vec3 force =
              advance_contact(l, law, 1 / (a.inverse_mass + (wall ? 0 : g.motion[pair.b].inverse_mass)), c, touch, n,
                              overlap, v, 0.5 * n.dot(a.spin + wb), dt, out.energy, wb - a.spin);
          const Vec3 held = couple(c);  // on b
          out.power += force.dot(moving);
          out.load[pair.a].force -= force, out.load[pair.a].torque += force.cross(arm_a) - held;
          if (!wall) out.load[pair.b].force += force, out.load[pair.b].torque += arm_b.cross(force) + held;
        },
        model.law);
  }
  return out;
}

}  // namespace grus::dem::test
