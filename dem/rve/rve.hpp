// SPDX-License-Identifier: LGPL-3.0-or-later
// The representative volume element of one Gauss point: a periodic cell of grains, committed and trial.
#pragma once

#include <functional>
#include <memory>

#include "dem/rve/model.hpp"
#include "dem/rve/response.hpp"
#include "dem/rve/state.hpp"

namespace grus::dem {

/// Since the last commit. F maps the committed configuration to the new one: det > 0.
struct Increment {
  Mat3 deformation = Mat3::Identity();
};

/// An RVE that is carried without rest (dem/rve/steady.hpp) keeps this besides its state.
struct Steady {
  Mat3 turn = Mat3::Identity();          // of the periodic cell since the start, which its state has not been given
  Mat3 stress = Mat3::Zero();            // when it last advanced, without dashpots, in the frame of the state (Pa)
  Mat3 viscous = Mat3::Zero();           // of the dashpots then (Pa)
  double work = 0, haste = 0;            // J, of its ledger then; work of the dashpots' stress
  double inertia = 0;                    // inertial number of 1/s at 1 Pa
  double reach = 0;                      // strain of recent increments: their largest, which fades
  std::uint64_t breakages = UINT64_MAX;  // when `inertia` was found; none: not yet
};

/// The contact-stiffness tangent of a response, and the time that it took.
void add_tangent(const Model& model, const State& state, Response& response);

/// Advances a state by an increment, quasi-statically. The deformation is F = R U: the cell is carried along U, with
/// constant rate in the fixed frame, then everything is turned by R (objective exactly). `told`: asked each 100 steps
/// or so, may throw.
Response deform(const Model& model, const QuasiStatic& options, State& state, const Increment& increment, Team& team,
                const std::function<void()>& told = {});

/// Holds the cell, or walls that stand, until the forces and the stress are at rest and no grain broke in the window.
/// `told`: asked after each window, may throw.
Response hold(const Model& model, const QuasiStatic& options, State& state, Team& team,
              const std::function<void()>& told = {});

/// The same in `pieces` equal parts of the path, each held, then turned. Stops at the first part that finds no rest.
Response deform_in_pieces(const Model& model, const QuasiStatic& options, State& state, const Increment& increment,
                          int pieces, Team& team, const std::function<void()>& told = {});

class Rve {
public:
  /// `state` must be prepared. The model is shared by all RVEs of a scene.
  Rve(std::shared_ptr<const Model> model, QuasiStatic options, State state, const Steady& steady = {});

  /// Always starts from the committed state, which rests from then on, so a refused iteration leaves no trace. An
  /// increment that fails is taken once more in `retry_pieces` parts before it is refused; one that no cell can follow
  /// (not finite, det F <= 0, stretches beyond `most_stretch`, no room for the grains) is refused before a step is
  /// made. `trial`: room; the state that has been reached. `told`: as in `deform`.
  Response advance(const Increment& increment, State& trial, const std::function<void()>& told = {});
  Response advance(const Increment& increment) {
    State trial;
    return advance(increment, trial);
  }
  static constexpr int retry_pieces = 4;
  static constexpr double most_stretch = 10;  // of one increment, either way: a million steps

  /// Carries the committed state itself through real time (s); there is no trial. Throws Unstable.
  Response advance_in_time(const Mat3& deformation, double duration, bool tangent);

  /// Carries the committed state itself, quasi-statically by its rate alone; there is no trial. Throws Unstable.
  Response advance_steadily(const Mat3& deformation, bool tangent);

  /// The committed state, whole, into `room`.
  void wake(State& room) const;

  /// Makes the last advance the committed state. Throws std::logic_error without one that was stable.
  void commit();

  /// At rest (resting.hpp) once it has been asked to advance to equilibrium.
  const State& committed() const { return committed_; }
  const Steady& steady() const { return steady_; }

private:
  std::shared_ptr<const Model> model_;
  QuasiStatic options_;
  State committed_, next_;
  Steady steady_;
  bool fresh_ = false;
};

}  // namespace grus::dem
