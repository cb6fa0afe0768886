// SPDX-License-Identifier: LGPL-3.0-or-later
// Mesh files in three dimensions and what is wrong in them, word by word; what a mesh that is no body is told for.
#include <mpi.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "fem/msh_contents.hpp"
#include "tests/helpers.hpp"

namespace grus {
namespace {

using fem::CellKind;
using fem::MshMesh;
using fem::Point;

std::string written(const std::string& text) {
  int rank;  // ranks share the folder
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grus_mesh_file_" + std::to_string(rank) + ".msh")).string();
  std::ofstream(path) << text;
  return path;
}

/// The mesh of a file, or what is said of it.
MshMesh mesh_of(const std::string& text) { return fem::read_msh(written(text)); }
std::string said_of(const std::string& text) {
  try {
    fem::read_msh(written(text));
  } catch (const std::invalid_argument& e) {
    const std::string said = e.what();
    return said.substr(said.find(".msh: ") + 6);
  }
  return "";
}

const std::string head2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", head4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string names =
    "$PhysicalNames\n4\n2 1 \"low\"\n2 2 \"high side\"\n3 10 \"rock\"\n3 11 \"ore\"\n$EndPhysicalNames\n";

/// Two cubes one above the other; a node that no element has.
const std::string nodes2 =
    "$Nodes\n13\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n77 5 5 5\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n9 0 0 2\n10 1 0 2\n"
    "11 1 1 2\n12 0 1 2\n$EndNodes\n";
const std::string cubes2 =
    head2 + names + nodes2 +
    "$Elements\n6\n1 3 2 1 1 1 2 3 4\n2 3 2 2 2 9 10 11 12\n3 1 2 5 1 1 2\n4 5 2 10 1 1 2 3 4 5 6 7 8\n"
    "5 5 3 11 1 99 5 6 7 8 9 10 11 12\n6 15 2 3 1 1\n$EndElements\n";

/// The same in format 4.1: a point, a curve, two surfaces and two volumes, with what bounds them. `of`: what stands
/// between an entity's number and its box.
std::string cubes4(const std::string& section, const std::string& of, const std::string& volume = "") {
  const auto parents = [&](int dimension) { return of.empty() ? "" : std::to_string(dimension) + of; };
  return head4 + "$Comments\nanything 1 2 3\n$EndComments\n" + names + "$" + section + "\n" +
         (of.empty() ? "" : "2\n1\n5 1\n") + "1 1 2 2\n3 " + parents(0) + " 0 0 0 1 3\n4 " + parents(1) +
         " 0 0 0 1 0 0 1 5 2 3 -3\n7 " + parents(2) + " 0 0 0 1 1 0 1 1 1 4\n8 " + parents(2) +
         " 0 0 2 1 1 2 1 -2 0\n1 " + (volume.empty() ? parents(3) : volume) + " 0 0 0 1 1 1 1 10 2 7 8\n2 " +
         parents(3) + " 0 0 1 1 1 2 1 11 0\n$End" + section +
         "\n$Nodes\n2 12 1 12\n3 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 "
         "1\n"
         "3 2 0 4\n9\n10\n11\n12\n0 0 2\n1 0 2\n1 1 2\n0 1 2\n$EndNodes\n"
         "$Elements\n6 6 1 6\n0 3 15 1\n6 1\n1 4 1 1\n3 1 2\n2 7 3 1\n1 1 2 3 4\n2 8 3 1\n2 9 10 11 12\n3 1 5 1\n"
         "4 1 2 3 4 5 6 7 8\n3 2 5 1\n5 5 6 7 8 9 10 11 12\n$EndElements\n";
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// Format 2.2 of nodes numbered from 1 and elements of one type.
std::string file_of(const std::vector<Point>& nodes, int type, const std::vector<std::vector<int>>& cells) {
  std::string text = head2 + "$Nodes\n" + std::to_string(nodes.size()) + "\n";
  char number[120];
  for (std::size_t n = 0; n < nodes.size(); ++n)
    std::snprintf(number, sizeof number, "%zu %.17g %.17g %.17g\n", n + 1, nodes[n][0], nodes[n][1], nodes[n][2]),
        text += number;
  text += "$EndNodes\n$Elements\n" + std::to_string(cells.size()) + "\n";
  for (std::size_t c = 0; c < cells.size(); ++c) {
    text += std::to_string(c + 1) + " " + std::to_string(type) + " 2 1 1";
    for (const int n : cells[c]) text += " " + std::to_string(n);
    text += "\n";
  }
  return text + "$EndElements\n";
}

/// A cube beside two halves of one whose nodes are its own but for those in the middle of the side: a body of three
/// hexahedra, two nodes of which hang on the cube's side. `off`: how far these are off it.
std::string hanging(double scale, double off) {
  std::vector<Point> at;
  for (const double x : {0.0, 1.0})
    for (const double y : {0.0, 1.0})
      for (const double z : {0.0, 1.0}) at.push_back({x, y, z});      // 1 .. 8: 1 + 4 x + 2 y + z
  for (const double y : {0.0, 1.0}) at.push_back({1 + off, y, 0.4});  // 9, 10
  for (const double y : {0.0, 1.0})
    for (const double z : {0.0, 0.4, 1.0}) at.push_back({2, y, z});  // 11 .. 16
  for (Point& x : at)
    for (double& v : x) v = scale * (v + 3);
  return file_of(at, 5, {{1, 5, 7, 3, 2, 6, 8, 4}, {5, 11, 14, 7, 9, 12, 15, 10}, {9, 12, 15, 10, 6, 13, 16, 8}});
}

}  // namespace

TEST_CASE("files of both formats say the same: elements with their groups, facets, names, in three dimensions") {
  for (const std::string& text : {cubes2, cubes4("Entities", ""), cubes4("PartitionedEntities", " 1 1 1"),
                                  cubes4("PartitionedEntities", " 1 2 1 1"), "\xEF\xBB\xBF" + cubes2}) {
    const MshMesh mesh = mesh_of(text);
    CHECK((mesh.kind == CellKind::hexahedron && mesh.notes.empty() && mesh.idle_facets.empty()));
    REQUIRE(mesh.nodes.size() == 12);  // without the one of no element
    CHECK((mesh.nodes[2] == Point{1, 1, 0} && mesh.nodes[11] == Point{0, 1, 2}));
    CHECK(mesh.cells == std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 8, 9, 10, 11});
    CHECK(mesh.cell_tags == std::vector<int>{10, 11});
    CHECK(mesh.facets ==
          std::map<std::vector<std::int64_t>, std::vector<int>>{{{0, 1, 2, 3}, {1}}, {{8, 9, 10, 11}, {2}}});
    CHECK(mesh.facet_names == std::map<std::string, std::vector<int>>{{"low", {1}}, {"high side", {2}}});
    CHECK(mesh.cell_names == std::map<std::string, std::vector<int>>{{"rock", {10}}, {"ore", {11}}});
  }
  // A partition's cut is an entity of less dimension than what it is part of, and in no group of it.
  const MshMesh cut = mesh_of(cubes4("PartitionedEntities", " 1 1 1", "2 1 1 1"));
  CHECK(cut.cell_tags == std::vector<int>{0, 11});
  // One name of two groups, told once each however often it stands there; a group of two names.
  const MshMesh named = mesh_of(changed(cubes2, "4\n2 1 \"low\"\n", "6\n2 1 \"low\"\n2 2 \"low\"\n2 1 \"low\"\n"));
  CHECK(named.facet_names == std::map<std::string, std::vector<int>>{{"low", {1, 2}}, {"high side", {2}}});
  // Tetrahedra and triangles.
  const std::string tetrahedra = head2 +
                                 "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n3\n"
                                 "1 2 1 3 1 2 3\n2 4 2 8 1 1 2 3 4\n3 4 0 2 3 4 5\n$EndElements\n";
  const MshMesh four = mesh_of(tetrahedra);
  CHECK((four.kind == CellKind::tetrahedron && four.cell_tags == std::vector<int>{8, 0}));
  CHECK(four.facets == std::map<std::vector<std::int64_t>, std::vector<int>>{{{0, 1, 2}, {3}}});
}

TEST_CASE("what is wrong in a mesh file is said with its section, or its element") {
  const std::string four = cubes4("Entities", "");
  struct Row {
    std::string text, said;
  };
  for (const Row& r : {
           Row{changed(cubes2, "2.2 0 8", "2.2 1 8"), "$MeshFormat: binary files are not read"},
           Row{changed(cubes2, "2.2 0 8", "2.1 0 8"), "$MeshFormat: format 2.1 is not read; save as 2.2 or 4.1"},
           Row{changed(cubes2, "2.2 0 8\n", "2.2 0 8 9\n"), "$MeshFormat: expected $EndMeshFormat"},
           Row{changed(cubes2, "2 1 \"low\"", "2 1 low"), "$PhysicalNames: a name without quotes"},
           Row{changed(cubes2, "2 1 \"low\"", "2 1000000001 \"low\""),
               "$PhysicalNames: physical group 1000000001: at most"},
           Row{changed(cubes2, "2 1 \"low\"", "2 -1000000001 \"low\""),
               "$PhysicalNames: physical group -1000000001: at most"},
           Row{changed(cubes2, "$PhysicalNames\n4", "$PhysicalNames\n3"), "$PhysicalNames: expected $EndPhysicalNames"},
           Row{changed(cubes2, "$Nodes\n13", "$Nodes\n130000"), "$Nodes: count 130000 is more than the file can hold"},
           Row{changed(cubes2, "$Nodes\n13", "$Nodes\n-1"), "$Nodes: count -1 is more"},
           Row{changed(cubes2, "$Nodes\n13", "$Nodes\n14"), "$Nodes: cut short, or not a number"},
           Row{changed(cubes2, "12 0 1 2\n", "11 0 1 2\n"), "$Nodes: node 11 appears twice"},
           Row{changed(cubes2, "4 5 2 10", "4 6 2 10"), "$Elements: element type 6 is not read; mesh with first-order"},
           Row{changed(cubes2, "6 15 2 3 1 1\n", "6 15 2 3 1 1 9\n"), "$Elements: expected $EndElements"},
           Row{changed(cubes2, "8 9 10 11 12\n6", "8 9 10 11 13\n6"),
               "element 5 (hexahedron) names node 13, which is not there"},
           Row{changed(cubes2, "5 6 7 8 9 10 11 12\n6", "5 6 7 8 9 10 12 11\n6"),
               "element 5 (hexahedron) is folded over itself"},
           Row{changed(cubes2, "9 0 0 2\n10 1 0 2\n11 1 1 2\n12 0 1 2", "9 0 0 1\n10 1 0 1\n11 1 1 1\n12 0 1 1"),
               "element 5 (hexahedron) is flat"},
           Row{changed(cubes2, "4 5 2 10 1 1 2 3 4 5 6 7 8", "4 4 2 10 1 1 2 3 5"),
               "mixes tetrahedron and hexahedron elements; one kind"},
           Row{changed(changed(cubes2, "$Elements\n6", "$Elements\n7"), "6 15 2 3 1 1",
                       "6 15 2 3 1 1\n7 5 2 11 1 1 2 3 4 5 6 7 8"),
               "elements 4 and 7 are one element, in the physical groups \"rock\" and \"ore\""},
           Row{changed(four, "4.1 0 8", "4.0 0 8"), "$MeshFormat: format 4.0 is not read"},
           Row{changed(four, "3 1 0 8", "3 1 1 8"), "$Nodes: parametric nodes are not read"},
           Row{changed(four, "3 2 5 1", "2 2 5 1"), "$Elements: an entity of dimension 2 with a hexahedron in it"},
           Row{changed(four, "1 10 2 7 8", "2 10 -11 2 7 8"),
               "element 4 is in the physical groups \"rock\" and \"ore\""},
           Row{changed(four, "1 10 2 7 8", "2 10 12 2 7 8"), "element 4 is in the physical groups \"rock\" and 12"},
           Row{four.substr(0, four.find("$EndElements")), "$Elements: cut short"},
           Row{changed(four, "$EndComments", "$EndOf"), "$Comments: cut short"},
           Row{"text\n" + cubes2, "expected a section that begins with $: not an ASCII Gmsh file, or damaged"},
           Row{changed(cubes2, head2, ""), "$Nodes: before $MeshFormat, which says how it is to be read"},
           Row{head2, "holds no triangles, quadrilaterals, tetrahedra or hexahedra"},
       }) {
    INFO(r.said);
    CHECK(said_of(r.text).starts_with(r.said));
  }
  CHECK(said_of(changed(cubes2, "2 1 \"low\"", "2 1000000000 \"low\"")).empty());
  CHECK(said_of(changed(four, "1 10 2 7 8", "2 10 -10 2 7 8")).empty());  // the same, turned over
  CHECK_THROWS_WITH(fem::read_msh("/"), Catch::Contains("no such mesh file"));
  // Three tetrahedra at one side.
  const std::string fan = file_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {1, 1, 1}}, 4,
                                  {{1, 2, 3, 4}, {1, 2, 3, 5}, {1, 2, 3, 6}});
  CHECK(said_of(fan) == "more than two elements share the side with nodes 1 2 3: they overlap");
  // In the plane nothing is off it, however large the mesh is.
  for (const double size : {1e-3, 1e4}) {
    const auto plate = [&](double z) {
      return said_of(
          file_of({{0, 0, 0}, {0.1 * size, 0, 0}, {0.1 * size, -size, z * size}, {0, -size, 0}}, 3, {{1, 2, 3, 4}}));
    };
    CHECK(plate(0.9e-9).empty());
    CHECK(plate(-1.1e-9) == "a two-dimensional mesh must lie in the plane z = 0");
  }
}

TEST_CASE("elements that stand twice, and facets where nothing acts, are noted") {
  std::string twice = changed(cubes2, "$Elements\n6", "$Elements\n9");
  twice = changed(twice, "6 15 2 3 1 1",
                  "6 15 2 3 1 1\n7 5 2 10 1 8 7 6 5 4 3 2 1\n8 5 2 0 1 5 6 7 8 9 10 11 12\n9 3 2 2 1 5 6 7 8");
  const MshMesh mesh = mesh_of(twice);
  CHECK(mesh.notes == std::vector<std::string>{"2 of the elements stand in the file again; each is taken once"});
  CHECK(mesh.cell_tags == std::vector<int>{10, 11});
  CHECK(mesh.idle_facets ==
        std::map<int, std::string>{
            {2,
             "of the 2 elements of physical group \"high side\" 1 lie between two elements: nothing "
             "acts there"}});
  const MshMesh apart = mesh_of(changed(twice, "3 1 2 5 1 1 2", "3 3 2 4 1 1 2 5 77"));
  CHECK(apart.idle_facets.at(4) ==
        "of the 1 elements of physical group 4 1 are the side of no element: nothing acts there");
}

TEST_CASE("sides of an element are those of its shape, each shared one twice") {
  const std::vector<std::int64_t> eight{0, 1, 2, 3, 4, 5, 6, 7};
  // Of a cube the corners of a side have one coordinate in common.
  MshMesh mesh;
  mesh.kind = CellKind::hexahedron, mesh.cells = eight, mesh.cell_tags = {0};
  const Point at[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  std::set<std::pair<int, double>> faces;
  for (const auto& side : fem::sides_of(mesh))
    for (int k = 0; k < 3; ++k) {
      std::set<double> seen;
      for (const auto n : side.corner) seen.insert(at[n][static_cast<std::size_t>(k)]);
      if (seen.size() == 1) faces.insert({k, *seen.begin()});
    }
  CHECK((faces.size() == 6 && fem::sides_of(mesh).size() == 6));
  // Of a square they are its edges: neighbours; of triangles and tetrahedra all but one corner.
  mesh.kind = CellKind::quadrilateral, mesh.cells = {0, 1, 2, 3};
  std::set<std::pair<std::int64_t, std::int64_t>> edges;
  for (const auto& side : fem::sides_of(mesh)) {
    CHECK((side.corner[2] == -1 && side.corner[3] == -1));
    edges.insert({side.corner[0], side.corner[1]});
  }
  CHECK(edges == std::set<std::pair<std::int64_t, std::int64_t>>{{0, 1}, {1, 2}, {2, 3}, {0, 3}});
  for (const CellKind kind : {CellKind::triangle, CellKind::tetrahedron}) {
    const int count = kind == CellKind::triangle ? 3 : 4;
    mesh.kind = kind, mesh.cells.assign(eight.begin(), eight.begin() + count);
    std::set<std::int64_t> left;
    for (const auto& side : fem::sides_of(mesh)) {
      std::int64_t sum = count * (count - 1) / 2;
      for (const auto n : side.corner) sum -= n >= 0 ? n : 0;
      left.insert(sum);
      CHECK(side.corner[static_cast<std::size_t>(count - 1)] == -1);
    }
    CHECK((static_cast<int>(left.size()) == count && *left.begin() == 0 && *left.rbegin() == count - 1));
  }
  const MshMesh both = mesh_of(cubes2);
  const auto sides = fem::sides_of(both);
  REQUIRE(sides.size() == 12);
  int shared = 0;
  for (std::size_t k = 1; k < 12; ++k)
    if (sides[k].corner == sides[k - 1].corner) {
      ++shared;
      CHECK((sides[k - 1].cell == 0 && sides[k].cell == 1));
    }
  CHECK(shared == 1);
}

TEST_CASE("a mesh that is no body is noted: parts, nodes in one place, nodes on sides, in any unit") {
  for (const double scale : {1e-3, 1.0, 1e3}) {
    INFO(scale);
    const auto hung = [&](double off) { return mesh_of(hanging(scale, off)).notes; };
    const std::vector<std::string> two{
        "2 nodes lie on sides of elements that do not have them (the first: 9): nothing holds them there"};
    CHECK(hung(0) == two);  // a side of a cube measures sqrt(2): a node is on it within 1.4e-6
    CHECK((hung(1e-6) == two && hung(-1e-6) == two));
    CHECK(hung(1e-4).empty());
    // Two cubes that touch, each with nodes of its own; a third beside them. Nodes are in one place within 1e-9 of the
    // diagonal, wherever they lie.
    const auto cube = [](double x) {
      std::vector<Point> at;
      for (const double dz : {0.0, 1.0})
        for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
          at.push_back({x + dx, dy, dz});
      return at;
    };
    const auto notes = [&](double off) {
      std::vector<Point> at = cube(0);
      for (const double x : {1 + off, 4.0})
        for (const Point& p : cube(x)) at.push_back(p);
      for (Point& x : at)
        for (double& v : x) v *= scale;
      std::vector<std::vector<int>> cells(3);
      for (int k = 0; k < 24; ++k) cells[static_cast<std::size_t>(k / 8)].push_back(k + 1);
      return mesh_of(file_of(at, 5, cells)).notes;
    };
    const std::string parts =
        "3 parts share no node: each moves without the others (in Gmsh: BooleanFragments, or Coherence Mesh)";
    CHECK(notes(4e-9) == std::vector<std::string>{parts,
                                                  "4 nodes lie where another one lies (the first: 2 and 9): nothing "
                                                  "holds them together"});
    CHECK(notes(7e-9) == std::vector<std::string>{parts});  // of a diagonal of 5.2
  }
  // Wherever two nodes lie as near: along a row of cubes that part by less each.
  std::vector<Point> row;
  std::vector<std::vector<int>> cells;
  for (int c = 0; c < 40; ++c) {
    cells.emplace_back();
    for (const double z : {0.0, 1.0})
      for (const auto& [dx, dy] : {std::pair{0.0, 0.0}, {0.73, 0.0}, {0.73, 1.0}, {0.0, 1.0}})
        row.push_back({c * (0.73 + 5e-9) + dx, dy, z}), cells.back().push_back(static_cast<int>(row.size()));
  }
  const auto notes = mesh_of(file_of(row, 5, cells)).notes;  // 1e-9 of the diagonal is 2.9e-8
  REQUIRE(notes.size() == 2);
  CHECK((notes[0].starts_with("40 parts") && notes[1].starts_with("156 nodes lie where another one lies")));
  // On the slope of a tetrahedron, and beside it in its plane.
  const auto slope = [](const Point& x) {
    return mesh_of(file_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, x, {1, 1, 1}, {2, 1, 1}, {1, 2, 1}}, 4,
                           {{1, 2, 3, 4}, {5, 6, 7, 8}}))
        .notes;
  };
  CHECK(slope({0.2, 0.3, 0.5}).back().starts_with("1 nodes lie on sides"));
  CHECK(slope({0.5, 0.5, 0}).back().starts_with("1 nodes lie on sides"));  // on its edge
  CHECK(slope({-0.2, 0.6, 0.6}).size() == 1);
  CHECK(slope({0.6, 0.6, -0.2}).size() == 1);
  CHECK(slope({0.6, -0.2, 0.6}).size() == 1);
}

}  // namespace grus
