#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Replays the recorded costs of a grus-bvp run (output.costs = true) on P = 1 ... 4096 ranks of one thread.

replay_scaling.py DIR. Every sweep ends with its slowest rank. RVEs stay where they are while the fullest rank, by what
they cost last time, is within a tenth of the mean, and are moved as coupling/rve_farm.cpp moves them otherwise: what a
sweep will cost is not known beforehand. The macro solver's own time is serial. Messages are not counted."""
import collections
import csv
import json
import os
import sys

folder = sys.argv[1]
sweeps = collections.OrderedDict()
for row in csv.DictReader(open(os.path.join(folder, "costs.csv"), newline="")):
    sweeps.setdefault(int(row["sweep"]), []).append((int(row["slot"]), float(row["seconds"])))
seconds = json.load(open(os.path.join(folder, "summary.json")))["seconds"]
serial = (seconds["solve_wall"] - seconds["rve_sweeps_wall"]) / len(sweeps)
total = sum(s for tasks in sweeps.values() for _, s in tasks)
slots = max(len(t) for t in sweeps.values())
print(
    f"{len(sweeps)} sweeps of up to {slots} RVEs, {total:.1f} s in RVEs, {1e3 * serial:.2f} ms a sweep in the macro "
    "solver"
)
print("| ranks | time (s) | speed-up | efficiency | without the macro solver |")
print("|---|---|---|---|---|")


def replay(ranks):
    home, cost, time, pure = {}, {}, 0.0, 0.0
    for tasks in sweeps.values():
        load = [0.0] * ranks
        for slot, c in cost.items():
            load[home[slot]] += c
        for slot, _ in tasks:  # new ones go to the emptiest rank
            if slot not in home:
                home[slot] = load.index(min(load))
                cost[slot] = sum(cost.values()) / len(cost) if cost else 1.0
                load[home[slot]] += cost[slot]
        mean = sum(load) / ranks
        for _ in range(len(home)):
            most, least = max(load), min(load)
            if most <= 1.1 * mean:
                break
            full, empty = load.index(most), load.index(least)
            moved = [s for s in home if home[s] == full and least + cost[s] < most]
            if not moved:
                break
            slot = max(moved, key=lambda s: cost[s])
            home[slot] = empty
            load[full] -= cost[slot]
            load[empty] += cost[slot]
        spent = [0.0] * ranks
        for slot, s in tasks:
            spent[home[slot]] += s
            cost[slot] = s
        time += max(spent) + serial
        pure += max(spent)
    return time, pure


one = total + serial * len(sweeps)
for ranks in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096):
    time, pure = replay(ranks)
    print(
        f"| {ranks} | {time:.2f} | {one / time:.1f} | {100 * one / time / ranks:.1f} % | "
        f"{100 * total / pure / ranks:.1f} % |"
    )
    if ranks > 2 * slots:
        print(
            f"| … 4096 | {time:.2f} | {one / time:.1f} | {100 * one / time / 4096:.2f} % | one RVE a rank from here on "
            "|"
        )
        break
