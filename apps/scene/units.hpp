// SPDX-License-Identifier: LGPL-3.0-or-later
// Numbers with units: "60 GPa", "1.77 MPa m^0.5", "500 1/s".
#pragma once

#include <string>
#include <vector>

namespace grus::app {

/// Exponents of metre, kilogram and second, the name a message uses, and that of the radian: an angle is no number.
struct Dimension {
  double metre, kilogram, second;
  const char* name;
  double radian = 0;
};

namespace dimension {
inline constexpr Dimension none{0, 0, 0, "number"}, angle{0, 0, 0, "angle", 1}, length{1, 0, 0, "length"},
    time{0, 0, 1, "time"}, mass{0, 1, 0, "mass"}, density{-3, 1, 0, "density"}, pressure{-1, 1, -2, "stress"},
    rate{0, 0, -1, "rate"}, speed{1, 0, -1, "speed"}, acceleration{1, 0, -2, "acceleration"},
    stiffness{0, 1, -2, "stiffness (N/m)"}, toughness{-0.5, 1, -2, "fracture toughness"},
    stress_rate{-1, 1, -3, "stress rate"}, force{1, 1, -2, "force"}, area{2, 0, 0, "area"},
    surface_energy{0, 1, -2, "energy per area (J/m^2)"}, foundation{-2, 1, -2, "stress per length (Pa/m)"};
}

/// SI value of a text such as "0.3 mm"; a bare number is SI, an angle in radians. Throws std::invalid_argument with
/// what is wrong (and a suggestion) where the unit is unknown or of another dimension.
double parse_quantity(const std::string& text, const Dimension& expected);

/// The candidate closest to `word`, or empty if none is close.
std::string closest(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace grus::app
