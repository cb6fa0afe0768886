# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits scene keys to measured data: curves, sieve gradings, strengths of single grains. Tells each value with its
standard deviation, and which the data do not fix. Runs that are done are not repeated: the same command goes on."""
import argparse
import json
import math
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed

import numpy as np

from grus._version import __version__
from grus.calibrate import posterior, regression
from grus.calibrate.pounders import pounders
from grus.calibrate.reader import case_at, read_calibration
from grus.errors import InputError
from grus.files.folders import Folder, clear_results
from grus.files.texts import toml_of
from grus.files.writing import write_csv, write_whole
from grus.results import read_run
from grus.runs import interrupts, programs, times
from grus.runs.cases import toml_value
from grus.runs.command import Lacking, duration_text, status_of
from grus.runs.runner import Runner


class Evaluation:
    """Runs all scenes at parameter points and makes answers of them."""

    def __init__(self, runner, runs, parameters, targets, workers, budget, quiet):
        self.runner, self.runs, self.parameters, self.targets = runner, runs, parameters, targets
        self.workers, self.budget, self.quiet = workers, budget, quiet
        self.start, self.points, self.rows = time.time(), 0, []

    def __call__(self, points):
        cases = [[case_at(run, self.parameters, x) for run in self.runs] for x in points]
        jobs = [(c, s) for row in cases for c in row for s in c["seeds"]]
        with ThreadPoolExecutor(self.workers) as pool:
            futures = [pool.submit(self.runner.run, c, s) for c, s in jobs]
            try:
                for done, future in enumerate(as_completed(futures), 1):
                    case, seed, failure = future.result()
                    if failure and (case["name"], str(seed)) not in self.runner.refused:
                        self.runner.stop()
                        raise Lacking(f"{case['label']}{'' if seed is None else f', seed {seed}'}: {failure}")
                    self.show(len(points) * done / len(jobs))
            except KeyboardInterrupt:
                self.runner.stop()
                raise
        self.points += len(points)
        answers = [self.answer(x, row) for x, row in zip(points, cases)]
        if all(r["refused"] for r in self.rows):
            raise Lacking(f"the scene is refused wherever it was tried: {next(iter(self.runner.refused.values()))}")
        return answers

    def show(self, part):
        if self.quiet or not sys.stderr.isatty():
            return
        done = self.points + part
        left = (time.time() - self.start) / done * (self.budget - done)
        print(f"\r{done:.1f} of {self.budget} points  ETA {duration_text(max(0.0, left))}   ", end="", file=sys.stderr,
              flush=True)

    def answer(self, x, cases):
        if any((c["name"], str(s)) in self.runner.refused for c in cases for s in c["seeds"]):
            values = np.full(sum(len(t.values) for t in self.targets), math.nan)
            self.rows.append({"x": list(x), "values": values, "failed": True, "refused": True, "told": []})
            seeds = np.concatenate(
                [np.full(len(t.values), float(len(c["seeds"]))) for t in self.targets for c in cases[:1]])
            return regression.Answer(values, np.zeros((len(values), len(values))), seeds, True)
        found = {c["name"].split("_")[0]: [read_run(self.runner.folder(c, s)) for s in c["seeds"]] for c in cases}
        failed = any(r["summary"].get("status") != 0 for runs in found.values() for r in runs)
        parts = [t.answer(found[t.run]) for t in self.targets]
        values = np.concatenate([p[0] for p in parts])
        between, at = np.zeros((len(values), len(values))), 0
        for part, covariance, _ in parts:
            between[at:at + len(part), at:at + len(part)] = covariance
            at += len(part)
        self.rows.append({
            "x": list(x), "values": values, "failed": failed, "refused": False,
            "told": [dict(t.told) for t in self.targets]
        })
        return regression.Answer(values, between, np.concatenate([np.full(len(v), float(n)) for v, _, n in parts]),
                                 failed)


def data_of(targets):
    join = lambda k: np.concatenate([getattr(t, k) for t in targets])
    return regression.Data(join("values"), join("error"), join("weight"), join("specimens"))


def record(result, table, parameters, targets, evaluation, checked):
    sd = np.sqrt(np.diag(result.covariance))
    correlation = result.covariance / np.outer(sd, sd)
    at, of_targets = 0, []
    for t in targets:
        part = result.misfit[at:at + len(t.values)]
        told = [r["told"][len(of_targets)] for r in evaluation.rows if r["told"]]
        of_targets.append({
            "name": t.name, "kind": t.kind, "points": len(t.values),
            "rms_in_standard_deviations": float(np.sqrt(np.mean(part**2))),
            **{key: sum(row[key] for row in told) for key in ("runs", "stronger_than", "still_rising")}
        })
        at += len(t.values)
    off = {
        t["name"]: t["rms_in_standard_deviations"] for t in of_targets
        if t["rms_in_standard_deviations"] > regression.TOO_FAR
    }
    refused = sum(r["refused"] for r in evaluation.rows)
    verdicts = regression.verdicts(result, [p.name for p in parameters], off)
    return {
        "method": table.get("method", "regression"), "points": evaluation.points,
        "failed_points": sum(r["failed"] for r in evaluation.rows), "refused_points": refused,
        "refusal": next(iter(evaluation.runner.refused.values()), None), "parameters": [{
            "key": p.key, "name": p.name, "value": p.number(u), "sd": p.deviation(u, s), "unit": p.unit,
            "scale": "log" if p.log else "linear", "sd_of_range": float(s), "verdict": v
        } for p, u, s, v in zip(parameters, result.x, sd, verdicts)],
        "correlation": correlation.tolist(), "singular_values": result.singular_values.tolist(),
        "directions": result.directions.tolist(), "targets": of_targets,
        "by_points": [{"points": n, "values": [p.number(u) for p, u in zip(parameters, x)], "sd_of_range": s.tolist()}
                      for n, x, s in result.history], "checked_by_runs": checked
    }


def check_by_runs(evaluation, result, data, parameters):
    """Runs at the best point and one standard deviation to either side of it in each parameter: sums of squares."""
    sd = np.sqrt(np.diag(result.covariance))
    points = [result.x] + [
        np.clip(result.x + side * s * np.eye(len(sd))[k], 0, 1) for k, s in enumerate(sd) for side in (-1, 1)
    ]
    evaluation.budget += len(points)
    answers = evaluation(points)
    y = regression.filled(answers)
    scale = data.weight / data.error**2
    cost = (scale * (y - data.values) ** 2).sum(axis=1)
    return {
        "best": float(cost[0]), "values": y[0].tolist(), "sides": [{
            "name": p.name, "at": [p.number(points[1 + 2 * k][k]),
                                   p.number(points[2 + 2 * k][k])],
            "sum_of_squares": [float(cost[1 + 2 * k]), float(cost[2 + 2 * k])]
        } for k, p in enumerate(parameters)]
    }


def write_tables(out, parameters, targets, evaluation, data):
    names = [f"{t.name}[{k}]" if len(t.values) > 1 else t.name for t in targets for k in range(len(t.values))]
    rows = [[p.name for p in parameters] + ["failed"] + names,
            ["data"] + [""] * (len(parameters) - 1) + [""] + [f"{v:.9g}" for v in data.values]]
    for row in evaluation.rows:
        rows.append([f"{p.number(u):.9g}" for p, u in zip(parameters, row["x"])] + [int(row["failed"])] +
                    ["" if math.isnan(v) else f"{v:.9g}" for v in row["values"]])
    write_csv(os.path.join(out, "calibration.csv"), rows)


def best_scene(run, parameters, x):
    """A scene file that runs as it is: the target's scene with its settings and the values found."""
    table = toml_of(run["scene"])
    for key, value in {**run["set"], **{p.key: p.setting(u) for p, u in zip(parameters, x)}}.items():
        here, parts = table, key.split(".")
        for part in parts[:-1]:
            here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
        here[int(parts[-1]) if isinstance(here, list) else parts[-1]] = value
    lines = []

    def put(path, t):
        own = {
            k: v for k, v in t.items()
            if not isinstance(v, dict) and not (isinstance(v, list) and v and isinstance(v[0], dict))
        }
        if path and (own or not t):
            lines.append(f"[{path}]")
        lines.extend(f"{k} = {toml_value(v)}" for k, v in own.items() if v != "")
        for k, v in t.items():
            inner = f"{path}.{k}" if path else k
            if isinstance(v, dict):
                put(inner, v)
            elif k not in own:
                for entry in v:
                    lines.append(f"[[{inner}]]")
                    lines.extend(f"{a} = {toml_value(b)}" for a, b in entry.items())

    put("", table)
    return "\n".join(lines) + "\n"


def best_name(run):
    """Of one of several best scenes."""
    return f"best_{os.path.splitext(os.path.basename(run['scene']))[0]}_{run['name']}.toml"


def work(args):
    whole, table, parameters, targets, runs = read_calibration(args.scene)
    out = args.out or os.path.splitext(os.path.basename(args.scene))[0]
    workers = args.threads or len(os.sched_getaffinity(0))
    runner = Runner(out, table.get("seed_key", "packing.seed"), programs.folder(), {})
    tried = []
    for corner in (0.0, 0.5, 1.0):
        for run in runs:
            case = case_at(run, parameters, [corner] * len(parameters))
            tried.append(case)
            runner.asked[case["name"]] = (set().union(*(t.columns() for t in run["targets"])),
                                          set().union(*(t.keys() for t in run["targets"])))
            try:
                refusal = runner.refusal(case)
            except KeyboardInterrupt:
                runner.stop()
                raise
            if refusal:
                raise InputError(refusal.told(args.scene))
    seeds = max(len(r["seeds"]) for r in runs)
    points = max(1, table.get("budget", 90) // seeds)
    sides = 2 * len(parameters) + 1 if table.get("check", True) else 0
    if table.get("method", "regression") == "regression" and points - sides < len(parameters) + 2:
        raise InputError(
            f"{args.scene}: calibrate.budget: {points} points of {seeds} seeds; {len(parameters)} parameters need at "
            f"least {(sides + len(parameters) + 2) * seeds} runs"
        )
    if table.get("posterior"):
        posterior.sampler()
    if args.check:
        for p in parameters:
            print(f"{p.key}: {p.setting(0)} … {p.setting(1)}{' (log)' if p.log else ''}")
        for t in targets:
            print(f"{t.name}: {t.kind}, {t.describe()}")
        planned = [times.Planned(c, c["seeds"][0], points * len(c["seeds"]) / 3) for c in tried]
        print(f"{points} points, {sum(len(r['seeds']) for r in runs)} runs each, "
              + times.told_of(runner, planned, workers))
        return 0
    data = data_of(targets)
    with Folder(out):
        os.makedirs(os.path.join(out, "runs"), exist_ok=True)
        evaluation = Evaluation(runner, runs, parameters, targets, workers, points - sides, args.quiet)

        def told(result):
            if not args.quiet:
                found = "  ".join(f"{p.name} {p.text(u, s)}"
                                  for p, u, s in zip(parameters, result.x, np.sqrt(np.diag(result.covariance))))
                print(f"{result.history[-1][0]} points: {found}", flush=True)

        if table.get("method", "regression") == "pounders":
            result = pounders(evaluation, len(parameters), data, points - sides, told)
        else:
            result = regression.calibrate(evaluation, len(parameters), data, points - sides, table.get("batch"),
                                          told=told)
        checked = check_by_runs(evaluation, result, data, parameters) if sides else None
        clear_results(out, ("report.html", "calibration.csv", "calibration.json", "posterior.csv"))
        write_tables(out, parameters, targets, evaluation, data)
        summary = record(result, table, parameters, targets, evaluation, checked)
        draws = None
        if table.get("posterior"):
            draws, worth = posterior.posterior(result, data)
            summary["posterior"] = {
                "draws": len(draws), "independent": round(worth), "parameters": posterior.table(draws, parameters)
            }
            write_csv(os.path.join(out, "posterior.csv"),
                      [[p.name for p in parameters]] + [[f"{p.number(u):.6g}" for p, u in zip(parameters, x)]
                                                        for x in draws[::10]])
        write_whole(os.path.join(out, "calibration.json"), json.dumps(summary, indent=2) + "\n")
        scenes = {best_name(run) if len(runs) > 1 else "best.toml": best_scene(run, parameters, result.x)
                  for run in runs}
        for name, text in {**scenes, "best.toml": best_scene(runs[0], parameters, result.x)}.items():
            write_whole(os.path.join(out, name), text)
        ran = [os.path.relpath(runner.folder(case_at(run, parameters, result.x), s), out) for run in runs
               for s in run["seeds"][:1]] if sides else []
        from grus.calibrate import report
        report.write(whole.get("title", "Calibration"), out, summary, parameters, targets, evaluation, result,
                     (list(scenes), ran), draws)
        for p in summary["parameters"]:
            print(
                f"{p['key']} = {p['value']:.5g}{' ' + p['unit'] if p['unit'] else ''} (sd {p['sd']:.2g}): "
                f"{p['verdict']}"
            )
        for line in report.said_of_runs(summary):
            print(line)
        print(f"best scene{'s' if len(scenes) > 1 else ''}: {', '.join(os.path.join(out, name) for name in scenes)}")
        print(f"report: {os.path.join(out, 'report.html')}")
        return 0


def main():
    parser = argparse.ArgumentParser(prog="grus-calibrate", description=__doc__)
    parser.add_argument("scene", metavar="CALIBRATION.toml")
    parser.add_argument("-o", metavar="DIR", dest="out", help="results folder (default: the file's name)")
    parser.add_argument("--threads", "--jobs", type=int, default=0,
                        help="cores to use; each run takes one (default: all cores given)")
    parser.add_argument("--check", action="store_true", help="check all, say what would run and stop")
    parser.add_argument("--resume", action="store_true", help="as without: runs that are done are never repeated")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--version", action="version", version=f"grus-calibrate {__version__}")
    interrupts.add_options(parser)
    args = parser.parse_args()
    if args.threads < 0:
        parser.error("--threads: at least 1")
    return status_of("grus-calibrate", args, work, "interrupted: finished runs are kept; the same command goes on")
