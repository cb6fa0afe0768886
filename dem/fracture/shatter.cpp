// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/shatter.hpp"

#include "dem/shape/fewer_planes.hpp"
#include "dem/shape/section.hpp"

namespace grus::dem {

Pieces pieces_of(const Shatter&, const Grains& g, std::size_t i, const Wanted&, std::uint64_t) {
  return {{}, g.orientation[i]};
}

Pieces pieces_by_labels(const Shatter& splitter, const Grains& g, std::size_t i, std::span<const Vec3> points,
                        std::span<const int> label, std::size_t count, double* misfit, std::size_t crumbs) {
  const HullView hull = (*g.hulls)[g.hull[i]];
  Parting parting =
      part_by_labels(body_of(hull), points, {label.begin(), label.end()}, count, hull.faces, splitter.parting);
  if (misfit) *misfit = parting.misfit;
  Pieces out;
  out.orientation = g.orientation[i];
  constexpr auto gone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> place(parting.part.size(), gone);  // among the pieces
  std::size_t kept = 0;
  for (std::size_t a = 0; a < place.size(); ++a)
    if (parting.of[a] + crumbs < count) place[a] = kept++;
  if (kept == 0) return out;
  out.loses_mass = kept < place.size();
  for (std::size_t a = 0; a < place.size(); ++a)
    for (const Polyhedron::Face& face : parting.part[a].face)
      if (const auto b = static_cast<std::size_t>(std::max<std::int64_t>(0, face.tag - hull.faces));
          face.tag >= hull.faces && a < b && place[a] != gone && place[b] != gone)
        out.face.push_back({place[a], place[b], face.normal, moments_of(parting.part[a], face)});
  for (std::size_t a = 0; a < place.size(); ++a) {
    if (place[a] == gone) continue;
    Polyhedron& body = parting.part[a];
    out.planes_dropped += drop_planes(body, hull.faces);
    if (!fits(body)) return {{}, g.orientation[i]};
    GrainSpec piece;
    piece.shape = PolyEllipsoid::sphere(std::cbrt(3 * moments_of(body).volume / (4 * pi)));
    piece.material = g.material[i];
    piece.density = solid_mass(g, i) / g.extent[i].volume;
    out.piece.push_back(piece);
    out.body.push_back(std::move(body));
  }
  return out;
}

}  // namespace grus::dem
