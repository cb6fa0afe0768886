// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/split_hull.hpp"

#include <atomic>

#include "dem/shape/fewer_planes.hpp"
#include "dem/shape/section.hpp"

namespace grus::dem {
namespace {

/// In the plane, of the hull's size.
constexpr double flush = 1e-10;

}  // namespace

bool can_split(const Cut&, const Grains& g, std::size_t i) { return g.kind[i] == ShapeKind::hull; }

Pieces pieces_of(const Cut&, const Grains& g, std::size_t i, const Wanted& wanted, std::uint64_t) {
  const Vec3 normal = wanted.plane ? *wanted.plane : Vec3(principal_axes(wanted.stress).directions.col(2));
  const Quat& q = g.orientation[i];
  const Vec3 n = q.conjugate() * normal;
  const HullView hull = (*g.hulls)[g.hull[i]];
  const double size = g.motion[i].radius;
  Pieces out;
  out.orientation = q;
  std::array<Polyhedron, 2> part{body_of(hull), body_of(hull)};
  cut(part[0], n, wanted.offset, hull.faces, flush * size);
  cut(part[1], -n, -wanted.offset, hull.faces, flush * size);
  for (const Polyhedron& body : part)
    if (body.empty()) return out;  // no plane through it: it stays whole
  for (const Polyhedron::Face& face : part[0].face)
    if (face.tag == hull.faces) out.face.push_back({0, 1, n, moments_of(part[0], face)});
  for (Polyhedron& body : part) {
    out.planes_dropped += drop_planes(body, hull.faces);
    if (!fits(body)) return {{}, q};
    const double room = moments_of(body).volume;
    GrainSpec piece;
    piece.shape = PolyEllipsoid::sphere(std::cbrt(3 * room / (4 * pi)));
    piece.material = g.material[i];
    piece.density = solid_mass(g, i) / g.extent[i].volume;
    out.piece.push_back(piece);
    out.body.push_back(std::move(body));
  }
  return out;
}

void put_bodies(Grains& g, std::size_t i, Pieces& pieces) {
  if (pieces.body.empty()) return;
  std::shared_ptr<HullStore> store;
  if (g.hulls.use_count() == 1) {  // nobody else sees it grow; who has just let it go has read it before
    std::atomic_thread_fence(std::memory_order_acquire);
    store = std::const_pointer_cast<HullStore>(g.hulls);
  } else {
    store = std::make_shared<HullStore>(*g.hulls);
  }
  for (std::size_t k = 0; k < pieces.piece.size(); ++k) {
    HullPlace place;
    GrainSpec& piece = pieces.piece[k];
    piece.hull = add_hull(*store, pieces.body[k], place);
    piece.position = g.motion[i].position + pieces.orientation * place.origin;
    piece.orientation = pieces.orientation * place.axes;
    if (!g.crystal.empty()) piece.crystal = place.axes.conjugate() * g.crystal[i];
    pieces.place.push_back(place);
  }
  g.hulls = std::move(store);
}

}  // namespace grus::dem
