// SPDX-License-Identifier: LGPL-3.0-or-later
// Packings from files of other programs: [packing] kind = "polyhedra", and what such files share.
#pragma once

#include <map>

#include "apps/scene/rve_scene.hpp"

namespace grus::app {

/// Materials by what files call them: [[packing.group]].
class Groups {
public:
  Groups(Table& packing, const dem::Model& model, std::uint8_t otherwise);

  /// Of the first of these names that is one of a group; else that of the packing.
  std::uint8_t material(const std::vector<std::string>& names);
  /// The same, of a name that may be a material's own. None: it is neither.
  std::optional<std::uint8_t> material_or_none(const std::string& name);
  /// Refuses a group that nothing was of.
  void finish() const;

private:
  struct Group {
    std::uint8_t material;
    bool found;
    std::string place;
  };
  const dem::Model* model_;
  std::uint8_t otherwise_;
  std::map<std::string, Group> group_;
};

/// `unit` (m): the length that is 1 in the file.
double read_unit(Table& packing);

/// Points "x y z", one a line, in a unit. Throws InputError with file and line.
std::vector<dem::Vec3> read_points(const std::string& path, double unit);

/// The recipe's box is given, or found here.
void read_polyhedra(Table& packing, RveScene& scene, std::uint8_t material);

}  // namespace grus::app
