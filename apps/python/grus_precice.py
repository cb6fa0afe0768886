# SPDX-License-Identifier: LGPL-3.0-or-later
"""preCICE's Micro Manager with RVEs of Grus: "micro_file_name": "grus_precice" in its configuration; GRUS_SCENE names the cell's
scene file (rve.toml). Read: deformation-gradient-1, -2, -3, the rows of F. Written: stress-normal (xx yy zz), stress-shear (yz xz xy)
in Pa, tangent-1 to tangent-12, the tangent's rows by halves (Pa), and the scalars breakages and void-ratio."""
import os

import numpy as np

import grus


class MicroSimulation:
    """One Gauss point. `solve` goes on from where the last one ended; the manager goes back by set_state."""

    def __init__(self, sim_id):
        self._id = sim_id
        self._rve = grus.Rve(os.environ.get("GRUS_SCENE", "rve.toml"))
        self._F = np.eye(3)

    def initialize(self):
        return self.output()

    def solve(self, macro_data, dt):
        F = np.array([macro_data[f"deformation-gradient-{row}"] for row in (1, 2, 3)], dtype=float)
        stress, tangent = self._rve.advance(F @ np.linalg.inv(self._F))
        self._rve.commit()
        self._F = F
        halves = {f"tangent-{k + 1}": half for k, half in enumerate(tangent.reshape(12, 3))}
        return {"stress-normal": stress[:3], "stress-shear": stress[3:], **halves, **self.output()}

    def get_state(self):
        return self._rve.get_state(), self._F.copy()

    def set_state(self, state):
        self._rve.set_state(state[0])
        self._F = state[1].copy()

    def get_global_id(self):
        return self._id

    def set_global_id(self, sim_id):
        self._id = sim_id

    def output(self):
        facts = self._rve.facts()
        return {"breakages": facts["breakages"], "void-ratio": facts["void_ratio"]}
