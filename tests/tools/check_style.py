#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the C++ and the Python are written: check_style.py format|clang|tidy|python SOURCE BUILD [--write]

format  every C++ file is as .clang-format wants it
clang   clang++ compiles everything that the build compiles, with its warnings, all of them errors
tidy    .clang-tidy has nothing to say of the product
python  flake8 and isort have nothing to say, mypy nothing of the package grus (python_style.cfg)

clang and tidy look at what has changed since it was last seen clean (seen_by_*.txt beside this file: digests of the
code without its comments; for clang of a file with all of the project that it includes, for tidy of a file and the
header of its name). --write keeps what was clean.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

from compile_calls import compile_calls

here = os.path.dirname(os.path.abspath(__file__))
cores = len(os.sched_getaffinity(0))


def sources(root, endings=(".hpp", ".cpp")):
    found = []
    for top in ("dem", "fem", "coupling", "apps", "docs", "tests"):
        for folder, _, names in os.walk(os.path.join(root, top)):
            found += [os.path.relpath(os.path.join(folder, n), root) for n in names if n.endswith(endings)]
    return sorted(found)


def commands(root, build):
    """What the build calls for each file; of those that are built for several machines one."""
    return {os.path.relpath(e["file"], root): e for e in compile_calls(build)}


def each(work, items):
    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        return [fault for faults in pool.map(work, items) for fault in faults]


def format_faults(root):
    files = [os.path.join(root, f) for f in sources(root)]
    done = subprocess.run(["clang-format", "--dry-run", "--Werror", *files], capture_output=True, text=True, cwd=root)
    return [line for line in done.stderr.split("\n") if "error:" in line] or ([done.stderr] if done.returncode else [])


def python_faults(root, build):
    """Of the package as the build has it: only there it knows its version."""
    files, settings = [os.path.join(root, f) for f in sources(root, ".py")], os.path.join(here, "python_style.cfg")
    calls = [(["flake8", "--config", settings, *files], root),
             (["isort", "--settings-file", settings, "--check-only", *files], root),
             (["mypy", "--config-file", settings, "--cache-dir",
               os.path.join(build, "mypy"), "-p", "grus"], os.path.join(build, "python"))]
    done = [subprocess.run(call, capture_output=True, text=True, cwd=folder) for call, folder in calls]
    return [line for d in done if d.returncode for line in (d.stdout + d.stderr).splitlines()]


GCC_ONLY = ("-Wno-maybe-uninitialized", "-fno-tree-slp-vectorize", "-Wno-uninitialized")


def without_gcc(command):
    """The call for clang: without launchers and g++'s own options."""
    call = shlex.split(command)
    call = call[next(k for k, word in enumerate(call) if os.path.basename(word).startswith(("c++", "g++", "clang++"))):]
    return [word for word in call if word not in GCC_ONLY]


def included(root, file, seen):
    """A file and all of the project that it includes."""
    if file not in seen and os.path.exists(os.path.join(root, file)):
        seen.add(file)
        for name in re.findall(r'#include "([^"]+)"', open(os.path.join(root, file)).read()):
            included(root, name, seen)
    return seen


TEXT_OR_COMMENT = re.compile(r'R"\((?:.|\n)*?\)"|"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*(?:.|\n)*?\*/')


def code_of(text):
    """Without comments and with one blank for all that is none: neither compiler nor clang-tidy looks at more, but for
    NOLINT."""
    kept = TEXT_OR_COMMENT.sub(lambda m: m[0] if m[0][0] in 'R"' or "NOLINT" in m[0] else " ", text)
    return " ".join(kept.split())


def digest(root, files, settings):
    h = hashlib.sha256(settings.encode())
    for name in sorted(files):
        with open(os.path.join(root, name)) as f:
            h.update((name + "\0" + code_of(f.read())).encode())
    return h.hexdigest()[:32]


def unless_seen(root, tool, digests, look_at, write):
    """Faults of the files whose digests are not known."""
    manifest = os.path.join(here, f"seen_by_{tool}.txt")
    clean = set(open(manifest).read().split()) if os.path.exists(manifest) else set()
    changed = [file for file in sorted(digests) if digests[file] not in clean]
    faults = {}

    def look(file):
        faults[file] = look_at(file)
        return faults[file]
    found = each(look, changed)
    print(f"{tool}: {len(changed)} of {len(digests)} files looked at")
    if write:
        with open(manifest, "w") as f:
            f.writelines(sorted(f"{digests[file]}\n" for file in digests if not faults.get(file)))
    return found


def clang_faults(root, build, write):
    entries = commands(root, build)

    def compile_one(file):
        call = without_gcc(entries[file]["command"])
        at = call.index("-o")
        call[at:at + 2] = []
        call = ["clang++", *call[1:], "-Werror", "-fsyntax-only"]
        done = subprocess.run(call, capture_output=True, text=True, cwd=entries[file]["directory"])
        return [done.stderr.strip()] if done.returncode else []
    warnings = " ".join(c for c in without_gcc(entries["dem/base/parallel.cpp"]["command"]) if c.startswith("-W"))
    digests = {file: digest(root, included(root, file, set()), warnings) for file in entries}
    return unless_seen(root, "clang", digests, compile_one, write)


def tidy_faults(root, build, write):
    scratch = tempfile.TemporaryDirectory()
    entries = {file: e for file, e in commands(root, build).items() if not file.startswith("tests/")}
    for e in entries.values():
        e["command"] = shlex.join(without_gcc(e["command"]))
    with open(os.path.join(scratch.name, "compile_commands.json"), "w") as f:
        json.dump(list(entries.values()), f)

    def look_at(file):
        done = subprocess.run(["clang-tidy", "-p", scratch.name, "--quiet",
                               os.path.join(root, file)], capture_output=True, text=True)
        return [done.stdout.strip() or done.stderr.strip()] if done.returncode else []
    settings = open(os.path.join(root, ".clang-tidy")).read()
    digests = {
        file: digest(root, [f for f in (file, file[:-4] + ".hpp") if os.path.exists(os.path.join(root, f))], settings)
        for file in entries
    }
    return unless_seen(root, "tidy", digests, look_at, write)


def main():
    what, root, build = sys.argv[1:4]
    root, build, write = os.path.abspath(root), os.path.abspath(build), "--write" in sys.argv
    if what in ("clang", "tidy"):
        faults = {"clang": clang_faults, "tidy": tidy_faults}[what](root, build, write)
    else:
        faults = python_faults(root, build) if what == "python" else format_faults(root)
    for fault in faults:
        print(fault)
    print(f"{what}: {len(faults)} faults")
    sys.exit(1 if faults else 0)


main()
