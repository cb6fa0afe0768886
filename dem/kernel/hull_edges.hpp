// SPDX-License-Identifier: LGPL-3.0-or-later
// The boundary of K = A and B by its edges: those of A within B, those of B within A, and the lines in which faces
// meet, whose ends are where the other two kinds end. No plane is cut with a plane, and no polygon is ever put in
// order.
#pragma once

#include "dem/kernel/hull_overlap.hpp"
#include "dem/kernel/lanes.hpp"

namespace grus::dem {
namespace {

constexpr int most_corners = 64, most_faces = 40, most_edges = most_corners + most_faces - 2;
constexpr int most_points = 4 * most_edges, most_borders = 6 * most_edges + 8;  // two ends of an edge; edges and lines
constexpr std::uint16_t none = 0xffff;

/// One of the two bodies, in the frame of A.
struct Body {
  const HullColumns* hull;
  const double *x, *y, *z;                          // corners
  double plane[most_faces * 4];                     // of the faces that can bound K: normal, offset
  std::uint8_t face[most_faces], rank[most_faces];  // those faces, and where each of them is
  std::uint8_t edge[most_edges];                    // edges that can be in K
  int faces = 0, edges = 0;
  std::uint64_t near = 0;                    // corners
  double height[most_faces * most_corners];  // of the corners above the other's plane: a row of `room` by plane
  double beyond[most_corners];               // by corner: sum of 2^m over the planes of the other that it is above
};

/// Directed edges of the faces of K that are of one body, and a corner of each face: what is about it errs by the
/// face's own size, however far and thin.
struct Borders {
  std::uint32_t from[most_borders], to[most_borders], face[most_borders], apex[most_borders];
  std::uint32_t first[most_faces];  // by face
  int count = 0;

  GRUS_INLINE explicit Borders(int faces) {
    for (int f = 0; f < faces; ++f) first[f] = none;
  }
  GRUS_INLINE void add(std::uint32_t p, std::uint32_t q, std::uint32_t f) {
    first[f] = first[f] == none ? p : first[f];
    from[count] = p, to[count] = q, apex[count] = first[f], face[count++] = f;
  }
};

struct Points {
  double row[4 * most_points];
  int count = 0;
};

/// Lines in which a face of A meets one of B, by their ranks: where A's face sees them begin and end.
struct Lines {
  std::uint16_t from[most_faces * most_faces], to[most_faces * most_faces];
  std::uint16_t begun[2 * most_points];
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

/// Edges with a corner on the near side of the level, and the faces beside them: what is beyond the slab between the
/// two bodies' levels bounds nothing.
GRUS_INLINE void find_near(Body& body, const double* along, double level, double sign) {
  const HullColumns& h = *body.hull;
  std::uint64_t faces = 0;
  for (int v = 0; v < h.room; v += width) {
    Real d;
    load(along + v, d);
    const unsigned far = bits(less(Real(sign) * d, Real(sign * level)));
    body.near |= std::uint64_t{~far & ((1u << width) - 1)} << v;
  }
  for (int e = 0; e < h.edges; ++e) {
    const std::uint8_t* row = h.edge + 4 * e;
    const std::uint64_t near = (body.near >> row[0] | body.near >> row[1]) & 1;
    body.edge[body.edges] = static_cast<std::uint8_t>(e);
    body.edges += static_cast<int>(near);
    faces |= near << row[2] | near << row[3];
  }
  for (; faces != 0; faces &= faces - 1) {
    const int f = __builtin_ctzll(faces);
    body.rank[f] = static_cast<std::uint8_t>(body.faces);
    body.face[body.faces++] = static_cast<std::uint8_t>(f);
  }
}

GRUS_INLINE double turned(const double* row, double x, double y, double z) {
  return row[0] * x + row[1] * y + row[2] * z;
}

GRUS_INLINE void take_planes(Body& a, Body& b, const HullPose& p) {
  for (int m = 0; m < a.faces; ++m)
    for (int k = 0; k < 4; ++k) a.plane[4 * m + k] = a.hull->side[k * a.hull->space + a.face[m]];
  for (int m = 0; m < b.faces; ++m) {
    const double* s = b.hull->side + b.face[m];
    const int step = b.hull->space;
    double* to = b.plane + 4 * m;
    for (int k = 0; k < 3; ++k) to[k] = turned(p.turn + 3 * k, s[0], s[step], s[2 * step]);
    to[3] = s[3 * step] + turned(to, p.shift[0], p.shift[1], p.shift[2]);
  }
}

/// Heights of the body's corners above the planes of the other, moved out by `slack`.
GRUS_INLINE void find_beyond(Body& body, const Body& other, double slack) {
  const int room = body.hull->room;
  for (int v = 0; v < room; v += width) {
    Real x, y, z, sum(0.0);
    load(body.x + v, x), load(body.y + v, y), load(body.z + v, z);
    double bit = 1;
    for (int m = 0; m < other.faces; ++m, bit *= 2) {
      const double* n = other.plane + 4 * m;
      const Real d = fused(z, n[2], fused(y, n[1], fused(x, n[0], -(n[3] + slack))));
      store(d, body.height + m * room + v);
      sum = sum + kept_lanes(less(Real(0.0), d), Real(bit));
    }
    store(sum, body.beyond + v);
  }
}

/// Edges of `body` within the other, with their ends. `first`: body is A, whose faces' lines run as its own edges do.
template <bool first>
GRUS_INLINE void keep_edges(const Body& body, const Body& other, Points& points, Borders& borders, Lines& lines) {
  const HullColumns& h = *body.hull;
  const int room = h.room, across = first ? other.faces : body.faces;
  for (int n = 0; n < body.edges; ++n) {
    const std::uint8_t* e = h.edge + 4 * body.edge[n];
    const auto out0 = static_cast<std::uint64_t>(body.beyond[e[0]]),
               out1 = static_cast<std::uint64_t>(body.beyond[e[1]]);
    if ((out0 & out1) != 0) continue;
    double t0 = 0, t1 = 1;
    int enters = -1, leaves = -1;
    for (std::uint64_t open = out0 | out1; open != 0; open &= open - 1) {
      const int m = __builtin_ctzll(open);
      const double d0 = body.height[m * room + e[0]], d1 = body.height[m * room + e[1]], t = d0 / (d0 - d1);
      if (d0 > 0) {
        if (t > t0 || enters < 0) t0 = t, enters = m;
      } else if (t < t1 || leaves < 0) {
        t1 = t, leaves = m;
      }
    }
    if (t0 > t1) continue;
    // A corner of K all of whose edges are looked at, or a crossing: else some face of K stays open.
    lines.clear =
        lines.clear && (enters >= 0 || (body.near >> e[0] & 1) != 0) && (leaves >= 0 || (body.near >> e[1] & 1) != 0);
    const double x = body.x[e[0]], y = body.y[e[0]], z = body.z[e[0]];
    const double dx = body.x[e[1]] - x, dy = body.y[e[1]] - y, dz = body.z[e[1]] - z;
    const int p = points.count++, q = points.count++;
    double *at_p = points.row + 4 * p, *at_q = points.row + 4 * q;
    at_p[0] = x + t0 * dx, at_p[1] = y + t0 * dy, at_p[2] = z + t0 * dz, at_p[3] = 0;
    if (leaves < 0)
      at_q[0] = body.x[e[1]], at_q[1] = body.y[e[1]], at_q[2] = body.z[e[1]];
    else
      at_q[0] = x + t1 * dx, at_q[1] = y + t1 * dy, at_q[2] = z + t1 * dz;
    at_q[3] = 0;
    const int left = body.rank[e[2]], right = body.rank[e[3]];
    const auto pp = static_cast<std::uint32_t>(p), qq = static_cast<std::uint32_t>(q);
    borders.add(pp, qq, static_cast<std::uint32_t>(left)), borders.add(qq, pp, static_cast<std::uint32_t>(right));
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

GRUS_INLINE bool join_lines(const Lines& lines, int across, Borders& of_a, Borders& of_b) {
  if (!lines.clear || lines.count != lines.ended) return false;
  for (int k = 0; k < lines.count; ++k) {
    const int line = lines.begun[k];
    if (lines.to[line] == none) return false;
    of_a.add(lines.from[line], lines.to[line], static_cast<std::uint32_t>(line / across));
    of_b.add(lines.to[line], lines.from[line], static_cast<std::uint32_t>(line % across));
  }
  return true;
}

}  // namespace
}  // namespace grus::dem
