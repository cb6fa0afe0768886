// SPDX-License-Identifier: LGPL-3.0-or-later
// What each rank of a problem that is spread owns: in a checkpoint, of which checkpoint.h5 is the index, written last;
// and on its way to other ranks.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <vector>

namespace grus::app {

/// What a rank owns, by numbers that are the same on any number of ranks: of elements and of Gauss points.
struct Shard {
  struct Region {
    std::vector<std::int64_t> points;
    std::string bytes;  // of its material, as many for each point
  };
  std::vector<std::int64_t> elements;
  std::vector<double> macro;  // fem::Snapshot::values of these elements
  std::vector<Region> regions;
  std::vector<std::int64_t> rves;  // points with grains
};

/// Shards of one checkpoint lie in files of one set; the next one is written into those of the other.
std::string shard_file(char set, int rank);  // relative to the results folder

/// Parts of a shard: of its elements, its regions, and its points with grains one by one.
using Parcel = std::vector<std::string>;

/// Fills macro state and regions of a shard that names its elements and points, and hands over its RVEs as they are
/// found: the k-th, its bytes.
class ShardFiller {
public:
  using TakeRve = std::function<void(std::size_t, const std::string&)>;
  ShardFiller(Shard& shard, TakeRve rve);
  /// What is wanted of a parcel `from` somewhere. Throws InputError for one that is damaged.
  void take(const std::string& from, const Parcel& parcel);
  /// Throws InputError where something has come from nowhere, or is no number.
  void end(const std::string& from);

private:
  using Places = std::unordered_map<std::int64_t, std::size_t>;
  static Places places(const std::vector<std::int64_t>& keys);
  void deal(const std::string& from, const std::string& keys, const std::string& bytes, const Places& wanted,
            std::string& into);

  Shard& shard_;
  TakeRve rve_;
  Places elements_, rves_;
  std::vector<Places> regions_;
  std::string macro_;
  std::size_t missing_;
};

/// `rve(k)`: bytes of the k-th point with grains, asked in turn.
void write_shard(const std::string& path, const Shard& shard, const std::function<std::string(std::size_t)>& rve);

/// Fills a shard from the files of a set in `folder`; `owners`: of each element the number of its file. One file is
/// held at a time. Throws InputError for files that are damaged, or not of these elements and points.
void read_shards(const std::string& folder, char set, const std::vector<std::int32_t>& owners, Shard& shard,
                 const ShardFiller::TakeRve& rve);

/// What of a shard goes to each rank, by the new owners of the mesh's elements. `rve(k)` as above, each asked once.
std::vector<Parcel> parcels(const Shard& shard, const std::vector<std::int32_t>& owners, int ranks,
                            int points_per_element, const std::function<std::string(std::size_t)>& rve);

}  // namespace grus::app
