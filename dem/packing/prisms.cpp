// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/prisms.hpp"

#include <map>

#include "dem/base/error.hpp"

namespace grus::dem {
namespace {

/// Rows along x, every other one moved by half a width; layers along z.
struct Place {
  int column, row, layer;
  auto operator<=>(const Place&) const = default;
};

/// The neighbour across side k: counter-clockwise from the one between the corners at 30 and 90 degrees.
Place across(const Place& p, int k) {
  const int shifted = p.row & 1;
  const int column[6] = {shifted, shifted - 1, -1, shifted - 1, shifted, 1}, row[6] = {1, 1, 0, -1, -1, 0};
  return {p.column + column[k], p.row + row[k], p.layer};
}

}  // namespace

Tessellation hexagonal_prisms(const Vec3& box, double side, double thickness, double gap, bool round) {
  const double width = std::sqrt(3.0) * side, r = side - gap / std::sqrt(3.0);
  constexpr double whole = 1 + 1e-9;
  const int layers = static_cast<int>(std::floor(box.z() / thickness * whole));
  const int rows = static_cast<int>(box.y() / (1.5 * side)), columns = static_cast<int>(box.x() / width);
  const double radius = 0.5 * box.x() * whole;
  const Vec3 first = round ? Vec3(0.5 * box.x(), 0.5 * box.y(), 0) : Vec3(0.5 * width, side, 0);
  const auto fits = [&](double x, double y) {
    if (!round) return x + 0.5 * width <= box.x() * whole && y + side <= box.y() * whole;
    const double across_x = std::abs(x - first.x()), up = std::abs(y - first.y());
    return std::hypot(across_x + 0.5 * width, up + 0.5 * side) <= radius && std::hypot(across_x, up + side) <= radius;
  };
  std::map<Place, Index> at;
  std::vector<Place> places;
  Tessellation cells;
  for (int layer = 0; layer < layers; ++layer)
    for (int row = round ? -rows : 0; row <= rows; ++row)
      for (int column = round ? -columns : 0; column <= columns; ++column) {
        const double x = first.x() + (column + 0.5 * (row & 1)) * width, y = first.y() + 1.5 * row * side;
        if (!fits(x, y)) continue;
        at[{column, row, layer}] = static_cast<Index>(places.size());
        places.push_back({column, row, layer});
        cells.seed.emplace_back(x, y, (layer + 0.5) * thickness);
      }
  if (cells.seed.empty()) throw InputError("not one prism fits");
  std::vector<Vec3> corners(6);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3& x = cells.seed[i];
    const Place& place = places[i];
    for (int k = 0; k < 6; ++k) {
      const double angle = pi / 6 + pi / 3 * k;
      corners[static_cast<std::size_t>(k)] = x + r * Vec3(std::cos(angle), std::sin(angle), 0);
    }
    Polyhedron body = prism_over(corners, x.z() - 0.5 * thickness, x.z() + 0.5 * thickness);
    std::vector<Tessellation::Partner> partners;
    for (auto& face : body.face) {  // sides -1 to -6, bottom -7, top -8
      const auto k = static_cast<int>(-face.tag - 1);
      const Place to = k < 6 ? across(place, k) : Place{place.column, place.row, place.layer + (k == 6 ? -1 : 1)};
      const auto found = at.find(to);
      if (found == at.end()) continue;
      face.tag = static_cast<std::int64_t>(partners.size());
      partners.push_back({found->second});
    }
    cells.body.push_back(std::move(body)), cells.partner.push_back(std::move(partners));
  }
  return cells;
}

}  // namespace grus::dem
