// SPDX-License-Identifier: LGPL-3.0-or-later
// Grus as a library: RVEs of breakable grains as the material of other programs. docs/library.md
#pragma once

#include "dem/base/error.hpp"
#include "dem/rve/measure.hpp"
#include "dem/rve/rve.hpp"
#include "dem/rves/rve_set.hpp"
