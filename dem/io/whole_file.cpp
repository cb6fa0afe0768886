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

void write_whole(const std::string& path, const std::string& text) {
  const std::string aside = path + ".new";
  int fault = 0;
  auto check = [&](bool good) {
    if (!good && fault == 0) fault = errno != 0 ? errno : EIO;
  };
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  check(file >= 0);
  for (std::size_t at = 0; fault == 0 && at < text.size();) {
    const ssize_t some = ::write(file, text.data() + at, std::min(text.size() - at, std::size_t{1} << 30));
    if (some < 0 && errno == EINTR) continue;
    check(some > 0);
    at += some > 0 ? static_cast<std::size_t>(some) : 0;
  }
  if (fault == 0) check(::fsync(file) == 0 || errno == EINVAL);  // what cannot be synced (a pipe) needs no syncing
  if (file >= 0) check(::close(file) == 0);
  if (fault == 0) check(std::rename(aside.c_str(), path.c_str()) == 0);
  if (fault == 0) return;
  std::remove(aside.c_str());
  throw std::runtime_error(path + ": cannot write: " + std::strerror(fault));
}

}  // namespace grus::dem
