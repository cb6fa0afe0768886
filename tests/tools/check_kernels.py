#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Kernels of wide targets share no symbol with the rest: a linker could pick the wide one for a machine that lacks it.
check_kernels.py BUILD_FOLDER"""
import glob
import os
import subprocess
import sys

objects = glob.glob(os.path.join(sys.argv[1], "dem", "CMakeFiles", "grus_kernels*.dir", "**", "*.o"), recursive=True)
faults = []
for path in objects:
    for line in subprocess.run(["nm", path], capture_output=True, text=True, check=True).stdout.splitlines():
        kind, name = line.split()[-2:]
        if kind in "WVuwvi" or (kind in "TDBR" and "lanes" not in name):
            faults.append(f"{path}: {kind} {name}")
print("\n".join(faults))
print(f"kernels: {len(objects)} objects, {len(faults)} faults")
sys.exit(bool(faults) or len(objects) < 3)
