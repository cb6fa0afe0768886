// SPDX-License-Identifier: LGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "dem/base/error.hpp"
#include "dem/base/random.hpp"
#include "dem/contact/broad_phase.hpp"
#include "dem/packing/packing.hpp"

namespace grus::dem {
namespace {

double draw(const RadiusDistribution& d, std::uint64_t seed, std::uint64_t i) {
  if (d.kind == "uniform") return d.min + (d.max - d.min) * random_uniform(seed, i, Purpose::radius);
  if (d.kind == "truncated-normal")
    for (std::uint64_t k = 0; k < 10000; ++k) {
      const double r = d.mean + d.sd * random_normal(seed, i, Purpose::radius, k);
      if (r >= d.min && r <= d.max) return r;
    }
  return d.mean;
}

/// Soft spheres pushed apart by FIRE (Bitzek et al. 2006): energy 1/2 overlap^2, unit mass.
class Relaxation {
public:
  Relaxation(const Vec3& box, bool periodic, std::vector<Sphere>& spheres) : box_(box), periodic_(periodic), s_(spheres) {
    set_grain_scratch();
  }

  /// Worst overlap relative to the smaller radius after at most `iterations`.
  double run(int iterations, double good_enough) {
    v_.assign(s_.size(), Vec3::Zero());
    double dt = 0.1, mix = 0.1;
    int downhill = 0;
    refresh();
    for (int it = 0; it < iterations; ++it) {
      if (moved()) refresh();
      const double worst = forces();
      if (worst <= good_enough) return worst;
      double power = 0, vv = 0, ff = 0;
      for (std::size_t i = 0; i < s_.size(); ++i) power += v_[i].dot(f_[i]), vv += v_[i].squaredNorm(), ff += f_[i].squaredNorm();
      if (power > 0) {
        const double scale = mix * std::sqrt(vv / std::max(ff, 1e-300));
        for (std::size_t i = 0; i < s_.size(); ++i) v_[i] = (1 - mix) * v_[i] + scale * f_[i];
        if (++downhill > 5) dt = std::min(1.1 * dt, 0.5), mix *= 0.99;
      } else {
        for (auto& v : v_) v.setZero();
        dt = std::max(0.5 * dt, 1e-3), mix = 0.1, downhill = 0;
      }
      for (std::size_t i = 0; i < s_.size(); ++i) v_[i] += dt * f_[i], s_[i].position += dt * v_[i];
    }
    refresh();
    return forces();
  }

private:
  void set_grain_scratch() {
    double mean = 0;
    for (const auto& s : s_) mean += s.radius;
    skin_ = 0.4 * mean / static_cast<double>(s_.size());
  }
  void refresh() {
    grains_.motion.resize(s_.size());
    at_.resize(s_.size());
    for (std::size_t i = 0; i < s_.size(); ++i) {
      if (!periodic_)
        for (int k = 0; k < 3; ++k) s_[i].position[k] = std::clamp(s_[i].position[k], 0.0, box_[k]);
      grains_.motion[i].position = at_[i] = s_[i].position;
      grains_.motion[i].radius = s_[i].radius;
    }
    Cell cell;
    if (periodic_) cell.vectors = Mat3(box_.asDiagonal());
    find_candidates(grains_, cell, skin_, near_, team_);
  }
  bool moved() const {
    for (std::size_t i = 0; i < s_.size(); ++i)
      if ((s_[i].position - at_[i]).squaredNorm() > 0.25 * skin_ * skin_) return true;
    return false;
  }
  double forces() {
    f_.assign(s_.size(), Vec3::Zero());
    double worst = 0;
    for (const auto& p : near_.pair) {
      Vec3 d = s_[p.b].position - s_[p.a].position;
      if (periodic_) d += box_.cwiseProduct(Vec3(p.image[0], p.image[1], p.image[2]));
      const double sum = s_[p.a].radius + s_[p.b].radius, d2 = d.squaredNorm();
      if (d2 >= sum * sum) continue;
      const double distance = std::sqrt(d2), overlap = sum - distance;
      const Vec3 n = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
      f_[p.a] -= overlap * n, f_[p.b] += overlap * n;
      worst = std::max(worst, overlap / std::min(s_[p.a].radius, s_[p.b].radius));
    }
    if (!periodic_)
      for (std::size_t i = 0; i < s_.size(); ++i)
        for (int k = 0; k < 3; ++k) {
          const double low = s_[i].radius - s_[i].position[k], high = s_[i].position[k] + s_[i].radius - box_[k];
          if (low > 0) f_[i][k] += low;
          if (high > 0) f_[i][k] -= high;
          worst = std::max(worst, std::max(low, high) / s_[i].radius);
        }
    return worst;
  }

  Vec3 box_;
  bool periodic_;
  std::vector<Sphere>& s_;
  Grains grains_;
  Candidates near_;
  std::vector<Vec3> v_, f_, at_;
  double skin_ = 0;
  Team team_;
};

}  // namespace

Packing random_packing(const Vec3& box, const RadiusDistribution& radius, double solid_fraction, std::size_t count, bool periodic,
                       std::uint64_t seed) {
  Packing p;
  p.box = box;
  const double target = solid_fraction * box.prod();
  double solid = 0;
  for (std::uint64_t i = 0; count > 0 ? i < count : true; ++i) {
    const double r = draw(radius, seed, i), v = 4 * pi / 3 * r * r * r;
    if (count == 0 && solid + 0.5 * v > target && i > 0) break;
    if (i >= 20'000'000) throw InputError("packing: more than 20 million grains would be needed; check box and radius");
    solid += v;
    p.spheres.push_back({{}, r});
    for (int k = 0; k < 3; ++k) p.spheres.back().position[k] = random_uniform(seed, i, Purpose::position, static_cast<std::uint64_t>(k));
  }
  const double exact = std::cbrt(target / solid);
  if (std::abs(exact - 1) > 0.02)
    throw InputError(fmt::format("packing: {} grains of this size fill {:.3f} of the box, not solid_fraction = {:g}; change count (or leave it out)",
                                 p.spheres.size(), solid / box.prod(), solid_fraction));
  std::vector<double> radii;
  for (auto& s : p.spheres) {
    radii.push_back(s.radius * exact);
    if (2 * radii.back() >= box.minCoeff())
      throw InputError(fmt::format("packing: a grain of radius {:.3g} m does not fit the box", radii.back()));
    s.position = s.position.cwiseProduct(box);
  }
  // Grow to the target with a margin of 1e-4 in radius, so that the final radii leave no overlap.
  constexpr double margin = 1e-4, first = 0.75;
  const int stages = 12;
  double worst = 0;
  for (int stage = 0; stage <= stages; ++stage) {
    const double grow = first + (1 + margin - first) * stage / stages;
    for (std::size_t i = 0; i < radii.size(); ++i) p.spheres[i].radius = grow * radii[i];
    Relaxation relaxation(box, periodic, p.spheres);
    worst = relaxation.run(stage < stages ? 400 : 20000, stage < stages ? 1e-2 : 0.5 * margin);
  }
  if (worst > margin)
    throw InputError(fmt::format("packing: could not reach solid_fraction = {:g} at random (overlaps of {:.2g} radii remain); ask for less "
                                 "(about 0.60 for spheres) and compress the sample instead",
                                 solid_fraction, worst));
  for (std::size_t i = 0; i < radii.size(); ++i) p.spheres[i].radius = radii[i];
  p.worst_overlap = std::max(0.0, worst - margin);
  return p;
}

}  // namespace grus::dem
