// SPDX-License-Identifier: LGPL-3.0-or-later
// The RVEs that live on one rank, by slot number, and what can be asked of them.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "dem/base/parallel.hpp"
#include "dem/base/watch.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/rve.hpp"

namespace grus::dem {

enum class TangentKind {
  automatic,          // contact stiffness; the network where Newton stalls with it
  contact_stiffness,  // elastic contacts, sliding ones without k_t
  network,            // the contact network with grains free to move: relaxed, sliding contacts without k_t
  elastic,            // that of the first response, kept
  perturbation,       // from scratch copies
  quasi_newton        // Broyden's update from iteration to iteration and from increment to increment
};

/// How an RVE is taken through an increment.
enum class Pace : std::uint8_t {
  relaxed,    // to rest, from the committed state; may be refused
  real_time,  // in the time that the macro solver says; no way back
  steady      // by its own rate, without rest; no way back
};

/// What becomes of an RVE that cannot go on, where there is no way back.
enum class OnFailure : std::uint8_t { stop, elastic };

/// How responses are made; the same on all ranks.
struct ResponseOptions {
  QuasiStatic quasi_static;
  TangentKind tangent = TangentKind::automatic;
  double perturbation = 1e-4;  // strain of the scratch copies
  bool central = false;
  double elastic = -1;  // share of the contact forces that may leave the linear range of an elastic point; below 0: off
  OnFailure on_failure = OnFailure::stop;
};

/// One RVE to advance. Quasi-static: the path's increments are taken one after the other, all but the last committed.
/// At any other pace there is one increment; in real time it takes the duration (s).
struct Task {
  std::uint64_t slot = 0;
  std::vector<Mat3> path;
  double duration = 0;
  Pace pace = Pace::relaxed;
  bool tangent = true;
  bool sharp = false;  // the network's tangent
};

struct Outcome {
  Response response;
  double seconds = 0;     // wall time of the thread
  bool elastic = false;   // a linear response served; no DEM
  bool given_up = false;  // the grains can no more: what answers is what is left of their stiffness
  double elastic_error =
      -1;  // of an earlier linear answer, relative to the stress, now that the grains have caught up; below 0: none
};

/// What is known of a committed state where it does not live.
struct Facts {
  double energy_error = 0, mass = 0, lost_mass = 0, void_ratio = 0;
  double work = 0, unexplained = 0;  // J, of the ledger
  double haste = 0;                  // J, of the work: the price of the cell's own rate; steady cells
  double local_damping = 0;          // J, of what is dissipated: by a device
  double bond_damping = 0;           // J, the same: by the dashpots of face bonds
  double scaled_inertia = 0;         // J, put in at births
  std::uint64_t grains = 0, breakages = 0, steps = 0;
  std::uint64_t bonds = 0, bonds_broken = 0;  // of faces; where the material has such bonds

  using Number = double Facts::*;
  using Count = std::uint64_t Facts::*;
};

/// What answers instead of grains that could not go on: their last stress and stiffness, carried along.
struct Remainder {
  Mat3 stress = Mat3::Zero();   // Pa, in space
  Mat6 tangent = Mat6::Zero();  // Pa
  double volume = 0, work = 0;  // m^3, present; J since the start, the grains' included
};

/// An RVE, and the deformation that a linear response has answered for since its state.
struct HostedRve {
  State state;
  Mat3 pending = Mat3::Identity();
  bool barred = false;  // no linear response is to be looked for at this state
  Steady steady = {};
  std::optional<Remainder> remainder = {};
  std::optional<Facts> facts = {};  // of a state at rest, which does not tell them all
  std::string bytes() const;
  static HostedRve from(const std::string& bytes);  // throws InputError
};

class RveHost {
public:
  RveHost(std::shared_ptr<const Model> model, const ResponseOptions& options, int threads);

  /// Throws InputError for an RVE, of a file, that no run of this model can have left.
  void check(const HostedRve& rve) const;
  void put(std::uint64_t slot, HostedRve rve);
  void copy(std::uint64_t from, std::uint64_t to) { put(to, hosted(from)); }
  void drop(std::uint64_t slot) { slots_.erase(slot); }
  HostedRve hosted(std::uint64_t slot) const;
  /// The committed state, whole; and any state of these RVEs.
  State state(std::uint64_t slot) const { return whole(slots_.at(slot).rve->committed()); }
  State whole(State state) const;
  /// Tasks of different slots, on all threads; a failure is told in the response. The calling thread asks the watch
  /// some times a second, within tasks as well; where it says so, all threads stop and Interrupted is thrown.
  std::vector<Outcome> advance(const std::vector<Task>& tasks, const Watch& watch = {});
  void commit(std::uint64_t slot);
  void commit(const std::vector<std::uint64_t>& slots);  // and gives back the room that their trials have left
  Facts facts(std::uint64_t slot) const;

private:
  struct Slot {
    std::unique_ptr<Rve> rve;
    Mat3 pending = Mat3::Identity(), trial = Mat3::Identity();
    std::unique_ptr<const LinearResponse> linear;
    bool tried = false, by_linear = false;  // linear was looked for at this state; it gave the last answer
    std::optional<Remainder> remainder;
    std::optional<Facts> facts, trial_facts;  // of a committed state at rest; of the one that commit would take
  };
  Outcome go_on(Slot& slot, const Task& task) const;
  Outcome advance(Slot& slot, const Task& task, State& room, const std::function<void()>& told) const;
  bool elastic(Slot& slot, const Mat3& increment, Response& response, State& room) const;
  Response carry(Slot& slot, const Mat3& increment, State& room, const std::function<void()>& told) const;
  static void settle(Slot& slot);

  std::shared_ptr<const Model> model_;
  ResponseOptions options_;
  std::map<std::uint64_t, Slot> slots_;
  std::vector<State> room_;  // of each thread: the state that it has at hand
  Team team_;
};

}  // namespace grus::dem
