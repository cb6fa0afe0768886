// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <chrono>

#include "dem/io/archive.hpp"
#include "dem/rve/steady.hpp"
#include "fem/exact_sum.hpp"

namespace grus::coupling {

using dem::Facts;
using dem::HostedRve;

namespace {

/// Who goes with whom would depend on who is there.
RveOptions each_alone(RveOptions options, bool alone) {
  options.exact_sharing = options.exact_sharing && !alone;
  return options;
}

}  // namespace

RveMaterial::RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
                         const RveOptions& options, std::optional<MPI_Comm> spread, std::vector<std::int64_t> keys)
    : farm_(farm),
      driver_(
          farm, [&](std::size_t v) { return HostedRve{.state = states.at(v)}.bytes(); }, states.size(), start,
          each_alone(options, spread.has_value())),
      spread_(spread) {
  for (const auto& s : states) start_volume_.push_back(s.boundary.cell.volume());
  int rank = 0;
  if (spread_) MPI_Comm_rank(*spread_, &rank);
  if (spread_ && !relaxed(driver_.book())) steps_.assign(points(), 0);
  if (spread_)
    for (std::size_t i = 0; i < keys.size(); ++i) farm_.call_in_costs(driver_.slot(i), keys[i], rank);
  driver_.name_points(std::move(keys));
}

fem::Material RveMaterial::material() {
  auto packed = [this] {
    dem::Saver a;
    save([&](const std::string& part) { a.text(part); });
    return a.take();
  };
  auto unpacked = [this](const std::string& bytes) {
    std::vector<std::string> parts;
    for (dem::Loader a(bytes); !a.at_end();) a.text(parts.emplace_back());
    load(parts);
  };
  auto energy = [this](std::span<const double> volumes) {
    return total(&Facts::work, volumes) - total(&Facts::haste, volumes);
  };
  fem::Material m([this](const fem::Points& p) { return respond(p); }, [this] { commit(); }, packed, unpacked, energy);
  m.noise = [this] { return noise(); };
  m.sharpen = [this] { return driver_.sharpen(); };
  m.inertial_number = [this] { return report().inertial_number; };
  m.reason = [this] { return driver_.book().reason; };
  m.energies = [this](std::span<const double> volumes, std::span<double> energies) {
    if (held_.empty())
      for (std::size_t i = 0; i < points(); ++i) held_.push_back(facts(i).work - facts(i).haste);
    for (std::size_t i = 0; i < volumes.size(); ++i) energies[i] = held_[i] * volumes[i] / start_volume(i);
  };
  m.inertial_numbers = [this] { return std::span<const double>(inertial_numbers_); };
  return m;
}

double RveMaterial::noise() {
  if (!spread_) return driver_.noise();
  return driver_.noise([this](dem::Misses& sums) {
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, *spread_);
  });
}

double RveMaterial::total(Facts::Number energy, std::span<const double> volumes) const {
  const auto add = [&](auto& sums) {
    for (std::size_t i = 0; i < volumes.size(); ++i) sums[0] += facts(i).*energy * volumes[i] / start_volume(i);
  };
  if (spread_) return fem::sums_over_ranks<1>(*spread_, true, add)[0];
  std::array<double, 1> sum{};
  add(sum);
  return sum[0];
}

double RveMaterial::sum(const std::function<double(const Facts&)>& of) const {
  const auto add = [&](auto& sums) {
    for (std::size_t i = 0; i < points(); ++i) sums[0] += of(facts(i));
  };
  if (spread_) return fem::sums_over_ranks<1>(*spread_, true, add)[0];
  std::array<double, 1> sum{};
  add(sum);
  return sum[0];
}

double RveMaterial::largest(const std::function<double(const Facts&)>& of) const {
  double most = 0;
  for (std::size_t i = 0; i < points(); ++i) most = std::max(most, of(facts(i)));
  if (spread_) MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, *spread_);
  return most;
}

std::uint64_t RveMaterial::over_ranks(std::uint64_t mine) const {
  if (spread_) MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_UINT64_T, MPI_SUM, *spread_);
  return mine;
}

SweepReport RveMaterial::report_of_all() const {
  SweepReport all = report();
  if (!spread_) return all;
  for (std::uint64_t SweepReport::*count :
       {&SweepReport::asked, &SweepReport::advanced, &SweepReport::deferred, &SweepReport::elastic,
        &SweepReport::retried, &SweepReport::dem_steps, &SweepReport::distinct, &SweepReport::given_up})
    all.*count = over_ranks(all.*count);
  for (MeasuredError SweepReport::*measured : {&SweepReport::deferral, &SweepReport::linear}) {
    MeasuredError& e = all.*measured;
    e.count = over_ranks(e.count);
    MPI_Allreduce(MPI_IN_PLACE, &e.sum, 1, MPI_DOUBLE, MPI_SUM, *spread_);
    MPI_Allreduce(MPI_IN_PLACE, &e.worst, 1, MPI_DOUBLE, MPI_MAX, *spread_);
  }
  MPI_Allreduce(MPI_IN_PLACE, &all.least_trust, 1, MPI_DOUBLE, MPI_MIN, *spread_);
  for (double SweepReport::*most : {&SweepReport::worst_unbalanced, &SweepReport::worst_stress_change})
    MPI_Allreduce(MPI_IN_PLACE, &(all.*most), 1, MPI_DOUBLE, MPI_MAX, *spread_);
  return all;
}

std::uint64_t RveMaterial::count(Facts::Count what) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < points(); ++i) sum += facts(i).*what;
  return over_ranks(sum);
}

dem::State RveMaterial::committed(std::size_t point) const {
  HostedRve rve = HostedRve::from(farm_.fetch(driver_.slot(point)));
  return dem::in_space(farm_.whole(std::move(rve.state)), rve.steady);
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto begin = std::chrono::steady_clock::now();
  const bool good = driver_.respond(points.deformation, points.duration, !points.tangent.empty(), watch_);
  if (spread_) inertial_numbers_.resize(good ? this->points() : 0);
  for (std::size_t i = 0; i < inertial_numbers_.size(); ++i) inertial_numbers_[i] = driver_.response(i).inertial_number;
  for (std::size_t i = 0; good && i < this->points(); ++i) {
    const dem::Answer& r = driver_.answer(i);
    const dem::Vec6 stress = dem::to_voigt(r.stress);
    for (int k = 0; k < 6; ++k) points.stress[6 * i + static_cast<std::size_t>(k)] = stress[k];
    if (points.tangent.empty()) continue;
    for (int a = 0; a < 6; ++a)
      for (int b = 0; b < 6; ++b) points.tangent[36 * i + static_cast<std::size_t>(6 * a + b)] = r.tangent(a, b);
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return good;
}

/// Steps in time tell what their RVEs hold: side by side, where facts lie far apart.
void RveMaterial::keep_energies() {
  held_.clear();
  if (!spread_ || relaxed(driver_.book())) return;
  for (std::size_t i = 0; i < points(); ++i) held_.push_back(driver_.response(i).work - driver_.response(i).haste);
}

double RveMaterial::spent(std::size_t point) const {
  if (steps_.empty()) return farm_.spent(driver_.slot(point));
  return static_cast<double>(steps_[point] * facts(point).grains);
}

void RveMaterial::count_anew() {
  sweeps_ = 0;
  std::fill(steps_.begin(), steps_.end(), 0);
}

void RveMaterial::count_steps() {
  constexpr std::uint64_t beside = 5;  // steps that the rest of an answer takes as long as, of 27 and of 213 spheres
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (const std::uint64_t steps = driver_.response(i).steps; steps > 0) steps_[i] += steps + beside;
}

void RveMaterial::commit() {
  keep_energies();
  count_steps();
  driver_.commit();
  ++sweeps_;
  // An explicit step is too short to go by, and too cheap to pay for a move.
  constexpr std::uint64_t steps_between = 100;
  if (++commits_ % steps_between == 0 || relaxed(driver_.book())) farm_.rebalance();
}

std::string RveMaterial::save_point(std::size_t point) const {
  dem::Saver a;
  a.plain(inertial_numbers_.at(point)), a.text(driver_.point_bytes(point));
  return a.take();
}

void RveMaterial::load_point(std::size_t point, const std::string& bytes) {
  held_.clear();
  std::string rest;
  dem::Loader a(bytes);
  inertial_numbers_.resize(points());
  a.plain(inertial_numbers_.at(point)), a.text(rest);
  if (!std::isfinite(inertial_numbers_[point])) throw dem::InputError("checkpoint is damaged: a point and its RVE");
  driver_.take_point(point, rest);
}

void RveMaterial::save(const std::function<void(const std::string&)>& take) const {
  bool first = true;
  driver_.save([&](const std::string& part) {
    if (!std::exchange(first, false)) return take(part);
    dem::Saver a;
    a.plain(seconds_), a.text(part);
    take(a.take());
  });
}

void RveMaterial::load(const std::vector<std::string>& parts) {
  held_.clear();
  std::string book;
  dem::Loader a(parts.at(0));
  a.plain(seconds_), a.text(book);
  try {
    driver_.load(book, std::span(parts).subspan(1));
    for (const auto& p : driver_.book().sharing.point)
      if (p.variant >= start_volume_.size()) throw dem::InputError("of other packings");
  } catch (const dem::InputError& e) {
    throw dem::InputError(std::string("checkpoint.h5: ") + e.what());
  }
}

}  // namespace grus::coupling
