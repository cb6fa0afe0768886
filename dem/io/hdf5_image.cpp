// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/hdf5_image.hpp"

#include <new>
#include <stdexcept>

namespace grus::dem {

hid_t must(hid_t id, const std::string& what) {
  if (id < 0) throw std::runtime_error("HDF5: cannot " + what);
  return id;
}

void begin_hdf5() {
  constexpr std::size_t cache = std::size_t{2} << 20;  // bytes, with room to spare
  ::operator delete(::operator new(cache));
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string hdf5_image(const std::function<void(hid_t file)>& fill) {
  begin_hdf5();
  const Handle access{must(H5Pcreate(H5P_FILE_ACCESS), "make properties"), H5Pclose};
  must(H5Pset_fapl_core(access.id, std::size_t{1} << 20, false), "make a file in memory");
  const Handle file{must(H5Fcreate("in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access.id), "make a file in memory"),
                    H5Fclose};
  fill(file.id);
  must(H5Fflush(file.id, H5F_SCOPE_GLOBAL), "flush a file in memory");
  const auto size = must(H5Fget_file_image(file.id, nullptr, 0), "tell the size of a file");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  must(H5Fget_file_image(file.id, bytes.data(), bytes.size()), "read a file in memory");
  return bytes;
}

}  // namespace grus::dem
