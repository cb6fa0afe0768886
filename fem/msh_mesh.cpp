// SPDX-License-Identifier: LGPL-3.0-or-later
// From what stands in a .msh file to elements, outer facets and their groups.
#include <algorithm>
#include <cmath>

#include "fem/cell_shape.hpp"
#include "fem/msh_contents.hpp"

namespace grus::fem {
namespace {

using Corners = std::array<std::int64_t, 8>;

/// Corners of each side, in Gmsh's order.
const std::vector<std::vector<std::size_t>>& sides_of_kind(CellKind kind) {
  static const std::vector<std::vector<std::size_t>> all[] = {
      {{0, 1}, {1, 2}, {2, 0}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
      {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}},
      {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 4, 5}, {1, 2, 5, 6}, {2, 3, 6, 7}, {0, 3, 4, 7}}};
  return all[static_cast<std::size_t>(kind)];
}

class Maker {
public:
  explicit Maker(const MshContents& file) : file_(file) {}

  MshMesh make() {
    for (const auto& e : file_.element) top_ = std::max(top_, e.type->dimension);
    if (top_ < 2) fail("holds no triangles, quadrilaterals, tetrahedra or hexahedra");
    for (const auto& e : file_.element)
      if (e.type->dimension == top_) check(e);
    take_cells();
    check_plane();
    sides_ = sides_of(mesh_);
    check_sides();
    take_facets();
    for (const auto& [key, tags] : file_.names) {
      if (key.first == top_) mesh_.cell_names[key.second] = tags;
      if (key.first == top_ - 1) mesh_.facet_names[key.second] = tags;
    }
    for (auto& note : openings(mesh_, sides_, number_)) mesh_.notes.push_back(std::move(note));
    return std::move(mesh_);
  }

private:
  [[noreturn]] void fail(const std::string& what) const { throw std::invalid_argument(file_.path + ": " + what); }

  std::string called(const MshElement& e) const { return "element " + std::to_string(e.number); }

  /// A physical group as its user knows it.
  std::string group(int dimension, int tag) const {
    if (tag == 0) return "no group";
    for (const auto& [key, tags] : file_.names)
      if (key.first == dimension && std::find(tags.begin(), tags.end(), tag) != tags.end())
        return '"' + key.second + '"';
    return std::to_string(tag);
  }

  std::vector<int> groups(const MshElement& e) const {
    if (e.tag != 0) return {e.tag};
    const auto at = file_.groups.find({e.type->dimension, e.entity});
    return e.entity == 0 || at == file_.groups.end() ? std::vector<int>{} : at->second;
  }

  /// Places of an element's nodes in the file.
  std::vector<std::int64_t> nodes(const MshElement& e) const {
    std::vector<std::int64_t> places;
    for (const auto number : e.nodes) {
      const auto at = file_.index.find(number);
      if (at == file_.index.end())
        fail(called(e) + " (" + e.type->name + ") names node " + std::to_string(number) + ", which is not there");
      places.push_back(at->second);
    }
    return places;
  }

  void check(const MshElement& e) {
    if (kind_ && kind_ != e.type)
      fail(std::string("mixes ") + kind_->name + " and " + e.type->name + " elements; one kind is needed");
    kind_ = e.type;
    mesh_.kind = static_cast<CellKind>(e.type->code - 2);  // 2 to 5: in the order of CellKind
    std::vector<Point> corner;
    for (const auto n : nodes(e)) corner.push_back(file_.node[static_cast<std::size_t>(n)]);
    if (const std::string fault = cell_fault(mesh_.kind, corner); !fault.empty())
      fail(called(e) + " (" + e.type->name + ") " + fault);
    if (const auto in = groups(e); in.size() > 1) in_two(called(e) + " is", in[0], in[1]);
  }

  [[noreturn]] void in_two(const std::string& cells, int a, int b) const {
    fail(cells + " in the physical groups " + group(top_, a) + " and " + group(top_, b) +
         "; an element belongs to one (leave it out of the other)");
  }

  /// Format 2.2 lists an element once for each of its groups.
  void take_cells() {
    used_.assign(file_.node.size(), -1);  // nodes of no element are left out
    std::map<Corners, std::pair<std::size_t, const MshElement*>> known;
    std::size_t twice = 0;
    for (const auto& e : file_.element) {
      if (e.type->dimension != top_) continue;
      const auto places = nodes(e);
      Corners key;
      key.fill(-1);
      std::copy(places.begin(), places.end(), key.begin());
      std::sort(key.begin(), key.end());
      const auto in = groups(e);
      const int tag = in.empty() ? 0 : in[0];
      const auto [at, fresh] = known.emplace(key, std::pair{mesh_.cell_tags.size(), &e});
      if (!fresh) {
        int& other = mesh_.cell_tags[at->second.first];
        if (other != 0 && tag != 0 && other != tag)
          in_two("elements " + std::to_string(at->second.second->number) + " and " + std::to_string(e.number) +
                     " are one element,",
                 other, tag);
        other = std::max(other, tag), ++twice;
        continue;
      }
      mesh_.cell_tags.push_back(tag);
      for (const auto n : places) {
        auto& place = used_[static_cast<std::size_t>(n)];
        if (place < 0) {
          place = static_cast<std::int64_t>(mesh_.nodes.size());
          mesh_.nodes.push_back(file_.node[static_cast<std::size_t>(n)]);
          number_.push_back(file_.number[static_cast<std::size_t>(n)]);
        }
        mesh_.cells.push_back(place);
      }
    }
    if (twice > 0)
      mesh_.notes.push_back(std::to_string(twice) + " of the elements stand in the file again; each is taken once");
  }

  void check_plane() const {
    if (top_ != 2) return;
    double size = 0;
    for (const auto& p : mesh_.nodes) size = std::max({size, std::abs(p[0]), std::abs(p[1])});
    for (const auto& p : mesh_.nodes)
      if (std::abs(p[2]) > 1e-9 * size) fail("a two-dimensional mesh must lie in the plane z = 0");
  }

  /// Elements that overlap in a fan would share a side.
  void check_sides() const {
    for (std::size_t k = 2; k < sides_.size(); ++k)
      if (sides_[k].corner == sides_[k - 2].corner) {
        std::string list;
        for (const auto n : sides_[k].corner)
          if (n >= 0) list.append(" ").append(std::to_string(number_[static_cast<std::size_t>(n)]));
        fail("more than two elements share the side with nodes" + list + ": they overlap");
      }
  }

  void take_facets() {
    std::map<int, std::array<std::size_t, 3>> found;  // of each group: outside, inside, of no element
    for (const auto& e : file_.element) {
      if (e.type->dimension != top_ - 1) continue;
      const auto in = groups(e);
      if (in.empty()) continue;
      std::vector<std::int64_t> key;
      for (const auto n : nodes(e)) key.push_back(used_[static_cast<std::size_t>(n)]);
      std::sort(key.begin(), key.end());
      CellSide side;
      std::copy(key.begin(), key.end(), side.corner.begin());
      const auto [first, last] = std::equal_range(sides_.begin(), sides_.end(), side,
                                                  [](const auto& a, const auto& b) { return a.corner < b.corner; });
      for (const int tag : in) ++found[tag][last - first == 1 ? 0 : last - first == 2 ? 1 : 2];
      auto& tags = mesh_.facets[key];
      for (const int tag : in)
        if (std::find(tags.begin(), tags.end(), tag) == tags.end()) tags.push_back(tag);
    }
    for (const auto& [tag, n] : found) {
      std::string text;
      if (n[1] > 0) text = std::to_string(n[1]) + " lie between two elements";
      if (n[2] > 0)
        text.append(text.empty() ? "" : ", ").append(std::to_string(n[2])).append(" are the side of no element");
      if (!text.empty())
        mesh_.idle_facets[tag] = "of the " + std::to_string(n[0] + n[1] + n[2]) + " elements of physical group " +
                                 group(top_ - 1, tag) + " " + text + ": nothing acts there";
    }
  }

  const MshContents& file_;
  int top_ = 0;
  const ElementType* kind_ = nullptr;
  MshMesh mesh_;
  std::vector<std::int64_t> used_;  // place in the mesh of each node of the file; -1: none
  std::vector<long long> number_;   // of the mesh's nodes
  std::vector<CellSide> sides_;
};

}  // namespace

std::vector<CellSide> sides_of(const MshMesh& mesh) {
  std::vector<CellSide> all;
  const auto width = static_cast<std::size_t>(corners(mesh.kind));
  for (std::size_t c = 0; c < mesh.cell_tags.size(); ++c)
    for (const auto& local : sides_of_kind(mesh.kind)) {
      CellSide& side = all.emplace_back();
      side.cell = c;
      for (std::size_t k = 0; k < local.size(); ++k) side.corner[k] = mesh.cells[width * c + local[k]];
      std::sort(side.corner.begin(), side.corner.begin() + static_cast<std::ptrdiff_t>(local.size()));
    }
  std::sort(all.begin(), all.end(), [](const CellSide& a, const CellSide& b) {
    return a.corner != b.corner ? a.corner < b.corner : a.cell < b.cell;
  });
  return all;
}

MshMesh mesh_of(const MshContents& contents) { return Maker(contents).make(); }

}  // namespace grus::fem
