// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/lattice.hpp"

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"

namespace grus::dem {
namespace {

/// Where a box of cells with empty ones around keeps cell (i, j, k): those of a row's end are the next row's begin.
struct Box {
  int low[3], reach;
  std::int32_t row, layer;
  std::size_t cells;

  Box(const int* first, const int* last, int pad) : reach(pad) {
    int wide[3];
    for (int c = 0; c < 3; ++c) low[c] = first[c], wide[c] = last[c] - first[c] + 1 + pad;
    row = wide[0], layer = wide[0] * wide[1];
    cells = static_cast<std::size_t>(wide[2] + pad) * static_cast<std::size_t>(layer) +
            static_cast<std::size_t>(pad * row + pad) + 8;  // a group of eight may read beyond
  }
  std::int32_t step(const int* at) const { return at[0] + at[1] * row + at[2] * layer; }
  std::uint32_t operator()(const int* at) const {
    const int from[3] = {at[0] - low[0] + reach, at[1] - low[1] + reach, at[2] - low[2] + reach};
    return static_cast<std::uint32_t>(step(from));
  }
};

/// The part of a line a + t d that lies in the solid (shares of the diameter); empty: from > to.
struct Part {
  double from, to;
};
Part inside(const LatticeSolid& solid, double diameter, const Vec3& a, const Vec3& d) {
  Part part{-INFINITY, INFINITY};
  if (solid.planes.empty()) {
    const double dd = d.squaredNorm(), middle = -a.dot(d) / dd, rest = 0.25 - a.squaredNorm() + middle * middle * dd;
    if (rest < 0) return {1, 0};
    return {middle - std::sqrt(rest / dd), middle + std::sqrt(rest / dd)};
  }
  for (const Plane& plane : solid.planes) {
    const double slope = plane.normal.dot(d), room = plane.offset / diameter - plane.normal.dot(a);
    if (slope > 0) part.to = std::min(part.to, room / slope);
    if (slope < 0) part.from = std::max(part.from, room / slope);
    if (slope == 0 && room < 0) return {1, 0};
  }
  return part;
}

struct Site {
  int at[3];
};

std::vector<Site> sites_in(const LatticeSolid& solid, const Mat3& axes, const Vec3& origin, double spacing) {
  std::vector<Site> sites;
  const double diameter = solid.diameter();
  const int far = static_cast<int>(solid.bounding_radius / diameter / spacing) + 2;
  for (int k = -far; k <= far; ++k)
    for (int j = -far; j <= far; ++j) {
      const Vec3 a = spacing * (axes * (origin + Vec3(0, j, k))), d = spacing * axes.col(0);
      const Part part = inside(solid, diameter, a, d);
      if (!(part.from <= part.to)) continue;
      for (int i = static_cast<int>(std::ceil(part.from)); i <= static_cast<int>(std::floor(part.to)); ++i)
        sites.push_back({{i, j, k}});
    }
  return sites;
}

Box box_around(const std::vector<Site>& sites, int reach) {
  int low[3], high[3];
  for (int c = 0; c < 3; ++c) {
    const auto [least, most] = std::minmax_element(sites.begin(), sites.end(),
                                                   [c](const Site& a, const Site& b) { return a.at[c] < b.at[c]; });
    low[c] = least->at[c], high[c] = most->at[c];
  }
  return {low, high, reach};
}

/// A point hangs on too few others where there is a direction in which they hold it by less than this share of what a
/// whole family does. The corner of a cube has 0.07.
constexpr double least_hold = 0.02;

/// Takes out what hangs on too few, until nothing does.
void drop_loose(std::vector<Site>& sites, const std::vector<LatticeNeighbour>& family, int reach) {
  double whole = 0;
  for (const LatticeNeighbour& n : family) whole += n.weight;
  for (bool more = true; more && !sites.empty();) {
    const Box box = box_around(sites, reach);
    std::vector<std::uint8_t> taken(box.cells);
    for (const Site& s : sites) taken[box(s.at)] = 1;
    const auto loose = [&](const Site& s) {
      double weight = 0;
      Mat3 hold = Mat3::Zero();
      for (const LatticeNeighbour& n : family) {
        if (!taken[static_cast<std::size_t>(static_cast<std::int64_t>(box(s.at)) + box.step(n.at))]) continue;
        const Vec3 to = Vec3(n.at[0], n.at[1], n.at[2]) / n.length;
        weight += n.weight, hold += n.weight * to * to.transpose();
      }
      return weight < 0.4 * whole && principal_values(hold)[0] < least_hold * whole / 3;
    };
    std::vector<Site> kept;
    for (const Site& s : sites)
      if (!loose(s)) kept.push_back(s);
    more = kept.size() < sites.size();
    sites.swap(kept);
  }
}

/// Points, octets and bonds of the sites, which run along x first.
void take_sites(PointLattice& lattice, const std::vector<Site>& sites, const Vec3& origin, double diameter, int reach) {
  const Box box = box_around(sites, reach);
  lattice.cells = box.cells;
  for (const LatticeNeighbour& n : lattice.family) {
    const double length = n.length * lattice.spacing;
    lattice.ways.push_back({{n.at[0] / n.length, n.at[1] / n.length, n.at[2] / n.length},
                            length,
                            n.weight,
                            n.weight * length,
                            box.step(n.at)});
  }
  std::vector<std::uint8_t> taken(box.cells);
  for (const Site& s : sites) {
    lattice.cell.push_back(box(s.at));
    lattice.point.push_back(diameter * lattice.spacing * (lattice.axes * (origin + Vec3(s.at[0], s.at[1], s.at[2]))));
    taken[lattice.cell.back()] = 1;
  }
  for (std::size_t first = 0, next; first < sites.size(); first = next) {
    const std::uint32_t cell = lattice.cell[first];
    for (next = first + 1; next < sites.size() && next < first + 8; ++next)
      if (lattice.cell[next] != cell + (next - first)) break;
    lattice.octet.push_back({cell, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(lattice.bond.size())});
    for (std::size_t w = 0; w < lattice.ways.size(); ++w) {
      unsigned has = 0;
      for (std::size_t l = 0; l < next - first; ++l)
        has |= unsigned{taken[static_cast<std::size_t>(std::int64_t{cell} + lattice.ways[w].step) + l]} << l;
      if (has == 0) continue;
      lattice.way.push_back(static_cast<std::uint16_t>(w));
      lattice.bond.push_back(static_cast<std::uint8_t>(has));
    }
  }
  lattice.octet.push_back(
      {0, static_cast<std::uint32_t>(sites.size()), static_cast<std::uint32_t>(lattice.bond.size())});
}

}  // namespace

LatticeSolid lattice_sphere(double radius) { return {{}, 4 * pi / 3 * radius * radius * radius, 2 * radius, radius}; }

LatticeSolid lattice_hull(const HullStore& store, Index hull) {
  const HullRow& row = store.row[hull];
  return {{&store.plane[row.plane], row.faces}, row.volume, row.least_width, row.bounding_radius};
}

double LatticeChoice::spacing() const { return std::cbrt(pi / 6 / points); }

std::vector<LatticeNeighbour> lattice_family(double horizon, bool partial_volume) {
  std::vector<LatticeNeighbour> family;
  const double far = partial_volume ? horizon + 0.5 : horizon * (1 + 1e-9);
  const int reach = static_cast<int>(far);
  for (int k = -reach; k <= reach; ++k)
    for (int j = -reach; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i) {
        const double length = std::sqrt(i * i + j * j + k * k);
        const double weight = partial_volume ? std::min(1.0, far - length) : 1.0;
        if (length > 0 && length <= far && weight > 0) family.push_back({{i, j, k}, length, weight});
      }
  std::stable_sort(family.begin(), family.end(),
                   [](const LatticeNeighbour& a, const LatticeNeighbour& b) { return a.length < b.length; });
  return family;
}

PointLattice make_lattice(const LatticeSolid& solid, const LatticeChoice& choice, std::uint64_t seed,
                          std::uint64_t id) {
  constexpr std::size_t fewest = 30, most_ways = 65536;  // a way has two bytes
  const double nominal = choice.spacing(), diameter = solid.diameter();
  PointLattice lattice;
  lattice.nominal_spacing = nominal;
  lattice.spacing = std::min(nominal, solid.least_width / (LatticeChoice::layers * diameter));
  if (!(lattice.spacing * std::cbrt(LatticeChoice::most_points) >= nominal)) return {};
  if (choice.turned) lattice.axes = random_rotation(random_bits(seed, id, Purpose::lattice, 0), id).toRotationMatrix();
  const auto draw = [&](std::uint64_t k) { return random_uniform(seed, id, Purpose::lattice, k); };
  const Vec3 origin(draw(3), draw(4), draw(5));
  lattice.family = lattice_family(choice.horizon, choice.partial_volume);
  if (lattice.family.size() > most_ways) throw InputError("a lattice's horizon reaches more than 65536 neighbours");
  int reach = 0;
  for (const LatticeNeighbour& n : lattice.family) reach = std::max(reach, n.at[0]);
  std::vector<Site> sites = sites_in(solid, lattice.axes, origin, lattice.spacing);
  drop_loose(sites, lattice.family, reach);
  if (sites.size() < fewest) return {};
  lattice.volume = pi / 6 / static_cast<double>(sites.size());
  take_sites(lattice, sites, origin, diameter, reach);
  return lattice;
}

std::vector<Vec3> point_forces(const PointLattice& lattice, std::span<const PatchLoad> loads, double patch,
                               double diameter) {
  const std::size_t n = lattice.size();
  std::vector<Vec3> force(n, Vec3::Zero());
  std::vector<std::pair<double, std::size_t>> near(n);
  for (const PatchLoad& load : loads) {
    for (std::size_t i = 0; i < n; ++i) near[i] = {(lattice.point[i] - load.at).norm(), i};
    const double radius = patch_radius(load, patch, diameter);
    const auto beyond = std::partition(near.begin(), near.end(), [&](const auto& x) { return x.first <= radius; });
    auto count = static_cast<std::size_t>(beyond - near.begin());
    if (count < 4) count = std::min<std::size_t>(4, n), std::partial_sort(near.begin(), near.begin() + 4, near.end());
    Vec3 middle = Vec3::Zero();
    for (std::size_t k = 0; k < count; ++k) middle += lattice.point[near[k].second] / static_cast<double>(count);
    Mat3 spread = Mat3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      const Mat3 c = cross_matrix(lattice.point[near[k].second] - middle);
      spread += c.transpose() * c;
    }
    spread += 1e-9 * spread.trace() * Mat3::Identity();  // four in a line
    const Vec3 turn = spread.inverse() * load.couple;
    for (std::size_t k = 0; k < count; ++k)
      force[near[k].second] +=
          load.force / static_cast<double>(count) + turn.cross(lattice.point[near[k].second] - middle);
  }
  Vec3 centre = Vec3::Zero(), total = Vec3::Zero(), moment = Vec3::Zero();
  for (const Vec3& x : lattice.point) centre += x / static_cast<double>(n);
  Mat3 inertia = Mat3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Mat3 c = cross_matrix(lattice.point[i] - centre);
    total += force[i], moment += c * force[i], inertia += c.transpose() * c;
  }
  const Vec3 turn = inertia.inverse() * moment;
  for (std::size_t i = 0; i < n; ++i) {
    force[i] -= total / static_cast<double>(n) + turn.cross(lattice.point[i] - centre);
    force[i] = lattice.axes.transpose() * force[i];
  }
  return force;
}

std::vector<bool> points_near(const PointLattice& lattice, std::span<const PatchLoad> loads, double distance) {
  std::vector<bool> near(lattice.size());
  for (std::size_t i = 0; i < lattice.size(); ++i)
    for (const PatchLoad& load : loads) near[i] = near[i] || (lattice.point[i] - load.at).norm() <= distance;
  return near;
}

double patch_radius(const PatchLoad& load, double patch, double diameter) {
  return std::max(patch * diameter, std::sqrt(load.area / pi));
}

}  // namespace grus::dem
