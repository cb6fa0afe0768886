// SPDX-License-Identifier: LGPL-3.0-or-later
// Kicks and turns of grains of any shape, `width` at a time; built once for each instruction set, see sphere_pass.cpp.
// Nothing is fused: what does so by a call, on processors before 2013, would take most of the time.
#include "dem/kernel/lanes.hpp"
#include "dem/kernel/sweep.hpp"

namespace grus::dem {
namespace {

struct Turn {  // a quaternion
  Real x, y, z, w;
};

GRUS_INLINE Turn operator*(const Turn& a, const Turn& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z,
          a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
GRUS_INLINE Turn back(const Turn& a) { return {Real(0.0) - a.x, Real(0.0) - a.y, Real(0.0) - a.z, a.w}; }
GRUS_INLINE Turn unit(const Turn& a) {  // the deviation is round-off: one Newton step
  const Real f = Real(1.5) - Real(0.5) * (a.x * a.x + a.y * a.y + a.z * a.z + a.w * a.w);
  return {f * a.x, f * a.y, f * a.z, f * a.w};
}

/// Columns of the rotation matrix.
struct Axes {
  Real3 x, y, z;
};
GRUS_INLINE Real3 axis_x(const Turn& q) {
  return {Real(1.0) - Real(2.0) * (q.y * q.y + q.z * q.z), Real(2.0) * (q.x * q.y + q.w * q.z),
          Real(2.0) * (q.x * q.z - q.w * q.y)};
}
GRUS_INLINE Real3 axis_y(const Turn& q) {
  return {Real(2.0) * (q.x * q.y - q.w * q.z), Real(1.0) - Real(2.0) * (q.x * q.x + q.z * q.z),
          Real(2.0) * (q.y * q.z + q.w * q.x)};
}
GRUS_INLINE Real3 axis_z(const Turn& q) {
  return {Real(2.0) * (q.x * q.z + q.w * q.y), Real(2.0) * (q.y * q.z - q.w * q.x),
          Real(1.0) - Real(2.0) * (q.x * q.x + q.y * q.y)};
}
GRUS_INLINE Axes axes(const Turn& q) { return {axis_x(q), axis_y(q), axis_z(q)}; }
GRUS_INLINE Real along(const Real3& a, const Real3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
GRUS_INLINE Real3 sum(Real a, const Real3& x, Real b, const Real3& y, Real c, const Real3& z) {
  return a * x + b * y + c * z;
}

/// cos(h) and sin(h) / (2 h) of half the angle, whose square is `half2`, as base/tensor.hpp: rotation_by.
GRUS_INLINE void half_turn(Real half2, Real& c, Real& s) {
  c = Real(1.0) - half2 * (Real(0.5) - half2 * (Real(1.0 / 24) - half2 * Real(1.0 / 720)));
  s = Real(0.5) * (Real(1.0) - half2 * (Real(1.0 / 6) - half2 * (Real(1.0 / 120) - half2 * Real(1.0 / 5040))));
  const unsigned far = bits(less(half2, Real(1e-4))) ^ ((1u << width) - 1);
  if (far == 0) return;
  double h2[width], cs[width], sn[width];
  store(half2, h2);
  store(c, cs);
  store(s, sn);
  for (unsigned m = far; m; m &= m - 1) {
    const int l = __builtin_ctz(m);
    const double half = __builtin_sqrt(h2[l]);
    cs[l] = __builtin_cos(half), sn[l] = 0.5 * __builtin_sin(half) / half;
  }
  load(cs, c), load(sn, s);
}
GRUS_INLINE Turn turn_by(const Real3& a) {
  Real c, s;
  half_turn(Real(0.25) * along(a, a), c, s);
  return {s * a.x, s * a.y, s * a.z, c};
}

/// Torque-free motion of a body, principal -> global: half a step about x, as a symmetric top about z, half a step
/// about x.
GRUS_INLINE Turn free_turn(Turn q, const Real3& moments, const Real3& momentum, Real dt) {
  const Real one(1.0), half(0.5), of_y = one / moments.y, split = one / moments.x - of_y, spin = one / moments.z - of_y;
  auto about_x = [&] {
    const Real a = half * dt * along(axis_x(q), momentum) * split;
    Real c, s;
    half_turn(Real(0.25) * a * a, c, s);
    s = s * a;
    q = {q.x * c + q.w * s, q.y * c + q.z * s, q.z * c - q.y * s, q.w * c - q.x * s};
  };
  about_x();
  const Real a = dt * along(axis_z(q), momentum) * spin;
  q = turn_by(dt * of_y * momentum) * q;
  Real c, s;
  half_turn(Real(0.25) * a * a, c, s);
  s = s * a;
  q = {q.x * c + q.y * s, q.y * c - q.x * s, q.z * c + q.w * s, q.w * c - q.z * s};
  about_x();
  return unit(q);
}

GRUS_INLINE Real3 spin_of(const Turn& q, const Real3& moments, const Real3& momentum) {
  const Axes e = axes(q);
  return sum(along(e.x, momentum) / moments.x, e.x, along(e.y, momentum) / moments.y, e.y,
             along(e.z, momentum) / moments.z, e.z);
}

/// -damping |force| against the direction of the velocity, as sphere_sweep.cpp.
GRUS_INLINE Real3 opposing(const Real3& f, const Real3& v, Real damping) {
  const Real zero(0.0), force2 = along(f, f), speed2 = along(v, v);
  const Mask moves = less(zero, speed2);
  const Real share = select(moves, zero - damping * root(force2 / select(moves, speed2, Real(1.0))), zero);
  return share * v;
}

/// Up to `width` grains; rows beyond `count` repeat the last.
struct Group {
  std::uint32_t at[width];
  int count;

  GRUS_INLINE Group(const std::uint32_t* grains, std::size_t first, std::size_t end)
      : count(end - first < width ? static_cast<int>(end - first) : width) {
    for (int l = 0; l < width; ++l) at[l] = grains[first + static_cast<std::size_t>(l < count ? l : count - 1)];
  }
  GRUS_INLINE Real3 read3(const double* column) const {
    return {gather(column, at, 3), gather(column + 1, at, 3), gather(column + 2, at, 3)};
  }
  GRUS_INLINE Real damping(const SweepRows& s) const {
    double of[width];
    for (int l = 0; l < width; ++l) of[l] = s.damping[s.material[at[l]]];
    Real v;
    load(of, v);
    return v;
  }
  GRUS_INLINE void write3(const Real3& v, double* column) const {
    double x[width], y[width], z[width];
    store(v.x, x);
    store(v.y, y);
    store(v.z, z);
    for (int l = 0; l < count; ++l) {
      double* const to = column + 3 * std::size_t{at[l]};
      to[0] = x[l];
      to[1] = y[l];
      to[2] = z[l];
    }
  }
  GRUS_INLINE void write4(Real x, Real y, Real z, Real w, double* column, std::size_t stride) const {
    const Quads rows = quads(x, y, z, w);
    for (int l = 0; l < width; ++l)
      if (l < count) put(rows, l, column + stride * at[l]);
  }
  GRUS_INLINE void write_frame(const Real3& position, const Turn& q, const SweepRows& s) const {
    Real3 plus, minus;
    Real again;
    load4(s.shape, at, 6, plus.x, plus.y, plus.z, minus.x);
    load4(s.shape + 2, at, 6, again, again, minus.y, minus.z);
    const Axes e = axes(q);
    const Real3 centre = Real(0.375) * (plus - minus),
                origin = position - sum(centre.x, e.x, centre.y, e.y, centre.z, e.z);
    write4(origin.x, origin.y, origin.z, e.x.x, s.frame, 12);
    write4(e.x.y, e.x.z, e.y.x, e.y.y, s.frame + 4, 12);
    write4(e.y.z, e.z.x, e.z.y, e.z.z, s.frame + 8, 12);
  }
};

/// Takes the loads of the group's grains: their own rows, then those of other tiles.
GRUS_INLINE void collect(const SweepRows& s, const Group& g, Real3& force, Real3& torque) {
  double sums[width][8];
  for (int l = 0; l < g.count; ++l) {
    const std::size_t i = g.at[l];
    double* row = s.load + 8 * (i - s.first);
    double* const to = sums[l];
    for (int k = 0; k < 8; ++k) to[k] = row[k], row[k] = 0;
    for (std::uint32_t r = s.remote[i]; r < s.remote[i + 1]; ++r) {
      row = s.elsewhere + 8 * std::size_t{s.remote_row[r]};
      __builtin_prefetch(s.elsewhere + 8 * std::size_t{s.remote_row[r + rows_ahead]}, 1);
      for (int k = 0; k < 8; ++k) to[k] = to[k] + row[k], row[k] = 0;
    }
  }
  for (int l = g.count; l < width; ++l)
    for (int k = 0; k < 8; ++k) sums[l][k] = 0;
  Real none;
  load4(sums[0], 8, force.x, force.y, force.z, none);
  load4(sums[0] + 4, 8, torque.x, torque.y, torque.z, none);
}

template <bool close, bool open>
SweepEnergy run(const SweepRows& s, const std::uint32_t* grains, std::size_t count) {
  const Real half(0.5), dt(s.dt), h(0.5 * s.dt);
  const Real3 gravity{s.gravity[0], s.gravity[1], s.gravity[2]};
  const double* const a = s.affine;
  const Real3 ax{a[0], a[1], a[2]}, ay{a[3], a[4], a[5]}, az{a[6], a[7], a[8]};
  SweepEnergy out;
  Real fastest(0.0);
  for (std::size_t first = 0; first < count; first += width) {
    const Group g(grains, first, count);
    Real3 x, v, w, moments;
    Real radius, inverse_mass, unused;
    Turn q, principal;
    load4(s.motion, g.at, 12, x.x, x.y, x.z, radius);
    load4(s.motion + 4, g.at, 12, v.x, v.y, v.z, inverse_mass);
    load4(s.orientation, g.at, 4, q.x, q.y, q.z, q.w);
    load4(s.inertia, g.at, 7, moments.x, moments.y, moments.z, unused);
    load4(s.inertia + 3, g.at, 7, principal.x, principal.y, principal.z, principal.w);
    Real3 momentum = g.read3(s.angular_momentum), force, torque;
    const Real mass = gather(s.mass, g.at, 1);
    if constexpr (close) {
      collect(s, g, force, torque);
      if (s.weighs) force = force + mass * gravity;
      if (s.bonded) force = force + g.read3(s.force), torque = torque + g.read3(s.torque);
      if constexpr (!open) g.write3(force, s.force), g.write3(torque, s.torque);
    } else {
      force = g.read3(s.force), torque = g.read3(s.torque);
    }
    auto apart = [&] { return s.shears ? v - sum(x.x, ax, x.y, ay, x.z, az) : v; };
    Real damping(0.0);
    if (s.damping) damping = g.damping(s), load4(s.motion + 8, g.at, 12, w.x, w.y, w.z, unused);
    for (int k = 0; k < (close && open ? 2 : 1); ++k) {
      Real3 f = force, t = torque;
      if (k == 1 && s.damping) w = spin_of(q * principal, moments, momentum);
      const Real kick = h * inverse_mass;
      if (s.damping) {
        const Real3 df = opposing(force, apart(), damping), dm = opposing(torque, w, damping);
        f = f + df, t = t + dm;
        double lost[width];
        store(h * (along(df, v + half * kick * f) + along(dm, w)), lost);
        for (int l = 0; l < g.count; ++l) out.viscous -= lost[l];
      }
      if (s.weighs) {
        double won[width];
        store(h * mass * along(gravity, v + half * kick * f), won);
        for (int l = 0; l < g.count; ++l) out.work += won[l];
      }
      v = v + kick * f;
      momentum = momentum + h * t;
    }
    if constexpr (open) {
      x = x + dt * v;
      const Turn turned = free_turn(q * principal, moments, momentum, dt);
      q = unit(turned * back(principal));
      w = spin_of(turned, moments, momentum);
      g.write4(x.x, x.y, x.z, radius, s.motion, 12);
      g.write4(q.x, q.y, q.z, q.w, s.orientation, 4);
      g.write_frame(x, q, s);
      const Real3 relative = apart();
      const Real speed = root(along(relative, relative)) + Real(1.01) * root(along(w, w)) * radius;
      fastest = larger(fastest, speed * speed);
    } else {
      w = spin_of(q * principal, moments, momentum);
    }
    g.write4(v.x, v.y, v.z, inverse_mass, s.motion + 4, 12);
    g.write4(w.x, w.y, w.z, gather(s.motion + 11, g.at, 12), s.motion + 8, 12);
    g.write3(momentum, s.angular_momentum);
  }
  double lanes[width];
  store(fastest, lanes);
  for (const double speed2 : lanes) out.speed2 = speed2 > out.speed2 ? speed2 : out.speed2;
  return out;
}

}  // namespace

namespace GRUS_LANES {

SweepEnergy body_kicks(const SweepRows& s, Kick kick, const std::uint32_t* grains, std::size_t count) {
  if (kick == Kick::both) return run<true, true>(s, grains, count);
  return kick == Kick::close ? run<true, false>(s, grains, count) : run<false, true>(s, grains, count);
}

void sphere_turns(const SweepRows& s, const std::uint32_t* grains, std::size_t count) {
  const Real dt(s.dt);
  for (std::size_t first = 0; first < count; first += width) {
    const Group g(grains, first, count);
    Turn q;
    Real3 w, x;
    Real unused;
    load4(s.orientation, g.at, 4, q.x, q.y, q.z, q.w);
    load4(s.motion + 8, g.at, 12, w.x, w.y, w.z, unused);
    q = unit(turn_by(dt * w) * q);
    g.write4(q.x, q.y, q.z, q.w, s.orientation, 4);
    if (!s.frame) continue;
    load4(s.motion, g.at, 12, x.x, x.y, x.z, unused);
    g.write_frame(x, q, s);
  }
}

}  // namespace GRUS_LANES

}  // namespace grus::dem
