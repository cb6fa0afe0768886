// SPDX-License-Identifier: LGPL-3.0-or-later
// Files are written aside, synced and renamed: a reader sees the old one or the new one, never a part.
#pragma once

#include <string>

namespace grus::dem {

/// Replaces `path` by `text`. Throws std::runtime_error with the system's reason.
void write_whole(const std::string& path, const std::string& text);

/// Syncs `aside` and renames it to `path`.
void put_in_place(const std::string& aside, const std::string& path);

}  // namespace grus::dem
