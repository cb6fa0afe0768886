# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that are run: a scene, changes of it, and the program that runs it."""
import json
import os

from grus.errors import InputError
from grus.files.texts import tables_of
from grus.runs.programs import program_of


def toml_value(v):
    """A value as --set takes it."""
    if isinstance(v, bool):
        return "true" if v else "false"
    if isinstance(v, str):
        return json.dumps(v) if v else ""
    if isinstance(v, dict):
        return "{" + ", ".join(f"{k} = {toml_value(x)}" for k, x in v.items()) + "}"
    if isinstance(v, list):
        return "[" + ", ".join(map(toml_value, v)) + "]"
    return repr(v)


def read_checked(path, fault_of):
    """A TOML file in which `fault_of` finds no fault."""
    table = tables_of(path)
    fault = fault_of(table)
    if fault:
        raise InputError(f"{path}: {fault}")
    return table


def scene_of(where, scene, folder):
    """The scene's file and the program: grus-bvp for scenes with a mesh."""
    if not scene:
        raise InputError(f"{where}: needs a scene, its own or that of [study]")
    scene = os.path.normpath(os.path.join(folder, scene))
    try:
        return {"scene": scene, "program": program_of(tables_of(scene, "scene file"))}
    except InputError as e:
        raise InputError(f"{where}: {e}") from None
