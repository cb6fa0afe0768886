# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders of grus-rve and grus-bvp: history.csv, summary.json, grading.csv."""
from __future__ import annotations

import csv
import html
import json
import math
import os
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from grus import curves
from grus.asked import Lacking, Named, path_of
from grus.bands import ShearBand, shear_band
from grus.errors import InputError
from grus.frames import Frame, frame

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

Path = str | os.PathLike[str]


def read_history(folder: str) -> dict[str, list[float]]:
    """history.csv as columns; an empty field is NaN. Throws ValueError, one line, for what is no table of numbers."""
    path = os.path.join(folder, "history.csv")
    try:
        with open(path, newline="") as f:
            rows = list(csv.reader(f))
    except (csv.Error, UnicodeDecodeError) as e:
        raise ValueError(f"{path}: not a table: {e}") from None
    if len(rows) < 2:
        raise ValueError(f"{path}: no rows")
    columns: dict[str, list[float]] = {name: [] for name in rows[0]}
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path}: line {number} has {len(row)} values for {len(rows[0])} columns")
        for name, value in zip(rows[0], row):
            try:
                columns[name].append(float(value) if value else math.nan)
            except ValueError:
                raise ValueError(f"{path}: line {number}: {name} is not a number") from None
    return columns


def read_summary(folder: str, hook: Callable[[dict], Any] | None = None) -> dict[str, Any]:
    """summary.json; `hook` makes of each of its tables what is wanted. Raises OSError, ValueError."""
    path = os.path.join(folder, "summary.json")
    with open(path) as f:
        try:
            summary = json.load(f, object_hook=hook)
        except (ValueError, RecursionError) as e:
            raise ValueError(f"{path}: not JSON: {e}") from None
    if not isinstance(summary, dict):
        raise ValueError(f"{path}: not a summary of Grus")
    return summary


def read_grading(folder: str, files: Any = None) -> dict[float, list[dict[str, float]]]:
    """States of grading.csv, if the scene asked for it: strain -> rows by size class. `files`: what summary.json lists
    of the run's files, None where it lists none."""
    path = os.path.join(folder, "grading.csv")
    if not os.path.isfile(path) or (isinstance(files, list) and "grading.csv" not in files):
        return {}
    states: dict[float, list[dict[str, float]]] = {}
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            states.setdefault(float(row["strain"]), []).append({k: float(v) for k, v in row.items()})
    return states


def read_run(folder: str) -> dict[str, Any]:
    """What studies and calibrations read of a run: columns, summary, grading."""
    summary = read_summary(folder)
    return {"columns": read_history(folder), "summary": summary, "grading": read_grading(folder, summary.get("files"))}


class Results(Mapping[str, NDArray]):
    """A results folder: `r["axial_stress_Pa"]` is a column of history.csv, (rows,); SI, NaN where a field is empty.

    Attributes:
        folder: where it was read
        summary: summary.json: the scene as used, counts, energies, error estimates, status (0 finished, 3 unstable)
        history: the columns by name
        grading: strain -> {column: array over size classes}; empty unless the scene asked for it
    """

    def __init__(self, folder: Path) -> None:
        folder = path_of("folder", folder)
        try:
            self.summary: dict[str, Any] = read_summary(folder, lambda d: Named(f"{folder}: summary.json", d))
            self.history = {name: np.array(column) for name, column in read_history(folder).items()}
            self.grading = Named(f"{folder}: grading.csv", {
                strain: Named(f"{folder}: grading.csv", {key: np.array([row[key] for row in rows]) for key in rows[0]})
                for strain, rows in read_grading(folder, self.summary.get("files")).items()})
        except OSError as e:
            raise InputError(f"{folder}: no results of Grus: {e.strerror}: {e.filename}") from None
        except ValueError as e:
            raise InputError(f"{folder}: {e}" if folder not in str(e) else str(e)) from None
        self.folder = folder

    def __getitem__(self, column: str) -> NDArray:
        if column not in self.history:
            raise Lacking(f"{self.folder}: history.csv", column, self.history)
        return self.history[column]

    def __repr__(self) -> str:
        rows = len(next(iter(self.history.values()))) if self.history else 0
        ended = {0: "finished", 3: "unstable"}.get(self.summary.get("status", -1), "unfinished")
        return f"<grus.Results of {self.folder}: {rows} rows of {len(self.history)} columns, {ended}>"

    def __iter__(self) -> Iterator[str]:
        return iter(self.history)

    def __len__(self) -> int:
        return len(self.history)

    def grains(self, frame: int = -1) -> Frame:
        """Grains of a frame, the last by default: arrays, `.grains()` one row a grain, `.pyvista()`, `.meshio()`.

        Raises:
            InputError: where there is none
        """
        return self._frame("grains", frame)

    def macro(self, frame: int = -1) -> Frame:
        """The macro mesh of a frame."""
        return self._frame("macro", frame)

    def contacts(self, frame: int = -1) -> Frame:
        """Contacts of a frame, if the scene asked for them."""
        return self._frame("contacts", frame)

    def shear_band(self, first: int = 0, last: int = -1) -> ShearBand:
        """What has sheared between two frames of a macro problem: the part of the body that takes part, and width,
        angle and peak of its strongest band.

        Args:
            first: number of the frame that strains are counted from
            last: number of the frame up to which they are

        Raises:
            InputError: where there are none, or both are one
        """
        before, after = self.macro(first), self.macro(last)
        if before.path == after.path:
            raise InputError(f"{before.path}: strains are found between two frames, and this is both")
        return shear_band(before, after)

    def _frame(self, kind: str, number: int) -> Frame:
        if not os.path.isdir(self.folder):
            raise InputError(f"{self.folder}: is gone: a run keeps its frames where it is given out=")
        return frame(self.folder, kind, number)

    def plot(self, y: str | None = None, x: str | None = None, *, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws a column over another, by default the load over the strain or the way (needs matplotlib).

        Args:
            y: a column's name
            x: a column's name
            ax: axes to draw on; default: new ones
            **style: as matplotlib's plot takes it

        Returns:
            The axes
        """
        if ax is None:
            from matplotlib.figure import Figure
            try:
                import matplotlib.pyplot as plt
                ax = plt.subplots()[1]
            except ImportError:
                ax = Figure().subplots()
        xs, ys, x_name, y_name = self._curve(x, y)
        ax.plot(xs, ys, **{"label": os.path.basename(os.path.abspath(self.folder)), **style})
        ax.set(xlabel=x_name, ylabel=y_name)
        ax.grid(alpha=0.3)
        return ax

    def _load(self) -> tuple[Any, Any, str, str]:
        return curves.load(self.history, self.summary.get("scene", {}))

    def _curve(self, x: str | None, y: str | None) -> tuple[Any, Any, str, str]:
        if y is None and x is None:
            return self._load()
        own, name = curves.along(self.history)
        return self[x] if x else own, self[y] if y else self._load()[1], x or name, y or "load"

    def _repr_html_(self) -> str:
        """What a notebook shows: how it ended, its load as a small picture, the names of its columns."""
        told = {"results": self.folder, "scene": self.summary.get("title", ""),
                "ending": self.summary.get("ending", "")}
        told |= {name.replace("_", " "): f"{value:.4g}" for name, value in self.summary.get("results", {}).items()
                 if isinstance(value, float)}
        rows = "".join(f"<tr><th style='text-align:left'>{html.escape(str(k))}</th><td>{html.escape(str(v))}</td></tr>"
                       for k, v in told.items())
        names = html.escape(", ".join(self.history))
        return (f"<table>{rows}</table>{_sketch(*self._load())}"
                f"<details><summary>{len(self.history)} columns</summary>{names}</details>")

    @property
    def status(self) -> int:
        """0: finished; 3: unstable."""
        return self.summary["status"]

    def frame(self) -> pandas.DataFrame:
        """history.csv as a pandas.DataFrame (needs pandas)."""
        import pandas
        return pandas.DataFrame(self.history)


def _sketch(x: Any, y: Any, x_name: str, y_name: str) -> str:
    """A curve as SVG, with its ends."""
    found = curves.thinned(x, y)
    if len(found["x"]) < 2:
        return ""
    (left, right), (low, high) = ((min(v), max(v)) for v in (found["x"], found["y"]))
    across, up = 240 / (right - left or 1), 120 / (high - low or 1)
    places = " ".join(f"{50 + across * (a - left):.1f},{140 - up * (b - low):.1f}" for a, b in zip(*found.values()))
    texts = [(50, 155, "start", f"{left:.3g}"), (290, 155, "end", f"{right:.3g}"), (46, 140, "end", f"{low:.3g}"),
             (46, 24, "end", f"{high:.3g}"), (170, 170, "middle", x_name), (170, 12, "middle", y_name)]
    words = "".join(f'<text x="{a}" y="{b}" text-anchor="{side}">{html.escape(t)}</text>' for a, b, side, t in texts)
    title = html.escape(f"{y_name} against {x_name}")
    return (f'<svg width="300" height="176" font-size="11" font-family="sans-serif"><title>{title}</title>'
            f'<rect x="50" y="20" width="240" height="120" fill="none" stroke="#999"/>'
            f'<polyline points="{places}" fill="none" stroke="#1f77b4" stroke-width="1.5"/>{words}</svg>')


def load(folder: Path) -> Results:
    """Reads a results folder of grus-rve or grus-bvp.

    Raises:
        InputError: where there is none, or a damaged one
    """
    return Results(folder)
