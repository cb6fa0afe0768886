// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/run_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "dem/base/error.hpp"

namespace grus::app {
namespace {

[[noreturn]] void refuse(const std::string& path, int error) {
  throw dem::InputError(fmt::format("--log: {}: cannot write: {}", path, std::strerror(error)));
}

/// Whether a line begins as those of a log do: "2026-01-31 12:00:00  ".
bool timed(const std::string& line) {
  const std::string form = "0000-00-00 00:00:00  ";
  return line.size() >= form.size() && std::equal(form.begin(), form.end(), line.begin(), [](char f, char c) {
           return f == '0' ? c >= '0' && c <= '9' : f == c;
         });
}

/// A file that is there and is no log: a scene, a mesh or a paper must not end in lines of a run.
void refuse_other(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none) || std::filesystem::file_size(path, none) == 0) return;
  std::ifstream in(path);
  std::string line(21, '\0');
  in.read(line.data(), static_cast<std::streamsize>(line.size()));
  if (!timed(line))
    throw dem::InputError(fmt::format("--log: {}: is there and is not a log of Grus: name another file", path));
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
  refuse_other(path_);
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
