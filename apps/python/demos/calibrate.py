# SPDX-License-Identifier: LGPL-3.0-or-later
"""Calibration in a notebook: Young's modulus of the grains from two points of a measured compression curve, by SciPy.

For more than one parameter, seeds, noise and what data do not fix, use grus-calibrate. python3 calibrate.py
"""
import os

import numpy as np
from scipy.optimize import least_squares

import grus

scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/sand_rve.toml")


# %% The model: axial stress (MPa) of an RVE after 0.2 and 0.4 % of uniaxial strain.
def curve(modulus_gpa, seed=1):
    rve = grus.Rve(
        scene,
        set=["material.sand.fracture=", f"material.sand.youngs_modulus={modulus_gpa} GPa",
             f"packing.seed={seed}"], unbalanced_force=1e-4, stress_change=1e-4)
    axial = []
    for _ in range(2):
        stress, _ = rve.advance(np.diag([1, 1, 1 - 2e-3]))
        rve.commit()
        axial.append(-stress[2] / 1e6)
    return np.array(axial)


# %% The data: here a twin with 45 GPa; yours come from a file.
data = curve(45.0)

# %% The fit, over the logarithm: a modulus is positive.
fit = least_squares(lambda p: curve(np.exp(p[0])) / data - 1, x0=[np.log(70.0)], diff_step=0.02, xtol=1e-3, ftol=1e-4)
print(f"{np.exp(fit.x[0]):.4g} GPa after {fit.nfev} steps, largest residual {np.abs(fit.fun).max():.2g}")
