// SPDX-License-Identifier: LGPL-3.0-or-later
// checkpoint.h5: packed parts with offsets, replaced whole, with a checksum.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace grus::dem {

struct Checkpoint {
  std::string about;               // JSON: what the parts are, and whose run this is
  std::vector<std::string> parts;  // bytes
};

using TakePart = std::function<void(const std::string& part)>;

/// `parts` hands over the parts one after the other, so that they are never all held at once beside the file in memory.
/// Throws std::runtime_error where the file cannot be written; the old one then stays.
void write_checkpoint(const std::string& path, const std::string& about,
                      const std::function<void(const TakePart&)>& parts);

/// Throws InputError, one line, for a file that is missing, damaged, of another version or of another machine's layout.
Checkpoint read_checkpoint(const std::string& path);

}  // namespace grus::dem
