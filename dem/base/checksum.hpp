// SPDX-License-Identifier: LGPL-3.0-or-later
// Tells bytes that were damaged on their way; no protection against who wants to deceive.
#pragma once

#include <cstdint>
#include <string_view>

namespace grus::dem {

/// FNV-1a of `bytes`, after those whose checksum is `h`.
inline std::uint64_t checksum(std::string_view bytes, std::uint64_t h = 0xcbf29ce484222325ULL) {
  for (const char c : bytes) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return h;
}

}  // namespace grus::dem
