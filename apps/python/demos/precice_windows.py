# SPDX-License-Identifier: LGPL-3.0-or-later
"""What preCICE's Micro Manager does with grus.precice.MicroSimulation, by hand: three time windows, each iterated
twice.

GRUS_SCENE=../../scenes/sand_rve.toml python3 precice_windows.py
"""
import numpy as np

from grus.precice import MicroSimulation


def macro(axial):
    F = np.diag([1.0, 1.0, 1.0 - axial])
    return {f"deformation-gradient-{row + 1}": F[row] for row in range(3)}


def windows(guesses):
    """Stress along z (Pa) at the end of each window; a wrong guess comes first, and is taken back."""
    sim = MicroSimulation(0)
    sim.initialize()
    ends = []
    for window in range(1, 4):
        before = sim.get_state()
        for guess in guesses:
            sim.set_state(before)
            answer = sim.solve(macro(1e-3 * window * guess), dt=1.0)
        ends.append(float(answer["stress-normal"][2]))
    return ends


iterated, straight = windows([1.4, 1.0]), windows([1.0])
print("iterated", iterated)
print("straight", straight)
raise SystemExit(0 if iterated == straight else "a window that is taken back leaves a trace")
