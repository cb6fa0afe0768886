// SPDX-License-Identifier: LGPL-3.0-or-later
// A row of history.csv and what its columns are read of. Facts of several columns are found when the first of them
// asks.
#pragma once

#include "apps/rve/first_grains.hpp"
#include "apps/scene/rve_scene.hpp"
#include "dem/motion/inertia_by_step.hpp"
#include "dem/rve/critical_grain.hpp"
#include "dem/rve/grading.hpp"
#include "dem/rve/hand_over.hpp"
#include "dem/rve/measure.hpp"
#include "dem/sample/make.hpp"

namespace grus::app {

/// A value that is found once, when it is asked for.
template <class T>
class Once {
public:
  template <class F>
  const T& operator()(F&& find) {
    if (!value_) value_.emplace(find());
    return *value_;
  }

private:
  std::optional<T> value_;
};

class Row {
public:
  /// `initial_cell`: edges of a periodic cell in which the test began. What is given must outlive the row.
  Row(const RveScene& scene, const dem::Sample& sample, const FirstGrains& first_grains, const dem::State& state,
      const dem::Measurement& measured, const dem::Mat3& initial_cell);

  const RveScene& scene;
  const dem::State& first;  // as the sample was made, but for its grains
  const FirstGrains& first_grains;
  const dem::State& state;  // now
  const dem::Measurement& measured;
  const dem::Mat3 gradient;  // displacement gradient F - 1
  const dem::Mat3& initial_cell;

  const dem::Ledger& ledger() const { return state.ledger; }
  double pressure() const { return dem::mean_pressure(measured.stress); }
  dem::Mat3 strain() const { return 0.5 * (gradient + gradient.transpose()); }
  const dem::Mat3& sample_stress() const;

  const dem::Grading& grading() const;
  const dem::Zingg& zingg() const;
  const dem::Roundness& roundness() const;
  const dem::Fragments& fragments() const;
  const dem::AddedInertia& added() const;
  const dem::CriticalGrain& critical() const;
  const dem::Vec3& wall_force(std::size_t wall) const;  // N
  /// Of a plane along its normal, since the test began (m).
  double way(std::size_t wall) const {
    const dem::Wall& now = state.boundary.walls[wall];
    return now.facing().dot(now.point - first.boundary.walls[wall].point);
  }
  const std::array<double, 2>& face_stresses() const;      // Pa, of the fixed and of the moving face
  const dem::Mat3& gauged() const;                         // displacement gradient of the middle, between platens
  double load() const;                                     // N, of the gauge
  std::optional<std::size_t> grain(std::size_t id) const;  // where it is; none: it has broken

private:
  mutable Once<dem::Grading> grading_;
  mutable Once<dem::Zingg> zingg_;
  mutable Once<dem::Roundness> roundness_;
  mutable Once<dem::Fragments> fragments_;
  mutable Once<dem::AddedInertia> added_;
  mutable Once<dem::CriticalGrain> critical_;
  mutable Once<std::vector<dem::Vec3>> wall_forces_;
  mutable Once<std::array<double, 2>> faces_;
  mutable Once<dem::Mat3> gauged_;
  mutable Once<double> load_;
  mutable Once<std::vector<std::optional<std::size_t>>> grains_;
};

/// Listed grains whose motion a history tells, at most.
inline constexpr std::size_t most_listed = 16;
inline std::size_t listed_of(const RveScene& scene) { return std::min(scene.listed_grains(), most_listed); }

}  // namespace grus::app
