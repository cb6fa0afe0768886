// SPDX-License-Identifier: LGPL-3.0-or-later
#include "fem/linear_options.hpp"

#include <sstream>

#include "fem/linear_solver.hpp"

namespace grus::fem {
namespace {

const std::string prefix = "-grus_";

/// Keeps what PETSc says first instead of printing it.
PetscErrorCode keep(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                    const char* message, void* kept) {
  auto& text = *static_cast<std::string*>(kept);
  if (type == PETSC_ERROR_INITIAL && text.empty() && message != nullptr) text = message;
  return code;
}

/// All options of the prefix, with their values.
std::string given() {
  char* all = nullptr;
  check(PetscOptionsGetAll(nullptr, &all), "PetscOptionsGetAll");
  std::istringstream words(all);
  check((*PetscTrFree)(all, 0, __func__, ""), "PetscFree");  // the macro would name the folder of the build
  std::string text;
  bool ours = false;
  for (std::string word; words >> word;) {
    if (word.starts_with('-') && word.find_first_of("0123456789") != 1) ours = word.starts_with(prefix);
    if (ours) text += (text.empty() ? "" : " ") + word;
  }
  return text;
}

}  // namespace

std::string fault_of_linear_options(LinearMethod method) {
  KSP ksp;
  std::string why;
  check(KSPCreate(MPI_COMM_SELF, &ksp), "KSPCreate");
  check(PetscPushErrorHandler(keep, &why), "PetscPushErrorHandler");
  const bool good = set_up(ksp, method) == 0;
  check(PetscPopErrorHandler(), "PetscPopErrorHandler");
  KSPDestroy(&ksp);
  if (good) return "";
  why = why.substr(0, why.find('\n'));
  return "PETSc refuses its options (PETSC_OPTIONS or .petscrc) \"" + given() + "\": " + why;
}

std::vector<std::string> unused_linear_options() {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &count, &names, &values), "PetscOptionsLeftGet");
  std::vector<std::string> unused;
  for (PetscInt i = 0; i < count; ++i) {
    const std::string name = std::string("-") + names[i];
    if (name.starts_with(prefix)) unused.push_back(values[i] != nullptr ? name + " " + values[i] : name);
  }
  check(PetscOptionsLeftRestore(nullptr, &count, &names, &values), "PetscOptionsLeftRestore");
  return unused;
}

}  // namespace grus::fem
