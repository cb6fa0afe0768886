// SPDX-License-Identifier: LGPL-3.0-or-later
// What scenes are refused for that say how walls move and press.
#include "apps/scene/rve_scene.hpp"
#include "tests/apps/refused.hpp"

using namespace grus::app;
using grus::app::test::check_refused;

namespace {

const char* const sided = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
boundary.kind = "walls"
loading = { kind = "free", duration = 1e-3 }
wall = [{ side = "xmax", control = "stress", stress = 1e5 }]
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
)";

const char* const lid = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
grain = [{ radius = 1e-3, position = [0, 0, 0] }]
wall = [{ point = [0, 0, 2e-3], normal = [0, 0, -1], control = "stress", stress = 1e5, area = 1e-6 }]
loading = { kind = "free", duration = 1e-3 }
)";

const char* const three = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
boundary.kind = "walls"
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
[loading]
kind = "true-triaxial"
x = { stress = 1e5 }
y = { b = 0.5 }
z = { stress = 3e5, strain_rate = 1 }
final_strain = 0.1
)";

const char* const cell = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
boundary.kind = "periodic"
loading = { kind = "uniaxial-strain", strain_rate = 1, final_strain = 0.1 }
[packing]
kind = "random"
box = [0.01, 0.01, 0.01]
radius = { distribution = "constant", mean = "0.5 mm" }
solid_fraction = 0.3
)";

const char* const hopper = R"(
material.sand = { density = 2650, youngs_modulus = "20 GPa", friction = 0.5 }
grain = [{ radius = 1e-3, position = [0, 0, 0] }]
wall = [{ shape = "mesh", path = "hopper.stl", point = [0, 0, -0.1], unit = "mm" }]
loading = { kind = "free", duration = 1e-3 }
)";

const char* const facets =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
    "a\n";

const char* const deposit = "stage=[{kind=\"deposit\",gravity=[0,0,-9.81],until={time=1e-3}}]";

/// A wall of the scene's own that moves, in place of its others.
std::string moving(const std::string& how) {
  const bool plane = how.find("shape") == std::string::npos;
  return "wall=[{point=[0,0,-2e-3]," + std::string(plane ? "normal=[0,0,1]," : "") + how + "}]";
}

void refuse(const std::vector<test::Refusal>& rows) { check_refused(rows, read_rve_scene); }

}  // namespace

TEST_CASE("walls of triangles are refused what does not fit them") {
  const auto read = [](const std::string& file, const auto& changes) {
    const std::string folder = file.substr(0, file.rfind('/') + 1);
    std::ofstream(folder + "hopper.stl") << facets;
    std::ofstream(folder + "flat.stl") << std::string(facets).replace(std::string(facets).find("0 1 0"), 5, "2 0 0");
    const std::string head = "ply\nformat ascii 1.0\n";
    const std::string corners = head +
                                "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                                "element face 1\nproperty list uchar int vertex_index\nend_header\n";
    for (const auto& [name, text] : {std::pair{"corner", corners + "0 0 0\n3 0 0 7\n"},
                                     {"two", corners + "0 0 0\n2 0 0\n"},
                                     {"word", corners + "0 0\nx\n"},
                                     {"list", corners + "0 0 0\n-1\n"},
                                     {"format", "ply\nformat utf8 1.0\n"},
                                     {"many", head + "element vertex many\n"},
                                     {"end", head}})
      std::ofstream(folder + name + ".ply") << text;
    read_rve_scene(file, changes);
  };
  check_refused(
      {{hopper, {"wall.0.path=none.stl"}, "none.stl"},
       {hopper, {"wall.0.path=corner.ply"}, "face 1 names corner 7: there are 1, counted from 0"},
       {hopper, {"wall.0.path=two.ply"}, "two.ply:11: a face needs three corners"},
       {hopper, {"wall.0.path=word.ply"}, "word.ply:11: ends too early, or has what is no number"},
       {hopper, {"wall.0.path=list.ply"}, "list.ply:11: a list of -1"},
       {hopper, {"wall.0.path=format.ply"}, "format.ply:2: format \"utf8\": must be ascii"},
       {hopper, {"wall.0.path=many.ply"}, "many.ply:3: \"element vertex many\": how many?"},
       {hopper, {"wall.0.path=end.ply"}, "end.ply:2: its header has no end"},
       {hopper, {"wall.0.path=flat.stl"}, "path: no triangles in it that have an area"},
       {hopper, {"wall.0.path=hopper.off"}, "path: a wall is read from a file that ends with .stl, .obj or .ply"},
       {hopper, {"wall.0.path=hopper.STL"}, "hopper.STL: no such file"},
       {hopper, {"wall.0.unit=kg"}, "unit: \"kg\""},
       {hopper, {"wall.0.normal=[0,0,1]"}, "normal: is of other shapes"},
       {hopper, {"wall.0.shape=plane", "wall.0.normal=[0,0,1]"}, "path: is for shape = \"mesh\""},
       {hopper, {"wall.0.control=stress"}, "control: is of planes"},
       {hopper, {"numerics.engine=implicit"}, "a wall of triangles needs explicit steps"},
       {hopper, {"material.sand.contact=jkr", "material.sand.work_of_adhesion=1"}, "knows no contacts that attract"},
       {hopper,
        {"grain=[{shape=\"polyellipsoid\",semi_axes=[1,1,1,1,1,2],position=[0,0,5]}]"},
        "a wall of triangles needs a scene of spheres alone"},
       {hopper,
        {"grain=[{shape=\"hull\",box=[1,1,1],position=[0,0,5]}]", "material.sand.contact=overlap"},
        "hulls cannot meet a wall of triangles yet"}},
      read);
}

TEST_CASE("walls that press are refused what does not fit them") {
  refuse({{sided, {"wall.0.point=[0,0,0]"}, "point: is of walls without side"},
          {sided, {"wall.0.side=top"}, "side: \"top\": must be one of"},
          {sided, {"wall.0.area=1e-6"}, "area: of a side is that of the box there"},
          {sided, {"wall.0.control=velocity"}, "stress: is for control = \"stress\""},
          {sided, {"wall.0.velocity=[1,0,0]"}, "velocity: of a wall that seeks a stress is along its plane"},
          {sided, {"wall.0.stress=-1"}, "stress: -1"},
          {sided, {"wall.0.stress=\"21 GPa\""}, "stress: 2.1e+10 Pa: above the stiffness of the grains, 2e+10 Pa"},
          {sided,
           {"wall.0.stress_rate=-2.1e13"},
           "duration: wall 1: stress_rate brings it to 2.1e+10 Pa: above the stiffness"},
          {sided, {"wall.0.max_speed=1e6"}, "max_speed: 1e+06 m/s: faster than any wave"},
          {sided, {"boundary.kind=open"}, "side: needs boundary.kind"},
          {sided, {"boundary.kind=cylinder"}, "side: of a cylinder or of \"periodic-xy\" is \"zmin\" or \"zmax\""},
          {sided,
           {"loading={kind=\"uniaxial-strain\",strain_rate=1,final_strain=0.1}"},
           "kind: walls that move by themselves"},
          {sided, {"loading=", "stage=[{kind=\"relax\",until={time=1e-3}}]"}, "stage: walls that move by themselves"},
          {lid, {moving("velocity=[0,0,0.1]"), "loading=", deposit}, "stage: walls that move by themselves"},
          {lid,
           {moving("shape=\"cylinder\",axis=\"z\",radius=1,velocity=[0,0,0.1]"), "loading=", deposit},
           "stage: walls that move by themselves"},
          {sided, {"wall=[{side=\"xmax\"},{side=\"xmax\"}]"}, "side: is given twice"},
          {sided,
           {"wall=[{side=\"xmin\",control=\"stress\",stress=1},{side=\"xmax\",control=\"stress\",stress=1}]"},
           "control: the side opposite seeks a stress, too"},
          {sided, {"wall=[{point=[0,0,0],normal=[0,0,1]}]"}, "makes its own walls"},
          {lid, {"wall.0.area="}, "area is missing"},
          {lid, {"wall.0.stress="}, "stress is missing"},
          {lid,
           {"wall=[{shape=\"cylinder\",axis=\"z\",radius=1e-2,point=[0,0,0],control=\"stress\"}]"},
           "control: is of planes"}});
}

TEST_CASE("grains are refused to move with walls where they cannot") {
  const char* const layer = "wall=[{side=\"zmin\",fixed_layer=1e-3}]";
  refuse({{sided, {"wall=[{side=\"zmin\",fixed_layer=0}]"}, "fixed_layer: 0"},
          {sided, {"wall=[{side=\"zmin\",fixed_material=\"snad\"}]"}, "fixed_material: \"snad\": no such material"},
          {sided, {layer, "numerics.engine=implicit"}, "fixed_layer: needs explicit steps"},
          {sided,
           {layer, "numerics.inertia={step=1e-6}", "loading={kind=\"uniaxial-strain\",strain_rate=1,final_strain=0.1}"},
           "fixed_layer: cannot be with numerics.inertia.step"},
          {sided,
           {layer, "packing={kind=\"voronoi\",cells=3,box=[1e-2,1e-2,1e-2]}", "material.sand.contact=overlap"},
           "fixed_layer: is of loose grains"},
          {lid,
           {"wall=[{shape=\"cylinder\",axis=\"z\",radius=1e-2,point=[0,0,0],fixed_layer=1e-3}]"},
           "fixed_layer: is of planes"}});
}

TEST_CASE("cells between walls are refused what needs other sides") {
  const std::string flat = "boundary.kind=periodic-xy";
  const char* const still = "wall=";
  refuse({{sided, {flat}, "side: of a cylinder or of \"periodic-xy\" is \"zmin\" or \"zmax\""},
          {sided, {flat, "wall=[{point=[0,0,0],normal=[0,0,1]}]"}, "\"periodic-xy\" makes its own walls"},
          {three, {flat}, "kind: \"true-triaxial\" cannot be with boundary.kind = \"periodic-xy\""},
          {sided,
           {flat, still, "loading={kind=\"uniaxial-strain\",axis=\"x\",strain_rate=1,final_strain=0.1}"},
           "axis: of \"periodic-xy\" is \"z\""},
          {sided,
           {flat, still, "loading=", "stage=[{kind=\"compress\",axis=\"y\",strain_rate=1,until={strain=0.1}}]"},
           "of a cylinder or \"periodic-xy\", whose sides stay"},
          {sided,
           {flat, still, "packing={kind=\"voronoi\",cells=3,box=[1e-2,1e-2,1e-2]}", "material.sand.contact=overlap"},
           "kind: \"periodic-xy\" is of loose grains"},
          {sided, {flat, still, "preparation={pressure=1e5}"}, "preparation: needs boundary.kind = \"periodic\""},
          {sided,
           {flat, still, "packing={kind=\"hcp\",layers=[3,3,3],radius={distribution=\"constant\",mean=1e-3}}"},
           "layers: a hcp packing that is periodic along y needs an even number of rows"},
          {sided,
           {"boundary.kind=open", "wall=[{side=\"zmax\",fixed_layer=1e-3}]"},
           "side: needs boundary.kind = \"walls\", \"cylinder\" or \"periodic-xy\""}});
}

TEST_CASE("three axes are refused orders that do not go together") {
  refuse({{three, {"loading.x="}, "x is missing"},
          {three, {"loading.z.stress_rate=1"}, "has strain_rate, stress_rate or b: one of them"},
          {three, {"loading.x.strain_rate=1"}, "y: b is of one axis beside one with strain_rate"},
          {three, {"loading.z={stress=3e5}"}, "y: b is of one axis beside one with strain_rate"},
          {three, {"loading.x={b=0.5}"}, "x: b is of one axis beside one with strain_rate"},
          {three, {"loading.y.stress=2e5"}, "stress: follows from b and the other two"},
          {three, {"loading.y={stress=2e5}", "loading.constant_mean=true"}, "constant_mean: needs b of one axis"},
          {three, {"loading.y={stress=2e5,stress_rate=-1e7}"}, "stress_rate -1e+07 Pa/s leaves less than no pressure"},
          {three, {"loading.z.strain_rate=0"}, "duration is missing"},
          {three, {"boundary.kind=cylinder"}, "\"true-triaxial\" cannot be in a cylinder"},
          {three, {"loading.y.b=2"}, "b: 2"},
          {three, {"loading.z.strain_rate=1e6"}, "z: 1e+06 1/s over 0.01 m is 1e+04 m/s: faster than any wave"},
          {three, {"loading.x.stress=21e9"}, "x: 2.1e+10 Pa: above the stiffness"}});
}

TEST_CASE("rates that outrun every wave are refused, and pressures that no grain bears") {
  const char* const walls = "boundary.kind=walls";  // 2 sqrt(20e9 / 2650) is 5494 m/s, of 10 mm 549,400 1/s
  const auto load = [](const std::string& how) { return "loading={" + how + "}"; };
  const auto stage = [](const std::string& how) { return "stage=[{strain_rate=5.6e5," + how + "}]"; };
  const char* const none = "loading=";
  const char* const fast = "strain_rate: 5.6e+05 1/s over 0.01 m is 5600 m/s: faster than any wave";
  const std::string rate = "strain_rate=5.6e5,final_strain=0.1";
  refuse({{cell, {"loading.strain_rate=5.6e5"}, fast},
          {cell, {"loading.strain_rate=-5.6e5"}, fast},
          {cell, {"loading.strain_rate=\"1e12 1/s\""}, "ask for less than 5.494e+05 1/s"},
          {cell, {walls, load("kind=\"triaxial\",confining_pressure=1e5," + rate)}, fast},
          {cell, {load("kind=\"constant-p\",pressure=1e5," + rate)}, fast},
          {cell, {load("kind=\"isotropic-stress\",pressure=1e5,duration=1,strain_rate=5.6e5")}, fast},
          {cell, {load("kind=\"oedometric-stress\",final_stress=1e6,strain_rate=5.6e5")}, fast},
          {cell,
           {load("kind=\"velocity-gradient\",duration=1,velocity_gradient=[[0,0,4e5],[0,0,0],[0,0,4e5]]")},
           "velocity_gradient: 5.657e+05 1/s over 0.01 m"},
          {cell,
           {load("kind=\"triaxial\",confining_pressure=21e9,strain_rate=1,final_strain=0.1")},
           "confining_pressure: 2.1e+10 Pa: above the stiffness of the grains, 2e+10 Pa"},
          {cell, {load("kind=\"constant-p\",pressure=21e9,strain_rate=1,final_strain=0.1")}, "pressure: 2.1e+10 Pa"},
          {cell,
           {"boundary=", "packing={kind=\"voronoi\",cells=60,box=[1e-2,1e-2,1e-2]}", "material.sand.contact=overlap",
            load("kind=\"platens\"," + rate)},
           fast},
          {cell, {none, stage("kind=\"compress\",until={strain=0.1}")}, fast},
          {cell, {none, stage("kind=\"compress\",axis=\"all\",until={stress=1e6}")}, fast},
          {cell, {none, stage("kind=\"shear\",plane=\"xz\",until={strain=0.1}")}, fast},
          {cell,
           {none, "stage=[{strain_rate=1,kind=\"shear\",lateral_stress=21e9,until={strain=0.1}}]"},
           "lateral_stress: 2.1e+10 Pa: above"},
          {cell, {none, stage("kind=\"cyclic\",cycles=2,strain_amplitude=0.01")}, fast}});
}
