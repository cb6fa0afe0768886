// SPDX-License-Identifier: LGPL-3.0-or-later
// What the boundary of K = A and B is made of: edges of A within B, those of B within A, and the lines in which faces
// meet, whose ends are where the other two kinds end. No plane is cut with a plane, and no polygon is ever put in
// order.
#pragma once

#include "dem/kernel/hull_overlap.hpp"
#include "dem/kernel/lanes.hpp"

namespace grus::dem {
namespace {

constexpr int most_corners = 64, most_faces = 40, most_edges = most_corners + most_faces - 2;
constexpr int most_octets = 15;                         // 120 edges of both hulls in K: their ends are told by a byte
constexpr int most_borders = 12 * 8 * most_octets + 8;  // of both hulls' faces: edges, and lines at both their ends
constexpr std::uint16_t none = 0xffff;

GRUS_INLINE std::uint8_t byte(int x) { return static_cast<std::uint8_t>(x); }

/// Edges of the hulls in K, in whole eights, those of A first, and the triangles of its faces, those of A first.
struct Topology {
  std::uint8_t from[8 * most_octets], to[8 * most_octets];        // corners of its hull
  std::uint8_t enters[8 * most_octets], leaves[8 * most_octets];  // faces of the other hull that cut it there, if any
  // By eight edges, bit by bit: whether one does; whether what is left ends there in a corner of K that no edge before
  // has told.
  std::uint8_t cut_from[most_octets], cut_to[most_octets], new_from[most_octets], new_to[most_octets];
  int octets = 0, octets_a = 0;
  // Each face's edges with a corner of the face, so that what is about it errs by the face's own size, however far and
  // thin. Point 16 o + l is where edge 8 o + l begins, + 8 where it ends; B's faces come after `most_faces` of A.
  std::uint8_t border[4][most_borders];  // from, to, apex, face
  int borders = 0, borders_a = 0;
};

/// One of the two bodies, in the frame of A: what of it can bound K.
struct Body {
  const HullColumns* hull;
  double plane[4 * most_faces];                     // of those faces: rows of normal, offset
  std::uint8_t face[most_faces], rank[most_faces];  // those faces, and where each of them is
  std::uint8_t edge[most_edges];                    // edges that can be in K
  std::uint8_t from[most_edges + 8], to[most_edges + 8];
  int faces = 0, edges = 0;
  std::uint64_t near = 0;             // corners in the slab
  std::uint16_t point[most_corners];  // of K where a corner is one; of the ends of those edges
};

/// Eight edges of a body as the other body cuts them.
struct Cuts {
  double enters[8], leaves[8];  // planes that cut there, by rank; below 0: none, the end is a corner
  unsigned left;                // bit by bit: something is
};

/// Triangles of one body's faces.
struct Borders {
  const std::uint8_t* face;
  int base;
  std::uint8_t row[4][most_borders / 2];
  std::uint16_t first[most_faces];  // by rank of the face
  int count = 0;

  GRUS_INLINE Borders(const Body& body, int base_of) : face(body.face), base(base_of) {
    for (int f = 0; f < body.faces; ++f) first[f] = none;
  }
  GRUS_INLINE void add(int p, int q, int f) {
    if (first[f] == none) first[f] = static_cast<std::uint16_t>(p);
    const int a = first[f];
    row[0][count] = byte(p), row[1][count] = byte(q), row[2][count] = byte(a), row[3][count] = byte(base + face[f]);
    count += p != a && q != a;  // an edge at that corner spans no area with it
  }
};

/// Lines in which a face of A meets one of B, by their ranks: where A's face sees them begin and end.
struct Lines {
  std::uint16_t from[most_faces * most_faces], to[most_faces * most_faces];
  std::uint16_t begun[4 * most_edges];
  int count = 0, ended = 0;
  bool clear = true;  // no end was met twice, none is missing

  GRUS_INLINE void begin(int line, int point) {
    clear = clear && from[line] == none;
    from[line] = static_cast<std::uint16_t>(point), begun[count++] = static_cast<std::uint16_t>(line);
  }
  GRUS_INLINE void end(int line, int point) {
    clear = clear && to[line] == none;
    to[line] = static_cast<std::uint16_t>(point), ++ended;
  }
};

/// Projections of the corners on n, and the greatest of `sign` times them.
GRUS_INLINE double project(const HullColumns& h, const double* n, double offset, double sign, double* along) {
  Real most(-1e300);
  for (int v = 0; v < h.room; v += width) {
    Real x, y, z;
    load(h.corner + v, x), load(h.corner + h.room + v, y), load(h.corner + 2 * h.room + v, z);
    const Real d = fused(z, n[2], fused(y, n[1], fused(x, n[0], offset)));
    store(d, along + v);
    most = larger(most, Real(sign) * d);
  }
  double each[width], best = -1e300;
  store(most, each);
  for (const double e : each) best = e > best ? e : best;
  return sign * best;
}

/// Corners on the near side of the level, their edges and faces: what is beyond the slab between the two bodies' levels
/// bounds nothing.
GRUS_INLINE void find_near(Body& body, const double* along, double level, double sign) {
  const HullColumns& h = *body.hull;
  for (int v = 0; v < h.room; v += width) {
    Real d;
    load(along + v, d);
    const unsigned far = bits(less(Real(sign) * d, Real(sign * level)));
    body.near |= std::uint64_t{~far & ((1u << width) - 1)} << v;
  }
  body.near &= ~std::uint64_t{0} >> (64 - h.vertices);
  std::uint64_t faces = 0, edges[2] = {0, 0};
  for (std::uint64_t near = body.near; near != 0; near &= near - 1) {
    const std::uint64_t* of = h.at + 3 * __builtin_ctzll(near);
    faces |= of[0], edges[0] |= of[1], edges[1] |= of[2];
  }
  for (int half = 0; half < 2; ++half)
    for (; edges[half] != 0; edges[half] &= edges[half] - 1) {
      const int e = 64 * half + __builtin_ctzll(edges[half]), n = body.edges++;
      body.edge[n] = static_cast<std::uint8_t>(e);
      body.from[n] = h.edge[4 * e], body.to[n] = h.edge[4 * e + 1];
      body.point[body.from[n]] = body.point[body.to[n]] = none;
    }
  for (int n = body.edges; n % 8 != 0; ++n) body.from[n] = body.to[n] = 0;
  for (; faces != 0; faces &= faces - 1) {
    const int f = __builtin_ctzll(faces);
    body.rank[f] = static_cast<std::uint8_t>(body.faces);
    body.face[body.faces++] = static_cast<std::uint8_t>(f);
  }
}

GRUS_INLINE void take_planes(Body& body) {
  for (int m = 0; m < body.faces; ++m)
    __builtin_memcpy(body.plane + 4 * m, body.hull->plane + 4 * body.face[m], 4 * sizeof(double));
}

/// Planes from B's own frame to that of A, B's axes there column by column.
GRUS_INLINE void turn_planes(Body& b, const double* turn, const double* shift) {
  for (int m = 0; m < b.faces; ++m) {
    double* n = b.plane + 4 * m;
    const double x = n[0], y = n[1], z = n[2];
    for (int k = 0; k < 3; ++k) n[k] = turn[k] * x + turn[3 + k] * y + turn[6 + k] * z;
    n[3] += n[0] * shift[0] + n[1] * shift[1] + n[2] * shift[2];
  }
}

GRUS_INLINE Real3 turned(const Real3& v, const double* turn, const double* shift) {
  const auto to = [&](int k) {
    return fused(v.z, turn[6 + k], fused(v.y, turn[3 + k], fused(v.x, turn[k], shift[k])));
  };
  return {to(0), to(1), to(2)};
}

/// Edges [at, at + 8) of `body`, cut by the planes of the other, moved out by `slack`. A's are in its frame as they
/// are. Of the planes that cut an edge at one end that is the last which cuts furthest; quotients are compared by what
/// they divide.
template <bool first>
GRUS_INLINE void cut_edges(const Body& body, int at, const Body& other, double slack, const double* turn,
                           const double* shift, Cuts& cuts) {
  cuts.left = 0;
  for (int lane = 0; lane < 8; lane += width) {
    Real3 a, b;
    Real unused;
    load4(body.hull->row, body.from + at + lane, 4, a.x, a.y, a.z, unused);
    load4(body.hull->row, body.to + at + lane, 4, b.x, b.y, b.z, unused);
    if constexpr (!first) a = turned(a, turn, shift), b = turned(b, turn, shift);
    const Real nothing(0.0), whole(1.0);
    Real out(-1e300), in0 = nothing, in_size = whole, in1 = nothing, enters(-1.0);
    Real out1 = nothing, out_size = whole, out0 = nothing, leaves(-1.0);
    for (int m = 0; m < other.faces; ++m) {
      const double* n = other.plane + 4 * m;
      const Real level(-(n[3] + slack)), rank(static_cast<double>(m));
      const Real d0 = fused(a.z, n[2], fused(a.y, n[1], fused(a.x, n[0], level))),
                 d1 = fused(b.z, n[2], fused(b.y, n[1], fused(b.x, n[0], level)));
      const Real by = d0 - d1, size = larger(by, nothing - by);
      out = larger(out, smaller(d0, d1));
      const Mask cuts_first = less(in0 * size, d0 * in_size), cuts_last = less(out1 * size, d1 * out_size);
      in0 = select(cuts_first, d0, in0), in1 = select(cuts_first, d1, in1);
      in_size = select(cuts_first, size, in_size), enters = select(cuts_first, rank, enters);
      out0 = select(cuts_last, d0, out0), out1 = select(cuts_last, d1, out1);
      out_size = select(cuts_last, size, out_size), leaves = select(cuts_last, rank, leaves);
    }
    const Mask cut_first = less(Real(-0.5), enters), cut_last = less(Real(-0.5), leaves);
    const Real t0 = kept_lanes(cut_first, in0 / select(cut_first, in0 - in1, whole)),
               t1 = select(cut_last, out0 / select(cut_last, out0 - out1, whole), whole);
    const unsigned gone = bits(less(nothing, out)) | bits(less(t1, t0));
    cuts.left |= (~gone & ((1u << width) - 1)) << lane;
    store(enters, cuts.enters + lane), store(leaves, cuts.leaves + lane);
  }
}

/// Edges of `body` within the other. `first`: body is A, whose faces' lines run as its own edges do.
template <bool first>
GRUS_INLINE void keep_edges(Body& body, const Body& other, double slack, const double* turn, const double* shift,
                            Topology& k, Borders& borders, Lines& lines) {
  const int across = first ? other.faces : body.faces;
  Cuts cuts;
  int lane = 8;  // of the last octet begun
  for (int at = 0; at < body.edges; at += 8) {
    cut_edges<first>(body, at, other, slack, turn, shift, cuts);
    if (body.edges - at < 8) cuts.left &= (1u << (body.edges - at)) - 1;
    for (; cuts.left != 0; cuts.left &= cuts.left - 1) {
      if (lane == 8 && k.octets == most_octets) {
        lines.clear = false;
        return;
      }
      if (lane == 8) {
        const int o = k.octets++;
        lane = 0, k.cut_from[o] = k.cut_to[o] = k.new_from[o] = k.new_to[o] = 0;
        for (int l = 8 * o; l < 8 * o + 8; ++l) k.from[l] = k.to[l] = k.enters[l] = k.leaves[l] = 0;
      }
      const int n = at + __builtin_ctz(cuts.left), o = k.octets - 1;
      const std::uint8_t* e = body.hull->edge + 4 * body.edge[n];
      const int enters = static_cast<int>(cuts.enters[n - at]), leaves = static_cast<int>(cuts.leaves[n - at]);
      // A corner of K all of whose edges are looked at, or a crossing: else some face of K stays open.
      lines.clear =
          lines.clear && (enters >= 0 || (body.near >> e[0] & 1) != 0) && (leaves >= 0 || (body.near >> e[1] & 1) != 0);
      const std::uint8_t bit = byte(1 << lane);
      k.from[8 * o + lane] = e[0], k.to[8 * o + lane] = e[1];
      int p = 16 * o + lane, q = p + 8;
      if (enters >= 0)
        k.enters[8 * o + lane] = other.face[enters], k.cut_from[o] |= bit, k.new_from[o] |= bit;
      else if (std::uint16_t& known = body.point[e[0]]; known == none)
        known = static_cast<std::uint16_t>(p), k.new_from[o] |= bit;
      else
        p = known;
      if (leaves >= 0)
        k.leaves[8 * o + lane] = other.face[leaves], k.cut_to[o] |= bit, k.new_to[o] |= bit;
      else if (std::uint16_t& known = body.point[e[1]]; known == none)
        known = static_cast<std::uint16_t>(q), k.new_to[o] |= bit;
      else
        q = known;
      ++lane;
      const int left = body.rank[e[2]], right = body.rank[e[3]];
      borders.add(p, q, left), borders.add(q, p, right);
      const auto line = [&](int mine, int others) { return first ? mine * across + others : others * across + mine; };
      // Where the face's own edge ends, its line begins; the other's face runs the line the other way.
      if (enters >= 0) {
        if constexpr (first)
          lines.end(line(left, enters), p), lines.begin(line(right, enters), p);
        else
          lines.begin(line(left, enters), p), lines.end(line(right, enters), p);
      }
      if (leaves >= 0) {
        if constexpr (first)
          lines.begin(line(left, leaves), q), lines.end(line(right, leaves), q);
        else
          lines.end(line(left, leaves), q), lines.begin(line(right, leaves), q);
      }
    }
  }
}

GRUS_INLINE bool join_lines(const Lines& lines, int across, Borders& of_a, Borders& of_b) {
  if (!lines.clear || lines.count != lines.ended) return false;
  for (int k = 0; k < lines.count; ++k) {
    const int line = lines.begun[k];
    if (lines.to[line] == none) return false;
    of_a.add(lines.from[line], lines.to[line], line / across);
    of_b.add(lines.to[line], lines.from[line], line % across);
  }
  return true;
}

/// Finds it from what of both hulls is near.
GRUS_INLINE Meets find_topology(Body& a, Body& b, double slack, const double* turn, const double* shift, Topology& k) {
  Borders of_a(a, 0), of_b(b, most_faces);
  Lines lines;
  const int crossings = a.faces * b.faces;
  for (int l = 0; l < crossings; ++l) lines.from[l] = lines.to[l] = none;
  k.octets = 0;
  keep_edges<true>(a, b, slack, turn, shift, k, of_a, lines);
  k.octets_a = k.octets;
  keep_edges<false>(b, a, -slack, turn, shift, k, of_b, lines);
  if (k.octets == 0) return Meets::apart;
  if (!join_lines(lines, b.faces, of_a, of_b)) return Meets::unsettled;
  k.borders = k.borders_a = of_a.count;
  for (int c = 0; c < 4; ++c) {
    for (int l = 0; l < of_a.count; ++l) k.border[c][l] = of_a.row[c][l];
    for (int l = 0; l < of_b.count; ++l) k.border[c][of_a.count + l] = of_b.row[c][l];
  }
  k.borders += of_b.count;
  for (int l = k.borders; l % 8 != 0; ++l)
    for (int c = 0; c < 4; ++c) k.border[c][l] = 0;
  return Meets::overlaps;
}

/// False where it takes more room than a guess has.
GRUS_INLINE bool keep(const Topology& k, HullGuess& g) {
  if (k.octets > HullGuess::most_octets || k.borders > HullGuess::most_borders) return false;
  g.octets = byte(k.octets), g.octets_a = byte(k.octets_a), g.borders = byte(k.borders),
  g.borders_a = byte(k.borders_a);
  for (int o = 0; o < k.octets; ++o)
    g.cut_from[o] = k.cut_from[o], g.cut_to[o] = k.cut_to[o], g.new_from[o] = k.new_from[o], g.new_to[o] = k.new_to[o];
  for (int l = 0; l < 8 * k.octets; ++l)
    g.from[l] = k.from[l], g.to[l] = k.to[l], g.enters[l] = k.enters[l], g.leaves[l] = k.leaves[l];
  for (int c = 0; c < 4; ++c)
    for (int l = 0; l < (k.borders + 7) / 8 * 8; ++l) g.border[c][l] = k.border[c][l];
  return true;
}

}  // namespace
}  // namespace grus::dem
