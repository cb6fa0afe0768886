#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the C++ is written: check_style.py format|clang|tidy SOURCE BUILD [--write]

format  every file is as .clang-format wants it
clang   clang++ compiles everything that the build compiles, with its warnings, all of them errors
tidy    .clang-tidy has nothing to say of the files that have changed since they were last seen clean (clean.txt beside this file: their
        digests). --write looks at all files that it does not know and keeps what was clean.
"""
import concurrent.futures
import hashlib
import json
import os
import shlex
import subprocess
import sys
import tempfile

here = os.path.dirname(os.path.abspath(__file__))
manifest = os.path.join(here, "clean.txt")
cores = len(os.sched_getaffinity(0))


def sources(root):
    found = []
    for top in ("dem", "fem", "coupling", "apps", "tests"):
        for folder, _, names in os.walk(os.path.join(root, top)):
            found += [os.path.relpath(os.path.join(folder, n), root) for n in names if n.endswith((".hpp", ".cpp"))]
    return sorted(found)


def commands(root, build):
    """What the build calls for each file; of those that are built for several machines one."""
    with open(os.path.join(build, "compile_commands.json")) as f:
        entries = json.load(f)
    return {os.path.relpath(e["file"], root): e for e in entries}


def each(work, items):
    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        return [fault for faults in pool.map(work, items) for fault in faults]


def format_faults(root, build):
    files = [os.path.join(root, f) for f in sources(root)]
    done = subprocess.run(["clang-format", "--dry-run", "--Werror", *files], capture_output=True, text=True, cwd=root)
    return [line for line in done.stderr.split("\n") if "error:" in line] or ([done.stderr] if done.returncode else [])


GCC_ONLY = ("-Wno-maybe-uninitialized", "-fno-tree-slp-vectorize", "-Wno-uninitialized")


def clang_faults(root, build):
    def compile_one(entry):
        call = shlex.split(entry["command"])
        if "ccache" in os.path.basename(call[0]):
            call = call[1:]
        at = call.index("-o")
        call[at:at + 2] = []
        call = ["clang++", *(c for c in call[1:] if c not in GCC_ONLY), "-Werror", "-fsyntax-only"]
        done = subprocess.run(call, capture_output=True, text=True, cwd=entry["directory"])
        return [done.stderr.strip()] if done.returncode else []
    return each(compile_one, commands(root, build).values())


def digest(root, file):
    """Of a file and of the header of its name."""
    h = hashlib.sha256(open(os.path.join(root, ".clang-tidy"), "rb").read())
    for name in (file, file[:-4] + ".hpp"):
        if os.path.exists(os.path.join(root, name)):
            h.update(open(os.path.join(root, name), "rb").read())
    return h.hexdigest()[:32]


def tidy_faults(root, build, write):
    clean = set(open(manifest).read().split()) if os.path.exists(manifest) else set()
    files = [f for f in commands(root, build) if not f.startswith("tests/")]
    changed = [f for f in sorted(files) if digest(root, f) not in clean]

    scratch = tempfile.TemporaryDirectory()
    entries = [dict(e, command=shlex.join(c for c in shlex.split(e["command"]) if c not in GCC_ONLY)) for e in commands(root, build).values()]
    with open(os.path.join(scratch.name, "compile_commands.json"), "w") as f:
        json.dump(entries, f)

    def look_at(file):
        done = subprocess.run(["clang-tidy", "-p", scratch.name, "--quiet", os.path.join(root, file)], capture_output=True, text=True)
        clean.add(digest(root, file)) if done.returncode == 0 else None
        return [done.stdout.strip() or done.stderr.strip()] if done.returncode else []
    faults = each(look_at, changed)
    if write:
        with open(manifest, "w") as f:
            f.writelines(sorted(f"{digest(root, file)}\n" for file in files if digest(root, file) in clean))
    print(f"tidy: {len(changed)} files looked at")
    return faults


def main():
    what, root, build = sys.argv[1:4]
    root, build = os.path.abspath(root), os.path.abspath(build)
    faults = tidy_faults(root, build, "--write" in sys.argv) if what == "tidy" else {"format": format_faults, "clang": clang_faults}[what](root, build)
    for fault in faults:
        print(fault)
    print(f"{what}: {len(faults)} faults")
    sys.exit(1 if faults else 0)


main()
