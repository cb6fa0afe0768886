// SPDX-License-Identifier: LGPL-3.0-or-later
// Springs of faces that make a solid of a modulus and a Poisson's ratio.
#pragma once

namespace grus::dem {

/// A solid's modulus (Pa) and Poisson's ratio.
struct Elasticity {
  double modulus, poissons_ratio;
};

/// Springs of the faces of Voronoi cells: normal stiffness times the distance of the cells (Pa), and shear over normal.
struct Network {
  double stiffness, ratio;
};

/// Poisson's ratios that rigid Voronoi cells with springs of faces show: from 0 to this.
inline constexpr double most_poisson = 0.26;

/// The network that shows an elasticity, and the elasticity that a network shows: those of many relaxed Voronoi cells
/// (docs/bonded.md), straight between the rows of a table; ratios from 0.05 to 1.
Network network_of(const Elasticity& solid);
Elasticity solid_of(const Network& network);

}  // namespace grus::dem
