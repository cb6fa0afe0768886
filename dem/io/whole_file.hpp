// SPDX-License-Identifier: LGPL-3.0-or-later
// Files are written aside, synced and renamed: a reader sees the old one or the new one, never a part.
#pragma once

#include <string>

namespace grus::dem {

/// Replaces `path` by `text`. Throws std::runtime_error with the system's reason; the old file then stays, and nothing
/// beside it.
void write_whole(const std::string& path, const std::string& text);

}  // namespace grus::dem
