# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes as Python sees them: the tables of a file, with changes by keyword."""
from __future__ import annotations

import os
import subprocess
import tomllib
from typing import Any, Iterator, Mapping

from grus.asked import Lacking, Named, path_of, value_text
from grus.errors import InputError
from grus.files.texts import tables_of
from grus.results import Path
from grus.runs.programs import found, program_of


def put(table: Any, key: str, text: str) -> None:
    """A change KEY=VALUE of a scene's tables, as --set takes it; an empty VALUE takes the key away."""
    *path, last = key.split(".")
    for part in path:
        if isinstance(table, list):
            table = table[int(part)] if part.isdecimal() and int(part) < len(table) else None
        else:
            table = table.setdefault(part, {}) if isinstance(table, dict) else None
    if not isinstance(table, dict):
        return
    if not text:
        table.pop(last, None)
        return
    try:
        table[last] = tomllib.loads(f"v = {text}")["v"]
    except ValueError:
        table[last] = text


def value_of(name: str, value: Any) -> str:
    """A value as --set takes it: lists too, which may hold each other; None takes the key away."""
    if value is None:
        return ""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(value_of(name, v) for v in value)}]"
    return value_text(name, value)


class Scene(Mapping[str, Any]):
    """A scene file with changes: `scene["packing"]["seed"]` is what a run would read. A scene does not change:
    `scene.with_(...)` is another.

    Attributes:
        file: where it was read
        changes: "KEY=VALUE" texts, as --set and `grus.run(set=...)` take them
        tables: all of its tables, with the changes
        program: grus-rve, or grus-bvp where it has a [mesh]
    """

    def __init__(self, file: str, changes: tuple[str, ...]) -> None:
        self.file, self.changes = file, changes
        tables = tables_of(file, "scene file")
        for change in changes:
            put(tables, *change.partition("=")[::2])
        self.tables, self.program = _named(file, tables), program_of(tables)

    def __getitem__(self, table: str) -> Any:
        if table not in self.tables:
            raise Lacking(self.file, table, self.tables)
        return self.tables[table]

    def __iter__(self) -> Iterator[str]:
        return iter(self.tables)

    def __len__(self) -> int:
        return len(self.tables)

    def __repr__(self) -> str:
        changed = f" with {', '.join(self.changes)}" if self.changes else ""
        return f"<grus.Scene of {self.file}{changed}>"

    def __reduce__(self) -> Any:
        return Scene, (self.file, self.changes)

    def with_(self, changes: Mapping[str, Any] | None = None, /, **keywords: Any) -> Scene:
        """The same scene with more changes; `_` twice stands for the point of a key."""
        asked = {**(changes or {}), **{name.replace("__", "."): v for name, v in keywords.items()}}
        return Scene(self.file, self.changes + tuple(f"{key}={value_of(key, v)}" for key, v in asked.items()))

    def columns(self) -> list[str]:
        """Names of the columns that its history.csv will have.

        Raises:
            InputError: with file, line and key, where it cannot run
        """
        sets = [word for change in self.changes for word in ("--set", change)]
        told = subprocess.run([found(self.program), self.file, *sets, "--columns"], capture_output=True, text=True)
        if told.returncode == 2:
            raise InputError(told.stderr.strip())
        if told.returncode != 0:
            raise RuntimeError(told.stderr.strip())
        return told.stdout.split()


def _named(what: str, value: Any) -> Any:
    if isinstance(value, dict):
        return Named(what, {key: _named(f"{what}: {key}", v) for key, v in value.items()})
    return [_named(what, v) for v in value] if isinstance(value, list) else value


def read_scene(scene: Path, changes: Mapping[str, Any] | None = None, /, **keywords: Any) -> Scene:
    """A scene file, with changes by keyword; `_` twice stands for the point of a key:

        scene = grus.read_scene("oedometer.toml", packing__seed=7, material__sand__friction=0.4)
        run = grus.run(scene, out="results")

    Values are numbers (SI), texts ("60 GPa"), lists and dicts; None takes a key away.

    Args:
        scene: the file
        changes: the same by whole keys: {"packing.seed": 7}
        **keywords: keys with `_` twice for their points

    Raises:
        InputError: for a file that cannot be read; what a run would refuse, `grus.run` and `scene.columns()` refuse
    """
    return Scene(os.path.normpath(path_of("scene", scene)), ()).with_(changes, **keywords)
