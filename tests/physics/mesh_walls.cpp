// SPDX-License-Identifier: LGPL-3.0-or-later
// Walls of triangles: places nearest in closed form, the grid against all triangles, spheres on flat meshes against
// planes, edges and corners counted once, round surfaces, moving ones; same bits for any threads; checkpoints.
#include "dem/contact/mesh_pairs.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/state_hash.hpp"
#include "dem/rve/wall_force.hpp"
#include "dem/sample/gauge.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

using Corners = std::vector<Vec3>;
using Faces = std::vector<std::array<Index, 3>>;

Wall mesh_wall(const Corners& corner, const Faces& face, const Vec3& point = Vec3::Zero()) {
  return {.point = point,
          .shape = MeshWall{std::make_shared<Triangles>(surface_of(corner, face))},
          .velocity = Vec3::Zero(),
          .material = 1};
}

/// A square of side 2 a about the origin in the plane z = 0, of n x n pairs of triangles.
Wall sheet(double a, int n) {
  Corners corner;
  Faces face;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) corner.emplace_back(a * (2.0 * i / n - 1), a * (2.0 * j / n - 1), 0);
  const auto at = [&](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      face.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      face.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});  // the other way round: it does not matter
    }
  return mesh_wall(corner, face);
}

/// A cube's surface, 2 a wide, about the origin.
Wall cube(double a) {
  Corners corner;
  for (int k = 0; k < 8; ++k) corner.emplace_back(k & 1 ? a : -a, k & 2 ? a : -a, k & 4 ? a : -a);
  return mesh_wall(corner, {{0, 1, 3},
                            {0, 3, 2},
                            {4, 5, 7},
                            {4, 7, 6},
                            {0, 1, 5},
                            {0, 5, 4},
                            {2, 3, 7},
                            {2, 7, 6},
                            {0, 2, 6},
                            {0, 6, 4},
                            {1, 3, 7},
                            {1, 7, 5}});
}

constexpr double stiffness = 1e5;  // N/m, of a contact with a rigid wall

/// A sphere of radius 1 at a place, and the force of a wall on it.
Vec3 push(const Wall& wall, const Vec3& x) {
  const Model model = linear_model(stiffness, 1, 2650, 0);
  State s;
  add(s, PolyEllipsoid::sphere(1), x, 2650);
  s.boundary.walls.push_back(wall);
  Team team(1);
  prepare(model, s, team);
  return -wall_force(s, 0);
}

State rolling(const Model& model, const Wall& wall, Team& team) {
  State s;
  const double overlap = 1e-3;
  add(s, PolyEllipsoid::sphere(1), Vec3(-2.3, 0.37, 1 - overlap), 2650, Vec3(4, 0.2, 0), Vec3(0, 1, 3));
  s.boundary.walls.push_back(wall);
  prepare(model, s, team);
  return s;
}

}  // namespace

TEST_CASE("the nearest place of a triangle is inside, on an edge or a corner: against a search") {
  const Corners corner{{0, 0, 0}, {2, 0, 0}, {0.5, 1.5, 0.2}};
  const Triangles t = surface_of(corner, {{0, 1, 2}});
  for (int k = 0; k < 200; ++k) {
    Vec3 x;
    for (int i = 0; i < 3; ++i)
      x[i] = 4 * random_uniform(7, static_cast<std::uint64_t>(k), Purpose::radius, static_cast<std::uint64_t>(i)) - 1.5;
    const double is = (nearest_on(t, 0, x) - x).norm();
    double least = INFINITY;
    constexpr int n = 200;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        least =
            std::min(least, (corner[0] + (i * (corner[1] - corner[0]) + j * (corner[2] - corner[0])) / n - x).norm());
    CHECK(is <= least + 1e-12);
    CHECK(is > least - 2.0 / n);  // of the search's grid
  }
}

TEST_CASE("the grid finds the triangles within a reach, in order: those of a search through all") {
  const Wall wall = sheet(3, 7);
  const Triangles& t = *wall.mesh();
  std::vector<Index> found;
  for (int k = 0; k < 100; ++k) {
    Vec3 x;
    for (int i = 0; i < 3; ++i)
      x[i] = 8 * random_uniform(9, static_cast<std::uint64_t>(k), Purpose::radius, static_cast<std::uint64_t>(i)) - 4;
    triangles_near(t, x, 1.1, found);
    std::vector<Index> wanted;
    for (Index i = 0; i < t.triangle.size(); ++i)
      if ((nearest_on(t, i, x) - x).norm() <= 1.1) wanted.push_back(i);
    CHECK(found == wanted);
  }
  CHECK(surface_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}).triangle.empty());  // no area
}

TEST_CASE("numbers of triangles keep their order in the place of an image") {
  std::array<std::int16_t, 3> last{-1, 0, 0};
  for (const Index t : {0u, 1u, 32767u, 32768u, 65535u, 1000000u, (1u << 30u) - 1}) {
    CHECK(triangle_of({0, 0, image_of_triangle(t)}) == t);
    CHECK(last < image_of_triangle(t));
    last = image_of_triangle(t);
  }
}

TEST_CASE(
    "a sphere at a cube of triangles is pushed by its faces, edges and corners once each, and by two walls of a "
    "hollow as by two planes") {
  const Wall box = cube(5);
  const double depth = 0.1, force = stiffness * depth;
  const auto is = [&](const Vec3& x, const Vec3& wanted) {
    INFO(x.transpose());
    CHECK((push(box, x) - wanted).norm() < 1e-9 * force);
  };
  const double out = 5 + 1 - depth, in = 5 - 1 + depth;
  is(Vec3(1, 2, out), Vec3(0, 0, force));  // a face, on its diagonal and off it
  is(Vec3(1, 1, out), Vec3(0, 0, force));
  is(Vec3(0, 0, -out), Vec3(0, 0, -force));
  const Vec3 slant = Vec3(1, 0, 1).normalized(), diagonal = Vec3::Ones().normalized();
  is(Vec3(5, 0.3, 5) + (1 - depth) * slant, force * slant);         // an edge
  is(5 * Vec3::Ones() + (1 - depth) * diagonal, force * diagonal);  // a corner
  is(Vec3(4.95, 0, out), Vec3(0, 0, force));                        // near the edge, over the face: the other is hidden
  is(Vec3(1, 2, in), Vec3(0, 0, -force));                           // from within
  is(Vec3(in, 2, in), Vec3(-force, 0, -force));                     // where two faces meet
  is(Vec3(in, in, in), Vec3(-force, -force, -force));
  is(Vec3(in, 2, 5 - 1 + 0.04), Vec3(-force, 0, -stiffness * 0.04));
  is(Vec3(0, 0, 7), Vec3::Zero());
}

TEST_CASE("the far side of a thin plate is not felt, and a round surface is as stiff as one plane") {
  const Wall plate = mesh_wall({{-5, -5, 0}, {5, -5, 0}, {0, 8, 0}, {-5, -5, -0.05}, {5, -5, -0.05}, {0, 8, -0.05}},
                               {{0, 1, 2}, {3, 4, 5}});
  CHECK(push(plate, Vec3(0, 0, 0.9)).z() == Approx(0.1 * stiffness).epsilon(1e-12));
  Corners corner;  // a cylinder of radius 5 about y, of 60 strips: 6 degrees from one to the next
  Faces face;
  constexpr Index n = 60;
  for (Index k = 0; k < n; ++k)
    for (const double y : {-4.0, 4.0})
      corner.emplace_back(5 * std::cos(2 * pi * k / n), y, 5 * std::sin(2 * pi * k / n));
  for (Index k = 0; k < n; ++k) {
    const Index a = 2 * k, b = 2 * ((k + 1) % n);
    face.push_back({a, b, a + 1}), face.push_back({b, a + 1, b + 1});
  }
  const Wall tube = mesh_wall(corner, face);
  const double flat = 5 * (1 - std::cos(pi / n));  // strips lie so much further in between their edges
  for (int k = 0; k < 50; ++k) {
    const double at = 0.0137 * k;
    const Vec3 x(4.1 * std::cos(at), 0.1, 4.1 * std::sin(at));
    const double force = push(tube, x).norm();
    CHECK(force >= stiffness * 0.1 * (1 - 1e-9));
    CHECK(force <= stiffness * (0.1 + flat) * (1 + 1e-9));
  }
}

TEST_CASE("a sphere that rolls over the edges of a flat mesh feels nothing of them: that on a plane to 1e-12") {
  const Model model = linear_model(stiffness, 0.8, 2650, 0.3);
  Team team(1);
  Wall plane{.shape = PlaneWall{Vec3::UnitZ()}, .material = 1};
  for (const int n : {1, 4, 13}) {
    INFO(n);
    State flat = rolling(model, plane, team), mesh = rolling(model, sheet(3.5, n), team);
    for (State* s : {&flat, &mesh}) {
      s->dt = 2e-4;
      run_steps(model, *s, 5000, team);
    }
    const Motion &a = flat.grains.motion[0], &b = mesh.grains.motion[0];
    CHECK(a.position.x() > 1);  // over many edges
    CHECK((a.position - b.position).norm() < 1e-12 * 10);
    CHECK((a.velocity - b.velocity).norm() < 1e-12 * 10 * a.velocity.norm());
    CHECK((a.spin - b.spin).norm() < 1e-11 * a.spin.norm());
    CHECK(mesh.ledger.friction == Approx(flat.ledger.friction).epsilon(1e-10));
  }
}

TEST_CASE("a mesh that moves throws grains as a plane does; any number of threads and a checkpoint keep the bits") {
  const Model model = model_of(solid(1e8, 0.2, 2650, 0.5, 0.6));
  std::vector<std::uint64_t> hashes;
  double work = 0, error = 0;
  for (const int way : {-1, 1, 3, 0}) {  // threads; -1: of a plane; 0: over a checkpoint
    Team team(way == 3 ? 3 : 1);
    State s;
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j)
        add(s, PolyEllipsoid::sphere(1), Vec3(2.1 * i, 2.1 * j, 6 + 0.01 * i), 2650, Vec3(0.1 * j, 0, -1));
    Wall wall = way < 0 ? Wall{.shape = PlaneWall{Vec3::UnitZ()}, .material = 1} : sheet(7.5, 5);
    wall.velocity = Vec3(0.3, 0, 2);
    s.boundary.walls.push_back(wall);
    prepare(model, s, team);
    run_for(model, s, 1.5, team);
    if (way == 0) {
      State again = state_of(bytes_of(s));
      check_state(model, again);
      CHECK(hash(again) == hash(s));
      s = std::move(again);
    }
    run_for(model, s, 1.5, team);
    CHECK(s.grains.motion[24].velocity.z() > 1);  // thrown up
    const double now = told_energy_error(s, stored_energy(model, s));
    if (way < 0) work = s.ledger.work, error = now;
    CHECK(s.ledger.work == Approx(work).epsilon(1e-9));
    CHECK(std::abs(now - error) < 1e-9);
    if (way >= 0) hashes.push_back(hash(s));
  }
  CHECK((hashes[0] == hashes[1] && hashes[0] == hashes[2]));
}
