// SPDX-License-Identifier: LGPL-3.0-or-later
// A process that has no memory left writes a checkpoint: an error, whatever of it is the first to fail, and no signal.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <new>
#include <set>
#include <stdexcept>

#include "dem/io/checkpoint.hpp"
#include "tests/apps/scratch.hpp"
#include "tests/helpers.hpp"

using namespace grus;
using grus::app::test::Scratch;

namespace {

/// Lets this process have so many bytes of data more than now.
void tighten(std::size_t room) {
  std::ifstream status("/proc/self/status");
  std::size_t data = 0;
  for (std::string word; status >> word;)
    if (word == "VmData:") status >> data;
  const rlimit tight{1024 * data + room, 1024 * data + room};
  setrlimit(RLIMIT_DATA, &tight);
}

}  // namespace

TEST_CASE("a checkpoint for which there is no memory is an error") {
  const Scratch folder;
  const std::string path = folder.path + "/checkpoint.h5";
  const auto write = [&] { dem::write_checkpoint(path, "{}", [](const auto& take) { take(std::string(1000, 'x')); }); };
  std::set<int> ended;
  for (std::size_t room = 0; room < (std::size_t{4} << 20); room += std::size_t{1} << 15) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      tighten(room);
      try {
        write();
        _exit(0);
      } catch (const std::bad_alloc&) {
        _exit(1);
      } catch (const std::runtime_error&) {
        _exit(2);
      }
    }
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WIFEXITED(status));
    ended.insert(WEXITSTATUS(status));
  }
  CHECK(ended.contains(0));
  CHECK(ended.contains(1));
}
