# SPDX-License-Identifier: LGPL-3.0-or-later
"""Writes results as other programs read them. The ending of FILE says how: of history.csv or of grains, one row each,
.csv, .json, .npz (NumPy) or .mat (MATLAB, Octave); of grains .txt (x y z r); of frames .vtu (ParaView, pyvista,
meshio), .stl (mm) or .obj (m)."""
import argparse
import os
import sys

from grus._version import __version__
from grus.commands.words import FRAMES as KINDS
from grus.errors import InputError
from grus.export.formats import FRAMES, TABLES
from grus.files.folders import refuse_overwrite
from grus.files.texts import one_line
from grus.files.writing import write_whole
from grus.frames import frame
from grus.results import read_history
from grus.runs import interrupts
from grus.runs.places import hint


def history(folder, asked):
    """Columns of history.csv, all or those that are asked for, in that order."""
    import numpy as np
    columns = {name: np.array(values) for name, values in read_history(folder).items()}
    for name in asked:
        if name not in columns:
            raise InputError(f"--columns: history.csv has no column '{name}'{hint(name, columns)}")
    return {name: columns[name] for name in asked or columns}


def names_of(columns):
    """Names with commas between them; all where none are asked for."""
    names = [n.strip() for n in (columns or "").split(",") if n.strip()]
    if columns is not None and not names:
        raise InputError("--columns: names no column; leave it out for all")
    return names


def refuse_ignored(args):
    """What is said of one kind, and something else is written."""
    if args.what == "history" and args.frame is not None:
        raise InputError("--frame: a history has no frames; name what is of one with --what, or leave --frame out")
    if args.what != "history" and args.columns is not None:
        raise InputError(f"--columns: is of the history, not of {args.what}; leave it out")


def content(args, ending):
    """Bytes of the file, and a word of what is not in it where there is one."""
    if args.what == "history":
        if ending not in TABLES:
            raise InputError(f"{args.o}: a history is written as {' '.join(TABLES)}; name frames with --what grains")
        return TABLES[ending](history(args.folder, names_of(args.columns))), ""
    found = frame(args.folder, args.what, -1 if args.frame is None else args.frame)
    if ending == ".txt" and args.what != "grains":
        raise InputError(f"{args.o}: {args.what} are written as .vtu; .txt is of grains")
    if ending in FRAMES:
        if ending in (".stl", ".obj") and not len(found.triangles()[1]):
            raise InputError(f"{args.folder}: {args.what} have no surface for an {ending}: write a .vtu")
        boxless = ending == ".txt" and found.box() is None
        return FRAMES[ending](found), ("\n  note: the frame has no upright box, so there is no line #box; a scene that "
                                       "reads the spheres needs a packing.box of its own" if boxless else "")
    if args.what != "grains":
        raise InputError(f"{args.o}: {args.what} are written as .vtu; tables are of history and grains")
    return TABLES[ending](found.grains()), ""


def main():
    parser = argparse.ArgumentParser(prog="grus export", description=__doc__)
    parser.add_argument("folder", metavar="DIR", help="results folder of grus-rve or grus-bvp")
    parser.add_argument("-o", metavar="FILE", required=True, help="what is written; its ending says how")
    parser.add_argument("--what", choices=KINDS,
                        help="default: history, or grains where FILE ends with .txt, .vtu, .stl or .obj")
    parser.add_argument("--frame", type=int, metavar="N",
                        help="of frames: 0 the first, -1 the last (default)")
    parser.add_argument("--columns", metavar="NAMES", help="of the history: names with commas between them")
    parser.add_argument("--force", action="store_true", help="write over FILE, unless a run has written it")
    parser.add_argument("--version", action="version", version=f"grus {__version__}")
    args = parser.parse_args()
    interrupts.raise_again()
    ending = os.path.splitext(args.o)[1].lower()
    args.what = args.what or ("history" if ending in TABLES else "grains")
    try:
        refuse_ignored(args)
        refuse_overwrite(args.o, args.force)
        if ending not in (known := TABLES | FRAMES):
            raise InputError(f"{args.o}: ends with none of {' '.join(known)}")
        data, note = content(args, ending)
        write_whole(args.o, data)
        which = "the last frame" if args.frame in (None, -1) else f"frame {args.frame}"
        print(f"{args.o}: " + ("history" if args.what == "history" else f"{args.what} of {which}") + note)
    except (InputError, ValueError) as e:
        print(one_line(f"grus export: {e}"), file=sys.stderr)
        return 2
    except OSError as e:
        print(one_line(f"grus export: {e.filename or args.o}: {e.strerror}"), file=sys.stderr)
        return 2
    return 0
