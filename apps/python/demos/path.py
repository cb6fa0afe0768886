# SPDX-License-Identifier: LGPL-3.0-or-later
"""An RVE of crushable sand along a path: uniaxial compression, then shear at constant volume. python3 path.py
[PICTURE]"""
import os
import sys

import matplotlib
import numpy as np

import grus

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

scene = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scenes/sand_rve.toml")
rve = grus.Rve(scene)
strains, stresses, broken = [], [], []
for step in range(40):
    dF = np.eye(3)
    if step < 20:
        dF[2, 2] -= 2e-3
    else:
        dF[0, 2] += 4e-3
    stress, tangent = rve.advance(dF)
    rve.commit()
    strains.append(step + 1), stresses.append(stress / 1e6), broken.append(rve.facts()["breakages"])

stresses = np.array(stresses)
figure, axes = plt.subplots(2, 1, sharex=True)
for name, k in {"-xx": 0, "-zz": 2, "-xz": 4}.items():
    axes[0].plot(strains, -stresses[:, k], label=f"{name} (MPa)")
axes[0].legend()
axes[1].plot(strains, broken, label="grains broken")
axes[1].set_xlabel("increment")
axes[1].legend()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "path.png")
print(f"at the end {-stresses[-1, 2]:.4g} MPa along z, shear {stresses[-1, 4]:.4g} MPa, {broken[-1]} grains broken")
