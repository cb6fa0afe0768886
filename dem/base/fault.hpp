// SPDX-License-Identifier: LGPL-3.0-or-later
// An error as a value: it crosses from a thread or a rank to another one and is thrown there as what it was.
#pragma once

#include <string>

namespace grus::dem {

struct Fault {
  enum class Kind : char { none = '-', input = 'i', unstable = 'u', interrupted = 's', memory = 'm', other = 'f' };
  Kind kind = Kind::none;
  std::string text;

  explicit operator bool() const { return kind != Kind::none; }
  /// The kind's letter and the text; nothing where there is no fault.
  std::string bytes() const;
  static Fault of(const std::string& bytes);
};

/// The exception that is being handled. std::invalid_argument, with which fem refuses its input, is input too.
Fault caught();

/// The fault that `part` throws, or none.
template <class F>
Fault fault_in(F&& part) {
  try {
    part();
  } catch (...) {
    return caught();
  }
  return {};
}

/// `place` before the text; input errors name their own place.
Fault at(const std::string& place, Fault fault);

/// A fault of the machine on rank `rank` > 0, told with the rank; what the user or the physics has done is
/// the same on any rank.
Fault on_rank(int rank, Fault fault);

/// Throws what the fault stands for: InputError, Unstable, Interrupted, std::bad_alloc or std::runtime_error. No fault:
/// does nothing.
void rethrow(const Fault& fault);

}  // namespace grus::dem
