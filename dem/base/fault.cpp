// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/base/fault.hpp"

#include <new>
#include <stdexcept>

#include "dem/base/error.hpp"
#include "dem/base/watch.hpp"

namespace grus::dem {

std::string Fault::bytes() const { return kind == Kind::none ? "" : static_cast<char>(kind) + text; }

Fault Fault::of(const std::string& bytes) {
  if (bytes.empty()) return {};
  for (const Kind kind : {Kind::input, Kind::unstable, Kind::interrupted, Kind::memory})
    if (bytes[0] == static_cast<char>(kind)) return {kind, bytes.substr(1)};
  return {Kind::other, bytes.substr(1)};
}

Fault caught() {
  try {
    throw;
  } catch (const InputError& e) {
    return {Fault::Kind::input, e.what()};
  } catch (const std::invalid_argument& e) {
    return {Fault::Kind::input, e.what()};
  } catch (const Unstable& e) {
    return {Fault::Kind::unstable, e.what()};
  } catch (const Interrupted& e) {
    return {Fault::Kind::interrupted, e.what()};
  } catch (const std::bad_alloc&) {
    return {Fault::Kind::memory, "out of memory"};
  } catch (const std::exception& e) {
    return {Fault::Kind::other, e.what()};
  } catch (...) {
    return {Fault::Kind::other, "an exception of an unknown kind"};
  }
}

Fault at(const std::string& place, Fault fault) {
  if (fault && fault.kind != Fault::Kind::input) fault.text.insert(0, place);
  return fault;
}

Fault on_rank(int rank, Fault fault) {
  if (rank == 0 || (fault.kind != Fault::Kind::memory && fault.kind != Fault::Kind::other)) return fault;
  return {Fault::Kind::other, "rank " + std::to_string(rank) + ": " + fault.text};
}

void rethrow(const Fault& fault) {
  switch (fault.kind) {
    case Fault::Kind::none:
      return;
    case Fault::Kind::input:
      throw InputError(fault.text);
    case Fault::Kind::unstable:
      throw Unstable(fault.text);
    case Fault::Kind::interrupted:
      throw Interrupted(fault.text);
    case Fault::Kind::memory:
      throw std::bad_alloc();
    case Fault::Kind::other:
      throw std::runtime_error(fault.text);
  }
}

}  // namespace grus::dem
