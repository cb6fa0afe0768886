# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the data leave possible: draws from the posterior of the parameters on the fitted surface, by emcee."""
import numpy as np

from grus.errors import InputError

STEPS, REST = 1500, 500  # of each walker; of them until where it began is forgotten


def sampler():
    try:
        import emcee
    except ImportError:
        raise InputError("posterior = true needs python3-emcee; install it, or leave it out") from None
    return emcee


def posterior(result, data, seed=1):
    """Draws (n, p) in [0, 1]^p, and how many independent ones they are worth. Even before; errors of data and runs
    normal with the covariance that the result knows (of seeds, of the fit), no weights. Same draws for the same
    seed."""
    emcee = sampler()
    p = len(result.x)
    # What is known exactly would leave nothing possible: a millionth of the largest error.
    covariance = result.noise + 1e-12 * np.trace(result.noise) * np.eye(len(data.values))
    root = np.linalg.inv(np.linalg.cholesky(covariance))

    def log_density(x):
        if (x < 0).any() or (x > 1).any():
            return -np.inf
        r = root @ (result.surface.at(x) - data.values)
        return -0.5 * float(r @ r)

    walkers, rng = max(32, 4 * p), np.random.default_rng(seed)
    spread = np.minimum(np.sqrt(np.diag(result.covariance)), 0.2)
    start = np.clip(result.x + spread * rng.normal(size=(walkers, p)), 1e-6, 1 - 1e-6)
    # A start cut off at a bound lies in a plane of few dimensions.
    start = np.where((start <= 1e-6) | (start >= 1 - 1e-6), rng.uniform(0.01, 0.99, (walkers, p)), start)
    chain = emcee.EnsembleSampler(walkers, p, log_density)
    chain.random_state = np.random.RandomState(seed).get_state()
    chain.run_mcmc(start, STEPS)
    apart = float(np.max(chain.get_autocorr_time(discard=REST, quiet=True, tol=0)))
    draws = chain.get_chain(discard=REST, flat=True)
    return draws, len(draws) / apart


def table(draws, parameters):
    """Per parameter: median and the bounds of the middle 68 and 95 %, in its own unit."""
    rows = []
    for k, p in enumerate(parameters):
        low2, low, middle, high, high2 = (p.number(u)
                                          for u in np.quantile(draws[:, k], [0.025, 0.16, 0.5, 0.84, 0.975]))
        rows.append({"key": p.key, "median": middle, "middle_68": [low, high], "middle_95": [low2, high2]})
    return rows
