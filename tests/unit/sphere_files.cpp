// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings of spheres from files of other programs.
#include <unistd.h>

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
