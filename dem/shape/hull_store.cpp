// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/shape/hull_store.hpp"

#include <algorithm>
#include <map>

#include "dem/base/error.hpp"
#include "dem/base/members.hpp"

namespace grus::dem {
namespace {

/// How many numbers of `column` a hull has.
std::size_t columns_of(const HullRow& row) {
  return static_cast<std::size_t>(3 * in_eights(static_cast<int>(row.vertices)) +
                                  8 * in_eights(static_cast<int>(row.faces))) +
         std::size_t{4} * row.vertices;
}

/// Vertices and planes in columns of whole eights, as HullView says.
void fill_columns(HullStore& store, const HullRow& row) {
  const std::uint32_t room = static_cast<std::uint32_t>(in_eights(static_cast<int>(row.vertices))),
                      space = static_cast<std::uint32_t>(in_eights(static_cast<int>(row.faces)));
  store.column.resize(row.column + columns_of(row));
  double* to = &store.column[row.column];
  for (Eigen::Index k = 0; k < 3; ++k)
    for (std::uint32_t v = 0; v < room; ++v) *to++ = store.vertex[row.vertex + (v < row.vertices ? v : 0)][k];
  for (Eigen::Index k = 0; k < 3; ++k)
    for (std::uint32_t f = 0; f < space; ++f) *to++ = f < row.faces ? store.plane[row.plane + f].normal[k] : 0;
  for (std::uint32_t f = 0; f < space; ++f) *to++ = f < row.faces ? store.plane[row.plane + f].offset : INFINITY;
  for (std::uint32_t f = 0; f < space; ++f) {
    for (Eigen::Index k = 0; k < 3; ++k) *to++ = f < row.faces ? store.plane[row.plane + f].normal[k] : 0;
    *to++ = f < row.faces ? store.plane[row.plane + f].offset : INFINITY;
  }
  for (std::uint32_t v = 0; v < row.vertices; ++v) {
    for (Eigen::Index k = 0; k < 3; ++k) *to++ = store.vertex[row.vertex + v][k];
    *to++ = 0;
  }
}

/// Every edge once, from the face that runs it upwards.
void add_edges(HullStore& store, HullRow& row, const Polyhedron& body) {
  row.edge = static_cast<std::uint32_t>(store.edge.size());
  std::map<std::pair<int, int>, std::size_t> left;
  for (std::size_t f = 0; f < body.face.size(); ++f)
    for (std::size_t k = 0; k < body.face[f].loop.size(); ++k)
      left[{body.face[f].loop[k], body.face[f].loop[(k + 1) % body.face[f].loop.size()]}] = f;
  for (const auto& [ends, face] : left) {
    if (ends.first > ends.second) continue;
    const std::size_t right = left.at({ends.second, ends.first});
    for (const std::size_t x :
         {static_cast<std::size_t>(ends.first), static_cast<std::size_t>(ends.second), face, right})
      store.edge.push_back(static_cast<std::uint8_t>(x));
  }
  row.edges = (static_cast<std::uint32_t>(store.edge.size()) - row.edge) / 4;
}

}  // namespace

std::vector<std::uint64_t> belongings(const std::uint8_t* edge, std::size_t edges, std::size_t vertices) {
  std::vector<std::uint64_t> rows(3 * vertices);
  const auto bit = [](std::size_t k) { return std::uint64_t{1} << (k % 64); };
  for (std::size_t k = 0; k < edges; ++k, edge += 4)
    for (const int end : {0, 1}) {
      std::uint64_t* row = &rows[std::size_t{3} * edge[end]];
      row[0] |= bit(edge[2]) | bit(edge[3]), row[1 + k / 64] |= bit(k);
    }
  return rows;
}

Index add_hull(HullStore& store, const Polyhedron& given, HullPlace& at) {
  if (given.vertex.size() > most_hull_vertices || given.face.size() > most_hull_faces)
    throw InputError("a hull of " + std::to_string(given.vertex.size()) + " vertices and " +
                     std::to_string(given.face.size()) + " faces: at most 64 and 40");
  const SolidMoments moments = moments_of(given);
  Mat3 second = moments.second / moments.volume;
  // Round-off would turn a body whose axes are principal as they are given.
  if ((second - Mat3(second.diagonal().asDiagonal())).norm() < 1e-13 * second.trace())
    second = Mat3(second.diagonal().asDiagonal());
  const PrincipalFrame principal = principal_frame(second);
  at = {moments.centre, principal.axes};
  Polyhedron body = given;
  const Mat3 back = principal.axes.toRotationMatrix().transpose();
  place(body, back, -(back * moments.centre));
  HullRow row{};
  row.vertex = static_cast<std::uint32_t>(store.vertex.size()),
  row.plane = static_cast<std::uint32_t>(store.plane.size());
  row.begin = static_cast<std::uint32_t>(store.begin.size()), row.loop = static_cast<std::uint32_t>(store.loop.size());
  row.vertices = static_cast<std::uint32_t>(body.vertex.size()),
  row.faces = static_cast<std::uint32_t>(body.face.size());
  row.volume = moments.volume, row.least_width = least_width(body);
  row.principal = {principal.moments, Quat::Identity()};
  double surface = 0;
  std::size_t corners = 0;
  store.begin.push_back(0);
  for (const auto& face : body.face) {
    store.plane.push_back({face.normal, face.offset});
    for (const int v : face.loop) store.loop.push_back(static_cast<std::uint8_t>(v));
    store.begin.push_back(static_cast<std::uint16_t>(corners += face.loop.size()));
    surface += moments_of(body, face).area;
  }
  for (const Vec3& x : body.vertex) {
    store.vertex.push_back(x);
    row.bounding_radius = std::max(row.bounding_radius, x.norm());
  }
  row.depth = 3 * moments.volume / surface;
  row.column = static_cast<std::uint32_t>(store.column.size());
  fill_columns(store, row);
  add_edges(store, row, body);
  const auto rows = belongings(&store.edge[row.edge], row.edges, row.vertices);
  store.at.insert(store.at.end(), rows.begin(), rows.end());
  store.row.push_back(row);
  return static_cast<Index>(store.row.size() - 1);
}

HullStore only(const HullStore& store, const std::vector<std::uint8_t>& wanted, std::vector<Index>& place) {
  static_assert(member_count<HullStore>() == 8, "another column of the store: take it along below");
  HullStore kept;
  place.assign(store.row.size(), 0);
  const auto take = [](const auto& from, std::uint32_t& at, std::size_t count, auto& to) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(at);
    at = static_cast<std::uint32_t>(to.size());
    to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(count));
  };
  for (std::size_t r = 0; r < store.row.size(); ++r) {
    if (!wanted[r]) continue;
    place[r] = static_cast<Index>(kept.row.size());
    HullRow row = store.row[r];
    const std::size_t corners = store.begin[row.begin + row.faces];
    std::uint32_t at = 3 * row.vertex;
    take(store.at, at, std::size_t{3} * row.vertices, kept.at);
    take(store.vertex, row.vertex, row.vertices, kept.vertex), take(store.plane, row.plane, row.faces, kept.plane);
    take(store.begin, row.begin, row.faces + 1, kept.begin), take(store.loop, row.loop, corners, kept.loop);
    take(store.column, row.column, columns_of(row), kept.column);
    take(store.edge, row.edge, std::size_t{4} * row.edges, kept.edge);
    kept.row.push_back(row);
  }
  return kept;
}

Index add_unturned(HullStore& store, const Polyhedron& body) {
  HullPlace place;
  const Index row = add_hull(store, body, place);
  const HullRow& at = store.row[row];
  const Mat3 axes = place.axes.toRotationMatrix();
  for (std::uint32_t v = 0; v < at.vertices; ++v) store.vertex[at.vertex + v] = axes * store.vertex[at.vertex + v];
  for (std::uint32_t f = 0; f < at.faces; ++f)
    store.plane[at.plane + f].normal = axes * store.plane[at.plane + f].normal;
  fill_columns(store, at);
  return row;
}

}  // namespace grus::dem
