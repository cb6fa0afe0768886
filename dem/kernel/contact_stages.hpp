// SPDX-License-Identifier: LGPL-3.0-or-later
// The stages that all kinds of pairs go through, `chunk` pairs at a time. Only for the files that are built once for
// each instruction set.
#pragma once

#include "dem/kernel/jkr_row.hpp"
#include "dem/kernel/spring_stage.hpp"

namespace grus::dem {
namespace {

// Roots take long, and a processor looks only some hundred operations ahead: each loop below ends in one, so that many
// are under way together.

struct HertzRow {
  static constexpr bool attracts = false;
  GRUS_INLINE static Pressed press(const ContactRows& s, std::size_t k, Real depth) {
    const Real ks = at(s.stiffness + k) * root(depth);
    return {ks * depth, Real(1.5) * ks, Real(0.0)};
  }
};

struct LinearRow {
  static constexpr bool attracts = false;
  GRUS_INLINE static Pressed press(const ContactRows& s, std::size_t k, Real depth) {
    const Real stiffness = at(s.stiffness + k);
    return {stiffness * depth, stiffness, Real(0.0)};
  }
};

/// Velocity of b against a where they touch, how far they turn about the normal, and what overlap and masses decide:
/// elastic force, tangential stiffness, dashpot.
template <Kind kind, class Law, bool friction, bool dashpot>
GRUS_STAGE void meet(const ContactRows& s, int kept, Chunk& c) {
  const Real one(1.0), half_step(0.5 * s.dt);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width;
    const std::size_t k = c.first[g];
    const std::uint32_t *ia = s.a + k, *ib = s.b + k;
    if (kind == Kind::spheres && far(s)) ask_for_histories(s, k);
    const Mask on = mask_of(c.touching[g]);
    Real3 va, wa, drag;
    Real unused, lightness;  // 1 / effective mass
    load4(s.motion + 4, ia, 12, va.x, va.y, va.z, lightness);
    load4(s.motion + 8, ia, 12, wa.x, wa.y, wa.z, unused);
    const Real3 n{at(c.nx + o), at(c.ny + o), at(c.nz + o)};
    Real3 v;
    if constexpr (kind == Kind::walls) {
      load4(s.walls + 4, s.target + k, 8, drag.x, drag.y, drag.z, unused);
      v = drag - va - cross(at(c.la + o) * wa, n);
      store(half_step * dot(n, wa), c.turn + o);
    } else {
      Real3 vb, wb;
      Real of_b;
      load4(s.motion + 4, ib, 12, vb.x, vb.y, vb.z, of_b);
      load4(s.motion + 8, ib, 12, wb.x, wb.y, wb.z, unused);
      lightness = lightness + of_b;
      if constexpr (kind == Kind::spheres) {
        v = vb - va - cross(fused(at(c.la + o), wa, at(c.lb + o) * wb), n);
      } else {
        const Real3 arm_a{at(c.arm_ax + o), at(c.arm_ay + o), at(c.arm_az + o)},
            arm_b{at(c.arm_bx + o), at(c.arm_by + o), at(c.arm_bz + o)};
        v = vb - va + cross(wb, arm_b) - cross(wa, arm_a);
      }
      store(half_step * dot(n, wa + wb), c.turn + o);
      if (s.shift) {
        load4(s.shifts + 4, s.shift + k, 8, drag.x, drag.y, drag.z, unused);
        v = v + drag;
      }
    }
    if (kind == Kind::walls || s.shift)
      store(drag.x, c.drag_x + o), store(drag.y, c.drag_y + o), store(drag.z, c.drag_z + o);
    store(v.x, c.vx + o);
    store(v.y, c.vy + o);
    store(v.z, c.vz + o);

    const Pressed pressed = Law::press(s, k, select(on, at(c.overlap + o), one));
    store(pressed.force, c.elastic + o);
    if constexpr (Law::attracts) store(pressed.pull, c.pull + o);
    if constexpr (friction) {
      const Real kt = select(on, constant(s, law_shear_ratio, k) * pressed.grip, one);
      store(kt, c.kt + o), store(one / kt, c.compliance + o);
    }
    if constexpr (dashpot) store(constant(s, law_dashpot, k) * root(pressed.grip / lightness), c.dashpot + o);
  }
}

/// Dashpot force; the tangential spring turned with the contact and stretched by the slip, and its Coulomb limit.
template <bool attracts, bool friction, bool dashpot, bool couples>
GRUS_STAGE void resist(const ContactRows& s, std::size_t first, int kept, Chunk& c, Sums& sums) {
  const Real dt(s.dt), zero(0.0);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, first);
    const std::size_t k = c.first[g];
    const Mask on = mask_of(c.touching[g]);
    const Real3 n{at(c.nx + o), at(c.ny + o), at(c.nz + o)}, v{at(c.vx + o), at(c.vy + o), at(c.vz + o)};
    const Real vn = dot(v, n), elastic = at(c.elastic + o);
    Real normal = elastic, viscous(0.0);
    if constexpr (dashpot) {
      const Real least = attracts ? elastic + at(c.pull + o) : elastic;
      viscous = larger(zero - at(c.dashpot + o) * vn, zero - least);  // no attraction beyond what parts it
      sums.spent[h] = sums.spent[h] + kept_lanes(on, (at(s.viscous + k) + viscous) * vn);
      normal = elastic + viscous;
    }
    store(normal, c.normal + o);
    if constexpr (attracts) store(fused(Real(2.0), at(c.pull + o), normal), c.borne + o);
    if constexpr (friction) {
      const Real3 sliding = less_fused(v, vn, n);
      store(sliding.x, c.vx + o);
      store(sliding.y, c.vy + o);
      store(sliding.z, c.vz + o);
      double* const* const column = s.spring[slide_spring];
      const Real3 spring{at(column[0] + k), at(column[1] + k), at(column[2] + k)};
      const Real size2 = dot(spring, spring);
      store(root(size2), c.size + o);
      const Turned turned = turn_spring(less_fused(spring, dot(n, spring), n), size2, n, at(c.turn + o));
      store(turned.old.x, c.sx + o);
      store(turned.old.y, c.sy + o);
      store(turned.old.z, c.sz + o);
      store(turned.keep, c.keep + o);
    }
    if constexpr (dashpot) put_back(kept_lanes(on, viscous), c.count[g], s.viscous + k);
  }
  if constexpr (friction)
    for (int g = 0; g < kept; ++g) {
      const int o = g * width, h = c.place(g, first);
      double* const compliance = s.compliance + c.first[g];
      const Mask on = mask_of(c.touching[g]);
      const Turned turned{{at(c.sx + o), at(c.sy + o), at(c.sz + o)}, at(c.keep + o)};
      const Real3 v{at(c.vx + o), at(c.vy + o), at(c.vz + o)};
      const Grip grip{at(compliance), at(c.compliance + o), at(c.kt + o),
                      constant(s, law_friction, c.first[g]) * at((attracts ? c.borne : c.normal) + o)};
      if constexpr (couples) store(grip.before, c.before + o);
      put_back(kept_lanes(on, grip.after), c.count[g], compliance);
      const Real size = at(c.size + o);
      const Stretched now = stretch_spring(turned, grip, size, size * size, v, dt, on, sums.slid[h], sums.lost[h]);
      store(now.now.x, c.sx + o);
      store(now.now.y, c.sy + o);
      store(now.now.z, c.sz + o);
      store(now.cut, c.cut + o);
    }
}

/// Histories back to their rows, forces to the grains' loads.
template <Kind kind, bool friction, bool dashpot, bool couples>
GRUS_STAGE void hand_out(const ContactRows& s, std::size_t first, int kept, Chunk& c, Sums& sums) {
  const Real zero(0.0);
  for (int g = 0; g < kept; ++g) {
    const int o = g * width, h = c.place(g, first);
    const std::size_t k = c.first[g];
    const unsigned touching = c.touching[g];
    const Mask on = mask_of(touching);
    const Real3 n{at(c.nx + o), at(c.ny + o), at(c.nz + o)};
    Real3 now{zero, zero, zero}, twist{zero, zero, zero};
    if constexpr (friction) {
      now = at(c.cut + o) * Real3{at(c.sx + o), at(c.sy + o), at(c.sz + o)};
      twist = cross(now, n);
      double* const* const spring = s.spring[slide_spring];
      put_back(kept_lanes(on, now.x), c.count[g], spring[0] + k);
      put_back(kept_lanes(on, now.y), c.count[g], spring[1] + k);
      put_back(kept_lanes(on, now.z), c.count[g], spring[2] + k);
    }
    const Real3 force = fused(at(c.normal + o), n, now);
    if (kind == Kind::walls || s.shift) {
      const Real3 drag{at(c.drag_x + o), at(c.drag_y + o), at(c.drag_z + o)};
      sums.power[h] = sums.power[h] + kept_lanes(on, dot(force, drag));
    }
    const Quads push = quads(force.x, force.y, force.z, zero);
    auto load_of_a = [&](int l) { return s.load + 8 * std::size_t{s.a[k + static_cast<std::size_t>(l)] - s.first}; };
    auto load_of_b = [&](int l) {
      const std::uint32_t target = s.target[k + static_cast<std::size_t>(l)];
      return target < s.grains ? s.load + 8 * std::size_t{target - s.first} : s.elsewhere + 8 * std::size_t{target};
    };
    Real3 couple;  // on b; - couple on a
    if constexpr (couples) couple = {at(c.mx + o), at(c.my + o), at(c.mz + o)};
    if constexpr (kind == Kind::shaped) {
      Real3 torque_a = cross(Real3{at(c.arm_ax + o), at(c.arm_ay + o), at(c.arm_az + o)}, force);
      Real3 torque_b = cross(Real3{at(c.arm_bx + o), at(c.arm_by + o), at(c.arm_bz + o)}, force);
      if constexpr (couples) torque_a = torque_a + couple, torque_b = torque_b + couple;
      const Rows on_a = rows(push, quads(torque_a.x, torque_a.y, torque_a.z, zero)),
                 on_b = rows(push, quads(torque_b.x, torque_b.y, torque_b.z, zero));
#pragma GCC unroll 8
      for (int l = 0; l < width; ++l)
        if (touching >> l & 1) subtract(on_a, l, load_of_a(l)), add(on_b, l, load_of_b(l));
    } else {
      Real3 torque_a = (zero - at(c.la + o)) * twist;
      if constexpr (couples) torque_a = torque_a + couple;
      const Rows on_a = rows(push, quads(torque_a.x, torque_a.y, torque_a.z, zero));
      if constexpr (kind == Kind::walls) {
        for (int l = 0; l < width; ++l)
          if (touching >> l & 1) subtract(on_a, l, load_of_a(l));
      } else {
        Real3 torque_b = at(c.lb + o) * twist;
        if constexpr (couples) torque_b = torque_b + couple;
        const Rows on_b = rows(push, quads(torque_b.x, torque_b.y, torque_b.z, zero));
#pragma GCC unroll 8
        for (int l = 0; l < width; ++l)
          if (touching >> l & 1) subtract(on_a, l, load_of_a(l)), add(on_b, l, load_of_b(l));
      }
    }
    if (s.touch) {
      const Rows seen = rows(quads(n.x, n.y, n.z, at(c.overlap + o)),
                             quads(kept_lanes(on, force.x), kept_lanes(on, force.y), kept_lanes(on, force.z), zero));
      for (int l = 0; l < c.count[g]; ++l)
        if (kind != Kind::shaped || (touching >> l & 1)) put(seen, l, s.touch + 8 * (k + static_cast<std::size_t>(l)));
    }
  }
}

/// The stage before all others: which pairs of [first, last) touch, their normals, overlaps and levers; how many groups
/// are kept. Overlaps of touching pairs are positive.
template <Kind kind, bool attracts>
int find_touching(const ContactRows& s, std::size_t first, std::size_t last, Chunk& c, double& parted);

template <Kind kind, class Law, bool friction, bool dashpot, bool couples = false>
PassEnergy run(const ContactRows& s, std::size_t first, std::size_t last) {
  Sums sums;
  for (int h = 0; h < group / width; ++h) sums.lost[h] = sums.slid[h] = sums.spent[h] = sums.power[h] = Real(0.0);
  PassEnergy e;
  double parted = 0;
  Chunk c;
  for (std::size_t start = first; start < last; start += chunk) {
    const int kept =
        find_touching<kind, Law::attracts>(s, start, last - start < chunk ? last : start + chunk, c, parted);
    meet<kind, Law, friction, dashpot>(s, kept, c);
    resist<Law::attracts, friction, dashpot, couples>(s, first, kept, c, sums);
    if constexpr (couples) hold_couples<kind, Law::attracts>(s, first, kept, c, sums);
    hand_out<kind, friction, dashpot, couples>(s, first, kept, c, sums);
  }
  for (int h = 0; h < group / width; ++h) {
    double w[width], x[width], y[width], z[width];
    store(sums.lost[h], w);
    store(sums.slid[h], x);
    store(sums.spent[h], y);
    store(sums.power[h], z);
    for (int l = 0; l < width; ++l) {
      e.springs += 0.5 * w[l];
      e.friction += 0.5 * x[l];
      e.viscous -= 0.5 * s.dt * y[l];
      e.power += z[l];
    }
  }
  e.springs += parted, e.friction += parted;
  return e;
}

template <Kind kind, class Law>
PassEnergy choose(const ContactRows& s, std::size_t first, std::size_t last) {
  if (s.couples)
    return s.dashpot ? run<kind, Law, true, true, true>(s, first, last)
                     : run<kind, Law, true, false, true>(s, first, last);
  if (s.friction)
    return s.dashpot ? run<kind, Law, true, true>(s, first, last) : run<kind, Law, true, false>(s, first, last);
  return s.dashpot ? run<kind, Law, false, true>(s, first, last) : run<kind, Law, false, false>(s, first, last);
}

template <Kind kind>
PassEnergy choose(const ContactRows& s, std::size_t first, std::size_t last) {
  switch (s.kernel) {
    case KernelLaw::linear:
      return choose<kind, LinearRow>(s, first, last);
    case KernelLaw::jkr:
      if constexpr (kind != Kind::shaped) return choose<kind, JkrRow>(s, first, last);
      break;
    case KernelLaw::hertz:
      break;
  }
  return choose<kind, HertzRow>(s, first, last);
}

}  // namespace
}  // namespace grus::dem
