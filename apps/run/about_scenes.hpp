// SPDX-License-Identifier: LGPL-3.0-or-later
// Answers of the commands about scenes, without running one: --new, --keys, --schema.
#pragma once

#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace grus::app {

/// The options that ask for them.
struct About {
  std::optional<std::string> keys;  // those that hold this text
  std::string kind;                 // of a new scene
  bool schema = false;

  bool asked() const { return keys || schema || !kind.empty(); }
};

/// Adds the options; `program` is "rve" or "bvp".
void add_about(CLI::App& cli, const std::string& program, About& about);

/// Prints it, or writes a new scene to `file` (KIND.toml where it is empty), which must not be there yet. Throws
/// InputError, std::runtime_error.
void tell(const About& about, const std::string& program, const std::string& file);

}  // namespace grus::app
