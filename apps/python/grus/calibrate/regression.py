# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters from noisy runs by batch regression: a Sobol design, then batches in a box that shrinks about the best
point so far; every component of the answer is fitted by a weighted quadratic over all runs, and the fit is minimised
within bounds. Noise averages, batches fill the cores, and the fit says what the data cannot tell. Parameters are in [0,
1]^p here."""
import math
from dataclasses import dataclass, field

import numpy as np
from scipy import stats
from scipy.optimize import least_squares
from scipy.stats import qmc

SHRINK, LEAST_BOX = 0.65, (
    0.02, 0.1)  # of the box's half width from batch to batch; where it stops: at two standard deviations between these
PRIOR = 12.0  # 1 / variance of what is known before: even over the range
FAILED = 0.1  # weight of a run that became unstable
IDENTIFIED, WEAK = 0.1, 0.15  # standard deviation, of the range
AT_BOUND = 1e-3  # of the range
TOO_FAR = 3  # standard deviations, rms over a target's points


@dataclass
class Answer:
    """What a point gave: `values` (m), NaN where a run has nothing to say; `between` (m, m): covariance of the values
    of one seed's run from seed to seed; `seeds` (m): how many each is the mean of; `failed`: a run became unstable."""
    values: np.ndarray
    between: np.ndarray
    seeds: np.ndarray
    failed: bool = False


@dataclass
class Data:
    """What is to be met: `values` (m) with standard deviations `error`; `weight` (m): of each in the sum of squares;
    `specimens` (m): the data themselves scatter as the mean of so many runs, 0: they do not."""
    values: np.ndarray
    error: np.ndarray
    weight: np.ndarray
    specimens: np.ndarray


@dataclass
class Result:
    x: np.ndarray  # the best point of the fit
    covariance: np.ndarray  # (p, p)
    singular_values: np.ndarray  # of the weighted sensitivities, per range
    directions: np.ndarray  # rows: of the parameters, by the singular values
    fitted: np.ndarray  # values of the fit at x
    misfit: np.ndarray  # (fitted - data) / standard deviation of data and noise
    history: list = field(default_factory=list)  # (points so far, x, sd)
    surface: object = None
    noise: np.ndarray | None = None  # (m, m): covariance of data, seeds and fit at x


def quadratic(x, centre):
    """Constant, linear and quadratic terms about a centre: (n, p) -> (n, 1 + p + p (p + 1) / 2)."""
    d = np.atleast_2d(x) - centre
    p = d.shape[1]
    squares = [d[:, i] * d[:, j] for i in range(p) for j in range(i, p)]
    return np.column_stack([np.ones(len(d)), d] + squares)


class Surface:
    """A weighted quadratic of each component; quadratic terms that the runs do not ask for stay small."""

    def __init__(self, x, y, weight, centre):
        self.centre, p = centre, x.shape[1]
        a = quadratic(x, centre)
        bend = np.zeros(a.shape[1])
        bend[1 + p:] = 1e-3 * weight.sum()
        normal = a.T @ (weight[:, None] * a) + np.diag(bend)
        self.inverse = np.linalg.pinv(normal, hermitian=True)
        self.coefficients = self.inverse @ (a.T @ (weight[:, None] * y))
        self.spread = self.inverse @ (
            a.T @ (weight[:, None]**2 * a)) @ self.inverse  # of the coefficients, per variance
        rest = y - a @ self.coefficients
        free = weight.sum() - np.trace(self.inverse @ (a.T @ (weight[:, None] * a)))
        self.noise = (weight[:, None] * rest).T @ rest / max(free, 1.0)  # covariance about the surface

    def at(self, x):
        return (quadratic(x, self.centre) @ self.coefficients)[0]

    def slope(self, x):
        """(m, p)"""
        p = len(self.centre)
        d, columns = np.asarray(x) - self.centre, []
        for k in range(p):
            row = np.zeros(self.coefficients.shape[0])
            row[1 + k] = 1
            place = 1 + p
            for i in range(p):
                for j in range(i, p):
                    row[place] = (i == k) * d[j] + (j == k) * d[i]
                    place += 1
            columns.append(row @ self.coefficients)
        return np.array(columns).T

    def leverage(self, x):
        a = quadratic(x, self.centre)[0]
        return float(a @ self.spread @ a)

    def slope_spread(self):
        """Of the slopes at the centre, per variance about the surface: (p, p)."""
        p = len(self.centre)
        return self.spread[1:1 + p, 1:1 + p]


def weights_of(points, failed, centre, half):
    away = np.abs(points - centre).max(axis=1) / half
    near = np.exp(-2 * np.maximum(0, away - 1) ** 2)
    return np.maximum(near, 1e-3) * np.where(failed, FAILED, 1.0)


def filled(answers):
    """Values of all points; what a run has nothing to say of is worse than the worst."""
    y = np.array([a.values for a in answers], dtype=float)
    centre = np.nanmedian(y, axis=0)
    spread = np.nanmax(np.abs(y - centre), axis=0)
    for k, row in enumerate(y):
        gone = np.isnan(row)
        if gone.any():
            known = ~gone
            sign = np.sign(np.sum(row[known] - centre[known])) if known.any() else -1.0
            y[k, gone] = centre[gone] + (sign or -1.0) * 1.5 * spread[gone]
    return y


def between_seeds(answers):
    """Covariance of one run from seed to seed, pooled over the points, and of a point's mean."""
    pooled = [a.between for a in answers if not a.failed and np.isfinite(a.values).all()]
    m = len(answers[0].values)
    one = np.mean(pooled, axis=0) if pooled else np.zeros((m, m))
    return one, one / np.sqrt(np.outer(answers[0].seeds, answers[0].seeds))


def best_of(surface, starts, low, high, data, sd):
    scale = np.sqrt(data.weight) / sd

    def residual(x):
        return scale * (surface.at(x) - data.values)

    def jacobian(x):
        return scale[:, None] * surface.slope(x)

    found = [
        least_squares(residual, np.clip(s, low + 1e-9, high - 1e-9), jacobian, bounds=(low, high), xtol=1e-12,
                      ftol=1e-12, gtol=1e-12) for s in starts
    ]
    return min(found, key=lambda r: r.cost).x


def few(mean_run, common, seeds, points):
    """What a variance that few seeds have told is widened by: two deviations are to hold 95 % all the same (Student).
    What seeds have in common at all points is told by them alone, what each point draws anew by all points together."""
    if seeds < 2:
        return 1.0
    share = min(1.0, np.trace(common) / max(np.trace(mean_run), 1e-300))
    freedom = (seeds - 1) * (1 + (points - 1) * (1 - share))
    return (stats.t.ppf(stats.norm.cdf(2), freedom) / 2) ** 2


def uncertainty(surface, x, data, one_run, mean_run, seeds, points):
    """Covariance of the parameters, the sensitivities' singular values and directions, covariance of data and runs.
    Sandwich of the weighted fit with the whole covariance of data and runs; slopes that noise alone would show tell
    nothing; the range is known before."""
    share = np.divide(1.0, data.specimens, out=np.zeros_like(data.specimens), where=data.specimens > 0)
    # What seeds have in common at all points does not show about the surface, and no number of points averages it.
    values, vectors = np.linalg.eigh(mean_run - surface.noise)
    common = vectors @ np.diag(np.maximum(values, 0)) @ vectors.T
    drawn = common + np.sqrt(share)[:, None] * one_run * np.sqrt(share)
    noise = np.diag(data.error**2) + few(mean_run, common, seeds, points) * drawn + surface.leverage(x) * surface.noise
    sd = np.sqrt(np.maximum(np.diag(noise), 1e-300))
    w = data.weight / sd**2
    j = surface.slope(x)
    a = j.T @ (w[:, None] * j)
    a_noise = float(np.sum(w * np.diag(surface.noise))) * surface.slope_spread()
    values, vectors = np.linalg.eigh(a - a_noise)
    a = vectors @ np.diag(np.maximum(values, 0)) @ vectors.T
    b = j.T @ (w[:, None] * noise * w) @ j
    b += 1e-12 * max(np.trace(b), 1e-300) * np.eye(len(x))
    precision = a @ np.linalg.solve(b, a)
    covariance = np.linalg.inv(0.5 * (precision + precision.T) + PRIOR * np.eye(len(x)))
    _, singular, directions = np.linalg.svd(np.sqrt(w)[:, None] * j, full_matrices=False)
    return covariance, singular, directions, noise


def smaller(half, sd):
    return max(half * SHRINK, min(LEAST_BOX[1], max(LEAST_BOX[0], 2 * sd)))


def calibrate(evaluate, p, data, points, batch=None, seed=1, told=None):
    """`evaluate` (list of points (p,), in [0, 1]^p) -> list of Answer, in their order. Result of `points` points."""
    batch = batch or max(8, 2 * p + 2)
    terms = (p + 1) * (p + 2) // 2
    first = min(points, max(batch, terms + 2))
    design = qmc.Sobol(p, scramble=True, seed=seed)
    low, high = np.zeros(p), np.ones(p)
    centre, half, known = np.full(p, 0.5), 0.5, 1.0
    tried, answers, history = np.zeros((0, p)), [], []
    result = None
    while len(tried) < points:
        count = min(first if not len(tried) else batch, points - len(tried))
        box_low, box_high = np.maximum(low, centre - half), np.minimum(high, centre + half)
        cube = design.random(2 ** math.ceil(math.log2(max(2, count))))[:count]
        fresh = box_low + (box_high - box_low) * cube
        answers += evaluate([row for row in fresh])
        tried = np.vstack([tried, fresh])
        y, failed = filled(answers), np.array([a.failed for a in answers])
        one_run, mean_run = between_seeds(answers)
        sd = np.sqrt(np.maximum(data.error**2 + np.diag(mean_run), 1e-300))
        cost = ((data.weight / sd**2) * (y - data.values) ** 2).sum(axis=1)
        starts = [tried[k] for k in np.argsort(cost, kind="stable")[:4]] + [centre]
        surface = Surface(tried, y, weights_of(tried, failed, centre, half), centre)
        x = best_of(surface, starts, box_low, box_high, data, sd)
        surface = Surface(tried, y, weights_of(tried, failed, x, smaller(half, known)), x)
        x = best_of(surface, [x], box_low, box_high, data, sd)
        covariance, singular, directions, noise = uncertainty(surface, x, data, one_run, mean_run,
                                                              float(np.median(answers[0].seeds)), len(tried))
        history.append((len(tried), x, np.sqrt(np.diag(covariance))))
        misfit = (surface.at(x) - data.values) / np.sqrt(np.maximum(np.diag(noise), 1e-300))
        result = Result(x, covariance, singular, directions, surface.at(x), misfit, history, surface, noise)
        if told:
            told(result)
        known = float(np.sqrt(np.diag(covariance)).min())
        centre, half = x, smaller(half, known)
    return result


def verdicts(result, names, off=None):
    """One text a parameter: identified, weak, or not identified, and with what it can be exchanged. One at its bound,
    or of a fit that is far from data (`off`: deviations by target), is never identified."""
    sd = np.sqrt(np.diag(result.covariance))
    values, vectors = np.linalg.eigh(result.covariance)
    texts = []
    for k, name in enumerate(names):
        bound = "lower" if result.x[k] <= AT_BOUND else "upper" if result.x[k] >= 1 - AT_BOUND else None
        if sd[k] <= IDENTIFIED and not bound and not off:
            texts.append("identified")
            continue
        direction = vectors[:, int(np.argmax(values * vectors[k] ** 2))]
        others = [(names[i], direction[i] / direction[k]) for i in range(len(names))
                  if i != k and abs(direction[i]) > 0.3 * abs(direction[k]) and abs(direction[i]) > 0.3]
        text = "doubtful" if sd[k] <= IDENTIFIED else "weak" if sd[k] <= WEAK else "not identified"
        if bound:
            text = f"not identified: at its {bound} bound"
        if off:
            text += "; " + ", ".join(f"the fit is {v:.1f} deviations off '{target}'" for target, v in off.items())
        if others and sd[k] > IDENTIFIED:
            text += " (combination with " + ", ".join(f"{n}: {r:+.2f} of its range a range" for n, r in others) + ")"
        texts.append(text)
    return texts
