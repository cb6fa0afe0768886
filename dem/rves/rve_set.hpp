// SPDX-License-Identifier: LGPL-3.0-or-later
// The RVEs of a macro program's Gauss points, by number of the point: deformation in, stress and tangent out, commit.
// What other people's solvers see of the grains (grus/rve.hpp, and grus.RveSet in Python).
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dem/base/watch.hpp"
#include "dem/rves/driver_options.hpp"

namespace grus::dem {

struct Model;  // dem/rve/model.hpp
struct State;  // dem/rve/state.hpp

class RveSet {
public:
  /// Point i starts from `prepared[start[i]]`; points of one history have one RVE between them (the same bits as
  /// without, dem/rves/sharing.hpp). What else may be left out, similar sharing and deferral, the options say; their
  /// pace is not read: every increment is taken to rest. `kin` is a number of the scene's: states of another one are
  /// refused.
  RveSet(std::shared_ptr<const Model> model, const std::vector<State>& prepared, std::span<const std::size_t> start,
         const RveOptions& options, int threads, std::uint64_t kin = 0);
  RveSet(std::shared_ptr<const Model> model, const std::vector<State>& prepared, std::span<const std::size_t> start,
         const ResponseOptions& options, int threads, std::uint64_t kin = 0);
  RveSet(RveSet&&) noexcept;
  RveSet& operator=(RveSet&&) noexcept;
  ~RveSet();

  std::size_t size() const;
  std::size_t distinct() const;  // RVEs

  /// Takes every point from its committed state through F_new F_old^-1: `deformation` 9 a point, row by row, taken to
  /// 6e-11 (dem/rves/alike.hpp); det F > 0. Out: Cauchy stress (Pa, tension-positive, Voigt xx yy zz yz xz xy), 6 a
  /// point; tangent d(stress) / d(strain) with engineering shear (Pa), 36 a point row by row, or empty. Again before
  /// `commit`: from the committed state again. Throws InputError for what is no increment, and Unstable, which names
  /// the point, where grains do not get there; then nothing has been written, and the committed states stand.
  /// Interrupted, where the watch says so: it is asked some times a second by the calling thread.
  void advance(std::span<const double> deformation, std::span<double> stress, std::span<double> tangent,
               const Watch& watch = {});

  /// Makes the last advance the committed states. Throws std::logic_error where there is none.
  void commit();

  /// What became of a point's RVE in the last advance that is not committed yet; std::logic_error where there is none.
  /// Where the RVE was not asked, or is another point's, stress and tangent are what is foretold for the RVE.
  const Response& response(std::size_t point) const;
  /// Of the committed state of the point's RVE: with similar sharing or deferral that of a similar point, and where it
  /// last was.
  Facts facts(std::size_t point) const;
  State state(std::size_t point) const;
  /// How often RVEs were asked, what was answered without DEM, and the errors that were measured of such answers.
  const SweepReport& report() const;

  /// The committed state, with a checksum; and back, which drops an advance that is not committed. Throws InputError
  /// for bytes that are damaged or of another scene, and with similar sharing, where a point is no state alone.
  std::string bytes(std::size_t point) const;
  void restore(std::size_t point, const std::string& bytes);

  /// All points' committed states in parts: who shares with whom, then the RVEs; and back into a set of as many points.
  void save(const std::function<void(const std::string&)>& take) const;
  void load(const std::vector<std::string>& parts);

private:
  struct Inside;
  std::unique_ptr<Inside> in_;
};

}  // namespace grus::dem
