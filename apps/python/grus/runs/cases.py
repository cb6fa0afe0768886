# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that are run: a scene, changes of it, and the program that runs it."""
import json
import os

from grus.files.texts import toml_of
from grus.runs.programs import program_of


class Refused(Exception):
    """What cannot be run; its text is one line."""


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
    try:
        table = toml_of(path)
    except OSError as e:
        raise Refused(f"{path}: {e.strerror}") from None
    except (ValueError, RecursionError) as e:
        raise Refused(f"{path}: {e}") from None
    fault = fault_of(table)
    if fault:
        raise Refused(f"{path}: {fault}")
    return table


def scene_of(where, scene, folder):
    """The scene's file and the program: grus-bvp for scenes with a mesh."""
    if not scene:
        raise Refused(f"{where}: needs a scene, its own or that of [study]")
    scene = os.path.normpath(os.path.join(folder, scene))
    if not os.path.isfile(scene):
        raise Refused(f"{where}: no such scene file {scene}")
    try:
        table = toml_of(scene)
    except (ValueError, RecursionError) as e:
        raise Refused(f"{where}: {scene}: {e}") from None
    return {"scene": scene, "program": program_of(table)}
