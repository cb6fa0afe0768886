#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""How long many runs are said to take, with a program of known answers in the place of grus-rve: study_times.py BIN"""
import math
import os
import sys
import tempfile

import made_up
from scene_tools import faults, need, write

SCENE = "[made_up]\na = 100.0\nb = 50.0\nc = 3.0\n"


def forecasts(tmp, programs):
    """What --check tells of one run, and what follows of many."""
    from grus.runs import times
    from grus.runs.runner import Runner
    lines = {"  run time about 3.5 s (the whole test was gone through)": (3.5, 3.5),
             "  run time 1 min 05 s to 2 h 10 min (a part)\n  preparation about 10.0 s": (75, 7810),
             "  run time not known (0 % of the test)": None, "  grains 8   memory about 3 MB": None,
             "  preparation: about 2.0 s (1 starts of 1 packings; 2 s a packing)\n  run: 3.0 s to 1 h 00 min (x); y":
                 (5, 3602),
             "  preparation: about 2.0 s (1 starts)\n  run: at least about 2 min 00 s (4 steps); more": (122, math.inf),
             "  preparation about 2.0 s": None}
    for text, wanted in lines.items():
        need(times.told(f"title\n{text}\n  note: run time about 9 s (no)") == wanted, f"{text}: {times.told(text)}")
    need(math.isnan(times.seconds_of("soon")), "a time that is none")
    # By hand: 3 runs of 2 to 4 s, one of 10 to 20 s, two as their mean, 6 to 12 s: 28 to 56 s in all.
    of = lambda workers: times.total([3, 1, 2], [(2, 4), (10, 20), None], workers)
    made_up.near([of(1), of(4), of(100)], [28, 56, 10, 14 + 15, 10, 56 / 6 + 20 * 5 / 6], "of many")
    need(times.total([2], [None], 1) is None and times.total([2], [(3, math.inf)], 1) == (6, math.inf), "no most")
    need(times.spread(5) == [0, 4, 2, 1, 3], f"an even order: {times.spread(5)}")
    scene = write(tmp, SCENE, "hangs.toml")
    case = lambda **keys: {"program": "grus-rve", "scene": scene, "set": keys}
    runner = Runner(tmp, "seed", programs, {})
    slow = [times.Planned(case(**k), None, 1) for k in ({}, {"hangs": 30})]
    found = times.tried(runner, slow, 2, patience=2)
    need(found == [(6, 84), None] and not runner.running, f"what takes too long is not waited for: {found}")
    said = times.told_of(runner, [times.Planned(case(told="none"), 1, 1)], 1)
    need(said.startswith("time not known"), f"nothing told: {said}")
    half = [times.Planned(case(**k), 1, 2) for k in ({}, {"told": "none"})]
    said = times.told_of(runner, half, 1)
    need(said == "24 s to 6 min on 1 core (from 1 of 2 that could be tried)", f"a half told: {said}")


with tempfile.TemporaryDirectory() as place:
    forecasts(place, made_up.installation(os.path.join(place, "place"), os.path.abspath(sys.argv[1])))
print(f"study_times: {len(faults)} faults")
sys.exit(bool(faults))
