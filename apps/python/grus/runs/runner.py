# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs cases of a study or a calibration, each on one core, and keeps what is done: a run is repeated only where its
scene, its settings or the program have changed."""
import hashlib
import math
import os
import re
import signal
import subprocess
import time
from typing import NamedTuple

from grus.files.summary_keys import keys_of, known
from grus.files.texts import one_line
from grus.files.writing import write_whole
from grus.results import read_run
from grus.runs import interrupts
from grus.runs.cases import toml_value
from grus.runs.censored import number_of, strength_of
from grus.runs.kept import digest_of, key_of, text_of
from grus.runs.places import hint, place_of


class Refusal(NamedTuple):
    """Why a case cannot run; the name that is not there, if that is why."""
    text: str
    name: str | None = None

    def told(self, path):
        """In one line that names the file, and where it asks for that name."""
        return f"{place_of(path, self.name) if self.name else path}: {self.text}"


class Runner:
    """Runs cases; `asked` tells what columns and keys each must have (Study.wanted of grus.study.reader)."""

    def __init__(self, out, seed_key, bins, asked):
        self.out, self.seed_key, self.bins, self.asked = out, seed_key, bins, asked
        self.running, self.stopped, self.refused = set(), False, {}
        interrupts.hand_on(self.running)

    def command(self, case, seed=None):
        settings = dict(case["set"])
        if seed is not None:
            before = settings.get(self.seed_key)
            settings[self.seed_key] = before + seed if isinstance(before, list) and isinstance(
                seed, list) else seed  # changes of a unit cell: both
        return [os.path.join(self.bins, case["program"]), case["scene"]
                ] + [a for k, v in settings.items() for a in ("--set", f"{k}={toml_value(v)}")]

    def ask(self, case, seed, *options, within=None):
        """(exit status, output, errors) of a command that runs nothing; status -1: not started, or not done within so
        many seconds."""
        if self.stopped:
            return -1, "", ""
        try:
            process = subprocess.Popen(self.command(case, seed) + list(options), stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True, start_new_session=True)
        except (OSError, ValueError) as e:  # no such program here, or a text that no command can hold
            return -1, "", str(e)
        self.watch(process)
        try:
            said, errors = process.communicate(timeout=within)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return -1, "", "out of time"
        finally:
            self.running.discard(process)
        return process.returncode, said, errors

    def refusal(self, case):
        """Why the program would refuse a case, or what it does not write that is asked of it (Refusal); None: nothing
        is wrong."""
        columns = ""
        for seed in case["seeds"]:
            status, columns, errors = self.ask(case, seed, "--columns")
            if self.stopped:
                return None
            if status != 0:
                return Refusal(f"{case['label']}: {errors.strip()}")
        asked_columns, asked_keys = self.asked[case["name"]]
        for name in sorted(asked_columns - set(columns.split())):
            near = hint(name, columns.split())
            return Refusal(f"{case['label']}: history.csv will have no column '{name}'{near}", name)
        program = case["program"].removeprefix("grus-")
        for key in sorted(key for key in asked_keys if not known(key, program)):
            near = hint(key, keys_of(program))
            return Refusal(f"{case['label']}: summary.json will have no key '{key}'{near}", key)
        return None

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
                return case, seed, (f"{place}: is a link, which leads out of the folder; remove it, or use another -o "
                                    "DIR")
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
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   start_new_session=True)
        process.begun = time.monotonic()
        self.watch(process)
        _, errors = process.communicate()
        self.running.discard(process)
        if os.path.isdir(os.path.dirname(begun)):
            write_whole(begun, key)
        return process, errors

    def watch(self, process):
        self.running.add(process)
        if self.stopped:  # since it was asked for, before `stop` could know of it
            process.send_signal(signal.SIGTERM)

    def stop(self):
        self.stopped = True
        for process in list(self.running):
            process.send_signal(signal.SIGTERM)  # SIGINT is ignored by what was started in the background of a script
