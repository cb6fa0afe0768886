// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "dem/base/error.hpp"

namespace grus::app {
namespace {

const char* const marker = ".grus";  // in folders that Grus has made; the lock

bool holds_something(const std::string& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().filename() != marker) return true;
  return false;
}

[[noreturn]] void in_use(const std::string& folder) {
  throw dem::InputError(fmt::format("{}: another run is writing to this folder; use another -o DIR", folder));
}

/// A marker is a file of the folder's own: a link is no sign of Grus, and leads elsewhere.
bool marked(const std::filesystem::path& mark) {
  return std::filesystem::is_regular_file(std::filesystem::symlink_status(mark));
}

/// An open file that holds the lock; -1: somebody else has it.
int locked(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0) throw std::runtime_error(fmt::format("{}: cannot write: {}", path, std::strerror(errno)));
  for (int tries = 0; tries < 20; ++tries) {  // the ranks of an mpirun that was killed outlive it for a moment
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  ::close(file);
  return -1;
}

void clear(const std::string& folder) {
  namespace fs = std::filesystem;
  for (const char* old : {"grains", "contacts", "macro"})
    fs::remove_all(fs::path(folder) / old);  // frames of another run would mix in
  std::vector<fs::path> probes;              // a folder of frames lies beside its index
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && entry.path().filename().string().starts_with("grains_") &&
        fs::exists(entry.path().string() + ".hdf.series"))
      probes.push_back(entry.path());
  for (const auto& probe : probes) fs::remove_all(probe), fs::remove(probe.string() + ".hdf.series");
  for (const char* old :
       {"grains.hdf.series", "contacts.hdf.series", "macro.hdf.series", "history.csv", "grading.csv", "hopkinson.csv",
        "costs.csv", "summary.json", "report.html", "checkpoint.h5", "preparation.h5"})
    fs::remove(fs::path(folder) / old);
}

}  // namespace

void check_folder(const Options& options) {
  namespace fs = std::filesystem;
  const std::string& folder = options.directory;
  const fs::path mark = fs::path(folder) / marker;
  if (options.resume) {
    if (!fs::exists(fs::path(folder) / "checkpoint.h5") && !fs::exists(fs::path(folder) / "preparation.h5"))
      throw dem::InputError(folder + "/checkpoint.h5: no checkpoint to resume from");
  } else if (fs::exists(folder)) {
    if (!fs::is_directory(folder)) throw dem::InputError(fmt::format("{}: is a file; name a folder with -o", folder));
    if (holds_something(folder)) {
      if (!options.force)
        throw dem::InputError(fmt::format("{}: folder is not empty; use another -o DIR, or --force", folder));
      if (!marked(mark))
        throw dem::InputError(
            fmt::format("{}: folder is not empty and was not made by Grus: --force clears only what Grus has made; use "
                        "another -o DIR",
                        folder));
    }
  }
  if (fs::is_symlink(mark))
    throw dem::InputError(
        fmt::format("{}: is a link: the folder was not made by Grus; use another -o DIR", mark.string()));
  if (!marked(mark)) return;
  const int file = locked(mark.string(), O_RDWR);
  if (file < 0) in_use(folder);
  ::close(file);
}

Folder::Folder(const Options& options) {
  namespace fs = std::filesystem;
  check_folder(options);
  std::error_code error;
  fs::create_directories(options.directory, error);
  if (error)
    throw std::runtime_error(fmt::format("{}: cannot create the folder: {}", options.directory, error.message()));
  lock_ = locked((fs::path(options.directory) / marker).string(), O_RDWR | O_CREAT);
  if (lock_ < 0) in_use(options.directory);
  if (!options.resume) clear(options.directory);
  if (options.log) options.log->begin();
}

Folder::~Folder() {
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace grus::app
