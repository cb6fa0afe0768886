// SPDX-License-Identifier: LGPL-3.0-or-later
// An HDF5 object that closes itself.
#pragma once

#include <hdf5.h>

namespace grus::dem {

struct Handle {
  hid_t id;
  herr_t (*close)(hid_t);
  Handle(hid_t id_, herr_t (*close_)(hid_t)) : id(id_), close(close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (id >= 0) close(id);
  }
};

}  // namespace grus::dem
