// SPDX-License-Identifier: LGPL-3.0-or-later
// A block of points that is opened at a notch: what a crack takes per area, against the toughness that its bonds were
// given.
#include "tests/lattices.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A block of points, its corner at the origin, lengths in spacings.
struct Block {
  Shape shape;
  PointLattice lattice;
  PeridynamicSolid solid;
  std::vector<Vec3> at;

  Block(int length, int width, int height)
      : shape(box_between(Vec3::Zero(), Vec3(length, width, height) / length)),
        lattice(
            make_lattice(lattice_hull(shape.store, 0), lattice_of(length * width * height, 2.5, true, false), 3, 0)),
        solid(lattice, poisson) {
    for (const Vec3& x : lattice.point) at.push_back(length * (shape.place.origin + shape.place.axes * x));
    REQUIRE(lattice.size() == static_cast<std::size_t>(length * width * height));
  }

  /// Calls f(bond, bit, middle) for each end of a bond across the plane of that height.
  template <class F>
  void each_across(double height, F&& f) {
    for (std::size_t k = 0; k + 1 < lattice.octet.size(); ++k)
      for (std::uint32_t b = lattice.octet[k].bond; b < lattice.octet[k + 1].bond; ++b)
        for (std::uint32_t i = lattice.octet[k].point; i < lattice.octet[k + 1].point; ++i) {
          const std::uint32_t bit = i - lattice.octet[k].point;
          if (!(lattice.bond[b] >> bit & 1)) continue;
          const LatticeNeighbour& n = lattice.family[lattice.way[b]];
          const Vec3 to = shape.place.axes * (lattice.axes * Vec3(n.at[0], n.at[1], n.at[2]));
          if ((at[i].z() < height) != (at[i].z() + to.z() < height)) f(b, bit, Vec3(at[i] + 0.5 * to));
        }
  }
};

/// Energy over area of a crack that grows from `from` to `to` spacings, over the toughness: the block is pulled apart
/// at its notched end, bonds break in the order of their stretch, and what each breaking takes at fixed displacement
/// is summed.
double toughness_of(int length, int width, int height, double notch, double from, double to) {
  Block block(length, width, height);
  PeridynamicSolid& solid = block.solid;
  const double middle = 0.5 * height;
  std::size_t all = 0, gone = 0;
  block.each_across(middle, [&](std::uint32_t b, std::uint32_t bit, const Vec3& x) {
    ++all;
    if (x.x() < notch) solid.intact()[b] = static_cast<std::uint8_t>(solid.intact()[b] & ~(1u << bit));
  });
  PointColumns load(block.lattice.size());
  std::vector<bool> held(block.lattice.size());
  std::vector<std::uint8_t> asked(block.lattice.octet.size() - 1);
  const Vec3 up = block.lattice.axes.transpose() * (block.shape.place.axes.conjugate() * Vec3::UnitZ());
  for (std::size_t k = 0; k < asked.size(); ++k)
    for (std::uint32_t i = block.lattice.octet[k].point; i < block.lattice.octet[k + 1].point; ++i) {
      const double x = block.at[i].x();
      held[i] = x < 3;
      if (x < 3)
        for (std::size_t c = 0; c < 3; ++c)
          load(i, c) = (block.at[i].z() > middle ? 1 : -1) * up[static_cast<Eigen::Index>(c)];
      if (x > 6) asked[k] = static_cast<std::uint8_t>(asked[k] | 1u << (i - block.lattice.octet[k].point));
    }
  solid.keep(held);
  PointColumns u(block.lattice.size());
  long sweeps = 0;
  const double spacing = block.lattice.spacing;  // of the diameter
  const double area = width * length * spacing * spacing;
  const double nominal = fracture_energy(Toughness::all_bonds, 1, 1, poisson, 2.5 * spacing);
  double energy = 0, lengths[2] = {-1, -1}, sums[2] = {0, 0};
  REQUIRE(solve(solid, load, u, 1e-5, 3000, sweeps) > 0);
  double give = dot(load, u);
  for (int event = 0; event < 5000; ++event) {
    solid.dilate(u);
    const double stretch = solid.largest_stretch(asked);
    double lost = 0;
    REQUIRE(solid.break_above(0.97 * stretch, lost) > 0);
    REQUIRE(solve(solid, load, u, 1e-4, 3000, sweeps) >= 0);
    const double before = give, force = 1 / stretch;
    give = dot(load, u);
    energy += 0.5 * force * force * before * (1 - before / give);
    gone = 0;
    block.each_across(
        middle, [&](std::uint32_t b, std::uint32_t bit, const Vec3&) { gone += !(solid.intact()[b] >> bit & 1); });
    const double reached = length * static_cast<double>(gone) / static_cast<double>(all);
    for (const int end : {0, 1})
      if (lengths[end] < 0 && reached > (end ? to : from)) lengths[end] = reached, sums[end] = energy;
    if (lengths[1] > 0) break;
  }
  REQUIRE(lengths[1] > 0);
  return (sums[1] - sums[0]) / (nominal * area * (lengths[1] - lengths[0]) / length);
}

}  // namespace

TEST_CASE("a crack takes 1.0 to 1.4 times the toughness that its bonds were given, per area") {
  const double small = toughness_of(36, 6, 24, 12, 15, 21);
  CAPTURE(small);
  CHECK(small > 1.0);
  CHECK(small < 1.4);
}

TEST_CASE("in a larger block it takes less of it", "[.slow]") {
  const double small = toughness_of(36, 6, 24, 12, 15, 21), large = toughness_of(48, 8, 32, 16, 20, 28);
  CAPTURE(small, large);
  CHECK(large > 1.0);
  CHECK(large < small);
}
