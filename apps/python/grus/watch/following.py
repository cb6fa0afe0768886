# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the page is told of results folders: runs, studies and calibrations, as they stand now."""
import json
import os
import time

from grus import curves
from grus.watch.growing import Growing
from grus.watch.processes import writer
from grus.watch.progress import done_of, left_of, scene_of

ENDINGS = {0: "finished", 3: "unstable", 75: "out of time", 130: "interrupted"}
DRAWN = 40  # runs of a study, the latest


class Run:
    """One results folder of grus-rve or grus-bvp."""

    def __init__(self, folder, name):
        self.folder, self.name = folder, name
        self.history, self.scene, self.process = Growing(os.path.join(folder, "history.csv")), None, None
        self.begun = None  # (seconds that it ran, part that was done) when it was first seen
        self.ended = None  # summary.json, once nobody writes

    def look(self):
        before, self.process = self.process, writer(self.folder)
        if self.process is None:
            if before is not None or self.ended is None:
                self.ended, self.scene = told_of(self.folder)
        elif before is None or before.number != self.process.number:
            self.scene, self.begun, self.ended = scene_of(self.process), None, None
        self.history.look()

    def state(self):
        if self.process:
            return "running" if len(self.history) else "preparing"
        if self.ended is None:
            return "waiting" if not len(self.history) else "stopped"
        return ENDINGS.get(self.ended, f"ended with {self.ended}")

    def told(self):
        c, running = self.history.columns, self.process is not None
        done = done_of(self.scene, c) if running else None
        since = self.process.since if running else None
        left = None
        if running and done is not None:
            if self.begun is None:
                self.begun = (since, done)
            left = left_of(done, since)
            if since - self.begun[0] > 5 and done > self.begun[1]:  # the pace that was seen, of a run that went on
                left = (since - self.begun[0]) * (1 - done) / (done - self.begun[1])
        last = {k: c[k][-1] for k in ("grains", "breakages", "bonds_broken", "energy_error", "increment") if c.get(k)}
        return {"name": self.name, "state": self.state(), "done": done, "since": since, "left": left, "rows":
                len(self.history), "last": {k: v for k, v in last.items() if v == v}}


def told_of(folder):
    """(exit status, scene) as summary.json tells them; None and {} where there is none."""
    try:
        with open(os.path.join(folder, "summary.json")) as f:
            summary = json.load(f)
        return summary.get("status"), summary.get("scene", {})
    except (OSError, ValueError, AttributeError):
        return None, {}


class Following:
    """The folders that are asked for, and the runs of those that are of studies."""

    def __init__(self, folders):
        self.folders, self.runs, self.planned = folders, {}, {}
        self.seen = set()  # folders that somebody has written into while they were followed

    def names(self):
        """(folder, name) of every run there is now."""
        found = []
        for folder in self.folders:
            inner = os.path.join(folder, "runs")
            if os.path.isdir(inner):
                found += [(os.path.join(inner, n), n) for n in sorted(os.listdir(inner))
                          if os.path.isdir(os.path.join(inner, n))]
            else:
                found.append((folder, os.path.basename(os.path.abspath(folder))))
        return found

    def look(self):
        names = self.names()
        self.runs = {f: self.runs.get(f) or Run(f, name) for f, name in names}
        for run in self.runs.values():
            if run.process is not None or run.ended is None or not len(run.history):
                run.look()
        writers = {folder: writer(folder) for folder in self.folders}
        self.seen |= {folder for folder, process in writers.items() if process}
        for folder, process in writers.items():
            if process and folder not in self.planned and os.path.isdir(os.path.join(folder, "runs")):
                self.planned[folder] = planned(process)
        self.writers = writers

    def over(self):
        """Whether all that ran has ended."""
        return bool(self.seen) and self.seen == set(self.folders) and not any(self.writers.values())

    def told(self):
        """Plain data for the page."""
        runs = list(self.runs.values())
        studies = []
        for folder in self.folders:
            inner = os.path.join(folder, "runs") + os.sep
            mine = [r for r in runs if r.folder.startswith(inner)]
            if mine:
                done, process = sum(finished(r.folder) for r in mine), self.writers.get(folder)
                of = self.planned.get(folder) or 0
                part = done / of if of else None
                studies.append({"name": os.path.basename(os.path.abspath(folder)), "done": done, "of": of,
                                "running": process is not None,
                                "left": left_of(part, process.since) if part and process else None})
        latest = sorted(runs, key=lambda r: (r.process is not None, len(r.history)))[-DRAWN:]
        shown = [r for r in runs if r in latest]
        plots = curves.of_loads([(r.name, r.history.columns, r.scene or {}) for r in shown])
        if len(runs) == 1:
            plots += curves.of_run(runs[0].history.columns)
        return {"title": ", ".join(self.folders), "over": self.over(), "at": time.time(), "studies": studies,
                "runs": [r.told() for r in runs], "plots": plots}


def finished(folder):
    """Of a run of a study: whether it is kept as done."""
    return os.path.exists(os.path.join(folder, "study.key"))


def planned(process):
    """How many runs a study or a calibration will make; 0 where its file does not tell."""
    from grus.commands.words import VALUED
    from grus.runs.programs import scene_in
    at = next((k for k, word in enumerate(process.words) if os.path.basename(word).startswith("grus")), 0)
    words = [w for w in process.words[at + 1:] if w not in ("study", "calibrate")]
    path = os.path.join(process.folder, scene_in(words, VALUED))
    try:
        if "calibrate" in " ".join(process.words[:at + 2]):
            from grus.calibrate.reader import read_calibration
            _, table, _, _, runs = read_calibration(path)
            points = max(1, table.get("budget", 90) // max(len(r["seeds"]) for r in runs))
            return points * sum(len(r["seeds"]) for r in runs)
        from grus.study.reader import read_study
        return len({(c["name"], str(s)) for c in read_study(path).cases() for s in c["seeds"]})
    except Exception:  # a page of progress stops for nothing that a study says of itself
        return 0
