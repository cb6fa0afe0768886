#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time: runs a scene over lists of settings, several seeds each, side by side on the cores given, and
compares with a reference: work-precision tables, plots, Pareto front, order, recommended settings. Or compares a list of
cases: a table, plots with scatter bands, checks of claims. All in report.html. Runs that are done are not repeated."""
import argparse
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor, as_completed

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import grus_precision as precision  # noqa: E402
from grus_results import read_grading, read_history  # noqa: E402


class Refused(Exception):
    pass


def need(table, where, known):
    for key in table:
        if key not in known:
            raise Refused(f"{where}: unknown key '{key}' (known: {', '.join(sorted(known))})")


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


def read_study(path):
    try:
        with open(path, "rb") as f:
            study = tomllib.load(f)
    except OSError as e:
        raise Refused(f"{path}: {e.strerror}") from None
    except tomllib.TOMLDecodeError as e:
        raise Refused(f"{path}: {e}") from None
    need(study, path, {"title", "study", "case", "plot", "check", "table", "fit", "precision"})
    common = study.get("study", {})
    need(common, f"{path}: study", {"scene", "seeds", "seed_key", "set", "at", "quantities"})
    folder = os.path.dirname(os.path.abspath(path))
    cases = []
    for k, c in enumerate(study.get("case", [])):
        where = f"{path}: case {c.get('name', k)}"
        need(c, where, {"name", "label", "scene", "set", "seeds"})
        if "name" not in c:
            raise Refused(f"{where}: needs a name")
        cases.append({"name": c["name"], "label": c.get("label", c["name"]), **scene_of(where, c.get("scene", common.get("scene")), folder),
                      "set": {**common.get("set", {}), **c.get("set", {})}, "seeds": c.get("seeds", common.get("seeds", [None]))})
    entries = [e for k, p in enumerate(study.get("precision", [])) for e in read_precision(path, k, p, common, folder)]
    if not cases and not entries:
        raise Refused(f"{path}: needs at least one [[case]] or [[precision]]")
    names = [c["name"] for c in cases]
    if len(set(names)) < len(names):
        raise Refused(f"{path}: two cases share a name")
    for kind in ("plot", "check", "table", "fit"):
        for t in study.get(kind, []):
            used = list(t.get("cases", [])) + ([t["reference"]] if "reference" in t else []) + list(t.get("greater", []))
            for name in used + ([t["case"]] if "case" in t else []):
                if name not in names:
                    raise Refused(f"{path}: {kind} '{t.get('name', t.get('claim', '?'))}': no case is called '{name}'")
    study["precision"] = entries
    return study, common, cases


def scene_of(where, scene, folder):
    """The scene's file, the one that it takes its cells from, and the program: grus-bvp for scenes with a mesh."""
    if not scene:
        raise Refused(f"{where}: needs a scene, its own or that of [study]")
    scene = os.path.normpath(os.path.join(folder, scene))
    if not os.path.isfile(scene):
        raise Refused(f"{where}: no such scene file {scene}")
    try:
        with open(scene, "rb") as f:
            table = tomllib.load(f)
    except tomllib.TOMLDecodeError as e:
        raise Refused(f"{where}: {scene}: {e}") from None
    inner = os.path.join(os.path.dirname(scene), table.get("rve", {}).get("scene", ""))
    return {"scene": scene, "inner": inner if os.path.isfile(inner) else None, "program": "grus-bvp" if "mesh" in table else "grus-rve"}


def read_precision(path, k, table, common, folder):
    """Entries of one [[precision]]: one for each position of `at`. Each carries its cases: the settings, then the reference."""
    where = f"{path}: precision {table.get('name', k)}"
    need(table, where, precision.KEYS)
    for key in ("name", "vary", "quantity"):
        if key not in table:
            raise Refused(f"{where}: needs '{key}'")
    if not isinstance(table["vary"], dict) or not all(isinstance(v, list) and v for v in table["vary"].values()):
        raise Refused(f"{where}: vary: needs keys with lists of values, as {{ \"numerics.safety\" = [0.4, 0.2] }}")
    how = table.get("measure", "at")
    if how not in ("at", "peak", "last", "area"):
        raise Refused(f"{where}: measure: '{how}' is none of at, peak, last, area")
    if how == "at" and "at" not in table:
        raise Refused(f"{where}: needs 'at', or a measure (peak, last, area)")
    reference = table.get("reference", "finest")
    if isinstance(reference, str) and reference != "finest":
        raise Refused(f"{where}: reference: \"finest\", a number, a table of settings, or {{ file = \"...\" }}")
    if isinstance(reference, dict) and "file" in reference and not os.path.isfile(os.path.join(folder, reference["file"])):
        raise Refused(f"{where}: reference: no such file {reference['file']}")
    base = {**scene_of(where, table.get("scene", common.get("scene")), folder), "seeds": table.get("seeds", common.get("seeds", [None]))}
    fixed = {**common.get("set", {}), **table.get("set", {})}
    reference = precision.reference_settings(table)
    rows = [s for s in precision.settings(table) if s != reference]
    if not rows:
        raise Refused(f"{where}: nothing to compare with the reference")

    def case(settings):
        whole = {**fixed, **settings}
        name = hashlib.sha256(json.dumps([base["scene"], whole], sort_keys=True).encode()).hexdigest()[:12]
        return {"name": name, "label": ", ".join(f"{key}={v}" for key, v in settings.items()), **base, "set": whole}

    table = {**table, "folder": folder, "rows": [(s, case(s)) for s in rows], "reference_case": case(reference) if reference is not None else None}
    if how != "at" or not isinstance(table["at"], list):
        return [table]
    return [{**table, "at": at, "name": f"{table['name']}, at {at:g}"} for at in table["at"]]


def key_of(case, seed, seed_key, program):
    """Changes when the scene, its settings or the program change: then the run is done again."""
    scene = b""
    for path in filter(None, (case["scene"], case["inner"])):
        with open(path, "rb") as f:
            scene += f.read()
    with open(program, "rb") as f:
        binary = hashlib.sha256(f.read()).hexdigest()
    return hashlib.sha256(scene + json.dumps([case["set"], seed, seed_key, binary], sort_keys=True).encode()).hexdigest()


class Runner:
    def __init__(self, out, seed_key, bins):
        self.out, self.seed_key, self.bins = out, seed_key, bins
        self.running, self.stopped = set(), False

    def folder(self, case, seed):
        text = "" if seed is None else "_s" + re.sub(r"[^\w.-]+", "_", toml_value(seed)).strip("_")
        return os.path.join(self.out, "runs", case["name"] + text)

    def run(self, case, seed):
        folder = self.folder(case, seed)
        program = os.path.join(self.bins, case["program"])
        key, marker = key_of(case, seed, self.seed_key, program), os.path.join(folder, "study.key")
        if os.path.isfile(marker) and open(marker).read() == key:
            return case, seed, None
        if self.stopped:
            return case, seed, "not started"
        if os.path.isfile(marker):  # of other settings: must not vouch for what is about to be overwritten
            os.remove(marker)
        settings = dict(case["set"])
        if seed is not None:
            settings[self.seed_key] = seed
        command = [program, case["scene"], "-o", folder, "--force", "--quiet", "--threads", "1"]
        for k, v in settings.items():
            command += ["--set", f"{k}={toml_value(v)}"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        self.running.add(process)
        _, errors = process.communicate()
        self.running.discard(process)
        if process.returncode in (0, 3):  # unstable is a result: the table says so
            with open(marker, "w") as f:
                f.write(key)
            return case, seed, None
        return case, seed, errors.strip() or f"ended with status {process.returncode}"

    def stop(self):
        self.stopped = True
        for process in list(self.running):
            process.send_signal(signal.SIGINT)


def duration_text(s):
    return f"{s:.0f} s" if s < 120 else f"{s / 60:.0f} min" if s < 7200 else f"{s / 3600:.1f} h"


def run_all(runner, cases, workers, quiet):
    jobs = list({(c["name"], str(s)): (c, s) for c in cases for s in c["seeds"]}.values())  # settings that two studies share run once
    start, failures, done = time.time(), [], 0
    with ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(runner.run, c, s) for c, s in jobs]
        try:
            for future in as_completed(futures):
                case, seed, failure = future.result()
                done += 1
                if failure:
                    failures.append((case, seed, failure))
                if not quiet:
                    left = (time.time() - start) / done * (len(jobs) - done)
                    print(f"{done}/{len(jobs)}  {case['label']}{'' if seed is None else f' seed {seed}'}"
                          f"{'  FAILED: ' + failure if failure else ''}  ETA {duration_text(left)}", flush=True)
        except KeyboardInterrupt:
            runner.stop()
            print("interrupted: finished runs are kept; the same command goes on", file=sys.stderr)
            return None, time.time() - start
    return failures, time.time() - start


def read_run(folder):
    with open(os.path.join(folder, "summary.json")) as f:
        summary = json.load(f)
    return {"columns": read_history(folder), "summary": summary, "grading": read_grading(folder)}


def main():
    parser = argparse.ArgumentParser(prog="grus-study", description=__doc__)
    parser.add_argument("scene", metavar="STUDY.toml")
    parser.add_argument("-o", metavar="DIR", dest="out", help="results folder (default: the study's name)")
    parser.add_argument("--threads", type=int, default=0, help="cores to use; each run takes one (default: all cores given)")
    parser.add_argument("--check", action="store_true", help="list the runs and stop")
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--strict", action="store_true", help="exit with 1 if a check of the study fails")
    args = parser.parse_args()
    try:
        study, common, cases = read_study(args.scene)
    except Refused as e:
        print(f"grus-study: {e}", file=sys.stderr)
        return 2
    runs_of = cases + [c for e in study["precision"] for c in [row[1] for row in e["rows"]] + ([e["reference_case"]] if e["reference_case"] else [])]
    out = args.out or os.path.splitext(os.path.basename(args.scene))[0]
    if args.check:
        for c in {c["name"]: c for c in runs_of}.values():
            print(c["name"], c["seeds"], os.path.relpath(c["scene"]), json.dumps(c["set"]))
        print(f"{len({(c['name'], str(s)) for c in runs_of for s in c['seeds']})} runs")
        return 0
    os.makedirs(os.path.join(out, "runs"), exist_ok=True)
    workers = args.threads or len(os.sched_getaffinity(0))
    runner = Runner(out, common.get("seed_key", "packing.seed"), os.path.dirname(os.path.realpath(__file__)))
    failures, wall = run_all(runner, runs_of, workers, args.quiet)
    if failures is None:
        return 130
    for case, seed, text in failures:
        print(f"grus-study: {case['label']}{'' if seed is None else f', seed {seed}'}: {text}", file=sys.stderr)
    lost = {(case["name"], str(seed)) for case, seed, _ in failures}
    if any(case is c for case, _, _ in failures for c in cases):
        return 1  # claims and plots need all their cases

    import grus_study_report as report
    runs = {c["name"]: [read_run(runner.folder(c, s)) for s in c["seeds"]] for c in cases}
    studies = []
    try:
        for e in study["precision"]:
            c = e["reference_case"]
            found = {k["name"]: {str(s): read_run(runner.folder(k, s)) for s in k["seeds"] if (k["name"], str(s)) not in lost}
                     for k in [k for _, k in e["rows"]] + ([c] if c else [])}
            # Runs that failed are left out; where seeds are compared one by one, the others of their seed too.
            paired = c is not None and e.get("paired", True)
            common_seeds = set.intersection(*(set(r) for r in found.values() if r)) if paired else None
            kept = {name: [r for seed, r in by_seed.items() if not paired or seed in common_seeds] for name, by_seed in found.items()}
            rows = [(s, kept[k["name"]]) for s, k in e["rows"] if kept[k["name"]]]
            if not rows or (c and not kept[c["name"]]):
                print(f"grus-study: {e['name']}: no run is left to compare", file=sys.stderr)
                continue
            studies.append((e, precision.judge(e, rows, kept[c["name"]] if c else None, e["folder"])))
    except KeyError as missing:
        print(f"grus-study: {args.scene}: no column {missing} in history.csv", file=sys.stderr)
        return 2
    passed = report.write(study, common, cases, runs, studies, out, wall, workers)
    print(f"report: {os.path.join(out, 'report.html')}")
    return 1 if failures or (args.strict and not passed) else 0


if __name__ == "__main__":
    sys.exit(main())
