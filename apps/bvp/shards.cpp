// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/shards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <unordered_map>

#include "dem/base/error.hpp"
#include "dem/io/checkpoint.hpp"

namespace grus::app {
namespace {

using Places = std::unordered_map<std::int64_t, std::size_t>;

template <class T>
std::string packed(const std::vector<T>& v) {
  return {reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T)};
}

template <class T>
std::vector<T> unpacked(const std::string& bytes) {
  std::vector<T> v(bytes.size() / sizeof(T));
  std::memcpy(v.data(), bytes.data(), v.size() * sizeof(T));
  return v;
}

Places places(const std::vector<std::int64_t>& keys) {
  Places at;
  for (std::size_t k = 0; k < keys.size(); ++k) at.emplace(keys[k], k);
  return at;
}

[[noreturn]] void damaged(const std::string& path) {
  throw dem::InputError(path + ": checkpoint is damaged: elements and points of a shard");
}

/// Copies what a file has, of equal size for each key, to where it is wanted; returns how many were.
std::size_t deal(const std::string& path, const std::vector<std::int64_t>& keys, const std::string& bytes,
                 const Places& wanted, std::string& into) {
  if (keys.empty()) return 0;
  const std::size_t width = bytes.size() / keys.size();
  if (width * keys.size() != bytes.size()) damaged(path);
  into.resize(wanted.size() * width);
  std::size_t found = 0;
  for (std::size_t k = 0; k < keys.size(); ++k)
    if (const auto at = wanted.find(keys[k]); at != wanted.end())
      std::memcpy(into.data() + at->second * width, bytes.data() + k * width, width), ++found;
  return found;
}

}  // namespace

std::string shard_file(char set, int rank) { return fmt::format("checkpoint/{}_{:05}.h5", set, rank); }

void write_shard(const std::string& path, const Shard& shard, const std::function<std::string(std::size_t)>& rve) {
  dem::write_checkpoint(path, R"({"program":"grus-bvp shard"})", [&](const dem::TakePart& take) {
    take(packed(shard.elements)), take(packed(shard.macro));
    for (const auto& r : shard.regions) take(packed(r.points)), take(r.bytes);
    take(packed(shard.rves));
    for (std::size_t k = 0; k < shard.rves.size(); ++k) take(rve(k));
  });
}

void read_shards(const std::string& folder, char set, const std::vector<std::int32_t>& owners, Shard& shard,
                 const std::function<void(std::size_t, const std::string&)>& rve) {
  const Places elements = places(shard.elements), rves = places(shard.rves);
  std::vector<Places> regions;
  for (const auto& r : shard.regions) regions.push_back(places(r.points));
  std::set<std::int32_t> files;
  for (const std::int64_t e : shard.elements) {
    if (e < 0 || static_cast<std::size_t>(e) >= owners.size()) damaged(folder + "/checkpoint.h5");
    files.insert(owners[static_cast<std::size_t>(e)]);
  }
  std::size_t missing = elements.size() + rves.size();
  for (const Places& r : regions) missing += r.size();
  std::string macro;
  for (const std::int32_t file : files) {
    const std::string path = folder + "/" + shard_file(set, file);
    const dem::Checkpoint kept = dem::read_checkpoint(path);
    const std::size_t head = 3 + 2 * regions.size();
    if (kept.parts.size() < head) damaged(path);
    missing -= deal(path, unpacked<std::int64_t>(kept.parts[0]), kept.parts[1], elements, macro);
    for (std::size_t r = 0; r < regions.size(); ++r)
      missing -= deal(path, unpacked<std::int64_t>(kept.parts[2 + 2 * r]), kept.parts[3 + 2 * r], regions[r],
                      shard.regions[r].bytes);
    const auto keys = unpacked<std::int64_t>(kept.parts[head - 1]);
    if (kept.parts.size() != head + keys.size()) damaged(path);
    for (std::size_t k = 0; k < keys.size(); ++k)
      if (const auto at = rves.find(keys[k]); at != rves.end()) rve(at->second, kept.parts[head + k]), --missing;
  }
  if (missing != 0) damaged(folder + "/checkpoint");
  shard.macro = unpacked<double>(macro);
  if (!std::all_of(shard.macro.begin(), shard.macro.end(), [](double x) { return std::isfinite(x); }))
    damaged(folder + "/checkpoint");
}

}  // namespace grus::app
