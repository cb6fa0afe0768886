// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rve/reduce_cell.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/contact/tiles.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

using Image = std::array<std::int16_t, 3>;

/// Round-off must not shorten edges for ever.
bool shorter(const Vec3& a, const Vec3& than) { return a.squaredNorm() < (1 - 1e-9) * than.squaredNorm(); }

void tell_anew(Image& image, const Mat3& back) {
  constexpr double most = 30000;
  const Vec3 n = at_image(back, image);
  if (n.cwiseAbs().maxCoeff() > most)
    throw Unstable(
        fmt::format("the periodic cell has been deformed until grains that touch are {:.3g} cells apart: "
                    "end the run earlier",
                    n.cwiseAbs().maxCoeff()));
  for (int k = 0; k < 3; ++k) image[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(std::lround(n[k]));
}

void swap_pairs(Contacts& c, std::size_t i, std::size_t j) {
  std::swap(c.pair[i], c.pair[j]);
  std::swap(c.touch[i], c.touch[j]);
  std::swap(c.active[i], c.active[j]);
  if (!c.spot.empty()) std::swap(c.spot[i], c.spot[j]);
  const Contact kept = c.contact[i];
  c.contact.set(i, c.contact[j]);
  c.contact.set(j, kept);
}

/// The list is searched by (a, b, image): pairs of the same two grains may have changed their order.
void sort_images(Contacts& c, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin + 1; k < end; ++k)
    for (std::size_t j = k; j > begin && by_place(c.pair[j], c.pair[j - 1]); --j) swap_pairs(c, j, j - 1);
}

}  // namespace

Mat3 shortest_edges(const Mat3& vectors) {
  Mat3 v = vectors, m = Mat3::Identity();
  auto take = [&](int i, const Vec3& whole) {  // edge i becomes the sum of whole multiples
    m.col(i) = Vec3(m * whole);
    v.col(i) = Vec3(vectors * m.col(i));
  };
  constexpr int enough = 1000;  // each shortens an edge by a factor: a shear of 1e9 takes 60
  bool again = true;
  for (int round = 0; again && round < enough; ++round) {
    again = false;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        if (i == j) continue;
        const double n = std::nearbyint(v.col(i).dot(v.col(j)) / v.col(j).squaredNorm());
        const Vec3 whole = Vec3::Unit(i) - n * Vec3::Unit(j);
        if (n != 0 && shorter(v * whole, v.col(i))) take(i, whole), again = true;
      }
    if (again) continue;
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (v.col(k).squaredNorm() > v.col(longest).squaredNorm()) longest = k;
    const Vec3 p = Vec3::Unit((longest + 1) % 3), q = Vec3::Unit((longest + 2) % 3);
    for (const Vec3& other : {Vec3(p + q), Vec3(p - q), Vec3(q - p), Vec3(-p - q)})
      if (shorter(v * (Vec3::Unit(longest) + other), v.col(longest))) {
        take(longest, Vec3::Unit(longest) + other), again = true;
        break;
      }
  }
  return m;
}

bool reduce_cell(State& state, double gain) {
  Cell& cell = state.boundary.cell;
  if (!cell.everywhere() || !(gain < INFINITY)) return false;
  const Mat3 m = shortest_edges(cell.vectors);
  if (m.isIdentity(0)) return false;
  if (Cell{.vectors = cell.vectors * m}.height() < gain * cell.height()) return false;
  const Mat3 back = m.inverse();  // whole numbers: cofactors over 1
  for (std::size_t k = 0; k < state.contacts.begin[first_wall]; ++k) tell_anew(state.contacts.pair[k].image, back);
  for_each_bond(state.bonds, [&](auto& bond) { tell_anew(bond.ends.image, back); });
  for (Handed& h : state.bonds.handed) tell_anew(h.ends.image, back);
  cell.vectors = cell.vectors * m, cell.rate = cell.rate * m;
  cell.whole = back * cell.whole;
  Contacts& c = state.contacts;
  for (std::size_t bin = 0; bin < first_wall; ++bin)
    for (std::size_t t = 0; t < c.apart[bin].size(); ++t) {
      sort_images(c, c.tile[bin][t], c.apart[bin][t]);
      sort_images(c, c.apart[bin][t], c.tile[bin][t + 1]);
    }
  index_images(cell, c);
  state.reference.cell = state.reference.cell * m;
  state.reference.room.anchor.clear();  // candidates are told of the edges before
  return true;
}

}  // namespace grus::dem
