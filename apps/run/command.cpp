// SPDX-License-Identifier: LGPL-3.0-or-later
#include "apps/run/command.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/run/about_scenes.hpp"
#include "apps/run/cores.hpp"
#include "dem/base/error.hpp"
#include "dem/base/watch.hpp"
#include "dem/io/whole_file.hpp"

namespace grus::app {
namespace {

/// mpirun gives its ranks a terminal of their own, and copies it to wherever it writes itself.
bool on_a_terminal() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_RANK"})
    if (std::getenv(name)) return false;
  const char* kind = std::getenv("TERM");
  return isatty(fileno(stdout)) != 0 && kind && std::string_view(kind) != "dumb";
}

}  // namespace

void say(const Options& options, const std::string& text) {
  if (options.log) options.log->add(text);
  if (!options.quiet) fmt::print("{}\n", text), std::fflush(stdout);
}

void say_fault(const Options& options, const std::string& text) {
  const std::string line = one_line(text);
  if (options.log) options.log->add(line);
  fmt::print(stderr, "{}\n", line);
}

std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text)
    if (c == '\n')
      line += "\\n";
    else if (c == '\t')
      line += "\\t";
    else if (static_cast<unsigned char>(c) < ' ' || c == 0x7f)
      line += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      line += c;
  return line;
}

int run_command(int argc, char** argv, const std::string& name, const std::string& description,
                const std::function<int(const Options&)>& work, bool speaks, int sharers, const Together& together) {
#ifdef M_MMAP_THRESHOLD
  mallopt(M_MMAP_THRESHOLD, 1 << 20);  // columns of large samples go back to the system when they have grown or moved
#endif
  Options options;
  CLI::App cli{description, name};
  cli.set_version_flag("--version", name + " " GRUS_VERSION);
  cli.add_option("SCENE", options.scene, "scene file (TOML)");
  cli.add_option("-o", options.directory, "results folder (default: the scene's name, in the current folder)")
      ->type_name("DIR");
  cli.add_option("--threads", options.threads, "threads (default: all cores that this process may use)")
      ->check(CLI::Range(1, 1024));
  cli.add_option("--set", options.overrides, "override a scene key, e.g. --set packing.seed=7 (repeatable)")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  cli.add_flag("--check", options.check, "validate, print the derived set-up, stop");
  cli.add_flag("--columns", options.columns, "validate, print the names of the columns of history.csv, stop");
  cli.add_flag("--resume", options.resume, "go on from checkpoint.h5 in DIR");
  cli.add_flag("--quiet", options.quiet, "print errors only");
  cli.add_flag("--force", options.force, "delete what Grus has written into DIR before, then run");
  std::string max_time, log;
  cli.add_option(
         "--max-time", max_time,
         "stop in time to be over, checkpoint written, after this wall time, e.g. \"2 h\", \"90 min\"; exit status 75")
      ->type_name("DURATION");
  cli.add_option("--log", log, "add what is said to the end of FILE, each line with the time, --quiet or not")
      ->type_name("FILE");
  About about;
  const std::string program = name.substr(name.rfind('-') + 1);
  add_about(cli, program, about);
  cli.footer(
      "SIGUSR1 and SIGUSR2: write a checkpoint and go on. SIGINT, SIGTERM, SIGHUP: write one and stop.\n"
      "Exit status: 0 finished, 2 scene or command line refused, 3 unstable or not converged, 75 out of time (--resume "
      "goes on), 130 interrupted, 1 other failure.");
  try {
    cli.parse(argc, argv);
    if (options.scene.empty() && !about.asked()) throw CLI::RequiredError("SCENE");
    if (options.force && options.resume)
      throw CLI::ValidationError("--force deletes what --resume would go on from: give one of them");
  } catch (const CLI::Success& e) {
    return speaks ? cli.exit(e) : finished;
  } catch (const CLI::ParseError& e) {
    if (speaks) fmt::print(stderr, "{}\n", one_line(fmt::format("{}: {} (see --help)", name, e.what())));
    return refused;
  }
  if (options.directory.empty()) options.directory = default_directory(options.scene);
  if (options.threads == 0) options.threads = std::max(1, usable_cores() / std::max(1, sharers));
  options.quiet = options.quiet || !speaks;
  hear_signals();
  auto say = [&](const std::string& line) {
    if (speaks) say_fault(options, line);
  };
  try {
    if (!max_time.empty()) options.max_time = std::max(1e-3, duration_of("--max-time", max_time) - age_of_process());
    together([&] {
      if (!log.empty() && speaks) options.log = std::make_shared<Log>(log, options.directory);
    });
    if (!about.asked()) return work(options);
    if (speaks) tell(about, program, options.scene);
    return finished;
  } catch (const dem::InputError& e) {
    return say(e.what()), refused;
  } catch (const dem::Unstable& e) {
    const std::string why = e.what();  // some name the place in the scene themselves
    return say(why.starts_with(options.scene + ":") ? why : options.scene + ": " + why), unstable;
  } catch (const dem::Interrupted& e) {
    const bool late = !interruption_asked() && options.max_time > 0;
    const char* why = late ? " (the time of --max-time is over)" : "";
    return say(options.scene + ": " + e.what() + why), late ? out_of_time : interrupted;
  } catch (const std::bad_alloc&) {
    return say(options.scene + ": out of memory"), failed;
  } catch (const std::exception& e) {
    return say(options.scene + ": " + e.what()), failed;
  }
}

std::string default_directory(const std::string& scene) { return std::filesystem::path(scene).stem().string(); }

double cpu_seconds() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return cpu_seconds(use);
}

double cpu_seconds(const rusage& use) {
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

std::string duration_text(double s) {
  if (!(s < 1e7)) return "?";
  if (s < 60) return fmt::format("{:.1f} s", s);
  const long t = std::lround(s);
  if (t < 3600) return fmt::format("{} min {:02} s", t / 60, t % 60);
  return fmt::format("{} h {:02} min", t / 3600, t % 3600 / 60);
}

Progress::Progress(const Options& options, bool quiet)
    : quiet_(options.quiet || quiet),
      terminal_(on_a_terminal()),
      log_(quiet ? nullptr : options.log),
      limit_(options.started, options.max_time) {}

void Progress::show(double done, const std::string& text) {
  if (quiet_ && !log_) return;
  const double now = clock_.wall();
  const bool live = terminal_ && !quiet_ && now - last_shown_ >= 0.1;
  const bool line = (log_ || !terminal_) && (done - last_part_ >= 0.05 || now - last_line_ >= 20);
  if (!live && !line) return;
  if (first_part_ < 0) first_part_ = done, first_shown_ = now;  // a resumed run does not begin at 0
  const std::string eta =
      done > first_part_ ? duration_text((now - first_shown_) * (1 - done) / (done - first_part_)) : "?";
  if (line) {
    last_line_ = now, last_part_ = done;
    const std::string plain = fmt::format("{:3.0f} %  {}  ETA {}", 100 * done, text, eta);
    if (log_) log_->add(plain);
    if (!quiet_ && !terminal_) fmt::print("{}  {}\n", time_of_day(), plain);
  }
  if (live) {
    last_shown_ = now;
    const int full = static_cast<int>(24 * done);
    fmt::print("\r\033[K[{}{}] {:3.0f} %  {}  ETA {}", std::string(static_cast<std::size_t>(full), '#'),
               std::string(static_cast<std::size_t>(24 - full), '.'), 100 * done, text, eta);
  }
  std::fflush(stdout);
}

bool Progress::watch(double done, const std::string& what) {
  if (what != stage_)
    stage_ = what, stage_began_ = clock_.wall(), last_shown_ = last_line_ = last_part_ = first_part_ = -1;
  if (clock_.wall() - stage_began_ > 1) show(done, what);  // what is done at once needs no line
  return !interruption_asked() && !limit_.over();
}

void Progress::note(const std::string& text) {
  if (log_) log_->add(text);
  if (quiet_) return;
  fmt::print("{}{}\n", terminal_ ? "\r\033[K" : "", text);
  std::fflush(stdout);
}

void Progress::finish(const std::string& text) { note(text); }

History::History(std::string path, std::vector<std::string> columns)
    : path_(std::move(path)), columns_(std::move(columns)) {
  for (std::size_t i = 0; i < columns_.size(); ++i) text_ += (i ? "," : "") + columns_[i];
  text_ += '\n';
}

void History::add(const std::vector<double>& row) {
  for (std::size_t i = 0; i < row.size(); ++i)
    fmt::format_to(std::back_inserter(text_), "{}{:.10g}", i ? "," : "", row[i]);
  text_ += '\n';
  last_ = row;
  ++rows_;
}

void History::restore(const std::string& text, std::size_t rows, const std::vector<double>& last) {
  text_ = text, last_ = last, written_ = 0;
  rows_ = rows;
}

void History::save(double seconds) {
  if (clock_.wall() - saved_ < seconds) return;
  std::error_code none;
  if (written_ == 0 || std::filesystem::file_size(path_, none) != written_)  // at first, or others have been at it
    dem::write_whole(path_, text_);
  else
    dem::append(path_, written_, std::string_view(text_).substr(written_));
  written_ = text_.size(), saved_ = clock_.wall();
}

nlohmann::json provenance() {
  return {{"program", "grus"}, {"version", GRUS_VERSION}, {"compiler", GRUS_COMPILER}, {"build_type", GRUS_BUILD_TYPE}};
}

}  // namespace grus::app
