// SPDX-License-Identifier: LGPL-3.0-or-later
// Grus as a library: RVEs from the scene files of grus-rve. docs/library.md
#pragma once

#include "apps/scene/open_rves.hpp"
#include "apps/scene/prepare_sample.hpp"
#include "apps/scene/unit_cells.hpp"
#include "grus/rve.hpp"
