// SPDX-License-Identifier: LGPL-3.0-or-later
// Private to fem: the linear systems of Newton's increments.
#pragma once

#include <petscksp.h>

#include <algorithm>

#include "fem/problem_impl.hpp"
#include "fem/statics.hpp"

namespace grus::fem {

/// Of the right side, by the preconditioned norm: far below what any increment of Newton is asked for.
inline constexpr double linear_residual = 1e-9;

inline void multigrid(KSP ksp) {
  constexpr int most = 500, kept = 60;  // directions
  PC pc;
  check(KSPSetType(ksp, KSPGMRES), "KSPSetType");
  check(KSPGMRESSetRestart(ksp, kept), "KSPGMRESSetRestart");
  check(KSPSetTolerances(ksp, linear_residual, PETSC_DEFAULT, PETSC_DEFAULT, most), "KSPSetTolerances");
  check(KSPGetPC(ksp, &pc), "KSPGetPC");
  check(PCSetType(pc, PCGAMG), "PCSetType");
}

inline void direct(KSP ksp) {
  PC pc;
  check(KSPSetType(ksp, KSPPREONLY), "KSPSetType");
  check(KSPGetPC(ksp, &pc), "KSPGetPC");
  check(PCSetType(pc, PCLU), "PCSetType");
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
}

/// As the scene has it; PETSc's options (prefix grus_) change it. An error code where they are not PETSc's.
inline PetscErrorCode set_up(KSP ksp, LinearMethod method) {
  check(KSPSetOptionsPrefix(ksp, "grus_"), "KSPSetOptionsPrefix");
  method == LinearMethod::iterative ? multigrid(ksp) : direct(ksp);
  return KSPSetFromOptions(ksp);
}

/// Linear solver with prescribed components, on the ranks of the problem: MUMPS, or GMRES behind algebraic multigrid;
/// PETSc's options (prefix grus_) change either; LU when all else fails.
class LinearSolver {
public:
  LinearSolver(Problem::Impl& p, LinearMethod method)
      : p_(p), iterative_(method == LinearMethod::iterative), a_(compat::make_matrix(p.comm, *p.space)) {
    check(MatSetOption(a_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
    check(MatCreateVecs(a_, &x_, &b_), "MatCreateVecs");
    check(KSPCreate(p.comm, &ksp_), "KSPCreate");
    check(set_up(ksp_, method), "KSPSetFromOptions");
    if (iterative_) tell_rigid_motions();
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
    const auto prescribe = [&] {
      check(VecGetArray(x_, &x), "VecGetArray");
      for (const auto* c : mine_) x[c->dof] = (p_.factor(c->boundary, to) - p_.factor(c->boundary, from)) * c->value;
      check(VecRestoreArray(x_, &x), "VecRestoreArray");
    };
    prescribe();
    check(MatZeroRowsColumns(a_, static_cast<PetscInt>(rows_.size()), rows_.data(), 1.0, x_, b_), "MatZeroRowsColumns");
    bool good = all_true(p_.comm, attempt(ksp_));  // an error may be one rank's alone
    iterations_ += iterative_ ? iterations_of(ksp_) : 0;
    if (!good) {
      ++failures_;
      KSP plain;
      check(KSPCreate(p_.comm, &plain), "KSPCreate");
      direct(plain);
      good = attempt(plain);
      KSPDestroy(&plain);
    }
    if (iterative_) prescribe();  // these are known, not found
    dx.resize(rhs.size());
    check(VecGetArray(x_, &x), "VecGetArray");
    std::copy_n(x, dx.size(), dx.begin());
    check(VecRestoreArray(x_, &x), "VecRestoreArray");
    double finite = 0;
    for (double v : dx) finite += v;
    return all_true(p_.comm, good && std::isfinite(finite));
  }

  int iterations() { return std::exchange(iterations_, 0); }  // since it was last asked
  int failures() { return std::exchange(failures_, 0); }      // solves that the direct one has stood in for

private:
  /// Motions without strain, which a coarse grid must know; about an axis there is but one.
  void tell_rigid_motions() {
    if (p_.discretisation.kinematics == Kinematics::axisymmetric) return;
    Vec at;
    double* x;
    MatNullSpace motions;
    check(VecDuplicate(b_, &at), "VecDuplicate");
    check(VecSetBlockSize(at, p_.components), "VecSetBlockSize");
    check(VecGetArray(at, &x), "VecGetArray");
    for (std::size_t n = 0; n < static_cast<std::size_t>(p_.owned_nodes()); ++n)
      std::copy_n(p_.node_at[n].begin(), p_.width(), x + n * p_.width());
    check(VecRestoreArray(at, &x), "VecRestoreArray");
    check(MatNullSpaceCreateRigidBody(at, &motions), "MatNullSpaceCreateRigidBody");
    check(MatSetNearNullSpace(a_, motions), "MatSetNearNullSpace");
    MatNullSpaceDestroy(&motions);
    VecDestroy(&at);
  }
  static int iterations_of(KSP ksp) {
    PetscInt count = 0;
    check(KSPGetIterationNumber(ksp, &count), "KSPGetIterationNumber");
    return static_cast<int>(count);
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
  bool iterative_;
  int iterations_ = 0, failures_ = 0;
  Mat a_ = nullptr;
  Vec x_ = nullptr, b_ = nullptr;
  KSP ksp_ = nullptr;
  std::vector<PetscInt> rows_;
  std::vector<const Prescribed*> mine_;
};

}  // namespace grus::fem
