// SPDX-License-Identifier: LGPL-3.0-or-later
// Files are written aside, synced and renamed: a reader sees the old one or the new one, never a part. Or they grow at
// their end.
#pragma once

#include <string>
#include <string_view>

namespace grus::dem {

/// Replaces `path` by `text`. Throws std::runtime_error with the system's reason; the old file then stays, and nothing
/// beside it.
void write_whole(const std::string& path, const std::string& text);

/// Adds to the end of a file that is `size` bytes long, lines that a reader may follow. Throws std::runtime_error with
/// the system's reason; the file is then as long as it was.
void append(const std::string& path, std::size_t size, std::string_view text);

}  // namespace grus::dem
