// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/io/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace grus::dem {

void put_in_place(const std::string& aside, const std::string& path) {
  const int file = ::open(aside.c_str(), O_RDONLY);
  if (file < 0 || ::fsync(file) != 0 || ::close(file) != 0 || std::rename(aside.c_str(), path.c_str()) != 0)
    throw std::runtime_error(path + ": cannot write: " + std::strerror(errno));
}

void write_whole(const std::string& path, const std::string& text) {
  const std::string aside = path + ".new";
  std::FILE* file = std::fopen(aside.c_str(), "wb");
  if (file == nullptr) throw std::runtime_error(path + ": cannot write: " + std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (std::fclose(file) != 0 || !written) {
    const std::string reason = std::strerror(errno);
    std::remove(aside.c_str());
    throw std::runtime_error(path + ": cannot write: " + reason);
  }
  put_in_place(aside, path);
}

}  // namespace grus::dem
