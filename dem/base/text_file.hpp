// SPDX-License-Identifier: LGPL-3.0-or-later
// Text files that people bring, as their editors write them.
#pragma once

#include <istream>
#include <memory>
#include <string>

namespace grus::dem {

/// The text of a file as UTF-8: a byte order mark is left out, UTF-16 with its mark is translated. Null where there is
/// no such file. Throws InputError where the file is compressed.
std::unique_ptr<std::istream> open_text(const std::string& path);

}  // namespace grus::dem
