// SPDX-License-Identifier: LGPL-3.0-or-later
// Labelled points to parts that tile their body: by closed forms, and by what any tiling keeps.
#include "dem/fracture/partition.hpp"
#include "dem/packing/random_hulls.hpp"
#include "tests/lattices.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr std::int64_t fresh = 1000;

/// Points of a lattice inside a body, and the class of each that `of` says.
struct Labelled {
  std::vector<Vec3> point;
  std::vector<int> label;
};
template <class F>
Labelled lattice_in(const Polyhedron& body, double spacing, F&& of) {
  Vec3 low = body.vertex[0], high = low;
  for (const Vec3& x : body.vertex) low = low.cwiseMin(x), high = high.cwiseMax(x);
  Labelled out;
  for (double x = low.x() + 0.37 * spacing; x < high.x(); x += spacing)
    for (double y = low.y() + 0.61 * spacing; y < high.y(); y += spacing)
      for (double z = low.z() + 0.43 * spacing; z < high.z(); z += spacing) {
        const Vec3 p(x, y, z);
        if (std::all_of(body.face.begin(), body.face.end(), [&](const auto& f) { return f.normal.dot(p) < f.offset; }))
          out.point.push_back(p), out.label.push_back(of(p));
      }
  return out;
}

/// Volume that two parts share, by planes of the one that cut the other.
double shared(Polyhedron a, const Polyhedron& b) {
  for (const Polyhedron::Face& f : b.face)
    if (!a.empty()) cut(a, f.normal, f.offset, 0, 0);
  return a.empty() || a.face.size() < 4 ? 0 : std::abs(moments_of(a).volume);
}

Mat3 about_origin(const SolidMoments& m) { return m.second + m.volume * m.centre * m.centre.transpose(); }

void check_tiling(const Polyhedron& body, const std::vector<Polyhedron>& parts) {
  const SolidMoments whole = moments_of(body);
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const Polyhedron& part : parts) {
    if (part.empty()) continue;
    const SolidMoments m = moments_of(part);
    CHECK(m.volume > 0);
    volume += m.volume, first += m.volume * m.centre, second += about_origin(m);
  }
  const double size = std::cbrt(whole.volume);
  CHECK(std::abs(volume / whole.volume - 1) < 1e-12);
  CHECK((first - whole.volume * whole.centre).norm() < 1e-12 * whole.volume * size);
  CHECK((second - about_origin(whole)).norm() < 1e-12 * whole.volume * size * size);
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (!parts[a].empty() && !parts[b].empty()) CHECK(shared(parts[a], parts[b]) < 1e-12 * whole.volume);
  // A fresh face is one of both parts.
  for (std::size_t a = 0; a < parts.size(); ++a)
    for (const Polyhedron::Face& face : parts[a].face) {
      if (face.tag < fresh) continue;
      const Polyhedron& other = parts[static_cast<std::size_t>(face.tag - fresh)];
      const auto back = std::find_if(other.face.begin(), other.face.end(), [&](const Polyhedron::Face& f) {
        return f.tag == fresh + static_cast<std::int64_t>(a);
      });
      REQUIRE(back != other.face.end());
      CHECK((back->normal + face.normal).norm() < 1e-14);
      CHECK(std::abs(moments_of(other, *back).area - moments_of(parts[a], face).area) < 1e-11 * size * size);
    }
}

double shortest_edge(const std::vector<Polyhedron>& parts) {
  double least = INFINITY;
  for (const Polyhedron& part : parts)
    for (const Polyhedron::Face& face : part.face)
      for (std::size_t k = 0; k < face.loop.size(); ++k) {
        const auto v = [&](std::size_t n) {
          return part.vertex[static_cast<std::size_t>(face.loop[n % face.loop.size()])];
        };
        least = std::min(least, (v(k + 1) - v(k)).norm());
      }
  return least;
}

}  // namespace

TEST_CASE("three classes of the unit cube have the volumes that their planes say") {
  const Polyhedron cube = box_between(Vec3::Zero(), Vec3::Ones());
  const std::vector<LinearClass> classes{{Vec3::Zero(), 0}, {Vec3::UnitX(), -0.5}, {Vec3::UnitY(), -0.75}};
  const auto parts = parts_of(cube, classes, fresh);
  REQUIRE(parts.size() == 3);
  const double expected[] = {0.375, 0.46875, 0.15625};
  for (std::size_t a = 0; a < 3; ++a) CHECK(std::abs(moments_of(parts[a]).volume - expected[a]) < 1e-12);
  check_tiling(cube, parts);
  for (const Vec3& x : {Vec3(0.2, 0.3, 0.5), Vec3(0.9, 0.8, 0.1), Vec3(0.3, 0.9, 0.6)})
    CHECK(class_at(classes, x) == (x.x() > 0.5 ? 1u : x.y() > 0.75 ? 2u : 0u));
  // Equal slopes: one of them has nothing.
  const std::vector<LinearClass> two{{Vec3::UnitX(), 0}, {Vec3::UnitX(), 0.1}};
  const auto one = parts_of(cube, two, fresh);
  CHECK(one[0].empty());
  CHECK(moments_of(one[1]).volume == Approx(1));
}

TEST_CASE("labels that a plane parts are parted between the layers next to it") {
  const Polyhedron cube = box_between(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  constexpr double spacing = 0.1;
  for (std::uint64_t k = 0; k < 10; ++k) {
    const Vec3 n = k == 0 ? Vec3(Vec3::UnitX()) : Vec3(random_vector(k, 5).normalized());
    const double offset = k == 0 ? 0.2 : 0.05 * static_cast<double>(k % 4);
    const Labelled in = lattice_in(cube, spacing, [&](const Vec3& x) { return n.dot(x) > offset ? 1 : 0; });
    const Parting p = part_by_labels(cube, in.point, in.label, 2, fresh, {});
    REQUIRE(p.part.size() == 2);
    CHECK(p.misfit == 0);
    CHECK(p.joined == 0);
    check_tiling(cube, p.part);
    // The gap between the classes' points is at most a spacing across, so the plane is off by less than that.
    Polyhedron beyond = cube;
    cut(beyond, -n, -offset, fresh, 1e-12);
    CHECK(std::abs(moments_of(p.part[1]).volume - moments_of(beyond).volume) < spacing * std::sqrt(3.0));
    if (k == 0) {  // layers at 0.137 and 0.237: the plane is between them
      CHECK(moments_of(p.part[1]).volume < 0.5 - 0.137);
      CHECK(moments_of(p.part[1]).volume > 0.5 - 0.237);
    }
  }
}

TEST_CASE("power diagrams of random seeds are found again by the labels of points, and tile hulls and balls") {
  for (std::uint64_t k = 0; k < 12; ++k) {
    const Polyhedron body = k % 2 ? some_cells(64).body[k] : ball_of_planes(Vec3::Ones()).body;
    const SolidMoments whole = moments_of(body);
    const double size = std::cbrt(whole.volume);
    std::vector<Vec3> seed;
    for (std::uint64_t s = 0; s < 2 + k % 4; ++s)
      seed.push_back(whole.centre + 0.25 * size * random_vector(50 + k, s).normalized());
    const auto nearest = [&](const Vec3& x) {
      int best = 0;
      for (std::size_t s = 1; s < seed.size(); ++s)
        if ((x - seed[s]).norm() < (x - seed[static_cast<std::size_t>(best)]).norm()) best = static_cast<int>(s);
      return best;
    };
    const Labelled in = lattice_in(body, size / 10, nearest);
    const auto classes = fit_classes(in.point, in.label, seed.size(), size);
    // Points that a plane of the diagram nearly goes through may lie beyond the plane that is found, no others.
    for (std::size_t i = 0; i < in.point.size(); ++i) {
      const auto own = static_cast<std::size_t>(in.label[i]), now = class_at(classes, in.point[i]);
      if (now == own) continue;
      const double before = ((in.point[i] - seed[now]).squaredNorm() - (in.point[i] - seed[own]).squaredNorm()) /
                            (2 * (seed[now] - seed[own]).norm());
      CHECK(before < 0.02 * size / 10);
    }
    check_tiling(body, parts_of(body, classes, fresh));
    const Parting p = part_by_labels(body, in.point, in.label, seed.size(), fresh, {});
    if (p.part.empty()) continue;
    CHECK(p.part.size() + static_cast<std::size_t>(p.joined) == seed.size());
    check_tiling(body, p.part);
    for (const Polyhedron& part : p.part) CHECK(stoutness(part) >= 0.15);
  }
}

TEST_CASE("planes that come near to a corner, an edge or one another go through it, and the parts still tile") {
  const Polyhedron cube = box_between(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  const Vec3 n = Vec3(1, 0.7, 0.3).normalized();
  const double corner = n.dot(Vec3(0.5, -0.5, 0.5));
  std::vector<LinearClass> near{{Vec3::Zero(), 0}, {n, -corner - 4e-4}};
  CHECK(shortest_edge(parts_of(cube, near, fresh)) < 2e-3);
  join_corners(cube, fresh, 2e-3, near);
  auto parts = parts_of(cube, near, fresh);
  CHECK(shortest_edge(parts) > 0.05);
  check_tiling(cube, parts);
  CHECK(std::abs((near[1].slope - near[0].slope).dot(Vec3(0.5, -0.5, 0.5)) + near[1].bias - near[0].bias) < 1e-14);
  // Three classes meet along z, 5e-4 from a face: they meet in it, or where the edge is.
  std::vector<LinearClass> three{{Vec3(-1, -1, 0), 0}, {Vec3(1, -1, 0), 0}, {Vec3(0, 1, 0), 1 - 5e-4}};
  CHECK(shortest_edge(parts_of(cube, three, fresh)) < 2e-3);
  join_corners(cube, fresh, 2e-3, three);
  parts = parts_of(cube, three, fresh);
  CHECK(shortest_edge(parts) > 0.05);
  check_tiling(cube, parts);
  // Far from all: they stay as they are.
  std::vector<LinearClass> far{{Vec3::Zero(), 0}, {Vec3(1, 0.2, 0.3), 0.1}};
  const std::vector<LinearClass> as_it_was = far;
  join_corners(cube, fresh, 2e-3, far);
  CHECK(far[1].slope == as_it_was[1].slope);
  CHECK(far[1].bias == as_it_was[1].bias);
  // And in balls of many corners, cut in three at random.
  const Polyhedron ball = ball_of_planes(Vec3::Ones()).body;
  for (std::uint64_t k = 0; k < 40; ++k) {
    std::vector<LinearClass> some;
    for (std::uint64_t c = 0; c < 3; ++c) some.push_back({random_vector(k, c), 0.2 * random_vector(k, 9)[int(c)]});
    join_corners(ball, fresh, 0.02, some);
    check_tiling(ball, parts_of(ball, some, fresh));
  }
}

TEST_CASE("thin wedges are joined to the part that they share most with; what is left whole is told as no parts") {
  const Polyhedron cube = box_between(Vec3::Constant(-0.5), Vec3::Constant(0.5));
  CHECK(stoutness(cube) == Approx(1 / std::sqrt(3.0)));
  // Slabs 0.1 wide are thinner than 0.15 of their length, 1.4.
  const auto slab = [](const Vec3& x) { return x.x() < -0.2 ? 0 : x.x() < -0.1 ? 1 : 2; };
  const Labelled in = lattice_in(cube, 0.05, slab);
  const Parting p = part_by_labels(cube, in.point, in.label, 3, fresh, {});
  REQUIRE(p.part.size() == 2);
  CHECK(p.joined == 1);
  CHECK(p.misfit == 0);
  check_tiling(cube, p.part);
  // One over two halves and under a whole goes with the whole: its face is larger.
  const auto stack = [](const Vec3& x) { return x.z() > 0.15 ? 3 : x.z() > 0.05 ? 2 : x.x() > 0 ? 1 : 0; };
  const Labelled stacked = lattice_in(cube, 0.05, stack);
  const Parting three = part_by_labels(cube, stacked.point, stacked.label, 4, fresh, {});
  REQUIRE(three.part.size() == 3);
  CHECK(three.misfit < 0.01);
  CHECK(three.of == std::vector<std::size_t>{0, 1, 2});  // of those joined the lower
  check_tiling(cube, three.part);
  const Parting all = part_by_labels(cube, in.point, in.label, 3, fresh, {.least_stoutness = 0});
  CHECK(all.part.size() == 3);
  CHECK(all.of == std::vector<std::size_t>{0, 1, 2});
  const Labelled thin = lattice_in(cube, 0.05, [](const Vec3& x) { return x.x() < -0.35 ? 0 : 1; });
  const Parting none = part_by_labels(cube, thin.point, thin.label, 2, fresh, {});
  CHECK(none.part.empty());
  CHECK(none.joined == 1);
  // Points of nobody count neither for a class nor as misfits.
  Labelled some = lattice_in(cube, 0.1, [](const Vec3& x) { return x.z() > 0.1 ? 1 : 0; });
  for (std::size_t i = 0; i < some.label.size(); i += 7) some.label[i] = -1;
  const Parting q = part_by_labels(cube, some.point, some.label, 2, fresh, {});
  REQUIRE(q.part.size() == 2);
  CHECK(q.misfit == 0);
  // A class without points has no part.
  CHECK(part_by_labels(cube, some.point, some.label, 3, fresh, {}).part.size() == 2);
}

TEST_CASE("what was torn out is told from the rest by where it went, and is a piece, a crumb or nothing by its size") {
  const PointLattice l = make_lattice(lattice_sphere(0.5), lattice_of(1000), 1, 3);
  const PeridynamicSolid solid(l, poisson);
  const auto told = [&](double above, double least, bool crumbs, double rest = 0) {
    const PointColumns u = field(l, 1, [&](const Vec3& x) {
      return (l.axes * x).z() > above ? Vec3(0.2 * x.y(), 3, 1) : Vec3(rest * Vec3(-3, 0.1 * x.x(), 0));
    });
    Clusters c = torn_apart(solid, u, least, crumbs);
    std::size_t up = 0, wrong = 0;
    for (std::size_t i = 0; i < l.size(); ++i) {
      const bool high = l.point[i].z() > above;
      up += high, wrong += (c.piece[i] == 1) != (high && c.pieces + c.crumbs > 1);
    }
    CHECK(wrong == 0);
    return std::tuple(c.pieces, c.crumbs, up);
  };
  const auto [pieces, crumbs, up] = told(0.35, 0.03, false);
  CHECK(pieces == 2);
  CHECK(crumbs == 0);
  CHECK(static_cast<double>(up) ==
        Approx(1000 * 0.15 * 0.15 * 1.35 / 0.5).epsilon(0.2));  // of a cap: h^2 (3 r - h) / 4 r^3
  CHECK(std::get<0>(told(0.1, 0.03, false, 1)) == 2);           // halves that part from each other
  const double share = static_cast<double>(up) / static_cast<double>(l.size());
  CHECK(std::get<0>(told(0.35, 1.01 * share, false)) == 1);
  CHECK(std::get<1>(told(0.35, 1.01 * share, false)) == 0);
  CHECK(std::get<0>(told(0.35, 1.01 * share, true)) == 1);
  CHECK(std::get<1>(told(0.35, 1.01 * share, true)) == 1);
  double top = -1, below = -1;  // of the points' heights: one point alone is no crumb
  for (const Vec3& x : l.point)
    if (x.z() > top)
      below = top, top = x.z();
    else
      below = std::max(below, x.z());
  CHECK(told(0.5 * (top + below), 0.03, true) == std::tuple(1, 0, std::size_t{1}));
}
