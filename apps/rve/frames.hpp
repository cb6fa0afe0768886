// SPDX-License-Identifier: LGPL-3.0-or-later
// Pictures of the grains in the course of a run.
#pragma once

#include <fmt/format.h>

#include <utility>

#include "apps/run/command.hpp"
#include "apps/run/folder.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/io/frames.hpp"
#include "dem/io/vtkhdf.hpp"
#include "dem/rve/breakage.hpp"

namespace grus::app {

/// Grain surfaces at evenly spaced times, the first at the start; contact networks beside them if asked for.
class GrainFrames {
public:
  GrainFrames(const Options& options, const Output& output, double duration)
      : folder_(options.directory),
        count_(output.frames),
        every_(count_ > 1 ? duration / (count_ - 1) : duration),
        contacts_(output.contacts),
        wrapped_(output.wrapped) {}
  /// Files of frames and their times (s).
  using Series = std::vector<std::pair<std::string, double>>;
  const Series& series() const { return series_; }
  void restore(Series series) { series_ = std::move(series); }
  /// `at`: how far the test is, as a time of its duration (s).
  void write_if_due(const dem::State& state, double at) {
    if (static_cast<int>(series_.size()) < count_ && at >= every_ * static_cast<double>(series_.size()) * (1 - 1e-9))
      write(state);
  }
  /// The state in which a test ends before its time: the stress is reached, or it is unstable.
  void write_last(const dem::State& state) {
    if (static_cast<int>(series_.size()) < count_ && (series_.empty() || state.time > series_.back().second))
      write(state);
  }

private:
  static std::string frame(const char* what, std::size_t number) {
    return fmt::format("{0}/{0}_{1:05}.hdf", what, number);
  }
  void write(const dem::State& state) {
    const std::string name = frame("grains", series_.size());
    dem::write_grains(result_file(folder_, name), state, wrapped_);
    if (contacts_) dem::write_contacts(result_file(folder_, frame("contacts", series_.size())), state, wrapped_);
    const bool walls = dem::has_meshes(state);
    if (walls) dem::write_walls(result_file(folder_, frame("walls", series_.size())), state);
    series_.emplace_back(name, state.time);
    dem::write_series(result_file(folder_, "grains.hdf.series"), series_);
    if (contacts_) write_series_of("contacts");
    if (walls) write_series_of("walls");
  }
  void write_series_of(const char* what) const {
    Series of = series_;
    for (std::size_t k = 0; k < of.size(); ++k) of[k].first = frame(what, k);
    dem::write_series(result_file(folder_, fmt::format("{}.hdf.series", what)), of);
  }

  std::string folder_;
  int count_;
  double every_;
  bool contacts_, wrapped_;
  Series series_;
};

/// Grains that crack, point by point, the first ones of a run a frame each (output.lattice).
class CrackFrames {
public:
  CrackFrames(const Options& options, const Output& output) : folder_(options.directory), count_(output.lattice) {}
  const GrainFrames::Series& series() const { return series_; }
  void restore(GrainFrames::Series series) { series_ = std::move(series); }
  /// They are written later: a step is no place for a fault of the disk.
  void keep(const dem::State& state, std::span<const dem::Break> breaks) {
    for (const dem::Break& b : breaks)
      if (b.lattice && series_.size() + kept_.size() < count_)
        kept_.push_back(
            {state.time, state.grains.motion[b.grain].position, state.grains.orientation[b.grain], b.lattice});
  }
  void write_kept() {
    for (const dem::CrackedGrain& grain : std::exchange(kept_, {})) {
      const std::string name = fmt::format("lattice/lattice_{:05}.hdf", series_.size());
      dem::write_lattice(result_file(folder_, name), grain);
      series_.emplace_back(name, grain.time);
      dem::write_series(result_file(folder_, "lattice.hdf.series"), series_);
    }
  }

private:
  std::string folder_;
  std::size_t count_;
  GrainFrames::Series series_;
  std::vector<dem::CrackedGrain> kept_;
};

}  // namespace grus::app
