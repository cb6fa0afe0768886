// SPDX-License-Identifier: LGPL-3.0-or-later
// Sweeps over the bonds of a lattice of points (fracture/peridynamic.hpp), eight points of a row at a time. No index is
// followed: a neighbour lies a fixed step away in a box of cells. Built for several instruction sets, as
// contact_pass.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

namespace grus::dem {

/// Up to eight points whose cells follow each other; its number of points and of bonds follow from the next one.
struct LatticeOctet {
  std::uint32_t cell, point, bond;  // the first of each
};

/// A neighbour as seen from any point.
struct LatticeWay {
  double along[3];                // unit vector to it
  double length, weight, moment;  // weight x length
  std::int32_t step;              // between the cells
};

/// A bond: `way` by way, which of its octet's eight points have it bit by bit in `intact`. Octets run in the order of
/// their cells; one more ends them.
struct LatticeRows {
  const LatticeOctet* octet;
  std::size_t octets;
  const std::uint16_t* way;
  const LatticeWay* ways;
};

/// Columns by cell; what empty cells hold is read, and must be finite.
struct LatticeColumns {
  const double *x, *y, *z;  // displacements
};

/// Sums over a point's intact bonds, by cell: factor x sum of moment x extension. With `square`: sums of weight x
/// extension^2 as well. Writes zeros to some empty cells. Eight cells more than there are must be there.
using LatticeDilation = void (*)(const LatticeRows&, const std::uint8_t* intact, const LatticeColumns& u,
                                 const double* factor, double* sum, double* square);
LatticeDilation lattice_dilation();

/// Forces by point, columns of `room` (eight more than points): sum of (moment (p_i + p_j) + weight x extension x
/// (q_i + q_j)) along. p and q by cell. A bond's two ends feel the same bits.
using LatticeForces = void (*)(const LatticeRows&, const std::uint8_t* intact, const LatticeColumns& u, const double* p,
                               const double* q, double* force, std::size_t room);
LatticeForces lattice_forces();

/// What holds each point if its neighbours stand still and their dilations are none: sums of weight (q_i + q_j) along x
/// along, by point as LatticeForces: xx, yy, zz and yz, xz, xy.
using LatticeStiffness = void (*)(const LatticeRows&, const std::uint8_t* intact, const double* q, double* on,
                                  double* off, std::size_t room);
LatticeStiffness lattice_stiffness();

/// Breaks bonds whose extension is above limit x length, of those that may break (`weak`, as `intact`), both ends at
/// once; returns how many ends broke. Writes sums as LatticeDilation over what is left, and over what went, with its
/// squares.
using LatticeBreaks = std::size_t (*)(const LatticeRows&, const std::uint8_t* weak, std::uint8_t* intact,
                                      const LatticeColumns& u, double limit, const double* factor, double* sum,
                                      double* lost, double* lost_square);
LatticeBreaks lattice_breaks();

/// Largest extension / length of bonds of points that are asked for (`asked`: by octet, bit by bit); 0 where none is
/// longer.
using LatticeStretch = double (*)(const LatticeRows&, const std::uint8_t* intact, const LatticeColumns& u,
                                  const std::uint8_t* asked);
LatticeStretch lattice_stretch();

#define GRUS_DECLARE_LANES(name)                                                                                     \
  namespace name {                                                                                                   \
  void lattice_dilation(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u,                \
                        const double* factor, double* sum, double* square);                                          \
  void lattice_forces(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u, const double* p, \
                      const double* q, double* force, std::size_t room);                                             \
  void lattice_stiffness(const LatticeRows& rows, const std::uint8_t* intact, const double* q, double* on,           \
                         double* off, std::size_t room);                                                             \
  std::size_t lattice_breaks(const LatticeRows& rows, const std::uint8_t* weak, std::uint8_t* intact,                \
                             const LatticeColumns& u, double limit, const double* factor, double* sum, double* lost, \
                             double* lost_square);                                                                   \
  double lattice_stretch(const LatticeRows& rows, const std::uint8_t* intact, const LatticeColumns& u,               \
                         const std::uint8_t* asked);                                                                 \
  }
GRUS_DECLARE_LANES(lanes1)
GRUS_DECLARE_LANES(lanes4)
GRUS_DECLARE_LANES(lanes8)
#undef GRUS_DECLARE_LANES

}  // namespace grus::dem
