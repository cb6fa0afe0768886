// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/sample/grains.hpp"

#include <fmt/format.h>

#include "dem/packing/clusters.hpp"
#include "dem/packing/sphere_bonds.hpp"
#include "dem/sample/spheres.hpp"

namespace grus::dem {
namespace {

/// Vertices or box of a hull become a row of the grains' hulls; its axes are turned into the orientation.
void add_listed_hull(const ListedGrain& grain, HullStore& store, GrainSpec& spec, std::vector<std::string>& notes) {
  try {
    Polyhedron body;
    if (!grain.vertices) {
      body = box_between(-0.5 * grain.box, 0.5 * grain.box);
    } else {
      body = hull_of(*grain.vertices);
      if (body.vertex.size() < grain.vertices->size())
        notes.push_back(fmt::format("{}: {} of {} vertices are no corners of the convex hull and are left out",
                                    grain.place, grain.vertices->size() - body.vertex.size(), grain.vertices->size()));
    }
    HullPlace place;
    spec.hull = add_hull(store, body, place);
    spec.orientation = spec.orientation * place.axes;
  } catch (const InputError& e) {
    refuse(grain.place, e.what());
  }
}

void put(const Listed& grains, const Model& model, const Recipe&, Team&, const Watch&, Sample& sample) {
  Grains& g = sample.state.grains;
  const auto store = std::make_shared<HullStore>();  // one for all: a copy for each hull would make thousands slow
  for (const ListedGrain& grain : grains) {
    GrainSpec spec = grain.spec;
    const Material& material = model.materials[spec.material];
    spec.density = material.density, spec.turns = material.turns;
    if (grain.hull()) {
      add_listed_hull(grain, *store, spec, sample.notes);
      g.hulls = store;
      if (const std::string why = unthinkable_mass(material, store->row[*spec.hull].bounding_radius); !why.empty())
        refuse(grain.place_of_size, why);
    } else {
      spec.inertia = model.numerics.inertia_factor(equivalent_radius(spec.shape));
    }
    set_grain(g, g.size(), spec);
  }
}

void put(const RandomPacking& p, const Model& model, const Recipe& recipe, Team& team, const Watch& watch,
         Sample& sample) {
  put_random(p, model, recipe, team, watch, sample.state.grains, sample.packing_overlap);
}

void put(const Lattice& l, const Model& model, const Recipe&, Team&, const Watch&, Sample& sample) {
  put_lattice(l, model, sample.state.grains);
}

void put(const Spheres& s, const Model& model, const Recipe&, Team&, const Watch&, Sample& sample) {
  put_spheres(s.spheres, {{s.material}}, s.turned, model, sample.state.grains, s.materials);
}

void put_faces(BondedFaces made, Sample& sample) {
  const BondedFaces& faces = sample.faces.emplace(std::move(made));
  if (faces.coarse > 0)
    sample.notes.push_back(fmt::format(
        "{} of {} bonds are too coarse for their energies: their tension or cohesion is lowered so that they "
        "can soften; use smaller Voronoi cells, a larger fracture_energy or shear_energy, or less cohesion",
        faces.coarse, faces.bonds));
}

void put_voronoi(const Model& model, const Tessellation& cells, std::uint8_t material, Sample& sample) {
  put_faces(add_voronoi_grains(model, cells, material, sample.state), sample);
}

void put(const VoronoiPacking& t, const Model& model, const Recipe& recipe, Team& team, const Watch&, Sample& sample) {
  const TessellationSpace space =
      t.space ? *t.space : (recipe.periodic() ? periodic_space(recipe.box) : box_space(recipe.box));
  try {
    Tessellation cells = t.seeds.empty() ? voronoi_packing(space, t.count, t.rounds, model.seed, team)
                                         : relaxed_voronoi(space, t.seeds, t.rounds, team);
    if (t.clusters > 0) deal_to_clusters(space, t.clusters, model.seed, team, cells);
    put_voronoi(model, cells, t.material, sample);
  } catch (const InputError& e) {
    refuse(t.place, e.what());
  }
}

void put(const Prisms& p, const Model& model, const Recipe& recipe, Team&, const Watch&, Sample& sample) {
  const Tessellation cells = prisms_of(p, recipe.box);
  try {
    put_voronoi(model, cells, p.material, sample);
  } catch (const InputError& e) {
    refuse(p.place, e.what());
  }
}

void put(const FilledGrains& f, const Model& model, const Recipe& recipe, Team& team, const Watch& watch,
         Sample& sample) {
  Sample parents;
  std::visit([&](const auto& p) { put(p, model, recipe, team, watch, parents); }, f.parents);
  try {
    put_voronoi(model, fill_grains(parents.state.grains, f.count, f.rounds, model.seed, team), f.material, sample);
  } catch (const InputError& e) {
    refuse(f.place, e.what());
  }
}

void put_rods(const Model& model, std::span<const Index> body, Team& team, Sample& sample) {
  const BondedFaces& made = sample.faces.emplace(bond_spheres(model, body, sample.state, team));
  const auto spheres = static_cast<double>(sample.state.grains.size());
  sample.notes.push_back(fmt::format("{} bonds between {} spheres, {:.1f} a sphere", made.bonds, spheres,
                                     2 * static_cast<double>(made.bonds) / spheres));
}

void put(const Agglomerates& a, const Model& model, const Recipe& recipe, Team& team, const Watch& watch,
         Sample& sample) {
  Sample parents;
  std::visit([&](const auto& p) { put(p, model, recipe, team, watch, parents); }, a.parents);
  std::vector<Sphere> whole;
  for (const Motion& m : parents.state.grains.motion) whole.push_back({m.position, m.radius});
  std::vector<Index> body;
  try {
    const std::vector<Sphere> spheres =
        spheres_in_spheres(whole, a.radius, a.solid_fraction, model.seed, team, watch, body);
    put_spheres(spheres, {{a.material}}, true, model, sample.state.grains);
  } catch (const InputError& e) {
    refuse(a.place, e.what());
  }
  put_rods(model, body, team, sample);
}

/// How much of the smaller one bodies may have in common: contacts of a packing under load, and no slip of a unit.
constexpr double most_common = 0.05;

void put(const Bodies& b, const Model& model, const Recipe& recipe, Team&, const Watch&, Sample& sample) {
  try {
    const Vec3 periodic = recipe.periodic() ? recipe.box : Vec3(Vec3::Zero());
    const SharedFaces shared = shared_faces(b.body, periodic, b.tolerance);
    if (const Overlaps& o = shared.overlap; o.share > most_common)
      throw InputError(fmt::format("bodies {} and {} have {:.2g} % of the smaller one in common, at most {:g} % may be",
                                   o.a + 1, o.b + 1, 100 * o.share, 100 * most_common));
    put_faces(add_bodies(model, b.body, b.middle, b.materials, shared, sample.state), sample);
    sample.notes.push_back(fmt::format("{} bodies share {} faces, of which {} are bonded", b.body.size(),
                                       shared.face.size(), sample.faces->bonds));
    if (shared.overlap.pairs > 0)
      sample.notes.push_back(
          fmt::format("{} pairs of bodies lie in one another, by {:.2g} % of the smaller one at most",
                      shared.overlap.pairs, 100 * shared.overlap.share));
  } catch (const InputError& e) {
    refuse(b.place, e.what());
  }
}

}  // namespace

void put_grains(const Model& model, const Recipe& recipe, Team& team, const Watch& watch, Sample& sample) {
  std::visit([&](const auto& grains) { put(grains, model, recipe, team, watch, sample); }, recipe.grains);
  if (!sample.faces && bonds_spheres(model)) put_rods(model, {}, team, sample);
}

}  // namespace grus::dem
