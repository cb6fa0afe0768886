# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files written whole: aside, and renamed."""
from __future__ import annotations

import contextlib
import csv
import io
import math
import os


def open_anew(path: str) -> int:
    """A file that nobody else has: what lies there under its name, a link to elsewhere included, makes room first."""
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)


def write_whole(path: str, content: str | bytes) -> None:
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


def write_csv(path: str, rows: list[list]) -> None:
    """A number that there is not is an empty field."""
    text = io.StringIO()
    lacks = lambda v: isinstance(v, float) and math.isnan(v)
    csv.writer(text, lineterminator="\n").writerows([["" if lacks(v) else v for v in row] for row in rows])
    write_whole(path, text.getvalue())
