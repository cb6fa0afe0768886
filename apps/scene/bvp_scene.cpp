// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/scene/bvp_scene.hpp"

#include <fmt/format.h>

#include <filesystem>

namespace grus::app {
namespace {

void read_mesh(Table t, BvpScene& scene) {
  if (t.has("file")) t.fail("file", "mesh files are not available in this version; use mesh.box");
  if (t.choice_or("dimension", "3d", {"3d", "plane-strain", "axisymmetric"}) != "3d") t.fail("dimension", "only \"3d\" is available in this version");
  Table box = t.table("box");
  const auto size = box.numbers("size", 3, dimension::length), cells = box.numbers("cells", 3, dimension::none);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(size[k] > 0)) box.fail("size", "all three sides must be above 0");
    scene.mesh.size[k] = size[k];
    scene.mesh.cells[k] = static_cast<long>(cells[k]);
    if (cells[k] != static_cast<double>(scene.mesh.cells[k]) || cells[k] < 1) box.fail("cells", "expected three whole numbers from 1");
  }
  scene.mesh.hexahedron = box.choice_or("cell", "hexahedron", {"hexahedron", "tetrahedron"}) == "hexahedron";
  box.finish();
  t.finish();
}

void read_rve(Table t, BvpScene& scene) {
  std::filesystem::path file = t.text("scene");
  if (file.is_relative()) file = std::filesystem::path(scene.file).parent_path() / file;
  if (!std::filesystem::is_regular_file(file)) t.fail("scene", fmt::format("\"{}\": no such scene file", t.text("scene")));
  scene.quasi_static = read_quasi_static(t);
  const std::string tangent = t.choice_or("tangent", "contact-stiffness", {"contact-stiffness", "perturbation", "elastic", "quasi-newton"});
  using Kind = coupling::TangentKind;
  scene.rve.tangent = tangent == "elastic" ? Kind::elastic : tangent == "perturbation" ? Kind::perturbation : tangent == "quasi-newton" ? Kind::quasi_newton : Kind::contact_stiffness;
  if (scene.rve.tangent == Kind::perturbation) {
    scene.rve.perturbation = t.number_or("perturbation", scene.rve.perturbation, dimension::none, {1e-8, 0.01});
    scene.rve.central = t.flag_or("perturbation_central", false);
  }
  scene.rve.share = t.flag_or("exact_sharing", true);
  if (t.has("adaptivity")) t.fail("adaptivity", "sharing of RVEs is not available in this version; leave the key out");
  scene.variants = static_cast<int>(t.integer_or("variants", 1, 1, 100000));
  t.finish();
  scene.unit_cells.push_back(read_unit_cell(file.string(), {}));
  // Below the pressure it was prepared at, a cell is a loose heap: tolerances are then against half that pressure.
  if (scene.quasi_static.pressure_floor == 0 && scene.unit_cells[0].preparation)
    scene.quasi_static.pressure_floor = 0.5 * scene.unit_cells[0].preparation->pressure;
  const std::uint64_t seed = scene.unit_cells[0].model.seed;
  for (std::uint64_t v = 1; v < static_cast<std::uint64_t>(scene.variants); ++v)
    scene.unit_cells.push_back(read_unit_cell(file.string(), {fmt::format("packing.seed={}", seed + v)}));
}

void read_boundary(Table t, BvpScene& scene) {
  fem::BoundaryCondition bc;
  if (t.has("tag")) t.fail("tag", "mesh tags are not available in this version; use where");
  const std::string where = t.text("where");
  try {
    bc.where = parse_where(where, scene.mesh.size);
  } catch (const std::invalid_argument& e) {
    t.fail("where", fmt::format("\"{}\": {}", where, e.what()));
  }
  std::string name;
  for (char c : where)
    if (std::isalnum(static_cast<unsigned char>(c))) name += c;
  bc.name = t.text_or("name", name);
  if (bc.name.empty() || bc.name.find_first_of(", \"\n") != std::string::npos) t.fail("name", "must be a word: it becomes part of column names");
  for (const auto& other : scene.boundaries)
    if (other.name == bc.name) t.fail("name", fmt::format("\"{}\": two boundaries have this name; give one of them another", bc.name));
  if (!t.has("displacement") && !t.has("traction")) t.fail("", "needs displacement or traction");
  if (t.has("displacement")) {
    const auto u = t.free_numbers("displacement", 3, dimension::length);
    for (std::size_t k = 0; k < 3; ++k) bc.displacement[k] = u[k];
  }
  if (t.has("traction")) {
    const auto p = t.numbers("traction", 3, dimension::pressure);
    bc.traction = fem::Point{p[0], p[1], p[2]};
  }
  t.finish();
  scene.boundaries.push_back(bc);
}

void read_solve(Table t, BvpScene& scene) {
  if (t.choice("kind", {"quasi-static", "explicit-dynamic"}) != "quasi-static")
    t.fail("kind", "\"explicit-dynamic\" is not available in this version; use \"quasi-static\"");
  fem::StaticsOptions& s = scene.solve;
  s.increments = static_cast<int>(t.integer_or("increments", 10, 1, 1000000));
  s.tolerance = t.number_or("tolerance", s.tolerance, dimension::none, {0, 0.1, true});
  s.displacement_tolerance = t.number_or("displacement_tolerance", s.displacement_tolerance, dimension::none, {0, 1, true});
  s.max_cutbacks = static_cast<int>(t.integer_or("max_cutbacks", s.max_cutbacks, 0, 100));
  s.max_iterations = static_cast<int>(t.integer_or("max_iterations", s.max_iterations, 1, 1000));
  t.finish();
}

std::string trimmed(const std::string& s) {
  const auto first = s.find_first_not_of(' '), last = s.find_last_not_of(' ');
  return first == std::string::npos ? "" : s.substr(first, last - first + 1);
}

}  // namespace

std::function<bool(const fem::Point&)> parse_where(const std::string& text, const fem::Point& box) {
  struct Plane {
    std::size_t axis;
    char relation;
    double at, tolerance;
  };
  std::vector<Plane> planes;
  std::string rest = text;
  while (true) {
    const auto joint = rest.find(" and ");
    const std::string part = trimmed(rest.substr(0, joint));
    if (part.size() < 3) throw std::invalid_argument("expected conditions such as z=max, joined by 'and'");
    const auto relation = part.find_first_of("=<>");
    const std::string axis = trimmed(part.substr(0, relation));
    if (relation == std::string::npos || (axis != "x" && axis != "y" && axis != "z"))
      throw std::invalid_argument(fmt::format("'{}' is not a condition such as z=max, x<0.01 or y>\"5 mm\"", part));
    Plane plane{static_cast<std::size_t>(axis[0] - 'x'), part[relation], 0, 0};
    const std::string value = trimmed(part.substr(relation + 1));
    plane.at = value == "min" ? 0 : value == "max" ? box[plane.axis] : parse_quantity(value, dimension::length);
    plane.tolerance = 1e-8 * (box[0] + box[1] + box[2]);
    planes.push_back(plane);
    if (joint == std::string::npos) break;
    rest = rest.substr(joint + 5);
  }
  return [planes](const fem::Point& x) {
    for (const auto& p : planes) {
      const double d = x[p.axis] - p.at;
      if (p.relation == '=' ? std::abs(d) > p.tolerance : p.relation == '<' ? d > p.tolerance : d < -p.tolerance) return false;
    }
    return true;
  };
}

BvpScene read_bvp_scene(const std::string& file, const std::vector<std::string>& overrides) {
  BvpScene scene;
  scene.file = file;
  const toml::table parsed = parse_scene(file, overrides);
  Table t(parsed, file, "", scene.record);
  scene.title = t.text_or("title", std::filesystem::path(file).stem().string());
  read_mesh(t.table("mesh"), scene);
  if (auto e = t.table_if("element")) {
    scene.discretisation.order = static_cast<int>(e->integer_or("order", 1, 1, 2));
    scene.discretisation.quadrature_degree = static_cast<int>(e->integer_or("quadrature_degree", 2, 1, 10));
    e->finish();
  }
  for (auto& b : t.tables("boundary")) read_boundary(b, scene);
  if (scene.boundaries.empty()) t.fail("", "needs at least one [[boundary]]");
  read_solve(t.table("solve"), scene);
  for (auto& p : t.tables("probe")) {
    Probe probe;
    probe.name = p.text("name");
    if (probe.name.empty() || probe.name.find_first_of(", /\"\n") != std::string::npos) p.fail("name", "must be a word: it becomes part of column and file names");
    for (const auto& other : scene.probes)
      if (other.name == probe.name) p.fail("name", fmt::format("\"{}\": two probes have this name", probe.name));
    const auto x = p.numbers("at", 3, dimension::length);
    for (std::size_t k = 0; k < 3; ++k) {
      probe.at[k] = x[k];
      if (x[k] < 0 || x[k] > scene.mesh.size[k]) p.fail("at", "lies outside the mesh");
    }
    probe.frames = p.flag_or("frames", false);
    probe.grading = p.flag_or("grading", false);
    p.finish();
    scene.probes.push_back(probe);
  }
  if (auto o = t.table_if("output")) {
    scene.frames = static_cast<int>(o->integer_or("frames", 0, 0, 100000));
    o->finish();
  }
  read_rve(t.table("rve"), scene);
  t.finish();
  return scene;
}

}  // namespace grus::app
