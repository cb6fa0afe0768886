// SPDX-License-Identifier: LGPL-3.0-or-later
// Grus as a library: the RVEs of a macro program, from a scene file, and nothing of the grains. docs/library.md
#pragma once

#include "apps/scene/open_rves.hpp"
#include "dem/base/error.hpp"
