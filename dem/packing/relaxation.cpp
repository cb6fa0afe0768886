// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/packing/relaxation.hpp"

#include <algorithm>

#include "dem/base/random.hpp"
#include "dem/state/images.hpp"

namespace grus::dem {

template <class F>
void Relaxation::each_wall(std::size_t i, double radius, F&& f) const {
  const Vec3& x = s_[i].position;
  for (int k = first_wall(); k < 3; ++k) {
    f(radius - x[k], Vec3(Vec3::Unit(k)));
    f(x[k] + radius - box_[k], Vec3(-Vec3::Unit(k)));
  }
  if (container_ != Container::cylinder) return;
  const Vec3 out(x[0] - 0.5 * box_[0], x[1] - 0.5 * box_[1], 0);
  const double away = out.norm();
  f(away + radius - 0.5 * box_[0], away > 0 ? Vec3(-out / away) : Vec3(-Vec3::UnitX()));
}

double Relaxation::run(int iterations, double good_enough, const std::function<void(int)>& watch) {
  double mean = 0;
  for (const auto& s : s_) mean += s.radius;
  const double skin = 0.4 * mean / static_cast<double>(s_.size());
  v_.assign(s_.size(), Vec3::Zero());
  double dt = 0.1, mix = 0.1;
  int downhill = 0;
  refresh(skin);
  for (int it = 0; it < iterations; ++it) {
    watch(it);
    if (moved()) refresh(skin);
    const double worst = forces();
    if (worst <= good_enough) return worst;
    double power = 0, vv = 0, ff = 0;
    for (std::size_t i = 0; i < s_.size(); ++i)
      power += v_[i].dot(f_[i]), vv += v_[i].squaredNorm(), ff += f_[i].squaredNorm();
    if (power > 0) {
      const double scale = mix * std::sqrt(vv / std::max(ff, 1e-300));
      for (std::size_t i = 0; i < s_.size(); ++i) v_[i] = (1 - mix) * v_[i] + scale * f_[i];
      if (++downhill > 5) dt = std::min(1.1 * dt, 0.5), mix *= 0.99;
    } else {
      for (auto& v : v_) v.setZero();
      dt = std::max(0.5 * dt, 1e-3);
      mix = 0.1;
      downhill = 0;
    }
    for (std::size_t i = 0; i < s_.size(); ++i) v_[i] += dt * f_[i], s_[i].position += dt * v_[i];
  }
  refresh(skin);
  return forces();
}

void Relaxation::refresh(double skin) {
  skin_ = skin;
  const std::size_t n = s_.size();
  grains_.motion.resize(n);
  at_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (int k = container_ == Container::cylinder ? 0 : first_wall(); k < 3; ++k)
      s_[i].position[k] = std::clamp(s_[i].position[k], 0.0, box_[k]);
    grains_.motion[i].position = at_[i] = s_[i].position;
    grains_.motion[i].radius = s_[i].radius;
  }
  double largest = 0;
  for (const Sphere& s : s_) largest = std::max(largest, s.radius);
  const Cell cell = cell_of(container_, box_, largest + skin);
  find_candidates(grains_, cell, skin, near_, search_, team_);
  row_.assign(n + 1, 0);
  for (const auto& p : near_.pair) ++row_[p.a + 1], ++row_[p.b + 1];
  for (std::size_t i = 0; i < n; ++i) row_[i + 1] += row_[i];
  neighbours_.resize(row_[n]);
  next_.assign(row_.begin(), row_.end() - 1);
  for (const auto& p : near_.pair) {  // sorted by a, then b: each sphere meets its neighbours in ascending order
    neighbours_[next_[p.b]++] = {p.a, true, at_image(cell.vectors, p.image)};
  }
  for (const auto& p : near_.pair) neighbours_[next_[p.a]++] = {p.b, false, at_image(cell.vectors, p.image)};
}

bool Relaxation::moved() const {
  for (std::size_t i = 0; i < s_.size(); ++i)
    if ((s_[i].position - at_[i]).squaredNorm() > 0.25 * skin_ * skin_) return true;
  return false;
}

double Relaxation::forces() {
  f_.resize(s_.size());
  worst_.assign(block_count(s_.size()), 0);
  team_.blocks(s_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 force = Vec3::Zero();
      double& worst = worst_[i / block_size];
      for (std::size_t e = row_[i]; e < row_[i + 1]; ++e) {
        const Neighbour& near = neighbours_[e];
        const Sphere& other = s_[near.other];
        const Vec3 d = near.second ? Vec3(s_[i].position - other.position + near.image)
                                   : Vec3(other.position - s_[i].position + near.image);
        const double sum = s_[i].radius + other.radius, d2 = d.squaredNorm();
        if (d2 >= sum * sum) continue;
        const double distance = std::sqrt(d2), overlap = sum - distance;
        const Vec3 n = distance > 0 ? Vec3(d / distance) : Vec3(1, 0, 0);
        if (near.second)
          force += overlap * n;
        else
          force -= overlap * n;
        worst = std::max(worst, overlap / std::min(s_[i].radius, other.radius));
      }
      each_wall(i, s_[i].radius, [&](double depth, const Vec3& inward) {
        if (depth > 0) force += depth * inward;
        worst = std::max(worst, depth / s_[i].radius);
      });
      f_[i] = force;
    }
  });
  return *std::max_element(worst_.begin(), worst_.end());
}

double Relaxation::energy_of(std::size_t i, double radius) const {
  double sum = 0;
  for (std::size_t e = row_[i]; e < row_[i + 1]; ++e) {
    const Neighbour& near = neighbours_[e];
    const Sphere& other = s_[near.other];
    const Vec3 d = near.second ? Vec3(s_[i].position - other.position + near.image)
                               : Vec3(other.position - s_[i].position + near.image);
    const double reach = radius + other.radius, d2 = d.squaredNorm();
    if (d2 < reach * reach) sum += 0.5 * std::pow(reach - std::sqrt(d2), 2);
  }
  each_wall(i, radius, [&](double depth, const Vec3&) {
    if (depth > 0) sum += 0.5 * depth * depth;
  });
  return sum;
}

std::size_t Relaxation::swap(std::uint64_t seed, std::size_t attempts) {
  const auto [small, large] =
      std::minmax_element(s_.begin(), s_.end(), [](const Sphere& a, const Sphere& b) { return a.radius < b.radius; });
  const double range = large->radius - small->radius;
  if (!(range > 1e-3 * large->radius)) return 0;
  refresh(2 * range + 0.1 * small->radius);
  std::size_t swapped = 0;
  const auto n = static_cast<double>(s_.size());
  for (std::uint64_t k = 0; k < attempts; ++k) {
    const auto i = static_cast<std::size_t>(n * random_uniform(seed, k, Purpose::radius, 0)),
               j = static_cast<std::size_t>(n * random_uniform(seed, k, Purpose::radius, 1));
    const double a = s_[i].radius, b = s_[j].radius;
    if (i == j || std::abs(a - b) < 1e-6 * range) continue;
    const double before = energy_of(i, a) + energy_of(j, b);
    if (before == 0) continue;
    s_[i].radius = b, s_[j].radius = a;  // neighbours of each other see both
    if (energy_of(i, b) + energy_of(j, a) < before)
      ++swapped;
    else
      s_[i].radius = a, s_[j].radius = b;
  }
  return swapped;
}

}  // namespace grus::dem
