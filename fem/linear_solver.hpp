// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: the linear systems of Newton's increments.
#pragma once

#include <petscksp.h>

#include <algorithm>

#include "fem/problem_impl.hpp"

namespace grus::fem {

/// Linear solver with prescribed components: KSP from PETSc's options (prefix grus_), MUMPS by default, LU when all
/// else fails.
class LinearSolver {
public:
  explicit LinearSolver(Problem::Impl& p) : p_(p), a_(compat::make_matrix(p.comm, *p.space)) {
    check(MatSetOption(a_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
    check(MatCreateVecs(a_, &x_, &b_), "MatCreateVecs");
    check(KSPCreate(p.comm, &ksp_), "KSPCreate");
    check(KSPSetOptionsPrefix(ksp_, "grus_"), "KSPSetOptionsPrefix");
    direct(ksp_);
    check(KSPSetFromOptions(ksp_), "KSPSetFromOptions");
    const auto map = p.space->dofmap()->index_map;
    for (const auto& c : p.prescribed)
      if (c.dof < p.components * map->size_local())
        rows_.push_back(static_cast<PetscInt>(p.components * map->local_range()[0]) + c.dof), mine_.push_back(&c);
  }
  ~LinearSolver() {
    KSPDestroy(&ksp_);
    VecDestroy(&x_);
    VecDestroy(&b_);
    MatDestroy(&a_);
  }
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;

  /// Solves K dx = rhs, prescribed components moving from one time to another; false if no solver succeeds.
  bool solve(const std::vector<double>& rhs, double from, double to, std::vector<double>& dx) {
    p_.assemble_tangent(a_);
    double *b, *x;
    check(VecGetArray(b_, &b), "VecGetArray");
    std::copy(rhs.begin(), rhs.end(), b);
    check(VecRestoreArray(b_, &b), "VecRestoreArray");
    check(VecSet(x_, 0), "VecSet");
    check(VecGetArray(x_, &x), "VecGetArray");
    for (const auto* c : mine_) x[c->dof] = (p_.factor(c->boundary, to) - p_.factor(c->boundary, from)) * c->value;
    check(VecRestoreArray(x_, &x), "VecRestoreArray");
    check(MatZeroRowsColumns(a_, static_cast<PetscInt>(rows_.size()), rows_.data(), 1.0, x_, b_), "MatZeroRowsColumns");
    bool good = all_true(p_.comm, attempt(ksp_));  // an error may be one rank's alone
    if (!good) {
      KSP plain;
      check(KSPCreate(p_.comm, &plain), "KSPCreate");
      direct(plain);
      good = attempt(plain);
      KSPDestroy(&plain);
    }
    dx.resize(rhs.size());
    check(VecGetArray(x_, &x), "VecGetArray");
    std::copy_n(x, dx.size(), dx.begin());
    check(VecRestoreArray(x_, &x), "VecRestoreArray");
    double finite = 0;
    for (double v : dx) finite += v;
    return all_true(p_.comm, good && std::isfinite(finite));
  }

private:
  static void direct(KSP ksp) {
    PC pc;
    check(KSPSetType(ksp, KSPPREONLY), "KSPSetType");
    check(KSPGetPC(ksp, &pc), "KSPGetPC");
    check(PCSetType(pc, PCLU), "PCSetType");
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
  }
  bool attempt(KSP ksp) {
    check(KSPSetOperators(ksp, a_, a_), "KSPSetOperators");
    check(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr),
          "PetscPushErrorHandler");  // a solve that fails is answered with another
    const bool failed = KSPSolve(ksp, b_, x_) != 0;
    check(PetscPopErrorHandler(), "PetscPopErrorHandler");
    if (failed) return check(KSPReset(ksp), "KSPReset"), false;
    KSPConvergedReason reason;
    check(KSPGetConvergedReason(ksp, &reason), "KSPGetConvergedReason");
    return reason > 0;
  }

  Problem::Impl& p_;
  Mat a_ = nullptr;
  Vec x_ = nullptr, b_ = nullptr;
  KSP ksp_ = nullptr;
  std::vector<PetscInt> rows_;
  std::vector<const Prescribed*> mine_;
};

}  // namespace grus::fem
