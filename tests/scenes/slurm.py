#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""The job script of docs/cluster.md for a problem on all ranks, with stand-ins for srun and scontrol. Told that its
time is nearly over it leaves a checkpoint and is queued again, goes on from there, and ends: slurm.py BIN"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

import scene_tools
from scene_tools import faults, here, history, need, shipped, without_wall, write

bvp = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-bvp")
SIDES = "".join(f'[[boundary]]\nwhere = "{axis}={end}"\ndisplacement = {held}\n'
                for axis, held in (("x", '[0, "free", "free"]'), ("y", '["free", 0, "free"]'))
                for end in ("min", "max"))
BLOCK = f"""
[mesh]
box = {{ size = ["40 mm", "40 mm", "80 mm"], cells = [1, 1, 4] }}
[rve]
scene = "{os.path.join(shipped, "sphere_rve.toml")}"
set = ["packing.box=[0.027, 0.027, 0.027]", "numerics.max_overlap=0.3"]
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
[[boundary]]
where = "z=max"
displacement = [0, 0, "-0.1 mm"]
{SIDES}
[solve]
kind = "explicit-quasi-static"
crossings = 20
kinetic = 0.5
balance = 0.5
[output]
history_interval = 0.02
"""
# Two ranks of one thread each, which hear SIGTERM themselves, as those of srun do.
SRUN = f"""#!/bin/bash
while [[ $1 == --* ]]; do shift; done
shift
set -- "${{@/#4/1}}"
mpirun -n 2 {bvp} "$@" &
job=$!
trap 'for rank in $(pgrep -P $job); do kill -TERM $rank; break; done' TERM
wait $job; status=$?
while kill -0 $job 2> /dev/null; do wait $job; status=$?; done
exit $status
"""


def script():
    page = open(os.path.join(here, "..", "..", "docs", "cluster.md")).read()
    found = [text for text in re.findall(r"```sh\n(#!/bin/bash.*?)```", page, re.S) if "solve.spread=true" in text]
    need(len(found) == 1, f"docs/cluster.md: {len(found)} scripts with solve.spread")
    return found[0]


def job(tmp, name, late):
    """Exit status, what it asked scontrol for, its folder, what it said. `late`: its time is nearly over once there is
    a row."""
    folder = os.path.join(tmp, name)
    if not os.path.exists(folder):
        os.mkdir(folder)
        write(folder, BLOCK, "block.toml")
        write(folder, script(), "job.sh")
        os.mkdir(os.path.join(folder, "bin"))
        for program, text in (("srun", SRUN), ("scontrol", "#!/bin/bash\necho \"$@\" >> queued\n")):
            os.chmod(write(os.path.join(folder, "bin"), text, program), 0o755)
    queue, out = os.path.join(folder, "queued"), os.path.join(folder, "block")
    before = open(queue).read() if os.path.exists(queue) else ""
    environment = {**os.environ, "PATH": os.path.join(folder, "bin") + ":" + os.environ["PATH"], "SLURM_JOB_ID": "52"}
    p = subprocess.Popen(["bash", "job.sh"], cwd=folder, env=environment, stdout=subprocess.DEVNULL,
                         stderr=subprocess.PIPE, text=True)
    rows = os.path.join(out, "history.csv")
    while late and p.poll() is None and not (os.path.exists(rows) and history(out)):
        time.sleep(0.02)
    if late:
        p.send_signal(signal.SIGUSR1)
    error = p.communicate(timeout=120)[1]
    return p.returncode, (open(queue).read() if os.path.exists(queue) else "")[len(before):], out, error


with tempfile.TemporaryDirectory() as tmp:
    status, queued, whole, error = job(tmp, "whole", False)
    need(status == 0 and queued == "", f"a job that ends: exit {status}, queued {queued!r} {error[-300:]}")
    status, queued, part, error = job(tmp, "part", True)
    need(status == 130 and queued == "requeue 52\n" and os.path.exists(os.path.join(part, "checkpoint.h5")),
         f"out of time: exit {status}, queued {queued!r} {error[-300:]}")
    need(len(history(part)) < len(history(whole)), f"out of time: {len(history(part))} rows of {len(history(whole))}")
    status, queued, part, error = job(tmp, "part", False)
    need(status == 0 and queued == "", f"gone on: exit {status}, queued {queued!r} {error[-300:]}")
    need(without_wall(part) == without_wall(whole), "gone on: another history.csv")
sys.exit(1 if faults else 0)
