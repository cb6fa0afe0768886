// SPDX-License-Identifier: LGPL-3.0-or-later
// Speeds that a scene asks for, against those of waves in its grains.
#pragma once

#include "apps/scene/reader.hpp"
#include "dem/rve/model.hpp"

namespace grus::app {

/// Twice the speed of a bar's wave, sqrt(E / density), in the material where that is largest (m/s): pressure waves of
/// solids up to a Poisson's ratio of 0.45 are slower.
double fastest_wave(const dem::Model& model);

/// Refuses what moves faster than waves in every grain: these would be passed before they could press back.
void refuse_fast(const Table& t, const std::string& key, double speed, const dem::Model& model);

/// The same of a rate of strain (1/s) of a sample that is so long (m) along the axis, or so high where it is sheared.
void refuse_fast_rate(const Table& t, const std::string& key, double rate, double length, const dem::Model& model);

/// Refuses a pressure (Pa) above the stiffness of every grain, which no contact could bear. `what` leads to it.
void refuse_high_pressure(const Table& t, const std::string& key, double pressure, const dem::Model& model,
                          const std::string& what = "");

/// A velocity, (0, 0, 0) where it is absent, that is not too fast.
dem::Vec3 read_velocity(Table& t, const dem::Model& model);

}  // namespace grus::app
