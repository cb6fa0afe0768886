// SPDX-License-Identifier: LGPL-3.0-or-later
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_session.hpp>
#else
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#endif
#include <mpi.h>

#include "tests/fem/session.hpp"

const grus::fem::Session* grus::fem::test::session = nullptr;

int main(int argc, char** argv) {
  const grus::fem::Session session;
  grus::fem::test::session = &session;
  int mine = Catch::Session().run(argc, argv), worst = 0;
  MPI_Allreduce(&mine, &worst, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return worst;
}
