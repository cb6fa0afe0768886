// SPDX-License-Identifier: LGPL-3.0-or-later
// A box whose walls hold a stress.
#pragma once

#include "dem/rve/loading.hpp"

namespace grus::dem::test {

/// Drives all walls until they hold 1 MPa of compression along each axis, for 4 ms.
inline Loading hold_by_walls(const Model& model, State& s, Team& team) {
  Loading loading;
  loading.driven = loading.holds = true;
  for (auto& axis : loading.axes) axis = {0, -1e6, 100};
  begin_loading(model, s, loading);
  load(model, s, loading, 4e-3, team);
  return loading;
}

}  // namespace grus::dem::test
