// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene of grus-rve: tables -> option structs of dem.
#pragma once

#include <nlohmann/json.hpp>

#include "dem/base/error.hpp"
#include "dem/packing/cells.hpp"
#include "dem/packing/packing.hpp"
#include "dem/rve/loading.hpp"

namespace grus::app {

class Table;
using dem::InputError;

struct Preparation {
  double pressure = 0;  // Pa
  double friction = 0;  // between grains while the sample is compressed
  dem::QuasiStatic quasi_static;
};

/// What the test does and when it ends.
struct TestProgram {
  std::string kind;
  int axis = 2;
  double strain_rate = 0;              // 1/s, compression-positive, of the driven axis
  double duration = 0;                 // s; an upper bound where final_stress decides
  std::optional<double> final_stress;  // Pa, compression-positive: ends the test when reached
  std::optional<double> stress_time;   // s, at which a stress that is controlled gets there
  dem::Loading loading;
};

struct Output {
  double history_interval = 0;             // s
  double bursts = 0;                       // s, window of bursts.csv; 0: none
  bool contacts = false, wrapped = false;  // beside the frames; grains drawn inside the periodic cell
  int frames = 0, gradings = 0;
  bool grading = false;              // size and shape columns in history.csv
  double checkpoint_interval = 300;  // s of wall time; an interrupted run writes one in any case
};

/// A random packing that is still to be made: that takes long, and can be watched and stopped.
struct PendingPacking {
  dem::Vec3 box = dem::Vec3::Zero();
  dem::RadiusDistribution radius;
  double solid_fraction = 0;
  std::size_t count = 0;  // 0: as many as fill the fraction
  dem::Container container = dem::Container::box;
  bool turned = false;
  /// What grains are made of, and how they are shaped: axes of an ellipsoid of the sphere's volume, relative.
  struct Part {
    std::uint8_t material = 0;
    double share = 1;
    dem::Vec3 aspect = dem::Vec3::Ones();
  };
  std::vector<Part> parts;  // one where nothing is mixed
  /// Grains are random hulls.
  struct Hulls {
    int rounds;        // of relaxation
    dem::Vec3 aspect;  // lengths along three axes
  };
  std::optional<Hulls> hulls;
  std::string place;  // file, line and key, for what is refused

  double volume() const { return dem::volume_of(container, box); }
  double grains() const;  // how many there will be, about
};

struct RveScene {
  std::string file, title;
  dem::Model model;
  dem::State state;  // grains and boundary; not prepared. No grains yet while a packing is pending
  std::optional<PendingPacking> pending;
  std::optional<Preparation> preparation;
  TestProgram test;
  Output output;
  std::size_t listed_grains = 0;
  double packing_overlap = 0;
  double scale = 1;  // grains are this many times larger than what they stand for; gradings are told of the latter
  nlohmann::json prepared;         // what [preparation] was asked and has reached; null: there is none, or not yet
  nlohmann::json record;           // the scene as used, defaults included
  std::vector<std::string> notes;  // what the user should know before it runs
  /// What tells the load of a test on cells.
  struct Gauge {
    std::vector<std::pair<std::size_t, double>> walls;  // and their weights
    dem::Vec3 along;                                    // unit, of the motion
    std::size_t moving = 0;                             // wall whose way is the displacement
    double stress_per_load = 0;                         // 1/m^2
  };
  struct Cells {
    dem::BondedFaces faces;
    dem::Vec3 box;  // m, that they fill
    bool round;     // as a cylinder along z
    std::optional<Gauge> gauge = {};
  };
  std::optional<Cells> cells;  // of [packing] kind = "voronoi"

  bool of_hulls() const { return pending ? pending->hulls.has_value() : !state.grains.hull.empty(); }
  bool bonded() const { return cells && cells->faces.bonds > 0; }
  double grains() const { return pending ? pending->grains() : static_cast<double>(state.grains.size()); }
};

/// Reads and checks a scene. Throws InputError with file, line and key.
RveScene read_rve_scene(const std::string& file, const std::vector<std::string>& overrides);

/// The same for the unit cell of a boundary-value problem: periodic, no loading or output needed.
RveScene read_unit_cell(const std::string& file, const std::vector<std::string>& overrides);

/// All [material.*] tables and [numerics] into the model (pair laws are made by the caller, after walls are known).
void read_model(Table& scene, dem::Model& model, bool unit_cell);

/// Quasi-static keys (strain_per_step, inertial_number, unbalanced_force, stress_change, pressure_floor, window,
/// max_hold) of a table.
dem::QuasiStatic read_quasi_static(Table& table);

}  // namespace grus::app
