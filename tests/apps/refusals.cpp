// SPDX-License-Identifier: LGPL-3.0-or-later
// What scenes of grus-rve are refused for, guard by guard. tests/scenes/refused holds scenes that the programs refuse.
#include "apps/scene/rve_scene.hpp"
#include "tests/apps/refused.hpp"

using namespace grus::app;
using grus::app::test::check_refused;

namespace {

const char* const sand = R"(
[material.sand]
density = 2650
youngs_modulus = "20 GPa"
friction = 0.5
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
[boundary]
kind = "periodic"
[loading]
kind = "uniaxial-strain"
strain_rate = 1
final_strain = 0.1
)";

const char* const staged = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
boundary.kind = "periodic"
stage = [{ kind = "compress", strain_rate = 1, until = { strain = 0.1 } }]
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
)";

const char* const rock = R"(
[material.rock]
density = 2600
contact = "overlap"
friction = 0.5
bond = { modulus = "10 GPa", tension = "1 MPa", cohesion = "3 MPa", fracture_energy = 5 }
[packing]
kind = "voronoi"
box = [0.01, 0.01, 0.01]
cells = 60
[loading]
kind = "platens"
strain_rate = 1
final_strain = 0.01
)";

const char* const cube = R"(
grain = [{ shape = "hull", box = [1, 1, 1], position = [0, 0, 0] }]
material.rock = { density = 2600, contact = "overlap", youngs_modulus = 1e9 }
loading = { kind = "free", duration = 1 }
)";

const char* const sphere = R"(
grain = [{ radius = 1, position = [0, 0, 1] }]
wall = [{ point = [0, 0, 0], normal = [0, 0, 1] }]
material.sand = { density = 2650, youngs_modulus = 1e9 }
loading = { kind = "free", duration = 1 }
)";

const char* const cleaving = R"(
boundary.kind = "walls"
loading = { kind = "uniaxial-strain", strain_rate = 1, final_strain = 0.1 }
[material.sand]
density = 2650
contact = "overlap"
youngs_modulus = "20 GPa"
fracture = { model = "cleavage", toughness = 1e6, flaw = "50 um" }
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.14
hulls = {}
)";

const char* const cracking = R"(
boundary.kind = "walls"
loading = { kind = "uniaxial-strain", strain_rate = 1, final_strain = 0.1 }
[material.sand]
density = 2650
contact = "overlap"
youngs_modulus = "20 GPa"
fracture = { model = "peridynamics", platen_strength = "20 MPa" }
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.14
hulls = { balls = 32 }
)";

void refuse(const std::vector<test::Refusal>& rows) { check_refused(rows, read_rve_scene); }

}  // namespace

TEST_CASE("what --set gave is found there, not in a line of the file") {
  refuse(
      {{sand, {"material.sand.friction=-1"}, "scene.toml: --set material.sand.friction: -1: must be at least 0"},
       {sand, {"packing.radius.mean=5 kPa"}, "scene.toml: --set packing.radius.mean: \"5 kPa\": "},
       {sand, {"packing.box=[0.01,0.01,nan]"}, "scene.toml: --set packing.box: must be finite"},
       {sand, {"packing.radius={distribution=\"odd\"}"}, "--set packing.radius: packing.radius.distribution: \"odd\""},
       {sand, {"numerics.time_step=1e-6", "numerics.max_time_step=1e-7"}, "max_time_step: bounds nothing beside"},
       {sand, {"packing.sed=1"}, "scene.toml: --set packing.sed: unknown key (did you mean 'seed'?)"},
       {sand,
        {"loading.duration=1"},
        "--set loading.duration: nothing in this scene makes use of it ('grus keys duration' says what it is "
        "for)"},
       {sand,
        {"material.sand.normal_stiffness=1e5"},
        "material.sand.normal_stiffness: nothing in this scene makes use of it ('grus keys normal_stiffness' says"},
       {sand, {"packing.solid_fraction="}, "scene.toml:6:1: packing: solid_fraction is missing"},
       {sphere, {"grain.0.radius=-1"}, "scene.toml: --set grain.0.radius: -1: must be above 0"},
       {sphere, {"grain.0.radius=", "grain.0.spin=[0,0,1]"}, " (with --set grain.0.spin): grain[0]: "}});
}

TEST_CASE("a test that asks for no more stress than its preparation is told to end as it begins") {
  const test::Scratch scratch;
  const std::string file = scratch.path + "/scene.toml";
  std::ofstream(file) << sand;
  for (const char* stress : {"0.5 MPa", "1 MPa", "1.1 MPa"}) {
    const RveScene scene =
        read_rve_scene(file, {"loading={kind=\"oedometric-stress\",strain_rate=1}",
                              std::string("loading.final_stress=") + stress, "preparation.pressure=1 MPa"});
    const bool told = std::any_of(scene.notes.begin(), scene.notes.end(), [](const std::string& note) {
      return note.find("is no more than preparation.pressure = 1e+06 Pa: the test ends as it begins") !=
             std::string::npos;
    });
    CHECK(told == (std::string(stress) != "1.1 MPa"));
  }
}

TEST_CASE("steps that solve their contacts are refused what they do not know, each by its name") {
  const std::string on = "numerics.engine=implicit", halves = "{model=\"polyellipsoid-split\",";
  const std::string breaks = "hoek_brown={compressive_strength=1e7,m=10}";
  refuse({{sand, {on, "material.sand.rotation=false"}, "knows no rotation = false: material sand"},
          {sand, {on, "material.sand.rolling_friction=0.1"}, "knows no rolling_friction: material sand"},
          {sand, {on, "material.sand.damping=0.1"}, "knows no damping"},
          {sand,
           {on, "material.sand.fracture=" + halves + breaks + ",cohesive_springs={toughness=1e6}}"},
           "knows no springs across fresh planes"},
          {sand,
           {on, "material.sand.fracture=" + halves + breaks + ",shape_transition={}}"},
           "knows no fragments that grow back"},
          {sand,
           {on, "material.sand.fracture={model=\"apollonian-14\"," + breaks + "}"},
           "knows no grains that break into balls"},
          {sand,
           {on, "material.sand.contact=jkr", "material.sand.work_of_adhesion=1e-3"},
           "knows no contacts that attract"},
          {sand, {on, "numerics.inertia={scaled_below=\"1 mm\"}"}, "needs no numerics.inertia"},
          {sphere, {on}, "is of real time, which numerics.engine = \"implicit\" damps away"},
          {rock,
           {on, "material.rock.bond=", "material.rock.youngs_modulus=1e9"},
           "is of real time, which numerics.engine = \"implicit\" damps away"},
          {rock,
           {on, "material.rock.bond=", "material.rock.youngs_modulus=1e9",
            "loading={kind=\"rollers\",outer=8e-3,radius=1e-3,speed=1,final_displacement=1e-4}"},
           "is of real time, which numerics.engine = \"implicit\" damps away"},
          {rock, {on}, "knows no bonds: material rock"},
          {cleaving, {on, "material.sand.fracture.cohesive=true"}, "knows no fracture with cohesive = true"}});
  check_refused({{sand, {on}, "is for tests of grus-rve"},
                 {sand, {"boundary.kind=walls"}, "the unit cell of a boundary-value problem must be periodic"}},
                read_unit_cell);
}

TEST_CASE("loading and output are refused what does not fit them") {
  refuse(
      {{sand, {"loading.strain_rate=0"}, "strain_rate: must not be 0"},
       {sand,
        {"loading={kind=\"constant-p\",strain_rate=0,pressure=1e6,final_strain=0.1}"},
        "strain_rate: must not be 0"},
       {sand, {"output.contacts=true"}, "contacts: is of frames, of which none are asked for"},
       {sand, {"output.wrapped=true"}, "wrapped: is of frames, of which none are asked for"},
       {sand, {"boundary.kind=walls", "output={wrapped=true,frames=2}"}, "wrapped: needs boundary.kind"},
       {sand, {"output.wall_forces=true"}, "is of a box or cylinder of walls"},
       {sand, {"output.bursts=1e-3"}, "bursts: the scene has no bonds between grains"},
       {sand, {"output.broken_bonds=true"}, "broken_bonds: the scene has no bonds between grains"},
       {sand, {"output.strain_gauges=true"}, "are on the middle of a sample between platens"},
       {sand,
        {"loading.gravity=[0,0,-9.81]", "numerics.inertia={scaled_below=\"1 mm\"}"},
        "cannot be with numerics.inertia"},
       {sphere, {"numerics.inertia={step=1e-5}"}, "\"free\" is of real time"},
       {sand,
        {"loading={kind=\"oedometric-stress\",strain_rate=1,final_stress=1e6,stress_rate=1}"},
        "stress_rate: is for control"},
       {sand, {"boundary.kind=open"}, "needs boundary.kind = \"walls\" or \"periodic\""},
       {sand,
        {"boundary.kind=cylinder", "loading={kind=\"triaxial\",strain_rate=1,confining_pressure=1e5,final_strain=0.1}"},
        "\"triaxial\" cannot be in a cylinder"},
       {sand, {"boundary.kind=cylinder", "loading.axis=x"}, "axis: of a cylinder is \"z\""},
       {sand, {"start=elsewhere", "preparation={pressure=1e6}"}, "cannot be with start"},
       {sand, {"boundary.kind=cylinder", "preparation={pressure=1e6}"}, "preparation: needs boundary.kind"},
       {sand,
        {"preparation={pressure=1e6,void_ratio=0.6,relative_density=0.5}"},
        "relative_density: cannot be beside void_ratio"},
       {rock, {"boundary.kind=walls"}, "\"platens\" makes its own two walls"},
       {rock, {"loading.strain_rate="}, "needs either speed or strain_rate"},
       {rock, {"loading.speed=1"}, "needs either speed or strain_rate"},
       {rock,
        {"wall=[{point=[0,0,0],normal=[0,0,1]}]",
         "loading={kind=\"rollers\",outer=8e-3,radius=1e-3,speed=1,final_displacement=1e-4}"},
        "\"rollers\" makes its own; leave out"},
       {rock,
        {"loading={kind=\"rollers\",axis=\"x\",outer=8e-3,radius=1e-3,speed=1,final_displacement=1e-4}"},
        "span: is across axis"}});
}

TEST_CASE("stages are refused what does not fit them") {
  const std::string shear = "stage=[{kind=\"shear\",plane=\"xz\",strain_rate=1,until={strain=0.1}";
  const std::string cyclic = "stage=[{kind=\"cyclic\",strain_rate=1,cycles=2,strain_amplitude=0.01";
  refuse({{staged,
           {"boundary.kind=cylinder", "stage.0.axis=x"},
           "of a cylinder or \"periodic-xy\", whose sides stay, the axis is \"z\""},
          {staged,
           {"boundary.kind=cylinder", "stage.0.lateral=held"},
           "of a cylinder or \"periodic-xy\", whose sides stay"},
          {staged,
           {"boundary.kind=cylinder", "stage.0.axis=all", "stage.0.until={stress=1e6}"},
           "of a cylinder or \"periodic-xy\", whose sides stay"},
          {staged, {shear + ",axis=\"x\"}]"}, "axis: is not with plane"},
          {staged, {shear + "}]", "boundary.kind=walls"}, "plane: needs boundary.kind"},
          {staged, {"stage.0.lateral=fixed", "stage.0.lateral_stress=1e5"}, "is for lateral = \"held\""},
          {staged,
           {"stage.0.lateral=volume", "stage.0.stress_rate=1e6", "stage.0.until={stress=1e6}"},
           "\"volume\" needs an axis that follows"},
          {staged,
           {"stage=[{kind=\"shear\",plane=\"xz\",strain_rate=0,until={strain=0.1}}]"},
           "strain_rate: must not be 0"},
          {staged,
           {"stage.0.axis=all", "stage.0.stress_rate=1e6", "stage.0.until={stress=1e6}"},
           "stress_rate: is of one axis that is compressed"},
          {staged, {cyclic + ",stress_amplitude=1e6}]"}, "is the second amplitude: give one"},
          {staged, {"stage=[{kind=\"cyclic\",strain_rate=1,cycles=2}]"}, "needs strain_amplitude"},
          {staged, {"stage.0.until={stress=1e6,deviator=1e5}"}, "deviator: cannot be beside stress"},
          {staged, {"stage.0.until={strain=0.5}", "stage.0.max_strain=0.4"}, "0.4 is less than until.strain, 0.5"},
          {staged,
           {"stage=[{kind=\"relax\",until={void_ratio=0.5}}]", "boundary.kind=open"},
           "a void ratio is of a box, a cylinder or a cell"},
          {staged, {"stage=[{kind=\"deposit\",until={time=1}}]", "boundary.kind=walls"}, "needs gravity"},
          {staged, {"stage=[{kind=\"deposit\",gravity=[0,0,-10],until={time=1}}]"}, "needs walls to fall on"},
          {staged, {"stage.0.axis=all"}, "needs a stress, which all axes are brought to"},
          {staged, {"stage.0.stress_rate=1e6"}, "needs a stress, which stress_rate goes to"},
          {staged, {"stage.0.until="}, "is missing: when does it end?"},
          {staged, {"stage=[{kind=\"hold\",until={unbalanced_force=1e-3}}]"}, "nothing else bounds how long it takes"},
          {staged, {"stage.0.rows=1000000"}, "more than a million rows in all"},
          {staged, {"loading={kind=\"free\",duration=1}"}, "loading: cannot be with [[stage]]"},
          {staged, {"output.history_interval=1e-3"}, "is not of a test with stages"},
          {staged,
           {"stage.0.gravity=[0,0,-10]", "numerics.inertia={scaled_below=\"1 mm\"}"},
           "cannot be with numerics.inertia"}});
}

TEST_CASE("samples are refused what cannot be made of them") {
  refuse(
      {{sand, {"packing.box="}, "packing: box is missing"},
       {sand, {"packing.box=[0.01,0,0.01]"}, "all three sides must be above 0"},
       {sand, {"packing.radius.mean=\"6 mm\""}, "a grain of the mean radius, 0.006 m, does not fit in"},
       {sand, {"packing.radius.mean=\"10 um\""}, "more than five million grains; check box and radius"},
       {sand, {"packing.kind=hcp", "packing.solid_fraction=", "packing.box="}, "packing: box or layers is missing"},
       {sand,
        {"packing.kind=hcp", "packing.solid_fraction=", "packing.layers=[300,300,300]"},
        "more than five million grains; check box, layers and radius"},
       {sand, {"packing.kind=hcp", "packing.solid_fraction=", "packing.layers=[3,3,2]"}, "even numbers of rows"},
       {sand,
        {"packing.kind=hcp", "packing.solid_fraction=", "packing.layers=[3,2.5,2]"},
        "three whole numbers from 1"},
       {sand, {"packing.void_ratio=1"}, "needs one of solid_fraction, void_ratio and relative_density"},
       {sand, {"packing.solid_fraction=0.75"}, "not even a lattice of spheres is denser than 0.74"},
       {sand, {"boundary.kind=cylinder", "packing.box=[0.01,0.02,0.01]"}, "expected [diameter, diameter, height]"},
       {sand, {"material.sand="}, "needs at least one [material.NAME] table"},
       {sand, {"numerics={inertia={step=1e-5},max_time_step=1e-6}"}, "1e-05 s: above numerics.max_time_step, 1e-06 s"},
       {sand, {"numerics={inertia={step=1e-5},time_step=1e-6}"}, "is for steps that follow from the grains"},
       {sand,
        {"boundary.kind=walls", "wall=[{point=[0,0,0],normal=[0,0,1]}]"},
        "\"walls\" makes its own walls; use \"open\" with [[wall]]"},
       {sand, {"boundary.kind=cylinder", "wall=[{point=[0,0,0],normal=[0,0,1]}]"}, "\"cylinder\" makes its own walls"},
       {sand, {"wall=[{point=[0,0,0],normal=[0,0,1]}]"}, "a periodic cell has no walls"},
       {sand, {"grain=[{radius=1,position=[0,0,0]}]"}, "a scene has either [packing] or [[grain]]"},
       {sand, {"packing.mixture=[{material=\"sand\",share=1}]", "packing.hulls={}"}, "says what its grains are"},
       {sand,
        {"packing.box=[3 mm, 2 mm, 2 mm]"},
        "expected a list of 3 values, those that are texts or have a unit in"},
       {sand, {"loading.strain_rate=1 :"}, "unknown unit ':'"},
       {sphere, {"wall.0.rigid=true", "wall.0.material=sand"}, "a wall is either rigid or of a material"},
       {sphere, {"wall.0.material=sand", "wall.0.friction=0.5"}, "a wall of a material has that material's friction"},
       {sphere, {"wall.0.rigid=false"}, "needs material, or rigid = true"},
       {sphere, {"boundary.kind=walls", "wall="}, "needs the size of the box: boundary.box, or packing.box"},
       {sphere, {"boundary={kind=\"walls\",box=[1,0,1]}", "wall="}, "all three sides must be above 0"},
       {sphere,
        {"boundary={kind=\"periodic\",box=[4,4,4]}", "wall=", "grain.0.position=[0,0,5000]"},
        "grain 0 lies more than a thousand cells away"},
       {sphere, {"grain.0.material=clay"}, "\"clay\": no such material"},
       {sphere, {"loading.scale=2"}, "loading.scale is for random packings"},
       {sphere, {"material.sand.rotation=false", "grain.0.spin=[1,0,0]"}, "its grains do not turn"}});
}

TEST_CASE("hulls, Voronoi cells and prisms are refused what cannot be made of them") {
  const std::string prisms = "packing.kind=prisms", prism = "packing.prism={height=1e-3,corners=";
  const std::string parents =
      "packing.parents={kind=\"random\",box=[0.01,0.01,0.01],solid_fraction=0.3,"
      "radius={distribution=\"constant\",mean=1e-3}}";
  refuse(
      {{cube, {"grain.0.vertices=[[0,0,0]]"}, "a hull needs either vertices or box"},
       {cube, {"grain.0.box="}, "a hull needs either vertices or box"},
       {cube, {"grain.0.box=[1,1,0]"}, "all three sides must be above 0"},
       {cube, {"material.rock.foundation=1e12"}, "needs either foundation or youngs_modulus"},
       {cube, {"material.rock.rotation=false"}, "rotation = false"},
       {rock, {"material.rock.bond.normal_stiffness=1e12"}, "needs either modulus or normal_stiffness"},
       {rock, {"material.rock.bond.shear_ratio=0.4"}, "follows from poissons_ratio; or give normal_stiffness"},
       {rock,
        {"material.rock.bond.modulus=", "material.rock.bond.normal_stiffness=1e12", "material.rock.bond.length=1e-3"},
        "normal_stiffness is per area: no length is needed"},
       {rock, {"packing.cell_size=1e-3"}, "needs either cells or cell_size"},
       {rock, {"packing.cells="}, "needs either cells or cell_size"},
       {rock, {"packing.cells=", "packing.cell_size=1e-5"}, "more than half a million Voronoi cells; check box"},
       {rock, {"packing.box="}, "packing: box, cylinder, prism or polyellipsoid is missing"},
       {rock, {"packing.cylinder={diameter=0.01,length=0.01}"}, "fill either a box or a cylinder"},
       {rock, {"packing.box=", prism + "[[0,0,0],[1,0,0]]}"}, "3 to 32 corners are needed"},
       {rock, {"packing.box=", prism + "[[0,0,0],[1,0,1],[0,1,0]]}"}, "are points [x, y, 0] of the plane"},
       {rock, {"packing.box=", prism + "[[0,0,0],[0,1,0],[1,0,0]]}"}, "convex polygon, counter-clockwise"},
       {rock, {"packing.box=", "packing.polyellipsoid={semi_axes=[1,1,1,1,1,0]}"}, "all six must be above 0"},
       {rock, {"boundary.kind=periodic", "packing.cells=60"}, "a periodic box needs four Voronoi cells a side"},
       {rock, {"packing.box=", "packing.cells=", parents, "packing.grains=one"}, "\"one\" has no parents"},
       {rock, {"packing.cells=", parents}, "box: is that of packing.parents"},
       {rock, {"packing.box=", "packing.cells=10000", parents}, "more than half a million Voronoi cells"},
       {rock, {"packing.box=", "packing.cells=", parents, "packing.parents.material=rock"}, "has no effect here"},
       {rock,
        {prisms, "packing.cells=", "packing.box=", "packing.side=1e-3", "packing.thickness=1e-3"},
        "packing: box or cylinder is missing"},
       {rock,
        {prisms, "packing.cells=", "packing.side=1e-5", "packing.thickness=1e-5"},
        "more than some hundred thousand prisms"},
       {rock,
        {prisms, "packing.cells=", "packing.cylinder={diameter=0.01,length=0.01}", "packing.side=1e-3",
         "packing.thickness=1e-3"},
        "prisms fill either a box or a cylinder"},
       {rock, {"clamp=[{where=\"x=min\"},{where=\"x=min\"}]"}, "is clamped twice"},
       {rock, {"clamp=[{where=\"x=min\",slips=true}]"}, "slips: unknown key"},
       {cleaving, {"packing.hulls={balls=32,relax=2}"}, "is of angular grains; balls are what they are"},
       {cleaving, {"packing.hulls={balls=30}"}, "30: must be 32"},
       {cleaving, {"packing.hulls={aspect=[1,1,11]}"}, "the longest at most ten times the shortest"}});
}

TEST_CASE("grains that break are refused planes, energies and laws that do not fit together") {
  const std::string planes = "material.sand.fracture.planes=";
  std::string many = "[";
  for (int k = 0; k < 33; ++k) many += "[1,0,0],";
  refuse(
      {{cleaving, {planes + "[[0,0,0]]"}, "planes: are normals, not zero"},
       {cleaving, {planes + many + "]"}, "planes: 32 at most"},
       {cleaving,
        {"material.sand.fracture.toughness=[1e6,0]", planes + "[[1,0,0],[0,1,0]]"},
        "toughness: must be above 0"},
       {cleaving, {"material.sand.fracture.toughness=[1e6,2e6]", planes + "[[1,0,0]]"}, "one for each of the 1 planes"},
       {cleaving, {"material.sand.fracture.offsets=[1]"}, "are between -1 and 1"},
       {cleaving, {"material.sand.fracture.offsets=[]"}, "expected a list of 1 to 32 numbers"},
       {cleaving,
        {planes + "[[1,0,0]]", "material.sand.fracture.crystal={axis=[0,0,0],angles=[0]}"},
        "axis: must not be zero"},
       {cleaving,
        {planes + "[[1,0,0]]", "material.sand.fracture.crystal={axis=[0,0,1],angles=[]}"},
        "expected a list of angles"},
       {cleaving, {"material.sand.fracture={model=\"cleavage\"}"}, "without a criterion nothing breaks"},
       {cleaving,
        {"material.sand.youngs_modulus=", "material.sand.foundation=1e12", "material.sand.fracture.cohesive=true"},
        "needs fracture_energy, or toughness and a modulus of elasticity"},
       {cleaving, {"material.sand.fracture={model=\"bonded\"}"}, "is not available in this version"},
       {cracking, {"material.sand.fracture.fracture_energy=10"}, "needs either platen_strength or fracture_energy"},
       {cracking, {"material.sand.fracture.platen_strength="}, "needs either platen_strength or fracture_energy"},
       {cracking, {"material.sand.fracture.horizon=6.1"}, "must be at most 6"},
       {cracking, {"material.sand.fracture.platen_strength=\"300 MPa\""}, "more than a hundredth of youngs_modulus"},
       {cracking,
        {"material.sand.fracture.weibull={modulus=5,reference_radius=1e-3}", "material.sand.fracture.size_law=griffith",
         "material.sand.fracture.reference_diameter=1e-3"},
        "it is twice weibull.reference_radius; leave it out"},
       {cracking,
        {"material.sand.fracture.scatter={size_exponent=0.3,reference_diameter=1e-3}",
         "material.sand.fracture.size_law=griffith", "material.sand.fracture.reference_diameter=2e-3"},
        "it is that of scatter"},
       {cracking,
        {"material.sand.bond={modulus=1e10,tension=1e6,cohesion=1e6,fracture_energy=1}"},
        "\"peridynamics\" goes with no bonds"},
       {cracking,
        {"material.sand.youngs_modulus=", "material.sand.foundation=1e12"},
        "\"peridynamics\" needs contact = \"overlap\", of hulls"},
       {sand, {"material.sand.fracture={model=\"cleavage\",toughness=1e6,flaw=1e-5}"}, "\"cleavage\" cuts hulls"},
       {sand,
        {"material.sand.fracture={model=\"apollonian-14\",rounding=0.1,hoek_brown={compressive_strength=1e7,m=10}}"},
        "rounding: is for model = \"polyellipsoid-split\""},
       {sand, {"material.sand.fracture={model=\"polyellipsoid-split\"}"}, "without a criterion nothing breaks"}});
}
