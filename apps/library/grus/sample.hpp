// SPDX-License-Identifier: LGPL-3.0-or-later
// Grus as a library: samples from recipes, without a scene file. docs/library.md
#pragma once

#include "dem/sample/gauge.hpp"
#include "dem/sample/network.hpp"
#include "dem/sample/prepare.hpp"
#include "grus/rve.hpp"
