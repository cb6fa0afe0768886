// SPDX-License-Identifier: LGPL-3.0-or-later
// What scenes of grus-bvp say is what is read of them, number by number, in SI units; and what they need not say.
#include <fmt/format.h>

#include "apps/bvp/scene/bvp_scene.hpp"
#include "tests/apps/refused.hpp"
#include "tests/apps/scene_texts.hpp"

using namespace grus;
using namespace grus::app;
using fem::Point;

namespace {

const std::string block = R"(
mesh.box = { size = ["1 m", 2, "3000 mm"], cells = [2, 4, 3] }
solve.kind = "quasi-static"
boundary = [{ where = "z=min", displacement = [0, 0, 0] }, { where = "z=max", traction = [0, 0, -1e6] }]
region = [{ where = "z>0", material = "elastic", youngs_modulus = "1 GPa", poissons_ratio = 0.2 }]
)";

const std::string strip = R"(
mesh = { dimension = "plane-strain", box = { size = [1, 2], cells = [2, 4] } }
solve.kind = "quasi-static"
boundary = [{ where = "y=min", displacement = [0, 0] }]
region = [{ where = "y>0", material = "elastic", youngs_modulus = 1e9, poissons_ratio = 0.2, density = 2000 }]
)";

BvpScene read(const std::string& text, const std::vector<std::string>& sets = {}) {
  const app::test::Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << text;
  std::ofstream(scratch.path + "/cell.toml") << app::test::sand.substr(0, app::test::sand.find("[loading]"));
  return read_bvp_scene(file, sets);
}

}  // namespace

TEST_CASE("meshes have the sides, elements, kinematics and thickness that they are told") {
  BvpScene s = read(block, {"title=T"});
  const auto box = [&] { return std::get<fem::BoxMesh>(s.mesh); };
  CHECK((s.title == "T" && s.extent() == "1 x 2 x 3 m" && !s.flat() && s.bricks()));
  CHECK((box().size == Point{1, 2, 3} && box().cells == std::array<long, 3>{2, 4, 3} && box().hexahedron));
  CHECK((s.low == Point{0, 0, 0} && s.high == Point{1, 2, 3} && s.element == 1));
  CHECK((s.discretisation.kinematics == fem::Kinematics::solid && s.discretisation.thickness == 1));
  s = read(block, {"mesh.box.cell=tetrahedron"});
  CHECK((!box().hexahedron && !s.bricks()));
  s = read(strip);
  CHECK((s.flat() && s.extent() == "1 x 2 m" && s.high == Point{1, 2, 0} && s.element == 0.5));
  CHECK((s.discretisation.kinematics == fem::Kinematics::plane_strain && s.discretisation.thickness == 1));
  CHECK(read(strip, {"mesh.thickness=\"20 cm\""}).discretisation.thickness == 0.2);
  s = read(strip, {"mesh.box={size=[1, 2, 0.3], cells=[2, 4, 1], cell=\"triangle\"}"});
  CHECK((s.discretisation.thickness == 0.3 && !s.bricks() && s.high[2] == 0));
  s = read(strip, {"mesh.dimension=axisymmetric", "mesh.box={size=[1, 2, 0.3], cells=[2, 4, 1]}"});
  CHECK((s.discretisation.kinematics == fem::Kinematics::axisymmetric && s.discretisation.thickness == 1));
}

TEST_CASE("elements are of the kind, order and quadrature that they are told, or of their kind's own") {
  using Kind = fem::ElementKind;
  const auto element = [](const std::string& table) {
    const fem::Discretisation d = read(block, {"element={" + table + "}"}).discretisation;
    CHECK((d.finite_strain && !d.exact_sums));
    return std::tuple(d.element, d.order, d.quadrature_degree);
  };
  CHECK(element("") == std::tuple(Kind::standard, 1, 2));
  CHECK(element("order=2, quadrature_degree=4") == std::tuple(Kind::standard, 2, 4));
  CHECK(element("kind=\"fbar\"") == std::tuple(Kind::fbar, 1, 2));
  CHECK(element("kind=\"serendipity\", quadrature_degree=3") == std::tuple(Kind::serendipity, 2, 3));
  const auto locks = [](const std::vector<std::string>& sets) {
    const auto notes = read(block, sets).notes;
    return notes == std::vector<std::string>{
                        "region[0].poissons_ratio = 0.46 with element.order = 1: such elements "
                        "lock, far too stiff in bending and shear; element.kind = \"fbar\" or "
                        "element.order = 2 helps"};
  };
  CHECK(locks({"region.0.poissons_ratio=0.46"}));
  CHECK_FALSE(locks({"region.0.poissons_ratio=0.46", "element.order=2"}));
  CHECK_FALSE(locks({"region.0.poissons_ratio=0.46", "element.kind=fbar"}));
  CHECK_FALSE(locks({"region.0.poissons_ratio=0.45"}));
}

TEST_CASE("solvers have the numbers that they are told, or their own") {
  BvpScene s = read(block);
  const fem::StaticsOptions own;
  CHECK((!s.is_explicit() && !s.dynamic() && !s.spread && s.patience == 600 && s.end_time() == 1));
  CHECK((s.solve.increments == 10 && s.solve.tolerance == own.tolerance && s.solve.tolerance == 1e-6));
  CHECK((s.solve.displacement_tolerance == 1e-3 && s.solve.max_iterations == 25 && s.solve.acceleration == 5));
  CHECK((s.solve.max_cutbacks == 6 && s.solve.linear == fem::LinearMethod::direct));
  CHECK((s.frames == 0 && !s.costs && s.checkpoint_interval == 300 && s.notes.empty() && s.residual_floor() == 0));
  s = read(block, {"solve={kind=\"quasi-static\", increments=7, tolerance=1e-4, displacement_tolerance=2e-3, "
                   "max_cutbacks=3, acceleration=2, max_iterations=11, linear_solver=\"iterative\"}",
                   "output={frames=4, costs=true, checkpoint_interval=\"2 min\"}"});
  CHECK((s.solve.increments == 7 && s.solve.tolerance == 1e-4 && s.solve.displacement_tolerance == 2e-3));
  CHECK((s.solve.max_cutbacks == 3 && s.solve.acceleration == 2 && s.solve.max_iterations == 11));
  CHECK((s.solve.linear == fem::LinearMethod::iterative && s.frames == 4 && s.costs && s.checkpoint_interval == 120));
  s = read(block, {"solve={kind=\"quasi-static\", spread=true, patience=\"5 min\", linear_solver=\"direct\"}"});
  CHECK((s.spread && s.patience == 300 && s.discretisation.exact_sums && s.solve.linear == fem::LinearMethod::direct));
  REQUIRE(s.notes.size() == 1);
  CHECK(s.notes[0].starts_with("solve.spread with \"quasi-static\": linear systems are solved on all ranks"));

  const std::string dense = "region.0.density=2000";
  s = read(block, {"solve={kind=\"explicit-dynamic\", duration=\"4 ms\"}", dense});
  REQUIRE(s.dynamics);
  fem::DynamicsOptions d = *s.dynamics;
  CHECK((s.is_explicit() && s.dynamic() && !s.explicit_statics && s.end_time() == 4e-3 && d.duration == 4e-3));
  CHECK((d.safety == 0.8 && d.time_step == 0 && d.linear_viscosity == 0 && d.quadratic_viscosity == 0));
  CHECK((d.estimate_every == 50 && d.max_energy_error == 0.1 && d.output_interval == Approx(2e-5)));
  CHECK(s.boundaries[1].history.points == std::vector<std::array<double, 2>>{{0, 0}, {4e-3, 1}});
  s = read(block,
           {"solve={kind=\"explicit-dynamic\", duration=1, safety=0.5, time_step=\"1 us\", linear_viscosity=0.1, "
            "quadratic_viscosity=1.2, estimate_every=9, max_energy_error=0.2, spread=true}",
            "output.history_interval=\"0.1 s\"", dense});
  d = *s.dynamics;
  CHECK((d.safety == 0.5 && d.time_step == 1e-6 && d.linear_viscosity == 0.1 && d.quadratic_viscosity == 1.2));
  CHECK((d.estimate_every == 9 && d.max_energy_error == 0.2 && d.output_interval == 0.1));
  CHECK((s.spread && s.discretisation.exact_sums && s.notes.empty()));

  const std::string slowly = "solve={kind=\"explicit-quasi-static\"";
  s = read(block, {slowly + "}", dense});
  REQUIRE(s.explicit_statics);
  fem::ExplicitStaticsOptions e = *s.explicit_statics;
  CHECK((s.is_explicit() && !s.dynamic() && s.end_time() == 1 && e.balance == 0.02 && e.kinetic == 0.01));
  CHECK((e.inertial_number == 0 && e.damping == 0.8 && e.safety == 0.9 && e.crossings == 100));
  CHECK((e.max_energy_error == 0.1 && e.output_interval == 0.005 && e.estimate_every == 20));
  s = read(block, {slowly + ", balance=0.03, kinetic=0.02, inertial_number=1e-3, damping=0.7, safety=0.6, "
                            "crossings=20, max_energy_error=0.3}",
                   "output.history_interval=0.25", dense});
  e = *s.explicit_statics;
  CHECK((e.balance == 0.03 && e.kinetic == 0.02 && e.inertial_number == 1e-3 && e.damping == 0.7));
  CHECK((e.safety == 0.6 && e.crossings == 20 && e.max_energy_error == 0.3 && e.output_interval == 0.25));
}

TEST_CASE("more frames than rows are told, of each solver's rows") {
  const std::string dense = "region.0.density=2000";
  const auto told = [&](const std::string& solve, const std::string& output) {
    const auto notes = read(block, {"solve={" + solve + "}", "output={" + output + "}", dense}).notes;
    return notes.empty() ? "" : notes.at(0);
  };
  const std::string still = "kind=\"quasi-static\", increments=7", slow = "kind=\"explicit-quasi-static\"";
  const std::string fast = "kind=\"explicit-dynamic\", duration=2";
  CHECK(told(still, "frames=7").empty());
  CHECK(told(still, "frames=8") ==
        "output.frames = 8, but one is written with a row of history.csv at most, of which "
        "there are 7 where no increment is cut");
  CHECK(told(slow, "frames=200").empty());
  CHECK(told(slow, "frames=201").ends_with("of which there are 200"));
  CHECK(told(slow, "frames=4, history_interval=0.3").empty());
  CHECK(told(slow, "frames=5, history_interval=0.3").ends_with("of which there are 4"));
  CHECK(told(fast, "frames=200").empty());
  CHECK(told(fast, "frames=201").ends_with("of which there are 200"));
  CHECK(told(fast, "frames=4, history_interval=0.7").ends_with("of which there are 3"));
}

TEST_CASE("boundaries move, press and pull as they are told, each where it is told") {
  const auto boundary = [](const std::string& table, const std::string& text = block) {
    return read(text, {"boundary=[{where=\"x=min\", name=\"first\", displacement=[0, 0, 0]}, {" + table + "}]"})
        .boundaries.at(1);
  };
  fem::BoundaryCondition b = boundary("where=\"z=max and x<0.5\", displacement=[\"free\", \"2 mm\", -3]");
  CHECK((b.name == "zmaxandx05" && b.tags.empty() && !b.traction && !b.pressure && !b.at));
  CHECK((!b.displacement[0] && b.displacement[1] == 2e-3 && b.displacement[2] == -3));
  CHECK((b.where({0.5, 1, 3}) && b.where({0, 2, 3}) && !b.where({0.6, 1, 3}) && !b.where({0.5, 1, 2.9})));
  CHECK(b.history.points == std::vector<std::array<double, 2>>{{0, 0}, {1, 1}});
  b = boundary("where=\"z=max\", name=\"top\", traction=[1, 2, \"3 kPa\"], history=\"constant\"");
  CHECK((b.name == "top" && *b.traction == Point{1, 2, 3000} && !b.displacement[0] && !b.pressure));
  CHECK(b.history.points == std::vector<std::array<double, 2>>{{0, 1}});
  b = boundary("where=\"z=max\", pressure=\"-4 kPa\", history=\"ramp\"");
  CHECK((*b.pressure == -4000 && !b.traction));
  CHECK(b.history.points == std::vector<std::array<double, 2>>{{0, 0}, {1, 1}});
  b = boundary("where=\"z=max\", pressure=1, history=[[0, 0.5], [0.3, 1], [1, -2]]");
  CHECK(b.history.points == std::vector<std::array<double, 2>>{{0, 0.5}, {0.3, 1}, {1, -2}});
  b = boundary("where=\"y=max\", displacement=[1, 2], traction=[3, 4]", strip);
  CHECK((b.displacement[0] == 1 && b.displacement[1] == 2 && !b.displacement[2] && *b.traction == Point{3, 4, 0}));
  CHECK(*boundary("where=\"y=max\", traction=[3, 4, 5]", strip).traction == Point{3, 4, 5});
}

TEST_CASE("regions are the solids that they are told") {
  const auto region = [](const std::string& table) { return read(block, {"region=[{" + table + "}]"}).regions.at(0); };
  Region r = region("where=\"z>1\", material=\"elastic\", youngs_modulus=\"2 GPa\", poissons_ratio=0.3");
  CHECK((r.youngs_modulus == 2e9 && r.poissons_ratio == 0.3 && r.density == 0 && !r.j2 && !r.initial_stress));
  CHECK((r.where({0, 0, 1.1}) && !r.where({0, 0, 0.9}) && r.tags.empty() && r.yield_stress == 0));
  r = region(
      "where=\"z>1\", material=\"j2\", youngs_modulus=2e9, poissons_ratio=0.3, yield_stress=\"3 MPa\", "
      "hardening=\"4 MPa\", density=\"2 g/cm^3\", initial_stress=[1, 2, 3, 4, 5, \"6 kPa\"]");
  CHECK((r.j2 && r.yield_stress == 3e6 && r.hardening == 4e6 && r.density == Approx(2000)));
  CHECK(*r.initial_stress == std::array<double, 6>{1, 2, 3, 4, 5, 6000});
  CHECK(region("where=\"z>1\", material=\"j2\", youngs_modulus=2e9, poissons_ratio=0.3, yield_stress=1").hardening ==
        0);
}

TEST_CASE("ground, gravity, probes and bars are as they are told") {
  const std::string weight = "gravity=[0, 0, \"-10 m/s^2\"]", dense = "region.0.density=2000";
  BvpScene s = read(block, {weight, dense, "initial_stress.k0=0.5"});
  CHECK((s.gravity == Point{0, 0, -10} && s.weighs() && !read(block).weighs()));
  CHECK((s.ground->k0 == 0.5 && s.ground->axis == 2 && s.ground->surface == 3 && s.ground->surcharge == 0));
  CHECK(s.ground->tolerance == 0.01);
  s = read(block, {"gravity=[0, -9, 0]", dense,
                   "initial_stress={k0=0.4, axis=\"y\", surface=\"1.5 m\", surcharge=\"2 kPa\", tolerance=0.1}"});
  CHECK((s.ground->axis == 1 && s.ground->surface == 1.5 && s.ground->surcharge == 2000 && s.ground->k0 == 0.4));
  CHECK((s.ground->tolerance == 0.1 && s.gravity[1] == -9));
  s = read(strip, {"gravity=[0, -9]", "initial_stress.k0=0.4"});
  CHECK((s.ground->axis == 1 && s.ground->surface == 2 && s.gravity == Point{0, -9, 0}));
  CHECK_NOTHROW(read(block, {"initial_stress={k0=0.4, surcharge=1}"}));  // stands without gravity

  s = read(strip, {"probe=[{name=\"a\", at=[0.5, \"30 cm\"]}, {name=\"b\", at=[0, 1, 0], frames=true}, "
                   "{name=\"c\", at=[1, 2], grading=true}, {name=\"d\", where=\"y<0.5\"}]"});
  REQUIRE(s.probes.size() == 4);
  CHECK((s.probes[0].name == "a" && s.probes[0].at == Point{0.5, 0.3, 0} && !s.probes[0].where));
  CHECK((!s.probes[0].frames && !s.probes[0].grading && s.probes[1].frames && !s.probes[1].grading));
  CHECK((s.probes[2].grading && !s.probes[2].frames && s.probes[2].at == Point{1, 2, 0}));
  CHECK((s.probes[3].where({0, 0.4, 0}) && !s.probes[3].where({0, 0.6, 0})));
  const std::string bar =
      "{incident_gauge=\"i\", transmitted_gauge=\"t\", bar_modulus=\"1 GPa\", bar_density=2000, bar_area=\"3 cm^2\", "
      "specimen_length=\"4 mm\", specimen_area=5, incident_distance=6, transmitted_distance=7";
  const std::vector<std::string> wave{"solve={kind=\"explicit-dynamic\", duration=1}", dense,
                                      "probe=[{name=\"i\", at=[0, 0, 0]}, {name=\"t\", at=[0, 0, 1]}]"};
  const auto with = [&](const std::string& end) {
    auto sets = wave;
    sets.push_back("hopkinson=" + bar + end);
    return *read(block, sets).hopkinson;
  };
  Hopkinson h = with("}");
  CHECK((h.incident == "i" && h.transmitted == "t" && h.bar_modulus == 1e9 && h.bar_density == 2000));
  CHECK((h.bar_area == Approx(3e-4) && h.specimen_length == 4e-3 && h.specimen_area == 5 && h.axis == 1));
  CHECK((h.incident_distance == 6 && h.transmitted_distance == 7));
  CHECK((with(", axis=\"z\"}").axis == 2 && with(", axis=\"x\"}").axis == 0));
}

TEST_CASE("points have grains where there are RVEs, which answer as they are told, at the pace of the solver") {
  const auto rves = [](const std::string& solve, const std::string& more, const std::vector<std::string>& sets = {}) {
    std::vector<std::string> all{"region=", "solve={kind=\"" + solve + "\"}", "rve={scene=\"cell.toml\"" + more + "}"};
    all.insert(all.end(), sets.begin(), sets.end());
    return read(block, all);
  };
  BvpScene s = rves("quasi-static", "");
  CHECK((s.has_rve && s.unit_cells.size() == 1 && s.samples.size() == 1 && !s.samples[0] && s.variants == 1));
  CHECK(!read(block).has_rve);
  CHECK((s.rve.pace == dem::Pace::relaxed && s.rve.exact_sharing && s.rve.share == 0 && s.rve.error == 0));
  const dem::ResponseOptions& r = s.rve.response;
  CHECK((r.tangent == dem::TangentKind::automatic && r.elastic == -1 && r.on_failure == dem::OnFailure::stop));
  CHECK((!s.damping && r.quasi_static.pressure_floor == 0));
  CHECK(s.residual_floor() == std::max(r.quasi_static.unbalanced_force, r.quasi_static.stress_change));
  s = rves("quasi-static",
           ", tangent=\"perturbation\", perturbation=2e-4, perturbation_central=true, unbalanced_force=3e-3, "
           "stress_change=2e-3, inertial_number=4e-3, strain_per_step=5e-6, window=7, max_hold=8, "
           "pressure_floor=\"9 kPa\", adaptivity={share=0.01, error=0.02, elastic=0.03}, damping=0.4, variants=3");
  CHECK((r.tangent == dem::TangentKind::perturbation && r.perturbation == 2e-4 && r.central));
  const dem::QuasiStatic& q = r.quasi_static;
  CHECK((q.unbalanced_force == 3e-3 && q.stress_change == 2e-3 && q.inertial_number == 4e-3));
  CHECK((q.strain_per_step == 5e-6 && q.window == 7 && q.max_hold == 8 && q.pressure_floor == 9000));
  CHECK((s.rve.share == 0.01 && s.rve.error == 0.02 && r.elastic == 0.03 && *s.damping == 0.4));
  CHECK((s.variants == 3 && s.unit_cells.size() == 3 && s.samples.size() == 3 && s.residual_floor() == 3e-3));
  for (const auto& [name, kind] :
       std::map<std::string, dem::TangentKind>{{"automatic", dem::TangentKind::automatic},
                                               {"contact-stiffness", dem::TangentKind::contact_stiffness},
                                               {"network", dem::TangentKind::network},
                                               {"elastic", dem::TangentKind::elastic},
                                               {"quasi-newton", dem::TangentKind::quasi_newton}})
    CHECK(rves("quasi-static", ", tangent=\"" + name + "\"").rve.response.tangent == kind);
  CHECK_FALSE(rves("quasi-static", ", exact_sharing=false").rve.exact_sharing);
  s = rves("explicit-quasi-static", ", on_failure=\"elastic\", set=[\"preparation={pressure=1e5}\"]",
           {"regularisation={length=0.1, memory=0.2}", "boundary.1.history=\"constant\""});
  CHECK((s.rve.pace == dem::Pace::steady && r.on_failure == dem::OnFailure::elastic));
  CHECK((s.regularisation->length == 0.1 && s.regularisation->memory == 0.2 && q.pressure_floor == 5e4));
  CHECK(s.residual_floor() == 0);
  CHECK(rves("explicit-quasi-static", "", {"regularisation.length=0.1"}).regularisation->memory ==
        fem::Regularisation().memory);
  s = rves("explicit-dynamic", "", {"solve.duration=1"});
  CHECK((s.rve.pace == dem::Pace::real_time && s.has_rve));
  // A residual below what RVEs leave is told of.
  const std::string below = "the residual is asked to fall to 0.001, what the RVEs' own equilibrium leaves";
  s = rves("quasi-static", "", {"solve.tolerance=1e-5"});
  CHECK(std::count_if(s.notes.begin(), s.notes.end(), [&](const auto& n) { return n.starts_with(below); }) == 1);
  for (const std::string& note : rves("quasi-static", "", {"solve.tolerance=1e-2"}).notes)
    CHECK(!note.starts_with("the residual is asked"));
}
