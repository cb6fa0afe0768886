// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings of spheres from files: columns of numbers, LAMMPS and LIGGGHTS dumps, Yade's texts.
#pragma once

#include "dem/packing/packing.hpp"

namespace grus::dem {

/// How a file is to be read.
struct SphereFile {
  std::string path;
  double unit = 1;                        // m, that 1 stands for
  std::vector<std::string> columns = {};  // names; none: those that the file tells, or x y z r
};

struct ReadSpheres {
  Packing packing;                 // its box is that of a dump, whose corner is moved to the origin; else zero
  std::vector<std::string> group;  // of each sphere, material or type; none: no such column
  std::vector<int> line;           // of each sphere
};

/// Columns: x, y, z (of dumps xu, xs, xsu, ... too), r or radius, d or diameter, and material, type or matId; "-" is
/// left out. Of a dump the last frame. Lines are parted by blanks, tabs, commas or semicolons; "#" begins a comment,
/// after which Yade's "#format x_y_z_r_matId" tells columns. Throws InputError with file and line.
ReadSpheres read_spheres(const SphereFile& file);

/// Throws InputError, with the file's lines, where two spheres are in one place or one is larger than the box (of zero:
/// none), or where a centre is outside of it or a sphere sticks out along an axis with walls: from `first_walls` on.
void check_spheres(const ReadSpheres& read, const std::string& path, const Vec3& box, int first_walls);

}  // namespace grus::dem
