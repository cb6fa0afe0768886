#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The README as a user takes it: its scene, and every command line that it prints: readme.py scene|demo|dem-only
BUILD"""
import json
import os
import re
import subprocess
import sys
import tempfile

from scene_tools import faults, history, need

case, build = sys.argv[1], os.path.abspath(sys.argv[2])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
readme = open(os.path.join(source, "README.md")).read()
full = os.path.exists(os.path.join(build, "bin", "grus-bvp"))

SCENE = "build/bin/grus run scene.toml && build/bin/grus report scene"
WORDS = 1000  # it stays short
DEM = "cmake --workflow --preset dem-only"
# What is printed, and by which case of this test it is run. The tests themselves are being run.
SITE = "cmake --build build --target docs"  # what it calls: the test documents
KNOWN = {SCENE: "scene", "ctest --test-dir build -L validation": "scene", SITE: None,
         "./bootstrap demo": "demo", "./bootstrap test": None, DEM: "dem-only"}


def shell(command, cwd, **environment):
    return subprocess.run(["bash", "-c", command], cwd=cwd, capture_output=True, text=True, timeout=1500,
                          env={**os.environ, **environment})


def scene(tmp):
    need(len(readme.split()) <= WORDS, f"the README has {len(readme.split())} words, more than {WORDS}")
    blocks = re.findall(r"```sh\n(.*?)```", readme, re.S)
    printed = {line.split("#")[0].strip() for block in blocks for line in block.splitlines() if line.strip()}
    printed |= {
        c for c in re.findall(r"`([^`\n]+)`", readme)
        if re.match(r"(\./|build/|[A-Z_]+=\S+ |ctest |cmake |mpirun |grus-\w+ +[-\w./]+\.toml)", c) and " " in c
    }
    need(printed == set(KNOWN),
         f"commands that the README prints and this test does not run, or the other way round: {printed ^ set(KNOWN)}")
    text = re.search(r"```toml\n(.*?)```", readme, re.S).group(1)
    need(text == open(os.path.join(source, "apps", "scenes", "sand_box.toml")).read(),
         "the README's scene is not apps/scenes/sand_box.toml")
    os.symlink(build, os.path.join(tmp, "build"))
    open(os.path.join(tmp, "scene.toml"), "w").write(text)
    r = shell(SCENE, tmp)
    need(r.returncode == 0 and r.stderr == "", f"the README's scene: exit {r.returncode} {r.stderr}")
    last = history(os.path.join(tmp, "scene"))[-1]
    need(
        abs(float(last["axial_strain"]) - 0.16) < 1e-9 and float(last["breakages"]) > 500
        and abs(float(last["energy_error"])) < 0.01,
        f"the README's scene ends at {last['axial_strain']}, {last['breakages']} breakages")
    need(os.path.getsize(os.path.join(tmp, "scene", "report.html")) > 50000, "no report")
    rows = history(os.path.join(tmp, "scene"))
    facts = [f"crushes {rows[0]['grains']} grains", f"stress is {float(last['axial_stress_Pa']) / 1e6:.0f} MPa",
             f"from {float(rows[0]['void_ratio']):.2f} to {float(last['void_ratio']):.2f}", f"{len(rows)} rows",
             f"broken {int(last['breakages']):,} times"]
    need(all(fact in readme for fact in facts), f"the README's figures are not those of its scene: {facts}")
    r = shell("ctest --test-dir build -L validation -N", tmp)
    need(r.returncode == 0 and "shpb_full" in r.stdout, f"the validation set: {r.stdout[-200:]} {r.stderr}")


def demo(tmp):
    """In the tree itself, its results elsewhere."""
    if build != os.path.join(source, "build"):
        return print("another build folder than the README's: nothing to run")
    r = shell("./bootstrap demo", source, GRUS_RESULTS=os.path.join(tmp, "results"))
    need(r.returncode == 0, f"./bootstrap demo: exit {r.returncode} {r.stdout[-500:]} {r.stderr[-500:]}")
    for name in ["shpb", "single_grain"] + (["oedometer"] if full else []):
        need(json.load(open(os.path.join(tmp, "results", name, "summary.json")))["status"] == 0, f"demo: {name}")
    need(os.path.getsize(os.path.join(tmp, "results", "report.html")) > 200000, "demo: no report")


def dem_only(tmp):
    r = shell(DEM, source)
    need(r.returncode == 0 and "100% tests passed" in r.stdout,
         f"{DEM}: exit {r.returncode} {r.stdout[-1500:]} {r.stderr[-500:]}")
    need(not os.path.exists(os.path.join(source, "build-dem", "bin", "grus-bvp")), "the DEM alone has built grus-bvp")


with tempfile.TemporaryDirectory() as tmp:
    {"scene": scene, "demo": demo, "dem-only": dem_only}[case](tmp)
print(f"readme {case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
