// SPDX-License-Identifier: LGPL-3.0-or-later
// Reader of ASCII Gmsh files, formats 2.2 and 4.1.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "fem/msh_contents.hpp"

namespace grus::fem {
namespace {

constexpr ElementType first_order[] = {{15, 0, 1, "point"},        {1, 1, 2, "line"},        {2, 2, 3, "triangle"},
                                       {3, 2, 4, "quadrilateral"}, {4, 3, 4, "tetrahedron"}, {5, 3, 8, "hexahedron"}};

constexpr long long most_tag = 1000000000;

class Reader {
public:
  explicit Reader(const std::string& path) : path_(path), in_(path) {
    file_.path = path;
    if (!in_ || !std::filesystem::is_regular_file(path)) throw std::invalid_argument(path + ": no such mesh file");
    size_ = std::filesystem::file_size(path);
  }

  MshContents read() {
    std::string word;
    while (in_ >> word) {
      if (section_.empty() && word.starts_with("\xEF\xBB\xBF")) word.erase(0, 3);  // a byte order mark
      section_ = word;
      if (version_ == 0 && (word == "$Nodes" || word == "$Elements"))
        fail("before $MeshFormat, which says how it is to be read");
      if (word == "$MeshFormat")
        format();
      else if (word == "$PhysicalNames")
        names();
      else if (word == "$Entities")
        entities(false);
      else if (word == "$PartitionedEntities")
        entities(true);
      else if (word == "$Nodes")
        version_ < 4 ? nodes2() : nodes4();
      else if (word == "$Elements")
        version_ < 4 ? elements2() : elements4();
      else if (word.size() > 1 && word[0] == '$')
        skip();
      else
        section_.clear(), fail("expected a section that begins with $: not an ASCII Gmsh file, or damaged");
    }
    return std::move(file_);
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

  /// Number of a physical group. A negative one says that the elements are turned over, which nothing here asks.
  int group() {
    const auto tag = next<long long>();
    if (tag < -most_tag || tag > most_tag)
      fail("physical group " + std::to_string(tag) + ": at most " + std::to_string(most_tag));
    return static_cast<int>(std::abs(tag));
  }

  void names() {
    for (std::size_t n = count(); n > 0; --n) {
      const int dimension = next<int>(), tag = group();
      std::string name;
      if (!std::getline(in_, name)) fail("cut short");
      const auto first = name.find('"'), last = name.rfind('"');
      if (first == last) fail("a name without quotes");
      auto& tags = file_.names[{dimension, name.substr(first + 1, last - first - 1)}];
      if (std::find(tags.begin(), tags.end(), tag) == tags.end()) tags.push_back(tag);
    }
    end();
  }

  /// Partitions cut entities into new ones, which say whose part they are; those of less dimension than what they are
  /// part of bound partitions, and are in no group of it.
  void entities(bool partitioned) {
    if (partitioned) {
      next<long long>();
      for (std::size_t n = count(); n > 0; --n) next<int>(), next<int>();
    }
    const std::size_t counts[4] = {count(), count(), count(), count()};
    for (int d = 0; d < 4; ++d)
      for (std::size_t i = 0; i < counts[d]; ++i) {
        const int tag = next<int>();
        bool counted = true;
        if (partitioned) {
          counted = next<int>() == d;
          next<int>();
          for (std::size_t n = count(); n > 0; --n) next<int>();
        }
        for (int k = 0; k < (d == 0 ? 3 : 6); ++k) next<double>();
        for (std::size_t n = count(); n > 0; --n) {
          const int physical = group();
          auto& groups = file_.groups[{d, tag}];
          if (counted && std::find(groups.begin(), groups.end(), physical) == groups.end()) groups.push_back(physical);
        }
        if (d > 0)
          for (std::size_t n = count(); n > 0; --n) next<int>();
      }
    end();
  }

  void node(long long number, const Point& at) {
    if (!file_.index.emplace(number, static_cast<std::int64_t>(file_.node.size())).second)
      fail("node " + std::to_string(number) + " appears twice");
    file_.number.push_back(number), file_.node.push_back(at);
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

  void element(long long number, const ElementType& of, int tag, int entity) {
    MshElement e{&of, number, tag, entity, {}};
    for (int k = 0; k < of.nodes; ++k) e.nodes.push_back(next<long long>());
    file_.element.push_back(std::move(e));
  }

  void elements2() {
    for (std::size_t n = count(); n > 0; --n) {
      const auto number = next<long long>();
      const ElementType& of = type(next<int>());
      int tag = 0;
      for (std::size_t tags = count(), k = 0; k < tags; ++k)
        if (k == 0)
          tag = group();
        else
          next<int>();
      element(number, of, tag, 0);
    }
    end();
  }

  void elements4() {
    const std::size_t blocks = count();
    for (int k = 0; k < 3; ++k) next<long long>();
    for (std::size_t b = 0; b < blocks; ++b) {
      const int dimension = next<int>(), entity = next<int>();
      const ElementType& of = type(next<int>());
      if (of.dimension != dimension)
        fail("an entity of dimension " + std::to_string(dimension) + " with a " + of.name + " in it");
      for (std::size_t n = count(); n > 0; --n) element(next<long long>(), of, 0, entity);
    }
    end();
  }

  std::string path_, section_;
  std::ifstream in_;
  std::uintmax_t size_ = 0;  // bytes: each number takes two at least
  double version_ = 0;
  MshContents file_;
};

}  // namespace

MshMesh read_msh(const std::string& path) { return mesh_of(Reader(path).read()); }

}  // namespace grus::fem
