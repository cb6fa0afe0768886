// SPDX-License-Identifier: LGPL-3.0-or-later
// What scenes say of materials, supports and Voronoi cells is what is read of them; options of unit cells; what is told
// of preparations and of keys.
#include <nlohmann/json.hpp>

#include "apps/scene/keys.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/speeds.hpp"
#include "apps/scene/unit_cells.hpp"
#include "tests/apps/scene_texts.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::read, grus::app::test::rock, grus::app::test::sand;
using grus::app::test::Scratch;
using grus::dem::Vec3, grus::dem::pi;

namespace {

dem::FractureModel fracture_of(const std::string& table, const std::string& contact = "") {
  return *read(sand, {"material.sand={density=2500, " + contact + "youngs_modulus=9e9, poissons_ratio=0.2, fracture={" +
                          table + "}}",
                      contact.empty() ? "title=\"t\"" : "packing.hulls={relax=0}"})
              .model.materials[0]
              .fracture;
}

}  // namespace

TEST_CASE("contacts, bonds and steps have the numbers that their tables tell, and those that follow from them") {
  const auto material = [](const std::string& table) {
    return read(sand, {"material.sand={density=2500, " + table + "}"}).model;
  };
  auto m = material(
      "youngs_modulus=\"7 GPa\", poissons_ratio=0.3, friction=0.2, rolling_friction=0.1, restitution=0.5, damping=0.3");
  const dem::Material& a = m.materials[0];
  CHECK((a.youngs_modulus == 7e9 && a.poissons_ratio == 0.3 && a.friction == 0.2 && a.rolling_friction == 0.1));
  CHECK((a.restitution == 0.5 && a.damping == 0.3 && a.turns && a.density == 2500 && a.name == "sand"));
  m = material("contact=\"linear\", normal_stiffness=\"3 kN/mm\"");
  CHECK((std::get<dem::LinearSpring::Of>(m.materials[0].contact).stiffness == 3e6 &&
         m.materials[0].youngs_modulus == 60e9));
  CHECK(std::get<dem::LinearSpring::Of>(m.materials[0].contact).shear_ratio == Approx(2.0 / 7));
  m = material("contact=\"linear-modulus\", contact_modulus=2e8, shear_ratio=0.6, youngs_modulus=5e9, rotation=false");
  CHECK((std::get<dem::LinearSpring::Of>(m.materials[0].contact).modulus == 2e8 && !m.materials[0].turns));
  CHECK((std::get<dem::LinearSpring::Of>(m.materials[0].contact).shear_ratio == 0.6 &&
         fastest_wave(m) == Approx(2 * std::sqrt(2e8 / 2500))));
  const auto bond = [](const std::string& table) {
    return *read(rock, {"material.rock={density=2500, contact=\"overlap\", friction=0.3, bond={" + table + "}}"})
                .model.materials[0]
                .bond;
  };
  auto b = bond(
      "normal_stiffness=\"2 GPa/m\", tension=2e6, cohesion=3e6, friction_angle=\"45 deg\", fracture_energy=5, "
      "between=1e6, damping=0.2, weibull=4");
  CHECK((b.stiffness == 2e9 && b.stiffness_given && b.ratio == 0.4 && b.tension == 2e6 && b.cohesion == 3e6 &&
         b.friction == 0.3));
  CHECK((b.tan_phi == Approx(1) && b.energy_1 == 5 && b.energy_2 == 5 && b.between == 1e6 && b.damping == 0.2 &&
         b.weibull == 4));
  b = bond("normal_stiffness=2e9, shear_ratio=0.7, criterion=\"strain-sum\", strain=0.01, rotation=\"90 deg\"");
  CHECK((b.criterion == dem::FaceCriterion::strain_sum && b.tension == 0.01 && b.cohesion == Approx(pi / 2) &&
         b.ratio == 0.7));
  CHECK(std::isinf(bond("normal_stiffness=2e9, criterion=\"strain-sum\", strain=0.01").cohesion));
  b = bond("normal_stiffness=2e9, criterion=\"parallel\", tension=2e6, shear=4e6, between=1e6, friction_angle=0");
  CHECK((b.criterion == dem::FaceCriterion::parallel && b.tension == 2e6 && b.cohesion == 4e6 && b.between == 1e6 &&
         b.tan_phi == 0));
  b = bond("modulus=1e10, length=\"2 mm\", tension=2e6, cohesion=3e6, fracture_energy=5, shear_energy=50");
  CHECK((b.length == 2e-3 && b.energy_2 == 50 && !b.stiffness_given && b.stiffness > 1e10 && b.ratio > 0));
  const dem::Numerics n = read(sand, {"numerics={safety=0.4, time_step=\"1 us\", skin=0.3, estimate_every=9, "
                                      "fracture_every=8, max_energy_error=0.2, max_overlap=0.15}"})
                              .model.numerics;
  CHECK((n.safety == 0.4 && n.time_step == 1e-6 && n.skin == 0.3 && n.estimate_every == 9));
  CHECK((n.fracture_every == 8 && n.max_energy_error == 0.2 && *n.max_overlap == 0.15 && !n.scales_inertia()));
  CHECK(read(sand, {"numerics={max_time_step=2e-6}"}).model.numerics.max_time_step == 2e-6);
  const dem::Numerics i = read(sand, {"numerics.inertia={scaled_below=\"1 mm\", step=1e-5}",
                                      "loading={kind=\"uniaxial-strain\", strain_rate=1, final_strain=0.1}"})
                              .model.numerics;
  CHECK((i.scaled_below == 1e-3 && i.inertia_step == 1e-5));
}

TEST_CASE("grains break by the criteria, splitters, limits and scatter of their table") {
  const std::string brown = "model=\"polyellipsoid-split\", hoek_brown={compressive_strength=\"80 MPa\", m=15}, ";
  auto f = fracture_of(
      brown +
      "turn_to_plane=true, slight_rotation=0.1, rounding=0.05, lost_mass=\"density\", break_plane=\"average-stress\", "
      "cohesive_springs={per_plane=5, toughness=1e6, max_opening=0.2, stiffness_ratio=0.3}, "
      "shape_transition={ratio=0.5, time=2e-5}, "
      "fines={dimension=2.5, largest=0.2, smallest=1e-6}, smallest_radius=1e-4, max_generations=3, rest=11");
  CHECK((std::get<dem::HoekBrown>(f.criteria.at(0)).compressive_strength == 8e7 &&
         std::get<dem::HoekBrown>(f.criteria[0]).m == 15));
  const auto& halves = std::get<dem::Halves>(f.splitter);
  CHECK((halves.turn_spheres && halves.slight_rotation == 0.1 && halves.rounding == 0.05 && halves.keep_mass));
  CHECK((f.plane == dem::BreakPlane::average_stress && f.springs->per_plane == 5 && f.springs->toughness == 1e6));
  CHECK((f.springs->max_opening == 0.2 && f.springs->stiffness_ratio == 0.3 && f.transition->ratio == 0.5 &&
         f.transition->time == 2e-5));
  CHECK((f.fines.dimension == 2.5 && f.fines.largest == 0.2 && f.fines.smallest == 1e-6));
  CHECK((f.limit.smallest_radius == 1e-4 && f.limit.max_generations == 3 && f.limit.rest == 11));
  f = fracture_of(
      brown +
      "break_plane=\"critical-contacts\", weibull={modulus=4, reference_radius=1e-3, law=\"linear\", inherit=true}");
  const auto& w = std::get<dem::Weibull>(f.strength_law);
  CHECK((f.plane == dem::BreakPlane::critical_contacts && w.modulus == 4 && w.linear && w.inherits &&
         w.size_exponent == 0.75));
  CHECK((!std::get<dem::Halves>(f.splitter).keep_mass && f.limit.rest == 0 && f.limit.max_generations == 255 &&
         !f.springs));
  f = fracture_of(brown +
                  "scatter={distribution=\"normal\", variation=0.3, size_exponent=0.4, reference_diameter=2e-3}");
  const auto& sc = std::get<dem::Scatter>(f.strength_law);
  CHECK((sc.normal && sc.variation == 0.3 && sc.size_exponent == 0.4 && sc.reference_diameter == 2e-3));
  f = fracture_of(
      "model=\"apollonian-14\", contact_tension={strength=5e7, critical_contacts=4}, contact_strength={strength=\"9 "
      "MPa\", area=\"angle\", angle=\"30 deg\"}, lost_mass=\"swell\"");
  CHECK((std::get<dem::ContactTension>(f.criteria.at(0)).strength == 5e7 && f.limit.rest == 20));
  CHECK((std::get<dem::ContactStrength>(f.criteria.at(1)).strength == 9e6 &&
         *std::get<dem::ContactStrength>(f.criteria[1]).angle == Approx(pi / 6)));
  CHECK((std::get<dem::Balls>(f.splitter).keep_mass && std::get<dem::Balls>(f.splitter).swells));
  const std::string overlap = "contact=\"overlap\", ", cleaves = "model=\"cleavage\", flaw=\"50 um\", ";
  f = fracture_of(cleaves +
                      "toughness=[2e6, 1e6], planes=[[0, 0, 2], [3, 0, 4]], geometry=1.1, mode_ratio=0.9, "
                      "offsets=[-0.2, 0.3], hydrostatic_gate=-1e6, crystal={axis=[0, 2, 0], angles=[\"90 deg\", 0]}",
                  overlap);
  const auto& c = std::get<dem::Cleavage>(f.criteria.at(0));
  CHECK((c.toughness == 1e6 && std::abs(c.flaw / 5e-5 - 1) < 1e-12 && c.geometry == 1.1 && c.mode_ratio == 0.9 &&
         *c.gate == -1e6));
  CHECK((c.offsets == std::vector<double>{-0.2, 0.3} && c.planes.size() == 2));
  CHECK((c.planes[0].normal == Vec3(0, 0, 1) && c.planes[0].toughness == 2e6 &&
         (c.planes[1].normal - Vec3(0.6, 0, 0.8)).norm() < 1e-15 && c.planes[1].toughness == 1e6));
  CHECK((*f.crystal->axis == Vec3(0, 1, 0) && f.crystal->angles.size() == 2 && f.crystal->angles[0] == Approx(pi / 2)));
  // Irwin: K^2 (1 - nu^2) / E.
  CHECK(
      (std::get<dem::Cut>(f.splitter).cohesive && std::get<dem::Cut>(f.splitter).energy == Approx(1e12 * 0.96 / 9e9)));
  f = fracture_of(cleaves + "toughness=1e6, planes=[[1, 0, 0]], crystal=\"aligned\", fracture_energy=7", overlap);
  CHECK((*f.crystal->axis == Vec3(0, 0, 1) && f.crystal->angles == std::vector<double>{0} &&
         std::get<dem::Cut>(f.splitter).energy == 7));
  f = fracture_of(cleaves + "toughness=1e6, cohesive=false", overlap);
  CHECK((!f.crystal && !std::get<dem::Cut>(f.splitter).cohesive && std::get<dem::Cut>(f.splitter).energy == 0));
  CHECK_FALSE(fracture_of(cleaves + "toughness=1e6, planes=[[1, 0, 0]]", overlap).crystal->axis);
}

TEST_CASE("clamps, loads, platens and rollers are on the sides and of the sizes that are told") {
  RveScene s = read(rock, {"clamp=[{where=\"x=min\"}, {where=\"z=max\", velocity=[0, 0, 1], slides=true}]",
                           "load=[{where=\"y=max\", force=[1, 2, \"3 kN\"], ramp=\"2 ms\"}]"});
  const auto& clamps = s.recipe.supports.clamps;
  CHECK((clamps.at(0).outward == Vec3(-1, 0, 0) && clamps[0].velocity.isZero() && !clamps[0].slides));
  CHECK((clamps.at(1).outward == Vec3(0, 0, 1) && clamps[1].velocity == Vec3(0, 0, 1) && clamps[1].slides));
  const auto& load = s.recipe.supports.loads.at(0);
  CHECK((load.outward == Vec3(0, 1, 0) && load.force == Vec3(1, 2, 3000) && load.ramp == 2e-3));
  s = read(rock, {"loading={kind=\"platens\", axis=\"y\", speed=\"2 mm/s\", final_strain=0.1, friction=0.2}"});
  const auto& p = std::get<dem::Platens>(s.recipe.supports.press);
  CHECK((p.axis == 1 && s.test.axis == 1 && p.by_speed && p.pace == 2e-3 && s.test.final_strain == 0.1));
  CHECK((s.model.materials[p.material].friction == 0.2 && std::isinf(s.model.materials[p.material].youngs_modulus)));
  s = read(rock, {"loading={kind=\"platens\", strain_rate=3, final_strain=0.1}"});
  CHECK((!std::get<dem::Platens>(s.recipe.supports.press).by_speed &&
         std::get<dem::Platens>(s.recipe.supports.press).pace == 3));
  s = read(rock, {"loading={kind=\"rollers\", outer=\"18 mm\", inner=\"6 mm\", radius=1e-3, speed=0.5, "
                  "final_displacement=\"1 mm\"}"});
  const auto& r = std::get<dem::Rollers>(s.recipe.supports.press);
  CHECK((r.axis == 2 && r.span == 0 && std::abs(r.outer - 0.018) < 1e-15 && std::abs(r.inner - 0.006) < 1e-15 &&
         r.radius == 1e-3 && r.speed == 0.5));
  CHECK(s.test.duration == Approx(2e-3));
  const auto refused = [](const std::string& scene, const std::string& more) {
    try {
      read(scene,
           {"loading={kind=\"rollers\", outer=9e-3, radius=1e-3, speed=0.5, final_displacement=1e-3" + more + "}"});
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(refused(rock, "").empty());
  const std::string boxes_alone = "\"rollers\" bends a box of Voronoi cells";
  CHECK(refused(rock.substr(0, rock.find("packing")) + "loading={}\npacking = { kind = \"voronoi\", cylinder = { "
                                                       "diameter = 0.02, length = 0.02 }, cells = 9 }\n",
                "")
            .find(boxes_alone) != std::string::npos);
  CHECK(refused(sand.substr(0, sand.find("boundary")) + "[[grain]]\nradius=1\nposition=[0, 0, 0]\n[loading]\n", "")
            .find(boxes_alone) != std::string::npos);
  CHECK(refused(rock, ", span=\"z\"").find("span: is across axis") != std::string::npos);
  s = read(rock, {"boundary={kind=\"walls\", bonded=\"normal\"}"});
  CHECK(s.recipe.supports.glue->slides);
  CHECK_FALSE(read(rock, {"boundary={kind=\"walls\", bonded=\"full\"}"}).recipe.supports.glue->slides);
  CHECK_FALSE(read(rock, {"boundary={kind=\"walls\"}"}).recipe.supports.glue);
}

TEST_CASE("Voronoi cells fill the spaces that are told, which begin at the origin, with as many as fit") {
  const auto cells = [](const std::string& table) {
    return read(rock, {"packing={kind=\"voronoi\", " + table + "}"}).recipe;
  };
  const auto of = [](const dem::Recipe& r) { return std::get<dem::VoronoiPacking>(r.grains); };
  auto r = cells("cells=9, prism={corners=[[-1, -2, 0], [3, -2, 0], [3, 1, 0], [-1, 1, 0]], height=5}");
  CHECK((r.box == Vec3(4, 3, 5) && of(r).space->volume() == Approx(60) && of(r).count == 9 && !of(r).round &&
         of(r).rounds == 5));
  r = cells("cells=9, prism={corners=[[3, 1, 0], [-1, 1, 0], [-1, -2, 0]], height=2}, relax=2");
  CHECK((r.box == Vec3(4, 3, 2) && of(r).space->volume() == Approx(12) && of(r).rounds == 2));
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  const auto prism = of(r);
  for (const Vec3& x : prism.space->body.vertex) low = low.cwiseMin(x), high = high.cwiseMax(x);
  CHECK((low.norm() < 1e-12 && (high - r.box).norm() < 1e-12));
  r = cells("cells=9, cylinder={diameter=2, length=3}");
  CHECK((r.box == Vec3(2, 2, 3) && of(r).round && of(r).space->volume() == Approx(3 * pi).epsilon(0.05)));
  r = cells("cell_size=0.5, polyellipsoid={semi_axes=[1, 2, 1, 1, 2, 3]}");
  const double volume = pi / 6 * 3 * 2 * 5;  // an octant's share of 4 pi / 3 a b c, summed
  CHECK((r.box == Vec3(3, 2, 5) && of(r).count == static_cast<std::size_t>(std::round(volume / 0.125))));
  CHECK(of(cells("cell_size=0.5, box=[2, 3, 4]")).count == 192);
  CHECK(of(cells("cell_size=0.5, box=[2, 3, 0.5], extruded=true")).count == 24);
  CHECK((of(cells("cells=60, clusters=7, grains=\"clusters\", box=[2, 3, 4]")).clusters == 7));
  CHECK(of(cells("cells=60, box=[2, 3, 4]")).clusters == 0);
  const auto filled = std::get<dem::FilledGrains>(cells("cells=11, relax=3, parents={kind=\"simple-cubic\", layers=[2, "
                                                        "2, 2], radius={distribution=\"constant\", mean=1}}")
                                                      .grains);
  CHECK((filled.count == 11 && filled.rounds == 3 && std::get<dem::Lattice>(filled.parents).radius == 1));
  const auto prisms = read(rock, {"packing={kind=\"prisms\", box=[20, 20, 5], side=2, thickness=1, gap=0.1}"}).recipe;
  const auto& q = std::get<dem::Prisms>(prisms.grains);
  CHECK((q.side == 2 && q.thickness == 1 && q.gap == 0.1 && !q.round && prisms.box == Vec3(20, 20, 5)));
  const auto round =
      read(rock, {"packing={kind=\"prisms\", cylinder={diameter=20, length=5}, side=2, thickness=1}"}).recipe;
  CHECK((std::get<dem::Prisms>(round.grains).round && std::get<dem::Prisms>(round.grains).gap == 0 &&
         round.box == Vec3(20, 20, 5)));
}

TEST_CASE("unit cells: variants differ in their seeds alone, options of responses, and what kin is") {
  const Scratch scratch;
  const std::string file = scratch.path + "/cell.toml";
  std::ofstream(file) << sand.substr(0, sand.find("[loading]"));
  const auto cells = read_unit_cells(file, {"packing.seed=5"}, 3);
  REQUIRE(cells.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK((cells[k].model.seed == 5 + k && kin_of(cells[k]) == kin_of(cells[0])));
  CHECK(kin_of(read_unit_cell(file, {"packing.solid_fraction=0.31"})) != kin_of(cells[0]));
  CHECK((cells[0].model.numerics.safety == 0.7 &&
         read_rve_scene(file, {"loading={kind=\"free\", duration=1}"}).model.numerics.safety == 0.3));
  const auto options = [&](const std::string& text) { return options_of_text(text, "response", cells[0]); };
  auto o = options("");
  CHECK((o.exact_sharing && o.share == 0 && o.error == 0 && o.response.elastic < 0 &&
         o.response.tangent == dem::TangentKind::automatic));
  o = options(
      "tangent=\"perturbation\"\nperturbation=1e-3\nperturbation_central=true\nwindow=9\nadaptivity={share=0.01, "
      "error=0.2, elastic=0.1}");
  CHECK(
      (o.response.tangent == dem::TangentKind::perturbation && o.response.perturbation == 1e-3 && o.response.central));
  CHECK((o.share == 0.01 && o.error == 0.2 && o.response.elastic == 0.1 && o.response.quasi_static.window == 9));
  CHECK(options("tangent=\"network\"").response.tangent == dem::TangentKind::network);
  CHECK(options("tangent=\"contact-stiffness\"").response.tangent == dem::TangentKind::contact_stiffness);
  CHECK_THROWS_WITH(options("tangent=\"elastic\""), Catch::Contains("are kept by the solver"));
  CHECK_THROWS_WITH(options("tangent=\"quasi-newton\""), Catch::Contains("are kept by the solver"));
  CHECK_FALSE(options("exact_sharing=false").exact_sharing);
  const RveScene pressed = read_unit_cell(file, {"preparation.pressure=2e5"});
  CHECK(options_of_text("", "r", pressed).response.quasi_static.pressure_floor == 1e5);
  CHECK(options_of_text("pressure_floor=7", "r", pressed).response.quasi_static.pressure_floor == 7);
  CHECK(options("").response.quasi_static.pressure_floor == 0);
}

TEST_CASE(
    "what preparations have made is told from the least to the largest, and noted where a void ratio has changed") {
  using nlohmann::json;
  const auto one = [](double packed, double now, double pressure, double off) {
    return json{{"packed_void_ratio", packed},
                {"void_ratio", now},
                {"worst_stress_error", off},
                {"asked_stress_Pa", {pressure, 2 * pressure, 3 * pressure}}};
  };
  const std::vector<json> two{one(0.8, 0.75, 1e6, 0.02), json(), one(0.7, 0.69, 2e6, 0.03)};
  const json sum = sum_of_preparations(two);
  CHECK((sum["starts"] == 2 && sum["worst_stress_error"] == 0.03 && sum["void_ratio"] == json({0.69, 0.75})));
  CHECK((sum["packed_void_ratio"] == json({0.7, 0.8}) && sum["asked_pressure_Pa"][0] == Approx(2e6) &&
         sum["asked_pressure_Pa"][1] == Approx(4e6)));
  CHECK(sum_of_preparations({json()}).is_null());
  CHECK(note_of_preparations(two) ==
        "preparation: the packing has a void ratio of 0.700 to 0.800 (solid fraction 0.5882 to 0.5556); compressed to "
        "2 to 4 MPa the "
        "sample begins the test at 0.690 to 0.750 (0.5917 to 0.5714). A lower preparation.friction makes it denser, a "
        "higher one looser");
  CHECK(note_of_preparations({one(0.8, 0.7921, 1e6, 0)}).empty());  // by a hundredth
  CHECK(note_of_preparations({one(0.8, 0.8079, 1e6, 0)}).empty());
  CHECK_FALSE(note_of_preparations({one(0.8, 0.7919, 1e6, 0)}).empty());
  CHECK(note_of_preparations({one(9e-4, 0, 1e6, 0)}).empty());  // of a rock
  json found = one(0.8, 0.6001, 5e5, 0);
  found["asked_void_ratio"] = 0.6, found["friction"] = 0.12345, found["tries"] = 4;
  CHECK(note_of_preparations({found}) ==
        "preparation: a friction of 0.1235 leaves a void ratio of 0.6001 at 1 MPa, 0.6000 was asked for (4 tried)");
  json other = found;
  other["void_ratio"] = 0.5998, other["friction"] = 0.2, other["tries"] = 7;
  CHECK(note_of_preparations({found, other}) ==
        "preparation: a friction of 0.1235 to 0.2 leaves a void ratio of 0.5998 to 0.6001 at 1 MPa, 0.6000 was asked "
        "for (up to 7 tried)");
  const json both = sum_of_preparations({found, other});
  CHECK((both["friction"] == json({0.12345, 0.2}) && both["tries"] == 7 &&
         both["asked_void_ratio"] == json({0.6, 0.6}) && !sum.contains("friction")));
}

TEST_CASE(
    "keys are listed with their facts, by path or meaning, of their program; defaults are known by general paths") {
  const auto listed = [](const char* program, const char* part) { return keys_listing(program, part); };
  CHECK(listed("rve", "bond.friction_angle") ==
        "material.*.bond.friction_angle\n    of a bond in shear\n    number (angle), 0 deg <= x <= 88.2 deg; default "
        "0.0\n    "
        "friction_angle = \"30 deg\"\n");
  CHECK(listed("rve", "holds the cells") == "\n[[clamp]]\n    holds the cells on a side: [[clamp]]\n");
  CHECK(listed("bvp", "the macro mesh").starts_with("\n[mesh]\n    the macro mesh\n"));
  CHECK((listed("rve", "the macro mesh").empty() && listed("bvp", "holds the cells").empty()));
  CHECK(listed("bvp", "element.kind")
            .find("    standard|fbar|serendipity; default \"standard\"\n    kind = \"fbar\"\n") != std::string::npos);
  CHECK(listed("bvp", "element.order").find("    integer, 1 <= x <= 2; default 1; serendipity 2\n") !=
        std::string::npos);
  for (const char* shared : {"output.frames", "title"})
    CHECK((!listed("rve", shared).empty() && !listed("bvp", shared).empty()));
  CHECK((listed("rve", "gravity").find("loading.gravity") != std::string::npos &&
         listed("bvp", "gravity").find("loading.gravity") == std::string::npos));
  CHECK((is_default("material.sand.poissons_ratio", 0.25) && !is_default("material.sand.poissons_ratio", 0.3)));
  CHECK((is_default("material.\"a.b\".poissons_ratio", 0.25) &&
         is_default("material.\"a\\\".b\".bond.poissons_ratio", 0.2)));
  CHECK((is_default("grain[12].shape", "sphere") && is_default("packing.parents.seed", nlohmann::json()) == false));
  CHECK((is_default("packing.parents.orientation", "random") && !is_default("no.such.key", 1) &&
         !is_default("title", "x")));
  CHECK(is_default("material.sand.shear_ratio", 2.0 / 7) == false);  // it depends on others
  CHECK((as_in_toml("a_b-9") == "a_b-9" && as_in_toml("a.b") == "\"a.b\"" && as_in_toml("") == "\"\"" &&
         as_in_toml("\xC3\xA4") == "\"\xC3\xA4\""));
}
