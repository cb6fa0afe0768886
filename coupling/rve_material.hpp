// SPDX-License-Identifier: LGPL-3.0-or-later
// A fem::Material made of RVEs, one for each Gauss point: dem's driver over the farm of all ranks, on rank 0; or, of a
// macro problem that is spread over ranks, over a farm of one rank for its own points.
#pragma once

#include <optional>

#include "coupling/rve_farm.hpp"
#include "dem/rves/driver.hpp"
#include "fem/material.hpp"

namespace grus::coupling {

using dem::MeasuredError, dem::RveOptions, dem::SweepReport;

class RveMaterial {
public:
  /// Point i starts from the prepared state `states[start[i]]`. Slots are made on the farm, which must outlive this.
  /// `spread`: the ranks that have parts of the points between them, each RVEs of its own (no sharing); what is told of
  /// all points is then of theirs, too, to the same bits however they are spread, and all must ask it together. `keys`:
  /// of the points, over all ranks; messages name them so.
  RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
              const RveOptions& options, std::optional<MPI_Comm> spread = {}, std::vector<std::int64_t> keys = {});

  /// Valid as long as this object.
  fem::Material material();

  /// dem/rves/driver_book.hpp
  double noise();
  static constexpr double max_noise = dem::max_noise;

  std::size_t points() const { return driver_.points(); }
  std::uint64_t all_points() const { return over_ranks(points()); }
  double start_volume(std::size_t point) const {  // m^3
    return start_volume_[driver_.book().sharing.point[point].variant];
  }
  const dem::Facts& facts(std::size_t point) const { return driver_.facts(point); }
  /// Sum of one energy of all points' RVEs (J), each for the volume (m^3, reference) that its point stands for.
  double total(dem::Facts::Number energy, std::span<const double> volumes) const;
  dem::State committed(std::size_t point) const;
  /// Brings facts up to date; needed where there is no way back and steps do not tell them.
  void refresh() { driver_.refresh(); }
  const SweepReport& report() const { return driver_.book().report; }
  SweepReport report_of_all() const;
  double seconds() const { return seconds_; }  // wall time in responses
  /// What a point's own answers have cost, and how many there were, since the last time that was counted anew; of
  /// points that are spread. Of answers at rest it is wall time (s). Others are DEM steps of all grains, and some more
  /// for what else an answer takes: the same however busy a machine is.
  double spent(std::size_t point) const;
  std::uint64_t sweeps() const { return sweeps_; }
  void count_anew();
  std::uint64_t count(dem::Facts::Count what) const;  // of the committed states, every point counted

  /// A sum over all points' RVEs of `of(facts)`, and the largest.
  double sum(const std::function<double(const dem::Facts&)>& of) const;
  double largest(const std::function<double(const dem::Facts&)>& of) const;

  /// All that decides how one point goes on, of points that are spread; and back, with what all points have done so
  /// far, which one rank takes on. Throws InputError.
  std::string save_point(std::size_t point) const;
  /// Its RVE goes; the point is not to answer any more.
  void give_away(std::size_t point) { farm_.drop(driver_.slot(point)); }
  void load_point(std::size_t point, const std::string& bytes);
  void go_on_counting(const SweepReport& from) { driver_.go_on_counting(from); }
  /// Asked while RVEs answer, of points that are not spread: false ends the response by dem::Interrupted.
  void watch(dem::Watch watch) { watch_ = std::move(watch); }
  /// Whether RVEs are put off: those that have caught up stay where they are, and no increment can be dropped.
  bool puts_off() const { return driver_.book().options.error > 0; }
  /// What an increment may be dropped by.
  dem::BetweenIncrements between_increments() const { return dem::between_increments(driver_.book()); }
  /// Drops a response that is not committed, or was not ended, as if the increment had not been begun.
  void forget(const dem::BetweenIncrements& before) { driver_.forget(before); }
  /// Increments that will have the network's tangent, alike on all ranks.
  int sharp() const { return driver_.book().sharp; }
  void go_on_sharp(int increments) { driver_.go_on_sharp(increments); }

  /// All that decides how the points go on, handed over in parts (the states one by one); and back, into one that was
  /// made alike.
  void save(const std::function<void(const std::string&)>& take) const;
  void load(const std::vector<std::string>& parts);

private:
  bool respond(const fem::Points& points);
  void commit();
  void keep_energies();
  void count_steps();
  std::uint64_t over_ranks(std::uint64_t mine) const;

  RveFarm& farm_;
  std::vector<double> start_volume_;  // of the starting states
  dem::Driver<RveFarm> driver_;
  dem::Watch watch_;
  double seconds_ = 0;
  std::uint64_t commits_ = 0, sweeps_ = 0;  // sweeps_: since they were counted anew
  std::vector<std::uint64_t> steps_;        // of DEM since then, of points that are spread and never at rest
  std::optional<MPI_Comm> spread_;
  std::vector<double> inertial_numbers_;  // of the last response; of points that are spread
  std::vector<double> held_;              // J, work less haste of the points' RVEs; empty: their facts say
};

}  // namespace grus::coupling
