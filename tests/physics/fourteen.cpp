// SPDX-License-Identifier: LGPL-3.0-or-later
// Spheres that break into fourteen (Ciantia et al. 2015): geometry, criterion, strengths, one event and its books.
#include "dem/fracture/apollonian.hpp"

#include "dem/contact/forces.hpp"
#include "dem/fracture/loaded_grain.hpp"
#include "tests/physics/crushable.hpp"

using namespace grus::dem;
using namespace grus::dem::test;

namespace {

constexpr double R = 1e-3;
constexpr double never = 1e30;

/// A sphere between two plates of a third material, or rigid ones (1), each to the force.
State between_plates(const Model& model, double force, std::uint8_t plates) {
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
  const double overlap = std::pow(force / (4.0 / 3 * reduced_modulus(model.pairs[plates]) * std::sqrt(R)), 2.0 / 3);
  for (const int side : {-1, 1}) {
    Wall wall;
    wall.material = plates;
    wall.shape = PlaneWall{Vec3(0, 0, -side)}, wall.point = Vec3(0, 0, side * (R - overlap));
    s.boundary.walls.push_back(wall);
  }
  return s;
}

bool breaks(const Model& model, double force, std::uint8_t plates) {
  State s = between_plates(model, force, plates);
  Team team(1);
  prepare(model, s, team);
  return !find_breaks(model, s, team).empty();
}

/// The force between bisected bounds at which it breaks (N).
double strength_between_plates(const Model& model, std::uint8_t plates) {
  double low = 1e-3, high = 1e5;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::sqrt(low * high);
    (breaks(model, middle, plates) ? high : low) = middle;
  }
  return high;
}

Pieces pieces_of_ball(State& s, const Vec3& load, std::uint64_t seed = 1) {
  return grus::dem::pieces_of(Balls{}, s.grains, 0, {Mat3::Zero(), std::nullopt, load}, seed);
}

}  // namespace

TEST_CASE("fourteen balls touch their mother from inside and one another in 39 points, and nowhere overlap") {
  const auto& b = fourteen_balls();
  const std::vector<std::pair<std::size_t, std::pair<double, Vec3>>> table{
      {0, {0.4641016151, {0, 0.5358983849, 0}}},
      {3, {0.2240092377, {0, -0.7759907623, 0}}},
      {6, {0.2572842744, {0, -0.5941725804, 0.4456294353}}},
      {12, {0.3660254038, {0, 0, 0.6339745962}}}};
  for (const auto& [n, ball] : table) {
    CHECK(b[n].radius == Approx(ball.first).margin(1e-10));
    CHECK((b[n].centre - ball.second).norm() < 2e-10);
  }
  int tangent = 0;
  double next = INFINITY;
  for (std::size_t i = 0; i < 14; ++i) {
    CHECK(b[i].centre.norm() + b[i].radius == Approx(1).margin(1e-14));
    for (std::size_t j = 0; j < i; ++j) {
      const double gap = (b[i].centre - b[j].centre).norm() - b[i].radius - b[j].radius;
      CHECK(gap > -1e-14);
      tangent += gap < 1e-9;
      if (gap >= 1e-9) next = std::min(next, gap);
    }
  }
  CHECK(tangent == 39);
  CHECK(next == Approx(0.377).margin(5e-4));
  CHECK(kept_volume() == Approx(0.5338735270).margin(1e-10));
  CHECK(smallest_ball() == Approx(0.2240092377).margin(1e-10));
  Vec3 centre = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
  for (const Ball& ball : b) {
    const double m = std::pow(ball.radius, 3);
    const Vec3& c = ball.centre;
    centre += m * c;
    inertia += m * ((0.4 * ball.radius * ball.radius + c.squaredNorm()) * Mat3::Identity() - c * c.transpose());
  }
  CHECK(centre.norm() < 1e-14);
  CHECK(inertia(0, 0) / 0.4 == Approx(0.413602).margin(1e-6));
  CHECK(inertia(1, 1) / 0.4 == Approx(0.413602).margin(1e-6));
  CHECK(inertia(2, 2) / 0.4 == Approx(0.442455).margin(1e-6));
}

TEST_CASE("the poles are on the line of the largest force, and the turn about it is the grain's own draw") {
  State s;
  add(s, PolyEllipsoid::sphere(2), Vec3(1, 2, 3), 2650);
  const Vec3 load = Vec3(1, -2, 0.5).normalized();
  const Pieces one = pieces_of_ball(s, load), again = pieces_of_ball(s, load), other = pieces_of_ball(s, load, 2);
  REQUIRE(one.piece.size() == 14);
  for (const std::size_t pole : {12u, 13u}) {
    const Vec3 at = (one.piece[pole].position - Vec3(1, 2, 3)) / 2;
    CHECK(std::abs(at.dot(load)) == Approx(0.6339745962).margin(1e-9));
    CHECK((at - at.dot(load) * load).norm() < 1e-12);
  }
  CHECK(one.piece[0].position == again.piece[0].position);
  CHECK((one.piece[0].position - other.piece[0].position).norm() > 1e-3);
  CHECK(one.piece[0].shape.plus.x() == Approx(2 * 0.4641016151).epsilon(1e-9));
}

TEST_CASE("a neighbour's flat face at random keeps touching the balls in the share that geometry gives") {
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3::Zero(), 2650);
  const Pieces pieces = pieces_of_ball(s, Vec3::UnitX());
  const std::uint64_t draws = 40000;
  for (const auto& [overlap, share] : std::vector<std::pair<double, double>>{{0.01, 0.104}, {0.05, 0.508}}) {
    std::uint64_t kept = 0;
    for (std::uint64_t k = 0; k < draws; ++k) {
      const Vec3 n = random_rotation(77, k) * Vec3::UnitZ();
      double height = 0;
      for (const auto& p : pieces.piece) height = std::max(height, n.dot(p.position) + p.shape.plus.x());
      kept += 1 - height < overlap;
    }
    // Five standard errors of a share drawn so often, and half of the last digit.
    const double error = 5 * std::sqrt(share * (1 - share) / static_cast<double>(draws)) + 5e-4;
    CHECK(static_cast<double>(kept) / static_cast<double>(draws) == Approx(share).margin(error));
  }
}

TEST_CASE("between plates a grain breaks at the forces of closed form: by an angle, and by Hertz's circle") {
  const double angle = pi / 9;
  CHECK(strength_between_plates(model_of(crushable({300e6, angle})), 1) == Approx(110.25).epsilon(1e-3));
  // F = (pi strength)^3 (3 R / 4 E*)^2 on plates of steel.
  for (const auto& [youngs, strength, force] :
       std::vector<std::array<double, 3>>{{0.858e9, 200e6, 158.30}, {7.8e9, 800e6, 131.21}, {46.8e9, 2200e6, 106.92}}) {
    Model model = model_of(crushable({strength, std::nullopt}));
    model.materials[0].youngs_modulus = youngs;
    model.materials.push_back(solid(200e9, 0.3, 7800));
    make_pair_laws(model);
    CHECK(strength_between_plates(model, 2) == Approx(force).epsilon(5e-3));
    const double e = reduced_modulus(model.pairs[2]);
    CHECK(strength_between_plates(model, 2) ==
          Approx(std::pow(pi * strength, 3) * std::pow(3 * R / (4 * e), 2)).epsilon(1e-6));
  }
}

TEST_CASE("the contact's strength that a compressive and a tensile strength stand for") {
  CHECK(ContactStrength::limit(1100e6, 48e6, 0.3) == Approx(2309.9e6).epsilon(5e-5));
}

TEST_CASE("force over diameter squared falls with size by 3/m for a fixed angle, 9/m for Hertz's circle") {
  const double m = 3;
  for (const bool angle : {true, false}) {
    ContactStrength strength{300e6, std::nullopt};
    if (angle) strength.angle = pi / 18;
    const Scatter law{false, 0, 2e-3, 3 / m};
    std::vector<double> x, y;
    for (const double d : {1e-3, 2e-3, 4e-3}) {
      // F = factor of strength (angle), its cube (Hertz), both times d^2.
      const double factor = law(0.5 * d, 1, 1), f = angle ? factor * d * d : std::pow(factor, 3) * d * d;
      x.push_back(std::log(d));
      y.push_back(std::log(f / d / d));
    }
    CHECK((y[2] - y[0]) / (x[2] - x[0]) == Approx(angle ? -3 / m : -9 / m).epsilon(1e-12));
    // The law reaches the test: a grain twice the reference is weaker by 2^-3/m.
    Material material = crushable(strength);
    material.fracture->strength_law = Scatter{false, 0, R, 3 / m};
    const double with = strength_between_plates(model_of(material), 1);
    const double without = strength_between_plates(model_of(crushable(strength)), 1);
    CHECK(with / without == Approx(std::pow(2, angle ? -3 / m : -9 / m)).epsilon(1e-6));
  }
}

TEST_CASE("scatter: log-normal draws have the mean 1 and their variation; normal ones are drawn anew below 0.05") {
  // Of a normal distribution cut at 0.05: means and variations by its closed form.
  const auto truncated = [](double sd) {
    const double a = (Scatter::least - 1) / sd, tail = 0.5 * std::erfc(a / std::sqrt(2.0));
    const double hazard = std::exp(-0.5 * a * a) / std::sqrt(2 * pi) / tail;
    const double mean = 1 + sd * hazard;
    return std::array<double, 2>{mean, sd * std::sqrt(1 + a * hazard - hazard * hazard) / mean};
  };
  CHECK(truncated(0.48)[0] == Approx(1.028).margin(5e-4));
  CHECK(truncated(1)[1] == Approx(0.600).margin(5e-4));
  const std::uint64_t n = 40000;
  for (const double variation : {0.48, 1.0})
    for (const bool normal : {false, true}) {
      const Scatter law{normal, variation, 1, 0};
      const auto [mean, relative] = normal ? truncated(variation) : std::array<double, 2>{1, variation};
      double sum = 0, squares = 0, least = INFINITY;
      for (std::uint64_t i = 0; i < n; ++i) {
        const double x = law(0.5, 7, i);
        sum += x;
        squares += x * x;
        least = std::min(least, x);
      }
      const double count = static_cast<double>(n), average = sum / count;
      CHECK(least > (normal ? Scatter::least : 0));
      CHECK(average == Approx(mean).epsilon(5 * relative / std::sqrt(count)));
      CHECK(std::sqrt(squares / count - average * average) / average == Approx(relative).epsilon(0.05));
    }
}

TEST_CASE("one event: thirteen more grains, and all that the mother had is theirs or the fines'") {
  for (const bool keep : {false, true}) {
    Model model = model_of(crushable({300e6, pi / 9}, 0.4));
    std::get<Balls>(model.materials[0].fracture->splitter).keep_mass = keep;
    model.materials[0].fracture->fines = {2.6, smallest_ball(), 1e-5};
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3(2, -1, 3), 2650, Vec3(5, 1, -2), Vec3(300, -200, 500));
    Team team(1);
    prepare(model, s, team);
    const double mass = total_mass(s.grains), energy = kinetic_energy(s.grains);
    const Vec3 p = momentum(s.grains), l = angular_momentum(s.grains);
    apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, Vec3::UnitY()}}}, team);
    REQUIRE(s.grains.size() == 14);
    const Fines& fines = s.ledger.fines;
    CHECK(total_mass(s.grains) == Approx((keep ? 1 : 0.5338735270) * mass).epsilon(1e-9));
    CHECK(std::abs(total_mass(s.grains) + fines.mass - mass) < 1e-12 * mass);
    CHECK((momentum(s.grains) + fines.momentum - p).norm() < 1e-12 * p.norm());
    CHECK((angular_momentum(s.grains) + fines.angular_momentum - l).norm() < 1e-12 * l.norm());
    CHECK(std::abs(kinetic_energy(s.grains) + fines.kinetic - energy) < 1e-12 * energy);
    CHECK(fines.volume == Approx(fines.mass / 2650).margin(1e-30));
    CHECK(fines.classes.size() == (keep ? 0 : 1));
    for (const std::uint8_t generation : s.grains.generation) CHECK(generation == 1);
    // Tangent to round-off: nothing is stored between them.
    CHECK(elastic_energy(model.law, s.contacts) < 1e-12 * energy);
  }
}

TEST_CASE("the ball at the pole keeps the overlap: by geometry alone it feels more than the mother could bear") {
  // Against an equal sphere, over the radius of either: 0.36603 R, R_e = 2 r / (1 + r) of the mother's.
  struct Case {
    bool angle;
    double m, utilisation;
  };
  for (const Case& c : {Case{true, 2, 1.21}, Case{true, 3, 2.00}, Case{false, 10, 1.01}}) {
    ContactStrength strength{300e6, std::nullopt};
    if (c.angle) strength.angle = pi / 9;
    Material material = crushable(strength);
    material.fracture->strength_law = Scatter{false, 0, 2 * R, 3 / c.m};
    material.fracture->limit.smallest_radius = 0.3 * R;
    Model model = model_of(material);
    // Two grains pressed together by walls, at the mother's utilisation 1.
    const double stiffness = 4.0 / 3 * reduced_modulus(model.pairs[0]) * std::sqrt(0.5 * R);
    const double radius_of =
        std::pow(pi * 300e6 * 3 * 0.5 * R / (4 * reduced_modulus(model.pairs[0])), 2);  // a^2 at u = 1, Hertz
    const double overlap = c.angle ? std::pow(300e6 * pi * R * R * std::pow(std::sin(pi / 9), 2) / stiffness, 2.0 / 3)
                                   : radius_of / (0.5 * R);
    State s;
    add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
    add(s, PolyEllipsoid::sphere(R), Vec3(0, 0, 2 * R - overlap), 2650);
    Team team(1);
    prepare(model, s, team);
    const LoadedGrain mother(model.law, 0.3, s.grains, s.contacts, 0);
    REQUIRE(strength.utilisation(mother, 1) == Approx(1).epsilon(1e-9));
    CHECK((load_direction(mother) - Vec3::UnitZ()).norm() < 1e-12);
    apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, load_direction(mother)}}}, team);
    double most = 0;
    for (std::size_t i = 0; i < s.grains.size(); ++i) {
      if (s.grains.extent[i].equivalent_radius > 0.4 * R) continue;
      const LoadedGrain ball(model.law, 0.3, s.grains, s.contacts, i);
      most = std::max(most, strength.utilisation(ball, s.grains.strength[i]));
    }
    CHECK(most == Approx(c.utilisation).margin(0.01));
    // Its contact is a new one: stiffness of its own radius, no history.
    for (std::size_t k = 0; k < s.contacts.size(); ++k)
      if (s.contacts.touch[k].overlap > 0.5 * overlap)
        CHECK(s.contacts.contact.radius[k] == Approx(R * 0.3660254038 / 1.3660254038).epsilon(1e-6));
  }
}

TEST_CASE("balls that touch one wall carry it each with the stiffness of its own radius") {
  Model model = model_of(crushable({300e6, pi / 9}));
  State s;
  add(s, PolyEllipsoid::sphere(R), Vec3::Zero(), 2650);
  // Deep into the ball in a gap of the equator, and into both balls beside it, alike.
  const Vec3 out = pieces_of_ball(s, Vec3::UnitZ(), model.seed).piece[3].position.normalized();
  s.boundary.walls.push_back({.point = 0.7 * R * out, .shape = PlaneWall{-out}, .material = 1});
  Team team(1);
  prepare(model, s, team);
  apply_breaks(model, s, {{0, {Mat3::Zero(), std::nullopt, Vec3::UnitZ()}}}, team);
  std::size_t touching = 0;
  for (std::size_t k = s.contacts.begin[first_wall]; k < s.contacts.size(); ++k) {
    if (!s.contacts.contact.touching(k)) continue;
    const double radius = s.grains.extent[s.contacts.pair[k].a].equivalent_radius;
    CHECK(s.contacts.contact.stiffness[k] ==
          Approx(4.0 / 3 * reduced_modulus(model.pairs[1]) * std::sqrt(radius)).epsilon(1e-12));
    ++touching;
  }
  CHECK(touching >= 3);
}

TEST_CASE("fragments rest: none is tested before its steps have passed, nor while it is out of balance") {
  Material material = crushable({300e6, pi / 9});
  material.fracture->limit = {0, 255, 20};
  Model model = model_of(material);
  State s = between_plates(model, 200, 1);  // nearly twice what it bears
  Team team(1);
  prepare(model, s, team);
  REQUIRE(s.grains.born.size() == 1);
  const auto breaks = find_breaks(model, s, team);
  REQUIRE(breaks.size() == 1);
  s.steps = 7;
  apply_breaks(model, s, breaks, team);
  REQUIRE(s.grains.born.size() == 14);
  for (const auto born : s.grains.born) CHECK(born == 7);
  const std::vector<Vec3> pushed = s.grains.force;
  for (auto& f : s.grains.force) f.setZero();
  s.steps = 26;
  CHECK(find_breaks(model, s, team).empty());
  s.grains.force = pushed;
  s.steps = 27;  // the balls at the poles are pushed from one side alone
  CHECK(find_breaks(model, s, team).empty());
  for (auto& f : s.grains.force) f.setZero();
  CHECK(find_breaks(model, s, team).size() == 2);
  model.materials[0].fracture->limit.rest = 0;
  s.steps = 8;
  CHECK(find_breaks(model, s, team).size() == 2);
}

TEST_CASE("any criterion with any splitter: fourteen balls by Hoek-Brown, halves by the strength of a contact") {
  const double critical = 2 * pi * R * R * 592e6 / 3;
  for (const double part : {0.999, 1.001}) {
    Material by_stress = crushable({never, pi / 9});
    by_stress.fracture->criteria = {HoekBrown{592e6, 15}};
    Model model = model_of(by_stress);
    State s = between_plates(model, part * critical, 1);
    Team team(1);
    prepare(model, s, team);
    const auto found = find_breaks(model, s, team);
    REQUIRE(found.size() == (part > 1 ? 1 : 0));
    if (found.empty()) continue;
    apply_breaks(model, s, found, team);
    CHECK(s.grains.size() == 14);
  }
  Material halved = crushable({300e6, pi / 9});
  halved.fracture->splitter = Halves{.turn_spheres = true};
  const Model model = model_of(halved);
  State s = between_plates(model, 120, 1);
  Team team(1);
  prepare(model, s, team);
  const auto found = find_breaks(model, s, team);
  REQUIRE(found.size() == 1);
  apply_breaks(model, s, found, team);
  REQUIRE(s.grains.size() == 2);
  // The plane holds the line of the load.
  const Vec3 apart = s.grains.motion[1].position - s.grains.motion[0].position;
  CHECK(std::abs(apart.normalized().z()) < 1e-6);
}

TEST_CASE("where nothing touches, the poles are along the most compressive stress") {
  State s;
  add(s, PolyEllipsoid::sphere(1), Vec3::Zero(), 2650);
  const Quat turn(0.8, 0.36, 0.48, 0);
  const Mat3 r = turn.toRotationMatrix(), stress = r * Vec3(0, 1e6, -1e6).asDiagonal() * r.transpose();
  const Pieces p = grus::dem::pieces_of(Balls{}, s.grains, 0, {stress, std::nullopt, Vec3::Zero()}, 1);
  for (const std::size_t pole : {12u, 13u})
    CHECK(std::abs(p.piece[pole].position.normalized().dot(r.col(2))) == Approx(1).epsilon(1e-12));
}
