// SPDX-License-Identifier: LGPL-3.0-or-later
// Neper's tessellations, formats 2.0 and 3.x: cells, with their seeds, modes and groups, vertices, faces, polyhedra.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "dem/base/error.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::dem {
namespace {

constexpr long most_of_tess = 50'000'000;

/// Words of a file, and in which line each is.
struct Words {
  std::istream& in;
  const std::string& path;
  int line = 1;
  std::string ahead = {};

  [[noreturn]] void fail(const std::string& why) const { throw InputError(fmt::format("{}:{}: {}", path, line, why)); }

  /// The next word, which stays; empty at the end.
  const std::string& peek() {
    if (!ahead.empty()) return ahead;
    for (int c; (c = in.peek()) == ' ' || c == '\n' || c == '\r' || c == '\t'; in.get()) line += c == '\n';
    in >> ahead;
    return ahead;
  }
  std::string next() {
    peek();
    return std::exchange(ahead, {});
  }
  bool section() { return peek().empty() || peek().starts_with('*'); }
  double number() {
    const std::string word = next();
    char* end = nullptr;
    const double v = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(v)) fail(fmt::format("\"{}\": expected a number", word));
    return v;
  }
  long whole(long low, long high) {
    const double v = number();
    if (v != std::floor(v) || v < static_cast<double>(low) || v > static_cast<double>(high))
      fail(fmt::format("{:g}: expected a whole number from {} to {}", v, low, high));
    return static_cast<long>(v);
  }
  /// The entry of the number that stands next.
  template <class T>
  T& fresh(std::map<long, T>& all, const char* what) {
    const long id = whole(1, most_of_tess);
    const auto [at, is] = all.try_emplace(id);
    if (!is) fail(fmt::format("{} {} is there twice", what, id));
    return at->second;
  }
  void skip(long count) {
    for (long k = 0; k < count; ++k) next();
  }
  void skip_section() {
    while (!section()) next();
  }
};

/// By number, from 1: gaps may be in old files.
struct Tess {
  std::vector<Vec3> seed;
  std::vector<double> weight;
  std::vector<std::vector<std::string>> group;
  std::map<long, Vec3> vertex;
  std::map<long, std::vector<long>> face;
  std::map<long, std::vector<long>> polyhedron;
};

void read_cells(Words& w, Tess& t) {
  const auto cells = static_cast<std::size_t>(w.whole(0, most_of_tess));
  t.group.resize(cells);
  while (w.peek().starts_with('*') && !w.peek().starts_with("**")) {
    const std::string what = w.next();
    if (what == "*seed") {
      t.seed.clear(), t.weight.clear();
      for (std::size_t k = 0; k < cells; ++k) {
        if (const long id = w.whole(1, most_of_tess); id != static_cast<long>(k + 1))
          w.fail(fmt::format("the seed of cell {} stands where that of cell {} should: one line a cell, in turn", id,
                             k + 1));
        Vec3 x;
        for (double& v : x) v = w.number();
        t.seed.push_back(x), t.weight.push_back(w.number());
      }
    } else if (what == "*group" || what == "*mode") {
      for (auto& names : t.group) names.push_back(w.next());
    } else {
      w.skip_section();
    }
    if (!w.section())
      w.fail(fmt::format("{} has more than one entry for each of the {} cells: \"{}\"", what, cells, w.peek()));
  }
}

void read_faces(Words& w, Tess& t) {
  for (long n = w.whole(0, most_of_tess); n > 0; --n) {
    auto& loop = w.fresh(t.face, "face");
    loop.resize(static_cast<std::size_t>(w.whole(3, 10000)));
    for (long& v : loop) v = w.whole(1, most_of_tess);
    w.skip(w.whole(0, 10000));  // edges
    w.skip(4 + 5);              // plane; state and point
  }
}

Surface cell_of(const Tess& t, long id, const std::vector<long>& faces, const Words& w) {
  Surface s{.name = fmt::format("{}: cell {}", w.path, id)};
  const auto at = static_cast<std::size_t>(id - 1);
  if (at < t.group.size()) s.group = t.group[at];
  const auto [least, largest] = std::minmax_element(t.weight.begin(), t.weight.end());
  if (at < t.seed.size() && *least == *largest) s.seed = t.seed[at];
  std::map<long, int> own;
  for (const long f : faces) {
    const auto loop = t.face.find(std::abs(f));
    if (loop == t.face.end()) w.fail(fmt::format("cell {} has face {}, which is not there", id, std::abs(f)));
    auto& corners = s.face.emplace_back();
    for (const long v : loop->second) {
      const auto x = t.vertex.find(v);
      if (x == t.vertex.end()) w.fail(fmt::format("face {} has vertex {}, which is not there", std::abs(f), v));
      const auto [place, fresh] = own.try_emplace(v, static_cast<int>(s.corner.size()));
      if (fresh) s.corner.push_back(x->second);
      corners.push_back(place->second);
    }
  }
  return s;
}

}  // namespace

std::vector<Surface> read_tess(std::istream& in, const std::string& path) {
  Words w{in, path};
  if (w.next() != "***tess") w.fail("is no tessellation of Neper: it does not begin with \"***tess\"");
  Tess t;
  while (!w.peek().empty()) {
    const std::string what = w.next();
    if (what == "**general") {
      if (const long dimension = w.whole(1, 3); dimension != 3)
        w.fail(fmt::format("a tessellation of {} dimensions: bodies need 3", dimension));
    } else if (what == "**cell") {
      read_cells(w, t);
    } else if (what == "**vertex") {
      for (long n = w.whole(0, most_of_tess); n > 0; --n) {
        Vec3& x = w.fresh(t.vertex, "vertex");
        for (double& v : x) v = w.number();
        w.next();  // state
      }
    } else if (what == "**face") {
      read_faces(w, t);
    } else if (what == "**polyhedron") {
      for (long n = w.whole(0, most_of_tess); n > 0; --n) {
        auto& faces = w.fresh(t.polyhedron, "polyhedron");
        faces.resize(static_cast<std::size_t>(w.whole(4, 10000)));
        for (long& f : faces) f = w.whole(-most_of_tess, most_of_tess);
      }
    }
    w.skip_section();
  }
  std::vector<Surface> bodies;
  for (const auto& [id, faces] : t.polyhedron) bodies.push_back(cell_of(t, id, faces, w));
  return bodies;
}

}  // namespace grus::dem
