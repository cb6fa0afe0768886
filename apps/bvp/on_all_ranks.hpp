// SPDX-License-Identifier: LGPL-3.0-or-later
// What all ranks do at once and may fail in on any of them.
#pragma once

#include "dem/base/error.hpp"
#include "dem/base/watch.hpp"
#include "fem/session.hpp"

namespace grus::app {

/// Runs `part` on every rank; if any throws, all throw the first rank's error: nobody is left waiting.
template <class F>
void on_all_ranks(const fem::Session& session, F&& part) {
  std::string message;
  int kind = 0;
  try {
    part();
  } catch (const dem::InputError& e) {
    kind = 1, message = e.what();
  } catch (const dem::Unstable& e) {
    kind = 2, message = e.what();
  } catch (const std::invalid_argument& e) {
    kind = 1, message = e.what();
  } catch (const dem::Interrupted& e) {
    kind = 4, message = e.what();
  } catch (const std::exception& e) {
    kind = 3, message = e.what();
  }
  const int mine = kind != 0 ? session.rank() : session.ranks();
  int first = 0;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (first == session.ranks()) return;
  int size = static_cast<int>(message.size());
  MPI_Bcast(&kind, 1, MPI_INT, first, MPI_COMM_WORLD);
  MPI_Bcast(&size, 1, MPI_INT, first, MPI_COMM_WORLD);
  message.resize(static_cast<std::size_t>(size));
  MPI_Bcast(message.data(), size, MPI_CHAR, first, MPI_COMM_WORLD);
  if (kind == 1) throw dem::InputError(message);
  if (kind == 2) throw dem::Unstable(message);
  if (kind == 4) throw dem::Interrupted(message);
  throw std::runtime_error(message);
}

}  // namespace grus::app
