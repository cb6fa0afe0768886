// SPDX-License-Identifier: LGPL-3.0-or-later
// Convex hulls: masses, cuts, Voronoi cells.
#include <random>

#include "dem/base/error.hpp"
#include "dem/shape/contact_patch.hpp"
#include "dem/shape/fewer_planes.hpp"
#include "dem/shape/overlap.hpp"
#include "dem/state/order.hpp"
#include "dem/state/shape_kinds.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

TEST_CASE("masses of hulls are exact: boxes, prisms, a dodecahedron, whatever the origin") {
  const Vec3 far(1e3, -2e3, 5e2);
  Polyhedron box = box_between(far, far + Vec3(1, 2, 3));
  const SolidMoments m = moments_of(box);
  CHECK(m.volume == Approx(6).epsilon(1e-12));
  CHECK((m.centre - far - Vec3(0.5, 1, 1.5)).norm() < 1e-9);
  CHECK(m.second(2, 2) == Approx(6 * 9 / 12.0).epsilon(1e-9));
  CHECK(std::abs(m.second(0, 1)) < 1e-8);

  std::vector<Vec3> corners;
  for (int k = 0; k < 6; ++k) corners.emplace_back(0.5 * std::cos(pi / 3 * k), 0.5 * std::sin(pi / 3 * k), 0);
  const SolidMoments hexagon = moments_of(prism_over(corners, 0, 1));
  CHECK(hexagon.volume == Approx(0.649519).epsilon(1e-6));
  CHECK(hexagon.second(0, 0) + hexagon.second(1, 1) == Approx(0.0676582).epsilon(1e-6));

  const double g = 0.5 * (1 + std::sqrt(5.0));
  std::vector<Vec3> points;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) points.emplace_back(x, y, z);
      points.emplace_back(0, x / g, y * g);
      points.emplace_back(x / g, y * g, 0);
      points.emplace_back(x * g, 0, y / g);
    }
  points.emplace_back(0.1, 0.2, -0.3);  // inside
  const Polyhedron dodecahedron = hull_of(points);
  CHECK(dodecahedron.vertex.size() == 20);
  CHECK(dodecahedron.face.size() == 12);
  const double edge = 2 / g;
  CHECK(moments_of(dodecahedron).volume == Approx((15 + 7 * std::sqrt(5.0)) / 4 * edge * edge * edge).epsilon(1e-12));
}

TEST_CASE("points in a face or in an edge of a hull are none of its corners") {
  // A tetrahedron of three unit edges: volume 1/6, whatever lies in its faces.
  std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  points.emplace_back(1 / 3.0, 1 / 3.0, 0);  // in the middle of a face
  points.emplace_back(0.2, 0.1, 0), points.emplace_back(0.1, 0.2, 0);
  points.emplace_back(0.5, 0.5, 0), points.emplace_back(0.25, 0.75, 0);  // in an edge
  points.emplace_back(1 / 3.0, 1 / 3.0, 1 / 3.0);                        // in the slanted face
  std::mt19937 shuffled(1);
  for (int n = 0; n < 20; ++n) {
    std::shuffle(points.begin(), points.end(), shuffled);
    const Polyhedron body = hull_of(points);
    CHECK(body.vertex.size() == 4);
    CHECK(body.face.size() == 4);
    CHECK(moments_of(body).volume == Approx(1 / 6.0).epsilon(1e-12));
    HullStore store;
    HullPlace place;
    add_hull(store, body, place);
    CHECK(store.row[0].edges == 6);
    CHECK((place.origin - Vec3::Constant(0.25)).norm() < 1e-12);
  }
}

TEST_CASE("points in a plane, or too many, are no hull") {
  std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  CHECK_THROWS_AS(hull_of(flat), InputError);
  std::vector<Vec3> many;
  for (int k = 0; k < 65; ++k) many.push_back(random_vector(1, static_cast<std::uint64_t>(k)).normalized());
  CHECK_THROWS_AS(hull_of(many), InputError);
}

TEST_CASE("a cut divides volume, centre and second moments, and both parts are closed") {
  const Tessellation cells = some_cells(64);
  double worst = 0, open = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const Polyhedron& whole = cells.body[n % cells.body.size()];
    const SolidMoments all = moments_of(whole);
    const Vec3 normal = random_vector(n, 0).normalized();
    const double offset = normal.dot(all.centre + 0.05 * random_vector(n, 1));
    Polyhedron below = whole, above = whole;
    cut(below, normal, offset, 9, 1e-13), cut(above, -normal, -offset, 9, 1e-13);
    SolidMoments sum;
    for (const Polyhedron* part : {&below, &above}) {
      if (part->empty()) continue;
      const SolidMoments m = moments_of(*part);
      const Vec3 d = m.centre - all.centre;
      sum.volume += m.volume, sum.centre += m.volume * m.centre;
      sum.second += m.second + m.volume * d * d.transpose();
      Vec3 closure = Vec3::Zero();
      for (const auto& f : part->face) closure += moments_of(*part, f).area * f.normal;
      open = std::max(open, closure.norm());
    }
    worst = std::max({worst, std::abs(sum.volume / all.volume - 1), (sum.centre / all.volume - all.centre).norm(),
                      (sum.second - all.second).norm() / all.second.norm()});
  }
  CHECK(worst < 1e-12);
  CHECK(open < 1e-13);
}

TEST_CASE("Voronoi cells fill their space; faces are shared; each closes; sum of area x distance is three volumes") {
  Team team(2);
  const auto check = [&](const TessellationSpace& space, std::size_t count, bool bounded) {
    const Tessellation cells = voronoi_packing(space, count, 1, 5, team);
    double volume = 0, reached = 0, open = 0, unlike = 0;
    for (std::size_t i = 0; i < cells.body.size(); ++i) {
      volume += moments_of(cells.body[i]).volume;
      Vec3 closure = Vec3::Zero();
      for (const auto& face : cells.body[i].face) {
        const FaceMoments m = moments_of(cells.body[i], face);
        closure += m.area * face.normal;
        if (face.tag < 0) continue;
        const auto& p = cells.partner[i][static_cast<std::size_t>(face.tag)];
        Vec3 to = cells.seed[p.cell] - cells.seed[i];
        for (int k = 0; k < 3; ++k) to[k] += p.image[static_cast<std::size_t>(k)] * space.periodic[k];
        reached += 0.5 * m.area * to.norm();
        double other = 0;  // area of the same face as the partner has it
        for (const auto& back : cells.body[p.cell].face) {
          if (back.tag < 0) continue;
          const auto& q = cells.partner[p.cell][static_cast<std::size_t>(back.tag)];
          const bool mirrored = q.image[0] == -p.image[0] && q.image[1] == -p.image[1] && q.image[2] == -p.image[2];
          if (q.cell == i && mirrored) other += moments_of(cells.body[p.cell], back).area;
        }
        unlike = std::max(unlike, std::abs(m.area - other));
      }
      open = std::max(open, closure.norm());
    }
    CHECK(volume == Approx(space.volume()).epsilon(1e-10));
    CHECK(open < 1e-11);
    CHECK(unlike < 1e-11);
    if (!bounded) CHECK(reached == Approx(3 * space.volume()).epsilon(1e-9));
  };
  check(periodic_space(Vec3(1, 0.8, 1.3)), 200, false);
  check(periodic_space(Vec3::Ones()), 5, false);  // a cell that meets its own image
  check(box_space(Vec3(1, 2, 0.5)), 200, true);
  check(cylinder_space(1, 0.4), 200, true);
  TessellationSpace disc = cylinder_space(1, 0.1);
  disc.extruded = true;
  check(disc, 300, true);
  CHECK(disc.volume() == Approx(0.1 * 48 * 0.25 * std::tan(pi / 48)).epsilon(1e-12));
  const Tessellation flat = voronoi_packing(disc, 300, 1, 5, team);
  for (const Polyhedron& body : flat.body)
    for (const Vec3& x : body.vertex) CHECK(std::min(std::abs(x.z()), std::abs(x.z() - 0.1)) < 1e-15);
}

TEST_CASE("cells do not depend on the number of threads; Lloyd's rounds even them out") {
  Team one(1), two(2);
  const auto with = [](Team& team, int rounds) {
    return voronoi_packing(periodic_space(Vec3::Ones()), 500, rounds, 1, team);
  };
  const Tessellation a = with(one, 5), b = with(two, 5), raw = with(one, 0);
  REQUIRE(a.body.size() == b.body.size());
  for (std::size_t i = 0; i < a.body.size(); ++i) CHECK(a.body[i].vertex == b.body[i].vertex);
  const auto least = [](const Tessellation& c) {
    double v = INFINITY;
    for (const Polyhedron& body : c.body) v = std::min(v, 500 * moments_of(body).volume);
    return v;
  };
  CHECK(least(raw) < 0.4);
  // In the plane one random cell in a thousand is smaller than a tenth of the mean: merged away, nothing is left empty.
  TessellationSpace sheet = box_space(Vec3(1, 1, 0.1));
  sheet.extruded = true;
  const Tessellation flat = voronoi_packing(sheet, 4000, 0, 2, two);
  CHECK(flat.body.size() < 4000);
  double smallest = INFINITY, filled = 0;
  for (const Polyhedron& body : flat.body) {
    const double v = moments_of(body).volume;
    smallest = std::min(smallest, v), filled += v;
  }
  CHECK(smallest >= 0.1 * 0.1 / 4000);
  CHECK(filled == Approx(0.1).epsilon(1e-9));
  CHECK(least(raw) >= 0.1);  // smaller ones are merged away
  CHECK(least(a) > 0.55);    // 0.63 of the mean for 1,000 cells
}

TEST_CASE("faces of a box are known by where they look: -1 to -6 are -x, +x, -y, +y, -z, +z") {
  const Polyhedron box = box_between(Vec3(1, 2, 3), Vec3(2, 4, 6));
  REQUIRE(box.face.size() == 6);
  for (const auto& face : box.face) {
    const auto k = static_cast<Eigen::Index>(-1 - face.tag);
    const double side = k % 2 ? 1 : -1;
    CHECK((face.normal - side * Vec3::Unit(k / 2)).norm() < 1e-15);
    CHECK(face.offset == Approx(side * Vec3(k % 2 ? Vec3(2, 4, 6) : Vec3(1, 2, 3))[k / 2]));
  }
}

TEST_CASE("a round of Lloyd's moves each seed to the centre of its cell of the round before") {
  Team team(1);
  const TessellationSpace space = box_space(Vec3(1, 2, 1.5));
  Tessellation before = voronoi_packing(space, 30, 0, 4, team);
  REQUIRE(before.seed.size() == 30);
  for (const int rounds : {1, 2, 3}) {
    const Tessellation now = voronoi_packing(space, 30, rounds, 4, team);
    REQUIRE(now.seed.size() == 30);
    for (std::size_t i = 0; i < 30; ++i) CHECK((now.seed[i] - moments_of(before.body[i]).centre).norm() < 1e-12);
    before = now;
  }
}

TEST_CASE("a body of too many corners loses the plane that adds least, and has volume and mass centre as before") {
  constexpr int n = 32;
  std::vector<Vec3> corners;
  for (int k = 0; k < n; ++k) corners.emplace_back(std::cos(2 * pi / n * k), std::sin(2 * pi / n * k), 0);
  const auto numbered = [](Polyhedron body) {
    for (std::size_t f = 0; f < body.face.size(); ++f) body.face[f].tag = static_cast<std::int64_t>(f);
    return body;
  };
  const Polyhedron whole = numbered(prism_over(corners, 0, 1));
  Polyhedron same = whole;
  CHECK(fits(whole));
  CHECK(drop_planes(same, 100) == 0);
  CHECK(same.vertex.size() == 64);
  // An upright edge is planed off: 66 corners. Without that face the prism is what it was.
  Polyhedron planed = whole;
  const double depth = 1e-3, side = 2 * std::sin(pi / n), outer = 2 * pi / n;
  cut(planed, Vec3::UnitX(), 1 - depth, 99, 1e-12);
  REQUIRE(planed.vertex.size() == 66);
  const SolidMoments before = moments_of(planed);
  const auto height = [](const Polyhedron& body) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3& x : body.vertex) low = std::min(low, x.z()), high = std::max(high, x.z());
    return high - low;
  };
  for (const bool kept : {false, true}) {
    Polyhedron body = planed;
    CHECK(drop_planes(body, kept ? 99 : 100) == 1);
    CHECK(fits(body));
    const SolidMoments after = moments_of(body);
    CHECK(std::abs(after.volume / before.volume - 1) < 1e-12);
    CHECK((after.centre - before.centre).norm() < 1e-12);
    CHECK(std::any_of(body.face.begin(), body.face.end(), [](const auto& f) { return f.tag == 99; }) == kept);
    // Else a side next to it goes, the shortest: a triangle on what is left of it, its angles those between the sides.
    const double half = depth / std::tan(pi / n), left = side - depth / std::sin(pi / n);
    const double at_edge = 0.5 * outer, beyond = outer;  // where it meets the planed face, and the next side
    const double rise = left / (1 / std::tan(at_edge) + 1 / std::tan(beyond));
    const double added = kept ? 0.5 * left * rise : half * depth;
    CHECK(height(body) == Approx(std::cbrt(before.volume / (before.volume + added))).epsilon(1e-12));
  }
}

TEST_CASE("hulls of no grain leave the store: what is left has the same bytes, rollers keep theirs") {
  HullStore store;
  HullPlace at;
  const Tessellation cells = some_cells(40);
  for (const Polyhedron& body : cells.body) add_hull(store, body, at);
  State s;
  s.grains.hulls = std::make_shared<const HullStore>(store);
  const std::shared_ptr<const HullStore> shared = s.grains.hulls;
  const std::vector<Index> rows{30, 7, 7, 12, 39};
  for (const Index row : rows) {
    GrainSpec spec;
    spec.hull = row, spec.density = 1;
    set_grain(s.grains, s.grains.size(), spec);
  }
  Wall roller;
  roller.shape = RollerWall{Vec3::UnitZ(), 1, 20};
  s.boundary.walls = {roller, Wall{}};
  s.contacts.guesses.row.resize(1);
  s.contacts.guesses.row[0].guess.octets = 2;
  free_hulls(s.grains, s.boundary.walls, s.contacts.guesses);
  CHECK(s.grains.hulls->row.size() == 5);
  CHECK(shared->row.size() == 40);
  CHECK(s.contacts.guesses.row[0].guess.octets == 0);  // of whose rows nobody knows
  const auto same = [&](Index is, Index was) {
    const HullView a = (*s.grains.hulls)[is], b = store[was];
    CHECK((a.vertices == b.vertices && a.faces == b.faces && a.edges == b.edges));
    const auto equal = [](const auto* x, const auto* y, int count) { CHECK(std::equal(x, x + count, y)); };
    equal(a.vertex, b.vertex, a.vertices), equal(a.edge, b.edge, 4 * a.edges), equal(a.begin, b.begin, a.faces + 1);
    equal(a.loop, b.loop, a.begin[a.faces]), equal(a.column, b.column, 3 * a.room + 4 * a.space);
    equal(a.rows, b.rows, 4 * a.space + 4 * a.vertices), equal(a.at, b.at, 3 * a.vertices);
    for (int f = 0; f < a.faces; ++f)
      CHECK((a.plane[f].normal == b.plane[f].normal && a.plane[f].offset == b.plane[f].offset));
    CHECK(s.grains.hulls->row[is].volume == store.row[was].volume);
  };
  for (std::size_t i = 0; i < rows.size(); ++i) same(s.grains.hull[i], rows[i]);
  same(std::get<RollerWall>(s.boundary.walls[0].shape).hull, 20);
  // While few are dead, nothing moves.
  const std::shared_ptr<const HullStore> now = s.grains.hulls;
  s.grains.hull[0] = s.grains.hull[1];
  free_hulls(s.grains, s.boundary.walls, s.contacts.guesses);
  CHECK(s.grains.hulls == now);
}

TEST_CASE("a hull is drawn as far as the first of its planes that a ray meets, in every direction") {
  State s;
  const Vec3 half(0.5, 1, 1.5);
  const std::size_t i = add_body(s, box_between(-half, half), Vec3(3, 2, 1), Quat::Identity());
  const Frame frame = frame_of(s.grains, i);
  for (std::uint64_t n = 0; n < 50; ++n) {
    const Vec3 seen = random_vector(n, 0).normalized();
    const Vec3 drawn = shape_functions(s.grains.kind[i]).drawn(s.grains, i, frame, frame.axes.transpose() * seen);
    const double reach = half.cwiseQuotient(seen.cwiseAbs()).minCoeff();
    CHECK((drawn - (Vec3(3, 2, 1) + reach * seen)).norm() < 1e-12);
  }
}

TEST_CASE(
    "a patch resists turns by its second moments: a cube in a plane by hand, cells in cells by their polar moment") {
  const double h = 0.1, side = 1.0 / 12 + h / 2 + h / 6, up = 4 * h * h * h / 3;  // the face, and of four sides a strip
  const Shape cube(unit_cube());
  const std::vector<Plane> floor{{Vec3::UnitZ(), -0.5 + h}};
  const Mat3 t = turning_of_patch(cube.view(), floor, Vec3(0, 0, -0.5));
  CHECK((t - Mat3(Vec3(side + up, side + up, 2 * side).asDiagonal())).norm() < 1e-14);
  const Tessellation cells = some_cells(30);
  int met = 0;
  for (std::uint64_t n = 0; n < 200; ++n) {
    const Shape a(cells.body[n % 30]), b(cells.body[(7 * n + 3) % 30]);
    const Mat3 turn = rotation_by(random_vector(n, 0)).toRotationMatrix();
    const Vec3 search = random_vector(n, 1).normalized(), shift = 0.25 * search;
    const Overlap o = overlap_by_faces(a.view(), b.view(), turn, shift, search);
    if (!(o.volume > 0)) continue;
    std::vector<Plane> planes;
    for (int f = 0; f < b.view().faces; ++f) {
      const Vec3 normal = turn * b.view().plane[f].normal;
      planes.push_back({normal, b.view().plane[f].offset + normal.dot(shift)});
    }
    const Mat3 patch = turning_of_patch(a.view(), planes, o.middle);
    CHECK(0.5 * patch.trace() == Approx(o.polar).epsilon(1e-9));
    CHECK(patch.eigenvalues().real().minCoeff() > 0);
    ++met;
  }
  CHECK(met > 50);
}
