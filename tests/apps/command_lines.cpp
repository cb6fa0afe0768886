// SPDX-License-Identifier: LGPL-3.0-or-later
// Command lines: what they ask for, how what goes wrong ends and what is said of it; progress, logs, tables of numbers.
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/run/about_scenes.hpp"
#include "apps/run/command.hpp"
#include "apps/run/cores.hpp"
#include "dem/base/error.hpp"
#include "dem/base/watch.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using namespace grus::app;
using grus::app::test::Scratch;

namespace {

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream all;
  all << in.rdbuf();
  return all.str();
}

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// A stream of the process leads to another file for a while.
class Led {
public:
  Led(int stream, int file) : stream_(stream), kept_((std::fflush(nullptr), ::dup(stream))) { ::dup2(file, stream); }
  ~Led() { std::fflush(nullptr), ::dup2(kept_, stream_), ::close(kept_); }
  Led(const Led&) = delete;
  Led& operator=(const Led&) = delete;

private:
  int stream_, kept_;
};

/// What `work` writes to the standard output (1) or error (2).
std::string written_to(int stream, const std::function<void()>& work) {
  const Scratch scratch;
  const std::string path = scratch.path + "/told";
  const int file = ::open(path.c_str(), O_CREAT | O_WRONLY, 0600);
  {
    const Led led(stream, file);
    ::close(file);
    work();
  }
  return text_of(path);
}

/// The same where the standard output is a terminal.
std::string shown_on_terminal(const std::function<void()>& work) {
  const int outer = posix_openpt(O_RDWR | O_NOCTTY);
  REQUIRE((outer >= 0 && grantpt(outer) == 0 && unlockpt(outer) == 0));
  const int inner = ::open(ptsname(outer), O_RDWR | O_NOCTTY);
  {
    const Led led(1, inner);
    work();
  }
  ::close(inner);
  std::string text;
  char some[256];
  for (ssize_t size; (size = ::read(outer, some, sizeof some)) > 0;)  // until nobody has the terminal any more
    text.append(some, static_cast<std::size_t>(size));
  ::close(outer);
  return text;
}

struct Ended {
  int status;
  std::string said;  // on standard error
};

/// A command whose work is `work`.
Ended command(std::vector<std::string> words, const std::function<int(const Options&)>& work, bool speaks = true,
              int sharers = 1) {
  words.insert(words.begin(), "grus-rve");
  std::vector<char*> each;
  for (std::string& word : words) each.push_back(word.data());
  Ended ended{};
  ended.said = written_to(2, [&] {
    ended.status =
        run_command(static_cast<int>(each.size()), each.data(), "grus-rve", "A test.", work, speaks, sharers);
  });
  return ended;
}

Options options_of(const std::vector<std::string>& words, bool speaks = true, int sharers = 1) {
  Options seen;
  REQUIRE(command(
              words, [&](const Options& o) { return seen = o, 0; }, speaks, sharers)
              .status == 0);
  return seen;
}

}  // namespace

TEST_CASE("a command line asks for what it names, and for nothing else") {
  const Options plain = options_of({"folder/a.b.toml"});
  CHECK((plain.scene == "folder/a.b.toml" && plain.directory == "a.b" && plain.overrides.empty()));
  CHECK((plain.threads == usable_cores() && plain.max_time == 0 && !plain.log && plain.speaks()));
  CHECK_FALSE((plain.check || plain.columns || plain.quiet || plain.force || plain.resume));
  CHECK(options_of({"a.toml", "-o", "there"}).directory == "there");
  CHECK(options_of({"a.toml", "--threads", "7"}).threads == 7);
  CHECK(options_of({"a.toml"}, true, 1000).threads == 1);
  CHECK(options_of({"a.toml"}, true, 0).threads == usable_cores());
  const auto changes = options_of({"--set", "x=1", "--set", "y=[1, 2]", "a.toml"});
  CHECK((changes.overrides == std::vector<std::string>{"x=1", "y=[1, 2]"} && changes.scene == "a.toml"));
  CHECK(options_of({"a.toml", "--check"}).check);
  CHECK(options_of({"a.toml", "--columns"}).columns);
  CHECK(options_of({"a.toml", "--resume"}).resume);
  CHECK(options_of({"a.toml", "--force"}).force);
  CHECK((options_of({"a.toml", "--quiet"}).quiet && !options_of({"a.toml", "--quiet"}).speaks()));
  CHECK(options_of({"a.toml"}, false).quiet);  // a rank that does not speak
  const double left = options_of({"a.toml", "--max-time", "2 h"}).max_time;
  CHECK((left <= 7200 && left > 7200 - age_of_process() - 1));
  CHECK(options_of({"a.toml", "--max-time", "1e-9 s"}).max_time == 1e-3);  // one that is over is no time without end
  const Scratch scratch;
  const std::string log = scratch.path + "/run.log";
  const Options logged = options_of({"a.toml", "--quiet", "--log", log});
  CHECK((logged.log && logged.speaks() && std::filesystem::exists(log)));
  CHECK_FALSE(options_of({"a.toml", "--log", log}, false).log);
}

TEST_CASE("what ends a command has its own status and one line that names the scene once") {
  const auto thrown = [](const auto& error) { return [&error](const Options&) -> int { throw error; }; };
  const auto is = [](const Ended& e, int status, const std::string& said) {
    INFO(e.said);
    CHECK((e.status == status && e.said == said));
  };
  for (const int status : {0, 2, 75}) is(command({"a.toml"}, [&](const Options&) { return status; }), status, "");
  is(command({"a.toml"}, thrown(dem::InputError("a.toml: no\nway"))), 2, "a.toml: no\\nway\n");
  is(command({"a.toml"}, thrown(dem::Unstable("it burst"))), 3, "a.toml: it burst\n");
  is(command({"a.toml"}, thrown(dem::Unstable("a.toml: grain: it burst"))), 3, "a.toml: grain: it burst\n");
  is(command({"a.toml"}, thrown(dem::Interrupted("stopped"))), 130, "a.toml: stopped\n");
  is(command({"a.toml", "--max-time", "1 s"}, thrown(dem::Interrupted("stopped"))), 75,
     "a.toml: stopped (the time of --max-time is over)\n");
  is(command({"a.toml"}, thrown(std::bad_alloc())), 1, "a.toml: out of memory\n");
  is(command({"a.toml"}, thrown(std::runtime_error("disk"))), 1, "a.toml: disk\n");
  is(command({"a.toml"}, thrown(dem::InputError("no")), false), 2, "");  // of several ranks one speaks
  is(command({}, thrown(dem::InputError("never asked"))), 2, "grus-rve: SCENE is required (see --help)\n");
  is(command({}, thrown(dem::InputError("never asked")), false), 2, "");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"a.toml", "--threads", "0"},
                                                {"a.toml", "--none"},
                                                {"a.toml", "b.toml"},
                                                {"a.toml", "--force", "--resume"}}) {
    const Ended e = command(words, thrown(std::runtime_error("never asked")));
    CHECK((e.status == 2 && e.said.starts_with("grus-rve: ") && e.said.ends_with(" (see --help)\n")));
  }
  CHECK(command({"a.toml", "--max-time", "soon"}, thrown(std::runtime_error("x"))).said.starts_with("--max-time: "));
  int status = -1;
  const std::string version =
      written_to(1, [&] { status = command({"--version"}, thrown(dem::InputError("x"))).status; });
  CHECK((status == 0 && version.starts_with("grus-rve ") && std::count(version.begin(), version.end(), '.') == 2));
  CHECK(written_to(1, [&] { command({"--version"}, thrown(dem::InputError("x")), false); }).empty());
  CHECK(written_to(1, [&] {
          status = command({"--keys", "loading.final_strain"}, thrown(dem::InputError("x"))).status;
        }).starts_with("loading.final_strain\n"));
  CHECK(status == 0);
  CHECK(one_line("a\tb\x01\x7f\xC3\xA9 \n") == "a\\tb\\x01\\x7f\xC3\xA9 \\n");
}

TEST_CASE("what is said goes to the terminal unless a run is quiet, and into its log with the time, always") {
  const Scratch scratch;
  Options o;
  o.log = std::make_shared<Log>(scratch.path + "/run.log", scratch.path + "/results");
  const std::size_t stamp = std::string("2026-01-31 12:00:00").size();
  CHECK(written_to(1, [&] { say(o, "one\ntwo"); }) == "one\ntwo\n");
  o.quiet = true;
  CHECK(written_to(1, [&] { say(o, "three"); }).empty());
  CHECK(written_to(2, [&] { say_fault(o, "no\tway"); }) == "no\\tway\n");
  std::istringstream lines(text_of(scratch.path + "/run.log"));
  std::vector<std::string> said;
  for (std::string line; std::getline(lines, line);) {
    CHECK((line.size() > stamp && line[4] == '-' && line[7] == '-' && line[13] == ':' && line[16] == ':'));
    said.push_back(line.substr(stamp));
  }
  CHECK(said == std::vector<std::string>{"  one", "  two", "  three", "  no\\tway"});
  // What is there is gone on with if it is a log; one inside the results waits until they may be written.
  { const Log more(scratch.path + "/run.log", scratch.path + "/results"); }
  for (const std::string other :
       {"grain = 1\n", "2026-01-31 12:00:0x  said\n", "2026-01-31\n", "2026/01/31 12:00:00  x"}) {
    write(scratch.path + "/other", other);
    CHECK_THROWS_WITH(Log(scratch.path + "/other", "r"), Catch::Contains("is not a log of Grus"));
    CHECK(text_of(scratch.path + "/other") == other);
  }
  write(scratch.path + "/empty", "");
  CHECK_NOTHROW(Log(scratch.path + "/empty", "r"));
  CHECK_THROWS_WITH(Log(scratch.path, "r"), Catch::Contains("Is a directory"));
  CHECK_THROWS_WITH(Log(scratch.path + "/none/run.log", "r"), Catch::Contains("No such file"));
  const std::string inside = scratch.path + "/results/run.log";
  Log waits(inside, scratch.path + "/results");
  waits.add("before");
  CHECK_FALSE(std::filesystem::exists(scratch.path + "/results"));
  std::filesystem::create_directory(scratch.path + "/results");
  waits.begin(), waits.begin(), waits.add("after");
  const std::string all = text_of(inside);
  CHECK(
      (all.find("  before\n") == stamp && all.ends_with("  after\n") && std::count(all.begin(), all.end(), '\n') == 2));
}

TEST_CASE("a run shows how far it is: a line each twentieth, a bar on a terminal, nothing where it is quiet") {
  const Scratch scratch;
  Options o;
  const auto lines_of = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  double took = 0;
  const std::string said = written_to(1, [&] {
    const Clock clock;
    Progress p(o);
    for (const double done : {0.5, 0.51, 0.54}) p.show(done, "t 1 s");
    ::usleep(200000);
    p.show(0.75, "t 2 s"), took = clock.wall();
    p.note("a note"), p.finish("done");
  });
  CHECK(lines_of(said) == 4);  // at 0.5, at 0.75, a note, the end
  CHECK(said.find("   50 %  t 1 s  ETA ?\n") != std::string::npos);
  const std::size_t eta = said.find("  75 %  t 2 s  ETA ");  // as long again
  REQUIRE(eta != std::string::npos);
  const double left = std::stod(said.substr(eta + std::string("  75 %  t 2 s  ETA ").size()));
  CHECK((left > 0.1 && left < took + 0.1));
  CHECK(said.ends_with("\na note\ndone\n"));
  Options quiet;
  quiet.quiet = true;
  CHECK(written_to(1, [&] {
          Progress p(quiet);
          p.show(0.5, "x"), p.note("y");
        }).empty());
  CHECK(written_to(1, [&] {
          Progress p(o, true);
          p.show(0.5, "x"), p.note("y");
        }).empty());
  quiet.log = std::make_shared<Log>(scratch.path + "/run.log", "r");
  CHECK(written_to(1, [&] {
          Progress p(quiet);
          p.show(0.25, "x"), p.show(0.26, "x"), p.note("y");
        }).empty());
  const std::string logged = text_of(scratch.path + "/run.log");
  CHECK(
      (lines_of(logged) == 2 && logged.find("   25 %  x  ETA ?\n") != std::string::npos && logged.ends_with("  y\n")));
  const auto bar = [&] {
    Progress p(o);
    p.show(0.25, "x"), p.show(0.9, "soon"), p.note("y");
  };
  setenv("TERM", "xterm", 1);
  CHECK(shown_on_terminal(bar) ==
        "\r\033[K[" + std::string(6, '#') + std::string(18, '.') + "]  25 %  x  ETA ?\r\033[Ky\r\n");
  setenv("TERM", "dumb", 1);
  CHECK(shown_on_terminal(bar).find('#') == std::string::npos);
  setenv("TERM", "xterm", 1), setenv("PMI_RANK", "0", 1);
  CHECK(shown_on_terminal(bar).find('#') == std::string::npos);
  unsetenv("PMI_RANK");
  // What is done at once has no line; what takes its time is stopped where that is over.
  CHECK(written_to(1, [&] { CHECK(Progress(o).watch(0.5, "packing")); }).empty());
  Options late;
  late.max_time = 1e-9;
  Progress over(late);
  CHECK_FALSE((over.watch(0.5, "packing") && over.watch(0.6, "packing")));
  const std::vector<std::pair<double, const char*>> times{{0, "0.0 s"},
                                                          {59.94, "59.9 s"},
                                                          {60, "1 min 00 s"},
                                                          {245.4, "4 min 05 s"},
                                                          {3599.4, "59 min 59 s"},
                                                          {3599.6, "1 h 00 min"},
                                                          {7859, "2 h 10 min"},
                                                          {9.99e6, "2775 h 00 min"},
                                                          {1e7, "?"},
                                                          {NAN, "?"}};
  for (const auto& [seconds, text] : times) CHECK(duration_text(seconds) == text);
}

TEST_CASE("a table of numbers is written whole at first, then at its end, and whole where others have been at it") {
  const Scratch scratch;
  const std::string path = scratch.path + "/history.csv";
  History h(path, {"time_s", "a"});
  h.add({0, 1.0 / 3}), h.add({1e-9, -2});
  CHECK((h.rows() == 2 && h.last() == std::vector<double>{1e-9, -2} && h.columns().size() == 2));
  h.save(3600);
  const std::string two = "time_s,a\n0,0.3333333333\n1e-09,-2\n";
  CHECK((text_of(path) == two && h.text() == two));
  h.add({2, 3});
  h.save(3600);  // so soon it is not written
  CHECK(text_of(path) == two);
  h.save();
  CHECK(text_of(path) == two + "2,3\n");
  write(path, "x" + two.substr(1) + "2,3\n");  // of the same size: it is gone on with at its end
  h.add({3, 4}), h.save();
  CHECK(text_of(path) == "x" + two.substr(1) + "2,3\n3,4\n");
  write(path, "spoilt\n");
  h.add({4, 5}), h.save();
  CHECK(text_of(path) == two + "2,3\n3,4\n4,5\n");
  History again(path, {"time_s", "a"});
  again.restore(two, 2, {1e-9, -2});
  CHECK((again.rows() == 2 && again.last() == std::vector<double>{1e-9, -2}));
  again.add({7, 8}), again.save();
  CHECK((text_of(path) == two + "7,8\n" && again.rows() == 3));
  const auto facts = provenance();
  CHECK((facts.size() == 4 && facts["program"] == "grus" && facts["version"].get<std::string>().size() >= 5));
  CHECK(facts["compiler"].get<std::string>().size() > 3);
}

TEST_CASE("time of all cores, and cores that a process may use: the fewest of its mask and of any group's quota") {
  rusage use{};
  use.ru_utime = {5, 250000}, use.ru_stime = {3, 500000};
  CHECK(cpu_seconds(use) == Approx(8.75).epsilon(1e-14));
  const double before = cpu_seconds();
  timespec begun{}, now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begun);
  do clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  while (static_cast<double>(now.tv_sec - begun.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec - begun.tv_nsec) <
         0.1);
  CHECK(cpu_seconds() - before == Approx(0.1).margin(0.03));
  cpu_set_t mine, one;
  REQUIRE(sched_getaffinity(0, sizeof mine, &mine) == 0);
  CHECK((usable_cores() >= 1 && usable_cores() <= CPU_COUNT(&mine)));
  CPU_ZERO(&one);
  for (std::size_t k = 0; k < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++k)
    if (CPU_ISSET(k, &mine)) CPU_SET(k, &one);
  sched_setaffinity(0, sizeof one, &one);
  CHECK(usable_cores() == 1);
  sched_setaffinity(0, sizeof mine, &mine);
  const Scratch scratch;
  const auto quota = [&](const std::string& groups) {
    std::istringstream in(groups);
    return tightest_quota(in, {scratch.path + "/two", scratch.path + "/one"});
  };
  std::filesystem::create_directories(scratch.path + "/two/a/b");
  std::filesystem::create_directories(scratch.path + "/one/c");
  CHECK(std::isinf(quota("0::/a/b\n")));
  write(scratch.path + "/two/a/b/cpu.max", "max 100000\n");
  CHECK(std::isinf(quota("0::/a/b\n")));
  write(scratch.path + "/two/a/cpu.max", "350000 100000\n");
  CHECK(quota("0::/a/b\n") == 3.5);  // that of the group above
  write(scratch.path + "/two/a/b/cpu.max", "150000 100000\n");
  CHECK(quota("0::/a/b\n") == 1.5);
  CHECK(quota("0::/a\n") == 3.5);
  CHECK((std::isinf(quota("0::/\n")) && std::isinf(quota("no group\n")) && std::isinf(quota(""))));
  write(scratch.path + "/one/c/cpu.cfs_quota_us", "-1\n"), write(scratch.path + "/one/c/cpu.cfs_period_us", "50000\n");
  CHECK(std::isinf(quota("4:cpu,cpuacct:/c\n")));
  write(scratch.path + "/one/c/cpu.cfs_quota_us", "125000\n");
  CHECK(quota("4:cpu,cpuacct:/c\n") == 2.5);
  CHECK(quota("4:cpu,cpuacct:/c\n0::/a/b\n") == 1.5);
}

TEST_CASE("new scenes: each with what it needs beside it under its name, none over what is there") {
  const Scratch scratch;
  const auto made = [&](const std::string& program, const std::string& kind, const std::string& name) {
    About about;
    about.kind = kind;
    return written_to(1, [&] { tell(about, program, scratch.path + "/" + name); });
  };
  const std::string a = scratch.path + "/a.toml";
  CHECK(made("rve", "triaxial", "a.toml") == fmt::format("{0}: grus check {0}, grus run {0}, grus report a\n", a));
  CHECK(text_of(a).find("kind = \"triaxial\"") != std::string::npos);
  CHECK_THROWS_WITH(made("rve", "triaxial", "a.toml"), Catch::Contains("is there already; name another file"));
  made("bvp", "footing", "f.toml");
  CHECK(text_of(scratch.path + "/f.toml").find("\"f_cell.toml\"") != std::string::npos);
  CHECK(text_of(scratch.path + "/f.toml").find("%NAME%") == std::string::npos);
  CHECK(text_of(scratch.path + "/f_cell.toml").find("[packing]") != std::string::npos);
  write(scratch.path + "/g_cell.toml", "mine");  // then nothing is written
  CHECK_THROWS_WITH(made("bvp", "footing", "g.toml"), Catch::Contains("g_cell.toml: is there already"));
  CHECK((text_of(scratch.path + "/g_cell.toml") == "mine" && !std::filesystem::exists(scratch.path + "/g.toml")));
  const std::string p = scratch.path + "/p.py";
  CHECK(made("bvp", "block-dolfinx", "p.py") == fmt::format("{0}: /usr/bin/python3 {0}\n", p));
  CHECK(std::filesystem::exists(scratch.path + "/p_cell.toml"));
  CHECK_THROWS_WITH(made("bvp", "block-dolfinx", "p.toml"), Catch::Contains("its name ends in .py"));
  CHECK_THROWS_WITH(made("bvp", "footing", "a\"b.toml"), Catch::Contains("a name without quotes"));
  CHECK_NOTHROW(made("rve", "shpb", "a\"b.toml"));  // of one file its name stands nowhere
  About keys;
  keys.keys = "no such word";
  CHECK_THROWS_WITH(tell(keys, "rve", ""), Catch::Contains("--keys no such word: no key holds that"));
  About schema;
  schema.schema = true;
  CHECK(nlohmann::json::parse(written_to(1, [&] { tell(schema, "rve", ""); })).is_object());
  CHECK_FALSE((About{}.asked() || !schema.asked() || !keys.asked()));
}
