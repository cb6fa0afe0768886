// SPDX-License-Identifier: LGPL-3.0-or-later
// Pictures of the grains in the course of a run.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/run.hpp"
#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"

namespace grus::app {

/// Grain surfaces at evenly spaced times, the first at the start.
class GrainFrames {
public:
  GrainFrames(const Options& options, int count, double duration)
      : folder_(options.directory), count_(count), every_(count > 1 ? duration / (count - 1) : duration) {
    if (count_ > 0) std::filesystem::create_directories(folder_ / "grains");
  }
  nlohmann::json series() const { return series_; }
  void restore(const nlohmann::json& series) { series_ = series.get<decltype(series_)>(); }
  void write_if_due(const dem::State& state) {
    if (static_cast<int>(series_.size()) >= count_ ||
        state.time < every_ * static_cast<double>(series_.size()) * (1 - 1e-9))
      return;
    const std::string name = fmt::format("grains/grains_{:05}.hdf", series_.size());
    dem::write_grains((folder_ / name).string(), state);
    series_.emplace_back(name, state.time);
    dem::write_series((folder_ / "grains.hdf.series").string(), series_);
  }

private:
  std::filesystem::path folder_;
  int count_;
  double every_;
  std::vector<std::pair<std::string, double>> series_;
};

}  // namespace grus::app
