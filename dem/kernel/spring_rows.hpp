// SPDX-License-Identifier: LGPL-3.0-or-later
// The springs of a contact: rows of one elastic-plastic spring (contact/springs.hpp, kernel/spring_stage.hpp).
#pragma once

#include <cstddef>

namespace grus::dem {

/// The first is the tangential force, stretched by the slip. The others, from `first_couple` on, hold couples over the
/// effective radius, and are stretched by how the two turn against each other, times that radius. All have one
/// stiffness and limits of their own.
enum SpringRow : std::size_t { slide_spring, roll_spring, spring_rows, first_couple = roll_spring };

/// Those that hold couples.
inline constexpr SpringRow couple_springs[] = {roll_spring};
static_assert(sizeof couple_springs == (spring_rows - first_couple) * sizeof(SpringRow));

}  // namespace grus::dem
