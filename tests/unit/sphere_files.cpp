// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings of spheres from files of other programs.
#include <unistd.h>

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "dem/base/error.hpp"
#include "dem/packing/sphere_files.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;

namespace {

ReadSpheres spheres_of(const std::string& text, std::vector<std::string> columns = {}, double unit = 1) {
  const auto path = std::filesystem::temp_directory_path() / ("grus_spheres_" + std::to_string(getpid()));
  std::ofstream(path, std::ios::binary) << text;
  return read_spheres({path.string(), unit, std::move(columns)});
}

std::string why_no_spheres(const std::string& text, const std::vector<std::string>& columns = {}) {
  try {
    spheres_of(text, columns);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

void check_sphere(const Sphere& s, const Vec3& x, double radius) {
  CHECK((s.position - x).norm() < 1e-12);
  CHECK(std::abs(s.radius - radius) < 1e-12);
}

}  // namespace

TEST_CASE("spheres of other programs: named columns, units, Yade's texts, the last frame of a dump") {
  const ReadSpheres plain = spheres_of("# x y z r\n1 2 3 0.5\n\n4,5;6\t0.25 # last\r\n", {}, 1e-3);
  REQUIRE(plain.packing.spheres.size() == 2);
  check_sphere(plain.packing.spheres[1], Vec3(4e-3, 5e-3, 6e-3), 0.25e-3);
  CHECK((plain.group.empty() && plain.packing.box.isZero() && plain.line == std::vector{2, 4}));
  const ReadSpheres boxed = spheres_of("# x y z r\n#box 4 5 6\n1 2 3 0.5\n", {}, 1e-3);
  CHECK(((boxed.packing.box - Vec3(4e-3, 5e-3, 6e-3)).norm() < 1e-15 && boxed.line == std::vector{3}));
  for (const char* wrong : {"#box 4 5\n", "#box 4 5 0\n", "#box 4 5 6 7\n"})
    CHECK(why_no_spheres(std::string(wrong) + "1 2 3 0.5\n").find(":1: #box: expected three lengths above 0") !=
          std::string::npos);
  CHECK(why_no_spheres("#box 4 5 m\n").find(":1: expected numbers") != std::string::npos);
  const ReadSpheres named = spheres_of("7 0.5 sand 3 2 1\n", {"-", "d", "material", "z", "y", "x"});
  check_sphere(named.packing.spheres.at(0), Vec3(1, 2, 3), 0.25);
  CHECK(named.group == std::vector<std::string>{"sand"});
  const ReadSpheres yade = spheres_of("#format id_x_y_z_r_matId\n12\t1\t2\t3\t0.5\t0\n");
  check_sphere(yade.packing.spheres.at(0), Vec3(1, 2, 3), 0.5);
  CHECK(yade.group == std::vector<std::string>{"0"});
  const std::string frame = "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp ff\n-1 3\n0 5\n2 8\n";
  const ReadSpheres dump =
      spheres_of("ITEM: TIMESTEP\n0\n" + frame + "ITEM: ATOMS id type x y z radius\n1 1 0 0 2 9\n2 1 0 0 2 9\n" +
                     "ITEM: TIMESTEP\n100\n" + frame + "ITEM: ATOMS type xs yu zsu vx diameter\n3 0.25 4 0.5 7 0.5\n",
                 {}, 0.01);
  REQUIRE(dump.packing.spheres.size() == 1);
  check_sphere(dump.packing.spheres[0], Vec3(0.01, 0.04, 0.03), 0.0025);
  CHECK((dump.packing.box - Vec3(0.04, 0.05, 0.06)).norm() < 1e-15);
  CHECK(dump.group == std::vector<std::string>{"3"});
  CHECK(why_no_spheres("1 2 3\n").find(":1: 3 columns, expected 4: x y z r") != std::string::npos);
  CHECK(why_no_spheres("1 2 3 nan\n").find("expected numbers") != std::string::npos);
  CHECK(why_no_spheres("1 2 3 0\n").find("expected a radius above 0") != std::string::npos);
  CHECK(why_no_spheres("1 2 3 4\n", {"x", "y", "z", "radios"}).find("\"radios\" is no column") != std::string::npos);
  CHECK(why_no_spheres("1 2 3 4\n", {"x", "y", "y", "d"}).find("x, y, z and one of radius") != std::string::npos);
  CHECK(why_no_spheres("ITEM: TIMESTEP\n0\n" + frame + "ITEM: ATOMS id x y z\n1 0 0 2\n").find(":9: the columns") !=
        std::string::npos);
  CHECK(why_no_spheres("ITEM: TIMESTEP\n0\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1 0.5\n").find("the box leans") !=
        std::string::npos);
}

TEST_CASE("compressed files are told to be unpacked, by their first bytes") {
  for (const char* begin : {"\x1F\x8B\x08", "PK\3\4", "BZh9",
                            "\xFD"
                            "7zXZ",
                            "\x28\xB5\x2F\xFD"})
    CHECK_THAT(why_no_spheres(begin + std::string("0 0 0 1\n")),
               Catch::EndsWith(": the file is compressed; unpack it first"));
  CHECK(why_no_spheres("P 0 0 1\n").find("compressed") == std::string::npos);
  check_sphere(spheres_of("\xEF\xBB\xBF"
                          "1 2 3 0.5\n")
                   .packing.spheres.at(0),
               {1, 2, 3}, 0.5);
}

TEST_CASE("spheres that lie in one another by more than half a radius are refused, with how much") {
  // Radii 2 and 1 at a distance d overlap by 3 - d of the smaller one; through the sides of a periodic box as well.
  for (const double x : {2.6, 2.4, 7.4, 7.6}) {
    const ReadSpheres two = spheres_of(fmt::format("0 5 5 2\n{} 5 5 1\n", x));
    const bool refused = x == 2.4 || x == 7.6;
    const auto check = [&] { check_spheres(two, "f", Vec3(10, 10, 10), 3); };
    if (refused)
      CHECK_THROWS_WITH(check(), Catch::Contains("f:2: ") && Catch::Contains("overlap by 0.6 of the smaller radius"));
    else
      CHECK_NOTHROW(check());
  }
  // Between walls along z there are images along x and y alone; in a box of walls there are none.
  const auto through = [](int axis, int first_walls) {
    Vec3 low(5, 5, 5), high = low;
    low[axis] = 1.6, high[axis] = 9.2;  // 2.4 apart through the side, at radii of 2 and 1
    const ReadSpheres two =
        spheres_of(fmt::format("{} {} {} 2\n{} {} {} 1\n", low.x(), low.y(), low.z(), high.x(), high.y(), high.z()));
    try {
      check_spheres(two, "f", Vec3(10, 10, 10), first_walls);
    } catch (const InputError& e) {
      return std::string(e.what()).find("overlap by 0.6 of the smaller radius") != std::string::npos;
    }
    return false;
  };
  for (const int first_walls : {0, 2, 3})
    for (int axis = 0; axis < 3; ++axis) CHECK(through(axis, first_walls) == (axis < first_walls));
}
