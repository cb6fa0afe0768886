// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>

#include "dem/base/error.hpp"

namespace grus::app {
namespace {

[[noreturn]] void refuse(const std::string& path, int error) {
  throw dem::InputError(fmt::format("--log: {}: cannot write: {}", path, std::strerror(error)));
}

}  // namespace

std::string time_of_day() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%F %T", &parts)};
}

Log::Log(std::string path, const std::string& waits_for) : path_(std::move(path)) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::weakly_canonical(fs::absolute(path_)).parent_path();
  const fs::path results = fs::weakly_canonical(fs::absolute(waits_for) / "");
  if (fs::is_directory(path_)) refuse(path_, EISDIR);
  if ((folder / "") != (results / "")) begin();
}

void Log::begin() {
  if (file_ >= 0) return;
  file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) refuse(path_, errno);
  write();
}

Log::~Log() {
  if (file_ >= 0) ::close(file_);
}

void Log::add(std::string_view text) {
  const std::string time = time_of_day();
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    text_ += fmt::format("{}  {}\n", time, text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  write();
}

void Log::write() {
  if (file_ < 0) return;
  [[maybe_unused]] const auto done = ::write(file_, text_.data(), text_.size());
  text_.clear();
}

}  // namespace grus::app
