// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/session.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#if __has_include(<dolfinx/common/init.h>)
#include <dolfinx/common/init.h>
#endif
#include <dolfinx/common/log.h>

namespace grus::fem {

int sharers_of(std::span<const cpu_set_t> all, const cpu_set_t& mine) {
  return static_cast<int>(std::count_if(all.begin(), all.end(), [&](const cpu_set_t& other) {
    cpu_set_t both;
    CPU_AND(&both, &mine, &other);
    return CPU_COUNT(&both) > 0;
  }));
}

Session::Session() {
  char name[] = "grus";
  char* only[] = {name, nullptr};
  dolfinx::init_logging(1, only);                   // silences it; our own options are not its own
  // Alone, Open MPI would start a daemon, which asks for the name of the host: seconds where nobody knows that name.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  PETSC_MPI_THREAD_REQUIRED = MPI_THREAD_MULTIPLE;  // a thread of its own may look whether others still answer
  PetscInitializeNoArguments();
  PetscPopSignalHandler();
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
  MPI_Comm node;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &node);
  int here = 1;
  MPI_Comm_size(node, &here);
  cpu_set_t mine;
  CPU_ZERO(&mine);
  sched_getaffinity(0, sizeof mine, &mine);
  std::vector<cpu_set_t> all(static_cast<std::size_t>(here));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, node);
  MPI_Comm_free(&node);
  sharers_ = sharers_of(all, mine);
}

Session::~Session() {
  // Where nobody reads the output any more (| head), PETSc would tell so at length.
  if (std::fflush(stdout) != 0 && std::freopen("/dev/null", "w", stdout) == nullptr) std::clearerr(stdout);
  PetscFinalize();
}

}  // namespace grus::fem
