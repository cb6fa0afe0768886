// SPDX-License-Identifier: LGPL-3.0-or-later
// Points that stand for a grain, the forces on them, and the linear peridynamic solid against closed forms and exact
// sums.
#include "tests/lattices.hpp"

#include "dem/base/error.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

/// A block of n^3 points, its lattice along its axes.
struct Block {
  Shape cube{unit_cube()};
  LatticeSolid shape = lattice_hull(cube.store, 0);
  PointLattice lattice;
  PeridynamicSolid solid;
  Block(int n, double horizon, bool partial)
      : lattice(make_lattice(shape, lattice_of(n * n * n, horizon, partial, false), 3, 0)), solid(lattice, poisson) {
    REQUIRE(lattice.size() == static_cast<std::size_t>(n * n * n));
  }
  double energy(const Mat3& gradient) {
    return solid.dilate(field(lattice, shape.diameter(), [&](const Vec3& x) { return Vec3(gradient * x); }), true) /
           lattice.volume;
  }
};

Mat3 gradient(std::initializer_list<std::array<int, 2>> ones) {
  Mat3 g = Mat3::Zero();
  for (const auto& [i, j] : ones) g(i, j) = 1;
  return g;
}

/// Energy of a point in the middle: energies of blocks are cubic in n, the third difference is that of six points.
double inner_energy(double horizon, bool partial, const Mat3& g) {
  const int n = 7;
  const auto e = [&](int more) { return Block(n + more, horizon, partial).energy(g); };
  return (e(3) - 3 * e(2) + 3 * e(1) - e(0)) / 6;
}

std::vector<LatticeSolid> shapes(const std::vector<Shape>& cells) {
  std::vector<LatticeSolid> all{lattice_sphere(1e-3)};
  for (const Shape& s : cells) all.push_back(lattice_hull(s.store, 0));
  return all;
}

std::vector<Shape> some_shapes() {
  std::vector<Shape> all;
  const auto cells = some_cells(4);
  for (int k = 0; k < 3; ++k) all.emplace_back(cells.body[static_cast<std::size_t>(k)]);
  all.emplace_back(box_between(Vec3::Zero(), Vec3(1, 0.2, 0.5)));
  return all;
}

}  // namespace

TEST_CASE("families of the horizons: neighbours, and the moduli of a lattice of them") {
  struct Row {
    double horizon;
    bool partial;
    std::size_t neighbours;
    double c11, c12, c44;  // GPa, exact sums
  };
  for (const Row& row : {Row{2.5, false, 80, 104.571, 19.143, 43.988}, Row{2.5, true, 92, 106.376, 18.241, 43.085},
                         Row{3, false, 122, 96.010, 23.423, 48.268}, Row{3.015, true, 178, 106.641, 18.108, 42.953}}) {
    CHECK(lattice_family(row.horizon, row.partial).size() == row.neighbours);
    const double giga = youngs / 1e9;
    const double c11 = 2 * giga * inner_energy(row.horizon, row.partial, gradient({{0, 0}}));
    CHECK(c11 == Approx(row.c11).epsilon(1e-4));
    CHECK(giga * inner_energy(row.horizon, row.partial, gradient({{0, 0}, {1, 1}})) - c11 ==
          Approx(row.c12).epsilon(1e-4));
    CHECK(2 * giga * inner_energy(row.horizon, row.partial, gradient({{0, 1}})) == Approx(row.c44).epsilon(1e-4));
  }
}

TEST_CASE("a dilation is exact at every point of any shape, and no motion of the whole costs energy") {
  const std::vector<Shape> cells = some_shapes();
  for (const LatticeSolid& shape : shapes(cells))
    for (const bool partial : {true, false}) {
      const PointLattice l = make_lattice(shape, lattice_of(700, partial ? 2.5 : 3, partial), 5, 2);
      PeridynamicSolid solid(l, poisson);
      const double d = shape.diameter(), e = 1e-3;
      const double energy = solid.dilate(field(l, d, [&](const Vec3& x) { return Vec3(e * x); }), true);
      double worst = 0;
      for (std::size_t i = 0; i < l.size(); ++i) worst = std::max(worst, std::abs(solid.dilation(i) / (3 * e) - 1));
      CHECK(worst < 1e-12);
      CHECK(energy == Approx(4.5 * solid.bulk_modulus() * e * e * pi / 6).epsilon(1e-12));
      const Mat3 turn = cross_matrix(Vec3(0.3, -0.2, 0.5));
      const PointColumns moved = field(l, d, [&](const Vec3& x) { return Vec3(turn * x + Vec3(1, 2, 3)); });
      CHECK(std::abs(solid.dilate(moved, true)) < 1e-24);
      PointColumns f(l.size());
      solid.pull(f);
      CHECK(dot(f, f) < 1e-24 * dot(moved, moved));
    }
}

TEST_CASE("forces are the slope of the energy, whole and broken; a bond breaks at both its ends; work is symmetric") {
  for (const double nu : {0.15, 0.25, 0.35}) {
    const PointLattice l = make_lattice(lattice_sphere(0.5), lattice_of(500), 1, 4);
    PeridynamicSolid solid(l, nu);
    const PointColumns a = random_field(l, 1), b = random_field(l, 2);
    PointColumns fa(l.size()), fb(l.size());
    for (const bool broken : {false, true}) {
      if (broken) {
        solid.dilate(random_field(l, 3));
        double lost = 0;
        const double before = solid.dilate(random_field(l, 3), true);
        const std::size_t gone = solid.break_above(4.2, lost);  // stretches are normal to some 6
        std::size_t bonds = 0, ends = 0, whole = 0;
        for (std::size_t k = 0; k + 1 < l.octet.size(); ++k)
          for (std::uint32_t w = l.octet[k].bond; w < l.octet[k + 1].bond; ++w)
            ends += static_cast<std::size_t>(__builtin_popcount(l.bond[w] ^ solid.intact()[w])),
                bonds += static_cast<std::size_t>(__builtin_popcount(l.bond[w])),
                whole += static_cast<std::size_t>(__builtin_popcount(solid.intact()[w]));
        CHECK(ends == 2 * gone);
        CHECK(static_cast<double>(ends) / static_cast<double>(bonds) == Approx(0.2).margin(0.08));
        CHECK(before - solid.dilate(random_field(l, 3), true) == Approx(lost).epsilon(1e-10));
        // Every bond that is gone is gone from its other end.
        std::vector<std::vector<bool>> has(l.ways.size(), std::vector<bool>(l.cells));
        for (std::size_t k = 0; k + 1 < l.octet.size(); ++k)
          for (std::uint32_t w = l.octet[k].bond; w < l.octet[k + 1].bond; ++w)
            for (unsigned lane = 0; lane < 8; ++lane)
              if (solid.intact()[w] >> lane & 1) has[l.way[w]][l.octet[k].cell + lane] = true;
        std::size_t single = 0;
        for (std::size_t w = 0; w < l.ways.size(); ++w)
          for (std::size_t v = 0; v < l.ways.size(); ++v)
            if (l.ways[v].step == -l.ways[w].step)
              for (const std::uint32_t c : l.cell)
                single += has[w][c] && !has[v][static_cast<std::size_t>(std::int64_t{c} + l.ways[w].step)];
        CHECK(single == 0);
      }
      solid.dilate(a), solid.pull(fa), solid.dilate(b), solid.pull(fb);
      CHECK(dot(b, fa) == Approx(dot(a, fb)).epsilon(1e-12));
      const double h = 1e-4;
      PointColumns up = a, down = a;
      for (std::size_t k = 0; k < a.size(); ++k) up[k] += h * b[k], down[k] -= h * b[k];
      const double slope = (solid.dilate(up, true) - solid.dilate(down, true)) / (2 * h);  // exact but for rounding
      CHECK(slope == Approx(-dot(fa, b)).epsilon(1e-7));
      CHECK(solid.dilate(a, true) > 0);
      double sum = 0, size = 0;
      for (std::size_t i = 0; i < l.size(); ++i) sum += fa(i, 1), size += std::abs(fa(i, 1));
      CHECK(std::abs(sum) < 1e-13 * size);
    }
  }
}

TEST_CASE("a plane wave in the middle of a block has the speed of its moduli, and the frequency of its sum") {
  const Shape bar{box_between(Vec3::Zero(), Vec3(13, 13, 60) / 60.0)};
  const LatticeSolid shape = lattice_hull(bar.store, 0);
  PointLattice l = make_lattice(shape, lattice_of(13 * 13 * 60, 2.5, true, false), 3, 0);
  PeridynamicSolid solid(l, poisson);
  Eigen::Index along = 0;
  (bar.place.axes.conjugate() * Vec3::UnitZ()).cwiseAbs().maxCoeff(&along);
  const double k = 2 * pi / (40 * l.spacing), d = shape.diameter();
  const PointColumns u = field(l, d, [&](const Vec3& x) { return Vec3(std::cos(k * x[along]) * Vec3::Unit(along)); });
  PointColumns f(l.size());
  solid.dilate(u), solid.pull(f);
  std::size_t middle = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    if (l.point[i].norm() < l.point[middle].norm()) middle = i;
  const auto axis = static_cast<std::size_t>(along);
  const double omega2 = -f(middle, axis) / (l.volume * u(middle, axis));
  const double speed = std::sqrt(omega2 * youngs / 2650) / k;
  CHECK(speed == Approx(6336).epsilon(0.02));
  // theta of a plane wave is (3/m) sum beta z sin(k z); its second difference, and that of the bonds, once more.
  double m = 0, first = 0, bonds = 0;
  for (const LatticeNeighbour& n : lattice_family(2.5, true)) {
    const double z = n.at[2];
    m += n.weight * n.length * n.length, first += n.weight * z * std::sin(k * l.spacing * z);
    bonds += n.weight * z * z / (n.length * n.length) * (1 - std::cos(k * l.spacing * z));
  }
  const double k0 = solid.bulk_modulus() - 5 * solid.shear_modulus() / 3, s2 = l.spacing * l.spacing;
  const double exact = 9 * k0 * first * first / (m * m * s2) + 30 * solid.shear_modulus() * bonds / (m * s2);
  CHECK(omega2 == Approx(exact).epsilon(1e-9));
}

TEST_CASE("forces on points: within the patch, evenly, in balance, with their couple; as large as the contact's area") {
  const double d = 2e-3;
  const LatticeSolid ball = lattice_sphere(0.5 * d);
  const PointLattice l = make_lattice(ball, lattice_of(1000), 2, 9);
  const std::vector<PatchLoad> two = pressed(d, 7);
  const std::vector<Vec3> f = point_forces(l, two, 0.124, d);
  double upper = 0;
  std::size_t loaded = 0, near = 0;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const Vec3 g = l.axes * f[i];
    if (l.point[i].z() > 0) upper += g.z();
    near += (l.point[i] - two[0].at).norm() <= 0.124 * d;
    loaded += g.z() < -0.1 * 7 / static_cast<double>(l.size());
  }
  CHECK(upper == Approx(-7).epsilon(0.02));  // the rest is d'Alembert's: patches of unequal numbers of points
  CHECK(near > 5);
  CHECK(loaded >= near);
  PatchLoad one{Vec3(0, 0.5 * d, 0), Vec3(1, -5, 2), Vec3(1e-3, 2e-3, -1e-3)};
  for (const double area : {0.0, pi * 0.09 * d * d}) {
    one.area = area;
    CHECK(patch_radius(one, 0.124, d) == Approx(area > 0 ? 0.3 * d : 0.124 * d));
    const std::vector<Vec3> g = point_forces(l, std::span(&one, 1), 0.124, d);
    Vec3 total = Vec3::Zero(), moment = Vec3::Zero();
    double size = 0;
    for (std::size_t i = 0; i < l.size(); ++i)
      total += g[i], moment += (l.axes.transpose() * l.point[i]).cross(g[i]), size += g[i].norm();
    CHECK(total.norm() < 1e-13 * size);
    CHECK(moment.norm() < 1e-13 * size * d);
  }
  // A couple alone: what the patch turns by, less what the grain does.
  PatchLoad couple{Vec3(0.5 * d, 0, 0), Vec3::Zero(), Vec3(0, 0, 1e-3)};
  const std::vector<Vec3> with = point_forces(l, std::span(&couple, 1), 0.124, d);
  Vec3 about = Vec3::Zero(), middle = Vec3::Zero();
  std::vector<std::size_t> in;
  for (std::size_t i = 0; i < l.size(); ++i)
    if ((l.point[i] - couple.at).norm() <= 0.124 * d) in.push_back(i), middle += l.point[i];
  middle /= static_cast<double>(in.size());
  for (const std::size_t i : in) about += (l.point[i] - middle).cross(Vec3(l.axes * with[i]));
  CHECK((about - couple.couple).norm() < 0.02 * couple.couple.norm());
}

TEST_CASE("a contact on a corner has four points at least") {
  const Shape cube{unit_cube()};
  const LatticeSolid shape = lattice_hull(cube.store, 0);
  const PointLattice l = make_lattice(shape, lattice_of(300), 2, 1);
  const PatchLoad corner{Vec3::Constant(0.6), Vec3(-1, -1, -1)};
  const std::vector<Vec3> f = point_forces(l, std::span(&corner, 1), 0.01, shape.diameter());
  std::vector<double> size;
  for (const Vec3& x : f) size.push_back(x.norm());
  std::sort(size.rbegin(), size.rend());
  CHECK(size[3] > 0.2 * std::sqrt(3.0));
  CHECK(size[4] < 0.05);
}

TEST_CASE("lattices: about as many points as asked for, drawn by grain, finer in thin grains, none in the thinnest") {
  const LatticeSolid ball = lattice_sphere(1e-3);
  const PointLattice a = make_lattice(ball, lattice_of(1000), 1, 1), again = make_lattice(ball, lattice_of(1000), 1, 1),
                     other = make_lattice(ball, lattice_of(1000), 1, 2);
  CHECK(static_cast<double>(a.size()) == Approx(1000).epsilon(0.03));
  CHECK(a.point == again.point);
  CHECK((a.axes - other.axes).norm() > 1e-3);
  CHECK(a.axes.determinant() == Approx(1));
  CHECK(a.volume * static_cast<double>(a.size()) == Approx(pi / 6).epsilon(1e-14));
  CHECK(a.spacing == Approx(std::cbrt(pi / 6000)));
  for (const Vec3& x : a.point) CHECK(x.norm() <= 1e-3 * (1 + 1e-12));
  struct Row {
    double thick;
    bool fits;
  };
  for (const Row& row : {Row{0.5, true}, Row{0.1, true}, Row{0.01, false}}) {
    const Shape plate{box_between(Vec3::Zero(), Vec3(1, 1, row.thick))};
    const LatticeSolid shape = lattice_hull(plate.store, 0);
    const PointLattice l = make_lattice(shape, lattice_of(500), 1, 1);
    CHECK((l.size() > 0) == row.fits);
    if (!row.fits) continue;
    CHECK(3 * l.spacing * shape.diameter() <= row.thick * (1 + 1e-12));
    CHECK(l.nominal_spacing == Approx(std::cbrt(pi / 3000)));
    CHECK(static_cast<double>(l.size()) == Approx(500 * std::pow(l.nominal_spacing / l.spacing, 3)).epsilon(0.12));
    double worst = 0;
    for (const Vec3& x : l.point)
      for (const Plane& p : shape.planes) worst = std::max(worst, p.normal.dot(x) - p.offset);
    CHECK(worst < 1e-12);
  }
  // A needle's tip: its last points would swing about the line that they lie in.
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 6}};
  const Shape needle{hull_of(corners)};
  const LatticeSolid sharp = lattice_hull(needle.store, 0);
  const PointLattice l = make_lattice(sharp, lattice_of(1000), 1, 1);
  PeridynamicSolid solid(l, poisson);
  PointColumns u(l.size());
  long sweeps = 0;
  const PatchLoad at_tip{needle.place.axes.conjugate() * (corners[3] - needle.place.origin), Vec3(1, 2, 3)};
  const std::vector<Vec3> f = point_forces(l, std::span(&at_tip, 1), 0.124, sharp.diameter());
  CHECK(solve(solid, columns_of(f), u, 1e-5, 500, sweeps) > 0);
}

TEST_CASE("a horizon of more neighbours than a lattice follows is refused, not cut short") {
  const LatticeSolid ball = lattice_sphere(0.5);
  CHECK(lattice_family(3.5, true).size() == 250);
  CHECK(lattice_family(6, true).size() > 900);
  for (const double horizon : {3.0, 3.5, 5.0}) {
    const PointLattice l = make_lattice(ball, lattice_of(horizon > 4 ? 4000 : 300, horizon), 1, 1);
    REQUIRE(l.size() > 0);
    CHECK(*std::max_element(l.way.begin(), l.way.end()) + 1u == l.ways.size());
  }
  CHECK_THROWS_AS(make_lattice(ball, lattice_of(300, 26), 1, 1), InputError);
}

TEST_CASE("critical stretch: both forms, the paper's value, the corrected size law") {
  const double horizon = 3 * 0.062 * 2e-3;
  CHECK(critical_stretch(Toughness::madenci_oterkus, 30, youngs, poisson, horizon) == Approx(8.1113e-4).epsilon(1e-5));
  CHECK(toughness_modulus(Toughness::all_bonds, youngs, poisson) == Approx(120.7e9).epsilon(1e-3));
  CHECK(toughness_modulus(Toughness::all_bonds, youngs, 0.25) == Approx(3.125 * 40e9).epsilon(1e-9));
  CHECK(toughness_modulus(Toughness::madenci_oterkus, youngs, 0.25) == Approx(120e9).epsilon(1e-9));
  for (const Toughness form : {Toughness::all_bonds, Toughness::madenci_oterkus})
    CHECK(fracture_energy(form, critical_stretch(form, 30, youngs, 0.3, horizon), youngs, 0.3, horizon) ==
          Approx(30).epsilon(1e-12));
  // Volume part of all bonds across a plane: theta of a point at depth z from its crossing bonds is 1.5 (1 - 1.25 z +
  // z^5 / 4) stretch, on both sides; half K - 5/3 mu times its square.
  double sum = 0;
  const int n = 20000;
  for (int k = 0; k < n; ++k) {
    const double z = (k + 0.5) / n, theta = 1.5 * (1 - 1.25 * z + 0.25 * std::pow(z, 5));
    sum += theta * theta / n;
  }
  const double mu = youngs / 2.6, bulk = youngs / 1.2;
  CHECK(toughness_modulus(Toughness::all_bonds, youngs, 0.3) ==
        Approx(3.125 * mu + sum * (bulk - 5 * mu / 3)).epsilon(1e-5));
  LatticeToughness t{.energy = 30, .reference_diameter = 2e-3};
  const LatticeChoice choice = lattice_of(1000);
  const auto at = [&](double diameter) { return t.stretch(choice, youngs, poisson, diameter); };
  CHECK(at(0.5e-3) == Approx(at(2e-3)).epsilon(1e-12));
  CHECK(t.stretch(choice, youngs, poisson, 1e-3, 1.7) == Approx(1.7 * at(1e-3)).epsilon(1e-12));
  t.size = SizeLaw::griffith;
  CHECK(at(0.5e-3) == Approx(2 * at(2e-3)).epsilon(1e-12));
  CHECK(at(2e-3) == Approx(critical_stretch(t.form, 30, youngs, poisson, 2.5 * std::cbrt(pi / 6000) * 2e-3)));
}

TEST_CASE("pieces: a cut through all bonds makes two, what hangs on a crack goes to its side, crumbs to the nearest") {
  const PointLattice l = make_lattice(lattice_sphere(0.5), lattice_of(1000), 1, 3);
  PeridynamicSolid solid(l, poisson);
  CHECK(clusters_of(solid, 0.03).pieces == 1);
  const double at = 0.13;
  // Two rigid halves, the upper one lifted: every bond across the plane is longer, none within a half.
  const auto lift = [&](double z) { return l.axes.row(2).transpose() * (z > at ? 1.0 : 0.0); };
  solid.dilate(field(l, 1, [&](const Vec3& x) { return lift((l.axes * x).z()); }));
  double lost = 0;
  CHECK(solid.break_above(1e-9, lost) > 100);
  CHECK(lost > 0);
  Clusters c = clusters_of(solid, 0.03);
  REQUIRE(c.pieces == 2);
  attach(solid, c);
  std::size_t wrong = 0, upper = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    upper += l.point[i].z() > at, wrong += (c.piece[i] == 1) != (l.point[i].z() > at);
  CHECK(wrong == 0);
  const Clusters large = clusters_of(solid, 1.2 * static_cast<double>(upper) / static_cast<double>(l.size()));
  CHECK(large.pieces == 1);
  CHECK(large.crumbs == 0);
  const double more_than_upper = 1.2 * static_cast<double>(upper) / static_cast<double>(l.size());
  const Clusters crumbs = clusters_of(solid, more_than_upper, true);
  CHECK(crumbs.pieces == 1);
  REQUIRE(crumbs.crumbs == 1);
  for (std::size_t i = 0; i < l.size(); ++i)
    if (crumbs.piece[i] >= 0) CHECK(crumbs.piece[i] == (l.point[i].z() > at));
  const std::vector<double> damage = damage_of(solid);
  std::size_t hurt = 0, far = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    hurt += damage[i] > 0.2, far += damage[i] > 0 && std::abs(l.point[i].z() - at) > 3 * l.spacing;
  CHECK(hurt > 100);
  CHECK(far == 0);
}

#if defined(__x86_64__)
TEST_CASE("sweeps over bonds have the same bits in all widths") {
  const PointLattice l = make_lattice(lattice_sphere(0.5), lattice_of(600), 1, 8);
  const LatticeRows rows{l.octet.data(), l.octet.size() - 1, l.way.data(), l.ways.data()};
  const std::size_t n = l.cells, room = l.size() + 8;
  std::vector<double> u(3 * n), some(n);
  for (const std::uint32_t c : l.cell) {
    const Vec3 v = random_vector(c, 1);
    for (std::size_t k = 0; k < 3; ++k) u[k * n + c] = v[static_cast<Eigen::Index>(k)];
    some[c] = 1 + 0.1 * v.x();
  }
  const LatticeColumns at{u.data(), u.data() + n, u.data() + 2 * n};
  struct Out {
    std::vector<std::uint8_t> intact;
    std::vector<double> theta, theta2, square, force, left, lost, lost2, on, off;
    std::size_t broken;
    double stretch;
    bool operator==(const Out&) const = default;
  };
  const auto run = [&](LatticeBreaks breaks, LatticeDilation dilation, LatticeForces forces, LatticeStretch stretch,
                       LatticeStiffness stiffness) {
    Out o{};
    o.intact = l.bond;
    for (auto* by_cell : {&o.theta, &o.theta2, &o.square, &o.left, &o.lost, &o.lost2}) by_cell->resize(n);
    for (auto* by_point : {&o.force, &o.on, &o.off}) by_point->resize(3 * room);
    std::vector<std::uint8_t> weak = l.bond;
    for (std::size_t b = 0; b < weak.size(); b += 3) weak[b] &= 0x3c;
    o.broken =
        breaks(rows, weak.data(), o.intact.data(), at, 5, some.data(), o.left.data(), o.lost.data(), o.lost2.data());
    dilation(rows, o.intact.data(), at, some.data(), o.theta.data(), o.square.data());
    dilation(rows, o.intact.data(), at, some.data(), o.theta2.data(), nullptr);
    forces(rows, o.intact.data(), at, o.theta.data(), some.data(), o.force.data(), room);
    stiffness(rows, o.intact.data(), some.data(), o.on.data(), o.off.data(), room);
    o.stretch = stretch(rows, o.intact.data(), at, std::vector<std::uint8_t>(rows.octets, 0x5a).data());
    return o;
  };
  const Out one = run(lanes1::lattice_breaks, lanes1::lattice_dilation, lanes1::lattice_forces, lanes1::lattice_stretch,
                      lanes1::lattice_stiffness);
  CHECK(one.broken > 1000);
  CHECK(one.theta == one.theta2);
  CHECK(one.theta == one.left);
  CHECK(one.stretch > 1);
  CHECK(one.stretch > 5);  // some may not break
  const Out own = run(lattice_breaks(), lattice_dilation(), lattice_forces(), lattice_stretch(), lattice_stiffness());
  CHECK((own == one));
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    CHECK((run(lanes4::lattice_breaks, lanes4::lattice_dilation, lanes4::lattice_forces, lanes4::lattice_stretch,
               lanes4::lattice_stiffness) == one));
}
#endif
