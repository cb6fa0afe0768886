// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/rve_host.hpp"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <new>

#include "dem/base/clock.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rve/check_state.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/resting.hpp"
#include "dem/rve/step.hpp"
#include "dem/rve/tangent.hpp"
#include "dem/rves/listener.hpp"
#include "dem/rves/prediction.hpp"

namespace grus::dem {

RveHost::RveHost(std::shared_ptr<const Model> model, const ResponseOptions& options, int threads)
    : model_(std::move(model)),
      options_(options),
      room_(static_cast<std::size_t>(std::max(threads, 1))),
      team_(threads) {}

std::string HostedRve::bytes() const {
  Saver a;
  walk(a, *this);
  return a.take();
}

HostedRve HostedRve::from(const std::string& bytes) {
  HostedRve rve;
  Loader a(bytes);
  walk(a, rve);
  if (!a.at_end()) throw InputError("checkpoint holds more than an RVE");
  make_again(rve.state);
  return rve;
}

namespace {

Facts facts_of(const Model& model, const State& s, double haste) {
  Facts f;
  f.energy_error = std::abs(told_energy_error(s, stored_energy(model, s)));
  f.work = s.ledger.work, f.haste = haste;
  f.local_damping = s.ledger.local_damping, f.bond_damping = s.ledger.bond_damping;
  f.scaled_inertia = s.ledger.inertia;
  f.unexplained = s.ledger.unexplained;
  f.lost_mass = s.ledger.fines.mass;
  f.mass = f.lost_mass + total_mass(s.grains);
  f.void_ratio = void_ratio(s);
  f.grains = s.grains.size();
  f.breakages = s.ledger.breakages;
  const auto& materials = model.materials;
  if (std::any_of(materials.begin(), materials.end(), [](const Material& m) { return m.bond.has_value(); }))
    f.bonds = s.bonds.face.row.size(), f.bonds_broken = s.ledger.bonds_broken;
  f.steps = s.steps;
  return f;
}

}  // namespace

State RveHost::whole(State state) const {
  Team alone(1);
  awaken(*model_, state, alone);
  return state;
}

void RveHost::check(const HostedRve& rve) const {
  const Steady& s = rve.steady;
  const bool good = rve.pending.allFinite() && rve.pending.determinant() > 0 && s.turn.allFinite() &&
                    s.stress.allFinite() && std::isfinite(s.work) && std::isfinite(s.haste) &&
                    (!rve.remainder || (rve.remainder->stress.allFinite() && rve.remainder->tangent.allFinite() &&
                                        rve.remainder->volume > 0 && std::isfinite(rve.remainder->work)));
  if (!good) throw InputError("checkpoint is damaged: an RVE");
  if (!rve.state.boundary.cell.periodic()) throw InputError("checkpoint is damaged: the cell");
  check_state(*model_, rve.state);
}

void RveHost::put(std::uint64_t slot, HostedRve hosted) {
  Slot& s = slots_[slot];
  s = {};
  s.rve = std::make_unique<Rve>(model_, options_.quasi_static, std::move(hosted.state), hosted.steady);
  s.pending = hosted.pending, s.remainder = hosted.remainder, s.facts = hosted.facts;
  s.tried = hosted.barred;
}

void RveHost::put(std::uint64_t slot, const std::string& state, double) {
  HostedRve rve = HostedRve::from(state);
  check(rve);
  put(slot, std::move(rve));
}

HostedRve RveHost::hosted(std::uint64_t slot) const {
  const Slot& s = slots_.at(slot);
  return {s.rve->committed(), s.pending, s.tried && !s.linear, s.rve->steady(), s.remainder, s.facts};
}

/// True where the grains need not be asked.
bool RveHost::elastic(Slot& s, const Mat3& increment, Response& response, State& room) const {
  if (!s.linear && !s.tried) {
    s.rve->wake(room);
    s.linear = linear_response(*model_, room, options_.elastic);
    s.tried = true;
  }
  if (!s.linear) return false;
  Mat3 r, u;
  s.trial = increment * s.pending;
  polar(s.trial, r, u);
  Vec6 strain = to_voigt(u - Mat3::Identity());
  strain.tail<3>() *= 2;
  if (!s.linear->holds(*model_, strain, options_.elastic)) return false;
  response.stress = r * (s.linear->stress + from_voigt(s.linear->tangent * strain)) * r.transpose();
  response.tangent = s.linear->tangent;
  response.stable = true;
  return true;
}

/// At a pace that knows no way back.
Outcome RveHost::go_on(Slot& s, const Task& task) const {
  Outcome out;
  const Mat3& increment = task.path.front();
  if (task.pace == Pace::real_time) {
    out.response = s.rve->advance_in_time(increment, task.duration, task.tangent);
    return out;
  }
  const Steady last = s.rve->steady();
  const double volume = s.rve->committed().boundary.cell.volume();
  if (!s.remainder) try {
      out.response = s.rve->advance_steadily(increment, task.tangent);
      return out;
    } catch (const Unstable&) {
      if (options_.on_failure == OnFailure::stop || last.breakages == UINT64_MAX) throw;
      const State& state = s.rve->committed();
      const Mat6 tangent = turned(contact_stiffness_tangent(*model_, state), last.turn);
      const Mat3 stress = last.turn * last.stress * last.turn.transpose();
      s.remainder = {stress, tangent.allFinite() ? tangent : Mat6::Zero(), volume, last.work};
    }
  Remainder& left = *s.remainder;
  const Mat3 before = left.stress;
  left.stress = predicted(before, left.tangent, increment);
  left.work += left.volume * (0.5 * (before + left.stress)).cwiseProduct(increment - Mat3::Identity()).sum();
  left.volume *= increment.determinant();
  out.response.stress = left.stress, out.response.tangent = left.tangent;
  out.response.work = left.work, out.response.haste = last.haste;
  out.response.stable = out.given_up = true;
  return out;
}

/// To equilibrium; the state comes to rest, and its facts are told while it is whole.
Response RveHost::carry(Slot& s, const Mat3& increment, State& room, const std::function<void()>& told) const {
  if (const State& whole = s.rve->committed(); !whole.resting)
    s.facts = facts_of(*model_, whole, s.rve->steady().haste);
  Response response = s.rve->advance({increment}, room, told);
  if (response.stable) s.trial_facts = facts_of(*model_, room, s.rve->steady().haste);
  return response;
}

/// What was carried becomes the committed state.
void RveHost::settle(Slot& s) {
  s.rve->commit();
  s.facts = s.trial_facts;
}

Outcome RveHost::advance(Slot& s, const Task& task, State& room, const std::function<void()>& told) const {
  Outcome out;
  s.by_linear = false;
  if (task.pace != Pace::relaxed) return go_on(s, task);
  std::uint64_t steps = 0;
  if (options_.elastic >= 0 && task.path.size() == 1) {
    if (elastic(s, task.path.front(), out.response, room)) {
      out.elastic = s.by_linear = true;
      return out;
    }
    if (s.pending != Mat3::Identity()) {  // the grains go to where the linear response has been
      Response guess;
      elastic(s, Mat3::Identity(), guess, room);
      Response caught_up = carry(s, s.pending, room, told);
      steps += caught_up.steps;
      if (!caught_up.stable) {
        out.response = std::move(caught_up);
        return out;
      }
      settle(s);
      out.elastic_error = (guess.stress - caught_up.stress).norm() /
                          std::max(caught_up.stress.norm(), std::sqrt(3.0) * options_.quasi_static.pressure_floor);
      s.pending.setIdentity();
    }
    s.linear.reset();
  }
  for (std::size_t i = 0; i < task.path.size(); ++i) {
    out.response = carry(s, task.path[i], room, told);
    steps += out.response.steps;
    if (!out.response.stable) break;
    if (i + 1 < task.path.size()) settle(s);
  }
  out.response.steps = steps;
  const Clock clock;
  if (task.sharp && out.response.stable) out.response.tangent = network_tangent(*model_, room);
  if (options_.tangent == TangentKind::perturbation && out.response.stable) {
    Team alone(1);
    out.response.tangent = perturbation_tangent(*model_, options_.quasi_static, room, options_.perturbation,
                                                options_.central, out.response.steps, alone, told);
  }
  out.response.tangent_seconds += clock.wall();
  return out;
}

/// Holes that states have left, where they are more than a quarter of what is in use, go back to the system. Once a
/// second: to look for them walks through all of them, and what is freed in between is slower to find again.
void RveHost::give_back_holes() {
#ifdef __GLIBC__
  if (since_holes_.wall() < 1) return;
  since_holes_ = Clock();
  const auto use = mallinfo2();
  if (use.fordblks > (std::size_t{4} << 20) && use.fordblks > use.uordblks / 4) malloc_trim(0);
#endif
}

std::vector<Outcome> RveHost::advance(const std::vector<Task>& tasks, const Watch& watch, std::vector<Outcome> room) {
  std::vector<Outcome> outcomes = std::move(room);
  outcomes.resize(tasks.size());
  asked_.clear();
  for (const Task& t : tasks) asked_.push_back(&slots_.at(t.slot));
  Listener listener(watch, tasks.size());
  std::atomic<std::size_t> next{0}, ended{0};
  std::atomic<bool> no_memory{false};
  const std::size_t loops = std::min(static_cast<std::size_t>(team_.threads()), tasks.size());
  team_.each(loops, [&](std::size_t, std::size_t rank) {
    for (std::size_t k = next++; k < tasks.size(); k = next++) {
      const Clock clock;
      try {
        listener.next_task();
        outcomes[k] = advance(*asked_[k], tasks[k], room_[rank], listener.told());
      } catch (const Interrupted&) {  // whoever is asked next hears of it as well
      } catch (const std::bad_alloc&) {
        no_memory = true;                  // of the machine, and not the grains' fault
      } catch (const std::exception& e) {  // must not leave a thread
        outcomes[k] = {};
        outcomes[k].response.failure = e.what();
      }
      outcomes[k].seconds = clock.wall();
      ++ended;
    }
    for (int spins = 0; listener.calling() && ended < tasks.size(); relax(spins)) listener.ask_at_times();
  });
  give_back_holes();
  if (no_memory) throw std::bad_alloc();
  if (listener.stopped()) throw Interrupted("interrupted while RVEs advanced; the committed states stand");
  return outcomes;
}

void RveHost::commit_one(std::uint64_t slot) {
  Slot& s = slots_.at(slot);
  if (s.by_linear) {
    s.pending = s.trial;
    return;
  }
  const std::size_t broken = s.rve->committed().ledger.breakages;
  settle(s);
  s.linear.reset();
  s.tried = s.rve->committed().ledger.breakages != broken;  // while grains break there is no elastic range to look for
}

std::vector<Facts> RveHost::commit(const std::vector<std::uint64_t>& slots) {
  for (const std::uint64_t slot : slots) commit_one(slot);
  give_back_holes();
  return facts(slots);
}

std::vector<Facts> RveHost::facts(const std::vector<std::uint64_t>& slots) const {
  std::vector<Facts> all;
  all.reserve(slots.size());
  for (const std::uint64_t slot : slots) all.push_back(facts(slot));
  return all;
}

Facts RveHost::facts(std::uint64_t slot) const {
  const Slot& s = slots_.at(slot);
  const State& state = s.rve->committed();
  const double haste = s.rve->steady().haste;
  Facts f = !state.resting ? facts_of(*model_, state, haste)
            : s.facts      ? *s.facts
                           : facts_of(*model_, this->state(slot), haste);
  if (s.remainder) f.work = s.remainder->work;
  return f;
}

}  // namespace grus::dem
