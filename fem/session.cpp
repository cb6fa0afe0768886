// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/session.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iterator>
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

namespace {

bool launched() {
  constexpr const char* told[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_FD"};  // by mpirun and srun
  return std::any_of(std::begin(told), std::end(told), [](const char* name) { return std::getenv(name) != nullptr; });
}

/// Alone, Open MPI would start a daemon that asks for the name of the host, which takes seconds where nobody knows it.
/// Without the daemon all such processes would share a folder and memory by name, so they have neither.
void need_no_others() {
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 1);
  setenv("OMPI_MCA_orte_create_session_dirs", "0", 1);
  setenv("OMPI_MCA_btl", "self", 1);
  setenv("OMPI_MCA_pml", "ob1", 1);
}

}  // namespace

Session::Session() {
  char name[] = "grus";
  char* only[] = {name, nullptr};
  dolfinx::init_logging(1, only);  // silences it; our own options are not its own
  if (!launched()) need_no_others();
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
