// SPDX-License-Identifier: LGPL-3.0-or-later
// HDF5 files are made in memory and written like any other: a full disk is then one error of one write, not a library
// that cannot close its file.
#pragma once

#include <functional>
#include <string>

#include "dem/io/hdf5_handle.hpp"

namespace grus::dem {

/// The id, or std::runtime_error: "HDF5: cannot ...".
hid_t must(hid_t id, const std::string& what);

/// To be called before a file is made or opened. HDF5 says nothing by itself: errors are one line of ours. Where there
/// is no memory for the cache of a file it follows a null pointer (1.10, H5AC_create): this throws std::bad_alloc
/// first.
void begin_hdf5();

/// The bytes of a file that `fill` has filled. Throws std::runtime_error.
std::string hdf5_image(const std::function<void(hid_t file)>& fill);

}  // namespace grus::dem
