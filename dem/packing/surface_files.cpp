// SPDX-License-Identifier: LGPL-3.0-or-later
// Lists of corners, STL, OBJ.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>

#include "dem/base/error.hpp"
#include "dem/base/text_file.hpp"
#include "dem/packing/surfaces.hpp"

namespace grus::dem {
namespace {

constexpr std::size_t most_facets = 20'000'000;

[[noreturn]] void fail(const std::string& path, int line, const std::string& why) {
  throw InputError(fmt::format("{}:{}: {}", path, line, why));
}

std::string in_lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

/// What is left of a line, without blanks at its ends.
std::string rest_of(std::istringstream& words) {
  std::string rest;
  std::getline(words >> std::ws, rest);
  while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\r' || rest.back() == '\t')) rest.pop_back();
  return rest;
}

const char* const by_ending = " (read as a list of corners: .tess, .stl, .obj and .ply are told by their ending)";

Vec3 read_point(std::istringstream& words, const std::string& path, int line, const char* hint = "") {
  Vec3 x;
  if (!(words >> x[0] >> x[1] >> x[2]) || !x.allFinite())
    fail(path, line, fmt::format("expected three numbers x y z{}", hint));
  return x;
}

/// Corners one a line, bodies parted by blank lines; a line "group NAME" is of the bodies that follow.
std::vector<Surface> read_lists(std::istream& in, const std::string& path) {
  std::vector<Surface> bodies;
  std::vector<std::string> group;
  Surface now;
  int first = 0, number = 0;
  const auto close = [&] {
    if (now.corner.empty()) return;
    now.name = fmt::format("{}:{}", path, first), now.group = group;
    bodies.push_back(std::move(now));
    now = {};
  };
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::string told = line.substr(0, line.find('#'));
    std::istringstream words(told);
    std::string word;
    if (!(words >> word)) {
      if (told.size() == line.size()) close();  // a comment is no blank line
      continue;
    }
    if (word == "group") {
      close();
      group = {rest_of(words)};
      continue;
    }
    if (now.corner.empty()) first = number;
    words = std::istringstream(told);
    now.corner.push_back(read_point(words, path, number, by_ending));
    if (!rest_of(words).empty())
      fail(path, number, fmt::format("expected three numbers x y z, and no more{}", by_ending));
  }
  close();
  return bodies;
}

void append_parts(const Surface& whole, std::vector<Surface>& bodies) {
  if (whole.face.empty()) return;
  for (Surface& part : parts_of(whole)) bodies.push_back(std::move(part));
}

/// Little-endian bytes, as STL has them on any machine.
template <class T>
T little(const char* from) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), from, sizeof(T));
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

constexpr std::size_t stl_head = 84, stl_facet = 50;

std::vector<Surface> read_binary_stl(const std::string& bytes, const std::string& path) {
  Surface whole{.name = path};
  for (std::size_t at = stl_head; at + stl_facet <= bytes.size(); at += stl_facet) {
    const int first = static_cast<int>(whole.corner.size());
    for (std::size_t k = 3; k < 12; k += 3) {
      Vec3 x;
      for (std::size_t m = 0; m < 3; ++m)
        x[static_cast<Eigen::Index>(m)] = static_cast<double>(little<float>(&bytes[at + 4 * (k + m)]));
      if (!x.allFinite()) throw InputError(path + ": a corner of a facet is no number");
      whole.corner.push_back(x);
    }
    whole.face.push_back({first, first + 1, first + 2});
  }
  std::vector<Surface> bodies;
  append_parts(whole, bodies);
  return bodies;
}

std::vector<Surface> read_stl(std::istream& in, const std::string& path) {
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.size() >= stl_head) {
    const std::size_t facets = little<std::uint32_t>(&bytes[80]);
    if (facets <= most_facets && bytes.size() == stl_head + stl_facet * facets) return read_binary_stl(bytes, path);
  }
  std::istringstream text(bytes);
  std::vector<Surface> bodies;
  Surface now;
  int number = 0;
  bool begun = false;
  for (std::string line; std::getline(text, line);) {
    ++number;
    std::istringstream words(line);
    std::string word;
    if (!(words >> word)) continue;
    word = in_lower_case(word);
    if (!begun && word != "solid")
      fail(path, number, "is no STL file: expected \"solid\", or as many facets as it says");
    if (word == "solid") {
      begun = true;
      const std::string name = rest_of(words);
      now = {.group = {name}, .name = fmt::format("{}:{}: solid \"{}\"", path, number, name)};
    } else if (word == "vertex") {
      now.corner.push_back(read_point(words, path, number));
    } else if (word == "endfacet") {
      const int last = static_cast<int>(now.corner.size());
      const int seen = now.face.empty() ? 0 : now.face.back().back() + 1;
      if (last - seen != 3) fail(path, number, fmt::format("a facet of {} corners: expected three", last - seen));
      now.face.push_back({seen, seen + 1, seen + 2});
    } else if (word == "endsolid") {
      append_parts(now, bodies);
      now = {};
    }
  }
  if (!now.face.empty()) fail(path, number, "ends within a solid: \"endsolid\" is missing");
  return bodies;
}

/// Blocks of an OBJ file: what stands under one object, group and material.
std::vector<Surface> read_obj(std::istream& in, const std::string& path) {
  std::vector<Vec3> corners;
  std::vector<Surface> bodies;
  std::string object, group, material;
  std::vector<std::vector<int>> faces;
  int first = 0, number = 0;
  const auto close = [&] {
    Surface block{.name = fmt::format("{}:{}", path, first)};
    for (const std::string& name : {material, group, object})
      if (!name.empty()) block.group.push_back(name);
    if (!object.empty() || !group.empty()) block.name += fmt::format(": \"{}\"", object.empty() ? group : object);
    std::map<int, int> own;  // of the file's corners
    for (auto& loop : faces)
      for (int& v : loop) {
        const auto [found, fresh] = own.try_emplace(v, static_cast<int>(block.corner.size()));
        if (fresh) block.corner.push_back(corners[static_cast<std::size_t>(v)]);
        v = found->second;
      }
    block.face = std::move(faces);
    append_parts(block, bodies);
    faces.clear();
  };
  for (std::string line; std::getline(in, line);) {
    ++number;
    std::istringstream words(line);
    std::string word;
    if (!(words >> word)) continue;
    if (word == "v") {
      corners.push_back(read_point(words, path, number));
    } else if (word == "o" || word == "g" || word == "usemtl") {
      if (!faces.empty()) close();
      (word == "o" ? object : word == "g" ? group : material) = rest_of(words);
    } else if (word == "f") {
      if (faces.empty()) first = number;
      std::vector<int> loop;
      const long known = static_cast<long>(corners.size());
      for (std::string corner; words >> corner;) {
        const long told = std::strtol(corner.c_str(), nullptr, 10), at = told < 0 ? known + told : told - 1;
        if (at < 0 || at >= known)
          fail(path, number, fmt::format("\"{}\": there are {} corners so far", corner, known));
        loop.push_back(static_cast<int>(at));
      }
      if (loop.size() < 3) fail(path, number, "a face needs three corners");
      faces.push_back(std::move(loop));
    }
  }
  if (!faces.empty()) close();
  return bodies;
}

}  // namespace

std::vector<Surface> read_surfaces(const std::string& path) {
  const auto in = open_text(path);
  if (!in) throw InputError(fmt::format("{}: no such file", path));
  const auto ends = [&](const char* with) { return in_lower_case(path).ends_with(with); };
  std::vector<Surface> bodies;
  if (ends(".tess")) {
    bodies = read_tess(*in, path);
  } else if (ends(".stl")) {
    bodies = read_stl(*in, path);
  } else if (ends(".obj")) {
    bodies = read_obj(*in, path);
  } else if (ends(".ply")) {
    append_parts(read_ply(*in, path), bodies);
  } else {
    bodies = read_lists(*in, path);
  }
  if (bodies.empty()) throw InputError(fmt::format("{}: no bodies in it", path));
  return bodies;
}

}  // namespace grus::dem
