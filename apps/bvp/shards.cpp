// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/bvp/shards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>

#include "dem/base/error.hpp"
#include "dem/io/checkpoint.hpp"

namespace grus::app {
namespace {

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

[[noreturn]] void damaged(const std::string& path) {
  throw dem::InputError(path + ": checkpoint is damaged: elements and points of a shard");
}

/// One order for files and parcels.
void hand_over(const Shard& shard, const std::function<std::string(std::size_t)>& rve, const dem::TakePart& take) {
  take(packed(shard.elements)), take(packed(shard.macro));
  for (const auto& r : shard.regions) take(packed(r.points)), take(r.bytes);
  take(packed(shard.rves));
  for (std::size_t k = 0; k < shard.rves.size(); ++k) take(rve(k));
}

/// A part of as many bytes for each of `count` keys: those of the k-th.
std::string_view share(const std::string& bytes, std::size_t count, std::size_t k) {
  const std::size_t width = bytes.size() / count;
  return std::string_view(bytes).substr(k * width, width);
}

}  // namespace

std::string shard_file(char set, int rank) { return fmt::format("checkpoint/{}_{:05}.h5", set, rank); }

ShardFiller::Places ShardFiller::places(const std::vector<std::int64_t>& keys) {
  Places at;
  for (std::size_t k = 0; k < keys.size(); ++k) at.emplace(keys[k], k);
  return at;
}

ShardFiller::ShardFiller(Shard& shard, TakeRve rve)
    : shard_(shard), rve_(std::move(rve)), elements_(places(shard.elements)), rves_(places(shard.rves)) {
  missing_ = elements_.size() + rves_.size();
  for (const auto& r : shard.regions) regions_.push_back(places(r.points)), missing_ += regions_.back().size();
}

/// Copies what a parcel has, of equal size for each key, to where it is wanted.
void ShardFiller::deal(const std::string& from, const std::string& keys, const std::string& bytes, const Places& wanted,
                       std::string& into) {
  const auto of = unpacked<std::int64_t>(keys);
  if (of.empty()) return;
  if (bytes.size() % of.size() != 0) damaged(from);
  into.resize(wanted.size() * (bytes.size() / of.size()));
  for (std::size_t k = 0; k < of.size(); ++k)
    if (const auto at = wanted.find(of[k]); at != wanted.end()) {
      const std::string_view mine = share(bytes, of.size(), k);
      std::memcpy(into.data() + at->second * mine.size(), mine.data(), mine.size());
      --missing_;
    }
}

void ShardFiller::take(const std::string& from, const Parcel& parts) {
  const std::size_t head = 3 + 2 * regions_.size();
  if (parts.size() < head) damaged(from);
  deal(from, parts[0], parts[1], elements_, macro_);
  for (std::size_t r = 0; r < regions_.size(); ++r)
    deal(from, parts[2 + 2 * r], parts[3 + 2 * r], regions_[r], shard_.regions[r].bytes);
  const auto keys = unpacked<std::int64_t>(parts[head - 1]);
  if (parts.size() != head + keys.size()) damaged(from);
  for (std::size_t k = 0; k < keys.size(); ++k)
    if (const auto at = rves_.find(keys[k]); at != rves_.end()) rve_(at->second, parts[head + k]), --missing_;
}

void ShardFiller::end(const std::string& from) {
  if (missing_ != 0) damaged(from);
  shard_.macro = unpacked<double>(macro_);
  if (!std::all_of(shard_.macro.begin(), shard_.macro.end(), [](double x) { return std::isfinite(x); })) damaged(from);
}

void write_shard(const std::string& path, const Shard& shard, const std::function<std::string(std::size_t)>& rve) {
  dem::write_checkpoint(path, R"({"program":"grus-bvp shard"})",
                        [&](const dem::TakePart& take) { hand_over(shard, rve, take); });
}

void read_shards(const std::string& folder, char set, const std::vector<std::int32_t>& owners, Shard& shard,
                 const ShardFiller::TakeRve& rve) {
  ShardFiller filler(shard, rve);
  std::set<std::int32_t> files;
  for (const std::int64_t e : shard.elements) {
    if (e < 0 || static_cast<std::size_t>(e) >= owners.size()) damaged(folder + "/checkpoint.h5");
    files.insert(owners[static_cast<std::size_t>(e)]);
  }
  for (const std::int32_t file : files) {
    const std::string path = folder + "/" + shard_file(set, file);
    filler.take(path, dem::read_checkpoint(path).parts);
  }
  filler.end(folder + "/checkpoint");
}

std::vector<Parcel> parcels(const Shard& shard, const std::vector<std::int32_t>& owners, int ranks,
                            int points_per_element, const std::function<std::string(std::size_t)>& rve) {
  std::vector<Shard> to(static_cast<std::size_t>(ranks));
  std::vector<std::string> macro(to.size());
  const auto rank_of = [&](std::int64_t element) {
    return static_cast<std::size_t>(owners.at(static_cast<std::size_t>(element)));
  };
  const std::string all = packed(shard.macro);
  for (std::size_t k = 0; k < shard.elements.size(); ++k) {
    const std::size_t r = rank_of(shard.elements[k]);
    to[r].elements.push_back(shard.elements[k]), macro[r] += share(all, shard.elements.size(), k);
  }
  for (std::size_t r = 0; r < to.size(); ++r)
    to[r].macro = unpacked<double>(macro[r]), to[r].regions.resize(shard.regions.size());
  for (std::size_t g = 0; g < shard.regions.size(); ++g) {
    const auto& [points, bytes] = shard.regions[g];
    for (std::size_t k = 0; k < points.size(); ++k) {
      Shard::Region& part = to[rank_of(points[k] / points_per_element)].regions[g];
      part.points.push_back(points[k]), part.bytes += share(bytes, points.size(), k);
    }
  }
  std::vector<std::vector<std::size_t>> places(to.size());  // of the points with grains, here
  for (std::size_t k = 0; k < shard.rves.size(); ++k) {
    const std::size_t r = rank_of(shard.rves[k] / points_per_element);
    to[r].rves.push_back(shard.rves[k]), places[r].push_back(k);
  }
  std::vector<Parcel> made(to.size());
  for (std::size_t r = 0; r < to.size(); ++r)
    hand_over(
        to[r], [&](std::size_t k) { return rve(places[r][k]); },
        [&](const std::string& part) { made[r].push_back(part); });
  return made;
}

}  // namespace grus::app
