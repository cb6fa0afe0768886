# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the programs are, and which of them runs a scene."""
from __future__ import annotations

import os
import shutil
from typing import Any, Collection, Mapping

from grus.errors import InputError


def beside() -> str | None:
    """The folder of the programs that this package belongs to: bin/ of the build or the installation that it lies
    in."""
    folder = os.path.dirname(os.path.realpath(__file__))
    while folder != os.path.dirname(folder):
        folder = os.path.dirname(folder)
        if os.access(os.path.join(folder, "bin", "grus-rve"), os.X_OK):
            return os.path.join(folder, "bin")
    return None


def folder() -> str:
    """Where all of them are. Raises InputError."""
    return os.path.dirname(found("grus-rve"))


def found(name: str) -> str:
    """The path of a program, beside the package or in PATH. Raises InputError."""
    path = shutil.which(name, path=beside()) or shutil.which(name)
    if path is None:
        raise InputError(f"{name}: not found beside the package nor in PATH")
    return path


def program_of(scene: Mapping[str, Any]) -> str:
    """Of a scene's tables: grus-bvp where there is a mesh."""
    return "grus-bvp" if "mesh" in scene else "grus-rve"


def scene_in(arguments: list[str], valued: Collection[str]) -> str:
    """The scene among a program's arguments, "" where none is; `valued`: options that take the word after them."""
    ahead = iter(arguments)
    for word in ahead:
        if word in valued:
            next(ahead, None)
        elif not word.startswith("-"):
            return word
    return ""
