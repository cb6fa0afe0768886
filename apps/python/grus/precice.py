# SPDX-License-Identifier: LGPL-3.0-or-later
"""preCICE's Micro Manager with RVEs of Grus: "micro_file_name": "grus.precice" in its configuration; GRUS_SCENE names
the cell's scene file (rve.toml). Read: deformation-gradient-1, -2, -3, the rows of F. Written: stress-normal (xx yy
zz), stress-shear (yz xz xy) in Pa, tangent-1 to tangent-12, the tangent's rows by halves (Pa), and the scalars
breakages and void-ratio. Adaptivity may compare any of them."""
from __future__ import annotations

import os
from typing import Any, Mapping

import numpy as np

import grus
from grus.asked import Lacking


class MicroSimulation:
    """One Gauss point. `solve` goes on from where the last one ended; the manager goes back by set_state."""

    def __init__(self, sim_id: int) -> None:
        self._id = sim_id
        self._rve = grus.Rve(os.environ.get("GRUS_SCENE", "rve.toml"))
        self._F = np.eye(3)

    def __repr__(self) -> str:
        return f"<grus.precice.MicroSimulation {self._id}: {self._rve!r}>"

    def initialize(self) -> None:
        """Nothing to tell: RVEs begin alike, so there is nothing to compare yet. The manager ends where it is told a
        name that its adaptivity has not asked for, and does not say which it has."""

    def solve(self, macro_data: Mapping[str, Any], dt: float) -> dict[str, Any]:
        """To the macro side's F, from where the last one ended.

        Args:
            macro_data: deformation-gradient-1, -2, -3: the rows of F, (3,) each
            dt: not read: RVEs are taken to rest

        Returns:
            stress-normal, stress-shear, tangent-1 to tangent-12 (3,) (Pa); breakages, void-ratio

        Raises:
            InputError: for what is no F
            Unstable: as `Rve.advance`: the manager counts the point as crashed then
        """
        F = np.array([self._row(macro_data, f"deformation-gradient-{row}") for row in (1, 2, 3)])
        stress, tangent = self._rve.advance(F @ np.linalg.inv(self._F))
        assert tangent is not None
        self._rve.commit()
        self._F = F
        halves = {f"tangent-{k + 1}": half for k, half in enumerate(tangent.reshape(12, 3))}
        return {"stress-normal": stress[:3], "stress-shear": stress[3:], **halves, **self.output()}

    def get_state(self) -> tuple[bytes, np.ndarray]:
        """The RVE and its F; can be pickled, and set in another MicroSimulation of the same scene."""
        return self._rve.get_state(), self._F.copy()

    def set_state(self, state: tuple[bytes, np.ndarray]) -> None:
        """Back to what get_state has given."""
        self._rve.set_state(state[0])
        self._F = state[1].copy()

    def get_global_id(self) -> int:
        """As the manager counts the points."""
        return self._id

    def set_global_id(self, sim_id: int) -> None:
        """As the manager counts the points."""
        self._id = sim_id

    def output(self) -> dict[str, Any]:
        """Grains broken since the start, and the void ratio."""
        facts = self._rve.facts()
        return {"breakages": facts["breakages"], "void-ratio": facts["void_ratio"]}

    @staticmethod
    def _row(macro_data: Mapping[str, Any], name: str) -> np.ndarray:
        if name not in macro_data:
            raise Lacking("macro data (read_data_names of the manager's configuration)", name, macro_data)
        row = np.asarray(macro_data[name], dtype=float)
        if row.shape != (3,):
            raise grus.InputError(
                f"{name}: shape {row.shape}, expected three numbers, a row of F: a vector of a 3D mesh")
        return row
