// SPDX-License-Identifier: LGPL-3.0-or-later
// The results folder: whose it is, and who may write there.
#pragma once

#include "apps/run/command.hpp"

namespace grus::app {

/// Refuses, with InputError, a results folder that cannot be used: a file, a folder that holds something without
/// `force`, with `force` one that Grus has not made, for --resume one without a checkpoint. Changes nothing.
void check_folder(const Options& options);

/// Path of a file that a run writes into its results folder. Its name, relative to the folder, is noted in .grus first:
/// what is noted there, and nothing else, is what --force clears and what summary.json lists. Only who holds the folder
/// may call it.
std::string result_file(const std::string& directory, const std::string& name);

/// Files of the folder that its run has written, in order of their names; without frames, which their .series list.
std::vector<std::string> result_files(const std::string& directory);

/// The results folder while a run writes there: made, marked as Grus's, and locked against a second program.
class Folder {
public:
  /// Clears what an earlier run has left, and nothing of the user's, unless the run goes on from it. Throws InputError
  /// as check_folder does.
  explicit Folder(const Options& options);
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

private:
  int lock_ = -1;
};

}  // namespace grus::app
