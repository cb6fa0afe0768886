// SPDX-License-Identifier: LGPL-3.0-or-later
// Reader of ASCII Gmsh files, formats 2.2 and 4.1.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "fem/cell_shape.hpp"
#include "fem/mesh.hpp"

namespace grus::fem {
namespace {

struct ElementType {
  int code, dimension, nodes;
  const char* name;
};

constexpr ElementType first_order[] = {{15, 0, 1, "point"},        {1, 1, 2, "line"},        {2, 2, 3, "triangle"},
                                       {3, 2, 4, "quadrilateral"}, {4, 3, 4, "tetrahedron"}, {5, 3, 8, "hexahedron"}};

struct Element {
  const ElementType* type;
  int tag;
  std::vector<std::int64_t> nodes;
  long long number;
};

class Reader {
public:
  explicit Reader(const std::string& path) : path_(path), in_(path) {
    if (!in_ || !std::filesystem::is_regular_file(path)) throw std::invalid_argument(path + ": no such mesh file");
    size_ = std::filesystem::file_size(path);
  }

  MshMesh read() {
    std::string word;
    while (in_ >> word) {
      section_ = word;
      if (word == "$MeshFormat")
        format();
      else if (word == "$PhysicalNames")
        names();
      else if (word == "$Entities")
        entities();
      else if (word == "$Nodes")
        version_ < 4 ? nodes2() : nodes4();
      else if (word == "$Elements")
        version_ < 4 ? elements2() : elements4();
      else if (word.size() > 1 && word[0] == '$')
        skip();
      else
        section_.clear(), fail("expected a section that begins with $: not an ASCII Gmsh file, or damaged");
    }
    section_.clear();
    return mesh();
  }

private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument(path_ + ": " + (section_.empty() ? "" : section_ + ": ") + what);
  }

  template <class T>
  T next() {
    T v;
    if (!(in_ >> v)) fail("cut short, or not a number");
    return v;
  }

  std::size_t count() {
    const auto n = next<long long>();
    if (n < 0 || static_cast<std::uintmax_t>(n) > size_ / 2)
      fail("count " + std::to_string(n) + " is more than the file can hold");
    return static_cast<std::size_t>(n);
  }

  void end() {
    if (next<std::string>() != "$End" + section_.substr(1))
      fail("expected $End" + section_.substr(1) + ": more or fewer entries than it says");
  }

  void skip() {
    const std::string stop = "$End" + section_.substr(1);
    std::string word;
    while (in_ >> word)
      if (word == stop) return;
    fail("cut short");
  }

  void format() {
    version_ = next<double>();
    if (next<int>() != 0) fail("binary files are not read; save as ASCII (gmsh -format msh22 or msh4)");
    if (version_ != 2.2 && version_ != 4.1)
      fail("format " + std::to_string(version_).substr(0, 3) + " is not read; save as 2.2 or 4.1");
    next<int>();
    end();
  }

  void names() {
    for (std::size_t n = count(); n > 0; --n) {
      const int dimension = next<int>(), tag = next<int>();
      std::string name;
      if (!std::getline(in_, name)) fail("cut short");
      const auto first = name.find('"'), last = name.rfind('"');
      if (first == last) fail("a name without quotes");
      names_[{dimension, name.substr(first + 1, last - first - 1)}] = tag;
    }
    end();
  }

  void entities() {
    const std::size_t counts[4] = {count(), count(), count(), count()};
    for (int d = 0; d < 4; ++d)
      for (std::size_t i = 0; i < counts[d]; ++i) {
        const int tag = next<int>();
        for (int k = 0; k < (d == 0 ? 3 : 6); ++k) next<double>();
        for (std::size_t n = count(), k = 0; k < n; ++k) {
          const int physical = next<int>();
          if (k == 0)
            physical_[{d, tag}] = physical;
          else
            fail("an entity is in two physical groups of one dimension");
        }
        if (d > 0)
          for (std::size_t n = count(); n > 0; --n) next<int>();
      }
    end();
  }

  void node(long long number, const Point& at) {
    if (!index_.emplace(number, static_cast<std::int64_t>(nodes_.size())).second)
      fail("node " + std::to_string(number) + " appears twice");
    nodes_.push_back(at);
  }

  void nodes2() {
    for (std::size_t n = count(); n > 0; --n) {
      const auto number = next<long long>();
      const double x = next<double>(), y = next<double>(), z = next<double>();
      node(number, {x, y, z});
    }
    end();
  }

  void nodes4() {
    const std::size_t blocks = count();
    for (int k = 0; k < 3; ++k) next<long long>();
    for (std::size_t b = 0; b < blocks; ++b) {
      next<int>(), next<int>();
      if (next<int>() != 0) fail("parametric nodes are not read");
      std::vector<long long> numbers(count());
      for (auto& v : numbers) v = next<long long>();
      for (const auto number : numbers) {
        const double x = next<double>(), y = next<double>(), z = next<double>();
        node(number, {x, y, z});
      }
    }
    end();
  }

  const ElementType& type(int code) const {
    for (const auto& t : first_order)
      if (t.code == code) return t;
    fail("element type " + std::to_string(code) +
         " is not read; mesh with first-order lines, triangles, quadrilaterals, tetrahedra or hexahedra");
  }

  void element(long long number, int code, int tag) {
    Element e{&type(code), tag, {}, number};
    for (int k = 0; k < e.type->nodes; ++k) {
      const auto node = next<long long>();
      const auto at = index_.find(node);
      if (at == index_.end()) fail("an element names node " + std::to_string(node) + ", which is not there");
      e.nodes.push_back(at->second);
    }
    elements_.push_back(std::move(e));
  }

  void elements2() {
    for (std::size_t n = count(); n > 0; --n) {
      const auto number = next<long long>();
      const int code = next<int>();
      int tag = 0;
      for (std::size_t tags = count(), k = 0; k < tags; ++k) {
        const int v = next<int>();
        if (k == 0) tag = v;
      }
      element(number, code, tag);
    }
    end();
  }

  void elements4() {
    const std::size_t blocks = count();
    for (int k = 0; k < 3; ++k) next<long long>();
    for (std::size_t b = 0; b < blocks; ++b) {
      const int d = next<int>(), entity = next<int>(), code = next<int>();
      const auto physical = physical_.find({d, entity});
      for (std::size_t n = count(); n > 0; --n) {
        const auto number = next<long long>();
        element(number, code, physical == physical_.end() ? 0 : physical->second);
      }
    }
    end();
  }

  MshMesh mesh() {
    int top = 0;
    for (const auto& e : elements_) top = std::max(top, e.type->dimension);
    if (top < 2) fail("holds no triangles, quadrilaterals, tetrahedra or hexahedra");
    MshMesh m;
    const ElementType* kind = nullptr;
    std::vector<std::int64_t> used(nodes_.size(), -1);  // nodes of no cell are left out
    for (auto& e : elements_) {
      if (e.type->dimension != top) continue;
      if (kind && kind != e.type)
        fail(std::string("mixes ") + kind->name + " and " + e.type->name + " cells; one kind is needed");
      kind = e.type;
      for (auto& n : e.nodes) {
        auto& place = used[static_cast<std::size_t>(n)];
        if (place < 0)
          place = static_cast<std::int64_t>(m.nodes.size()), m.nodes.push_back(nodes_[static_cast<std::size_t>(n)]);
        m.cells.push_back(place);
      }
      m.cell_tags.push_back(e.tag);
    }
    m.kind = static_cast<CellKind>(kind->code - 2);  // 2 to 5: in the order of CellKind
    std::vector<Point> corner;
    for (const auto& e : elements_) {
      if (e.type->dimension != top) continue;
      corner.clear();
      for (const auto n : e.nodes) corner.push_back(nodes_[static_cast<std::size_t>(n)]);
      if (const std::string fault = cell_fault(m.kind, corner); !fault.empty())
        fail("element " + std::to_string(e.number) + " (" + e.type->name + ") " + fault);
    }
    if (top == 2)
      for (const auto& p : m.nodes)
        if (std::abs(p[2]) > 1e-9 * (std::abs(p[0]) + std::abs(p[1])))
          fail("a two-dimensional mesh must lie in the plane z = 0");
    for (const auto& e : elements_) {
      if (e.type->dimension != top - 1 || e.tag == 0) continue;
      std::vector<std::int64_t> key;
      for (const auto n : e.nodes) key.push_back(used[static_cast<std::size_t>(n)]);
      std::sort(key.begin(), key.end());
      m.facets[key].push_back(e.tag);
    }
    for (const auto& [key, tag] : names_) {
      if (key.first == top) m.cell_names[key.second] = tag;
      if (key.first == top - 1) m.facet_names[key.second] = tag;
    }
    return m;
  }

  std::string path_, section_;
  std::ifstream in_;
  std::uintmax_t size_ = 0;  // bytes: each number takes two at least
  double version_ = 0;
  std::map<std::pair<int, std::string>, int> names_;
  std::map<std::pair<int, int>, int> physical_;
  std::map<long long, std::int64_t> index_;
  std::vector<Point> nodes_;
  std::vector<Element> elements_;
};

}  // namespace

MshMesh read_msh(const std::string& path) { return Reader(path).read(); }

}  // namespace grus::fem
