// SPDX-License-Identifier: LGPL-3.0-or-later
// Scenes that are refused, in this process: a scene that reads, and changes of it that do not.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "dem/base/error.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/catch.hpp"

namespace grus::app::test {

struct Refusal {
  const char* scene;                 // TOML
  std::vector<std::string> changes;  // as --set takes them
  const char* says;                  // part of the message
};

/// Each scene reads as it is, and with the changes of a row throws what the row says.
template <class Read>
void check_refused(const std::vector<Refusal>& rows, Read&& read) {
  const Scratch scratch;
  const auto said = [&](const char* scene, const std::vector<std::string>& changes) -> std::string {
    const std::string file = scratch.path + "/scene.toml";
    std::ofstream(file) << scene;
    try {
      read(file, changes);
    } catch (const dem::InputError& e) {
      return e.what();
    }
    return "";
  };
  const char* last = nullptr;
  for (const Refusal& row : rows) {
    if (row.scene != last) {
      INFO(row.scene);
      CHECK(said(row.scene, {}) == "");
      last = row.scene;
    }
    const std::string why = said(row.scene, row.changes);
    INFO(row.says << " is not in: " << why);
    CHECK(why.find(row.says) != std::string::npos);
  }
}

}  // namespace grus::app::test
