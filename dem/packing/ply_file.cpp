// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <sstream>

#include "dem/base/error.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::dem {
namespace {

enum class Form : std::uint8_t { text, little, big };

struct Property {
  std::string type, name;
  std::string count_type = {};  // of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> property = {};
};

struct Head {
  Form form = Form::text;
  std::vector<Element> element;
};

constexpr std::size_t most_items = 20'000'000, most_corners = 4096;

[[noreturn]] void fail(const std::string& path, const std::string& why) { throw InputError(path + ": " + why); }

/// At where the file has been read to: a line, of a text.
[[noreturn]] void fail_here(std::istream& in, Form form, const std::string& path, const std::string& why) {
  if (form != Form::text) fail(path, why);
  in.clear();
  const std::streamoff end = in.tellg();
  in.seekg(0);
  long line = 1;
  for (std::streamoff k = 0; k < end; ++k) line += in.get() == '\n';
  fail(fmt::format("{}:{}", path, line), why);
}

Head read_head(std::istream& in, const std::string& path) {
  Head head;
  std::string line, word;
  int number = 1;
  const auto fail_in = [&](const std::string& why) { fail(fmt::format("{}:{}", path, number), why); };
  if (!std::getline(in, line) || !line.starts_with("ply")) fail_in("is no PLY file: it does not begin with \"ply\"");
  while (++number, std::getline(in, line)) {
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "end_header") return head;
    if (word == "format") {
      words >> word;
      if (word != "ascii" && word != "binary_big_endian" && word != "binary_little_endian")
        fail_in(fmt::format("format \"{}\": must be ascii, binary_little_endian or binary_big_endian", word));
      head.form = word == "ascii" ? Form::text : word == "binary_big_endian" ? Form::big : Form::little;
    } else if (word == "element") {
      Element e;
      if (!(words >> e.name >> e.count) || e.count > most_items) fail_in(fmt::format("\"{}\": how many?", line));
      head.element.push_back(e);
    } else if (word == "property" && !head.element.empty()) {
      Property p;
      words >> p.type;
      if (p.type == "list") words >> p.count_type >> p.type;
      words >> p.name;
      head.element.back().property.push_back(p);
    }
  }
  fail(fmt::format("{}:{}", path, number - 1), "its header has no end");
}

template <class T>
double binary(std::istream& in, bool big) {
  std::array<char, sizeof(T)> bytes{};
  in.read(bytes.data(), sizeof(T));
  if (big != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

/// The types of numbers, by both of their names.
struct Type {
  const char *name, *by_bits;
  double (*read)(std::istream& in, bool big);
};
constexpr Type types[] = {{"float", "float32", binary<float>},      {"double", "float64", binary<double>},
                          {"char", "int8", binary<std::int8_t>},    {"uchar", "uint8", binary<std::uint8_t>},
                          {"short", "int16", binary<std::int16_t>}, {"ushort", "uint16", binary<std::uint16_t>},
                          {"int", "int32", binary<std::int32_t>},   {"uint", "uint32", binary<std::uint32_t>}};

double value(std::istream& in, Form form, const std::string& type, const std::string& path) {
  double v = 0;
  const bool big = form == Form::big;
  if (form == Form::text) {
    in >> v;
  } else {
    const auto found = std::find_if(std::begin(types), std::end(types),
                                    [&](const Type& t) { return type == t.name || type == t.by_bits; });
    if (found == std::end(types)) fail(path, fmt::format("\"{}\": no type of PLY files", type));
    v = found->read(in, big);
  }
  if (!in || !std::isfinite(v)) fail_here(in, form, path, "ends too early, or has what is no number");
  return v;
}

}  // namespace

Surface read_ply(std::istream& in, const std::string& path) {
  const Head head = read_head(in, path);
  Surface s{.name = path};
  for (const Element& e : head.element)
    for (std::size_t i = 0; i < e.count; ++i) {
      Vec3 x = Vec3::Constant(NAN);
      for (const Property& p : e.property) {
        const bool list = !p.count_type.empty();
        const double count = list ? value(in, head.form, p.count_type, path) : 1;
        if (!(count >= 0 && count <= most_corners))
          fail_here(in, head.form, path, fmt::format("a list of {:g}", count));
        std::vector<int> loop;
        for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
          const double v = value(in, head.form, p.type, path);
          if (list) loop.push_back(std::abs(v) < most_items ? static_cast<int>(v) : -1);
          if (e.name == "vertex" && !list && p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z')
            x[p.name[0] - 'x'] = v;
        }
        if (e.name == "face" && list && (p.name == "vertex_indices" || p.name == "vertex_index")) {
          if (loop.size() < 3) fail_here(in, head.form, path, "a face needs three corners");
          s.face.push_back(std::move(loop));
        }
      }
      if (e.name != "vertex") continue;
      if (!x.allFinite()) fail_here(in, head.form, path, "its vertices have no x, y and z");
      s.corner.push_back(x);
    }
  const int corners = static_cast<int>(s.corner.size());
  for (std::size_t f = 0; f < s.face.size(); ++f)
    for (const int v : s.face[f])
      if (v < 0 || v >= corners)
        fail(path, fmt::format("face {} names corner {}: there are {}, counted from 0", f + 1, v, corners));
  return s;
}

}  // namespace grus::dem
