#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/extending.md as a reader would take it: its patches apply to a copy of the tree, in their order; what they touch
compiles; its programs, linked with the library as it is built, say that all is well: extending.py BUILD"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

from scene_tools import faults, need

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tools"))
from compile_calls import compile_calls  # noqa: E402

build = os.path.abspath(sys.argv[1])
source = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = "docs/extending.md"
page = open(os.path.join(source, PAGE)).read()


def run(command, folder):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)


def calls():
    """What the build calls for each file, without launchers and output."""
    found = {}
    for entry in compile_calls(build):
        call = shlex.split(entry["command"])
        call = call[next(k for k, word in enumerate(call) if os.path.basename(word).startswith(("c++", "g++"))):]
        at = call.index("-o")
        found[os.path.relpath(entry["file"], source)] = call[:at] + call[at + 2:]
    return found


def compile_there(tree, call):
    """Looks at a file of the copy: the paths of the tree in the call are the copy's."""
    words = [re.sub(f"(^|-I){re.escape(source)}(?=/|$)", lambda m: m[1] + tree, word)
             if not word.startswith(f"-I{build}") and build not in word else word for word in call]
    return run([*words, "-fsyntax-only", "-O0"], tree)


def apply(tree, patch):
    """The files that a patch changes or adds; none where it does not apply."""
    path = os.path.join(tree, "one.diff")
    with open(path, "w") as f:
        f.write(patch)
    done = run(["patch", "-p1", "--fuzz=0", "--no-backup-if-mismatch", "-i", path], tree)
    need(done.returncode == 0, f"{PAGE}: a patch does not apply: {done.stdout[-300:]} {done.stderr[-200:]}")
    return re.findall(r"^\+\+\+ b/(\S+)", patch, re.M) if done.returncode == 0 else []


def check_program(title, part, tree, name, program):
    """Built against the changed headers and the library as it is; it must print what the page says."""
    with open(name + ".cpp", "w") as f:
        f.write(program)
    call = known["dem/base/tensor.cpp"]
    flags = [w for k, w in enumerate(call) if w.startswith(("-std", "-D")) or "-isystem" in call[max(k - 1, 0):k + 1]]
    library = os.path.join(build, "dem", "libgrus_dem.a")
    done = run(["c++", "-Wall", "-Wextra", *flags, "-I", tree, name + ".cpp", library, "-lfmt", "-o", name], tree)
    need(done.returncode == 0 and done.stderr == "", f"{PAGE}: {title}: its program: {done.stderr[:600]}")
    if done.returncode == 0:
        done = run([name], tree)
        told = re.findall(r"It prints `([^`]+)`", part)
        need(done.returncode == 0, f"{PAGE}: {title}: its program ends with {done.returncode}: {done.stdout}")
        need(done.stdout.strip() in told, f"{PAGE}: {title}: its program prints {done.stdout!r}, the page {told}")


known = calls()
with tempfile.TemporaryDirectory() as tmp:
    tree = os.path.join(tmp, "tree")
    for room in ("dem", "fem", "coupling", "apps", "tests"):
        shutil.copytree(os.path.join(source, room), os.path.join(tree, room))
    for part in re.split(r"^## ", page, flags=re.M)[1:]:
        title = part.split("\n")[0]
        touched = [file for patch in re.findall(r"```diff\n(.*?)```", part, re.S) for file in apply(tree, patch)]
        need(touched, f"{PAGE}: {title}: no patch")
        compiled = re.findall(r"`([^`]+\.cpp)`", "".join(re.findall(r"The test compiles [^.]*\.cpp`[^:]*", part)))
        for file in touched + compiled:
            need(file in known or file not in compiled, f"{PAGE}: {title}: the build does not know {file}")
            if file.endswith(".cpp") and file in known:
                done = compile_there(tree, known[file])
                need(done.returncode == 0, f"{PAGE}: {title}: {file}: {done.stderr[:600]}")
        for number, program in enumerate(re.findall(r"```cpp\n(.*?)```", part, re.S)):
            check_program(title, part, tree, os.path.join(tmp, f"program{number}"), program)
print(f"extending: {len(faults)} faults")
sys.exit(1 if faults else 0)
