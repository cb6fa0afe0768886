// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/spheres.hpp"

#include <algorithm>
#include <map>

#include "dem/packing/random_hulls.hpp"
#include "dem/sample/compaction.hpp"
#include "dem/state/order.hpp"

namespace grus::dem {
namespace {

bool shaped(const Part& part) { return part.aspect.minCoeff() != part.aspect.maxCoeff(); }

/// Longest half axis of an ellipsoid over the radius of a sphere of its volume.
double reach_of(const Part& part) { return part.aspect.maxCoeff() / std::cbrt(part.aspect.prod()); }

/// Grain i's part is entry i, and again from the first: who has had least of his share is next.
std::vector<std::size_t> deal(const std::vector<Part>& parts) {
  double all = 0;
  for (const Part& part : parts) all += part.share;
  std::vector<double> had(parts.size(), 0.0);
  std::vector<std::size_t> row(parts.size() == 1 ? 1 : 10000);
  for (std::size_t i = 0; i < row.size(); ++i) {
    std::size_t next = 0;
    double most = -1;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double lacks = parts[k].share / all * static_cast<double>(i + 1) - had[k];
      if (lacks > most) most = lacks, next = k;
    }
    had[next] += 1, row[i] = next;
  }
  return row;
}

/// How much larger than a sphere of its volume the sphere about each grain is, in turn; empty where all are spheres.
std::vector<double> reaches(const std::vector<Part>& parts) {
  std::vector<double> reach;
  if (std::any_of(parts.begin(), parts.end(), shaped))
    for (const std::size_t k : deal(parts)) reach.push_back(reach_of(parts[k]));
  return reach;
}

/// Solid part of the spheres that hold grains of a solid part of 1.
double spheres_of(const std::vector<double>& reach) {
  double sum = 0;
  for (const double r : reach) sum += r * r * r;
  return reach.empty() ? 1 : sum / static_cast<double>(reach.size());
}

/// A hull into every sphere: shape i of `hulls` in turn, in the sphere that holds it. Equal ones share a row.
void put_hulls(const Packing& packing, const std::vector<UnitHull>& hulls, std::uint8_t material, bool turned,
               const Model& model, Grains& g) {
  HullStore store;
  std::map<std::pair<std::size_t, double>, std::pair<Index, HullPlace>> rows;
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const std::size_t k = i % hulls.size();
    const double scale = packing.spheres[i].radius / hulls[k].reach;
    const auto [row, fresh] = rows.try_emplace({k, scale});
    if (!fresh) continue;
    Polyhedron body = hulls[k].body;
    stretch(body, Vec3::Constant(scale));
    row->second.first = add_hull(store, body, row->second.second);
  }
  g.hulls = std::make_shared<HullStore>(std::move(store));
  for (std::size_t i = 0; i < packing.spheres.size(); ++i) {
    const std::size_t k = i % hulls.size();
    const auto& [row, at] = rows.at({k, packing.spheres[i].radius / hulls[k].reach});
    GrainSpec spec;
    spec.hull = row;
    spec.position = packing.spheres[i].position;
    spec.material = material;
    spec.density = model.materials[material].density;
    spec.inertia = model.numerics.inertia_factor(std::cbrt(3 * g.hulls->row[row].volume / (4 * pi)));
    spec.orientation = turned ? random_rotation(model.seed, i) * at.axes : at.axes;
    set_grain(g, i, spec);
  }
  sort_in_space(g);
}

}  // namespace

void put_spheres(const std::vector<Sphere>& spheres, const std::vector<Part>& parts, bool turned, const Model& model,
                 Grains& grains, const std::vector<std::uint8_t>& materials) {
  const std::vector<std::size_t> row = deal(parts);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    Part part = parts[row[i % row.size()]];
    if (!materials.empty()) part.material = materials[i];
    const Material& material = model.materials[part.material];
    GrainSpec spec;
    const double radius = spheres[i].radius / reach_of(part);
    spec.shape = PolyEllipsoid::sphere(radius);
    if (shaped(part)) spec.shape.plus = spec.shape.minus = radius / std::cbrt(part.aspect.prod()) * part.aspect;
    spec.position = spheres[i].position;
    spec.material = part.material;
    spec.density = material.density;
    spec.turns = material.turns;
    spec.inertia = model.numerics.inertia_factor(radius);
    if (turned) spec.orientation = random_rotation(model.seed, i);
    set_grain(grains, i, spec);
  }
  sort_in_space(grains);
}

void put_lattice(const Lattice& l, const Model& model, Grains& grains) {
  const Packing packing = (l.hexagonal ? hexagonal_close : simple_cubic)(l.radius, l.layers);
  put_spheres(packing.spheres, {{l.material}}, l.turned, model, grains);
}

void put_random(const RandomPacking& p, const Model& model, const Recipe& recipe, Team& team, const Watch& watch,
                Grains& grains, double& overlap) {
  const Container container = container_of(recipe.bounds, p.round);
  std::vector<UnitHull> hulls;
  std::vector<double> reach;
  if (p.hulls && p.hulls->balls)
    hulls = {ball_of_planes(p.hulls->aspect)};
  else if (p.hulls)
    hulls = random_hulls(p.hulls->rounds, p.hulls->aspect, model.seed, team);
  for (const UnitHull& hull : hulls) reach.push_back(hull.reach);
  if (!p.hulls) reach = reaches(p.parts);
  const auto pack = [&](const Vec3& box, double solid_fraction) {
    const Packing packing =
        random_packing(box, p.radius, solid_fraction, p.count, container, model.seed, team, watch, reach);
    overlap = packing.worst_overlap;
    if (p.hulls)
      put_hulls(packing, hulls, p.parts[0].material, p.turned, model, grains);
    else
      put_spheres(packing.spheres, p.parts, p.turned, model, grains);
  };
  const double held = spheres_of(reach) * p.solid_fraction;  // would be of the spheres about the grains
  const auto bring_closer = [&] {
    const double room = held / loosest_in_spheres;
    const Vec3 box = std::cbrt(room) * recipe.box;
    pack(box, p.solid_fraction / room);
    compact(model, recipe, box, grains, overlap, team, watch);
    sort_in_space(grains);
  };
  const bool may = !reach.empty() && p.turned && (container == Container::periodic || container == Container::box);
  try {
    if (may && held > most_in_spheres) return bring_closer();
    try {
      pack(recipe.box, p.solid_fraction);
    } catch (const InputError&) {
      if (!may) throw;
      bring_closer();
    }
  } catch (const InputError& e) {
    refuse(p.place, e.what());
  }
}

}  // namespace grus::dem
