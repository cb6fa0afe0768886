// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace grus::dem {

namespace {

/// The first error of a series of calls.
struct Faults {
  int first = 0;
  void check(bool good) {
    if (!good && first == 0) first = errno != 0 ? errno : EIO;
  }
};

void write_all(int file, std::string_view text, Faults& faults) {
  while (faults.first == 0 && !text.empty()) {
    const ssize_t some = ::write(file, text.data(), std::min(text.size(), std::size_t{1} << 30));
    if (some < 0 && errno == EINTR) continue;
    faults.check(some > 0);
    if (some > 0) text.remove_prefix(static_cast<std::size_t>(some));
  }
}

[[noreturn]] void cannot_write(const std::string& path, const Faults& faults) {
  throw std::runtime_error(path + ": cannot write: " + std::strerror(faults.first));
}

}  // namespace

void write_whole(const std::string& path, const std::string& text) {
  const std::string aside = path + ".new";
  Faults faults;
  ::unlink(aside.c_str());  // left by a killed run, or a link to elsewhere: what is written is a file of our own
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
  faults.check(file >= 0);
  write_all(file, text, faults);
  if (faults.first == 0)
    faults.check(::fsync(file) == 0 || errno == EINVAL);  // what cannot be synced (a pipe) needs no syncing
  if (file >= 0) faults.check(::close(file) == 0);
  if (faults.first == 0) faults.check(std::rename(aside.c_str(), path.c_str()) == 0);
  if (faults.first == 0) return;
  if (file >= 0) std::remove(aside.c_str());
  cannot_write(path, faults);
}

void append(const std::string& path, std::size_t size, std::string_view text) {
  Faults faults;
  const int file = ::open(path.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
  faults.check(file >= 0);
  write_all(file, text, faults);
  // Where not even that can be done the rows are left torn; the fault that is told is the first.
  if (faults.first != 0 && file >= 0) {
    [[maybe_unused]] const int left = ::ftruncate(file, static_cast<off_t>(size));
  }
  if (file >= 0) faults.check(::close(file) == 0);
  if (faults.first != 0) cannot_write(path, faults);
}

}  // namespace grus::dem
