// SPDX-License-Identifier: LGPL-3.0-or-later
// Work that all ranks do at once, and that may fail on any of them.
#pragma once

#include <mpi.h>

#include "dem/base/fault.hpp"
#include "fem/session.hpp"

namespace grus::app {

/// Runs `part` on every rank; if any throws, all throw the first rank's error: nobody is left waiting.
template <class F>
void on_all_ranks(const fem::Session& session, F&& part) {
  const dem::Fault mine = dem::fault_in(part);
  const int rank = mine ? session.rank() : session.ranks();
  int first = 0;
  MPI_Allreduce(&rank, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (first == session.ranks()) return;
  std::string bytes = mine.bytes();
  int size = static_cast<int>(bytes.size());
  MPI_Bcast(&size, 1, MPI_INT, first, MPI_COMM_WORLD);
  bytes.resize(static_cast<std::size_t>(size));
  MPI_Bcast(bytes.data(), size, MPI_CHAR, first, MPI_COMM_WORLD);
  rethrow(on_rank(first, dem::Fault::of(bytes)));
}

}  // namespace grus::app
