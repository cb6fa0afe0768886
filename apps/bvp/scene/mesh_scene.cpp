// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/scene/mesh_scene.hpp"
#include "apps/scene/reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "apps/scene/sample_scene.hpp"
#include "dem/rve/measure.hpp"

namespace grus::app {
namespace {

using Kinematics = fem::Kinematics;

std::string trimmed(const std::string& s) {
  const auto first = s.find_first_not_of(' '), last = s.find_last_not_of(' ');
  return first == std::string::npos ? "" : s.substr(first, last - first + 1);
}

void read_box(Table box, BvpScene& scene) {
  const bool flat = scene.flat();
  const std::size_t width = flat && box.length("size") == 2 ? 2 : 3;
  const auto size = box.numbers("size", width, dimension::length);
  const auto cells = box.numbers("cells", flat && box.length("cells") == 2 ? 2 : 3, dimension::none);
  double elements = 1;
  fem::BoxMesh mesh;
  for (std::size_t k = 0; k < (flat ? 2 : 3); ++k) {
    if (!(size[k] > 0)) box.fail("size", "all sides must be above 0");
    mesh.size[k] = size[k];
    mesh.cells[k] = static_cast<long>(cells[k]);
    if (cells[k] != static_cast<double>(mesh.cells[k]) || cells[k] < 1)
      box.fail("cells", "expected whole numbers from 1");
    elements *= cells[k];
    if (!(elements < 1e8)) box.fail("cells", "more than a hundred million elements");
  }
  if (flat && size.size() == 3 && scene.discretisation.kinematics == Kinematics::plane_strain) {
    if (!(size[2] > 0)) box.fail("size", "the third side is the thickness, above 0");
    scene.discretisation.thickness = size[2];
  }
  if (flat && cells.size() == 3 && cells[2] != 1) box.fail("cells", "two dimensions have one element across");
  const std::vector<std::string> kinds = flat ? std::vector<std::string>{"quadrilateral", "triangle"}
                                              : std::vector<std::string>{"hexahedron", "tetrahedron"};
  mesh.hexahedron = box.choice_or("cell", kinds[0], kinds) == kinds[0];
  box.finish();
  tell_uneven({mesh.size.data(), flat ? 2u : 3u}, scene.notes);
  scene.low = {0, 0, 0}, scene.high = mesh.size;
  if (flat) scene.high[2] = 0;
  for (std::size_t k = 0; k < (flat ? 2 : 3); ++k)
    scene.element = std::max(scene.element, mesh.size[k] / static_cast<double>(mesh.cells[k]));
  scene.mesh = mesh;
}

/// Mean of the elements' longest sides along an axis (m).
double element_length(const fem::MshMesh& mesh) {
  const auto width = static_cast<std::size_t>(fem::corners(mesh.kind));
  double sum = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      double low = INFINITY, high = -INFINITY;
      for (std::size_t i = c; i < c + width; ++i) {
        const double x = mesh.nodes[static_cast<std::size_t>(mesh.cells[i])][k];
        low = std::min(low, x), high = std::max(high, x);
      }
      longest = std::max(longest, high - low);
    }
    sum += longest;
  }
  const std::size_t cells = mesh.cells.size() / width;
  return sum / static_cast<double>(cells);
}

void read_file(Table& t, BvpScene& scene) {
  const std::string file = t.path("file");
  const double unit = t.number_or("unit", 1, dimension::length, positive);
  fem::MshMesh mesh;
  try {
    mesh = fem::read_msh(file);
  } catch (const std::invalid_argument& e) {
    t.fail("file", e.what());
  }
  if ((fem::dimension(mesh.kind) == 2) != scene.flat())
    t.fail("dimension", fmt::format("the mesh has {} dimensions; use {}", fem::dimension(mesh.kind),
                                    scene.flat() ? "\"3d\"" : "\"plane-strain\" or \"axisymmetric\""));
  for (const auto& note : mesh.notes) scene.notes.push_back("mesh.file: " + note);
  scene.low = {INFINITY, INFINITY, INFINITY}, scene.high = {-INFINITY, -INFINITY, -INFINITY};
  for (auto& x : mesh.nodes)
    for (std::size_t k = 0; k < 3; ++k)
      x[k] *= unit, scene.low[k] = std::min(scene.low[k], x[k]), scene.high[k] = std::max(scene.high[k], x[k]);
  scene.element = element_length(mesh);
  if (!t.has("unit"))
    scene.notes.push_back(
        fmt::format("mesh.file is read in metres, as mesh.unit is not given: it measures {}", scene.extent()));
  scene.mesh = std::move(mesh);
}

/// Tags of a physical group, by number or by name; of a name there may be several.
std::vector<int> read_tags(Table& t, const BvpScene& scene, bool of_cells) {
  const auto* mesh = std::get_if<fem::MshMesh>(&scene.mesh);
  if (mesh == nullptr) t.fail("tag", "only mesh files have tags; use where");
  if (!t.is_text("tag")) return {static_cast<int>(t.integer("tag", 1, 1000000000))};
  const std::string name = t.text("tag");
  const auto& names = of_cells ? mesh->cell_names : mesh->facet_names;
  if (const auto at = names.find(name); at != names.end()) return at->second;
  std::string known;
  for (const auto& [other, tags] : names) known += (known.empty() ? "" : ", ") + other;
  t.fail("tag", fmt::format("\"{}\": the mesh has no physical group of this name{}", name,
                            known.empty() ? "" : " (it has " + known + ")"));
}

}  // namespace

std::function<bool(const fem::Point&)> read_where(Table& t, const BvpScene& scene) {
  const std::string where = t.text("where");
  try {
    return parse_where(where, scene.low, scene.high);
  } catch (const std::invalid_argument& e) {
    t.fail("where", fmt::format("\"{}\": {}", where, e.what()));
  }
}

std::string BvpScene::extent() const {
  std::string text;
  for (std::size_t k = 0; k < (flat() ? 2 : 3); ++k)
    text += fmt::format("{}{:.4g}", k > 0 ? " x " : "", high[k] - low[k]);
  return text + " m";
}

void note_size(BvpScene& scene) {
  constexpr double far = 1000;
  double longest = 0, grain = 0;
  for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, scene.high[k] - scene.low[k]);
  if (scene.has_rve) {
    const auto* random = std::get_if<dem::RandomPacking>(&scene.unit_cells[0].recipe.grains);
    grain = random ? 2 * random->radius.mean : dem::mean_diameter(scene.samples[0]->state.grains);
  }
  if (longest > far)
    scene.notes.push_back(fmt::format("the mesh measures {}: in metres? (mesh.unit of a file)", scene.extent()));
  else if (grain > longest)  // than an element they may be: an RVE has no place in it
    scene.notes.push_back(
        fmt::format("the RVEs' grains, of {:.3g} m, are larger than the whole mesh, which measures {}: in metres? "
                    "(mesh.unit of a file, lengths of the unit cell)",
                    grain, scene.extent()));
}

void read_mesh(Table t, BvpScene& scene) {
  const std::string kind = t.choice_or("dimension", "3d", {"3d", "plane-strain", "axisymmetric"});
  if (kind == "plane-strain") scene.discretisation.kinematics = Kinematics::plane_strain;
  if (kind == "axisymmetric") scene.discretisation.kinematics = Kinematics::axisymmetric;
  if (t.has("box") == t.has("file")) t.fail("", "needs either box or file");
  if (kind == "plane-strain") scene.discretisation.thickness = t.number_or("thickness", 1, dimension::length, positive);
  if (t.has("file"))
    read_file(t, scene);
  else
    read_box(t.table("box"), scene);
  t.finish();
}

void read_boundary(Table t, BvpScene& scene, const Dimension& time) {
  fem::BoundaryCondition bc;
  if (t.has("tag") == t.has("where")) t.fail("", "needs either where or tag");
  std::string name;
  if (t.has("tag")) {
    bc.tags = read_tags(t, scene, false);
    name = t.is_text("tag") ? t.text("tag") : fmt::format("tag{}", bc.tags[0]);
    const auto& idle = std::get<fem::MshMesh>(scene.mesh).idle_facets;
    for (const int tag : bc.tags)
      if (const auto at = idle.find(tag); at != idle.end())
        scene.notes.push_back(fmt::format("boundary[{}]: {}", scene.boundaries.size(), at->second));
  } else {
    bc.where = read_where(t, scene);
    for (char c : t.text("where"))
      if (std::isalnum(static_cast<unsigned char>(c))) name += c;
  }
  bc.name = t.text_or("name", name);
  if (bc.name.empty() || bc.name.find_first_of(", \"\n") != std::string::npos)
    t.fail(t.has("name") ? "name" : "tag",
           "must be a word, for it becomes part of column names: give it a name = \"...\"");
  for (const auto& other : scene.boundaries)
    if (other.name == bc.name)
      t.fail("name", fmt::format("\"{}\": two boundaries have this name; give one of them another", bc.name));
  if (!t.has("displacement") && !t.has("traction") && !t.has("pressure"))
    t.fail("", "needs displacement, traction or pressure");
  const std::size_t width = scene.flat() ? 2 : 3;
  if (t.has("displacement")) {
    const auto u =
        t.free_numbers("displacement", width == 2 && t.length("displacement") == 2 ? 2 : 3, dimension::length);
    for (std::size_t k = 0; k < width; ++k) bc.displacement[k] = u[k];
    if (width == 2 && u.size() == 3 && u[2].value_or(0) != 0)
      t.fail("displacement", "two dimensions do not move along z");
  }
  if (t.has("traction")) {
    const auto p = t.numbers("traction", width == 2 && t.length("traction") == 2 ? 2 : 3, dimension::pressure);
    bc.traction = fem::Point{p[0], p[1], p.size() == 3 ? p[2] : 0};
  }
  if (t.has("pressure")) bc.pressure = t.number("pressure", dimension::pressure, any);
  if (t.is_text("history")) {
    if (t.choice("history", {"constant", "ramp"}) == "constant") bc.history.points = {{0, 1}};
  } else if (t.has("history")) {
    bc.history.points = t.pairs("history", time);
    for (std::size_t i = 1; i < bc.history.points.size(); ++i)
      if (bc.history.points[i][0] <= bc.history.points[i - 1][0]) t.fail("history", "times must grow");
  }
  if (bc.history.points.empty()) bc.history.points = {{0, 0}, {scene.end_time(), 1}};
  t.finish();
  scene.boundaries.push_back(bc);
}

void read_region(Table t, BvpScene& scene) {
  Region region;
  if (t.has("tag") == t.has("where")) t.fail("", "needs either where or tag");
  if (t.has("tag"))
    region.tags = read_tags(t, scene, true);
  else
    region.where = read_where(t, scene);
  region.j2 = t.choice("material", {"elastic", "j2"}) == "j2";
  region.youngs_modulus = t.number("youngs_modulus", dimension::pressure, positive);
  region.poissons_ratio = t.number("poissons_ratio", dimension::none, {0, 0.5, false, true});
  if (region.j2) {
    region.yield_stress = t.number("yield_stress", dimension::pressure, positive);
    region.hardening = t.number_or("hardening", 0, dimension::pressure, not_negative);
  }
  if (t.has("initial_stress")) {
    const auto stress = t.numbers("initial_stress", 6, dimension::pressure);
    std::copy(stress.begin(), stress.end(), region.initial_stress.emplace().begin());
  }
  if (scene.weighs() && !t.has("density")) t.fail("density", "is needed: there is gravity");
  if (scene.dynamic())
    region.density = t.number("density", dimension::density, positive);
  else
    region.density = t.number_or("density", 0, dimension::density, not_negative);
  t.finish();
  scene.regions.push_back(region);
}

std::function<bool(const fem::Point&)> parse_where(const std::string& text, const fem::Point& low,
                                                   const fem::Point& high) {
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
    if (value == "min")
      plane.at = low[plane.axis];
    else if (value == "max")
      plane.at = high[plane.axis];
    else
      plane.at = parse_quantity(value, dimension::length).value;
    plane.tolerance = 1e-8 * (high[0] - low[0] + high[1] - low[1] + high[2] - low[2]);
    planes.push_back(plane);
    if (joint == std::string::npos) break;
    rest = rest.substr(joint + 5);
  }
  return [planes](const fem::Point& x) {
    for (const auto& p : planes) {
      const double d = x[p.axis] - p.at;
      if (p.relation != '>' && d > p.tolerance) return false;
      if (p.relation != '<' && d < -p.tolerance) return false;
    }
    return true;
  };
}

}  // namespace grus::app
