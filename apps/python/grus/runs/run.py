# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of scenes by grus-rve and grus-bvp."""
from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
from typing import Iterable

from grus.asked import changes_of, path_of, whole_number
from grus.errors import InputError, Unstable
from grus.files.texts import tables_of
from grus.results import Path, Results
from grus.runs import interrupts
from grus.runs.programs import found, program_of
from grus.runs.scene import Scene


def _stop(process: subprocess.Popen, by_mpirun: bool) -> None:
    """Asks a run to stop. mpirun would kill its ranks a second after it has asked them, too soon for a checkpoint: they
    are asked themselves."""
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


def run(scene: Path | Scene, set: Iterable[str] = (), *, out: Path | None = None, threads: int | None = None,
        ranks: int = 1, check: bool = True, force: bool = False) -> Results:
    """Runs a scene by grus-rve, or by grus-bvp where it has a [mesh], and returns its results.

    Args:
        scene: a file, or what `grus.read_scene` made of one
        set: "KEY=VALUE" changes of the scene
        out: results folder, which stays; default: a temporary one, of which only what is returned remains
        threads: default: all cores
        ranks: of grus-bvp, by mpirun
        check: raise Unstable where the run ends unstable; else its results are returned, with status 3
        force: overwrite the results in `out`

    Raises:
        InputError: for a scene that cannot run
        Unstable: where grains go through each other or do not come to rest
        KeyboardInterrupt: after the run has written its checkpoint
        RuntimeError: for all else that stops it
    """
    more = list(scene.changes) if isinstance(scene, Scene) else []
    scene, set = path_of("scene", scene.file if isinstance(scene, Scene) else scene), more + changes_of(set)
    threads = None if threads is None else whole_number("threads", threads, 1)
    ranks = whole_number("ranks", ranks, 1)
    if ranks > 1 and shutil.which("mpirun") is None:
        raise InputError(f"ranks = {ranks}: there is no mpirun here")
    name = "grus-rve"  # of a scene that cannot be read it says where it is wrong
    if os.path.isfile(scene):
        with contextlib.suppress(InputError):
            name = program_of(tables_of(scene))
    if out is None:
        with tempfile.TemporaryDirectory(prefix="grus-") as tmp:
            return run(scene, set, out=os.path.join(tmp, "run"), threads=threads, ranks=ranks, check=check)
    out = path_of("out", out)
    command = [found(name), scene, "-o", out, "--quiet"]
    command += [] if threads is None else ["--threads", str(threads)]
    command += ["--force"] if force else []
    command += [text for change in set for text in ("--set", change)]
    if ranks > 1:
        command = ["mpirun", "-n", str(ranks)] + command
    process = None
    try:
        with interrupts.held():
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                       start_new_session=True)
        _, errors = process.communicate()
    except KeyboardInterrupt:
        if process is not None:
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
