# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results folders: marked as Grus's, locked while they are written, cleared of what an earlier run has left."""
from __future__ import annotations

import fcntl
import fnmatch
import os
from typing import IO, Iterable

from grus.errors import InputError

MARKER = ".grus"  # in folders that Grus has made; the lock
OF_A_RUN = ("history.csv", "summary.json", "checkpoint.h5", "grading.csv")  # where a marker does not list them
REPORT = "report.html"


def of_a_run(path: str) -> bool:
    """A file that a run has written: the marker of its folder, or of the one above, lists it. Its report is none."""
    folder, name = os.path.split(os.path.abspath(path))
    if name == MARKER or (name in OF_A_RUN and os.path.lexists(path)):
        return True
    for above, inside in ((folder, name), (os.path.dirname(folder), f"{os.path.basename(folder)}/{name}")):
        try:
            with open(os.path.join(above, MARKER), encoding="utf-8") as f:
                notes = f.read().splitlines()
        except (OSError, ValueError):
            continue
        if inside != REPORT and any(fnmatch.fnmatchcase(inside, note) for note in notes):
            return True
    return False


def refuse_overwrite(path: str, force: bool) -> None:
    """Refuses to write over a file of a run, and without `force` over any."""
    if of_a_run(path):
        raise InputError(f"{path}: is a file of a run, which nothing else may take the place of; use another -o FILE")
    if os.path.lexists(path) and not os.path.isdir(path) and not force:
        raise InputError(f"{path}: is there already; use another -o FILE, or --force")


def clear_results(out: str, names: Iterable[str]) -> None:
    """Takes away what an earlier study or calibration in this folder has left of `names`, and its plots: the one that
    follows may write fewer. Runs stay, and so does what is not Grus's."""
    plots = os.path.join(out, "plots")
    pictures = [os.path.join(plots, n) for n in os.listdir(plots) if n.endswith(".png")] if os.path.isdir(plots) else []
    for path in [os.path.join(out, n) for n in names] + pictures:
        if os.path.lexists(path):
            os.remove(path)


def note_result(folder: str, name: str) -> None:
    """Notes in a folder's marker that a file of this name is Grus's, as the C++ programs do: --force clears it. A
    folder without a marker stays as it is."""
    try:
        mark = os.open(os.path.join(folder, MARKER), os.O_RDWR | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return
    with os.fdopen(mark, "r+") as f:
        if name not in f.read().splitlines():
            f.write(name + "\n")


class InUse(Exception):
    """A results folder that is not Grus's, or that another program writes to."""


class Folder:
    """A results folder: made, marked as Grus's, and locked against a second program, as the C++ programs do."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.file: IO[str]

    def __enter__(self) -> Folder:
        mark = os.path.join(self.path, MARKER)
        if os.path.exists(self.path):
            if not os.path.isdir(self.path):
                raise InUse(f"{self.path}: is a file; name a folder with -o")
            if os.listdir(self.path) and (os.path.islink(mark) or not os.path.isfile(mark)):
                raise InUse(f"{self.path}: folder is not empty and was not made by Grus; use another -o DIR")
        try:
            os.makedirs(self.path, exist_ok=True)
            self.file = os.fdopen(
                os.open(mark, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666), "a")
        except OSError as e:
            raise InUse(f"{self.path}: cannot write: {e.strerror}") from None
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.file.close()
            raise InUse(f"{self.path}: another run is writing to this folder; use another -o DIR") from None
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()
