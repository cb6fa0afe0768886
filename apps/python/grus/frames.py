# SPDX-License-Identifier: LGPL-3.0-or-later
"""Frames of a results folder: grains, macro mesh and contacts at the times that were written, as arrays; for pyvista
and meshio as those want them. Reading needs h5py."""
from __future__ import annotations

import glob
import json
import numbers
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grus.errors import InputError

KINDS = ("grains", "macro", "contacts")
LINE, TRIANGLE = 3, 5
# VTK's numbers, meshio's names.
NAMES = {1: "vertex", 3: "line", 5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron"}


class Frame:
    """Points and cells at one time, by VTK's numbering of kinds.

    Attributes:
        path: where it was read
        points: (n, 3) (m)
        connectivity: points of all cells; cell k joins connectivity[offsets[k]:offsets[k + 1]]
        offsets: (cells + 1,)
        types: kinds of the cells, by VTK's numbers
        cells: name -> array, one row a cell (of grains: a triangle; `id` says whose)
        at_points: name -> array, one row a point
        time: s, of macro problems the load factor; NaN where no index tells it
    """

    def __init__(self, path: str, time: float = np.nan) -> None:
        try:
            import h5py
        except ImportError:
            raise InputError("frames need h5py (Debian: python3-h5py)") from None
        self.path, self.time = path, time
        try:
            with h5py.File(path, "r") as f:
                grid = f["VTKHDF"]
                self.points, self.connectivity, self.offsets, self.types = (
                    np.asarray(grid[k]) for k in ("Points", "Connectivity", "Offsets", "Types"))
                self.cells, self.at_points = (
                    {k: np.asarray(v) for k, v in grid[group].items()} if group in grid else {}
                    for group in ("CellData", "PointData"))
        except (OSError, KeyError) as e:
            raise ValueError(f"{path}: not a frame of Grus ({e})") from None

    def __repr__(self) -> str:
        return (f"<grus.Frame of {self.path}: {len(self.points)} points, {len(self.types)} cells, "
                f"{', '.join([*self.cells, *self.at_points])}>")

    def triangles(self) -> tuple[NDArray, NDArray]:
        """(corners, which cells they are): points of each triangle (m, 3), and its place among the cells."""
        at = np.flatnonzero(self.types == TRIANGLE)
        return self.connectivity[self.offsets[at][:, None] + np.arange(3)], at

    def box(self) -> tuple[NDArray, NDArray] | None:
        """(lowest corner, lengths) of the box or cell around grains (m); None where none is drawn or where it leans."""
        ends = self.points[self.connectivity[self.offsets[np.flatnonzero(self.types == LINE)][:, None] + np.arange(2)]]
        upright = len(ends) == 12 and all(np.count_nonzero(edge) == 1 for edge in ends[:, 1] - ends[:, 0])
        return (ends.min((0, 1)), np.ptp(ends, axis=(0, 1))) if upright else None

    def grains(self) -> dict[str, NDArray]:
        """Of grains: one row a grain, by id: the fields, `position_m` (centre of its surface's volume) and
        `volume_m3`."""
        corners, at = self.triangles()
        ids, first, owner = np.unique(self.cells["id"][at].astype(np.int64), return_index=True, return_inverse=True)
        found: dict[str, NDArray] = {"id": ids}
        found |= {name: values[at][first] for name, values in self.cells.items() if name != "id"}
        x = self.points.astype(np.float64)[corners]
        start = x[first, 0][owner]  # of each grain a point of its own: far from the origin digits would be lost
        a, b, c = (x[:, k] - start for k in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        total = np.bincount(owner, volume, len(ids))
        moment = np.stack([np.bincount(owner, volume * (a + b + c)[:, k] / 4, len(ids)) for k in range(3)], 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            found["position_m"] = x[first, 0] + moment / total[:, None]
        found["volume_m3"] = total
        return found

    def pyvista(self) -> Any:
        """A pyvista.UnstructuredGrid (needs pyvista)."""
        import pyvista
        sizes = np.diff(self.offsets)
        joined = np.insert(self.connectivity, self.offsets[:-1], sizes)
        grid = pyvista.UnstructuredGrid(joined, self.types, self.points)
        for name, values in self.cells.items():
            grid.cell_data[name] = values
        for name, values in self.at_points.items():
            grid.point_data[name] = values
        return grid

    def meshio(self) -> Any:
        """A meshio.Mesh (needs meshio); cells of one kind together, their data with them."""
        import meshio
        kinds = [int(k) for k in np.unique(self.types) if int(k) in NAMES]
        blocks, data = [], {name: [] for name in self.cells}  # type: ignore[var-annotated]
        for kind in kinds:
            at = np.flatnonzero(self.types == kind)
            size = int(self.offsets[at[0] + 1] - self.offsets[at[0]])
            blocks.append((NAMES[kind], self.connectivity[self.offsets[at][:, None] + np.arange(size)]))
            for name, values in self.cells.items():
                data[name].append(values[at])
        if not kinds:  # meshio cannot write data of no cells
            data = {}
        return meshio.Mesh(self.points, blocks, point_data=self.at_points, cell_data=data)


def frames(folder: str, kind: str) -> list[tuple[str, float]]:
    """(file, time) of every frame of grains, macro or contacts, in their order."""
    try:
        with open(os.path.join(folder, kind + ".hdf.series")) as f:
            told = {e["name"]: float(e["time"]) for e in json.load(f)["files"]}
    except (OSError, ValueError, KeyError, TypeError):
        told = {}
    files = sorted(glob.glob(os.path.join(glob.escape(folder), kind, kind + "_*.hdf")))
    return [(path, told.get(f"{kind}/{os.path.basename(path)}", float("nan"))) for path in files]


def frame(folder: str, kind: str, number: int = -1) -> Frame:
    """The frame of that number, from the end if below 0. Raises InputError where there is none."""
    found = frames(folder, kind)
    if not found:
        hint = " (output.contacts = true)" if kind == "contacts" else " (output.frames)"
        raise InputError(f"{folder}: no frames of {kind}{hint}")
    if not isinstance(number, numbers.Integral):
        raise InputError(f"{folder}: frame {number!r} of {kind}: frames have whole numbers")
    if not -len(found) <= number < len(found):
        raise InputError(f"{folder}: no frame {number} of {kind}: there are {len(found)}")
    return Frame(*found[number])
