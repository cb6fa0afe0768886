// SPDX-License-Identifier: LGPL-3.0-or-later
// An error that crosses a rank as bytes is thrown as what it was, and says where it was where that helps.
#include <new>
#include <stdexcept>

#include "dem/base/error.hpp"
#include "dem/base/fault.hpp"
#include "dem/base/watch.hpp"
#include "dem/io/whole_file.hpp"
#include "tests/catch.hpp"

using namespace grus::dem;

namespace {

/// What `thrown` has become after a way from rank to rank.
template <class E>
Fault carried(E thrown) {
  return Fault::of(fault_in([&] { throw thrown; }).bytes());
}

/// What E says that is thrown for the fault; another exception goes on.
template <class E>
std::string thrown(const Fault& fault) {
  try {
    rethrow(fault);
  } catch (const E& e) {
    return e.what();
  }
  return "nothing is thrown";
}

}  // namespace

TEST_CASE("a fault is thrown as what it was") {
  CHECK(thrown<InputError>(carried(InputError("scene.toml:3:1: no"))) == "scene.toml:3:1: no");
  CHECK(thrown<InputError>(carried(std::invalid_argument("no node"))) == "no node");
  CHECK(thrown<Unstable>(carried(Unstable("too fast"))) == "too fast");
  CHECK(thrown<Interrupted>(carried(Interrupted("stopped"))) == "stopped");
  CHECK_THROWS_AS(rethrow(carried(std::bad_alloc())), std::bad_alloc);
  const Fault other = carried(std::logic_error("disk full\nand more"));
  CHECK(other.kind == Fault::Kind::other);
  CHECK(thrown<std::runtime_error>(other) == "disk full\nand more");
  CHECK(fault_in([] { throw 3; }).kind == Fault::Kind::other);
}

TEST_CASE("no fault is no bytes, and throws nothing") {
  const Fault none = fault_in([] {});
  CHECK_FALSE(none);
  CHECK(none.bytes().empty());
  CHECK_FALSE(Fault::of(""));
  CHECK_NOTHROW(rethrow(none));
  CHECK_FALSE(at("place: ", none));
  CHECK(at("place: ", none).text.empty());
  CHECK_FALSE(on_rank(2, none));
}

TEST_CASE("input errors name their own place; the place of others stands before them") {
  CHECK(at("cell.toml: ", carried(InputError("scene.toml: no"))).text == "scene.toml: no");
  CHECK(at("cell.toml: ", carried(Unstable("too fast"))).text == "cell.toml: too fast");
}

TEST_CASE("a fault of the machine names its rank, others do not") {
  CHECK(on_rank(3, carried(std::runtime_error("disk full"))).text == "rank 3: disk full");
  CHECK(on_rank(0, carried(std::runtime_error("disk full"))).text == "disk full");
  CHECK(on_rank(3, carried(Unstable("too fast"))).text == "too fast");
  CHECK(thrown<std::runtime_error>(on_rank(1, carried(std::bad_alloc()))) == "rank 1: out of memory");
  CHECK_THROWS_AS(rethrow(on_rank(0, carried(std::bad_alloc()))), std::bad_alloc);
}

TEST_CASE("a file that cannot be written tells the system's own reason") {
  const auto told = [](auto&& write) {
    try {
      write();
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("nothing is thrown");
  };
  const std::string nowhere = "/nowhere/at/all.csv";
  CHECK(told([&] { append(nowhere, 0, "1,2"); }) == nowhere + ": cannot write: No such file or directory");
  CHECK(told([&] { write_whole(nowhere, "1,2"); }) == nowhere + ": cannot write: No such file or directory");
}
