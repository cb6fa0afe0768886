// SPDX-License-Identifier: LGPL-3.0-or-later
// The checkpoint of a problem that is spread over ranks: a shard of each, and checkpoint.h5 as their index, written
// last.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
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

/// `rve(k)`: bytes of the k-th point with grains, asked in turn.
void write_shard(const std::string& path, const Shard& shard, const std::function<std::string(std::size_t)>& rve);

/// Fills macro state and regions of a shard that names its elements and points, from the files of a set in `folder`;
/// `owners`: of each element the number of its file. Hands over RVEs as they are found: the k-th, its bytes. One file
/// is held at a time. Throws InputError for files that are damaged, or not of these elements and points.
void read_shards(const std::string& folder, char set, const std::vector<std::int32_t>& owners, Shard& shard,
                 const std::function<void(std::size_t, const std::string&)>& rve);

}  // namespace grus::app
