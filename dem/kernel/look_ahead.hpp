// SPDX-License-Identifier: LGPL-3.0-or-later
// How far ahead the kernels of spheres ask for what they read.
#pragma once

#include <cstddef>

namespace grus::dem {

/// Samples of more grains are larger than a core's own cache (half to one MB): what they read is asked for ahead. In
/// smaller ones that costs instructions and gains nothing.
inline constexpr std::size_t near_grains = 4096;
/// Motions are asked for so many pairs ahead, histories so many. The plan's column b is longer by `grains_ahead`.
inline constexpr std::size_t grains_ahead = 64, histories_ahead = 128;

}  // namespace grus::dem
