# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders of grus-rve and grus-bvp: history.csv, summary.json, grading.csv."""
from __future__ import annotations

import csv
import json
import math
import os
from typing import TYPE_CHECKING, Any, Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from grus.asked import Lacking, Named, path_of
from grus.errors import InputError

if TYPE_CHECKING:
    import pandas

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

    folder     where it was read
    summary    summary.json: the scene as used, counts, energies, error estimates, status (0 finished, 3 unstable)
    grading    strain -> {column: array over size classes}; empty unless the scene asked for it
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

    @property
    def status(self) -> int:
        """0: finished; 3: unstable."""
        return self.summary["status"]

    def frame(self) -> pandas.DataFrame:
        """history.csv as a pandas.DataFrame (needs pandas)."""
        import pandas
        return pandas.DataFrame(self.history)


def load(folder: Path) -> Results:
    """Reads a results folder of grus-rve or grus-bvp. Raises InputError where there is none, or a damaged one."""
    return Results(folder)
