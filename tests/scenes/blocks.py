#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Each block of README and docs/ is run, here or by the test that is named, or is plainly text: blocks.py BUILD"""
import glob
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from scene_tools import faults, need

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
environment = {**os.environ, "PATH": os.path.join(build, "bin") + os.pathsep + os.environ["PATH"]}
COMMAND = re.compile(r"\s*(\./|build|cmake|ctest|mpirun|srun|python3|gmsh|grus[ -])")
# Blocks that another test takes from their page and runs.
ELSEWHERE = {("README.md", "sh"): "scenes/readme.py", ("README.md", "toml"): "scenes/readme.py",
             ("docs/library.md", "cmake"): "tools/check_install.py",
             ("docs/library.md", "cpp"): "tools/check_install.py",
             ("docs/extending.md", None): "scenes/extending.py",
             ("docs/tutorial.md", None): "scenes/tutorial.py", ("docs/stages.md", None): "scenes/recipes.py",
             ("docs/walls.md", None): "scenes/recipes.py",
             ("docs/howto/from_other_programs.md", None): "scenes/recipes.py"}
# Pages whose named blocks are files of one folder, in which the page's commands are asked whether they would run.
WALKED = {"docs/howto/data_to_scene.md", "docs/tutorial_rock.md"}
# Pages whose blocks are parts of a program that another test runs.
PARTS = {"docs/tutorial_dolfinx.md": "apps/python/demos/block_dolfinx.py"}
# What a table of a page lacks to be a whole scene.
LOADING = '[loading]\nkind = "platens"\naxis = "y"\nstrain_rate = "1 /s"\nfinal_strain = 0.0018\n'
DATA = {"e_sigma.csv": "axial_stress_Pa,void_ratio\n1e6,0.8\n2e6,0.75\n",
        "sieve.csv": "diameter_m,passing\n0.0003,0.2\n0.001,1\n", "grains.csv": "value\n1e8\n1.2e8\n1.4e8\n"}


def shell(line, folder):
    r = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    need(r.returncode == 0 and r.stderr == "", f"{line}: exit {r.returncode} {r.stdout[-200:]} {r.stderr[-300:]}")
    return r.stdout


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as f:
        f.write(text)


def bonded(folder, block):
    write(folder, "bonded.toml", block + LOADING)
    said = shell("grus-rve bonded.toml --check", folder)
    need("grains 1500" in said, "docs/bonded.md: not the cells that it asks for")


def calibration(folder, block):
    for name, text in DATA.items():
        write(folder, name, text)
    write(folder, "calibration.toml", block)
    shutil.copy(os.path.join(source, "apps", "scenes", "single_grain.toml"), folder)
    shell("grus-rve --new oedometer && sed -i '/^seed = /d' oedometer.toml", folder)
    said = shell("grus-calibrate calibration.toml --check", folder)
    points = re.search(r"(\d+) points", block)[1]
    need(f"\n{points} points" in said, f"docs/calibration.md says {points} points, the program: {said}")


def whole(folder, block):
    """A scene that lacks nothing, beside the shipped ones."""
    for scene in glob.glob(f"{source}/apps/scenes/*.toml"):
        shutil.copy(scene, folder)
    write(folder, "scene.toml", block)
    program = "grus-bvp" if "[mesh]" in block else "grus-rve"
    if os.path.exists(os.path.join(build, "bin", program)):
        shell(f"{program} scene.toml --check", folder)


def implicit(folder, block):
    """A table that a shipped scene lacks."""
    with open(f"{source}/apps/scenes/angular_rve.toml") as f:
        write(folder, "implicit.toml", f.read() + "\n" + block)
    shell("grus-rve implicit.toml --check", folder)


TABLES = {"docs/physics/implicit.md": implicit, "docs/scenes.md": whole, "docs/macro.md": whole,
          "docs/bonded_spheres.md": whole,
          "docs/bonded.md": bonded, "docs/cleavage.md": whole, "docs/calibration.md": calibration}


# Runs tell their columns, which takes no forecast of their time.
ASKED = {"grus run": "--columns", "grus-rve": "--columns", "grus-bvp": "--columns", "grus study": "--check",
         "grus-study": "--check", "grus calibrate": "--check", "grus-calibrate": "--check"}


def command(page, line):
    """A program of ours is asked whether it would run; of other commands, what they name must be there."""
    words = line.split("#")[0].split()
    if not words:
        return
    if words[0].startswith("grus"):
        name = " ".join(words[:2]) if words[0] == "grus" else words[0]
        if name != "grus-bvp" or os.path.exists(os.path.join(build, "bin", "grus-bvp")):
            shell(" ".join([*words, ASKED.get(name, "")]), source)
        return
    for preset in re.findall(r"--preset (\S+)", line):
        known = json.load(open(os.path.join(source, "CMakePresets.json")))
        need(preset in {p["name"] for p in known["configurePresets"]}, f"{page}: no preset {preset}")
    program = words[0]
    stem = os.path.basename(program).removeprefix("grus_")
    sources = glob.glob(f"{source}/tests/bench/{stem}*.cpp") or glob.glob(os.path.join(source, program))
    if program != "cmake":
        text = "".join(open(path).read() for path in sources)
        need(text != "", f"{page}: what is {program}?")
        known = all(w in text for w in words if w.startswith("--"))
        need(known, f"{page}: {program} does not know all of {words}")


def python(page, folder, block):
    """A block of Python runs beside the shipped scenes, and says what the page says that it does."""
    for scene in glob.glob(f"{source}/apps/scenes/*.toml"):
        shutil.copy(scene, folder)
    write(folder, "block.py", block)
    said = shell(f"PYTHONPATH={build}/python /usr/bin/python3 block.py", folder)
    text = open(os.path.join(source, page)).read()
    after = text[text.index(block) + len(block):]
    expected = re.match(r"```\n\nIt says `(.*?)`", after) or re.search(r"says `(.*?)`", text)
    need(expected is None or said == expected[1] + "\n", f"{page}: its block of Python says {said!r}")


def walk(page, found):
    with tempfile.TemporaryDirectory() as at:
        for kind, name, block in found:
            need(kind == "sh" or name, f"{page}: a block without a name: {block[:60]!r}")
            if name:
                write(at, name, block)
            else:
                for line in block.splitlines():
                    shell(line if line.startswith("grus check ") else line + " --check", at)


seen = set()
with tempfile.TemporaryDirectory() as folder:
    for path in [f"{source}/README.md"] + sorted(glob.glob(f"{source}/docs/**/*.md", recursive=True)):
        page = os.path.relpath(path, source)
        text = open(path).read()
        if page in WALKED:
            walk(page, re.findall(r"^```(\w+) ?(\S*)\n([\s\S]*?)^```$", text, re.M))
            continue
        for kind, block in re.findall(r"^```(\w*).*\n([\s\S]*?)^```$", text, re.M):
            test = ELSEWHERE.get((page, kind), ELSEWHERE.get((page, None)))
            if test:
                reads = open(os.path.join(source, "tests", test)).read()
                need(os.path.basename(page) in reads, f"{test} does not read {page}")
                seen.add(page)
            elif kind in ("", "text", "csv"):
                commands = any(COMMAND.match(line) for line in block.splitlines())
                need(not commands, f"{page}: commands in a block of text: {block[:60]!r}")
            elif kind == "toml" and page in TABLES:
                TABLES[page](folder, block)
                seen.add(page)
            elif kind == "sh" and block.startswith("#!"):  # a job's script
                write(folder, "job.sh", block)
                shell("bash -n job.sh", folder)
            elif kind == "sh":
                for line in block.replace("\\\n", " ").splitlines():
                    command(page, line)
            elif kind == "python" and page in PARTS:
                program = open(os.path.join(source, PARTS[page])).read()
                need(block in program, f"{page}: not a part of {PARTS[page]}: {block[:60]!r}")
            elif kind == "python":
                python(page, folder, block)
                seen.add(page)
            else:
                need(False, f"{page}: no test runs this block of {kind}: {block[:60]!r}")
need(seen >= set(TABLES) | {page for page, _ in ELSEWHERE}, f"blocks that are no longer there: {seen}")
print(f"blocks: {len(faults)} faults")
sys.exit(1 if faults else 0)
