# SPDX-License-Identifier: LGPL-3.0-or-later
"""Calibration by TAO's POUNDERS, for what is smooth: it builds models of the single residuals, one point after the
other."""
import numpy as np

from grus.calibrate import regression
from grus.errors import InputError


def pounders(evaluate, p, data, points, told):
    """TAO's POUNDERS, for what is smooth: one point after the other."""
    try:
        import petsc4py
        petsc4py.init([])
        from petsc4py import PETSc
    except ImportError:
        raise InputError("method = \"pounders\" needs python3-petsc4py; install it, or use \"regression\"") from None
    m, answers, tried = len(data.values), [], []
    scale = np.sqrt(data.weight) / data.error

    def residual(_, x, f):
        u = np.clip(x.getArray(readonly=True).copy(), 0, 1)
        tried.append(u)
        answers.append(evaluate([u])[0])
        f.setArray(scale * (regression.filled(answers)[-1] - data.values))

    x = PETSc.Vec().createWithArray(np.full(p, 0.5), comm=PETSc.COMM_SELF)
    f = PETSc.Vec().createSeq(m)
    tao = PETSc.TAO().create(PETSc.COMM_SELF)
    tao.setType("pounders")
    options = PETSc.Options()
    options["tao_pounders_delta"] = 0.2
    tao.setFromOptions()
    tao.setResidual(residual, f)
    tao.setVariableBounds((PETSc.Vec().createWithArray(np.zeros(p), comm=PETSc.COMM_SELF),
                           PETSc.Vec().createWithArray(np.ones(p), comm=PETSc.COMM_SELF)))
    tao.setMaximumFunctionEvaluations(points)
    tao.setTolerances(1e-12, 1e-12, 0)
    tao.solve(x)
    y = regression.filled(answers)
    best = int(np.argmin((scale**2 * (y - data.values) ** 2).sum(axis=1)))
    centre = np.array(tried[best])
    away = np.abs(np.array(tried) - centre).max(axis=1)
    near = np.sort(away)[min(len(away) - 1, (p + 1) * (p + 2) // 2 + 1)]
    surface = regression.Surface(
        np.array(tried), y,
        regression.weights_of(np.array(tried), np.array([a.failed for a in answers]), centre, max(near, 1e-6)), centre)
    one, mean = regression.between_seeds(answers)
    seeds = float(np.median(answers[0].seeds))
    covariance, singular, directions, noise = regression.uncertainty(surface, centre, data, one, mean, seeds, 1)
    misfit = (y[best] - data.values) / np.sqrt(np.maximum(np.diag(noise), 1e-300))
    result = regression.Result(centre, covariance, singular, directions, y[best], misfit,
                               [(len(tried), centre, np.sqrt(np.diag(covariance)))], surface, noise)
    told(result)
    return result
