# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs cases of a study or a calibration, each on one core, and keeps what is done: a run is repeated only where its scene, its
settings or the program have changed."""
import hashlib
import json
import math
import os
import re
import signal
import subprocess
import sys
import time

import grus_interrupts
from grus_censored import number_of, strength_of
from grus_results import InUse, one_line, read_grading, read_history, write_whole
from grus_study_reader import Refused, toml_value
from grus_tables import toml_of

# Of share/grus/tools, where this lies, the folder of the programs.
PROGRAMS = os.path.normpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "..", "bin"))


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
    """Every file that a run of the scene may read: the scene, and what a text in it or in the settings names beside it: meshes,
    packings, hulls, tables, and scenes of unit cells with the files that these name."""
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


class Lacking(Exception):
    """Something that is asked for and that no run has."""


class Runner:
    """Runs cases; `asked` tells what columns and keys each must have (grus_study_reader.wanted)."""

    def __init__(self, out, seed_key, bins, asked):
        self.out, self.seed_key, self.bins, self.asked = out, seed_key, bins, asked
        self.running, self.stopped, self.refused = set(), False, {}
        grus_interrupts.hand_on(self.running)

    def command(self, case, seed=None):
        settings = dict(case["set"])
        if seed is not None:
            before = settings.get(self.seed_key)
            settings[self.seed_key] = before + seed if isinstance(before, list) and isinstance(seed, list) else seed  # changes of a unit cell: both
        return [os.path.join(self.bins, case["program"]), case["scene"]] + [a for k, v in settings.items() for a in ("--set", f"{k}={toml_value(v)}")]

    def refusal(self, case):
        """Why the program would refuse a case, or what it does not write that is asked of it; None: nothing is wrong."""
        for seed in case["seeds"]:
            if self.stopped:
                return None
            try:
                process = subprocess.Popen(self.command(case, seed) + ["--columns"], stdout=subprocess.PIPE,
                                           stderr=subprocess.PIPE, text=True, start_new_session=True)
            except (OSError, ValueError) as e:  # no such program here, or a text that no command can hold
                return f"{case['label']}: {e}"
            self.running.add(process)
            columns, errors = process.communicate()
            self.running.discard(process)
            if process.returncode != 0:
                return f"{case['label']}: {errors.strip()}"
            if self.stopped:
                return None
        missing = sorted(self.asked[case["name"]][0] - set(columns.split()))
        return f"{case['label']}: history.csv will have no column '{missing[0]}'" if missing else None

    def lacking(self, case, folder):
        """A key of summary.json that is asked of a case and is not there; a run that was stopped may have none."""
        run = read_run(folder)
        if run["summary"].get("status") != 0:
            return None
        for key in sorted(self.asked[case["name"]][1]):
            if math.isnan(number_of(run, key)) and math.isnan(strength_of(run, key)[1]):
                return f"summary.json has no number '{key}'"
        return None

    def folder(self, case, seed):
        if seed is None:
            return os.path.join(self.out, "runs", case["name"])
        text = toml_value(seed)
        plain = re.sub(r"[^\w.-]+", "_", text).strip("_")
        if plain != text:  # another seed may look alike
            plain += "-" + hashlib.sha256(text.encode()).hexdigest()[:6]
        return os.path.join(self.out, "runs", f"{case['name']}@{plain}")  # no case has @ in its name

    def run(self, case, seed):
        folder = self.folder(case, seed)
        for place in (os.path.dirname(folder), folder):
            if os.path.islink(place):  # what it leads to is not the study's
                return case, seed, f"{place}: is a link, which leads out of the folder; remove it, or use another -o DIR"
        program = os.path.join(self.bins, case["program"])
        key, marker = key_of(case, seed, self.seed_key, program), os.path.join(folder, "study.key")
        if text_of(marker) == f"{key} {digest_of(folder)}":
            return case, seed, None
        if self.stopped:
            return case, seed, "not started"
        if os.path.isfile(marker):  # of other settings, or damaged: must not vouch for what is about to be overwritten
            os.remove(marker)
        begun = os.path.join(folder, "study.begun")
        goes_on = text_of(begun) == key and os.path.isfile(os.path.join(folder, "checkpoint.h5"))
        command = self.command(case, seed) + ["-o", folder, "--quiet", "--threads", "1"]
        process, errors = self.start(command + ["--resume" if goes_on else "--force"], begun, key)
        if goes_on and process.returncode == 2 and not self.stopped:  # a checkpoint that cannot be used
            process, errors = self.start(command + ["--force"], begun, key)
        if process.returncode == 2:
            self.refused[case["name"], str(seed)] = one_line(errors.strip())
        if process.returncode in (0, 3):  # unstable is a result: the table says so
            write_whole(marker, f"{key} {digest_of(folder)}")
            os.remove(begun)
            return case, seed, None
        return case, seed, errors.strip() or f"ended with status {process.returncode}"

    def start(self, command, begun, key):
        """Runs a command; its folder tells by `begun` whose checkpoint it holds."""
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        process.begun = time.monotonic()
        self.running.add(process)
        _, errors = process.communicate()
        self.running.discard(process)
        if os.path.isdir(os.path.dirname(begun)):
            write_whole(begun, key)
        return process, errors

    def stop(self):
        self.stopped = True
        for process in list(self.running):
            process.send_signal(signal.SIGTERM)  # SIGINT is ignored by what was started in the background of a script


def duration_text(s):
    return f"{s:.0f} s" if s < 120 else f"{s / 60:.0f} min" if s < 7200 else f"{s / 3600:.1f} h"


def read_run(folder):
    with open(os.path.join(folder, "summary.json")) as f:
        summary = json.load(f)
    return {"columns": read_history(folder), "summary": summary, "grading": read_grading(folder)}


def status_of(program, args, work, interrupted):
    """Exit status of a command; what went wrong is told in one line, the whole story to who asks."""
    try:
        grus_interrupts.raise_again()
        if args.log:
            try:
                grus_interrupts.log_to(args.log)
            except FileExistsError as e:
                raise Refused(f"--log: {args.log}: {e.strerror}") from None
            except OSError as e:
                raise Refused(f"--log: {args.log}: cannot write: {e.strerror}") from None
        if args.max_time:
            grus_interrupts.end_after(args.max_time)
        return work(args)
    except (Refused, InUse) as e:
        print(one_line(f"{program}: {e}"), file=sys.stderr)
        return 2
    except Lacking as e:
        print(one_line(f"{program}: {args.scene}: {e}"), file=sys.stderr)
        return 1
    except grus_interrupts.OutOfTime:
        print(f"{program}: out of time: finished runs are kept; the same command goes on", file=sys.stderr)
        return 75
    except KeyboardInterrupt:
        print(f"{program}: {interrupted}", file=sys.stderr)
        return 130
    except Exception as e:
        if os.environ.get("GRUS_DEBUG"):
            raise
        print(one_line(f"{program}: {args.scene}: {type(e).__name__}: {e} (GRUS_DEBUG=1 shows where)"), file=sys.stderr)
        return 1


def end(status):
    signal.setitimer(signal.ITIMER_REAL, 0)
    grus_interrupts.hear(grus_interrupts.STOPS, signal.SIG_IGN)  # nothing is left to interrupt; Python's own end would die of it
    sys.exit(status)
