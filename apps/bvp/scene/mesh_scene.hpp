// SPDX-License-Identifier: LGPL-3.0-or-later
// Tables of a macro problem that speak of places: [mesh], [[boundary]], [[region]].
#pragma once

#include "apps/bvp/scene/bvp_scene.hpp"
#include "apps/scene/reader.hpp"

namespace grus::app {

void read_mesh(Table t, BvpScene& scene);
/// Notes where a mesh is so large, or so small beside the grains of its RVEs, that its unit is in doubt; of a scene
/// that has been read.
void note_size(BvpScene& scene);
void read_boundary(Table t, BvpScene& scene, const Dimension& time);
void read_region(Table t, BvpScene& scene);

/// "z=max", "x=min and y=0", "z>0.01": planes and half-spaces, joined by `and`; min and max are the mesh's extent.
/// Throws std::invalid_argument with what is wrong.
std::function<bool(const fem::Point&)> parse_where(const std::string& text, const fem::Point& low,
                                                   const fem::Point& high);

/// The key `where` of a table, which is refused with its place.
std::function<bool(const fem::Point&)> read_where(Table& t, const BvpScene& scene);

}  // namespace grus::app
