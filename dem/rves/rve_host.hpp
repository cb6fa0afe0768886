// SPDX-License-Identifier: LGPL-3.0-or-later
// The host of one process: RVEs by slot number, on its threads.
#pragma once

#include <memory>
#include <optional>
#include <unordered_map>

#include "dem/base/clock.hpp"
#include "dem/base/parallel.hpp"
#include "dem/rve/linear_response.hpp"
#include "dem/rve/rve.hpp"
#include "dem/rves/host.hpp"

namespace grus::dem {

/// The remainder of grains that could not go on, which answers for them: their last stress and stiffness, carried
/// along.
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
  void put(std::uint64_t slot, const std::string& state, double cost);  // bytes of a HostedRve, which are checked
  void copy(std::uint64_t from, std::uint64_t to) { put(to, hosted(from)); }
  void drop(std::uint64_t slot) { slots_.erase(slot); }
  HostedRve hosted(std::uint64_t slot) const;
  std::string fetch(std::uint64_t slot) const { return hosted(slot).bytes(); }
  /// The committed state, whole; and any state of these RVEs.
  State state(std::uint64_t slot) const { return whole(slots_.at(slot).rve->committed()); }
  State whole(State state) const;
  /// Tasks of different slots, on all threads; a failure is told in the response. The calling thread asks the watch
  /// some times a second, within tasks as well; where it says so, all threads stop and Interrupted is thrown.
  std::vector<Outcome> advance(const std::vector<Task>& tasks, const Watch& watch = {}, std::vector<Outcome> room = {});
  std::vector<Facts> commit(const std::vector<std::uint64_t>& slots);  // gives back the room that their trials leave
  std::vector<Facts> facts(const std::vector<std::uint64_t>& slots) const;
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
  void commit_one(std::uint64_t slot);
  void give_back_holes();

  std::shared_ptr<const Model> model_;
  ResponseOptions options_;
  std::unordered_map<std::uint64_t, Slot> slots_;  // looked up for each point in each sweep
  std::vector<State> room_;                        // of each thread: the state that it has at hand
  std::vector<Slot*> asked_;                       // of the tasks at hand
  Team team_;
  Clock since_holes_;  // were last looked for
};
static_assert(Host<RveHost>);

}  // namespace grus::dem
