# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time: runs a scene over lists of settings, several seeds each, side by side on the cores given, and
compares with a reference: work-precision tables, plots, Pareto front, order, recommended settings. Or compares a list
of cases: a table, plots with scatter bands, checks of claims. All in report.html. Runs that are done are not
repeated."""
import argparse
import json
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed

from grus._version import __version__
from grus.errors import InputError
from grus.files.folders import Folder, clear_results
from grus.files.texts import one_line
from grus.runs import interrupts, programs, times
from grus.runs.command import Lacking, duration_text, status_of
from grus.runs.runner import Runner
from grus.study import report
from grus.study.reader import read_study
from grus.study.tables import Done


def run_all(runner, cases, workers, quiet):
    jobs = list({(c["name"], str(s)): (c, s) for c in cases
                 for s in c["seeds"]}.values())  # settings that two studies share run once
    start, failures, done = time.time(), [], 0
    with ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(runner.run, c, s) for c, s in jobs]
        try:
            for future in as_completed(futures):
                case, seed, failure = future.result()
                done += 1
                if not failure and not runner.stopped:
                    lacking = runner.lacking(case, runner.folder(case, seed))
                    if lacking:  # the first run tells: no need to wait for the others
                        runner.stop()
                        raise Lacking(f"{case['label']}: {lacking}; what has run is kept")
                if failure:
                    failures.append((case, seed, failure))
                if not quiet:
                    left = (time.time() - start) / done * (len(jobs) - done)
                    print(f"{done}/{len(jobs)}  {case['label']}{'' if seed is None else f' seed {seed}'}"
                          f"{'  FAILED: ' + failure if failure else ''}  ETA {duration_text(left)}", flush=True)
        except interrupts.OutOfTime:
            runner.stop()
            raise
        except KeyboardInterrupt:
            runner.stop()
            print("interrupted: finished runs are kept; the same command goes on", file=sys.stderr)
            return None, time.time() - start
    return failures, time.time() - start


def refuse_early(study, path, runner, workers):
    """Asks the programs of every case before any of them runs."""
    with ThreadPoolExecutor(workers) as pool:
        try:
            for refusal in pool.map(runner.refusal, {c["name"]: c for c in study.cases()}.values()):
                if refusal:
                    raise InputError(refusal.told(path))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            runner.stop()
            raise


def planned_of(cases):
    """Each case once, with the number of its seeds."""
    seeds = {}
    for c in cases:
        seeds.setdefault(c["name"], (c, {}))[1].update({str(s): s for s in c["seeds"]})
    return [times.Planned(c, next(iter(of.values())), len(of)) for c, of in seeds.values()]


def work(args):
    study = read_study(args.scene)
    cases = study.cases()
    out = args.out or os.path.splitext(os.path.basename(args.scene))[0]
    workers = args.threads or len(os.sched_getaffinity(0))
    runner = Runner(out, study.common.get("seed_key", "packing.seed"), programs.folder(), study.wanted())
    refuse_early(study, args.scene, runner, workers)
    if args.check:
        for c in {c["name"]: c for c in cases}.values():
            print(c["name"], c["seeds"], os.path.relpath(c["scene"]), json.dumps(c["set"], default=str))
        planned = planned_of(cases)
        print(f"{sum(p.runs for p in planned)} runs, {times.told_of(runner, planned, workers)}")
        return 0
    with Folder(out):
        os.makedirs(os.path.join(out, "runs"), exist_ok=True)
        failures, wall = run_all(runner, cases, workers, args.quiet)
        if failures is None:
            return 130
        for case, seed, text in failures:
            print(one_line(f"grus-study: {case['label']}{'' if seed is None else f', seed {seed}'}: {text}"),
                  file=sys.stderr)
        if any(case is c for case, _, _ in failures for c in study.named):
            return 1  # claims and plots need all their cases
        clear_results(out, ("report.html", "study.txt", "study.csv", "precision.csv", "sweep.csv"))
        done = Done(out, study.common, runner, study.named, {(case["name"], str(seed)) for case, seed, _ in failures})
        passed = report.write(study, done, f"{wall:.0f} s on {workers} cores")
        print(f"report: {os.path.join(out, 'report.html')}")
        return 1 if failures or (args.strict and not passed) else 0


def main():
    parser = argparse.ArgumentParser(prog="grus-study", description=__doc__)
    parser.add_argument("scene", metavar="STUDY.toml")
    parser.add_argument("-o", metavar="DIR", dest="out", help="results folder (default: the study's name)")
    parser.add_argument("--threads", type=int, default=0,
                        help="cores to use; each run takes one (default: all cores given)")
    parser.add_argument("--check", action="store_true", help="check every case, list the runs and stop")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a check of the study fails")
    parser.add_argument("--version", action="version", version=f"grus-study {__version__}")
    interrupts.add_options(parser)
    args = parser.parse_args()
    if args.threads < 0:
        parser.error("--threads: at least 1")
    return status_of("grus-study", args, work, "interrupted")  # where no run is under way
