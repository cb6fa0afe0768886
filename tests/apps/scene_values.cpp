// SPDX-License-Identifier: LGPL-3.0-or-later
// What scenes say of tests and samples is what is read of them, number by number, in SI units.
#include <fmt/format.h>

#include "apps/scene/speeds.hpp"
#include "tests/apps/scene_texts.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::read, grus::app::test::rock, grus::app::test::sand;
using grus::app::test::Scratch;
using grus::dem::Vec3;

namespace {

dem::Programme loaded(const std::string& loading) { return read(sand, {"loading={" + loading + "}"}).test; }

/// The axes of a loading: rate (1/s), stress (Pa; none: NaN), largest rate (1/s), rate of the stress (Pa/s).
void check_axes(const dem::Loading& l, const std::vector<std::array<double, 4>>& wanted) {
  CHECK(l.driven);
  for (std::size_t k = 0; k < 3; ++k) {
    const dem::AxisControl& a = l.axes[k];
    INFO("axis " << k);
    CHECK(a.strain_rate == wanted[k][0]);
    CHECK(a.stress.has_value() == !std::isnan(wanted[k][1]));
    if (a.stress) CHECK(*a.stress == wanted[k][1]);
    CHECK((a.max_rate == wanted[k][2] && a.stress_rate == wanted[k][3]));
  }
}

}  // namespace

TEST_CASE("loadings drive the axes that they name: strains and pressures compress, what is held has its bound") {
  auto p = loaded("kind=\"uniaxial-strain\", axis=\"y\", strain_rate=-4, final_strain=0.2");
  CHECK((p.axis == 1 && p.strain_rate == -4 && p.duration == Approx(0.05) && !p.final_stress && !p.loading.holds));
  check_axes(p.loading, {{0, NAN, 0, 0}, {4, NAN, 0, 0}, {0, NAN, 0, 0}});
  p = loaded("kind=\"oedometric-stress\", axis=\"x\", strain_rate=2, final_stress=\"3 MPa\"");
  CHECK((p.axis == 0 && *p.final_stress == 3e6 && p.duration == Approx(0.3) && !p.stress_time));
  check_axes(p.loading, {{-2, NAN, 0, 0}, {0, NAN, 0, 0}, {0, NAN, 0, 0}});
  p = loaded(
      "kind=\"oedometric-stress\", strain_rate=2, final_stress=3e6, max_strain=0.1, control=\"stress\", "
      "stress_rate=\"10 MPa/s\"");
  CHECK((p.axis == 2 && *p.stress_time == Approx(0.3) && p.duration == Approx(0.33)));
  check_axes(p.loading, {{0, NAN, 0, 0}, {0, NAN, 0, 0}, {0, 0, 2, -1e7}});
  p = loaded(
      "kind=\"oedometric-stress\", strain_rate=0.2, final_stress=3e6, max_strain=0.1, control=\"stress\", "
      "stress_rate=1e7");
  CHECK(p.duration == Approx(0.5));  // a strain may take longer than the ramp
  p = loaded("kind=\"isotropic-stress\", strain_rate=3, pressure=\"2 MPa\", duration=\"40 ms\"");
  CHECK((p.duration == Approx(0.04) && p.strain_rate == 3 && !p.loading.holds));
  check_axes(p.loading, {{0, -2e6, 3, 0}, {0, -2e6, 3, 0}, {0, -2e6, 3, 0}});
  p = loaded("kind=\"triaxial\", strain_rate=3, confining_pressure=1e6, final_strain=0.6");
  CHECK((p.duration == Approx(0.2) && p.loading.holds));
  check_axes(p.loading, {{0, -1e6, 6, 0}, {0, -1e6, 6, 0}, {-3, NAN, 0, 0}});
  for (const double rate : {3.0, -3.0}) {
    p = loaded(fmt::format("kind=\"constant-p\", axis=\"x\", strain_rate={}, pressure=1e6, final_strain=0.3", rate));
    CHECK((*p.loading.mean == -1e6 && p.loading.consolidation == Approx(0.02) && p.duration == Approx(0.12)));
    check_axes(p.loading, {{-rate, NAN, 18, 0}, {0, -1e6, 18, 0}, {0, -1e6, 18, 0}});
    CHECK(p.loading.holds);
  }
  CHECK(loaded("kind=\"constant-p\", strain_rate=3, pressure=1, final_strain=0.3, consolidation=0.5").duration ==
        Approx(0.6));
  // A mean of 2 Pa, of which nothing else is added: axes at 1, 2 and 3 Pa.
  p = loaded(
      "kind=\"true-triaxial\", constant_mean=true, final_strain=0.3, x={stress=1}, y={strain_rate=3, stress=3}, "
      "z={b=0.5}");
  CHECK((*p.loading.mean == Approx(-2).epsilon(1e-12) && *p.loading.ratio == 0.5 && p.loading.middle == 2));
  CHECK((*p.loading.first - Vec3(-1, -3, -2)).norm() < 1e-12);
  CHECK((p.axis == 1 && p.strain_rate == 3 && p.loading.consolidation == Approx(0.02) && p.duration == Approx(0.12)));
  check_axes(p.loading, {{0, -1, 18, 0}, {-3, NAN, 18, 0}, {0, -2, 18, 0}});
  p = loaded("kind=\"velocity-gradient\", duration=2, velocity_gradient=[[0, 3, 0], [0, 0, 0], [4, 0, 0]]");
  CHECK((p.duration == 2 && p.strain_rate == 5 && !p.loading.driven));
  const dem::Mat3& L = *p.loading.velocity_gradient;
  CHECK((L(0, 1) == 3 && L(2, 0) == 4 && L.norm() == 5));
  const RveScene fell = read(sand, {"loading.gravity=[1, 2, \"-9.81 m/s^2\"]"});
  CHECK(fell.model.motion.gravity == Vec3(1, 2, -9.81));
}

TEST_CASE(
    "rows of a test: of its strain or its time, a two-hundredth where none are told; too few for frames are noted") {
  const std::string strained = "loading={kind=\"uniaxial-strain\", strain_rate=-4, final_strain=0.2}";
  const auto interval = [&](const std::string& loading, const std::string& output) {
    return read(sand, {loading, "output={" + output + "}"}).output.history_interval;
  };
  CHECK(interval(strained, "") == Approx(0.05 / 200));
  CHECK(interval(strained, "history_interval=0.001") == Approx(0.00025));
  CHECK(interval(strained, "history_interval=\"1 ms\"") == Approx(0.001));
  CHECK(interval("loading.duration=2", "history_interval=0.5") == 0.5);  // without a rate in seconds
  RveScene s = read(sand, {"output={frames=12, gradings=3, history_interval=0.1, checkpoint_interval=\"2 min\"}"});
  CHECK(
      (s.output.frames == 12 && s.output.gradings == 3 && s.output.checkpoint_interval == 120 && !s.output.last_state));
  REQUIRE(s.notes.size() == 1);
  CHECK(s.notes[0] ==
        "output: 12 frames are asked for, but one is written with a row of history.csv at most, of which there are 11; "
        "shorten history_interval for more");
  CHECK(read(sand, {"output={frames=11, gradings=11, history_interval=0.1}"}).notes.empty());
  s = read(sand, {"output={frames=11, gradings=13, history_interval=0.1}"});
  CHECK(s.notes.at(0).starts_with("output: 13 gradings are asked for"));
  const std::vector<std::pair<const char*, bool Output::*>> flags{
      {"grading", &Output::grading}, {"critical_grain", &Output::critical_grain}, {"last_state", &Output::last_state}};
  for (const auto& [key, flag] : flags)
    for (const auto& [other, of] : flags)
      CHECK(read(sand, {fmt::format("output.{}=true", key)}).output.*of == (flag == of));
  s = read(sand, {"output={frames=2, contacts=true}"});
  CHECK((s.output.contacts && !s.output.wrapped));
  s = read(sand, {"output={frames=2, wrapped=true}"});
  CHECK((s.output.wrapped && !s.output.contacts));
  CHECK(read(rock, {"output.bursts=\"3 us\""}).output.bursts == 3e-6);
  CHECK((read(rock, {"output.broken_bonds=true"}).output.broken_bonds &&
         read(rock, {"output.broken_bonds=true"}).model.records_bonds));
  CHECK_FALSE(read(rock).model.records_bonds);
}

TEST_CASE("stages have the rates, sides, ends and bounds that they are told, or those of their kind") {
  const auto stages = [](const std::string& list) {
    return read(sand.substr(0, sand.find("[loading]")) + "[[stage]]\nkind=\"relax\"\nuntil={time=0.5}\n" + list);
  };
  const auto stage = [&](const std::string& table) { return stages("[[stage]]\n" + table).test.stages.at(1); };
  dem::Stage s = stage(
      "kind=\"compress\"\nstrain_rate=2\nuntil={strain=0.1, void_ratio=0.4, time=\"3 ms\"}\nfriction=0.1\n"
      "damping=0.2\nname=\"n\"\nrows=7\n");
  CHECK((s.kind == dem::StageKind::compress && s.name == "n" && s.axis == 2 && !s.all && s.strain_rate == 2 &&
         s.rows == 7));
  CHECK((*s.until.strain == 0.1 && *s.until.void_ratio == 0.4 && *s.until.time == 0.003 && !s.until.stress));
  CHECK((*s.friction == 0.1 && *s.damping == 0.2 && !s.gravity && s.max_strain == 0.6 && s.max_time == 0));
  CHECK((s.lateral == dem::Lateral::fixed && !s.lateral_stress && s.legs() == 1));
  s = stage("kind=\"compress\"\nstrain_rate=2\naxis=\"all\"\nuntil={stress=\"2 MPa\"}\n");
  CHECK((s.all && *s.until.stress == 2e6 && s.name == "compress" && s.rows == 25 && !s.by_strain()));
  s = stage(
      "kind=\"compress\"\nstrain_rate=2\naxis=\"x\"\nstress_rate=1e6\nuntil={stress=1e6}\nlateral_stress=1e5\nmax_time="
      "4\nmax_strain=0.3\n");
  CHECK((s.axis == 0 && *s.stress_rate == 1e6 && s.lateral == dem::Lateral::held && *s.lateral_stress == 1e5));
  CHECK((s.max_time == 4 && s.max_strain == 0.3 && !s.by_strain()));
  s = stage("kind=\"shear\"\nstrain_rate=-2\nuntil={deviator=1e6}\n");
  CHECK((s.lateral == dem::Lateral::held && s.strain_rate == -2 && *s.until.deviator == 1e6 && !s.plane));
  s = stage("kind=\"shear\"\nplane=\"zx\"\nstrain_rate=2\nuntil={strain=3}\n");
  CHECK(((*s.plane)[0] == 2 && (*s.plane)[1] == 0 && s.axis == 0 && s.max_strain == 10));
  s = stage("kind=\"shear\"\nlateral=\"volume\"\nstrain_rate=2\nuntil={strain=0.3}\n");
  CHECK(s.lateral == dem::Lateral::volume);
  s = stage("kind=\"hold\"\nuntil={unbalanced_force=0.01}\nmax_time=2\n");
  CHECK((s.all && s.strain_rate == 0 && *s.until.unbalanced_force == 0.01 && s.max_time == 2));
  s = stage("kind=\"cyclic\"\nstrain_rate=2\nstrain_amplitude=0.01\ncycles=3\n");
  CHECK((s.swing == dem::Swing::strain && s.amplitude == 0.01 && s.cycles == 3 && s.legs() == 7));
  CHECK(stage("kind=\"cyclic\"\nstrain_rate=2\nstress_amplitude=\"1 kPa\"\ncycles=3\n").swing == dem::Swing::stress);
  CHECK(stage("kind=\"cyclic\"\nstrain_rate=2\ndeviator_amplitude=9\ncycles=3\n").swing == dem::Swing::deviator);
  const RveScene turn = stages(
      "[[stage]]\nkind=\"unload\"\nstrain_rate=1\nuntil={strain=0.01}\n[[stage]]\nkind=\"reload\"\nstrain_rate=1\n"
      "[[stage]]\nkind=\"reload\"\nstrain_rate=1\nuntil={strain=0.02}\n");
  CHECK((turn.test.stages[2].to_turn && !turn.test.stages[1].to_turn && !turn.test.stages[3].to_turn));
  CHECK((turn.output.last_state && turn.test.kind == dem::TestKind::staged && turn.test.duration == 1));
  // 0.5 s, a strain of 0.1 at 2 1/s but 3 ms, four sweeps of 0.01 for each of three cycles.
  CHECK(
      stages("[[stage]]\nkind=\"compress\"\nstrain_rate=2\nuntil={strain=0.1, time=0.003}\n[[stage]]\nkind=\"cyclic\"\n"
             "strain_rate=2\nstrain_amplitude=0.01\ncycles=3\n")
          .test.duration == Approx(0.5 + 0.003 + 0.06));
}

TEST_CASE("packings are as dense, as graded and as large as they are told") {
  const auto random = [](const std::vector<std::string>& sets) {
    return std::get<dem::RandomPacking>(read(sand, sets).recipe.grains);
  };
  CHECK(random({}).solid_fraction == 0.3);
  const std::string none = "packing.solid_fraction=";  // taken out
  CHECK(random({none, "packing.void_ratio=1.5"}).solid_fraction == Approx(0.4));
  CHECK(random({none, "packing.relative_density=0.25", "packing.void_ratio_max=2", "packing.void_ratio_min=1.2"})
            .solid_fraction == Approx(1 / 2.8));
  const auto radius = [&](const std::string& table) { return random({"packing.radius={" + table + "}"}).radius; };
  auto r = radius("distribution=\"uniform\", min=\"0.2 mm\", max=\"0.4 mm\"");
  CHECK((r.min == Approx(2e-4) && r.max == Approx(4e-4) && r.mean == Approx(3e-4)));
  r = radius("distribution=\"truncated-normal\", mean=3e-4, sd=1e-5, min=2e-4, max=5e-4");
  CHECK((r.mean == 3e-4 && r.sd == 1e-5 && r.min == 2e-4 && r.max == 5e-4));
  r = radius("distribution=\"log-normal\", median=3e-4, spread=0.2, min=2e-4, max=5e-4");
  CHECK((r.median == 3e-4 && r.spread == 0.2 && r.mean == Approx(3e-4 * std::exp(-2.5 * 0.04))));
  CHECK(radius("distribution=\"log-normal\", median=3e-4, spread=0.5, min=2e-4, max=5e-4").mean == 2e-4);
  r = radius("distribution=\"sieve\", passing=[[\"0.4 mm\", 0], [\"0.8 mm\", 1]]");
  // Mass even in log d: number ~ r^-4 in r, whose mean is (3/2)(r1^-2 - r2^-2) / (r1^-3 - r2^-3).
  const double a = 2e-4, b = 4e-4;
  CHECK((r.sieve.size() == 2 && r.min == Approx(a) && r.max == Approx(b)));
  CHECK(r.mean == Approx(1.5 * (1 / (a * a) - 1 / (b * b)) / (1 / (a * a * a) - 1 / (b * b * b))));
  const RveScene twice = read(sand, {"loading={kind=\"free\", duration=1, scale=2}"});
  CHECK((twice.scale == 2 && std::get<dem::RandomPacking>(twice.recipe.grains).radius.mean == 1e-3));
  CHECK((random({"packing.count=77", "packing.seed=9"}).count == 77 && read(sand, {"packing.seed=9"}).model.seed == 9));
  CHECK((read(sand, {"seed=8"}).model.seed == 8 && read(sand, {"seed=8", "packing.seed=9"}).model.seed == 9));
  CHECK((random({}).turned && !random({"packing.orientation=\"aligned\""}).turned));
  const auto hulls =
      *std::get<dem::RandomPacking>(read(sand, {"material.sand={density=1, contact=\"overlap\", youngs_modulus=1e9}",
                                                "packing.hulls={relax=3, aspect=[1, 0.5, 0.25]}"})
                                        .recipe.grains)
           .hulls;
  CHECK((hulls.rounds == 3 && hulls.aspect == Vec3(1, 0.5, 0.25) && !hulls.balls));
  // As many layers of a lattice as fit the box: hcp rows are sqrt(3) r apart, layers sqrt(8/3) r.
  const auto lattice = [](const std::string& kind, const std::string& more) {
    return read(sand, {"boundary.kind=\"walls\"",
                       "packing={kind=\"" + kind + "\", radius={distribution=\"constant\", mean=1}, " + more + "}"});
  };
  auto l = std::get<dem::Lattice>(lattice("simple-cubic", "box=[6, 8.1, 3.9]").recipe.grains);
  CHECK((!l.hexagonal && l.radius == 1 && l.layers == std::array{3, 4, 1}));
  const double rows = 2 + 1 / std::sqrt(3.0) + 3 * std::sqrt(3.0), high = 2 + 4 * std::sqrt(8.0 / 3);
  l = std::get<dem::Lattice>(
      lattice("hcp", fmt::format("box=[9.0, {:.9f}, {:.9f}]", rows + 1e-6, high + 1e-6)).recipe.grains);
  CHECK((l.hexagonal && l.layers == std::array{4, 4, 5}));
  l = std::get<dem::Lattice>(
      lattice("hcp", fmt::format("box=[8.99, {:.9f}, {:.9f}]", rows - 1e-6, high - 1e-6)).recipe.grains);
  CHECK(l.layers == std::array{3, 3, 4});
  CHECK(lattice("simple-cubic", "layers=[2, 3, 4]").recipe.box == Vec3(4, 6, 8));
}

TEST_CASE("bodies of a file are of the material of their group; a group that the file has not is refused") {
  const Scratch scratch;
  const std::string file = scratch.path + "/cubes.obj";
  std::string text;
  for (const int at : {0, 1}) {
    text += fmt::format("g {}\n", at == 0 ? "quartz" : "clay");
    for (int k = 0; k < 8; ++k) text += fmt::format("v {} {} {}\n", 3 * at + (k & 1), k >> 1 & 1, k >> 2);
    for (const auto& f : {std::array{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}})
      text += fmt::format("f {} {} {} {}\n", f[0] + 8 * at, f[1] + 8 * at, f[2] + 8 * at, f[3] + 8 * at);
  }
  std::ofstream(file) << text;
  const auto with = [&](const std::string& groups) {
    const std::string scene = fmt::format(
        "material.a = {{ density = 2000, contact = \"overlap\", youngs_modulus = 1e9 }}\n"
        "material.b = {{ density = 1000, contact = \"overlap\", youngs_modulus = 4e9 }}\n"
        "loading = {{ kind = \"free\", duration = 1 }}\n"
        "[packing]\nkind = \"polyhedra\"\nmaterial = \"a\"\npath = \"{}\"\nunit = \"mm\"\n{}",
        file, groups);
    return std::get<dem::Bodies>(read(scene).recipe.grains);
  };
  const dem::Bodies plain = with("");
  CHECK(plain.materials == std::vector<std::uint8_t>{0, 0});
  CHECK((plain.middle.at(1) - Vec3(3.5e-3, 5e-4, 5e-4)).norm() < 1e-9);
  CHECK(with("[[packing.group]]\nname = \"clay\"\nmaterial = \"b\"\n").materials == std::vector<std::uint8_t>{0, 1});
  CHECK_THROWS_WITH(with("[[packing.group]]\nname = \"sand\"\nmaterial = \"b\"\n"),
                    Catch::Contains("\"sand\": nothing in the file is of that group"));
}

TEST_CASE("preparations, boxes, walls and single grains are those of the scene") {
  const auto prepared = [](const std::string& more) {
    return *read(sand, {"preparation={pressure=\"0.2 MPa\", " + more + "}"}).recipe.preparation;
  };
  auto p = prepared("friction=0.1, void_ratio=0.7, inertial_number=0.002, window=7, max_hold=99");
  CHECK((p.pressure == 2e5 && p.friction == 0.1 && *p.void_ratio == 0.7 && p.quasi_static.inertial_number == 0.002));
  CHECK((p.quasi_static.window == 7 && p.quasi_static.max_hold == 99));
  p = prepared("relative_density=0.25, void_ratio_max=0.9, void_ratio_min=0.5");
  CHECK((*p.void_ratio == Approx(0.8) && p.friction == 0.5));
  CHECK(read(sand, {"preparation.pressure=2e5"}).test.loading.prepared == -2e5);
  const RveScene ends =
      read(sand, {"preparation.pressure=2e5", "loading={kind=\"oedometric-stress\", strain_rate=1, final_stress=2e5}"});
  CHECK(ends.notes == std::vector<std::string>{"loading.final_stress = 2e+05 Pa is no more than preparation.pressure = "
                                               "2e+05 Pa: the test ends as it begins"});
  CHECK(read(sand, {"packing.box=[1e-2, 1e-2, 9.9]"}).notes.size() == 0);
  CHECK(read(sand, {"packing={kind=\"random\", box=[1e-2, 1.2e-2, 10], radius={distribution=\"constant\", mean=2e-3}, "
                    "solid_fraction=0.3}"})
            .notes.at(0)
            .starts_with("the sides of the box, 0.01 m, 0.012 m, 10 m, differ by a factor of 1e+03"));
  const std::string ball =
      "material.a = { density = 2000, youngs_modulus = 1e9 }\nmaterial.b = { density = 1000, youngs_modulus = 4e9 }\n"
      "loading = { kind = \"free\", duration = 1 }\n";
  const RveScene s = read(ball +
                          "[[grain]]\nshape=\"polyellipsoid\"\nsemi_axes=[1, 2, 3, 4, 5, 6]\nposition=[7, 8, 9]\n"
                          "velocity=[1, 2, 3]\nspin=[4, 5, 6]\nmaterial=\"b\"\norientation=[0, 0.6, 0, 0.8]\n[[wall]]\n"
                          "point=[1, 2, 3]\nnormal=[0, 0, 2]\nvelocity=[0, 0, 5]\nfriction=0.4\n");
  const dem::GrainSpec& g = s.recipe.listed()->at(0).spec;
  CHECK((g.shape.plus == Vec3(1, 3, 5) && g.shape.minus == Vec3(2, 4, 6) && g.position == Vec3(7, 8, 9)));
  CHECK((g.velocity == Vec3(1, 2, 3) && g.spin == Vec3(4, 5, 6) && g.material == 1));
  CHECK((g.orientation.w() == 0 && g.orientation.x() == 0.6 && g.orientation.y() == 0 && g.orientation.z() == 0.8));
  const dem::Wall& flat = s.recipe.walls.at(0).wall;
  const dem::Material& rigid = s.model.materials[flat.material];
  CHECK((flat.point == Vec3(1, 2, 3) && flat.velocity == Vec3(0, 0, 5) && rigid.friction == 0.4));
  CHECK((std::get<dem::PlaneWall>(flat.shape).normal == Vec3(0, 0, 1) && std::isinf(rigid.youngs_modulus)));
  const RveScene drum = read(ball +
                             "[[grain]]\nradius=1\nposition=[0, 0, 0]\n[[wall]]\nshape=\"cylinder\"\naxis=\"y\"\n"
                             "radius=30\npoint=[0, 1, 0]\nvelocity=[0, 2, 0]\nmaterial=\"b\"\n");
  const dem::Wall& round = drum.recipe.walls.at(0).wall;
  const auto& shape = std::get<dem::CylinderWall>(round.shape);
  CHECK((shape.radius == 30 && shape.axis == Vec3(0, 1, 0) && round.material == 1));
  CHECK((round.velocity == Vec3(0, 2, 0) && drum.notes.empty()));
  CHECK((s.model.numerics.safety == 0.02 && read(sand).model.numerics.safety == 0.3));
  CHECK((s.model.motion.turn_spheres && !read(sand).model.motion.turn_spheres));
  // Twice the rod's wave of the fastest material; walls have none.
  CHECK(fastest_wave(s.model) == Approx(2 * std::sqrt(4e9 / 1000)));
  const dem::Model cells = read(rock).model;  // as stiff as their bonds
  CHECK(fastest_wave(cells) == Approx(2 * std::sqrt(cells.materials[0].bond->stiffness / 2500)));
  dem::Model soft = cells;  // however soft
  std::get<dem::Foundation::Of>(soft.materials[0].contact).modulus = 0.5;
  CHECK(fastest_wave(soft) == Approx(2 * std::sqrt(0.5 / 2500)));
  const std::string one = "[[grain]]\nradius=1\nposition=[0,0,0]\n";
  CHECK(read(ball + one).notes == std::vector<std::string>{"material.b: no grain and no wall is of it"});
  CHECK(read(ball + one + "[[wall]]\npoint=[0, 0, -2]\nnormal=[0, 0, 1]\nmaterial=\"b\"\n").notes.empty());
}
