// SPDX-License-Identifier: LGPL-3.0-or-later
#include "coupling/rve_material.hpp"

#include <chrono>

#include "dem/io/archive.hpp"
#include "dem/rve/steady.hpp"

namespace grus::coupling {

using dem::Facts;
using dem::HostedRve;

RveMaterial::RveMaterial(RveFarm& farm, const std::vector<dem::State>& states, const std::vector<std::size_t>& start,
                         const RveOptions& options)
    : farm_(farm),
      driver_(
          farm, [&](std::size_t v) { return HostedRve{.state = states.at(v)}.bytes(); }, states.size(), start,
          options) {
  for (const auto& s : states) start_volume_.push_back(s.boundary.cell.volume());
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
  return m;
}

double RveMaterial::total(Facts::Number energy, std::span<const double> volumes) const {
  double sum = 0;
  for (std::size_t i = 0; i < volumes.size(); ++i) sum += facts(i).*energy * volumes[i] / start_volume(i);
  return sum;
}

std::uint64_t RveMaterial::count(Facts::Count what) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < points(); ++i) sum += facts(i).*what;
  return sum;
}

dem::State RveMaterial::committed(std::size_t point) const {
  HostedRve rve = HostedRve::from(farm_.fetch(driver_.slot(point)));
  return dem::in_space(farm_.whole(std::move(rve.state)), rve.steady);
}

bool RveMaterial::respond(const fem::Points& points) {
  const auto begin = std::chrono::steady_clock::now();
  const bool good = driver_.respond(points.deformation, points.duration, !points.tangent.empty());
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

void RveMaterial::commit() {
  driver_.commit();
  // An explicit step is too short to go by, and too cheap to pay for a move.
  constexpr std::uint64_t steps_between = 100;
  if (relaxed(driver_.book()) || ++commits_ % steps_between == 0) farm_.rebalance();
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
