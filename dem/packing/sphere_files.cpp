// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/sphere_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>

#include "dem/base/error.hpp"
#include "dem/base/text_file.hpp"
#include "dem/contact/broad_phase.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {
namespace {

constexpr double deepest_start =
    0.5;  // overlap of two spheres, and with a wall, by radius: no sample begins with so much

/// Two spheres that lie in one another: their lines, and how deep, of the smaller radius.
struct Merged {
  int first, last;
  double depth;
};

/// Such two, if there are any; by their images too along the first `repeated` axes.
std::optional<Merged> merged(const Packing& p, const std::vector<int>& line, int repeated) {
  Grains places;
  double largest = 0;
  for (const auto& s : p.spheres) {
    places.motion.push_back({s.position, s.radius, Vec3::Zero(), 0, Vec3::Zero(), 0});
    largest = std::max(largest, s.radius);
  }
  Cell cell;
  for (int k = 0; k < 3 && repeated > 0; ++k) cell.vectors(k, k) = p.box[k] + (k < repeated ? 0 : 4 * largest);
  Team team(1);
  Candidates near;
  SearchRoom room;
  find_candidates(places, cell, 0, near, room, team);
  for (const Candidate& pair : near.pair) {
    const Motion &one = places.motion[pair.a], &other = places.motion[pair.b];
    const Vec3 between = other.position - one.position + at_image(cell.vectors, pair.image);
    const double depth = (one.radius + other.radius - between.norm()) / std::min(one.radius, other.radius);
    const auto [first, last] = std::minmax(line[pair.a], line[pair.b]);
    if (depth > deepest_start) return Merged{first, last, depth};
  }
  return {};
}

/// What stands in a column; `scaled`: a share of a dump's box.
struct SphereColumn {
  enum Kind : std::uint8_t { place, radius, diameter, group, other } kind = other;
  int axis = 0;
  bool scaled = false;
};

/// None: a name that nobody knows.
std::optional<SphereColumn> column_of(const std::string& name) {
  using C = SphereColumn;
  if (!name.empty() && name[0] >= 'x' && name[0] <= 'z') {
    const std::string rest = name.substr(1);
    if (rest.empty() || rest == "u" || rest == "s" || rest == "su")
      return C{C::place, name[0] - 'x', rest.starts_with('s')};
  }
  if (name == "r" || name == "radius") return C{C::radius};
  if (name == "d" || name == "diameter") return C{C::diameter};
  if (name == "material" || name == "type" || name == "matId") return C{C::group};
  if (name == "-") return C{};
  return {};
}

/// Reads the lines of a file one after the other.
struct SphereReader {
  const SphereFile& file;
  ReadSpheres read = {};
  std::vector<SphereColumn> columns = {};
  Vec3 low = Vec3::Zero();  // of a dump's box, in the file's unit
  int number = 0;

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}:{}: {}", file.path, number, why));
  }
  /// `strict`: names that nobody knows are refused.
  void take_columns(const std::vector<std::string>& names, bool strict) {
    columns.clear();
    std::array<int, 3> places{};
    int sizes = 0;
    for (const std::string& name : names) {
      const auto column = column_of(name);
      if (!column && strict)
        throw InputError(
            fmt::format("\"{}\" is no column: x, y, z, r or radius, d or diameter, material or type; \"-\" "
                        "for one that is left out",
                        name));
      columns.push_back(column.value_or(SphereColumn{}));
      if (columns.back().kind == SphereColumn::place) ++places[static_cast<std::size_t>(columns.back().axis)];
      sizes += columns.back().kind == SphereColumn::radius || columns.back().kind == SphereColumn::diameter;
    }
    if (places != std::array{1, 1, 1} || sizes != 1)
      throw InputError(fmt::format("{}: the columns {} are to name x, y, z and one of radius and diameter, each once",
                                   number > 0 ? fmt::format("{}:{}", file.path, number) : file.path,
                                   fmt::join(names, " ")));
  }
  double number_of(const std::string& word) const {
    char* end = nullptr;
    const double v = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(v)) fail("expected numbers");
    return v;
  }
  void take_box(const std::vector<std::string>& words) {
    for (std::size_t k = 0; k < 3; ++k)
      read.packing.box[static_cast<int>(k)] = k < words.size() ? number_of(words[k]) : 0;
    if (words.size() != 3 || !(read.packing.box.minCoeff() > 0)) fail("#box: expected three lengths above 0");
  }
  void take_row(const std::vector<std::string>& words) {
    if (words.size() != columns.size())
      fail(fmt::format("{} columns, expected {}{}", words.size(), columns.size(),
                       file.columns.empty() && columns.size() == 4 ? ": x y z r" : ""));
    Sphere s{Vec3::Zero(), 0};
    for (std::size_t k = 0; k < words.size(); ++k) {
      const SphereColumn& c = columns[k];
      if (c.kind == SphereColumn::group) read.group.push_back(words[k]);
      if (c.kind == SphereColumn::group || c.kind == SphereColumn::other) continue;
      const double v = number_of(words[k]);
      if (c.kind == SphereColumn::place)
        s.position[c.axis] = c.scaled ? low[c.axis] + v * read.packing.box[c.axis] : v;
      else
        s.radius = c.kind == SphereColumn::diameter ? 0.5 * v : v;
    }
    if (!(s.radius > 0)) fail("expected a radius above 0");
    read.packing.spheres.push_back(s);
    read.line.push_back(number);
  }
};

std::vector<std::string> words_of(std::string line) {
  for (char& c : line)
    if (c == ',' || c == ';' || c == '\t' || c == '\r') c = ' ';
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// The frames of a dump, of which the last stays.
void read_dump(std::istream& in, std::string line, SphereReader& reader) {
  ReadSpheres& read = reader.read;
  int bounds = 3;  // read of this frame
  bool rows = false;
  do {
    ++reader.number;
    const auto words = words_of(line);
    if (words.empty()) continue;
    if (words[0] != "ITEM:") {
      if (rows) {
        reader.take_row(words);
      } else if (bounds < 3) {
        if (words.size() < 2) reader.fail("expected the box's lower and upper end");
        if (words.size() > 2 && reader.number_of(words[2]) != 0)
          reader.fail("the box leans; that of a packing is upright");
        reader.low[bounds] = reader.number_of(words[0]);
        read.packing.box[bounds] = reader.number_of(words[1]) - reader.low[bounds];
        ++bounds;
      }
      continue;
    }
    rows = words.size() > 1 && words[1] == "ATOMS";
    if (words.size() > 1 && words[1] == "TIMESTEP") read = {};
    if (words.size() > 2 && words[1] == "BOX") bounds = 0;
    if (rows)
      reader.take_columns(
          reader.file.columns.empty() ? std::vector(words.begin() + 2, words.end()) : reader.file.columns,
          !reader.file.columns.empty());
  } while (std::getline(in, line));
  if (!(read.packing.box.minCoeff() > 0)) throw InputError(reader.file.path + ": the dump's box has no size");
  for (Sphere& s : read.packing.spheres) s.position -= reader.low;
}

void read_columns(std::istream& in, std::string line, SphereReader& reader) {
  const std::string yade = "#format";
  reader.take_columns(reader.file.columns.empty() ? std::vector<std::string>{"x", "y", "z", "r"} : reader.file.columns,
                      true);
  do {
    ++reader.number;
    if (line.starts_with(yade) && reader.file.columns.empty()) {
      std::string names = line.substr(yade.size());
      std::replace(names.begin(), names.end(), '_', ' ');
      auto told = words_of(names);
      std::erase(told, "attrs");  // what these are is told elsewhere
      reader.take_columns(told, false);
    }
    if (line.starts_with("#box")) reader.take_box(words_of(line.substr(4)));
    if (const auto words = words_of(line.substr(0, line.find('#'))); !words.empty()) reader.take_row(words);
  } while (std::getline(in, line));
}

}  // namespace

ReadSpheres read_spheres(const SphereFile& file) {
  const auto in = open_text(file.path);
  if (!in) throw InputError(fmt::format("{}: no such packing file", file.path));
  SphereReader reader{file};
  std::string line;
  std::getline(*in, line);
  (line.starts_with("ITEM:") ? read_dump : read_columns)(*in, line, reader);
  if (reader.read.packing.spheres.empty())
    throw InputError(fmt::format("{}: no spheres in the packing file", file.path));
  for (Sphere& s : reader.read.packing.spheres) s.position *= file.unit, s.radius *= file.unit;
  reader.read.packing.box *= file.unit;
  return std::move(reader.read);
}

void check_spheres(const ReadSpheres& read, const std::string& path, const Vec3& box, int first_walls) {
  Packing p = read.packing;
  p.box = box;
  const std::vector<int>& line = read.line;
  if (p.box.minCoeff() > 0)
    for (std::size_t k = 0; k < p.spheres.size(); ++k) {
      const auto& s = p.spheres[k];
      if (2 * s.radius > p.box.minCoeff())
        throw InputError(
            fmt::format("{}:{}: a sphere of radius {:g} m does not fit into the box of {:g} x {:g} x {:g} m: "
                        "is the file in metres?",
                        path, line[k], s.radius, p.box.x(), p.box.y(), p.box.z()));
      double near = INFINITY;
      for (int axis = first_walls; axis < 3; ++axis)
        near = std::min({near, s.position[axis], p.box[axis] - s.position[axis]});
      if (near < 0)
        throw InputError(fmt::format(
            "{}:{}: the centre {:g}, {:g}, {:g} m is outside of the box, 0 to {:g}, {:g}, {:g} m: "
            "is the file in metres?",
            path, line[k], s.position.x(), s.position.y(), s.position.z(), p.box.x(), p.box.y(), p.box.z()));
      if (near < (1 - deepest_start) * s.radius)
        throw InputError(
            fmt::format("{}:{}: this sphere of radius {:g} m sticks out of the box: its centre is {:g} m from a wall; "
                        "move it in or "
                        "make the box larger",
                        path, line[k], s.radius, near));
    }
  if (const auto two = merged(p, line, p.box.minCoeff() > 0 ? first_walls : 0))
    throw InputError(fmt::format(
        "{}:{}: this sphere and that of line {}{} overlap by {:.2g} of the smaller radius, beyond {:g}: leave "
        "one of them out; grains that have broken overlap as spheres, they go on by start = \"DIR\"",
        path, two->last, two->first, first_walls > 0 ? ", or an image of it," : "", two->depth, deepest_start));
}

}  // namespace grus::dem
