// SPDX-License-Identifier: LGPL-3.0-or-later
// Bodies from files of other programs, and the faces that they share, against what they were written from.
#include <fmt/format.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "dem/base/error.hpp"
#include "dem/packing/surfaces.hpp"
#include "dem/packing/voronoi_grains.hpp"
#include "tests/bonded.hpp"
#include "tests/hulls.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

namespace files = std::filesystem;

/// A file of this text, which goes with the object.
struct File {
  files::path path;
  File(const std::string& ending, const std::string& bytes)
      : path(files::temp_directory_path() / fmt::format("grus_bodies_{}{}", getpid(), ending)) {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  ~File() { files::remove(path); }
  File(const File&) = delete;
  std::vector<Surface> read() const { return read_surfaces(path.string()); }
};

std::string in_digits(const Vec3& x, int digits) {
  return fmt::format("{:.{}g} {:.{}g} {:.{}g}", x.x(), digits, x.y(), digits, x.z(), digits);
}

template <class F>
void each_triangle(const Polyhedron& body, F&& f) {
  for (const auto& face : body.face)
    for (std::size_t k = 1; k + 1 < face.loop.size(); ++k) f(std::array{face.loop[0], face.loop[k], face.loop[k + 1]});
}

const Vec3& corner(const Polyhedron& body, int v) { return body.vertex[static_cast<std::size_t>(v)]; }

std::string stl(const std::vector<Polyhedron>& bodies) {
  std::string text;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    text += fmt::format("solid body {}\n", i);
    each_triangle(bodies[i], [&](const auto& t) {
      text += "facet normal 0 0 0\n outer loop\n";
      for (const int v : t) text += "  vertex " + in_digits(corner(bodies[i], v), 16) + "\n";
      text += " endloop\nendfacet\n";
    });
    text += "endsolid\n";
  }
  return text;
}

std::string binary_stl(const Polyhedron& body) {
  std::string bytes(80, ' '), facets;
  std::uint32_t count = 0;
  each_triangle(body, [&](const auto& t) {
    ++count;
    facets += std::string(12, '\0');
    for (const int v : t)
      for (const double x : corner(body, v)) {
        const auto b = std::bit_cast<std::array<char, 4>>(static_cast<float>(x));
        facets.append(b.begin(), b.end());
      }
    facets += std::string(2, '\0');
  });
  const auto head = std::bit_cast<std::array<char, 4>>(count);
  return bytes.append(head.begin(), head.end()) + facets;
}

std::string obj(const std::vector<Polyhedron>& bodies) {
  std::string text = "# polygons\nmtllib none.mtl\n";
  std::size_t before = 1;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    text += fmt::format("o body{}\nusemtl {}\n", i, i % 2 ? "odd" : "even");
    for (const Vec3& x : bodies[i].vertex) text += "v " + in_digits(x, 16) + "\n";
    for (const auto& face : bodies[i].face) {
      text += "f";
      for (const int v : face.loop) text += fmt::format(" {}//7", before + static_cast<std::size_t>(v));
      text += "\n";
    }
    before += bodies[i].vertex.size();
  }
  return text;
}

std::string ply(const Polyhedron& body, bool binary) {
  std::string text = fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "property uchar red\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      binary ? "binary_big_endian" : "ascii", body.vertex.size(), body.face.size());
  const auto put = [&](auto v) {
    auto b = std::bit_cast<std::array<char, sizeof v>>(v);
    std::reverse(b.begin(), b.end());
    text.append(b.begin(), b.end());
  };
  for (const Vec3& x : body.vertex) {
    if (binary)
      put(x.x()), put(x.y()), put(x.z()), put(std::uint8_t{9});
    else
      text += in_digits(x, 16) + " 9\n";
  }
  for (const auto& face : body.face) {
    if (binary) put(static_cast<std::uint8_t>(face.loop.size()));
    if (!binary) text += fmt::format("{}", face.loop.size());
    for (const int v : face.loop) binary ? put(std::int32_t{v}) : void(text += fmt::format(" {}", v));
    if (!binary) text += "\n";
  }
  return text;
}

std::string lists(const std::vector<Polyhedron>& bodies) {
  std::string text = "# corners\n";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (i == 3) text += "group from the fourth\n";
    for (const Vec3& x : bodies[i].vertex) text += in_digits(x, 12) + "\n";
    text += "\n";
  }
  return text;
}

/// As Neper writes them: vertices and faces once, faces signed by whether they look out of the cell.
std::string tess(const Tessellation& cells, double weight) {
  std::map<std::array<long, 3>, std::size_t> at;
  std::string vertices, faces, polyhedra, seeds, groups;
  std::size_t count = 0;
  const auto vertex = [&](const Vec3& x) {
    const auto [found, fresh] =
        at.try_emplace({std::lround(1e8 * x.x()), std::lround(1e8 * x.y()), std::lround(1e8 * x.z())}, at.size() + 1);
    if (fresh) vertices += fmt::format(" {} {:.12f} {:.12f} {:.12f} 0\n", found->second, x.x(), x.y(), x.z());
    return found->second;
  };
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> between;
  for (std::size_t i = 0; i < cells.body.size(); ++i) {
    seeds += fmt::format("  {} {:.12f} {:.12f} {:.12f} {:.3f}\n", i + 1, cells.seed[i].x(), cells.seed[i].y(),
                         cells.seed[i].z(), i == 0 ? weight : 0.0);
    groups += fmt::format(" {}", i % 2 + 1);
    std::string own;
    for (const auto& face : cells.body[i].face) {
      const std::size_t j = face.tag < 0 ? i : cells.partner[i][static_cast<std::size_t>(face.tag)].cell;
      if (j < i) {
        own += fmt::format(" -{}", between.at({j, i}));
        continue;
      }
      if (j > i) between[{i, j}] = count + 1;
      own += fmt::format(" {}", ++count);
      faces += fmt::format(" {} {}", count, face.loop.size());
      for (const int v : face.loop) faces += fmt::format(" {}", vertex(corner(cells.body[i], v)));
      faces += fmt::format("\n {}", face.loop.size());
      for (std::size_t k = 0; k < face.loop.size(); ++k) faces += " 1";
      faces += "\n 0.1 1 0 0\n 0 0 0 0 0\n";
    }
    polyhedra += fmt::format(" {} {}{}\n", i + 1, cells.body[i].face.size(), own);
  }
  return fmt::format(
      "***tess\n **format\n   3.4\n **general\n   3 standard\n **cell\n  {}\n  *crysym\n   cubic\n  *seed\n{}  "
      "*group\n{}\n"
      " **vertex\n {}\n{} **edge\n 1\n 1 1 2 0\n **face\n {}\n{} **polyhedron\n {}\n{} **domain\n  *general\n   cube\n"
      "  *vertex\n  0\n***end\n",
      cells.body.size(), seeds, groups, at.size(), vertices, count, faces, cells.body.size(), polyhedra);
}

Tessellation mesh_of_a_box(std::size_t count = 40) {
  Team team(1);
  return voronoi_packing(box_space(Vec3(2, 3, 2.5)), count, 1, 5, team);
}

struct Read {
  std::vector<Polyhedron> body;
  std::vector<Vec3> middle;
  explicit Read(const std::vector<Surface>& surfaces, double tolerance = 1e-5) {
    for (const Surface& s : surfaces) {
      body.push_back(body_of(s, tolerance));
      middle.push_back(s.seed.value_or(moments_of(body.back()).centre));
    }
  }
};

State bonded(const Model& model, const Read& read, const Vec3& periodic = Vec3::Zero(),
             const std::vector<std::uint8_t>& materials = {0}, BondedFaces* told = nullptr) {
  State s;
  if (!periodic.isZero()) s.boundary.cell.vectors = Mat3(periodic.asDiagonal());
  const BondedFaces faces =
      add_bodies(model, read.body, read.middle, materials, shared_faces(read.body, periodic, 1e-5), s);
  if (told) *told = faces;
  return s;
}

void check_bodies(const std::vector<Polyhedron>& was, const std::vector<Polyhedron>& is, double tolerance) {
  REQUIRE(is.size() == was.size());
  for (std::size_t i = 0; i < was.size(); ++i) {
    const SolidMoments a = moments_of(was[i]), b = moments_of(is[i]);
    CHECK(std::abs(b.volume / a.volume - 1) < tolerance);
    CHECK((a.centre - b.centre).norm() < tolerance * std::cbrt(a.volume));
    CHECK((a.second - b.second).norm() < 10 * tolerance * a.second.norm());
  }
}

std::string why_not(const std::string& ending, const std::string& text) {
  try {
    Read(File(ending, text).read());
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

}  // namespace

TEST_CASE(
    "a mesh of cells that is written as lists, STL, OBJ, PLY or .tess and read again has its bodies, and their faces") {
  const Tessellation cells = mesh_of_a_box();
  check_bodies(cells.body, Read(File(".STL", stl(cells.body)).read()).body, 1e-9);
  check_bodies(cells.body, Read(File(".txt", lists(cells.body)).read()).body, 1e-9);
  check_bodies(cells.body, Read(File(".obj", obj(cells.body)).read()).body, 1e-9);
  check_bodies(cells.body, Read(File(".tess", tess(cells, 0)).read()).body, 1e-9);
  for (std::size_t i = 0; i < 5; ++i) {
    check_bodies({cells.body[i]}, Read(File(".ply", ply(cells.body[i], false)).read()).body, 1e-9);
    check_bodies({cells.body[i]}, Read(File(".ply", ply(cells.body[i], true)).read()).body, 1e-9);
    check_bodies({cells.body[i]}, Read(File(".stl", binary_stl(cells.body[i])).read()).body, 1e-5);  // single precision
    // Triangles in a plane become one face again; faces narrower than the slack are gone.
    CHECK(Read(File(".stl", stl({cells.body[i]})).read()).body[0].face.size() == cells.body[i].face.size());
  }
  CHECK(File(".obj", obj(cells.body)).read()[3].group == std::vector<std::string>{"odd", "body3"});
  CHECK(File(".txt", lists(cells.body)).read()[2].group.empty());
  CHECK(File(".txt", lists(cells.body)).read()[3].group == std::vector<std::string>{"from the fourth"});
  CHECK(File(".tess", tess(cells, 0)).read()[3].group == std::vector<std::string>{"2"});
  CHECK(File(".tess", tess(cells, 0)).read()[3].seed);
  CHECK(!File(".tess", tess(cells, 0.1)).read()[3].seed);  // seeds with weights are not half way between faces
}

TEST_CASE("faces that bodies share are found by where they lie: the bonds are those of the mesh itself") {
  const Tessellation cells = mesh_of_a_box();
  const Model model = rock(elastic(0.5));
  State was;
  const BondedFaces told = add_voronoi_grains(model, cells, 0, was);
  BondedFaces now;
  const State is = bonded(model, Read(File(".tess", tess(cells, 0)).read()), Vec3::Zero(), {0}, &now);
  std::map<std::pair<Index, Index>, const FaceBond*> of;
  for (const FaceBond& b : is.bonds.face.row) of[{b.ends.a, b.ends.b}] = &b;
  REQUIRE(of.size() == is.bonds.face.row.size());
  std::size_t small = 0;
  for (const FaceBond& b : was.bonds.face.row) {
    const auto found = of.find({b.ends.a, b.ends.b});
    if (found == of.end()) {
      CHECK(b.area < 1e-8);  // narrower than the slack
      ++small;
      continue;
    }
    const FaceBond& f = *found->second;
    CHECK(std::abs(f.area - b.area) < 1e-8);
    CHECK(std::abs(f.kn / b.kn - 1) < 1e-8);
    CHECK(std::abs(f.kt / b.kt - 1) < 1e-8);
    CHECK((is.grains.orientation[f.ends.a] * f.normal - was.grains.orientation[b.ends.a] * b.normal).norm() < 1e-7);
  }
  CHECK(is.bonds.size() + small == was.bonds.size());
  double outside = 0;
  for (const OuterFace& f : now.outer) outside += f.face.area;
  CHECK(std::abs(outside - 2 * (2 * 3 + 2 * 2.5 + 3 * 2.5)) < 1e-7);
  CHECK(now.outer.size() == told.outer.size());
}

TEST_CASE("whole cells of a periodic mesh find each other through the sides of their box") {
  const Vec3 box(1, 1.2, 1.1);
  Team team(1);
  const Tessellation cells = voronoi_packing(periodic_space(box), 90, 3, 2, team);
  const Model model = rock(elastic());
  State was;
  was.boundary.cell.vectors = Mat3(box.asDiagonal());
  add_voronoi_grains(model, cells, 0, was);
  Read read(File(".stl", stl(cells.body)).read());
  read.middle = cells.seed;
  const State is = bonded(model, read, box);
  double area_was = 0, area_is = 0, volume = 0;
  for (const FaceBond& b : was.bonds.face.row) area_was += b.area;
  for (const FaceBond& b : is.bonds.face.row) {
    area_is += b.area;
    volume += b.area * E0 / b.kn / 3;  // the sum of area times distance is three times the volume
  }
  CHECK(std::abs(area_is / area_was - 1) < 1e-7);
  CHECK(std::abs(volume / box.prod() - 1) < 1e-7);
  const Polyhedron wide = box_between(Vec3(0, 0.1, 0.1), Vec3(1, 0.3, 0.3));
  CHECK_THROWS(shared_faces({wide}, box, 1e-5));
}

TEST_CASE(
    "bricks in bond share parts of their faces; two materials make a bond of half of each, as strong as the weaker") {
  Model model = rock(cohesive(2e6, 1e5));
  model.materials[0].bond->ratio = 0.5;
  model.materials.push_back(model.materials[0]);
  model.materials[2].name = "hard", model.materials[2].bond->stiffness = 4e9, model.materials[2].bond->ratio = 0.25;
  model.materials[2].bond->tension = 1e6;
  make_pair_laws(model);
  Read wall({});
  for (const auto& [low, high] : {std::pair{Vec3(0, 0, 0), Vec3(2, 1, 1)},
                                  {Vec3(-0.5, 0, 1), Vec3(0.6, 1, 3)},
                                  {Vec3(0.6, 0.25, 1), Vec3(3, 1, 3)},
                                  {Vec3(5, 0, 0), Vec3(6, 1, 1)}}) {
    wall.body.push_back(box_between(low, high));
    wall.middle.push_back(0.5 * (low + high));
  }
  const State s = bonded(model, wall, Vec3::Zero(), {0, 0, 2, 0});
  REQUIRE(s.bonds.size() == 3);
  const auto& b = s.bonds.face.row;
  CHECK(std::abs(b[0].area - 0.6 * 1) < 1e-12);
  CHECK(std::abs(b[1].area - 1.4 * 0.75) < 1e-12);
  CHECK(std::abs(b[2].area - 0.75 * 2) < 1e-12);
  CHECK(std::abs(b[0].kn - E0 / 1.5) < 1e-3);
  // Half a metre of 1 GPa and a metre of 4 GPa one behind the other; in shear of 0.5 and 1 GPa.
  CHECK(std::abs(b[1].kn - 1 / (0.5 / 1e9 + 1 / 4e9)) < 1e-3);
  CHECK(std::abs(b[1].kt - 1 / (0.5 / 0.5e9 + 1 / 1e9)) < 1e-3);
  CHECK(b[0].tension == 2e6);
  CHECK(b[1].tension == 1e6);
  // The middle of what they share, not of either face: seen from both.
  for (const FaceBond& f : b) {
    const Vec3 at_a = s.grains.motion[f.ends.a].position + s.grains.orientation[f.ends.a] * f.at_a;
    const Vec3 at_b = s.grains.motion[f.ends.b].position + s.grains.orientation[f.ends.b] * f.at_b;
    CHECK((at_a - at_b).norm() < 1e-12);
  }
  CHECK((s.grains.motion[0].position + s.grains.orientation[0] * b[1].at_a - Vec3(1.3, 0.625, 1)).norm() < 1e-12);
  model.materials[2].bond->criterion = FaceCriterion::parallel;
  CHECK_THROWS(bonded(model, wall, Vec3::Zero(), {0, 0, 2, 0}));
}

TEST_CASE("bodies in one another are told by the volume that they share") {
  const std::vector<Polyhedron> two{box_between(Vec3::Zero(), Vec3::Ones()),
                                    box_between(Vec3(0.9, 0.2, 0.2), Vec3(1.9, 0.7, 0.7))};
  const SharedFaces s = shared_faces(two, Vec3::Zero(), 1e-6);
  CHECK(s.face.empty());
  CHECK(s.overlap.pairs == 1);
  CHECK(std::abs(s.overlap.share - 0.1) < 1e-4);
  CHECK(shared_faces({two[0], box_between(Vec3(1.01, 0, 0), Vec3(2, 1, 1))}, Vec3::Zero(), 1e-6).overlap.pairs == 0);
}

TEST_CASE("Voronoi cells of given seeds: a body-centred lattice makes truncated octahedra") {
  std::vector<Vec3> seeds;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) {
        seeds.emplace_back(x, y, z);
        seeds.emplace_back(x + 0.5, y + 0.5, z - 0.5);
      }
  Team team(1);
  const Vec3 box = Vec3::Constant(3);
  const Tessellation cells = relaxed_voronoi(periodic_space(box), seeds, 0, team);
  const double edge = std::sqrt(2.0) / 4;
  for (const Polyhedron& body : cells.body) {
    CHECK(std::abs(moments_of(body).volume - 0.5) < 1e-9);
    REQUIRE(body.face.size() == 14);
    for (const auto& face : body.face) {
      const double area = face.loop.size() == 4 ? edge * edge : 1.5 * std::sqrt(3.0) * edge * edge;
      CHECK(std::abs(moments_of(body, face).area - area) < 1e-9);
    }
  }
  seeds.push_back(seeds[7]);
  CHECK_THROWS(relaxed_voronoi(periodic_space(box), seeds, 0, team));
  CHECK_THROWS(relaxed_voronoi(box_space(box), {Vec3(1, 1, 1), Vec3(1, 3.1, 1)}, 0, team));
}

TEST_CASE("surfaces that bound no convex body are refused, with the reason") {
  const std::string cube = stl({unit_cube()});
  std::string open = cube;
  const std::size_t first = open.find("facet normal"), last = open.find("endfacet") + 9;
  open.erase(first, last - first);
  CHECK(why_not(".stl", open).find("is not closed") != std::string::npos);
  Polyhedron dented = unit_cube();
  dented.vertex[6] *= 0.4;
  CHECK(why_not(".stl", stl({dented})).find("is not convex: a corner lies") != std::string::npos);
  Polyhedron bent = unit_cube();
  bent.vertex[6] *= 1.01;
  CHECK(why_not(".obj", obj({bent})).find("is bent") != std::string::npos);
  const Polyhedron flat = box_between(Vec3::Zero(), Vec3(1, 1, 1e-7));
  CHECK(why_not(".obj", obj({flat})).find("is flat") != std::string::npos);
  std::vector<Vec3> round;
  for (int k = 0; k < 50; ++k) round.emplace_back(std::cos(0.04 * pi * k), std::sin(0.04 * pi * k), 0);
  CHECK(why_not(".obj", obj({prism_over(round, 0, 1)})).find("has 52 faces, more than the 40") != std::string::npos);
  for (const auto& [text, why] :
       {std::pair{"**general\n 2 standard\n", ":3: a tessellation of 2 dimensions"},
        {"**cell\n1\n*seed\n1 0 0 0 0\n1 0 0 0 0\n", ":6: *seed has more than one entry for each of the 1"},
        {"**cell\n2\n*seed\n1 0 0 0 0\n1 0 0 0 0\n", ":6: the seed of cell 1 stands where that of cell 2"},
        {"**cell\n2\n*group\n1 1 2\n", ":5: *group has more than one entry"},
        {"**polyhedron\n2\n1 4 1 2 3 4\n1 4 1 2 3 4\n", ":5: polyhedron 1 is there twice"}})
    CHECK(why_not(".tess", std::string("***tess\n") + text + "***end\n").find(why) != std::string::npos);
  CHECK(why_not(".obj", "v 0 0 0\nf 1 2 3\n").find(":2: \"2\": there are 1 corners so far") != std::string::npos);
  CHECK(why_not(".ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1\n")
            .find(":6: its vertices have no x, y and z") != std::string::npos);
  CHECK(why_not(".stl", "nothing\n").find(":1: is no STL file") != std::string::npos);
  CHECK(why_not(".txt", "0 0 0\n1 0\n").find(":2: expected three numbers x y z (read as a list of corners") !=
        std::string::npos);
  CHECK(why_not(".txt", "\n\n").find("no bodies") != std::string::npos);
}
