# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether a run that is there is the one that is asked for: digests of what it read and of what it wrote."""
import hashlib
import json
import os

from grus.files.texts import toml_of


def texts_in(value):
    """All texts that a scene or its settings hold."""
    if isinstance(value, str):
        yield value
        yield value.partition("=")[2].strip(" \"'")  # a change of a unit cell: key=value
    elif isinstance(value, dict):
        for v in value.values():
            yield from texts_in(v)
    elif isinstance(value, list):
        for v in value:
            yield from texts_in(v)


def files_read(scene, settings):
    """Every file that a run of the scene may read: the scene, and what a text in it or in the settings names beside it:
    meshes, packings, hulls, tables, and scenes of unit cells with the files that these name."""
    found, ahead = [], [(os.path.abspath(scene), settings)]
    while ahead:
        path, more = ahead.pop()
        if path in found:
            continue
        found.append(path)
        if not path.endswith(".toml"):
            continue
        try:
            table = toml_of(path)
        except (OSError, ValueError, RecursionError):  # the program will say so
            continue
        for text in [*texts_in(table), *texts_in(more)]:
            named = os.path.normpath(os.path.join(os.path.dirname(path), text))
            if 0 < len(text) < 1000 and "\0" not in text and os.path.isfile(named):
                ahead.append((named, more))
    return sorted(found)


def key_of(case, seed, seed_key, program):
    """Changes when the settings, the program or any file that the run reads change: then the run is done again."""
    digest = hashlib.sha256(json.dumps([case["set"], seed, seed_key], sort_keys=True).encode())
    for path in [program, *files_read(case["scene"], case["set"])]:
        with open(path, "rb") as f:
            digest.update(hashlib.file_digest(f, "sha256").digest())
    return digest.hexdigest()


def digest_of(folder):
    """Of what a study reads of a run: what has been damaged since the run ended is not the same."""
    digest = hashlib.sha256()
    for name in ("summary.json", "history.csv", "grading.csv"):
        try:
            with open(os.path.join(folder, name), "rb") as f:
                digest.update(hashlib.file_digest(f, "sha256").digest())
        except OSError:
            digest.update(b"none")
    return digest.hexdigest()


def text_of(path):
    """None where there is no such file; whatever bytes it holds are a text."""
    try:
        with open(path, encoding="utf-8", errors="replace") as f:
            return f.read()
    except OSError:
        return None
