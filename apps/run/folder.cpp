// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include "apps/run/same_scene.hpp"
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

/// What the marker lists: files of the folder, relative to it; of frames, whose number is any, with a star for it.
std::vector<std::string> noted(const std::string& folder) {
  std::vector<std::string> names;
  std::ifstream marks(std::filesystem::path(folder) / marker);
  for (std::string name; std::getline(marks, name);) names.push_back(name);
  return names;
}

/// What earlier versions left, whose markers are empty.
std::vector<std::string> unnoted(const std::string& folder) {
  std::vector<std::string> names{"history.csv", "grading.csv",  "hopkinson.csv", "costs.csv",
                                 "bursts.csv",  "summary.json", "report.html",   "checkpoint.h5"};
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with(".hdf.series")) continue;
    const std::string frames = name.substr(0, name.find('.'));  // they lie in a folder beside it
    names.insert(names.end(), {name, fmt::format("{0}/{0}_*.hdf", frames), frames + "/grains_*.hdf"});
  }
  return names;
}

/// How a file is noted: frames of one kind in one line.
std::string note_of(const std::string& name) {
  const std::size_t end = name.rfind('.'), begin = name.find_last_not_of("0123456789", end - 1) + 1;
  return name.find('/') != std::string::npos && end != std::string::npos && begin < end
             ? name.substr(0, begin) + "*" + name.substr(end)
             : name;
}

/// A file of the folder itself or of one of its own folders: a name that leads elsewhere is none of ours.
bool inside(const std::filesystem::path& folder, const std::filesystem::path& name) {
  namespace fs = std::filesystem;
  if (name.empty() || name.is_absolute() || !name.has_filename()) return false;
  for (const auto& part : name)
    if (part == ".." || part == "." || part == marker) return false;
  fs::path at = folder;
  for (const auto& part : name.parent_path())
    if (!fs::is_directory(fs::symlink_status(at /= part))) return false;
  return true;
}

/// Files that a note means, and what is left of them by a run that was killed while it wrote.
std::vector<std::filesystem::path> meant_by(const std::filesystem::path& folder, const std::string& note) {
  namespace fs = std::filesystem;
  const fs::path path = folder / note;
  const std::string wanted = path.filename().string();
  if (wanted.find('*') == std::string::npos) return {path, path.string() + ".new"};
  const std::string head = wanted.substr(0, wanted.find('*')), tail = wanted.substr(wanted.find('*') + 1);
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(path.parent_path())) {
    const std::string name = entry.path().filename().string();
    const std::size_t digits = name.starts_with(head) ? name.find_first_not_of("0123456789", head.size()) : 0;
    if (digits == std::string::npos || digits <= head.size()) continue;
    if (const std::string rest = name.substr(digits); rest == tail || rest == tail + ".new")
      all.push_back(entry.path());
  }
  return all;
}

void clear(const std::string& folder, int mark) {
  namespace fs = std::filesystem;
  std::vector<std::string> notes = noted(folder);
  if (notes.empty()) notes = unnoted(folder);
  std::error_code kept;  // a folder that holds something of the user's stays
  for (const std::string& note : notes) {
    if (!inside(folder, note)) continue;
    for (const fs::path& path : meant_by(folder, note))
      if (!fs::is_directory(fs::symlink_status(path))) fs::remove(path);
    if (const fs::path parent = (fs::path(folder) / note).parent_path(); parent != fs::path(folder))
      fs::remove(parent, kept);
  }
  if (::ftruncate(mark, 0) != 0)
    throw std::runtime_error(fmt::format("{}/{}: cannot write: {}", folder, marker, std::strerror(errno)));
}

/// Whether the folder can be made, or written into: told before hours of packing, without making it.
void refuse_unwritable(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  const bool there = fs::exists(folder, error);
  if (there && !fs::is_directory(folder)) return;  // said better elsewhere
  fs::path nearest = fs::absolute(folder);
  while (!error && !fs::exists(nearest, error) && nearest.has_relative_path()) nearest = nearest.parent_path();
  if (!error && !fs::is_directory(nearest)) error = std::make_error_code(std::errc::not_a_directory);
  if (!error && ::access(nearest.c_str(), W_OK | X_OK) != 0) error = {errno, std::generic_category()};
  if (error)
    throw std::runtime_error(
        fmt::format("{}: cannot {}: {}", folder, there ? "write" : "create the folder", error.message()));
}

}  // namespace

void check_folder(const Options& options) {
  namespace fs = std::filesystem;
  const std::string& folder = options.directory;
  const fs::path mark = fs::path(folder) / marker;
  refuse_unwritable(folder);
  if (options.resume) {
    if (!fs::exists(fs::path(folder) / "checkpoint.h5") && has_finished(folder))
      throw dem::InputError(folder + ": the run has finished; there is nothing to go on with");
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
  for (const std::string& note : noted(folder))
    if (const fs::path parent = (fs::path(folder) / note).parent_path();
        parent != fs::path(folder) && fs::is_symlink(parent))
      throw dem::InputError(fmt::format(
          "{}: is a link, which leads out of the folder; remove it, or use another -o DIR", parent.string()));
  const int file = locked(mark.string(), O_RDWR);
  if (file < 0) in_use(folder);
  ::close(file);
}

std::string result_file(const std::string& directory, const std::string& name) {
  const std::vector<std::string> notes = noted(directory);
  const std::filesystem::path path = std::filesystem::path(directory) / name;
  const std::string note = note_of(name), line = note + "\n", mark = directory + "/" + marker;
  if (std::find(notes.begin(), notes.end(), note) != notes.end()) return path.string();
  std::error_code error;  // one that matters is told where the file is written
  std::filesystem::create_directories(path.parent_path(), error);
  const int file = ::open(mark.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
  const off_t before = file >= 0 ? ::lseek(file, 0, SEEK_END) : 0;
  if (file >= 0) errno = ENOSPC;  // of a write that is cut short
  const bool done = file >= 0 && ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int fault = errno;
  if (!done && file >= 0) {  // a torn line would be read with the next one
    [[maybe_unused]] const int left = ::ftruncate(file, before);
  }
  if (file >= 0) ::close(file);
  if (!done) throw std::runtime_error(fmt::format("{}: cannot write: {}", mark, std::strerror(fault)));
  return path.string();
}

std::vector<std::string> result_files(const std::string& directory) {
  std::vector<std::string> names = noted(directory);
  std::erase_if(names, [](const std::string& name) { return name.find('/') != std::string::npos; });
  std::sort(names.begin(), names.end());
  return names;
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
  if (!options.resume) clear(options.directory, lock_);
  if (options.log) options.log->begin();
}

Folder::~Folder() {
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace grus::app
