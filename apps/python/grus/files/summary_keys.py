# SPDX-License-Identifier: LGPL-3.0-or-later
"""Keys of summary.json: the table summary_keys.txt (program, dotted key, unit, meaning; `scene.*` is all below it)."""
import functools
import os
from typing import NamedTuple


class Row(NamedTuple):
    """A row of the table; `program`: rve, bvp or both."""
    program: str
    path: str
    unit: str
    meaning: str


@functools.cache
def table() -> list[Row]:
    """All rows."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "summary_keys.txt"), encoding="utf-8") as f:
        return [Row(*(part.strip() for part in line.split("|"))) for line in f]


def keys_of(program: str) -> list[str]:
    """The keys that grus-rve ("rve") or grus-bvp ("bvp") writes, where there is something to tell."""
    return [row.path for row in table() if row.program in (program, "both")]


def known(key: str, program: str) -> bool:
    """The program may write such a key."""
    return any(key == path or (path.endswith("*") and key.startswith(path[:-1])) for path in keys_of(program))
