// SPDX-License-Identifier: LGPL-3.0-or-later
// Numbers with units: "60 GPa", "1.77 MPa m^0.5", "500 1/s".
#pragma once

#include <string>
#include <vector>

namespace grus::app {

/// Exponents of metre, kilogram and second, the name and the SI unit that a message uses, and the exponent of the
/// radian: an angle is no number.
struct Dimension {
  double metre, kilogram, second;
  const char* name;
  const char* unit = "";
  double radian = 0;
};

namespace dimension {
inline constexpr Dimension none{0, 0, 0, "number"}, angle{0, 0, 0, "angle", "rad", 1}, length{1, 0, 0, "length", "m"},
    time{0, 0, 1, "time", "s"}, mass{0, 1, 0, "mass", "kg"}, density{-3, 1, 0, "density", "kg/m^3"},
    pressure{-1, 1, -2, "stress", "Pa"}, rate{0, 0, -1, "rate", "1/s"}, speed{1, 0, -1, "speed", "m/s"},
    acceleration{1, 0, -2, "acceleration", "m/s^2"}, stiffness{0, 1, -2, "stiffness (N/m)", "N/m"},
    toughness{-0.5, 1, -2, "fracture toughness", "Pa m^0.5"}, stress_rate{-1, 1, -3, "stress rate", "Pa/s"},
    force{1, 1, -2, "force", "N"}, area{2, 0, 0, "area", "m^2"},
    surface_energy{0, 1, -2, "energy per area (J/m^2)", "J/m^2"},
    foundation{-2, 1, -2, "stress per length (Pa/m)", "Pa/m"};
}

/// A number as it was written: its SI value, its unit (empty: none) and how much of SI that is.
struct Quantity {
  double value = 0;
  std::string unit = {};
  double factor = 1;
};

/// Reads a text such as "0.3 mm"; a bare number is SI, an angle in radians. Throws std::invalid_argument with what is
/// wrong (and a suggestion) where the unit is unknown or of another dimension.
Quantity parse_quantity(const std::string& text, const Dimension& expected);

/// A bound (SI) in the unit of the number that it bounds: "88.2 deg". To a number without a unit an angle is told both
/// ways: "1.53938 rad (88.2 deg)".
std::string bound_text(double bound, const Quantity& of, const Dimension& dimension);

/// The candidate closest to `word`, or empty if none is close.
std::string closest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace grus::app
