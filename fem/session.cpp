// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/session.hpp"

#include <petscsys.h>
#if __has_include(<dolfinx/common/init.h>)
#include <dolfinx/common/init.h>
#endif
#include <dolfinx/common/log.h>

namespace grus::fem {

Session::Session() {
  char name[] = "grus";
  char* only[] = {name, nullptr};
  dolfinx::init_logging(1, only);  // silences it; our own options are not its own
  PetscInitializeNoArguments();
  PetscPopSignalHandler();
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks_);
}

Session::~Session() { PetscFinalize(); }

}  // namespace grus::fem
