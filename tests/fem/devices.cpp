// SPDX-License-Identifier: LGPL-3.0-or-later
// What is answered without grains: predictions, linear responses, points that wait or ride along; and what counts as
// noise.
#include "coupling/rve_material.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rves/prediction.hpp"
#include "tests/fem/sand.hpp"

namespace grus {

using namespace dem;
using fem::test::Sand, fem::test::sand, fem::test::standard;

namespace {

Mat3 stretch(double xx, double xz, double zz) {
  Mat3 f = Mat3::Identity();
  f(0, 0) += xx, f(0, 2) = f(2, 0) = xz, f(2, 2) += zz;
  return f;
}

Mat3 turn(double angle) { return Eigen::AngleAxisd(angle, Vec3(1, -2, 0.5).normalized()).toRotationMatrix(); }

/// Grains of the standard sand that break under little.
Sand weak(double strength) {
  Sand s = standard();
  Model model = *s.model;
  FractureModel f;
  f.criteria.emplace_back(HoekBrown{strength, 20});
  model.materials[0].fracture = f;
  s.model = std::make_shared<const Model>(model);
  Team team(1);
  prepare(*s.model, s.state, team);
  return s;
}

/// As many points of one sand as asked, driven by hand.
struct Driven {
  coupling::RveOptions with;
  coupling::RveFarm farm;
  coupling::RveMaterial rves;
  fem::Material material;
  std::vector<double> stress, tangent;

  Driven(const Sand& s, std::size_t points, coupling::RveOptions o)
      : with((o.response.quasi_static = s.q, o)),
        farm(MPI_COMM_SELF, s.model, with.response, 2),
        rves(farm, {s.state}, std::vector<std::size_t>(points, 0), with),
        material(rves.material()),
        stress(6 * points),
        tangent(36 * points) {}

  void respond(const std::vector<Mat3>& f) {
    std::vector<double> rows;
    for (const Mat3& m : f)
      for (int k = 0; k < 9; ++k) rows.push_back(m(k / 3, k % 3));
    REQUIRE(material.respond({rows, stress, tangent}));
  }
  void go(const std::vector<Mat3>& f) { respond(f), material.commit(); }
};

}  // namespace

TEST_CASE(
    "a prediction is stress plus tangent times strain, shear counted as engineers do, turned with the deformation") {
  Mat6 c;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) c(i, j) = 1e8 * (i == j ? 5 : 1.0 / (1 + i + j));
  const Mat3 stress = from_voigt((Vec6() << -1e5, -2e5, -3e5, 1e4, 2e4, 3e4).finished()),
             u = stretch(1e-3, 4e-4, -2e-3), r = turn(0.3);
  Vec6 strain = Vec6::Zero();
  strain[0] = 1e-3, strain[2] = -2e-3, strain[4] = 2 * 4e-4;
  const Mat3 expected = r * (stress + from_voigt(c * strain)) * r.transpose();
  CHECK((dem::predicted(stress, c, r * u) - expected).norm() < 1e-12 * expected.norm());
}

TEST_CASE("an elastic answer turns with its increment, and increments follow one another in their order") {
  Sand s = standard();
  s.q.unbalanced_force = s.q.stress_change = 1e-4;
  dem::ResponseOptions with;
  with.quasi_static = s.q, with.elastic = 0.3;
  coupling::RveFarm farm(MPI_COMM_SELF, s.model, with, 1);
  for (std::uint64_t slot : {0u, 1u, 2u}) farm.put(slot, s.state, 1);
  const Mat3 u = stretch(2e-6, 3e-6, -4e-6), r = turn(0.4);
  const auto straight = farm.advance({{0, {u}}})[0], turned = farm.advance({{1, {r * u}}})[0];
  REQUIRE(straight.elastic);
  REQUIRE(turned.elastic);
  const Mat3 expected = r * straight.response.stress * r.transpose();
  CHECK((turned.response.stress - expected).norm() < 1e-9 * expected.norm());
  // Turned first and then sheared in the turned frame is sheared and turned.
  farm.advance({{2, {r}}});
  farm.commit({2});
  const auto after = farm.advance({{2, {r * u * r.transpose()}}})[0];
  CHECK((after.response.stress - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE("a point that waits has been where its increments lead, one after the other") {
  coupling::RveOptions with;
  with.error = 0.9;
  Driven d(standard(), 1, with);
  const Mat3 cell = standard().state.boundary.cell.vectors;
  Mat3 total = Mat3::Identity();
  d.go({total});
  REQUIRE(d.rves.report().advanced == 1);
  const Mat3 start = from_voigt(Eigen::Map<const Vec6>(d.stress.data()));
  const Mat6 tangent = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data());
  for (const Mat3& f : {turn(0.5), stretch(0, 2e-5, -2e-5), turn(-0.2)}) total = f * total, d.go({f});
  REQUIRE(d.rves.report().deferred == 3);
  const Mat3 told = from_voigt(Eigen::Map<const Vec6>(d.stress.data())),
             foretold = dem::predicted(start, tangent, total);
  CHECK((told - foretold).norm() < 1e-7 * foretold.norm());  // by all of the way since the grains were asked
  const Mat3 large = stretch(0, 0, -0.02);
  total = large * total;
  d.go({large});
  REQUIRE(d.rves.report().advanced > 1);
  CHECK((d.rves.committed(0).boundary.cell.vectors - total * cell).norm() < 1e-8 * cell.norm());
}

TEST_CASE("iterations near one another ask the grains once; the next increment starts from where the last one led") {
  coupling::RveOptions with;
  with.error = 0.05;
  Driven d(standard(), 1, with), every(standard(), 1, {});
  const Mat3 cell = standard().state.boundary.cell.vectors;
  const Mat3 first = turn(0.02) * stretch(2e-3, 1e-3, -4e-3), near = stretch(2e-5, -1e-5, 3e-5) * first,
             far = stretch(0, 0, -2e-3) * first;
  const auto told = [&] { return from_voigt(Eigen::Map<const Vec6>(d.stress.data())); };
  d.respond({first});
  const Mat3 stress = told();
  const Mat6 tangent = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data());
  const auto once = d.rves.report();
  REQUIRE(once.advanced == 1);
  d.respond({near});
  CHECK(d.rves.report().dem_steps == once.dem_steps);
  const Mat3 foretold = dem::predicted(stress, tangent, near * first.inverse());
  CHECK((told() - foretold).norm() < 1e-7 * foretold.norm());
  CHECK((foretold - stress).norm() > 1e-4 * stress.norm());
  d.respond({far});
  CHECK(d.rves.report().advanced == 2);
  d.respond({first});  // from far: no longer near to what the grains were asked last
  CHECK(d.rves.report().advanced == 3);
  d.go({near});
  CHECK(d.rves.report().advanced == 3);
  // The next increment: the grains first go to where they were believed to be, then on, turned or not.
  const Mat3 next = turn(-0.03) * stretch(0, 0, -3e-3);
  d.go({next});
  every.go({near}), every.go({next});
  CHECK(d.rves.report().advanced == 5);
  CHECK(d.rves.report().deferral.count == 1);
  CHECK(d.rves.report().deferral.worst < with.error);
  CHECK((d.rves.committed(0).boundary.cell.vectors - next * near * cell).norm() < 1e-8 * cell.norm());
  const Mat3 asked = from_voigt(Eigen::Map<const Vec6>(every.stress.data()));
  CHECK((told() - asked).norm() < with.error * asked.norm());
}

TEST_CASE("who was told wrong is trusted less") {
  coupling::RveOptions with;
  with.error = 0.05, with.response.tangent = dem::TangentKind::network;
  Driven d(weak(0.4e6), 1, with);
  d.go({Mat3::Identity()});
  CHECK(d.rves.report().least_trust == 1);
  // Squeezed by steps that the elastic tangent foretells well, while grains break.
  for (int k = 0; k < 20; ++k) d.go({stretch(0, 0, -5e-4)});
  const auto& report = d.rves.report();
  REQUIRE(report.deferral.count > 0);
  REQUIRE(report.deferral.worst > 0.9 * with.error);
  CHECK(report.least_trust < 1);
  CHECK(report.least_trust <= 0.9 * with.error / report.deferral.worst * (1 + 1e-9));
  // And so waits for less: a change below the tolerance, above the trusted share of it, is asked of the grains.
  const double trust = report.least_trust;
  REQUIRE(trust < 0.6);
  d.go({stretch(0, 0, -2e-3)});
  for (const double share : {0.8, 0.3 * trust}) {
    const Vec6 stress = Eigen::Map<const Vec6>(d.stress.data()), unit = (Vec6() << 0, 0, -1, 0, 0, 0).finished();
    const Mat6 tangent = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data());
    const auto waited = report.deferred;
    d.go({stretch(0, 0, -share * with.error * from_voigt(stress).norm() / from_voigt(Vec6(tangent * unit)).norm())});
    CHECK((report.deferred > waited) == (share < trust));
  }
}

TEST_CASE("points ride together up to the sharing tolerance of this increment, and not beyond") {
  for (const double part : {0.9, 1.5, 3.0}) {
    coupling::RveOptions with;
    with.share = 1e-3;
    Driven d(standard(), 2, with);
    d.respond({stretch(0, 0, -2e-3), stretch(0, 0, -2e-3 - part * 1e-3)});
    CHECK((d.rves.report().similar == 1) == (part < 1));
    CHECK(d.rves.report().advanced == (part < 1 ? 1u : 2u));
  }
}

TEST_CASE("points that have once been apart do not share, though they have come together") {
  coupling::RveOptions with;
  with.share = 1e-3;
  Driven d(standard(), 3, with);
  const Mat3 s = stretch(0, 3e-3, 0), one = Mat3::Identity(), t = stretch(0, 0, -3e-3);
  d.go({one, one, one});
  d.go({s, one, one});
  d.go({s.inverse(), one, one});
  CHECK(d.rves.report().distinct == 2);
  d.go({t, one, t});  // the third leaves the second, and is where the first is, but has not come its way
  CHECK(d.rves.report().distinct == 3);
  // Who rides on another's path, though it ends in the same place, has a path of its own to go back to: by powers of
  // two, exactly.
  with.share = 0.012;
  Driven e(standard(), 3, with);
  auto shear = [](double amount) {
    Mat3 f = Mat3::Identity();
    f(0, 2) = amount;
    return f;
  };
  e.go({one, one, one});
  e.go({one, shear(0x1p-6), shear(0x1p-7)});  // the second leaves; the third rides on the first
  e.go({one, one, shear(0x1p-7)});            // now it rides on the second, and is where that is
  REQUIRE(e.rves.report().distinct == 2);
  REQUIRE(e.rves.report().replayed == 0);
  e.go({one, one, shear(0x1p-5)});
  CHECK(e.rves.report().replayed == 1);
}

TEST_CASE("yielding is no noise, breakage is, up to a cap") {
  coupling::RveOptions stiff;
  stiff.response.tangent = dem::TangentKind::contact_stiffness;  // the affine bound: what yields stays below it
  Driven d(standard(), 1, stiff);
  d.go({Mat3::Identity()});
  for (int k = 0; k < 10; ++k) d.go({stretch(0, 1e-3, 0)});
  d.respond({stretch(0, 1e-3, 0)});
  const Vec6 first = Eigen::Map<const Vec6>(d.stress.data());
  const Mat6 tangent = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data());
  d.respond({stretch(0, 2e-3, 0)});
  const Vec6 change = Eigen::Map<const Vec6>(d.stress.data()) - first,
             elastic = tangent * (Vec6() << 0, 0, 0, 0, 2e-3, 0).finished();
  REQUIRE((change - elastic).norm() > 0.02 * first.norm());  // far from the tangent
  // Anything from no change to the elastic one is what yielding may do: only what misses by more is no function of
  // strain.
  const double off = from_voigt(Vec6(change - elastic)).norm(), yields = from_voigt(elastic).norm(),
               size = from_voigt(first + change).norm();
  CHECK(d.rves.noise() ==
        Approx(std::max(standard().q.unbalanced_force, std::max(0.0, off - yields) / size)).epsilon(1e-6));
  CHECK(d.rves.noise() < 0.5 * off / size);
  // Where one iteration breaks grains and the other does not, the difference counts; however large, the cap holds.
  const Sand brittle = weak(1.2e6);
  Driven b(brittle, 1, {});
  b.go({Mat3::Identity()});
  b.respond({stretch(0, 0, -1e-4)});
  b.respond({stretch(0, 0, -0.05)});
  CHECK(b.rves.noise() == coupling::RveMaterial::max_noise);
}

TEST_CASE("after a breakage no elastic range is looked for; without one it is") {
  for (const double strength : {1e12, 2e6}) {
    Sand s = weak(strength);
    dem::ResponseOptions with;
    with.quasi_static = s.q, with.elastic = 5;  // whatever slides
    coupling::RveFarm farm(MPI_COMM_SELF, s.model, with, 1);
    farm.put(0, s.state, 1);
    const auto large = farm.advance({{0, {stretch(0, 0, -0.03)}}})[0];
    REQUIRE(large.response.stable);
    REQUIRE((large.response.breakages > 0) == (strength < 1e12));
    farm.commit({0});
    farm.put(1, dem::HostedRve::from(farm.fetch(0)).state,
             1);  // the same grains, and nobody knows that some have broken
    const Mat3 little = stretch(0, 0, -1e-7);
    CHECK(farm.advance({{0, {little}}})[0].elastic == (strength == 1e12));
    CHECK(farm.advance({{1, {little}}})[0].elastic);
  }
}

TEST_CASE("the cheap tangent is the contacts' until Newton stalls; then the network's, for five increments") {
  Driven d(standard(), 1, {});
  const Mat3 f = stretch(0, 1e-5, -1e-5);
  const auto told = [&] {
    return Mat6(Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data()));
  };
  const auto contacts = [&] { return contact_stiffness_tangent(*standard().model, d.rves.committed(0)); };
  const auto network = [&] { return network_tangent(*standard().model, d.rves.committed(0)); };
  d.go({f});
  CHECK(told() == contacts());
  REQUIRE((network() - contacts()).norm() > 0.05 * contacts().norm());
  CHECK(d.material.sharpen());
  CHECK_FALSE(d.material.sharpen());  // there is none better
  for (int k = 0; k < 5; ++k) {
    d.go({f});
    CHECK(told() == network());
  }
  d.go({f});
  CHECK(told() == contacts());
  coupling::RveOptions fixed;
  fixed.response.tangent = dem::TangentKind::contact_stiffness;
  CHECK_FALSE(Driven(standard(), 1, fixed).material.sharpen());
}

TEST_CASE(
    "a cell that can no more ends the run, or goes on as what is left of its stiffness, which is counted and booked") {
  Sand s = standard();
  Model model = *s.model;
  model.numerics.max_overlap = 0.05;
  s.model = std::make_shared<const Model>(model);
  const Mat3 f = stretch(0, 0, -2e-4);
  for (const auto policy : {dem::OnFailure::stop, dem::OnFailure::elastic}) {
    coupling::RveOptions with;
    with.pace = dem::Pace::steady, with.response.on_failure = policy;
    Driven d(s, 2, with);
    int survived = 0;
    const auto rows = [&](const Mat3& m, const Mat3& n) {
      std::vector<double> all;
      for (const Mat3& g : {m, n})
        for (int k = 0; k < 9; ++k) all.push_back(g(k / 3, k % 3));
      return all;
    };
    bool good = true;
    Mat3 last = Mat3::Zero();
    const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3(1, 2, 0).normalized()).toRotationMatrix();  // of all there is
    REQUIRE(d.material.respond({rows(turn, Mat3::Identity()), d.stress, d.tangent}));
    d.material.commit();
    while (survived < 600 && d.rves.report().given_up == 0 &&
           (good = d.material.respond({rows(f, Mat3::Identity()), d.stress, d.tangent}))) {
      d.material.commit(), ++survived;
      if (d.rves.report().given_up == 0) last = from_voigt(Eigen::Map<const Vec6>(d.stress.data()));
    }
    CHECK(good == (policy == dem::OnFailure::elastic));
    if (!good) {
      CHECK(d.material.reason().find("overlap") != std::string::npos);
      continue;
    }
    REQUIRE(survived < 600);
    CHECK(d.rves.report().given_up == 1);
    // Linear from its last stress, and its energy is the work of that.
    const Mat6 c = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(d.tangent.data());
    const Mat3 first = from_voigt(Eigen::Map<const Vec6>(d.stress.data()));
    CHECK((first - dem::predicted(last, c, f)).norm() < 1e-9 * first.norm());
    const std::vector<double> volumes{1, 0};
    const double before = d.material.energy(volumes);
    REQUIRE(d.material.respond({rows(f, Mat3::Identity()), d.stress, d.tangent}));
    d.material.commit();
    const Mat3 second = from_voigt(Eigen::Map<const Vec6>(d.stress.data()));
    const double shrunk = std::pow(f.determinant(), survived);  // volume, of a unit one
    CHECK(d.material.energy(volumes) - before ==
          Approx(0.5 * shrunk * (first + second).cwiseProduct(f - Mat3::Identity()).sum()).epsilon(1e-6));
    // It is saved and goes on as it was.
    const std::string bytes = d.material.save();
    Driven again(s, 2, with);
    again.material.load(bytes);
    REQUIRE(d.material.respond({rows(f, f), d.stress, d.tangent}));
    REQUIRE(again.material.respond({rows(f, f), again.stress, again.tangent}));
    CHECK(d.stress == again.stress);
    CHECK(again.rves.report().given_up == 1);
  }
}

TEST_CASE("points that are spread come back one by one, each with its own inertial number") {
  const Sand& s = standard();
  coupling::RveOptions with;
  with.response.quasi_static = s.q, with.pace = dem::Pace::steady;
  coupling::RveFarm farm(MPI_COMM_SELF, s.model, with.response, 1), other(MPI_COMM_SELF, s.model, with.response, 1);
  const std::vector<std::size_t> start(3, 0);
  coupling::RveMaterial rves(farm, {s.state}, start, with, MPI_COMM_SELF),
      back(other, {s.state}, start, with, MPI_COMM_SELF);
  const fem::Material m = rves.material(), again = back.material();
  std::vector<double> stress(18);
  const auto go = [&](const std::array<double, 3>& ways) {  // paces are set by the largest of recent increments
    std::vector<double> f;
    for (const double way : ways)
      for (int k = 0; k < 9; ++k) f.push_back(stretch(0, 0, -way)(k / 3, k % 3));
    REQUIRE(m.respond({f, stress, {}}));
    m.commit();
  };
  go({4e-5, 4e-5, 4e-5}), go({1e-5, 2e-5, 4e-5});
  const auto numbers = m.inertial_numbers();
  REQUIRE(numbers.size() == 3);
  REQUIRE((numbers[0] > 0 && numbers[0] != numbers[1] && numbers[1] != numbers[2]));
  for (const std::size_t i : {2u, 0u, 1u}) back.load_point(i, rves.save_point(i));
  const auto told = again.inertial_numbers();
  REQUIRE(told.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(told[i] == numbers[i]);
    CHECK(back.save_point(i) == rves.save_point(i));
  }
}

}  // namespace grus
