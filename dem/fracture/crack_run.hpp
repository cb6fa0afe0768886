// SPDX-License-Identifier: LGPL-3.0-or-later
// Whether a peridynamic solid holds a load, and how it cracks under it (units of peridynamic.hpp, bonds break at the
// stretch 1).
#pragma once

#include "dem/fracture/clusters.hpp"

namespace grus::dem {

enum class Hold {
  holds,
  fails,
  unsettled  // after as many rounds as are worth it, or half as much work again as when intact
};

struct HoldTest {
  Hold verdict = Hold::unsettled;
  int rounds = 0, iterations = 0, solves = 0;
  double work = 1;  // load times displacement at the last equilibrium, over that of the intact solid
  double lost = 0;  // energy that broken bonds gave up

  bool holds() const { return verdict == Hold::holds; }
};

/// When the test by static answers ends. `rounds` and `work`: beyond, nothing is said; `failed`: beyond, it fails.
struct HoldLimits {
  int rounds = 25;
  double work = 1.5, failed = 2.5;
  static constexpr double tolerance = 1e-3, coarse = 1e-2;  // of answers that hold, and while bonds break
  static constexpr int iterations = 200;
};

/// From the answer `u` of the intact solid: breaks all bonds above their limit and solves again, roughly while some
/// break, until none is (it holds), or there is no answer near (it fails). `u` and the solid are left at the last
/// equilibrium; after it the bonds that are too long there are broken.
HoldTest hold_test(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, const HoldLimits& limits = {});

struct CrackChoice {
  double damping = 3.2;                   // times c_p / d
  double time = 2;                        // passages of c_p through d after it has parted
  double smallest_piece = 0.03;           // share of the points
  bool crumbs = false;                    // what is smaller is told as such
  static constexpr double quiet = 15;     // passages without a break under the whole load: it holds
  static constexpr double pause = 5;      // the same under a part of it: the load goes on
  static constexpr int most_steps = 900;  // without parting: the load is raised
  static constexpr double raise = 1.05;
  static constexpr int raises = 3;  // above the whole load
  static constexpr int most_in_all = 4000;
  static constexpr double torn = 5;  // times what the whole load displaces at rest: a patch is off, its load with it
};

/// The largest share of a load, in powers of 1 / CrackChoice::raise, that the solid holds, where it does not hold the
/// whole: the load will have grown to it. The solid and `u` are left at rest under it, or it holds none. `whole`: the
/// intact solid's answer to the whole load.
struct LastHold {
  double share = 0;
  HoldTest test;  // of that share; rounds, iterations and solves of all tests
};
LastHold last_hold(PeridynamicSolid& solid, const PointColumns& load, const PointColumns& whole, PointColumns& u);

enum class CrackEnd { parts, holds, stalls };

struct CrackRun {
  CrackEnd end = CrackEnd::stalls;
  int steps = 0;
  double load_factor = 1;  // when it ended
  double lost = 0;         // energy that broken bonds gave up
  Clusters clusters;       // where it parts
};

/// Steps of central differences from rest at `u` under a dead load, bonds breaking in each. It begins at a share of the
/// load, and goes up by twentieths where nothing breaks any more. Parted are two clusters, or what a contact has torn
/// out from the rest (torn_apart).
CrackRun crack_run(PeridynamicSolid& solid, const PointColumns& load, PointColumns& u, const CrackChoice& choice,
                   double share = 1);

}  // namespace grus::dem
