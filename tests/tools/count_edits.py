#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What additions have touched, counted from git: count_edits.py [--check]

Prints the table of docs/architecture.md; with --check, exit 1 if the page says otherwise (77 where git's history is not
there). Counted are files of the product, source and build, that were there before and were edited, and new ones.
"""
import os
import re
import subprocess
import sys

root = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
ADDITIONS = [
    ("face bonds: a kind of bond with three criteria", ["8dd3fdb"]),
    ("fourteen balls: splitter, criterion, scatter, rest, fines", ["61690c6"]),
    ("convex hulls: a kind of shape", ["1650514", "9ad8055"]),
    ("clamps, dead loads, rollers, a constant mean stress, glued walls", ["2a45027"]),
    ("cleavage: a criterion and a splitter of hulls, their fresh faces", ["4600648"]),
    ("resistance to rolling, and mixtures", ["267f957"]),
    ("JKR: a contact law with attraction, the first through its seam", ["514d0a2"]),
]
PRODUCT = re.compile(r"(apps|coupling|dem|fem)/.*(\.cpp|\.hpp|\.py|keys\.txt|CMakeLists\.txt)$")


def git(*words):
    return subprocess.run(["git", "-C", root, *words], capture_output=True, text=True)


def files(commits, kind):
    """Files of one kind of change; one that an earlier commit of the addition made is not an edit."""
    found = set()
    for commit in commits:
        done = git("show", "--name-only", "--no-renames", f"--diff-filter={kind}", "--format=", commit)
        if done.returncode:
            print(f"count_edits: git does not know {commit}")
            sys.exit(77)
        found |= {f for f in done.stdout.split("\n") if PRODUCT.match(f)}
    return found


def table():
    rows = ["| addition | existing files edited | new files | commit |", "|---|---|---|---|"]
    for what, commits in ADDITIONS:
        new = files(commits, "A")
        rows.append(f"| {what} | {len(files(commits, 'M') - new)} | {len(new)} | {', '.join(commits)} |")
    return "\n".join(rows)


def main():
    if git("rev-parse", "--git-dir").returncode:
        print("count_edits: no git history here")
        sys.exit(77)
    counted = table()
    if "--check" not in sys.argv:
        print(counted)
        return
    with open(os.path.join(root, "docs", "architecture.md")) as f:
        holds = counted in f.read()
    print("count_edits: the page holds the table" if holds else f"docs/architecture.md lacks this table:\n{counted}")
    sys.exit(0 if holds else 1)


main()
