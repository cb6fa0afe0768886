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

/// What some steps after a warm-up took and made.
struct Timed {
  double seconds = 0, contacts = 0;  // a grain
  double stress = 0;                 // Pa, compressive along z: pairs of grains alone, over the volume at the start
  dem::State state;                  // at their end
};
Timed time_steps(const Sample& sample, std::uint64_t steps, int threads, std::uint64_t warm);
double seconds_of_steps(const Sample& sample, std::uint64_t steps, int threads, std::uint64_t warm);
/// The share of the time of those steps that making neighbour lists took.
double share_of_lists(const Sample& sample, Timed& run);
/// ns a touching pair in the contact pass alone.
double contact_nanoseconds(Sample& sample);
/// The loop of contact pass and sweep alone, nothing else asked: what a program without breakage, bonds and the rest
/// would run.
double seconds_of_bare_steps(const Sample& sample, std::uint64_t steps);

/// A periodic cell as another program made it: "N", nine numbers of the cell's vectors by rows, then "x y z r"; no
/// dashpots, local damping 0.2, friction 0.5.
Sample read_cell(const std::string& file);
/// `count` such increments one after the other at a share of the critical step, from the cell at rest: median seconds,
/// mean steps, the largest error of an increment's stress against closure to 1e-6, and the last one's axial stress
/// (Pa).
struct Path {
  double seconds, steps, error, stress;
};
Path increments(const Sample& cell, double safety, int count);

/// Speed-up of two threads over one in advancing `count` cells by 1e-4 each.
double farm_speed_up(const Sample& sample, std::size_t count);

}  // namespace grus::bench
