// SPDX-License-Identifier: LGPL-3.0-or-later
// What boundary-value problems are refused for, guard by guard.
#include "apps/bvp/scene/bvp_scene.hpp"
#include "apps/bvp/scene/mesh_scene.hpp"
#include "tests/apps/refused.hpp"

using namespace grus::app;
using grus::app::test::check_refused;

namespace {

const char* const block = R"(
mesh.box = { size = [1, 1, 2], cells = [2, 2, 4] }
solve.kind = "quasi-static"
boundary = [{ where = "z=min", displacement = [0, 0, 0] }, { where = "z=max", traction = [0, 0, -1e6] }]
region = [{ where = "z>0", material = "elastic", youngs_modulus = 1e9, poissons_ratio = 0.2 }]
)";

const char* const strip = R"(
mesh = { dimension = "plane-strain", box = { size = [1, 2], cells = [2, 4] } }
solve.kind = "quasi-static"
gravity = [0, -10]
boundary = [{ where = "y=min", displacement = [0, 0] }]
region = [{ where = "y>0", material = "elastic", youngs_modulus = 1e9, poissons_ratio = 0.2, density = 2000 }]
probe = [{ name = "middle", at = [0.5, 1] }]
)";

const char* const bars = R"(
mesh.box = { size = [1, 1, 2], cells = [2, 2, 4] }
solve = { kind = "explicit-dynamic", duration = 1e-3 }
boundary = [{ where = "z=max", traction = [0, 0, -1e6] }]
region = [{ where = "z>0", material = "elastic", youngs_modulus = 1e9, poissons_ratio = 0.2, density = 2000 }]
probe = [{ name = "in", at = [0, 0, 2] }, { name = "out", where = "z=min" }]
[hopkinson]
incident_gauge = "in"
transmitted_gauge = "out"
bar_modulus = 1e9
bar_density = 2000
bar_area = 1
specimen_length = 1
specimen_area = 1
incident_distance = 1
transmitted_distance = 1
)";

void refuse(const std::vector<test::Refusal>& rows) { check_refused(rows, read_bvp_scene); }

}  // namespace

TEST_CASE("meshes, boundaries and regions are refused what does not fit them") {
  refuse({{block, {"mesh.box="}, "mesh: needs either box or file"},
          {block, {"mesh.file=a.msh"}, "mesh: needs either box or file"},
          {block, {"mesh.box.size=[1,1,0]"}, "size: all sides must be above 0"},
          {block, {"mesh.box.cells=[2,2.5,4]"}, "cells: expected whole numbers from 1"},
          {block, {"mesh.box.cells=[2,0,4]"}, "cells: expected whole numbers from 1"},
          {block, {"mesh.box.cells=[1000,1000,1000]"}, "more than a hundred million elements"},
          {block, {"boundary="}, "needs at least one [[boundary]]"},
          {block, {"boundary.0.where="}, "needs either where or tag"},
          {block, {"boundary.0.tag=1"}, "needs either where or tag"},
          {block, {"boundary.0.where=", "boundary.0.tag=1"}, "only mesh files have tags; use where"},
          {block, {"boundary.0.displacement="}, "needs displacement, traction or pressure"},
          {block, {"boundary.0.name=two words"}, "must be a word, for it becomes part of column names"},
          {block, {"boundary.1.name=zmin"}, "two boundaries have this name"},
          {block, {"boundary.0.where=z"}, "expected conditions such as z=max"},
          {block, {"boundary.0.where=zmax"}, "'zmax' is not a condition such as"},
          {block, {"boundary.0.where=w=max"}, "'w=max' is not a condition such as"},
          {block, {"boundary.1.history=[[0,0],[0.5,1],[0.5,0]]"}, "history: times must grow"},
          {block, {"region.0.tag=1"}, "needs either where or tag"},
          {block, {"gravity=[0,0,-10]"}, "density: is needed: there is gravity"},
          {block, {"element={kind=\"fbar\",order=2}"}, "elements of kind \"fbar\" have order 1"},
          {block, {"element={kind=\"serendipity\",order=1}"}, "elements of kind \"serendipity\" have order 2"},
          {block, {"element.kind=fbar", "mesh.box.cell=tetrahedron"}, "\"fbar\" is for quadrilaterals and hexahedra"},
          {strip, {"mesh.box={size=[1,2,0],cells=[2,4,1]}"}, "the third side is the thickness, above 0"},
          {strip, {"mesh.box={size=[1,2,1],cells=[2,4,2]}"}, "two dimensions have one element across"},
          {strip, {"boundary.0.displacement=[0,0,1]"}, "two dimensions do not move along z"},
          {strip, {"gravity=[0,0,-10]"}, "two dimensions have no weight along z"},
          {strip, {"mesh.dimension=axisymmetric", "gravity=[1,0]"}, "acts along the axis (y) where x is the radius"}});
}

TEST_CASE("of a whole table that is refused it is told what --set gave of it") {
  refuse({{block, {"mesh.file=a.msh"}, "scene.toml:2:1 (with --set mesh.file): mesh: needs either box or file"},
          {block, {"boundary.0.tag=1"}, " (with --set boundary.0.tag): boundary[0]: needs either where or tag"}});
}

TEST_CASE("places along which a condition holds: both sides, by their tolerance") {
  const auto at = [](const char* where, double x, double y) {
    return parse_where(where, {0, 0, 0}, {1, 2, 3})({x, y, 0});
  };
  for (const double off : {-1e-7, -5e-8, 0.0, 5e-8, 1e-7}) {  // the tolerance is 6e-8
    CHECK(at("x=max", 1 + off, 0) == (std::abs(off) < 6e-8));
    CHECK(at("y=min", 0, off) == (std::abs(off) < 6e-8));
    CHECK(at("x<0.5", 0.5 + off, 0) == (off < 6e-8));
    CHECK(at("x>50 cm", 0.5 + off, 0) == (off > -6e-8));
    CHECK(at("x<0.5 and y=max", 0.5 + off, 2) == (off < 6e-8));
    CHECK(at("x<0.5 and y=max", 0.25, 2 + off) == (std::abs(off) < 6e-8));
  }
}

TEST_CASE("probes, bars, ground and loads that come at once are refused what does not fit them") {
  const std::string ground = "initial_stress={k0=0.5";
  const std::string slowly = "solve.kind=explicit-quasi-static", dense = "region.0.density=2000";
  refuse({{strip, {"probe.0.name=a b"}, "must be a word: it becomes part of column and file names"},
          {strip, {"probe.0.name="}, "name"},
          {strip, {"probe=[{name=\"a\",at=[0,1]},{name=\"a\",at=[0,0]}]"}, "two probes have this name"},
          {strip, {"probe.0.where=x=min"}, "needs either at or where"},
          {strip, {"probe.0.at="}, "needs either at or where"},
          {strip, {"probe.0.at=[0.5,2.1]"}, "at: lies outside the mesh"},
          {strip, {"probe.0.at=[-0.1,1]"}, "at: lies outside the mesh"},
          {strip, {"probe=[{name=\"a\",where=\"x=min\",frames=true}]"}, "frames: is of one point's grains"},
          {strip, {"probe=[{name=\"a\",where=\"x=min\",grading=true}]"}, "grading: is of one point's grains"},
          {strip, {ground + ",axis=\"z\"}"}, "two dimensions have no depth along z"},
          {strip, {ground + ",axis=\"x\"}"}, "axis: gravity acts along another axis"},
          {strip, {ground + "}", "gravity=[0,10]"}, "axis: gravity acts away from the ground"},
          {strip, {ground + "}", "gravity=[0,0]"}, "needs a surcharge, or gravity and a surface above"},
          {strip, {ground + ",surface=0}"}, "needs a surcharge, or gravity and a surface above"},
          {bars, {"probe.0.at=[0,0,2.1]"}, "at: lies outside the mesh"},
          {bars, {"probe.0.at=[0,-0.1,2]"}, "at: lies outside the mesh"},
          {bars, {"output.history_interval=1e-10"}, "more than a million rows; ask for fewer"},
          {bars, {"hopkinson.incident_gauge=nobody"}, "incident_gauge: no probe has the name \"nobody\""},
          {bars, {"hopkinson.transmitted_gauge=nobody"}, "transmitted_gauge: no probe has the name \"nobody\""},
          {bars, {"regularisation.length=0.1"}, "needs solve.kind = \"explicit-quasi-static\""},
          {bars, {"solve={kind=\"quasi-static\"}"}, "needs solve.kind = \"explicit-dynamic\""},
          {block, {slowly, dense, "regularisation.length=0.1"}, "needs points with grains ([rve])"},
          {block, {slowly, dense, "boundary.1.history=constant"}, "nothing stands under this load at the start"},
          {block,
           {slowly, dense, "boundary.0.displacement=[0,0,0.1]", "boundary.0.history=constant"},
           "its displacement is not eased in: the history begins with 1 instead of 0"}});
  // What may come at once: nothing moves, or stresses stand under it.
  const auto reads = [](const std::vector<std::string>& changes) {
    check_refused({{block, {"boundary="}, "needs at least one"}}, [&](const std::string& file, const auto& more) {
      auto all = changes;
      all.insert(all.end(), more.begin(), more.end());
      return read_bvp_scene(file, all);
    });
  };
  reads({slowly, dense, "boundary.0.history=constant"});
  reads({slowly, dense, "boundary.1.history=constant", "region.0.initial_stress=[0,0,-1e6,0,0,0]"});
}
