// SPDX-License-Identifier: LGPL-3.0-or-later
// The overlap from what it is made of: a guess that holds, or what has been found anew. Both give the same bits, since
// all numbers come from here.
#include "dem/kernel/hull_integrals.hpp"

namespace grus::dem {
namespace {

/// The two hulls in the frame of A.
struct Scene {
  const HullColumns *a, *b;
  double turn[9], shift[3];             // of B, axes column by column
  double side_b[4 * most_faces];        // planes of B in columns, as HullColumns::side
  double planes[2 * 4 * most_faces];    // rows: those of A, and after `most_faces` of them B's
  double points[4 * 16 * most_octets];  // rows; see Topology
  double slack, margin;
};

GRUS_INLINE void place_planes(Scene& s) {
  const HullColumns &a = *s.a, &b = *s.b;
  for (int k = 0; k < 4 * a.space; k += width) {
    Real x;
    load(a.plane + k, x), store(x, s.planes + k);
  }
  for (int f = 0; f < b.space; f += width) {
    Real x, y, z, d;
    load(b.side + f, x), load(b.side + b.space + f, y), load(b.side + 2 * b.space + f, z);
    load(b.side + 3 * b.space + f, d);
    const auto to = [&](int k) { return fused(z, s.turn[6 + k], fused(y, s.turn[3 + k], x * Real(s.turn[k]))); };
    const Real3 n{to(0), to(1), to(2)};
    d = fused(n.z, s.shift[2], fused(n.y, s.shift[1], fused(n.x, s.shift[0], d)));
    store(n.x, s.side_b + f), store(n.y, s.side_b + b.space + f), store(n.z, s.side_b + 2 * b.space + f);
    store(d, s.side_b + 3 * b.space + f);
    const Quads rows = quads(n.x, n.y, n.z, d);
    for (int l = 0; l < width; ++l) put(rows, l, s.planes + 4 * (most_faces + f + l));
  }
}

/// Faces whose planes are above x or less than the margin below it, bit by bit.
GRUS_INLINE std::uint64_t faces_at(const double* side, int space, const double* x, double margin) {
  std::uint64_t at = 0;
  for (int f = 0; f < space; f += width) {
    Real nx, ny, nz, d;
    load(side + f, nx), load(side + space + f, ny), load(side + 2 * space + f, nz), load(side + 3 * space + f, d);
    const Real below = less_fused(less_fused(less_fused(d, nx, x[0]), ny, x[1]), nz, x[2]);
    at |= std::uint64_t{bits(less(below, Real(margin)))} << f;
  }
  return at;
}

/// Ends of what is left of the edges. `looks`: false where they do not bound K, or so nearly not that round-off might
/// say so: a corner of K must be of the planes that it is said to be of, and clearly below all others of the other
/// hull; an edge must clearly end on both sides of a plane that cuts it.
template <bool first, bool looks, class Known>
GRUS_INLINE bool place_points(Scene& s, const Known& k) {
  const HullColumns& own = first ? *s.a : *s.b;
  const double* const planes = first ? s.planes + 4 * most_faces : s.planes;
  const Real slack(first ? s.slack : -s.slack), margin(s.margin), nothing(0.0), whole(1.0);
  for (int o = first ? 0 : k.octets_a; o < (first ? k.octets_a : k.octets); ++o) {
    double* const row = s.points + 64 * o;
    unsigned doubtful = 0;
    for (int lane = 0; lane < 8; lane += width) {
      Real3 a, b, n, m;
      Real unused, in, out;
      const int at = 8 * o + lane;
      load4(own.row, k.from + at, 4, a.x, a.y, a.z, unused), load4(own.row, k.to + at, 4, b.x, b.y, b.z, unused);
      if constexpr (!first) a = turned(a, s.turn, s.shift), b = turned(b, s.turn, s.shift);
      load4(planes, k.enters + at, 4, n.x, n.y, n.z, in), load4(planes, k.leaves + at, 4, m.x, m.y, m.z, out);
      in = in + slack, out = out + slack;
      const Real in0 = dot(n, a) - in, in1 = dot(n, b) - in, out0 = dot(m, a) - out, out1 = dot(m, b) - out;
      constexpr unsigned lanes = (1u << width) - 1;
      const unsigned from = unsigned{k.cut_from[o]} >> lane & lanes, to = unsigned{k.cut_to[o]} >> lane & lanes;
      if constexpr (looks)
        doubtful |= (bits(less(in0, margin)) | bits(less(nothing - margin, in1))) & from,
            doubtful |= (bits(less(nothing - margin, out0)) | bits(less(out1, margin))) & to;
      const Mask cut_from = mask_of(from), cut_to = mask_of(to);
      const Real t0 = in0 / select(cut_from, in0 - in1, whole), t1 = out0 / select(cut_to, out0 - out1, whole);
      const Real3 way = b - a, p = fused(t0, way, a), q = fused(t1, way, a);
      const Quads from_rows = quads(select(cut_from, p.x, a.x), select(cut_from, p.y, a.y), select(cut_from, p.z, a.z),
                                    nothing),
                  to_rows =
                      quads(select(cut_to, q.x, b.x), select(cut_to, q.y, b.y), select(cut_to, q.z, b.z), nothing);
      for (int l = 0; l < width; ++l)
        put(from_rows, l, row + 4 * (lane + l)), put(to_rows, l, row + 4 * (8 + lane + l));
    }
    if constexpr (looks) {
      if (doubtful != 0) return false;
      const double* const side = first ? s.side_b : s.a->side;
      const int space = first ? s.b->space : s.a->space;
      const auto holds = [&](unsigned some, unsigned cut, const std::uint8_t* face, const double* x) {
        for (; some != 0; some &= some - 1) {
          const int l = __builtin_ctz(some);
          if (faces_at(side, space, x + 4 * l, s.margin) != std::uint64_t{cut >> l & 1} << face[l]) return false;
        }
        return true;
      };
      if (!holds(k.new_from[o], k.cut_from[o], k.enters + 8 * o, row) ||
          !holds(k.new_to[o], k.cut_to[o], k.leaves + 8 * o, row + 32))
        return false;
    }
  }
  return true;
}

/// Integrals over K.
template <class Known>
GRUS_INLINE Meets integrate(const Scene& s, const Known& k, const HullPose& pose, HullWrench& out) {
  double o[3];  // all is about this point of K
  for (int c = 0; c < 3; ++c) o[c] = s.points[4 * k.border[0][0] + c];
  Triangles triangles[most_borders / 8 + 1];
  Solid solid;
  add_triangles(s.points, s.planes, k, o, triangles, solid);
  double body[4], surface[4], centre[3], x[3], i[4], j[4];
  solid.body.total(body), solid.surface.total(surface);
  const double volume = body[3] / 6, area[3] = {0.5 * surface[0], 0.5 * surface[1], 0.5 * surface[2]};
  const double area2 = dot3(area, area);
  if (!(volume > 0 && volume * volume > pose.thin * pose.thin * s.slack * s.slack * area2)) return Meets::apart;
  const double per_volume = 1 / (24 * volume);
  for (int c = 0; c < 3; ++c) centre[c] = body[c] * per_volume, x[c] = o[c] + centre[c];
  find_shallowest(s.a->side, s.a->space, x, i), find_shallowest(s.side_b, s.b->space, x, j);
  const double slope[3] = {-(i[0] + j[0]), -(i[1] + j[1]), -(i[2] + j[2])};
  const double level = i[3] + j[3] + dot3(slope, o), depth = level + dot3(slope, centre);

  Faces faces;
  add_faces(triangles, k.borders_a, level, slope, area, faces);
  double press[4], couple[4], weighted[4], first[4], force[3], moment[3], middle[3], of_i[3], at_o[3];
  faces.force.total(press), faces.moment.total(couple), faces.weighted.total(weighted), faces.plain.total(first);
  // Over all of K the integrals of phi n and x with phi n are V slope and x_c with it: A's surface tells B's.
  cross3(centre, i, of_i);
  for (int c = 0; c < 3; ++c) force[c] = 0.5 * (volume * i[c] + 0.5 * press[c]);
  cross3(o, force, at_o);
  for (int c = 0; c < 3; ++c) moment[c] = at_o[c] + 0.5 * (volume * of_i[c] + couple[c] / 24);
  // A closed surface has no area vector: one hull is in the other.
  const double per = 1 / (6 * (area2 > 1e-300 ? area2 : 1e-300));
  for (int c = 0; c < 3; ++c) middle[c] = weighted[c] * per;
  out.polar = first[3] / 24 - dot3(middle, first) / 3 + 0.5 * surface[3] * dot3(middle, middle);
  for (int c = 0; c < 3; ++c) middle[c] += o[c];
  turn3(pose.a, force, out.force), turn3(pose.a, moment, out.moment);
  turn3(pose.a, area, out.area), turn3(pose.a, middle, out.middle);
  out.volume = volume, out.energy = 0.5 * volume * depth;
  return Meets::overlaps;
}

}  // namespace

namespace GRUS_LANES {

Meets hull_overlap(const HullColumns& ha, const HullColumns& hb, const HullPose& pose, HullGuess* guess,
                   HullWrench& out) {
  Scene s;
  Topology k;
  s.a = &ha, s.b = &hb;
  const auto see = [&] {
    turn_back3(pose.a, pose.shift, s.shift);
    for (int c = 0; c < 3; ++c) turn_back3(pose.a, pose.b + 3 * c, s.turn + 3 * c);
    const double corner[3] = {ha.corner[0], ha.corner[ha.room], ha.corner[2 * ha.room]};
    const double size = largest3(corner) + largest3(s.shift);  // the same whatever is looked along
    s.slack = pose.flush * size, s.margin = pose.clear * size;
  };
  const bool guessed = guess != nullptr && guess->octets != 0;
  if (guessed) {
    see(), place_planes(s);
    if (place_points<true, true>(s, *guess) && place_points<false, true>(s, *guess))
      return integrate(s, *guess, pose, out);
    guess->octets = 0;
  }
  double along_a[most_corners], along_b[most_corners], n_a[3], n_b[3];
  turn_back3(pose.a, pose.search, n_a), turn_back3(pose.b, pose.search, n_b);
  const double highest = project(ha, n_a, 0, 1, along_a),
               lowest = project(hb, n_b, dot3(pose.search, pose.shift), -1, along_b);
  if (highest <= lowest) {
    out.gap = lowest - highest;
    return Meets::parted;
  }
  if (!guessed) see();
  Body a, b;
  a.hull = &ha, b.hull = &hb;
  find_near(a, along_a, lowest - s.slack, 1), find_near(b, along_b, highest + s.slack, -1);
  take_planes(a), take_planes(b), turn_planes(b, s.turn, s.shift);
  if (const Meets meets = find_topology(a, b, s.slack, s.turn, s.shift, k); meets != Meets::overlaps) return meets;
  if (!guessed) place_planes(s);
  place_points<true, false>(s, k), place_points<false, false>(s, k);
  if (guess != nullptr && !keep(k, *guess)) guess->octets = 0;
  return integrate(s, k, pose, out);
}

}  // namespace GRUS_LANES
}  // namespace grus::dem
