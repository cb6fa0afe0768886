#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that users bring, changed by meaning: user_files.py BIN COUNT SEED|today

With "today" the seed is another each day; it is told, and the same number draws the same files again.

Each kind of file is a module with draw(rng, folder, binaries) -> Case: it writes one file in a way that people write
such files, and says what numbers it means. A case is read as these numbers, or it is refused in one line that names the
file; never anything else. What must be read (`must_read`) may not be refused, what must be refused may not be read.
A new kind: a module with draw, and its name in KINDS."""
import datetime
import importlib
import os
import random
import sys
import tempfile
from collections import Counter

KINDS = ["user_csv", "user_packings", "user_meshes"]
SLOW = ["user_meshes"]  # half a second each, for MPI to begin: one case in eight


def judge(case):
    """What is wrong with how a case was taken; None: nothing."""
    kind, found = case.read()
    if kind == "refused":
        if case.must_read:
            return f"refused: {found}"
        if "\n" in found.strip() or case.name not in found:
            return f"not refused in one line that names the file: {found!r}"
        return None
    if kind != "read":
        return f"{kind}: {found}"
    if case.must_refuse:
        return f"read as {found}"
    if len(found) != len(case.means) or any(abs(a - b) > 1e-9 * max(abs(b), 1e-300) for a, b in zip(found, case.means)):
        return f"read as {found} instead of {case.means}"
    return None


def main():
    binaries, count = os.path.abspath(sys.argv[1]), int(sys.argv[2])
    seed = datetime.date.today().toordinal() if sys.argv[3] == "today" else int(sys.argv[3])
    sys.path.insert(0, os.path.join(binaries, "..", "python"))
    modules = [importlib.import_module(k) for k in KINDS]
    modules = [m for m in modules if os.path.exists(os.path.join(binaries, getattr(m, "PROGRAM", "grus-rve")))]
    faults, seen = 0, Counter()
    slow = [m for m in modules if m.__name__ in SLOW]
    quick = [m for m in modules if m not in slow]
    with tempfile.TemporaryDirectory() as folder:
        for k in range(count):
            module = slow[k // 8 % len(slow)] if slow and k % 8 == 0 else quick[k % len(quick)]
            case = module.draw(random.Random(f"{seed} {k}"), folder, binaries)
            seen.update(case.did)
            fault = judge(case)
            if fault:
                faults += 1
                print(f"FAULT case {k} ({module.__name__}: {', '.join(case.did)}): {fault}")
    for module in modules:  # every way of writing was tried
        missing = [way for way in module.WAYS if seen[way] == 0]
        if missing and count >= 200:
            faults += 1
            print(f"FAULT {module.__name__}: never drawn: {', '.join(missing)}")
    print(f"user files: {count} cases of seed {seed}, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
