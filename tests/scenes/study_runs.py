#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which runs grus-study starts and how, what it keeps, how it ends and what it writes, with a program of known answers
in the place of grus-rve: study_runs.py BIN"""
import csv
import hashlib
import json
import math
import os
import re
import signal
import sys
import tempfile
import time
from types import SimpleNamespace

import numpy as np

import made_up
from scene_tools import faults, need

SCENE = "[made_up]\na = 100.0\nb = 50.0\nc = 3.0\n"
COMMON = """[study]
scene = "scene.toml"
seeds = [1, 2, 4]
seed_key = "seed"
at = [0.1]
"""


def write(folder, name, text):
    path = os.path.join(folder, name)
    with open(path, "w") as f:
        f.write(text)
    return path


def rows_of(folder, name):
    with open(os.path.join(folder, name), newline="") as f:
        return list(csv.DictReader(f))


def runs_again(tmp, programs):
    """A run is done again where anything that it read or wrote is another, and goes on from its own checkpoint."""
    from grus.runs.runner import Runner
    scene, out = write(tmp, "again.toml", SCENE), os.path.join(tmp, "again")
    case = {"name": "c", "label": "C", "program": "grus-rve", "scene": scene, "set": {"graded": 1}, "seeds": [1]}
    fresh = lambda **more: Runner(out, more.get("seed_key", "seed"), programs, {"c": (set(), set())})
    folder = os.path.join(out, "runs", "c@1")

    def asked(what, wanted, case=case, **more):
        _, _, failure = fresh(**more).run(case, 1)
        told = made_up.calls(programs)
        flags = [t.split()[-1] for t in told]
        need(flags == wanted and not failure, f"{what}: {told} {failure}")

    alike = [os.path.basename(fresh().folder(case, seed)) for seed in ("b 1", "b_1", 7, 0.5)]
    need(alike == ["c@b_1-" + hashlib.sha256(b'"b 1"').hexdigest()[:6],
                   "c@b_1-" + hashlib.sha256(b'"b_1"').hexdigest()[:6], "c@7", "c@0.5"], f"folders of seeds: {alike}")
    asked("a new run", ["--force"])
    asked("a run that is kept", [])
    for name in ("summary.json", "history.csv", "grading.csv"):
        with open(os.path.join(folder, name), "a") as f:
            f.write("\n")
        asked(f"{name} was changed", ["--force"])
        os.remove(os.path.join(folder, name))
        asked(f"{name} was lost", ["--force"])
    asked("another setting", ["--force"], {**case, "set": {"graded": 1, "b": 7.0}})
    asked("the setting before", ["--force"])
    asked("another key of seeds", ["--force"], seed_key="other")
    asked("the key before", ["--force"])
    write(tmp, "again.toml", SCENE + "# changed\n")
    asked("another scene", ["--force"])
    with open(os.path.join(programs, "grus-rve"), "a") as f:
        f.write("# another program\n")
    asked("another program", ["--force"])
    asked("that program", [])
    key, begun = os.path.join(folder, "study.key"), os.path.join(folder, "study.begun")
    need(not os.path.exists(begun), "a run that has ended is under way")
    own = open(key).read().split()[0]
    for what, text, checkpoint, flags in (("its own checkpoint", own, True, ["--resume"]),
                                          ("no checkpoint", own, False, ["--force"]),
                                          ("a checkpoint of other settings", own[::-1], True, ["--force"]),
                                          ("a checkpoint of nobody knows what", None, True, ["--force"])):
        for path in (key, begun, os.path.join(folder, "checkpoint.h5")):
            if os.path.exists(path):
                os.remove(path)
        if text:
            write(folder, "study.begun", text)
        if checkpoint:
            write(folder, "checkpoint.h5", "")
        asked(what, flags)
    lost = {**case, "set": {"lost_checkpoint": 1}}
    asked("settings whose checkpoints are lost", ["--force"], lost)
    own = open(key).read().split()[0]
    os.remove(key), write(folder, "study.begun", own)
    asked("a checkpoint that is refused", ["--resume", "--force"], lost)
    stopped = fresh()
    stopped.stopped = True
    need(stopped.run(lost, 1)[2] is None and stopped.run(case, 1)[2] == "not started" and not made_up.calls(programs),
         "a runner that was stopped")
    # How runs end.
    runner = fresh()
    need(runner.run({**case, "set": {"fails": [1]}}, 1)[2] == "no room" and not os.path.exists(key)
         and not runner.refused, "a run that fails is kept, or counts as refused")
    need(runner.run({**case, "set": {"fails": [1], "says": " "}}, 1)[2] == "ended with status 1", "a silent end")
    need(runner.run({**case, "set": {"a": 9.0, "refused_from": 5}}, 1)[2] == "scene: a: too large"
         and runner.refused == {("c", "1"): "scene: a: too large"}, f"refused: {runner.refused}")
    made_up.calls(programs)
    asked("an unstable run", ["--force"], {**case, "set": {"unstable": [1]}})
    asked("an unstable run that is kept", [], {**case, "set": {"unstable": [1]}})
    need(fresh().refusal({**case, "set": {"a": 9.0, "refused_from": 5}}).text == "C: scene: a: too large"
         and fresh().refusal(case) is None, "what the program refuses before anything runs")
    lacks = Runner(out, "seed", programs, {"c": ({"void_ratio", "none"}, {"results.peak_axial_stress_Pa"})})
    need(lacks.refusal(case) == ("C: history.csv will have no column 'none'", "none"), f"{lacks.refusal(case)}")
    key = "results.peek_axial_stress_Pa"
    misspelt = Runner(out, "seed", programs, {"c": (set(), {key})})
    need(misspelt.refusal(case) == (f"C: summary.json will have no key '{key}' (did you mean "
                                    "'results.peak_axial_stress_Pa'?)", key), f"{misspelt.refusal(case)}")
    need(lacks.lacking(case, folder) is None, "a run that was unstable lacks nothing")
    need(fresh().run(case, 1)[2] is None and lacks.lacking(case, folder) is None, "a key that is there is lacking")
    lacks.asked["c"][1].add("results.none")
    need(lacks.lacking(case, folder) == "summary.json has no number 'results.none'", f"{lacks.lacking(case, folder)}")
    made_up.calls(programs)
    need(not runner.running and not lacks.running, "what has ended counts as running")
    need(runner.command({**case, "set": {"seed": ["a=1"]}}, 7)[2:] == ["--set", "seed=7"], "a number beside a list")
    need(runner.command(case, 5)[2:] == ["--set", "graded=1", "--set", "seed=5"]
         and runner.command({**case, "set": {"seed": 8, "x": ""}}, None)[2:] == ["--set", "seed=8", "--set", "x="]
         and runner.command({**case, "set": {"seed": ["a=1"]}}, ["b=2"])[2:] == ["--set", 'seed=["a=1", "b=2"]'],
         "commands of seeds")
    from grus.runs.cases import toml_value
    need([toml_value(v) for v in (True, "a\"b", "", [1, "x"], {"k": 2.5}, 1e-9)] ==
         ["true", '"a\\"b"', "", '[1, "x"]', "{k = 2.5}", "1e-09"], "values as --set takes them")


def results_read(tmp, programs):
    """What is read of a folder: an empty field, a grading that is of this run, and one that is not."""
    import subprocess

    import grus.results as results
    scene, out = write(tmp, "read.toml", SCENE), os.path.join(tmp, "read")
    subprocess.run([os.path.join(programs, "grus-rve"), scene, "--set", "graded=1", "-o", out], check=True)
    run = results.read_run(out)
    strain = run["columns"]["axial_strain"]
    need(list(run) == ["columns", "summary", "grading"] and len(strain) == 11
         and np.allclose(run["columns"]["axial_stress_Pa"], 100 * np.array(strain) + 50 * np.array(strain) ** 2),
         "columns of a run")
    need(sorted(run["grading"]) == [0.0, 0.1, 0.2] and run["grading"][0.1][1] ==
         {"strain": 0.1, "diameter_m": 2e-4, "passing": 0.2**1.5, "mass_kg": 0.25}, f"{run['grading']}")
    loaded = results.load(out)
    need(loaded.status == 0 and loaded.summary["results"]["peak_axial_stress_Pa"] == max(loaded["axial_stress_Pa"])
         and np.allclose(loaded.grading[0.2]["passing"], [0.1, 0.2, 0.4, 1]) and len(loaded) == 6
         and "11 rows of 6 columns, finished" in repr(loaded), f"{loaded!r}")
    path = os.path.join(out, "summary.json")
    summary = json.load(open(path))
    write(out, "summary.json", json.dumps({**summary, "files": ["history.csv"], "status": 3}))
    need(results.read_run(out)["grading"] == {} and results.load(out).grading == {}, "a grading of an earlier run")
    need("unstable" in repr(results.load(out)) and results.load(out).status == 3, "an unstable run")
    del summary["files"], summary["status"]
    write(out, "summary.json", json.dumps(summary))
    need(len(results.read_run(out)["grading"]) == 3 and "unfinished" in repr(results.load(out)),
         "a summary without a list of files")
    write(out, "history.csv", "a,b\n1,\n2,3\n")
    columns = results.read_history(out)
    need(columns["a"] == [1, 2] and math.isnan(columns["b"][0]) and columns["b"][1] == 3, f"an empty field: {columns}")
    need(np.isnan(results.load(out)["b"][0]) and list(results.load(out)) == ["a", "b"], "an empty field of results")
    frame = results.load(out).frame()
    need(list(frame.columns) == ["a", "b"] and frame["b"][1] == 3, "a frame")
    for text, said in (("a,b\n1,2\n3\n", "line 3 has 1 values for 2 columns"), ("a\nx\n", "line 2: a is not a number"),
                       ("a\n", "no rows")):
        write(out, "history.csv", text)
        try:
            results.read_history(out)
            need(False, f"{text!r} is a history")
        except ValueError as e:
            need(str(e).endswith(said), f"{text!r}: {e}")


def studies(tmp, programs):
    """What a study writes of runs of known answers, and how it ends."""
    from grus.study.command import main
    made_up.unpainted()
    write(tmp, "scene.toml", SCENE)
    at = lambda e, seed, a=100.0: a * e + 50 * e * e + 3 * seed
    cases = COMMON + """[[case]]
name = "soft"
[[case]]
name = "hard"
set = { a = 300.0 }
seeds = [2]
[[check]]
claim = "harder"
greater = ["hard", "soft"]
at = [0.2]
factor = 2.3
"""
    path, out = write(tmp, "cases.toml", cases), os.path.join(tmp, "cases")
    made_up.calls(programs)
    status, said, errors = made_up.command(main, path, "--check", "--threads", "2")
    asked = made_up.calls(programs)
    # Four runs of 6 to 84 s by two: no less than half of their sum, no more than that and half of the last one.
    need(status == 0 and said.splitlines()[-1] == "4 runs, 12 s to 4 min on 2 cores" and not os.path.exists(out)
         and [line.split()[-1] for line in asked] == 4 * ["--columns"] + 2 * ["1"]
         and all("--check --threads 1" in line for line in asked[4:]), f"--check: {said} {errors} {asked}")
    status, said, errors = made_up.command(main, path, "-o", out, "--strict", "--threads", "1")
    need(status == 0 and not errors and len(made_up.calls(programs)) == 8, f"a study: exit {status} {said} {errors}")
    far = [line.split("  ETA ") for line in said.splitlines()[:4]]
    need([a[:5] for a, _ in far] == [f"{k}/4  " for k in (1, 2, 3, 4)] and far[3][1] == "0 s"
         and {a[5:] for a, _ in far} == {"soft seed 1", "soft seed 2", "soft seed 4", "hard seed 2"}, f"how far: {far}")
    soft, hard = rows_of(out, "study.csv")
    stresses = [at(0.1, s) for s in (1, 2, 4)]
    for found, wanted in ((soft, {"case": "soft", "seeds": 3, "mean_axial_stress_Pa_at_0.1": np.mean(stresses),
                                  "sd_axial_stress_Pa_at_0.1": np.std(stresses, ddof=1), "grains": 100 + 7 / 3,
                                  "breakages": 2 + 7 / 3, "worst_energy_error_percent": 0.5, "steps": 1000 + 70 / 3,
                                  "cpu_s": 1 + 7 / 3}),
                          (hard, {"case": "hard", "seeds": 1, "mean_axial_stress_Pa_at_0.1": at(0.1, 2, 300.0),
                                  "sd_axial_stress_Pa_at_0.1": 0, "cpu_s": 3})):
        for name, value in wanted.items():
            good = found[name] == value if isinstance(value, str) else abs(float(found[name]) - value) < 1e-9
            need(good, f"study.csv of {found['case']}: {name} = {found[name]}, not {value}")
    quotient = (at(0.2, 2, 300.0)) / np.mean([at(0.2, s) for s in (1, 2, 4)])
    text = open(os.path.join(out, "study.txt")).read()
    need(f"= {quotient:.3g} at 0.2" in text and "holds  harder" in text, f"{quotient}: {text}")
    claim = cases.replace("2.3", "2.4")
    for arguments, wanted in (([], 0), (["--strict"], 1)):
        status, said, errors = made_up.command(main, write(tmp, "cases.toml", claim), "-o", out, *arguments)
        need(status == wanted and "DOES NOT HOLD  harder" in said, f"a false claim, {arguments}: exit {status} {said}")
    made_up.calls(programs)
    # A named case that fails ends the study, whatever holds.
    failing = cases.replace('name = "hard"', 'name = "hard"\nlabel = "H"').replace("300.0", "300.0, fails = [2]")
    failing = write(tmp, "fails.toml", failing)
    status, said, errors = made_up.command(main, failing, "-o", out, "--quiet")
    need(status == 1 and errors == "grus-study: H, seed 2: no room\n", f"a case that fails: exit {status} {errors!r}")
    status, said, errors = made_up.command(main, failing, "-o", out)
    need(re.search(r"^\d/4  H seed 2  FAILED: no room  ETA \d+ s$", said, re.M), f"its line: {said!r}")
    made_up.calls(programs)
    # A seed of other tables that fails is left out, and told; the study ends with 1 all the same.
    other = COMMON.replace("seeds", "set = { fails = [2] }\nseeds") + """[[precision]]
name = "p"
quantity = "axial_stress_Pa"
at = [0.1, 0.2]
vary = { b = [150.0, 60.0] }
reference = { b = 50.0 }
[[sweep]]
name = "s"
key = "a"
values = [100.0, 200.0]
quantity = "results.peak_axial_stress_Pa"
"""
    status, said, errors = made_up.command(main, write(tmp, "other.toml", other), "-o", out, "--quiet")
    need(status == 1 and errors.count("no room") == 5, f"seeds that fail: exit {status} {errors}")
    lines = rows_of(out, "precision.csv")
    wanted = [(b * e * e - 50 * e * e) / np.mean([at(e, s) for s in (1, 4)]) for e in (0.1, 0.2) for b in (150.0, 60.0)]
    need([line["study"] for line in lines] == ["p, at 0.1", "p, at 0.1", "p, at 0.2", "p, at 0.2"]
         and np.allclose([float(line["signed"]) for line in lines], wanted)
         and all(line["seeds"] == "2" and float(line["interval"]) < 1e-12 for line in lines), f"{lines}")
    first, second = rows_of(out, "sweep.csv")
    peak = np.mean([at(0.2, s) for s in (1, 4)])
    need(np.allclose([float(first["mean"]), float(second["change"])], [peak, 20 / peak]) and second["seeds"] == "2",
         f"sweep.csv: {first} {second}")
    need(not rows_of(out, "study.csv"), "the study before has left its rows")
    asked = made_up.calls(programs)
    kept = [line for line in asked if "--columns" not in line]
    need(len(kept) == 15, f"{len(kept)} runs: five settings of three seeds")
    status, said, errors = made_up.command(main, path.replace("cases.toml", "other.toml"), "-o", out, "--quiet")
    asked = [line for line in made_up.calls(programs) if "--columns" not in line]
    need(status == 1 and len(asked) == 5, f"what has failed is tried again, the rest is not: {asked}")
    whole = write(tmp, "whole.toml", other.replace("fails = [2]", "unstable = [2]"))
    status, said, errors = made_up.command(main, whole, "-o", out, "--quiet")
    need(status == 0 and [line["status"] for line in rows_of(out, "precision.csv")] == ["0,3 (1 not finished)"] * 4,
         f"a run that is unstable is a result: exit {status} {errors}")
    lacking = write(tmp, "lacking.toml", other.replace("results.peak_axial_stress_Pa", "errors.sought_stress.mean"))
    made_up.calls(programs)
    status, said, errors = made_up.command(main, lacking, "-o", os.path.join(tmp, "lacks"), "--quiet", "--threads", "1")
    asked = [line for line in made_up.calls(programs) if "--columns" not in line and "b=" not in line]
    need(len(asked) <= 2, f"the first run has told, and {len(asked)} are waited for")
    need(status == 1 and "no number 'errors.sought_stress.mean'" in errors, f"exit {status} {errors}")
    misspelt = write(tmp, "misspelt.toml", other.replace("results.peak_axial", "results.peek_axial"))
    status, said, errors = made_up.command(main, misspelt, "-o", os.path.join(tmp, "none"), "--quiet")
    place = next(n for n, line in enumerate(open(misspelt), 1) if "results.peek" in line)
    need(status == 2 and errors.count("\n") == 1 and f"{misspelt}:{place}: " in errors
         and "no key 'results.peek_axial_stress_Pa' (did you mean 'results.peak" in errors, f"exit {status} {errors}")
    refused = write(tmp, "refused.toml", other.replace("fails = [2]", "refused_from = 150.0"))
    status, said, errors = made_up.command(main, refused, "-o", os.path.join(tmp, "none"), "--quiet")
    need(status == 2 and "scene: a: too large" in errors and not os.path.exists(os.path.join(tmp, "none")),
         f"exit {status} {errors}")
    log = os.path.join(tmp, "log.txt")
    for times in (1, 2):
        status, said, errors = made_up.command(main, path, "--check", "--log", log)
        with open(log) as f:
            lines = f.read().splitlines()
        need(status == 0 and len(lines) == 3 * times and all(re.fullmatch(
            r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d  .*", line) for line in lines)
             and [line[21:] for line in lines[-3:]] == said.splitlines(), f"a log: exit {status} {errors} {lines}")
    status, said, errors = made_up.command(main, path, "--check", "--log", path)
    need(status == 2 and "is not a log of Grus" in errors, f"a log that is none: exit {status} {errors}")
    for wrong in ("--threads=-1", "--max-time=0", "--max-time=x"):
        status, said, errors = made_up.command(main, path, wrong)
        need(status == 2 and wrong.split("=")[0] in errors, f"{wrong}: {status} {errors}")


def interrupted(tmp):
    """Ctrl-C stops the runs, and the tool ends with 130."""
    from grus.study.command import main
    signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever starts the tests may ignore it
    write(tmp, "scene.toml", SCENE)
    path = write(tmp, "stop.toml", COMMON + "[[case]]\nname = \"c\"\nset = { interrupts = 1 }\n")
    begin = time.monotonic()
    status, said, errors = made_up.command(main, path, "-o", os.path.join(tmp, "stop"), "--threads", "1")
    need(status == 130 and errors == "interrupted: finished runs are kept; the same command goes on\n"
         and time.monotonic() - begin < 30 and not os.path.exists(os.path.join(tmp, "stop", "study.csv")),
         f"Ctrl-C: exit {status} {said} {errors}")


def changes():
    """Changes of a scene's tables reach what is there; places that are not there stay as they are."""
    from grus.runs.scene import put
    table = {"a": [{"b": 1}, {"b": 2}], "c": {"d": 3}}
    for key, text in (("a.1.b", "5"), ("a.2.b", "6"), ("a.x.b", "7"), ("c.d", ""), ("c.e", "words"), ("f.g", "[1]")):
        put(table, key, text)
    need(table == {"a": [{"b": 1}, {"b": 5}], "c": {"e": "words"}, "f": {"g": [1]}}, f"changes of a scene: {table}")


def single_runs(tmp, programs):
    """grus.run: what the program is asked, and what comes of its ends."""
    import grus
    scene, out = write(tmp, "scene.toml", SCENE), os.path.join(tmp, "single")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    asked = grus.read_scene(scene).columns()
    need(asked[:2] == ["axial_strain", "axial_stress_Pa"] and len(asked) == 6, f"columns of a scene: {asked}")
    try:
        grus.run(scene, ["interrupts=1", f'ends="{tmp}/ended"'], out=out + "_stopped")
    except KeyboardInterrupt:
        need(os.path.exists(os.path.join(tmp, "ended")), "Ctrl-C: it is not waited for what the run still writes")
    else:
        need(False, "Ctrl-C is not heard")
    made_up.calls(programs)
    run = grus.run(scene, ["a=7.0", "graded=1"], out=out, threads=3)
    need(made_up.calls(programs) == [f"-o {out} --quiet --threads 3 --set a=7.0 --set graded=1"]
         and run["axial_stress_Pa"][-1] == 0.2 * 7 + 50 * 0.2 * 0.2 and run.folder == out, f"a run: {run}")
    run = grus.run(scene, force=True, out=out)
    need(made_up.calls(programs) == [f"-o {out} --quiet --force"] and os.path.exists(run.folder), "force")
    run = grus.run(scene)
    need(not os.path.exists(run.folder) and len(run["grains"]) == 11, "a temporary folder stays")
    with open(os.path.join(programs, "mpirun"), "w") as f:
        f.write(f'#!/bin/sh\necho "mpirun $1 $2 $(basename $3)" >> {programs}/calls\nshift 2\nexec "$@"\n')
    os.chmod(f.name, 0o755)
    made_up.calls(programs)
    before, os.environ["PATH"] = os.environ["PATH"], programs + os.pathsep + os.environ["PATH"]
    for ranks, wanted in ((1, []), (2, ["mpirun -n 2 grus-rve"])):
        grus.run(scene, ranks=ranks)
        need(made_up.calls(programs)[:-1] == wanted, f"{ranks} ranks")
    os.environ["PATH"] = before
    for changes, kind, words in ((["seed=1", "unstable=[1]"], grus.Unstable, ""),
                                 (["seed=1", "fails=[1]"], RuntimeError, "no room"),
                                 (["a=9.0", "refused_from=5"], grus.InputError, "scene: a: too large")):
        try:
            grus.run(scene, changes)
            need(False, f"{changes}: no error")
        except Exception as e:
            need(type(e) is kind and str(e) == words, f"{changes}: {type(e).__name__} {e}")
    run = grus.run(scene, ["seed=1", "unstable=[1]"], check=False)
    need(run.status == 3 and run.summary["ending"] == "unstable", "a run that became unstable")


def durations():
    from grus.runs import interrupts
    from grus.runs.command import duration_text
    heard = []
    process = lambda name, ago: SimpleNamespace(begun=time.monotonic() - ago,
                                                send_signal=lambda s: heard.append((name, s)))
    interrupts.hand_on([process("old", 3), process("new", 1)])
    os.kill(os.getpid(), signal.SIGUSR1)
    need(heard == [("old", signal.SIGUSR1)], f"who hears of a wish: {heard}")
    need([interrupts.duration(t) for t in ("2 h", "90min", "5", "3 s", "200 ms")] == [7200, 5400, 5, 3, 0.2],
         "durations that people write")
    need([duration_text(s) for s in (5.4, 119, 121, 7199, 7201)] == ["5 s", "119 s", "2 min", "120 min", "2.0 h"],
         "durations that people read")


with tempfile.TemporaryDirectory() as tmp:
    programs = made_up.installation(os.path.join(tmp, "place"), os.path.abspath(sys.argv[1]))
    runs_again(tmp, programs)
    results_read(tmp, programs)
    studies(tmp, programs)
    interrupted(tmp)
    single_runs(tmp, programs)
    changes()
    durations()
print(f"study_runs: {len(faults)} faults")
sys.exit(1 if faults else 0)
