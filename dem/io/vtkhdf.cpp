// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/vtkhdf.hpp"

#include <fmt/format.h>

#include <array>

#include "dem/io/hdf5_image.hpp"
#include "dem/io/whole_file.hpp"

namespace grus::dem {
namespace {

template <class T>
hid_t type_of();
template <>
hid_t type_of<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
hid_t type_of<std::int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
hid_t type_of<std::uint8_t>() {
  return H5T_NATIVE_UINT8;
}

template <class T>
void dataset(hid_t group, const std::string& name, const std::vector<T>& values, int components) {
  const hsize_t rows = values.size() / static_cast<std::size_t>(components);
  const hsize_t size[2] = {rows, static_cast<hsize_t>(components)};
  const int rank = components > 1 ? 2 : 1;
  Handle space{must(H5Screate_simple(rank, size, nullptr), "make a data space"), H5Sclose};
  Handle properties{must(H5Pcreate(H5P_DATASET_CREATE), "make properties"), H5Pclose};
  H5Pset_obj_track_times(properties.id, false);  // the time of day is no result: the same frames have the same bytes
  if (rows > 64) {
    const hsize_t chunk[2] = {std::min<hsize_t>(rows, 65536), size[1]};
    H5Pset_chunk(properties.id, rank, chunk);
    H5Pset_shuffle(properties.id);
    H5Pset_deflate(properties.id, 1);
  }
  Handle data{must(H5Dcreate2(group, name.c_str(), type_of<T>(), space.id, H5P_DEFAULT, properties.id, H5P_DEFAULT),
                   "make a dataset"),
              H5Dclose};
  must(H5Dwrite(data.id, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write a dataset");
}

void fields(hid_t root, const char* name, const std::map<std::string, VtkField>& all) {
  if (all.empty()) return;
  Handle group{must(H5Gcreate2(root, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), "make a group"), H5Gclose};
  for (const auto& [key, field] : all) dataset(group.id, key, field.values, field.components);
}

}  // namespace

void write_vtkhdf(const std::string& path, const VtkGrid& grid) {
  write_whole(
      path, hdf5_image([&](hid_t file) {
        Handle root{must(H5Gcreate2(file, "VTKHDF", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), "make a group"), H5Gclose};
        {
          const hsize_t two = 2;
          const std::array<std::int64_t, 2> version{1, 0};
          Handle space{H5Screate_simple(1, &two, nullptr), H5Sclose};
          Handle attribute{H5Acreate2(root.id, "Version", H5T_NATIVE_INT64, space.id, H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose};
          must(H5Awrite(attribute.id, H5T_NATIVE_INT64, version.data()), "write an attribute");
          Handle text{H5Tcopy(H5T_C_S1), H5Tclose};  // fixed-length ASCII: what VTK's reader accepts
          H5Tset_size(text.id, 16);
          H5Tset_strpad(text.id, H5T_STR_NULLPAD);
          Handle scalar{H5Screate(H5S_SCALAR), H5Sclose};
          Handle type{H5Acreate2(root.id, "Type", text.id, scalar.id, H5P_DEFAULT, H5P_DEFAULT), H5Aclose};
          must(H5Awrite(type.id, text.id, "UnstructuredGrid"), "write an attribute");
        }
        using Counts = std::vector<std::int64_t>;
        dataset(root.id, "NumberOfPoints", Counts{static_cast<std::int64_t>(grid.points.size() / 3)}, 1);
        dataset(root.id, "NumberOfCells", Counts{static_cast<std::int64_t>(grid.types.size())}, 1);
        dataset(root.id, "NumberOfConnectivityIds", Counts{static_cast<std::int64_t>(grid.connectivity.size())}, 1);
        dataset(root.id, "Points", grid.points, 3);
        dataset(root.id, "Connectivity", grid.connectivity, 1);
        dataset(root.id, "Offsets", grid.offsets, 1);
        dataset(root.id, "Types", grid.types, 1);
        fields(root.id, "PointData", grid.point_fields);
        fields(root.id, "CellData", grid.cell_fields);
      }));
}

void write_series(const std::string& path, const std::vector<std::pair<std::string, double>>& files) {
  std::string text = "{\"file-series-version\": \"1.0\", \"files\": [";
  for (std::size_t i = 0; i < files.size(); ++i)
    text += fmt::format("{}\n  {{\"name\": \"{}\", \"time\": {:.9g}}}", i ? "," : "", files[i].first, files[i].second);
  write_whole(path, text + "\n]}\n");
}

}  // namespace grus::dem
