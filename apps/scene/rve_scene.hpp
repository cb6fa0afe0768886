// SPDX-License-Identifier: LGPL-3.0-or-later
// A scene of grus-rve: what its tables ask for. No grain is made here (dem/sample).
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>

#include "dem/base/error.hpp"
#include "dem/sample/programme.hpp"
#include "dem/sample/recipe.hpp"

namespace grus::app {

class Table;
using dem::InputError;

struct Output {
  double history_interval = 0;             // s; of a test between platens known once its sample is made
  double history_strain = 0;               // the same as strain of the test; 0: it was told as a time, or not at all
  std::string place_of_history;            // for what is refused
  double bursts = 0;                       // s, window of bursts.csv; 0: none
  std::string place_of_bonds;              // of the key that asks for broken bonds
  bool broken_bonds = false;               // each in broken_bonds.csv
  bool contacts = false, wrapped = false;  // beside the frames; grains drawn inside the periodic cell
  int frames = 0, gradings = 0;
  std::size_t lattice = 0;           // so many grains that crack are written point by point
  bool grading = false;              // size and shape columns in history.csv
  bool wall_forces = false;          // columns of every wall of a box or cylinder
  bool strain_gauges = false;        // columns of the strain in the middle between platens
  bool critical_grain = false;       // columns of the grain that sets the time step
  bool last_state = false;           // kept as a checkpoint, to go on from
  double checkpoint_interval = 300;  // s of wall time; an interrupted run writes one in any case
};

struct RveScene {
  std::string file, title;
  std::string start, place_of_start;  // folder of the run whose last state this one begins in; empty: none
  dem::Model model;
  dem::Recipe recipe;
  dem::Programme test;
  Output output;
  double scale = 1;  // grains are this many times larger than what they stand for; gradings are told of the latter
  std::shared_ptr<const nlohmann::json> record;  // the scene as used, defaults included
  std::vector<std::string> notes;                // what the user should know before it runs

  std::size_t listed_grains() const { return recipe.listed() ? recipe.listed()->size() : 0; }
};

/// Reads and checks a scene. Throws InputError with file, line and key.
RveScene read_rve_scene(const std::string& file, const std::vector<std::string>& overrides);

/// The same for the unit cell of a boundary-value problem: periodic, no loading or output needed.
RveScene read_unit_cell(const std::string& file, const std::vector<std::string>& overrides);

/// Sizes of the fines as shares of the grain that broke, or in m. `balls`: "fragment" may be said, too.
void read_fines(Table& table, bool balls, dem::FinesGrading& fines);

/// All [material.*] tables and [numerics] into the model (pair laws are made by the caller, after walls are known).
void read_model(Table& scene, dem::Model& model, bool unit_cell);

/// Unit cells are quasi-static: the share of the critical step that costs them no error (docs/studies/cell_step.txt),
/// less where grains break, whose energy closes worse.
inline double unit_cell_safety(const dem::Model& model) { return model.breakable() ? 0.5 : 0.7; }

/// Quasi-static keys (strain_per_step, inertial_number, unbalanced_force, stress_change, pressure_floor, window,
/// max_hold) of a table.
dem::QuasiStatic read_quasi_static(Table& table);

}  // namespace grus::app
