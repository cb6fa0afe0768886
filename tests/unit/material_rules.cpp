// SPDX-License-Identifier: LGPL-3.0-or-later
// The rules of the driver of RVEs, by made-up responses: when an RVE is not asked, and what two responses say of noise.
#include "dem/rves/deferral.hpp"
#include "dem/rves/tangents.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;

namespace {

Mat3 stretched(double strain) {
  Mat3 f = Mat3::Identity();
  f(2, 2) += strain;
  return f;
}

Response response(double stress, double stiffness) {
  Response r;
  r.stress = stress * Mat3::Identity();
  r.tangent = stiffness * Mat6::Identity();
  r.stable = true;
  return r;
}

}  // namespace

TEST_CASE("an RVE is put off while its tangent foretells less than the tolerance of its stress") {
  const Deferral d{0.05, 1e3};
  Memory m;
  CHECK_FALSE(d.foretells(m, Mat3::Identity()));  // it has never said anything
  commit(m, stretched(0.01), false, response(-1e6, 1e8));
  CHECK(m.heard);
  const double limit = 0.05 * std::sqrt(3.0) * 1e6 / 1e8;  // of the strain
  CHECK(d.foretells(m, stretched(0.99 * limit)));
  CHECK_FALSE(d.foretells(m, stretched(1.01 * limit)));
  CHECK_FALSE((Deferral{0, 1e3}.foretells(m, Mat3::Identity())));
  // What is pending counts.
  CHECK(commit(m, stretched(0.6 * limit), true, {}) == nullptr);
  CHECK(d.foretells(m, stretched(0.39 * limit)));
  CHECK_FALSE(d.foretells(m, stretched(0.41 * limit)));
  CHECK(told(m, stretched(0.1)).beyond == Mat3(stretched(0.1) * m.pending));
  // A turn changes nothing.
  const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3::UnitX()).toRotationMatrix();
  CHECK(d.foretells(m, turn * stretched(0.39 * limit)));
  // No stress counts as smaller than the floor.
  Memory loose;
  commit(loose, Mat3::Identity(), false, response(0, 1e8));
  CHECK(d.foretells(loose, stretched(0.99 * 0.05 * 1e3 / 1e8)));
  CHECK_FALSE(d.foretells(loose, stretched(1.01 * 0.05 * 1e3 / 1e8)));
}

TEST_CASE("an answer of the same increment foretells from where it was given, and is what is committed") {
  const Deferral d{0.05, 1e3};
  Memory m;
  commit(m, Mat3::Identity(), false, response(-1e6, 1e8));
  m.trial = Memory::Trial{stretched(0.1), response(-5e6, 2e8)};
  const double limit = 0.05 * std::sqrt(3.0) * 5e6 / 2e8;
  CHECK(d.foretells(m, stretched(0.99 * limit) * stretched(0.1)));
  CHECK_FALSE(d.foretells(m, stretched(1.01 * limit) * stretched(0.1)));
  const Response* done = commit(m, stretched(0.5 * limit) * stretched(0.1), true, response(1, 1));
  REQUIRE(done);
  CHECK(done->stress(0, 0) == -5e6);
  CHECK(m.stress(0, 0) == -5e6);
  CHECK((m.pending - stretched(0.5 * limit)).norm() < 1e-15);
}

TEST_CASE("a bad prediction costs trust, a good one gives it back") {
  const Deferral d{0.05, 1e3};
  Memory m;
  commit(m, Mat3::Identity(), false, response(-1e6, 1e8));
  m.pending = stretched(-1e-3);  // predicted: zz -1.1e6
  Response r = response(-1e6, 1e8);
  r.tangent(0, 1) = 3e7, r.stress(0, 1) = 0;
  const double error = d.caught_up(m, r);
  CHECK(error == Approx(1e5 / (std::sqrt(3.0) * 1e6)).epsilon(1e-12));
  CHECK(m.trust == Approx(0.9 * 0.05 / error).epsilon(1e-12));
  CHECK((m.pending == Mat3::Identity() && m.stress == r.stress && m.tangent == r.tangent));  // it goes on from there
  const double limit = m.trust * 0.05 * std::sqrt(3.0) * 1e6 / 1e8;
  CHECK(d.foretells(m, stretched(0.99 * limit)));
  CHECK_FALSE(d.foretells(m, stretched(1.01 * limit)));
  CHECK(d.caught_up(m, r) == 0);
  CHECK(m.trust == 1);
  m.pending = stretched(-0.5);
  d.caught_up(m, r);
  CHECK(m.trust == 0.05);  // never none
}

TEST_CASE("noise is what no tangent between none and the elastic one explains") {
  Sweep before{{Mat3::Identity()}, {{-1e6 * Mat3::Identity(), 1e8 * Mat6::Identity(), 0}}};
  auto after = [](double strain, double stress, std::size_t breakages) {
    Sweep s{{stretched(strain)}, {{-1e6 * Mat3::Identity(), 1e8 * Mat6::Identity(), breakages}}};
    s.answer[0].stress(2, 2) += stress;
    return s;
  };
  const auto size = [](const Sweep& s) { return s.answer[0].stress.norm(); };
  for (const double part : {0.0, 0.5, 1.0, 1.99}) {  // anything from nothing to the elastic change, or as much beyond
    CHECK(disagreement(before, after(1e-3, part * 1e5, 0)) == Approx(0).margin(1e-12));
  }
  const Sweep far = after(1e-3, 3e5, 0), broken = after(1e-3, 0, 1);
  CHECK(disagreement(before, far) == Approx(1e5 / size(far)).epsilon(1e-9));  // 2e5 beyond, of which 1e5 is yielding's
  CHECK(disagreement(before, broken) == Approx(1e5 / size(broken)).epsilon(1e-9));
  NoiseMeter meter;
  meter.read(before, far);
  const double first = meter.measured;
  meter.read(before, after(1e-3, 1e5, 0));
  CHECK(meter.measured == Approx(0.7 * first));
  meter.read({}, far);
  CHECK(meter.measured == 0);
  // Of points that two have between them: the squares of both, whoever asks; also of one who has none.
  const auto both = [&](const Sweep& a, const Sweep& b, const Sweep& c) {
    NoiseMeter all, none;
    Misses other{};
    const auto told = [&](Misses& sums) { other = sums; };
    NoiseMeter{}.read(before, b, told);
    const auto join = [&](Misses& sums) {
      for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += other[k];
    };
    all.read(before, a, join), none.read({}, c, join);
    return std::array{all.measured, none.measured};
  };
  const double of_two = std::sqrt(2e10 / (std::pow(size(far), 2) + std::pow(size(broken), 2)));
  CHECK(both(far, broken, {})[0] == Approx(of_two).epsilon(1e-9));
  CHECK(both(far, broken, {})[1] == Approx(1e5 / size(broken)).epsilon(1e-9));
}

TEST_CASE("kept tangents: the first one as it is, or improved to meet the last step") {
  const Sweep first{{Mat3::Identity()}, {{Mat3::Zero(), 1e8 * Mat6::Identity(), 0}}};
  Sweep second{{stretched(1e-3)}, {{Mat3::Zero(), 3e8 * Mat6::Identity(), 0}}};
  second.answer[0].stress(2, 2) = 2e5;
  const std::vector<std::pair<TangentKind, double>> kinds{
      {TangentKind::elastic, 1e8}, {TangentKind::quasi_newton, 2e8}, {TangentKind::network, 3e8}};
  for (const auto& [kind, expected] : kinds) {
    std::vector<Mat6> kept;
    Sweep a = first, b = second;
    choose_tangents(kind, {}, a, kept);
    CHECK(a.answer[0].tangent == Mat6(1e8 * Mat6::Identity()));
    choose_tangents(kind, a, b, kept);
    const double zz = b.answer[0].tangent(2, 2);
    CHECK(zz == Approx(expected));
  }
}
