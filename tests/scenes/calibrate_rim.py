#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a calibration does with runs and data that are not as they should be: grains that do not break, values that are
refused, bounds, bad fits, files that change, Ctrl-C. calibrate_rim.py BIN"""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from unittest import mock

import numpy as np

binaries = os.path.abspath(sys.argv[1])
sys.path.insert(0, os.path.join(binaries, "..", "python"))
from grus.calibrate import regression  # noqa: E402
from grus.calibrate.targets import Target  # noqa: E402
from grus.runs.censored import places, quantiles  # noqa: E402

here = os.path.dirname(os.path.abspath(__file__))
scenes = os.path.abspath(os.path.join(here, "..", "..", "apps", "scenes"))
faults = []


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message)


def censored():
    """Strengths of which some are only known to be larger: Kaplan and Meier by hand; without any, the places are (k -
    1/2) / n."""
    values, shares = places([3.0, 1.0, 2.0, 4.0], [])
    need(
        np.allclose(values, [1, 2, 3, 4]) and np.allclose(shares, [0.125, 0.375, 0.625, 0.875]),
        f"places of a whole sample {shares}")
    # 1 of 4; then 2.5 leaves the three that are left; 3 is one of two, 4 the last: steps 1/4, 3/8, 3/8.
    values, shares = places([1.0, 3.0, 4.0], [2.5])
    need(np.allclose(shares, [0.125, 0.25 + 0.1875, 0.625 + 0.1875]),
         f"places beside one that is larger than 2.5: {shares}")
    need(np.allclose(quantiles([1.0, 2.0], [9.0, 9.0], [0.125, 0.375, 0.6, 0.9]), [1, 2, 9, 9]),
         "half of the grains never broke")
    # Weibull grains of modulus 3 in tests that end at the same load, a third of them before they break: the quantiles
    # below that stay.
    rng = np.random.default_rng(3)
    strengths = rng.weibull(3.0, 400)
    end = np.quantile(strengths, 2 / 3)
    found = quantiles(strengths[strengths <= end], np.full((strengths > end).sum(), end), [0.1, 0.3, 0.5])
    exact = (-np.log(1 - np.array([0.1, 0.3, 0.5]))) ** (1 / 3)
    need(
        np.allclose(found, np.quantile(strengths, [0.1, 0.3, 0.5]), rtol=0.02) and np.allclose(found, exact, rtol=0.1),
        f"quantiles of a cut sample {found}, {exact}")


def verdicts():
    """A value at its bound, and a fit that is far from its data, are never identified."""
    from types import SimpleNamespace
    result = SimpleNamespace(x=np.array([0.5, 0.0, 1.0]), covariance=1e-4 * np.eye(3))
    words = regression.verdicts(result, ["a", "b", "c"])
    need(words[0] == "identified" and "at its lower bound" in words[1] and "at its upper bound" in words[2],
         f"verdicts at bounds: {words}")
    words = regression.verdicts(result, ["a", "b", "c"], {"grains": 7.9})
    need(not any("identified" == w for w in words) and words[0] == "doubtful; the fit is 7.9 deviations off 'grains'",
         f"verdicts of a bad fit: {words}")


def unbroken(folder):
    """A target of strengths counts grains that did not break, a peak in the last row is told."""
    with open(os.path.join(folder, "s.csv"), "w") as f:
        f.write("value (Pa)\n10\n20\n30\n40\n")
    t = Target({"name": "s", "kind": "quantiles", "data": "s.csv", "quantity": "results.peak_before_breakage_Pa"},
               folder)
    run = lambda broke, most: {
        "columns": {}, "grading": {},
        "summary": {"results": {"peak_axial_stress_Pa": most, **({"peak_before_breakage_Pa": broke} if broke else {})}}
    }
    values, between, n = t.answer([run(10.0, 12.0), run(20.0, 25.0), run(None, 35.0), run(None, 35.0)])
    need(
        np.allclose(values, [10, 20, 35, 35]) and t.told["stronger_than"] == 2 and n == 4
        and np.isfinite(between).all(), f"two grains that did not break: {values} {t.told}")
    t = Target({"name": "p", "kind": "peak", "quantity": "q", "value": 1.0}, folder)
    history = lambda q: {"columns": {"q": q}, "grading": {}, "summary": {}}
    t.answer([history([1, 3, 2]), history([1, 2, 3])])
    need(t.told["still_rising"] == 1, f"a peak that is the last row: {t.told}")


def installation(folder, command, rve):
    """The folder of programs of an installation that has this command, and a script in the place of grus-rve."""
    shutil.copytree(os.path.join(binaries, "..", "python"), os.path.join(folder, "python"))
    programs = os.path.join(folder, "bin")
    os.makedirs(programs)
    shutil.copy(os.path.join(binaries, command), programs)
    with open(os.path.join(programs, "grus-rve"), "w") as f:
        f.write(rve)
    os.chmod(f.name, 0o755)
    return programs


def refused_inside(tmp):
    """A value inside the ranges that the program refuses is a failed point and not the end; bounds may differ in their
    units."""
    path = os.path.join(tmp, "box.toml")
    with open(path, "w") as f:
        f.write(f"""[calibrate]
scene = "{os.path.join(scenes, 'single_grain.toml')}"
budget = 10
seeds = [10]
seed_key = "numerics.fracture_every"
check = false
set = {{ "output.frames" = 0, "loading.final_strain" = 0.02, "loading.strain_rate" = 1000.0 }}
parameters = [ {{ key = "material.sand.youngs_modulus", min = "0.03 TPa", max = "120 GPa", scale = "log" }} ]
targets = [ {{ name = "end", kind = "value", quantity = "axial_stress_Pa", value = 1e8, error = 1e6 }} ]
""")
    # It refuses a modulus from 50 to 60 GPa.
    fake = installation(os.path.join(tmp, "picky"), "grus-calibrate", f"""#!/bin/sh
case "$*" in *--columns*) ;; *youngs_modulus=*0.05[0-9]*) echo "scene: youngs_modulus: refused" >&2; exit 2;; esac
exec {os.path.join(binaries, 'grus-rve')} "$@"
""")
    r = subprocess.run([os.path.join(fake, "grus-calibrate"), path, "-o",
                        os.path.join(tmp, "box")], capture_output=True, text=True, timeout=280)
    need(r.returncode == 0, f"a value that is refused inside the ranges: exit {r.returncode}: {r.stderr}")
    if r.returncode == 0:
        with open(os.path.join(tmp, "box", "calibration.json")) as f:
            found = json.load(f)
        need(0 < found["refused_points"] < found["points"] and "refused" in found["refusal"],
             f"{found['refused_points']} of {found['points']} points refused")
        need("points were refused" in r.stdout, f"not told: {r.stdout}")
        need(0.03 <= found["parameters"][0]["value"] <= 0.12 and found["parameters"][0]["unit"] == "TPa",
             f"bounds in two units: {found['parameters']}")


def interrupted_check(tmp):
    """Ctrl-C while the cases of a study are checked: at once, one line, 130."""
    path = os.path.join(tmp, "slow.toml")
    with open(path, "w") as f:
        f.write(f'[study]\nscene = "{os.path.join(scenes, "single_grain.toml")}"\n' +
                "".join(f'[[case]]\nname = "c{k}"\n' for k in range(4)))
    slow = installation(os.path.join(tmp, "slow"), "grus-study", f"#!/bin/sh\ntouch {tmp}/begun\nexec sleep 60\n")
    process = subprocess.Popen([os.path.join(slow, "grus-study"), path, "-o",
                                os.path.join(tmp, "slow_out")], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
    for _ in range(600):
        time.sleep(0.05)
        if os.path.exists(os.path.join(tmp, "begun")):
            break
    start = time.time()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=50)
    need(process.returncode == 130 and errors.count("\n") == 1 and time.time() - start < 10,
         f"Ctrl-C in a check: exit {process.returncode} after {time.time() - start:.0f} s: {errors!r}")


def late_stop():
    """A stop that comes while a program is being started reaches it, too."""
    from grus.runs.runner import Runner
    runner, begins = Runner("", "seed", "", {}), subprocess.Popen
    runner.command = lambda case, seed: ["sleep", "40"]

    def stopped_as_it_begins(*given, **more):
        process = begins(*given, **more)
        runner.stop()
        return process

    start = time.time()
    with mock.patch("subprocess.Popen", stopped_as_it_begins):
        status = runner.ask({}, 1)[0]
    need(status == -signal.SIGTERM and time.time() - start < 20, f"stopped as it began: {status}")


def hashed(tmp):
    """The key of a run changes with every file that the run reads, and with nothing else."""
    from grus.runs.kept import key_of
    from grus.runs.runner import Runner
    write = lambda name, text: open(os.path.join(tmp, name), "w").write(text)
    write("scene.toml", '[mesh]\nfile = "m.msh"\n[rve]\nscene = "cell.toml"\n')
    write("cell.toml", '[packing]\npath = "p.txt"\n'), write("other.toml", '[packing]\npath = "q.txt"\n')
    for name in ("m.msh", "p.txt", "q.txt", "unread.txt", "program"):
        write(name, "1")
    case = {"scene": os.path.join(tmp, "scene.toml"), "set": {"rve.scene": "other.toml", "rve.set": ["x.path=r.txt"]}}
    write("r.txt", "1")
    key = lambda: key_of(case, 1, "packing.seed", os.path.join(tmp, "program"))
    first = key()
    for name in ("scene.toml", "cell.toml", "other.toml", "m.msh", "p.txt", "q.txt", "r.txt", "program"):
        before = open(os.path.join(tmp, name)).read()
        write(name, before + "\n")
        need(key() != first, f"{name} may change and the run is not done again")
        write(name, before)
    write("unread.txt", "2")
    need(key() == first, "a file that no run reads has changed the key")
    runner = Runner("out", "packing.seed", "bin", {})
    folders = [
        runner.folder({"name": n}, s) for n, s in (("a", None), ("a", 1), ("a_s1", None), ("a-s1", None), ("a", "1"),
                                                   ("a", "1/2"), ("a", "1_2"), ("a", [1, 2]))
    ]
    need(len(set(folders)) == len(folders), f"runs that share a folder: {folders}")


censored()
verdicts()
with tempfile.TemporaryDirectory() as folder:
    unbroken(folder)
    hashed(folder)
    refused_inside(folder)
    interrupted_check(folder)
late_stop()
print("calibrate_rim:", len(faults), "faults")
sys.exit(bool(faults))
