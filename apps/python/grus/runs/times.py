# SPDX-License-Identifier: LGPL-3.0-or-later
"""How long many runs would take: from what the programs' own --check tells of them, as many as can be tried in half a
minute."""
import math
import re
import time
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from grus.runs.command import duration_text

PATIENCE = 30  # s, in which runs are tried
SECONDS = {"h": 3600, "min": 60, "s": 1}
TOLD = re.compile(r"^  (run time|run:|preparation:?) (at least )?(?:about )?([\d.][^(;\n]*?)"
                  r"(?: to ([^(;\n]*?))?(?= \(|;|$)", re.M)


class Planned(NamedTuple):
    """So many runs like this one."""
    case: dict
    seed: object
    runs: float


def seconds_of(text):
    """Of "12.3 s", "4 min 05 s", "2 h 10 min"; NaN for what is none."""
    parts = re.findall(r"([\d.]+) (h|min|s)\b", text)
    return sum(float(number) * SECONDS[unit] for number, unit in parts) if parts else math.nan


def told(text):
    """(least, most) seconds that --check tells of a run, its preparation among them; no most where it tells a least
    alone; None where it tells nothing."""
    found = TOLD.findall(text)
    if not any(what.startswith("run") for what, *_ in found):
        return None
    low = sum(seconds_of(first) for _, _, first, _ in found)
    high = sum(math.inf if least else seconds_of(last or first) for _, least, first, last in found)
    return None if math.isnan(low + high) else (low, high)


def spread(count):
    """0 to count - 1 in an order in which any first few lie evenly among all."""
    return sorted(range(count), key=lambda k: int(f"{k:032b}"[::-1], 2))


def tried(runner, planned, workers, patience=PATIENCE):
    """What --check tells of each, None of those that it was not asked for in time."""
    end, found = time.monotonic() + patience, [None] * len(planned)

    def ask(k):
        left = end - time.monotonic()
        if left > 0 and not runner.stopped:
            status, said, _ = runner.ask(planned[k].case, planned[k].seed, "--check", "--threads", "1", within=left)
            found[k] = told(said) if status == 0 else None
    with ThreadPoolExecutor(workers) as pool:
        try:
            list(pool.map(ask, spread(len(planned))))
        except BaseException:
            runner.stop()
            raise
    return found


def total(counts, found, workers):
    """(least, most) seconds in which `workers` get through all, each run on one; `found`: of one run of each, None
    where it is not known, and then as the others' mean. None: nothing is known."""
    known = [f for f in found if f]
    if not known:
        return None
    mean = tuple(sum(f[k] for f in known) / len(known) for k in (0, 1))
    each = [f or mean for f in found]
    workers = min(workers, max(1, round(sum(counts))))
    low, high = (sum(n * f[k] for n, f in zip(counts, each)) / workers for k in (0, 1))
    longest = [max(f[k] for f in each) for k in (0, 1)]
    last = (1 - 1 / workers) * longest[1] if math.isfinite(high) else 0  # the longest one may begin last
    return max(low, longest[0]), high + last


def told_of(runner, planned, workers):
    """Of --check: "3 min to 12 min on 2 cores (4 of 40 were tried)"."""
    found = tried(runner, planned, workers)
    of = total([p.runs for p in planned], found, workers)
    known = sum(f is not None for f in found)
    if of is None:
        return f"time not known: none could be tried within {PATIENCE} s"
    low, high = (duration_text(max(1, s)) if math.isfinite(s) else "" for s in of)
    text = f"at least {low}" if not high else low if low == high else f"{low} to {high}"
    cores = f"on {workers} core{'s' if workers > 1 else ''}"
    return f"{text} {cores}" + (f" (from {known} of {len(found)} that could be tried)" if known < len(found) else "")
