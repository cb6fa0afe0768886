#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The tree's guard rails: includes only go down, files stay short, no lost words."""
import os
import re
import sys

root = sys.argv[1]
floor = {"dem/base": 0, "dem/kernel": 1, "dem/shape": 1, "dem/state": 2, "dem/contact": 3, "dem/bond": 3, "dem/fracture": 4, "dem/motion": 4, "dem/rve": 5, "dem/packing": 6, "dem/io": 6, "dem/rves": 7,
         "fem": 10, "coupling": 20, "apps/scene": 30, "apps/library/grus": 31, "apps/run": 31, "apps/bvp/scene": 31, "apps/rve": 32, "apps/bvp": 32, "apps/python": 33}
faults = []


def room(path):
    folder = os.path.dirname(path)
    return folder if folder in floor else None


for top in ("dem", "fem", "coupling", "apps", "tests"):
    for folder, _, names in os.walk(os.path.join(root, top)):
        for name in names:
            path = os.path.relpath(os.path.join(folder, name), root)
            if not name.endswith((".hpp", ".cpp", ".py")) or "__pycache__" in path:
                continue
            text = open(os.path.join(root, path)).read()
            if text.count("\n") > 400:
                faults.append(f"{path}: {text.count(chr(10))} lines; 400 at most")
            if "SPDX-License-Identifier" not in text.split("\n\n")[0][:200]:
                faults.append(f"{path}: no SPDX line at its head")
            mine = room(path)
            for target in re.findall(r'#include "([^"]+)"', text):
                if top == "tests":
                    continue
                theirs = room(f"apps/library/{target}" if target.startswith("grus/") else target)
                if theirs is None:
                    faults.append(f"{path}: includes {target}, which is in no room")
                elif theirs != mine and floor[theirs] > floor[mine]:
                    faults.append(f"{path}: includes {target}, which is above it")
                elif theirs != mine and floor[theirs] == floor[mine]:
                    faults.append(f"{path}: includes {target} of a room beside it")
                elif path.startswith("fem/") and target.startswith("dem/"):
                    faults.append(f"{path}: fem must not know dem")
for f in faults:
    print(f)
print(f"floors: {len(faults)} faults")
sys.exit(1 if faults else 0)
