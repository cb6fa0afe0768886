// SPDX-License-Identifier: LGPL-3.0-or-later
// VTKHDF unstructured grids (version 1.0, which ParaView 5.11 reads as *.hdf) and their time series.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace grus::dem {

/// A field of `components` values for each point or VTK cell.
struct VtkField {
  int components = 1;
  std::vector<float> values;
};

struct VtkGrid {
  std::vector<float> points;                        // x y z
  std::vector<std::int64_t> connectivity, offsets;  // offsets: VTK cells + 1
  std::vector<std::uint8_t> types;                  // VTK cell types
  std::map<std::string, VtkField> point_fields, cell_fields;
};

/// Writes the grid whole or not at all; throws std::runtime_error.
void write_vtkhdf(const std::string& path, const VtkGrid& grid);

/// The index that ParaView opens: `files` are names beside it.
void write_series(const std::string& path, const std::vector<std::pair<std::string, double>>& files);

}  // namespace grus::dem
