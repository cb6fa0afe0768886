// SPDX-License-Identifier: LGPL-3.0-or-later
// The works that are timed.
#pragma once

#include <string>
#include <vector>

#include "dem/rve/model.hpp"
#include "dem/rve/rve.hpp"
#include "dem/rve/state.hpp"

namespace grus::bench {

/// One line of the table.
struct Row {
  std::string work, unit;
  double value = 0;             // in `unit`
  double bytes = 0, flops = 0;  // a grain-step, counted by hand; 0: no roofline for this work
  double touched = 0;           // bytes that a step goes through
};

/// A sample ready to run, with the model it belongs to.
struct Sample {
  dem::Model model;
  dem::State state;
};

/// Centres and radii in a box of walls: "N L", then "x y z r".
struct Packing {
  double size = 0;
  std::vector<dem::Vec3> centre;
  std::vector<double> radius;
};
Packing read_packing(const std::string& file);
/// Dense, about `grains` grains, radii 1:`ratio`: placed at random, then compressed by the walls.
Packing make_packing(std::size_t grains, double ratio);
/// Simple-cubic lattice of layers^3 equal spheres, a thousandth overlapped: large samples at no cost.
Packing lattice(int layers);
void write_packing(const std::string& file, const Packing& packing);

/// Hertz-Mindlin spheres (60 GPa, friction 0.5, restitution 0.5) between walls, the top one coming down at 500/s.
Sample boxed(const Packing& packing);
/// A periodic cell of spheres or poly-ellipsoids at a pressure (Pa).
Sample celled(std::size_t grains, bool shapes, double pressure);

/// ns a grain to make its neighbour list anew.
double list_nanoseconds(const Sample& sample);
/// Bytes of a prepared sample's state.
double bytes_of(const Sample& sample);

double seconds_of_steps(const Sample& sample, std::uint64_t steps, int threads, std::uint64_t warm,
                        double* contacts = nullptr, double* rebuild_share = nullptr);
/// ns a touching pair in the contact pass alone.
double contact_nanoseconds(Sample& sample);
/// The loop of contact pass and sweep alone, nothing else asked: what a program without breakage, bonds and the rest
/// would run.
double seconds_of_bare_steps(const Sample& sample, std::uint64_t steps);

/// One increment of 1e-3 (uniaxial) of a cell, closed to an unbalanced force: seconds, and the relative error of the
/// stress against the same increment closed to 1e-6.
struct Increment {
  double seconds, steps, error;
};
Increment uniaxial_increment(const Sample& sample, double unbalanced, int count);

/// Speed-up of two threads over one in advancing `count` cells by 1e-4 each.
double farm_speed_up(const Sample& sample, std::size_t count);

}  // namespace grus::bench
