// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/fewer_planes.hpp"

#include <algorithm>

#include "dem/shape/hull_store.hpp"

namespace grus::dem {
namespace {

/// The body without the plane of face `left_out`; empty where nothing closes it within three times its size.
Polyhedron without(const Polyhedron& body, std::size_t left_out, const Vec3& middle, double size) {
  Polyhedron wider = box_between(middle - Vec3::Constant(3 * size), middle + Vec3::Constant(3 * size));
  for (std::size_t f = 0; f < body.face.size(); ++f) {
    const Polyhedron::Face& face = body.face[f];
    if (f != left_out) cut(wider, face.normal, face.offset, face.tag, 1e-10 * size);
  }
  const bool open =
      std::any_of(wider.face.begin(), wider.face.end(), [](const Polyhedron::Face& face) { return face.tag < 0; });
  return open ? Polyhedron{} : wider;
}

}  // namespace

bool fits(const Polyhedron& body) {
  return body.vertex.size() <= most_hull_vertices && body.face.size() <= most_hull_faces;
}

int drop_planes(Polyhedron& body, std::int64_t kept) {
  if (fits(body)) return 0;
  const SolidMoments before = moments_of(body);
  double size = 0;
  for (const Vec3& x : body.vertex) size = std::max(size, (x - before.centre).norm());
  int dropped = 0;
  while (!fits(body)) {
    Polyhedron best;
    double least = INFINITY;
    for (std::size_t f = 0; f < body.face.size(); ++f) {
      if (body.face[f].tag >= kept) continue;
      Polyhedron wider = without(body, f, before.centre, size);
      if (wider.empty()) continue;
      if (const double volume = moments_of(wider).volume; volume < least) least = volume, best = std::move(wider);
    }
    if (best.empty()) break;
    dropped += static_cast<int>(body.face.size() - best.face.size());
    body = std::move(best);
  }
  const SolidMoments after = moments_of(body);
  stretch(body, Vec3::Constant(std::cbrt(before.volume / after.volume)));
  place(body, Mat3::Identity(), before.centre - moments_of(body).centre);
  return dropped;
}

}  // namespace grus::dem
