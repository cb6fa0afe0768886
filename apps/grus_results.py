# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reads the tables of a result folder."""
import contextlib
import csv
import fcntl
import io
import math
import os

from grus_version import VERSION  # noqa: F401  shown by every command

MARKER = ".grus"  # in folders that Grus has made; the lock


def one_line(text):
    """Text without line ends or other control characters: a message is one line."""
    return "".join(c if c.isprintable() else " " for c in str(text))


def plain(axis):
    """Plain numbers on a logarithmic axis of a plot: mathematics is off there, texts are the user's. Between powers of ten 2 and 5 where there is room."""
    def minor(v, _):
        low, high = sorted(axis.get_view_interval())
        return f"{v:g}" if low > 0 and high < 30 * low and f"{v:e}"[0] in "25" else ""
    axis.set_major_formatter(lambda v, _: f"{v:g}")
    axis.set_minor_formatter(minor)


def open_anew(path):
    """A file that nobody else has: what lies there under its name, a link to elsewhere included, makes room first."""
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def write_whole(path, content):
    """Text or bytes, written aside and renamed."""
    data = content.encode() if isinstance(content, str) else content
    try:
        with os.fdopen(open_anew(path + ".new"), "wb") as f:
            f.write(data)
        os.replace(path + ".new", path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(path + ".new")
        raise


def write_csv(path, rows):
    """A number that there is not is an empty field."""
    text = io.StringIO()
    lacks = lambda v: isinstance(v, float) and math.isnan(v)
    csv.writer(text, lineterminator="\n").writerows([["" if lacks(v) else v for v in row] for row in rows])
    write_whole(path, text.getvalue())


def clear_results(out, names):
    """Takes away what an earlier study or calibration in this folder has left of `names`, and its plots: the one that follows may
    write fewer. Runs stay, and so does what is not Grus's."""
    plots = os.path.join(out, "plots")
    pictures = [os.path.join(plots, n) for n in os.listdir(plots) if n.endswith(".png")] if os.path.isdir(plots) else []
    for path in [os.path.join(out, n) for n in names] + pictures:
        if os.path.lexists(path):
            os.remove(path)


def note_result(folder, name):
    """Notes in a folder's marker that a file of this name is Grus's, as the C++ programs do: --force clears it. A folder without a marker
    stays as it is."""
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

    def __init__(self, path):
        self.path, self.file = path, None

    def __enter__(self):
        mark = os.path.join(self.path, MARKER)
        if os.path.exists(self.path):
            if not os.path.isdir(self.path):
                raise InUse(f"{self.path}: is a file; name a folder with -o")
            if os.listdir(self.path) and (os.path.islink(mark) or not os.path.isfile(mark)):
                raise InUse(f"{self.path}: folder is not empty and was not made by Grus; use another -o DIR")
        try:
            os.makedirs(self.path, exist_ok=True)
            self.file = os.fdopen(os.open(mark, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666), "a")
        except OSError as e:
            raise InUse(f"{self.path}: cannot write: {e.strerror}") from None
        try:
            fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.file.close()
            raise InUse(f"{self.path}: another run is writing to this folder; use another -o DIR") from None
        return self

    def __exit__(self, *_):
        self.file.close()


def read_history(folder):
    """history.csv as columns; an empty field is NaN. Throws ValueError, one line, for what is no table of numbers."""
    path = os.path.join(folder, "history.csv")
    try:
        with open(path, newline="") as f:
            rows = list(csv.reader(f))
    except (csv.Error, UnicodeDecodeError) as e:
        raise ValueError(f"{path}: not a table: {e}") from None
    if len(rows) < 2:
        raise ValueError(f"{path}: no rows")
    columns = {name: [] for name in rows[0]}
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path}: line {number} has {len(row)} values for {len(rows[0])} columns")
        for name, value in zip(rows[0], row):
            try:
                columns[name].append(float(value) if value else math.nan)
            except ValueError:
                raise ValueError(f"{path}: line {number}: {name} is not a number") from None
    return columns


def read_grading(folder, files=None):
    """States of grading.csv, if the scene asked for it: strain -> rows by size class. `files`: what summary.json lists of the run's files,
    None where it lists none."""
    path = os.path.join(folder, "grading.csv")
    if not os.path.isfile(path) or (isinstance(files, list) and "grading.csv" not in files):
        return {}
    states = {}
    with open(path, newline="") as f:
        for row in csv.DictReader(f):
            states.setdefault(float(row["strain"]), []).append({k: float(v) for k, v in row.items()})
    return states
