// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/fracture/peridynamic.hpp"

#include <algorithm>

namespace grus::dem {
namespace {

double bulk_of(double youngs_modulus, double poissons_ratio) { return youngs_modulus / (3 * (1 - 2 * poissons_ratio)); }
double shear_of(double youngs_modulus, double poissons_ratio) { return youngs_modulus / (2 * (1 + poissons_ratio)); }

}  // namespace

double toughness_modulus(Toughness form, double youngs_modulus, double poissons_ratio) {
  const double mu = shear_of(youngs_modulus, poissons_ratio),
               rest = bulk_of(youngs_modulus, poissons_ratio) - 5 * mu / 3;
  // 0.60877: twice the integral over depth of (theta of the crossing bonds alone / stretch)^2 / 2.
  return form == Toughness::all_bonds ? 3.125 * mu + 0.60877 * rest : 3 * mu + 0.31640625 * rest;
}

double critical_stretch(Toughness form, double energy, double youngs_modulus, double poissons_ratio, double horizon) {
  return std::sqrt(energy / (toughness_modulus(form, youngs_modulus, poissons_ratio) * horizon));
}

double fracture_energy(Toughness form, double stretch, double youngs_modulus, double poissons_ratio, double horizon) {
  return stretch * stretch * toughness_modulus(form, youngs_modulus, poissons_ratio) * horizon;
}

double LatticeToughness::stretch(const LatticeChoice& lattice, double youngs_modulus, double poissons_ratio,
                                 double diameter, double strength) const {
  const double of = size == SizeLaw::griffith ? diameter : reference_diameter;
  return strength *
         critical_stretch(form, energy, youngs_modulus, poissons_ratio, lattice.horizon * lattice.spacing() * of);
}

PointColumns columns_of(const std::vector<Vec3>& by_point, double factor) {
  PointColumns c(by_point.size());
  for (std::size_t i = 0; i < by_point.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) c(i, axis) = factor * by_point[i][static_cast<Eigen::Index>(axis)];
  return c;
}

double dot(const PointColumns& a, const PointColumns& b) {
  double sum[8] = {};  // the zeros behind each column add nothing
  for (std::size_t k = 0; k < a.size(); k += 8)
    for (std::size_t l = 0; l < 8; ++l) sum[l] += a[k + l] * b[k + l];
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + ((sum[4] + sum[5]) + (sum[6] + sum[7]));
}

PeridynamicSolid::PeridynamicSolid(const PointLattice& lattice, double poissons_ratio)
    : lattice_(lattice),
      bulk_(bulk_of(1, poissons_ratio)),
      shear_(shear_of(1, poissons_ratio)),
      intact_(lattice.bond),
      weak_(lattice.bond) {
  const double v = lattice.volume, k0 = bulk_ - 5 * shear_ / 3;
  for (auto* column : {&box_[0], &box_[1], &box_[2], &theta_, &lost_, &square_, &p_, &q_, &to_theta_, &to_p_, &half_})
    column->assign(lattice.cells, 0.0);
  for (std::size_t k = 0; k + 1 < lattice.octet.size(); ++k) {
    const LatticeOctet &o = lattice.octet[k], &next = lattice.octet[k + 1];
    for (std::uint32_t l = 0; l < next.point - o.point; ++l) {
      double m = 0;  // eq 3
      for (std::uint32_t b = o.bond; b < next.bond; ++b) {
        const LatticeWay& w = lattice.ways[lattice.way[b]];
        if (lattice.bond[b] >> l & 1) m += w.moment * w.length * v;
      }
      const std::size_t c = o.cell + l;
      to_theta_[c] = 3 * v / m;         // eq 4
      to_p_[c] = 3 * k0 * v * v / m;    // eq 2
      q_[c] = 15 * shear_ * v * v / m;  // eq 2
      half_[c] = 0.5 * k0 * v;
    }
  }
}

void PeridynamicSolid::keep(std::vector<bool> point) {
  kept_ = std::move(point);
  weak_ = lattice_.bond;
  std::vector<std::uint8_t> kept(lattice_.cells);
  for (std::size_t i = 0; i < lattice_.size(); ++i) kept[lattice_.cell[i]] = kept_[i];
  for (std::size_t k = 0; k + 1 < lattice_.octet.size(); ++k)
    for (std::uint32_t b = lattice_.octet[k].bond; b < lattice_.octet[k + 1].bond; ++b)
      for (std::uint32_t l = 0; l < lattice_.octet[k + 1].point - lattice_.octet[k].point; ++l) {
        const std::int64_t cell = std::int64_t{lattice_.octet[k].cell} + l;
        if (kept[static_cast<std::size_t>(cell)] ||
            kept[static_cast<std::size_t>(cell + lattice_.ways[lattice_.way[b]].step)])
          weak_[b] = static_cast<std::uint8_t>(weak_[b] & ~(1u << l));
      }
}

double PeridynamicSolid::wave_speed() const { return std::sqrt(bulk_ + 4 * shear_ / 3); }

LatticeRows PeridynamicSolid::rows() const {
  return {lattice_.octet.data(), lattice_.octet.size() - 1, lattice_.way.data(), lattice_.ways.data()};
}

void PeridynamicSolid::take_in(const PointColumns& u) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double* const to = box_[axis].data();
    const double* const from = u.data() + axis * u.room();
    for (std::size_t i = 0; i < lattice_.size(); ++i) to[lattice_.cell[i]] = from[i];
  }
}

double PeridynamicSolid::dilate(const PointColumns& u, bool energy) {
  take_in(u);
  lattice_dilation()(rows(), intact_.data(), columns(), to_theta_.data(), theta_.data(),
                     energy ? square_.data() : nullptr);
  double sum = 0;
  if (energy)
    for (const std::uint32_t c : lattice_.cell) sum += half_[c] * theta_[c] * theta_[c] + 0.5 * q_[c] * square_[c];
  return sum;
}

void PeridynamicSolid::pull(PointColumns& force) {
  for (std::size_t c = 0; c < lattice_.cells; ++c) p_[c] = to_p_[c] * theta_[c];
  lattice_forces()(rows(), intact_.data(), columns(), p_.data(), q_.data(), force.data(), force.room());
}

void PeridynamicSolid::flexibility(PointColumns& on, PointColumns& off) const {
  lattice_stiffness()(rows(), intact_.data(), q_.data(), on.data(), off.data(), on.room());
  double most = 0;
  for (std::size_t k = 0; k < on.size(); ++k) most = std::max(most, on[k]);
  const double least = 1e-3 * most;  // a point may have lost all bonds in some direction
  for (std::size_t i = 0; i < lattice_.size(); ++i) {
    const double a = on(i, 0) + least, b = on(i, 1) + least, c = on(i, 2) + least;
    const double f = off(i, 0), g = off(i, 1), h = off(i, 2);  // yz, xz, xy
    const double aa = b * c - f * f, hh = f * g - h * c, gg = h * f - b * g, over = 1 / (a * aa + h * hh + g * gg);
    on(i, 0) = over * aa, on(i, 1) = over * (a * c - g * g), on(i, 2) = over * (a * b - h * h);
    off(i, 0) = over * (h * g - a * f), off(i, 1) = over * gg, off(i, 2) = over * hh;
  }
}

std::size_t PeridynamicSolid::break_above(double limit, double& lost) {
  const std::size_t ends = lattice_breaks()(rows(), weak_.data(), intact_.data(), columns(), limit, to_theta_.data(),
                                            theta_.data(), lost_.data(), square_.data());
  if (ends > 0)
    for (const std::uint32_t c : lattice_.cell)
      lost += half_[c] * lost_[c] * (2 * theta_[c] + lost_[c]) + 0.5 * q_[c] * square_[c];
  return ends / 2;
}

std::size_t PeridynamicSolid::break_above(const PointColumns& u, double limit, double& lost) {
  take_in(u);
  return break_above(limit, lost);
}

double PeridynamicSolid::largest_stretch(const std::vector<std::uint8_t>& asked) const {
  return lattice_stretch()(rows(), intact_.data(), columns(), asked.data());
}

double PeridynamicSolid::largest_breakable_stretch() const {
  const std::vector<std::uint8_t> all(lattice_.octet.size() - 1, 0xff);
  return lattice_stretch()(rows(), weak_.data(), columns(), all.data());
}

double PeridynamicSolid::highest_frequency(int iterations) {
  // Energy <= bonds alone where K < 5/3 mu; elsewhere theta^2 <= 9/m of the sum over bonds bounds the rest.
  const double k0 = bulk_ - 5 * shear_ / 3, scale = 1 + std::max(0.0, 9 * k0 / (15 * shear_));
  PointColumns u(lattice_.size()), f(lattice_.size());
  for (std::size_t i = 0; i < lattice_.size(); ++i)  // no mode is missed, and none is favoured
    for (std::size_t axis = 0; axis < 3; ++axis)
      u(i, axis) = std::sin(static_cast<double>((3 * i + axis + 1) * (3 * i + axis + 1)));
  double highest = 0;
  std::fill(p_.begin(), p_.end(), 0.0);
  for (int k = 0; k < iterations; ++k) {
    take_in(u);
    lattice_forces()(rows(), intact_.data(), columns(), p_.data(), q_.data(), f.data(), f.room());
    const double uu = dot(u, u), ff = dot(f, f);
    highest = std::sqrt(ff / uu);
    const double shrink = 1 / std::sqrt(ff);
    for (std::size_t c = 0; c < u.size(); ++c) u[c] = -shrink * f[c];
  }
  return std::sqrt(scale * highest / lattice_.volume);
}

int solve(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, double tolerance, int most,
          long& sweeps) {
  const std::size_t n = u.size(), points = solid.lattice().size();
  PointColumns residual(points), way = residual, force = residual, eased = residual, on = residual, off = residual;
  solid.flexibility(on, off);
  const auto ease = [&] {
    for (std::size_t i = 0; i < points; ++i) {
      const double x = residual(i, 0), y = residual(i, 1), z = residual(i, 2);
      eased(i, 0) = on(i, 0) * x + (off(i, 2) * y + off(i, 1) * z);
      eased(i, 1) = on(i, 1) * y + (off(i, 2) * x + off(i, 0) * z);
      eased(i, 2) = on(i, 2) * z + (off(i, 1) * x + off(i, 0) * y);
    }
    return dot(residual, eased);
  };
  const auto forces = [&](const PointColumns& at) { solid.dilate(at), solid.pull(force), ++sweeps; };
  forces(u);
  for (std::size_t k = 0; k < n; ++k) residual[k] = load[k] + force[k];
  double rr = dot(residual, residual), rz = ease();
  way = eased;
  const double enough = tolerance * tolerance * dot(load, load);
  int done = 0;
  for (; done < most && rr > enough; ++done) {
    forces(way);
    const double bent = -dot(way, force);
    if (!(bent > 0)) return -1;  // a mechanism is loaded
    const double share = rz / bent;
    for (std::size_t k = 0; k < n; ++k) u[k] += share * way[k], residual[k] += share * force[k];
    const double now = ease(), keep = now / rz;
    rr = dot(residual, residual), rz = now;
    for (std::size_t k = 0; k < n; ++k) way[k] = eased[k] + keep * way[k];
  }
  return rr <= enough ? done : -1;
}

}  // namespace grus::dem
