// SPDX-License-Identifier: LGPL-3.0-or-later
// Sums whose bits depend neither on their order nor on who adds what: over numbers, and over ranks.
#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>

namespace grus::fem {

/// A sum of doubles kept as one integer, in digits of 32 bits from 2^-256 on: nothing is rounded but its value. Of each
/// number what lies below 2^-256 is cut off; one of 2^128 or more, or that is none, makes the value NaN. Holds 2^63
/// numbers of any size.
class ExactSum {
public:
  void operator+=(double v);
  void operator+=(const ExactSum& other);
  double value() const;  // the nearest double

  static constexpr int digits = 14;  // the last two for what numbers below 2^128 add up to
  /// The digits, and how many numbers were too large or none; what MPI_SUM adds up over ranks.
  using Words = std::array<std::int64_t, digits + 1>;
  Words words() const;                     // each digit below 2^32, but for the last one
  static ExactSum of(const Words& words);  // of digits up to 2^63 - 2^32

private:
  void carry();
  Words words_{};
};

/// The sums over all ranks.
template <std::size_t N>
std::array<double, N> over_ranks(MPI_Comm comm, const std::array<double, N>& mine) {
  std::array<double, N> all;
  MPI_Allreduce(mine.data(), all.data(), static_cast<int>(N), MPI_DOUBLE, MPI_SUM, comm);
  return all;
}
template <std::size_t N>
std::array<double, N> over_ranks(MPI_Comm comm, const std::array<ExactSum, N>& mine) {
  std::array<ExactSum::Words, N> words, all;
  for (std::size_t k = 0; k < N; ++k) words[k] = mine[k].words();
  MPI_Allreduce(words.data(), all.data(), static_cast<int>(N * words[0].size()), MPI_INT64_T, MPI_SUM, comm);
  std::array<double, N> values;
  for (std::size_t k = 0; k < N; ++k) values[k] = ExactSum::of(all[k]).value();
  return values;
}

/// `add(sums)` adds this rank's part to N sums, plain or exact; returns them over all ranks.
template <std::size_t N, class Add>
std::array<double, N> sums_over_ranks(MPI_Comm comm, bool exact, Add&& add) {
  if (exact) {
    std::array<ExactSum, N> sums{};
    add(sums);
    return over_ranks(comm, sums);
  }
  std::array<double, N> sums{};
  add(sums);
  return over_ranks(comm, sums);
}

}  // namespace grus::fem
