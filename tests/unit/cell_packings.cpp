// SPDX-License-Identifier: LGPL-3.0-or-later
// Cells in outlines, prisms on a lattice, clusters, the bonds between them, and the power law of bursts.
#include <numeric>

#include "dem/base/random.hpp"
#include "dem/packing/clusters.hpp"
#include "dem/packing/packing.hpp"
#include "dem/packing/prisms.hpp"
#include "dem/packing/random_hulls.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "dem/rve/bursts.hpp"
#include "dem/sample/strain_gauges.hpp"
#include "dem/shape/hull_measures.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

double volume_of(const Tessellation& cells) {
  return std::accumulate(cells.body.begin(), cells.body.end(), 0.0,
                         [](double sum, const Polyhedron& p) { return sum + moments_of(p).volume; });
}

State state_of_voronoi(const Model& model, const Tessellation& cells) {
  State s;
  add_voronoi_grains(model, cells, 0, s);
  return s;
}

}  // namespace

TEST_CASE("hexagonal prisms: volume and moments of the polygon; each meets six others, and those above and below") {
  const Tessellation cells = hexagonal_prisms(Vec3(5, 5, 3), 0.5, 1, 0);
  // Widths of 0.866 along x: five and, half a width on, five; rows of 0.75 along y: five and a half; three layers.
  REQUIRE(cells.seed.size() == 5 * 6 * 3);
  const SolidMoments one = moments_of(cells.body[0]);
  CHECK(std::abs(one.volume - 0.6495190528) < 1e-9);
  CHECK(std::abs(one.second(0, 0) + one.second(1, 1) - 0.0676582) < 1e-6);
  const auto surrounded = [](const Tessellation& all, std::size_t by) {  // and partners lie across the faces
    std::size_t whole = 0;
    for (std::size_t i = 0; i < all.seed.size(); ++i) {
      whole += all.partner[i].size() == by;
      for (const auto& face : all.body[i].face) {
        if (face.tag < 0) continue;
        const Vec3 to = all.seed[all.partner[i][static_cast<std::size_t>(face.tag)].cell] - all.seed[i];
        CHECK((to.normalized() - face.normal).norm() < 1e-12);
        CHECK(std::abs(0.5 * to.norm() - (face.offset - face.normal.dot(all.seed[i]))) < 1e-12);
      }
    }
    return whole;
  };
  CHECK(surrounded(cells, 8) == 3 * 4);  // inner columns, inner rows, the middle layer
  // Within a circle, about a prism in its middle: all centres up to seven widths away (Saleme 2016's disc). The corners
  // furthest out are 7 widths and 5 sides away, of twelve prisms that a hair less room leaves out.
  const double side = 0.57, room = 2 * std::sqrt(7 * 7 * 3 + 5.0 * 5) * side;
  const Tessellation disc = hexagonal_prisms(Vec3(room, room, 5), side, 5, 0, true);
  REQUIRE(disc.seed.size() == 187);
  CHECK(surrounded(disc, 6) == 139);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : disc.seed) middle += x / 187;
  CHECK((middle - Vec3(0.5 * room, 0.5 * room, 2.5)).norm() < 1e-12);
  CHECK(hexagonal_prisms(Vec3(room, room, 5) * (1 - 1e-6), side, 5 * (1 - 1e-6), 0, true).seed.size() == 175);
  const Model model = rock(elastic());
  const State tight = state_of_voronoi(model, cells);
  const State loose = state_of_voronoi(model, hexagonal_prisms(Vec3(5, 5, 3), 0.5, 1, 0.1));
  REQUIRE(tight.bonds.size() == loose.bonds.size());
  // Smaller faces at the lattice's distance: 0.5 - 0.1 / sqrt 3 of side.
  const double shrunk = 1 - 0.2 / std::sqrt(3.0);
  for (std::size_t k = 0; k < loose.bonds.size(); ++k) {
    const FaceBond &a = tight.bonds.face.row[k], &b = loose.bonds.face.row[k];
    const bool above = std::abs(cells.seed[a.ends.a].z() - cells.seed[a.ends.b].z()) > 0.5;
    CHECK(std::abs(b.area / a.area - (above ? shrunk * shrunk : shrunk)) < 1e-9);
    CHECK(std::abs(b.kn / a.kn - 1) < 1e-12);
  }
  CHECK_THROWS(hexagonal_prisms(Vec3(0.8, 5, 3), 0.5, 1, 0));
}

TEST_CASE("cells fill the outline of a prism and of a poly-ellipsoid, whose volume and centre they keep") {
  Team team(1);
  const std::array<Vec3, 3> corners{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, 0)};
  CHECK(std::abs(volume_of(voronoi_packing(prism_space(corners, 4), 40, 2, 1, team)) - 12) < 1e-9);
  const PolyEllipsoid shape{{1, 1.2, 0.8}, {0.7, 1, 1.5}};
  const TessellationSpace space = polyellipsoid_space(shape, 100);
  CHECK(std::abs(space.volume() / volume(shape) - 1) < 1e-9);
  // 200 planes leave caps of some 1 / 200 of the surface: the body is as much as half a per cent out of shape.
  CHECK((moments_of(space.body).centre - centre_of_mass(shape)).norm() < 0.01);
  for (const Vec3& x : space.body.vertex) {
    const double out = std::sqrt(x.cwiseProduct(x).dot(octant_squares(shape, x).cwiseInverse()));
    CHECK(out < 1.06);
  }
  CHECK(std::abs(volume_of(voronoi_packing(space, 60, 3, 1, team)) / volume(shape) - 1) < 1e-9);
}

TEST_CASE(
    "grains of a packing become clusters of cells: volume, mass centre and pose are kept, none is bonded to another") {
  Team team(1);
  State parents;
  GrainSpec a, b;
  a.shape = PolyEllipsoid{{1, 1.2, 0.8}, {0.7, 1, 1.5}}, a.position = Vec3(3, 4, 5);
  a.orientation = Quat(0.8, 0.36, 0.48, 0), a.density = density;
  b.shape = PolyEllipsoid::sphere(1.1), b.position = Vec3(-3, 1, 0), b.density = density;
  set_grain(parents.grains, 0, a), set_grain(parents.grains, 1, b);
  const Tessellation cells = fill_grains(parents.grains, 25, 5, 7, team);
  const State s = state_of_voronoi(rock(elastic()), cells);
  for (Index i = 0; i < 2; ++i) {
    double mass = 0;
    Vec3 centre = Vec3::Zero();
    for (std::size_t k = 0; k < cells.seed.size(); ++k)
      if (cells.cluster[k] == i) mass += s.grains.mass[k], centre += s.grains.mass[k] * s.grains.motion[k].position;
    CHECK(std::abs(mass / parents.grains.mass[i] - 1) < 1e-9);
    CHECK((centre / mass - parents.grains.motion[i].position).norm() < 0.02);
    // The longest way is where the grain's is.
    const Vec3 along = a.orientation * Vec3(0, 0, -1);
    double furthest = 0;
    for (std::size_t k = 0; k < cells.seed.size(); ++k)
      for (const Vec3& x : cells.body[k].vertex)
        if (cells.cluster[k] == i) furthest = std::max(furthest, along.dot(x - parents.grains.motion[i].position));
    const double wanted = i == 0 ? 1.5 - 0.375 * 0.7 : 1.1;
    CHECK(std::abs(furthest / wanted - 1) < 0.06);
  }
  for (const FaceBond& bond : s.bonds.face.row) CHECK(cells.cluster[bond.ends.a] == cells.cluster[bond.ends.b]);
}

TEST_CASE("a mesh that is drawn out is prisms, however long the body is against its cells") {
  Team team(2);
  for (const double length : {1.0, 10.0, 60.0, 400.0}) {  // of bodies whose cells are 1.4 wide
    TessellationSpace space = box_space(Vec3(10, 10, length));
    space.extruded = true;
    const Tessellation cells = voronoi_packing(space, 50, 20, 3, team);
    CAPTURE(length);
    REQUIRE(cells.body.size() == 50);
    for (const Polyhedron& body : cells.body)
      for (const Vec3& x : body.vertex) REQUIRE(std::min(std::abs(x.z()), std::abs(x.z() - length)) < 1e-9 * length);
    CHECK(volume_of(cells) == Approx(100 * length).epsilon(1e-9));
  }
}

TEST_CASE("bonds between clusters are weaker as asked, in energy by the square, or not there") {
  Team team(1);
  const TessellationSpace space = periodic_space(Vec3(4, 4, 4));
  Tessellation cells = voronoi_packing(space, 200, 3, 1, team);
  const std::size_t all = state_of_voronoi(rock(cohesive(1e3, 1)), cells).bonds.size();
  deal_to_clusters(space, 5, 1, team, cells);
  for (Index c = 0; c < 5; ++c) CHECK(std::count(cells.cluster.begin(), cells.cluster.end(), c) > 15);
  BondModel bond = cohesive(1e3, 1);
  const State open = state_of_voronoi(rock(bond), cells);
  bond.between = 400;
  const State closed = state_of_voronoi(rock(bond), cells);
  CHECK(closed.bonds.size() == all);
  std::size_t across = 0;
  for (const FaceBond& b : closed.bonds.face.row) {
    const bool apart = cells.cluster[b.ends.a] != cells.cluster[b.ends.b];
    across += apart;
    CHECK(b.tension == (apart ? 400 : 1000));
    CHECK(b.cohesion == 2 * b.tension);
    CHECK(std::abs(b.energy_1 - (apart ? 0.16 : 1)) < 1e-12);
    CHECK(std::abs(b.energy_2 - (apart ? 0.48 : 3)) < 1e-12);
  }
  CHECK(open.bonds.size() == all - across);
  // Surface of five cells of 64 / 5 in volume among bonds of 200 of 64 / 200: the ratio of the sizes, some 0.3.
  CHECK(across > all / 6);
  CHECK(across < all / 2);
}

namespace {

struct Round {
  double sphericity, angularity;
};

Round round_of(const Polyhedron& body) {
  HullStore store;
  HullPlace place;
  const Index row = add_hull(store, body, place);
  return {sphericity(store.row[row]), angularity(store[row])};
}

}  // namespace

TEST_CASE("sphericity and angularity of cube, beam, tetrahedron and octahedron by closed form") {
  const Round cube = round_of(box_between(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  CHECK(std::abs(cube.sphericity - std::cbrt(pi / 6)) < 1e-12);
  CHECK(std::abs(cube.angularity - pi / std::sqrt(2.0)) < 1e-12);
  const Round beam = round_of(box_between(Vec3(0, 0, 0), Vec3(4, 1, 1)));
  CHECK(std::abs(beam.sphericity - std::cbrt(36 * pi * 16) / 18) < 1e-12);
  // Four edges of 4 at 1/sqrt 2 from the middle, eight of 1 at sqrt(4 + 1/4); a face at 1/2.
  CHECK(std::abs(beam.angularity - pi / 2 * 2 * (16 * std::sqrt(0.5) + 8 * std::sqrt(4.25)) / 24) < 1e-12);
  const Round four = round_of(hull_of(std::vector<Vec3>{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}));
  CHECK(std::abs(four.angularity - std::sqrt(3.0) * (pi - std::acos(1.0 / 3))) < 1e-12);
  const Round eight =
      round_of(hull_of(std::vector<Vec3>{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}));
  CHECK(std::abs(eight.angularity - std::sqrt(1.5) * std::acos(1.0 / 3)) < 1e-12);
  // A roof over a rectangle 2 x 1, its ridge at 1/2 over the middle: mass centre at 1/6, which is the nearest face.
  const Round roof =
      round_of(hull_of(std::vector<Vec3>{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 1, 0}, {0, 0.5, 0.5}, {2, 0.5, 0.5}}));
  const double third = 1.0 / 36, slope = std::sqrt(0.5);
  const double eaves = 2 * 2 * 0.75 * pi * std::sqrt(0.25 + third), ridge = 2 * 0.5 * pi / 3;
  const double ends = pi * std::sqrt(1 + third) + 2 * pi * slope * std::sqrt(1 + 1.0 / 16 + 1.0 / 144);
  CHECK(std::abs(roof.angularity - 6 * (eaves + ridge + ends) / (8 + 4 * slope)) < 1e-12);
}

TEST_CASE("a stretched polyhedron: planes through its corners, volume by the product") {
  Team team(1);
  const Tessellation cells = voronoi_packing(box_space(Vec3(1, 2, 3)), 30, 2, 5, team);
  const Vec3 factors(2, 0.5, 0.7);
  for (const Polyhedron& cell : cells.body) {
    Polyhedron body = cell;
    stretch(body, factors);
    CHECK(std::abs(moments_of(body).volume / moments_of(cell).volume - factors.prod()) < 1e-12);
    for (const auto& face : body.face) {
      CHECK(std::abs(face.normal.norm() - 1) < 1e-14);
      for (const int v : face.loop)
        CHECK(std::abs(face.normal.dot(body.vertex[static_cast<std::size_t>(v)]) - face.offset) < 1e-12);
      CHECK(face.offset > face.normal.dot(moments_of(body).centre));
    }
  }
}

TEST_CASE(
    "random hulls have the unit sphere's volume and lie in spheres that fit; they are rounder the more they relax") {
  Team team(1);
  const auto mean = [&](int rounds, const Vec3& aspect) {
    const std::vector<UnitHull> hulls = random_hulls(rounds, aspect, 7, team);
    REQUIRE(hulls.size() > 200);
    Round sum{};
    for (const UnitHull& h : hulls) {
      const SolidMoments m = moments_of(h.body);
      CHECK(std::abs(m.volume - 4 * pi / 3) < 1e-12);
      CHECK(m.centre.norm() < 1e-12);
      CHECK(std::abs(std::max_element(h.body.vertex.begin(), h.body.vertex.end(),
                                      [](const Vec3& a, const Vec3& b) { return a.norm() < b.norm(); })
                         ->norm() -
                     h.reach) < 1e-14);
      const Round r = round_of(h.body);
      sum.sphericity += r.sphericity / static_cast<double>(hulls.size());
      sum.angularity += r.angularity / static_cast<double>(hulls.size());
    }
    return sum;
  };
  const Round random = mean(0, Vec3::Ones()), relaxed = mean(20, Vec3::Ones()), flat = mean(20, Vec3(1, 0.8, 0.4));
  // Between Poisson's cells, 4.836 / 5.821 by mean surface (Meijering 1953), and truncated octahedra.
  const double poisson = 4.836 / 5.821, best = 0.910;
  CHECK(std::abs(random.sphericity - poisson) < 0.03);
  CHECK(relaxed.sphericity < best);
  CHECK(relaxed.sphericity > 0.5 * (poisson + best));
  CHECK(random.angularity > 1.2 * relaxed.angularity);
  CHECK(flat.sphericity < relaxed.sphericity - 0.05);
}

TEST_CASE("a ball of planes: 32 of them touch one sphere, at 60 corners and 90 edges; stretched, its volume stays") {
  const UnitHull ball = ball_of_planes(Vec3::Ones());
  CHECK(ball.body.face.size() == 32);
  CHECK(ball.body.vertex.size() == 60);
  const Shape shape(ball.body);  // a hull has room for it
  CHECK(shape.store.row[0].edges == 90);
  // All faces as far from the centre as the surface is small: V = S d / 3.
  double corners = 0;
  for (const auto& face : ball.body.face) {
    CHECK(std::abs(face.offset - 0.951489973) < 1e-9);
    corners += static_cast<double>(face.loop.size());
  }
  CHECK(corners == 2 * 90);
  CHECK(std::abs(sphericity(shape.store.row[0]) - 0.951489973) < 1e-9);
  CHECK(std::abs(moments_of(ball.body).volume - 4 * pi / 3) < 1e-12);
  CHECK(std::abs(ball.reach - 1.129863637) < 1e-9);
  const Vec3 moments = shape.store.row[0].principal.moments;  // of a body as symmetric as a cube: one
  CHECK(moments.maxCoeff() - moments.minCoeff() < 1e-12);
  const SolidMoments flat = moments_of(ball_of_planes(Vec3(1, 1, 0.5)).body);
  CHECK(std::abs(flat.volume - 4 * pi / 3) < 1e-12);
  CHECK(std::abs(flat.second(2, 2) / flat.second(0, 0) - 0.25) < 1e-12);
}

TEST_CASE("spheres of hulls: reach makes them larger, their solid is what is asked for") {
  RadiusDistribution radius{"uniform", 1.0, 0, 0.8, 1.2};
  Team team(1);
  const std::vector<double> reach{1.2, 1.5, 1.35};
  const Packing p = random_packing(Vec3::Constant(20), radius, 0.2, 0, Container::periodic, 3, team, {}, reach);
  double solid = 0;
  for (std::size_t i = 0; i < p.spheres.size(); ++i) {
    const double r = p.spheres[i].radius / reach[i % reach.size()];
    CHECK(r > 0.8 * 0.98);
    CHECK(r < 1.2 * 1.02);
    solid += 4 * pi / 3 * r * r * r;
  }
  CHECK(std::abs(solid / 8000 - 0.2) < 1e-12);
  CHECK(p.worst_overlap < 1e-6);
}

TEST_CASE("bursts: windows of time; the exponent of a power law is found within its error") {
  std::vector<BrokenBond> broken;
  for (const double t : {0.1e-3, 0.9e-3, 1.1e-3, 5.5e-3}) broken.push_back({t, Vec3(t, 0, 1), 1 + t, 2});
  const std::vector<Burst> bursts = bursts_of(broken, 1e-3);
  REQUIRE(bursts.size() == 3);
  CHECK(bursts[0].bonds == 2);
  CHECK(bursts[0].energy == 4);
  CHECK(std::abs(bursts[0].middle.x() - (0.1e-3 * 1.0001 + 0.9e-3 * 1.0009) / 2.001) < 1e-15);
  CHECK(std::abs(bursts[2].time - 5e-3) < 1e-15);
  CHECK(std::isnan(fit_power_law(std::vector<Burst>(5, Burst{0, 1})).exponent));
  for (const double exponent : {0.8, 1.5, 2.5}) {
    constexpr std::size_t largest = 300, count = 4000;
    std::vector<double> below{0};
    for (std::size_t s = 1; s <= largest; ++s)
      below.push_back(below.back() + std::pow(static_cast<double>(s), -exponent));
    std::vector<Burst> drawn;
    for (std::uint64_t k = 0; k < count; ++k) {
      const double u = below.back() * random_uniform(11, k, Purpose::strength, 0);
      const auto at = std::upper_bound(below.begin(), below.end(), u) - below.begin();
      drawn.push_back({0, static_cast<std::size_t>(std::min<std::ptrdiff_t>(at, largest))});
    }
    const PowerLaw law = fit_power_law(drawn);
    CHECK(law.error < 0.05);
    CHECK(std::abs(law.exponent - exponent) < 4 * law.error);
  }
}

TEST_CASE("two equal grains are not filled alike") {
  Team team(1);
  State parents;
  for (std::size_t i = 0; i < 2; ++i) {
    GrainSpec grain;
    grain.shape = PolyEllipsoid::sphere(1), grain.position = Vec3(3 * static_cast<double>(i), 0, 0);
    grain.density = density;
    set_grain(parents.grains, i, grain);
  }
  const Tessellation cells = fill_grains(parents.grains, 12, 0, 7, team);
  double nearest = INFINITY;
  for (std::size_t i = 0; i < cells.seed.size(); ++i)
    for (std::size_t j = 0; j < cells.seed.size(); ++j)
      if (cells.cluster[i] == 0 && cells.cluster[j] == 1)
        nearest = std::min(nearest, (cells.seed[i] + Vec3(3, 0, 0) - cells.seed[j]).norm());
  CHECK(nearest > 1e-3);  // of 12 by 12 pairs in a sphere of radius 1
}

TEST_CASE("bursts of one and two bonds: exponent and error by hand") {
  std::vector<Burst> drawn(80, Burst{0, 1});
  drawn.resize(100, Burst{0, 2});
  const PowerLaw law = fit_power_law(drawn);  // 2^-e / (1 + 2^-e) of them are two
  CHECK(law.exponent == Approx(2).epsilon(1e-9));
  CHECK(law.error == Approx(1 / (std::log(2.0) * std::sqrt(100 * 0.2 * 0.8))).epsilon(1e-9));
}

TEST_CASE(
    "strain gauges read the affine motion of the middle, whatever the ends do, and nothing where centres do not "
    "differ") {
  Team team(1);
  State first = state_of_voronoi(rock(elastic()), voronoi_packing(box_space(Vec3(2, 2, 4)), 120, 1, 3, team));
  Wall bottom, top;
  top.point = Vec3(0, 0, 4);
  first.boundary.walls = {bottom, top};
  Mat3 gradient;
  gradient << 2e-3, 1e-4, 3e-4, -2e-4, 1e-3, 5e-4, 1e-4, -3e-4, -5e-3;
  State now = first;
  std::size_t ends = 0;
  for (std::size_t i = 0; i < now.grains.size(); ++i) {
    Vec3& x = now.grains.motion[i].position;
    const bool middle = std::abs(x.z() - 2) <= 1;
    ends += !middle;
    x += middle ? Vec3(Vec3(7, 8, 9) + gradient * x) : Vec3(0.1 * x.z(), 0.2, 0.3 * x.x());
  }
  REQUIRE(ends > 30);
  CHECK((gauged_gradient(first, now, 2) - gradient).norm() < 1e-12);
  // Motion that is not affine: the part of it that is, weighted by mass.
  double mass = 0, second = 0, third = 0;
  Vec3 centre = Vec3::Zero();
  const auto each = [&](auto&& f) {
    for (std::size_t i = 0; i < first.grains.size(); ++i)
      if (const Vec3& x = first.grains.motion[i].position; std::abs(x.z() - 2) <= 1) f(first.grains.mass[i], x, i);
  };
  each([&](double m, const Vec3& x, std::size_t) { mass += m, centre += m * x; });
  centre /= mass;
  now = first;
  each([&](double m, const Vec3& x, std::size_t i) {
    const double z = x.z() - centre.z();
    second += m * z * z, third += m * z * z * z;
    now.grains.motion[i].position.x() += 1e-3 * z * z;
  });
  const Mat3 bent = gauged_gradient(first, now, 2);
  CHECK(std::abs(bent.row(1).norm()) < 1e-12);
  // A parabola in z alone correlates with x and y a little, as centres are where they are; its slope along z does not
  // exceed what its third moment gives by more than that.
  CHECK(std::abs(bent(0, 2) - 1e-3 * third / second) < 5e-5);
  State layer = state_of_voronoi(rock(elastic()), hexagonal_prisms(Vec3(5, 5, 1), 0.5, 1, 0));
  bottom.shape = PlaneWall{Vec3(0, 1, 0)}, top.point = Vec3(0, 5, 0);
  layer.boundary.walls = {bottom, top};
  now = layer;
  for (Motion& m : now.grains.motion) m.position += Vec3(-1e-3 * m.position.x(), 2e-3 * m.position.y(), 0);
  const Mat3 flat = gauged_gradient(layer, now, 1);
  CHECK(std::abs(flat(0, 0) + 1e-3) < 1e-12);
  CHECK(std::abs(flat(1, 1) - 2e-3) < 1e-12);
  CHECK(std::isnan(flat(2, 2)));
}
