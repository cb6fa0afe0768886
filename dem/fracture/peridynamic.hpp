// SPDX-License-Identifier: LGPL-3.0-or-later
// The linear peridynamic solid (Silling et al. 2007; Zhu and Zhao 2019, eqs 1 to 5) on the points of one grain, small
// displacements, influence 1. In units of the diameter d, Young's modulus E and a stretch s: lengths d, displacements
// d s, forces E d^2 s, energies E d^3 s^2.
#pragma once

#include <array>

#include "dem/fracture/lattice.hpp"

namespace grus::dem {

/// What opening a face of unit area takes, as a multiple of stretch^2 x horizon (Pa).
enum class Toughness {
  all_bonds,       // every bond across it at the critical stretch: 25/8 mu + 0.60877 (K - 5/3 mu)
  madenci_oterkus  // 3 mu + (3/4)^4 (K - 5/3 mu), the paper's eq 5
};
double toughness_modulus(Toughness form, double youngs_modulus, double poissons_ratio);

/// The stretch at which bonds break, from an energy (J/m^2), and back; `horizon` in m.
double critical_stretch(Toughness form, double energy, double youngs_modulus, double poissons_ratio, double horizon);
double fracture_energy(Toughness form, double stretch, double youngs_modulus, double poissons_ratio, double horizon);

/// How strength goes with size at one fracture energy.
enum class SizeLaw {
  reference_horizon,  // F/d^2 is the same at all sizes: the stretch is that of the reference grain
  griffith            // F/d^2 ~ d^-1/2: the horizon is the grain's own
};

/// Toughness of a material, and the stretch at which bonds of its grains break.
struct LatticeToughness {
  double energy = 0;              // G_c (J/m^2)
  double reference_diameter = 0;  // m
  Toughness form = Toughness::all_bonds;
  SizeLaw size = SizeLaw::reference_horizon;

  /// `strength`: the grain's own factor on F/d^2. Eq 16 of the paper, as printed, multiplies the reference grain's
  /// stretch by sqrt(d / d_ref): that makes small grains weaker. Meant is the stretch by the grain's own horizon times
  /// that root.
  double stretch(const LatticeChoice& lattice, double youngs_modulus, double poissons_ratio, double diameter,
                 double strength = 1) const;
};

/// Columns x, y and z by point, and some zeros behind each.
class PointColumns {
public:
  explicit PointColumns(std::size_t points = 0) : room_((points + 7) / 8 * 8 + 8), value_(3 * room_) {}

  std::size_t room() const { return room_; }
  std::size_t size() const { return value_.size(); }
  double* data() { return value_.data(); }
  const double* data() const { return value_.data(); }
  double& operator[](std::size_t k) { return value_[k]; }
  double operator[](std::size_t k) const { return value_[k]; }
  double& operator()(std::size_t point, std::size_t axis) { return value_[axis * room_ + point]; }
  double operator()(std::size_t point, std::size_t axis) const { return value_[axis * room_ + point]; }

private:
  std::size_t room_;
  std::vector<double> value_;
};
PointColumns columns_of(const std::vector<Vec3>& by_point, double factor = 1);
double dot(const PointColumns& a, const PointColumns& b);

/// Points, their bonds, and room for what the sweeps need. The lattice must outlive it.
class PeridynamicSolid {
public:
  PeridynamicSolid(const PointLattice& lattice, double poissons_ratio);

  const PointLattice& lattice() const { return lattice_; }
  double bulk_modulus() const { return bulk_; }
  double shear_modulus() const { return shear_; }
  /// Speed of pressure waves at unit density.
  double wave_speed() const;

  /// By bond of `lattice().way`, of which points it is intact.
  std::vector<std::uint8_t>& intact() { return intact_; }
  const std::vector<std::uint8_t>& intact() const { return intact_; }
  /// All bonds are whole again.
  void mend() { intact_ = lattice_.bond; }
  /// Bonds of these points do not break.
  void keep(std::vector<bool> point);
  bool keeps(std::size_t point) const { return !kept_.empty() && kept_[point]; }

  /// Takes displacements in and finds the dilations; with `energy` the stored energy, otherwise 0.
  double dilate(const PointColumns& u, bool energy = false);
  /// Forces of the bonds at the displacements that were taken in last.
  void pull(PointColumns& force);
  /// Inverse of what the bonds hold each point by, were its neighbours fixed: symmetric, xx, yy, zz in `on` and yz, xz,
  /// xy in `off`.
  void flexibility(PointColumns& on, PointColumns& off) const;
  /// Breaks the bonds that are stretched more than the limit at the displacements that were taken in last; the energy
  /// that the solid loses as they go is added to `lost`. Returns how many broke. The dilations are up to date after it.
  std::size_t break_above(double limit, double& lost);
  /// The same at displacements that it takes in.
  std::size_t break_above(const PointColumns& u, double limit, double& lost);
  /// Largest stretch of bonds of the points asked for, by octet of the lattice and bit by bit.
  double largest_stretch(const std::vector<std::uint8_t>& asked) const;
  /// The same of all bonds that may break, were they whole.
  double largest_breakable_stretch() const;
  /// Dilation of a point at the displacements that were taken in last.
  double dilation(std::size_t point) const { return theta_[lattice_.cell[point]]; }

  /// A bound on the highest frequency (rad s^-1 at unit density) that no broken bond makes higher: power iterations on
  /// the stiffness of the bonds without what dilation takes off.
  double highest_frequency(int iterations = 30);

private:
  LatticeRows rows() const;
  void take_in(const PointColumns& u);
  LatticeColumns columns() const { return {box_[0].data(), box_[1].data(), box_[2].data()}; }

  const PointLattice& lattice_;
  double bulk_, shear_;
  std::vector<std::uint8_t> intact_, weak_;
  std::vector<bool> kept_;
  std::array<std::vector<double>, 3> box_;                                      // displacements by cell
  std::vector<double> theta_, lost_, square_, p_, q_, to_theta_, to_p_, half_;  // by cell
};

/// Solves forces(u) + load = 0 from u on, by conjugate gradients on what each point is held by alone, until the
/// residual is below tolerance x |load|. Returns the number of iterations, or -1 where `most` are not enough.
int solve(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, double tolerance, int most, long& sweeps);

}  // namespace grus::dem
