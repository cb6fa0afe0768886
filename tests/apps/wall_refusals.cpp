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

void refuse(const std::vector<test::Refusal>& rows) { check_refused(rows, read_rve_scene); }

}  // namespace

TEST_CASE("walls that press are refused what does not fit them") {
  refuse({{sided, {"wall.0.point=[0,0,0]"}, "point: is of walls without side"},
          {sided, {"wall.0.side=top"}, "side: \"top\": must be one of"},
          {sided, {"wall.0.area=1e-6"}, "area: of a side is that of the box there"},
          {sided, {"wall.0.control=velocity"}, "stress: is for control = \"stress\""},
          {sided, {"wall.0.velocity=[1,0,0]"}, "velocity: of a wall that seeks a stress is along its plane"},
          {sided, {"wall.0.stress=-1"}, "stress: -1"},
          {sided, {"wall.0.max_speed=1e6"}, "max_speed: 1e+06 m/s: faster than any wave"},
          {sided, {"boundary.kind=open"}, "side: needs boundary.kind"},
          {sided, {"boundary.kind=cylinder"}, "side: of a cylinder is \"zmin\" or \"zmax\""},
          {sided,
           {"loading={kind=\"uniaxial-strain\",strain_rate=1,final_strain=0.1}"},
           "kind: walls that move by themselves"},
          {sided, {"loading=", "stage=[{kind=\"relax\",until={time=1e-3}}]"}, "stage: walls that move by themselves"},
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
          {three, {"loading.y.b=2"}, "b: 2"}});
}
