// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/rves/rve_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "dem/base/checksum.hpp"
#include "dem/base/error.hpp"
#include "dem/io/archive.hpp"
#include "dem/rves/alike.hpp"
#include "dem/rves/driver.hpp"
#include "dem/rves/rve_host.hpp"

namespace grus::dem {

struct RveSet::Inside {
  RveHost host;
  Driver<RveHost> driver;
  std::uint64_t kin;   // of states that it takes: of the same scene, left out alike
  bool fresh = false;  // an advance that may be committed

  Inside(std::shared_ptr<const Model> model, const std::vector<State>& prepared, std::span<const std::size_t> start,
         const RveOptions& options, int threads, std::uint64_t number)
      : host(std::move(model), options.response, threads),
        driver(
            host, [&](std::size_t v) { return HostedRve{.state = prepared.at(v)}.bytes(); }, prepared.size(), start,
            options),
        kin(number ^ (options.error > 0 ? 1u : 0u) ^ (options.share > 0 ? 2u : 0u)) {}

  bool deferring() const { return driver.book().options.error > 0; }
  std::string sealed(const std::string& bytes) const;
  std::string opened(const std::string& bytes) const;
  void alone() const;
};

namespace {

RveOptions to_rest(RveOptions options) {
  options.pace = Pace::relaxed;
  return options;
}

const std::vector<State>& periodic(const std::vector<State>& prepared) {
  for (const State& s : prepared)
    if (!s.boundary.cell.periodic()) throw InputError("an RVE is a periodic cell: boundary.kind = \"periodic\"");
  return prepared;
}

}  // namespace

RveSet::RveSet(std::shared_ptr<const Model> model, const std::vector<State>& prepared,
               std::span<const std::size_t> start, const RveOptions& options, int threads, std::uint64_t kin)
    : in_(std::make_unique<Inside>(std::move(model), periodic(prepared), start, to_rest(options), threads, kin)) {}

RveSet::RveSet(std::shared_ptr<const Model> model, const std::vector<State>& prepared,
               std::span<const std::size_t> start, const ResponseOptions& options, int threads, std::uint64_t kin)
    : RveSet(std::move(model), prepared, start, RveOptions{.response = options}, threads, kin) {}

RveSet::RveSet(RveSet&&) noexcept = default;
RveSet& RveSet::operator=(RveSet&&) noexcept = default;
RveSet::~RveSet() = default;

std::size_t RveSet::size() const { return in_->driver.points(); }
std::size_t RveSet::distinct() const { return in_->driver.book().sharing.leader.size(); }
Facts RveSet::facts(std::size_t point) const { return in_->driver.facts(point); }
State RveSet::state(std::size_t point) const { return in_->host.state(in_->driver.slot(point)); }
const SweepReport& RveSet::report() const { return in_->driver.book().report; }

void RveSet::advance(std::span<const double> deformation, std::span<double> stress, std::span<double> tangent,
                     const Watch& watch) {
  const std::size_t n = size();
  if (deformation.size() != 9 * n || stress.size() != 6 * n || (!tangent.empty() && tangent.size() != 36 * n))
    throw InputError(fmt::format("{} points need 9, 6 and 36 (or no) numbers each; given {}, {} and {} in all", n,
                                 deformation.size(), stress.size(), tangent.size()));
  in_->fresh = false;
  for (std::size_t i = 0; i < n; ++i) {
    const Mat3 f = snapped(deformation.subspan(9 * i, 9));
    if (!f.allFinite()) throw InputError(fmt::format("deformation of point {}: not a finite number", i));
    if (f.determinant() <= 0)
      throw InputError(
          fmt::format("deformation of point {}: det F = {:.4g}; an increment has det F > 0, and is "
                      "F_new F_old^-1, not a strain",
                      i, f.determinant()));
  }
  Driver<RveHost>& driver = in_->driver;
  if (!driver.respond(deformation, 0, !tangent.empty(), watch)) throw Unstable(driver.book().reason);
  for (std::size_t i = 0; i < n; ++i) {
    const Answer& r = driver.answer(i);
    const Vec6 voigt = to_voigt(r.stress);
    std::copy_n(voigt.data(), 6, stress.data() + 6 * i);
    if (!tangent.empty()) Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(tangent.data() + 36 * i) = r.tangent;
  }
  in_->fresh = true;
}

const Response& RveSet::response(std::size_t point) const {
  if (!in_->fresh) throw std::logic_error("no advance since the last commit");
  return in_->driver.response(point);
}

void RveSet::commit() {
  if (!in_->fresh) throw std::logic_error("nothing to commit: advance comes first");
  in_->fresh = false;
  in_->driver.commit();
}

std::string RveSet::Inside::sealed(const std::string& bytes) const {
  Saver a;
  a.plain(kin);
  a.plain(checksum(bytes));
  return a.take() + bytes;
}

std::string RveSet::Inside::opened(const std::string& bytes) const {
  std::uint64_t theirs = 0, seal = 0;
  Loader a(bytes);
  a.plain(theirs), a.plain(seal);
  if (theirs != kin) throw InputError("state of another scene, other settings or another version");
  std::string inner = bytes.substr(sizeof theirs + sizeof seal);
  if (checksum(inner) != seal) throw InputError("state is damaged: its checksum does not match");
  return inner;
}

void RveSet::Inside::alone() const {
  if (driver.book().options.share > 0)
    throw InputError("with similar sharing a point is no state alone: save and load all of them");
}

std::string RveSet::bytes(std::size_t point) const {
  in_->alone();
  const std::uint64_t slot = in_->driver.slot(point);
  if (!in_->deferring()) return in_->sealed(in_->host.fetch(slot));
  Saver a;
  archive_memory(a, in_->driver.book().slots.at(slot).memory);
  a.text(in_->host.fetch(slot));
  return in_->sealed(a.take());
}

void RveSet::restore(std::size_t point, const std::string& bytes) {
  in_->alone();
  std::string state = in_->opened(bytes);
  Memory memory;
  if (in_->deferring()) {
    const std::string both = std::move(state);
    Loader a(both);
    archive_memory(a, memory);
    a.text(state);
  }
  in_->driver.replace(point, state, memory);
  in_->fresh = false;
}

void RveSet::save(const std::function<void(const std::string&)>& take) const {
  in_->driver.save([&](const std::string& part) { take(in_->sealed(part)); });
}

void RveSet::load(const std::vector<std::string>& parts) {
  if (parts.empty()) throw InputError("no states");
  const std::string book = in_->opened(parts[0]);
  std::vector<std::string> states;
  for (std::size_t k = 1; k < parts.size(); ++k) {  // all of them before any is dropped
    states.push_back(in_->opened(parts[k]));
    in_->host.check(HostedRve::from(states.back()));
  }
  try {
    in_->driver.load(book, states);
  } catch (const InputError& e) {
    throw InputError(fmt::format("states: {}", e.what()));
  }
  in_->fresh = false;
}

}  // namespace grus::dem
