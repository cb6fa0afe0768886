// SPDX-License-Identifier: LGPL-3.0-or-later
// Decompositions, turns and distances of tensors, by what defines them.
#include "dem/state/boundary.hpp"
#include "tests/helpers.hpp"

using namespace grus::dem;

namespace {

const Mat3 turn = (Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized())).toRotationMatrix();

}  // namespace

TEST_CASE("a turned tangent answers a turned strain with the turned stress, shear included") {
  Mat6 tangent;  // no symmetry at all
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) tangent(i, j) = 1 + std::sin(3 * i + 7 * j);
  const auto engineering = [](const Mat3& strain) {
    Vec6 e = to_voigt(strain);
    e.tail<3>() *= 2;
    return e;
  };
  for (int k = 0; k < 6; ++k) {
    const Mat3 strain = from_voigt(Vec6::Unit(k));
    const Mat3 stress = from_voigt(tangent * engineering(strain));
    const Vec6 asked = turned(tangent, turn) * engineering(turn * strain * turn.transpose());
    CHECK((asked - to_voigt(turn * stress * turn.transpose())).norm() < 1e-14 * tangent.norm());
  }
}

TEST_CASE("F = R U with the rotation on the left") {
  Mat3 stretch = Vec3(1.3, 0.9, 0.6).asDiagonal(), r, u;
  stretch(0, 1) = stretch(1, 0) = 0.2;
  polar(turn * stretch, r, u);
  CHECK((r - turn).norm() < 1e-14);
  CHECK((u - stretch).norm() < 1e-14);
  polar(turn, r, u);
  CHECK(((r - turn).norm() < 1e-15 && (u - Mat3::Identity()).norm() < 1e-15));
  polar(Mat3::Identity(), r, u);
  CHECK((r == Mat3::Identity() && u == Mat3::Identity()));
}

TEST_CASE("F = R U of increments to round-off, of stretches of any size, of a mirror image and of what is flat") {
  Mat3 r, u;
  for (const double size : {1e-9, 1e-5, 1e-2, 0.3}) {
    Mat3 stretch = Mat3::Identity();
    stretch.diagonal() += size * Vec3(1, -0.5, 0.2);
    stretch(0, 2) = stretch(2, 0) = 0.3 * size;
    polar(turn * stretch, r, u);
    CHECK(((r - turn).norm() < 2e-15 && (u - stretch).norm() < 2e-15));
    CHECK(u == u.transpose());
  }
  for (const Vec3& large : {Vec3(1e6, 1, 1e-6), Vec3(1e5, 2e5, 3e5), Vec3(1e-7, 2e-7, 1e-7)}) {
    polar(turn * large.asDiagonal(), r, u);
    CHECK((r.transpose() * r - Mat3::Identity()).norm() < 1e-14);
    CHECK((u - Mat3(large.asDiagonal())).norm() < 1e-14 * large.maxCoeff());
  }
  const Mat3 mirror = Vec3(1, 1, -1).asDiagonal();
  polar(turn * mirror * 1.1, r, u);
  CHECK(((r - turn * mirror).norm() < 1e-14 && (u - 1.1 * Mat3::Identity()).norm() < 1e-14));
  polar(turn * Vec3(2, 1, 0).asDiagonal(), r, u);
  CHECK((u - Mat3(Vec3(2, 1, 0).asDiagonal())).norm() < 1e-14);
}

TEST_CASE("principal values ascend, each with its direction") {
  const Mat3 stress = turn * Vec3(-5, 1, 20).asDiagonal() * turn.transpose();
  CHECK((principal_values(stress) - Vec3(-5, 1, 20)).norm() < 1e-12);
  const PrincipalAxes found = principal_axes(stress);
  CHECK((found.values - Vec3(-5, 1, 20)).norm() < 1e-12);
  for (int k = 0; k < 3; ++k) CHECK(std::abs(found.directions.col(k).dot(turn.col(k))) == Approx(1).epsilon(1e-12));
}

TEST_CASE("a cell is as high as its closest pair of faces: volume over the largest face") {
  Cell cell;
  cell.vectors << 2, 0.7, 0.1, 0, 1, 0.4, 0, 0, 5;
  double largest = 0;
  for (int k = 0; k < 3; ++k)
    largest = std::max(largest, cell.vectors.col(k).cross(cell.vectors.col((k + 1) % 3)).norm());
  CHECK(cell.height() == Approx(cell.volume() / largest).epsilon(1e-14));
}
