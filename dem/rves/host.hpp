// SPDX-License-Identifier: LGPL-3.0-or-later
// Hosts: who carries RVEs, by slot number, through increments. What is asked of one, what it answers, and its verbs.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <vector>

#include "dem/base/watch.hpp"
#include "dem/rves/driver_options.hpp"

namespace grus::dem {

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

/// The seven verbs of a host; none of them names another slot's grains, so slots may live anywhere. Slots are numbers
/// that the caller gives; a state is bytes that only hosts of one model read.
///
///   put(slot, state, cost)  a new RVE, committed, or another state for one that is there. `cost`: what its advance is
///                           expected to take, in any unit; a hint for who shares out work. Throws InputError for bytes
///                           that are no state of this model; then the slot is as it was
///   copy(from, to)          what is committed at one slot, as a new one
///   drop(slot)              it will not be asked again
///   advance(tasks, watch)   tasks of different slots, all from their committed states; an outcome for each, in order.
///                           What fails is told in its response (`stable`, `failure`). Again before `commit`: from the
///                           committed states again, but at a pace that knows no way back. May ask the watch, and
///                           throw Interrupted where it says so: slots then stand where they were committed, those
///                           of a path of several increments somewhere on it
///   commit(slots)           their last advance becomes their committed state; the facts of each, in order. Throws
///                           std::logic_error where a slot has none that was stable
///   facts(slots)            of the committed states
///   fetch(slot)             bytes of the committed state, for `put`
///
/// The same tasks in the same order of calls give the same bits, however a host spreads them. A host of many ranks may
/// also tell `cost(slot)`, what a slot has cost of late, in the unit that it wants in `put`. A third argument of
/// advance, where a host takes one, is outcomes that nobody needs any more, to be filled anew.
template <class H>
concept Host = requires(H host, std::uint64_t slot, const std::string& state, const std::vector<std::uint64_t>& slots,
                        const std::vector<Task>& tasks, const Watch& watch) {
  host.put(slot, state, 1.0);
  host.copy(slot, slot);
  host.drop(slot);
  { host.advance(tasks, watch) } -> std::same_as<std::vector<Outcome>>;
  { host.commit(slots) } -> std::same_as<std::vector<Facts>>;
  { host.facts(slots) } -> std::same_as<std::vector<Facts>>;
  { host.fetch(slot) } -> std::same_as<std::string>;
};

}  // namespace grus::dem
