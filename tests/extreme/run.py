#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Extreme cases, side by side on two cores: run.py fast|slow|all BIN [--write docs/stability.md] [NAME...]"""
import os
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

import bench
import cells  # noqa: F401  registers its cases, as do the others
import contacts  # noqa: F401
import grains  # noqa: F401
import inputs  # noqa: F401
import macro  # noqa: F401

which, bench.binaries = sys.argv[1], os.path.abspath(sys.argv[2])
write = sys.argv[sys.argv.index("--write") + 1] if "--write" in sys.argv else None
names = [a for a in sys.argv[3:] if a not in ("--write", write)]
fem = os.path.exists(os.path.join(bench.binaries, "grus-bvp"))
chosen = [
    c for c in bench.cases if (which == "all" or c["slow"] == (which == "slow")) and (
        not names or c["name"] in names) and (fem or c["run"].__module__ != "macro")
]


def judge(c):
    start = time.time()
    with tempfile.TemporaryDirectory() as tmp:
        try:
            measured, passed = c["run"](tmp)
        except Exception as e:  # a case that cannot even be measured has failed
            measured, passed = f"{type(e).__name__}: {e}", False
    print(f"{'ok  ' if passed else 'FAIL'} {c['name']}: {measured}   ({time.time() - start:.1f} s)", flush=True)
    return measured, passed


with ThreadPoolExecutor(2) as pool:
    results = list(pool.map(judge, chosen))
if write:
    head = open(write).read().split("\n| ")[0] if os.path.exists(write) else "# Stability\n"
    with open(write + ".new", "w") as f:
        f.write(head.rstrip("\n") + "\n\n| | case | must hold | measured | |\n|---|---|---|---|---|\n")
        for k, (c, (measured, passed)) in enumerate(zip(chosen, results)):
            text = measured.replace("|", "/")
            f.write(
                f"| {k + 1} | {c['title']}{' (slow set)' if c['slow'] else ''} | {c['holds']} | {text} | "
                f"{'pass' if passed else '**FAIL**'} |\n"
            )
    os.replace(write + ".new", write)
failed = sum(not passed for _, passed in results)
print(f"extreme: {len(results)} cases, {failed} failed")
sys.exit(1 if failed or not results else 0)
