#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What an evaluation of an RVE took in grus-bvp runs (output.costs = true).   evaluations.py DIR ...

Means over all evaluations of a run: wall time on its rank, DEM steps, and which parts of it the tangent and the
messages of rank 0 are."""
import csv
import json
import os
import sys

print("| run | evaluations | steps | ms | tangent | messages | DEM |")
print("|---|---|---|---|---|---|---|")
for folder in sys.argv[1:]:
    rows = list(csv.DictReader(open(os.path.join(folder, "costs.csv"), newline="")))
    total, tangent, told = (sum(float(r[k]) for r in rows) for k in ("seconds", "tangent_seconds", "message_seconds"))
    steps = sum(int(r["steps"]) for r in rows)
    whole, n = total + told, len(rows)
    grains = json.load(open(os.path.join(folder, "summary.json")))["counts"]["grains_a_point"]
    print(
        f"| {os.path.basename(os.path.normpath(folder))}, {grains:g} grains a point | {n} | {steps / n:.0f} | "
        f"{1e3 * total / n:.2f} | {tangent / whole:.1%} | {told / whole:.2%} | {(total - tangent) / whole:.1%} |"
    )
