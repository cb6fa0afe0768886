# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of scenes by grus-rve and grus-bvp, and what they have written."""
from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from typing import TYPE_CHECKING, Any, Iterable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ._core import InputError, Unstable
from .asked import Lacking, Named, changes_of, path_of, whole_number

sys.path.append(os.path.dirname(os.path.abspath(__file__)))  # the commands' readers are modules of their own
from grus_results import read_grading, read_history  # type: ignore[import]  # noqa: E402

if TYPE_CHECKING:
    import pandas

Path = str | os.PathLike[str]


def _summary(folder: str) -> dict[str, Any]:
    """summary.json of a folder. Raises OSError, ValueError."""
    path = os.path.join(folder, "summary.json")
    with open(path) as f:
        try:
            summary = json.load(f, object_hook=lambda d: Named(f"{folder}: summary.json", d))
        except (ValueError, RecursionError) as e:
            raise ValueError(f"{path}: not JSON: {e}") from None
    if not isinstance(summary, dict):
        raise ValueError(f"{path}: not a summary of Grus")
    return summary


class Results(Mapping[str, NDArray]):
    """A results folder: `r["axial_stress_Pa"]` is a column of history.csv, (rows,); SI, NaN where a field is empty.

    folder     where it was read
    summary    summary.json: the scene as used, counts, energies, error estimates, status (0 finished, 3 unstable)
    grading    strain -> {column: array over size classes}; empty unless the scene asked for it
    """

    def __init__(self, folder: Path) -> None:
        folder = path_of("folder", folder)
        try:
            self.summary: dict[str, Any] = _summary(folder)
            self.history = {name: np.array(column) for name, column in read_history(folder).items()}
            self.grading = Named(f"{folder}: grading.csv", {
                strain: Named(f"{folder}: grading.csv", {key: np.array([row[key] for row in rows]) for key in rows[0]})
                for strain, rows in read_grading(folder).items()})
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


def _program(name: str) -> str:
    here = os.path.dirname(os.path.abspath(__file__))
    for up in ("../../bin", "../../../../bin"):  # of a build; of an installation
        path = os.path.normpath(os.path.join(here, up, name))
        if os.access(path, os.X_OK):
            return path
    found = shutil.which(name)
    if found is None:
        raise InputError(f"{name}: not found beside the package nor in PATH")
    return found


def _stop(process: subprocess.Popen, by_mpirun: bool) -> None:
    """Asks a run to stop. mpirun would kill its ranks a second after it has asked them, too soon for a checkpoint: they are asked themselves."""
    ranks = []
    if by_mpirun:
        try:
            with open(f"/proc/{process.pid}/task/{process.pid}/children") as f:
                ranks = [int(child) for child in f.read().split()]
        except OSError:
            pass
    for rank in ranks:
        with contextlib.suppress(ProcessLookupError):
            os.kill(rank, signal.SIGTERM)
    if not ranks:
        process.send_signal(signal.SIGTERM)


def run(scene: Path, set: Iterable[str] = (), *, out: Path | None = None, threads: int | None = None, ranks: int = 1,
        check: bool = True, force: bool = False) -> Results:
    """Runs a scene by grus-rve, or by grus-bvp where it has a [mesh], and returns its results.

    set        "KEY=VALUE" changes of the scene
    out        results folder, which stays; default: a temporary one, of which only what is returned remains
    threads    default: all cores
    ranks      of grus-bvp, by mpirun
    check      raise Unstable where the run ends unstable; else its results are returned, with status 3
    force      overwrite the results in `out`

    Raises InputError for a scene that cannot run, Unstable, KeyboardInterrupt (the run writes its checkpoint first), RuntimeError.
    """
    scene, set = path_of("scene", scene), changes_of(set)
    threads = None if threads is None else whole_number("threads", threads, 1)
    ranks = whole_number("ranks", ranks, 1)
    if ranks > 1 and shutil.which("mpirun") is None:
        raise InputError(f"ranks = {ranks}: there is no mpirun here")
    try:
        with open(scene, "rb") as f:
            raw = f.read()
        encoding = "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
        macro = "mesh" in tomllib.loads(raw.decode(encoding))
    except OSError as e:
        raise InputError(f"{scene}: no such scene file: {e.strerror}") from None
    except ValueError:
        macro = False  # the program says where it is wrong
    if out is None:
        with tempfile.TemporaryDirectory(prefix="grus-") as tmp:
            return run(scene, set, out=os.path.join(tmp, "run"), threads=threads, ranks=ranks, check=check)
    out = path_of("out", out)
    command = [_program("grus-bvp" if macro else "grus-rve"), scene, "-o", out, "--quiet"]
    command += [] if threads is None else ["--threads", str(threads)]
    command += ["--force"] if force else []
    command += [text for change in set for text in ("--set", change)]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        _, errors = process.communicate()
    except KeyboardInterrupt:
        _stop(process, by_mpirun=ranks > 1)
        process.communicate()
        raise
    said = errors.strip().removeprefix("grus-bvp: ").removeprefix("grus-rve: ")
    if process.returncode == 2:
        raise InputError(said)
    if process.returncode == 3 and check:
        raise Unstable(said)
    if process.returncode not in (0, 3):
        raise RuntimeError(said or f"{command[0]} ended with status {process.returncode}")
    return Results(out)
