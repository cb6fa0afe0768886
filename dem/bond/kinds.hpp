// SPDX-License-Identifier: LGPL-3.0-or-later
// All kinds of bonds, for those who ask their rows something: a new kind is an include here.
#pragma once

#include "dem/bond/cohesive.hpp"
#include "dem/bond/face_bond.hpp"
