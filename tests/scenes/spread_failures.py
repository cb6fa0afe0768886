# SPDX-License-Identifier: LGPL-3.0-or-later
"""What ends one rank of a macro problem that is spread ends all: one line, its status, and nobody waits."""
import os
import shutil
import signal
import subprocess
import sys
import time

from spread_tools import command, whole

from scene_tools import history, need, run, write


def failures(tmp, scene):
    """A cell that cannot go on, a folder that rank 0 cannot write to: one line, its status, and no rank waits."""
    tight = "rve.set=['packing.box=[0.027, 0.027, 0.027]', 'numerics.max_overlap=0.026']"
    said = []
    for ranks in (1, 3) if whole else (2,):
        r = run(*command(ranks, scene, os.path.join(tmp, f"tight_{ranks}"), tight, "solve.crossings=15"), timeout=120)
        said += [line for line in r.stderr.split("\n") if line.startswith(scene)]
        need(r.returncode == 3, f"a cell that gives up, {ranks} ranks: exit {r.returncode} {r.stderr[-300:]!r}")
    need(len(said) == (2 if whole else 1) and all("RVE of point" in line for line in said),
         f"a cell that gives up: {said}")
    if whole:
        r = run(*command(2, scene, os.path.join(tmp, "elastic"), tight, "solve.crossings=15", "rve.on_failure=elastic"),
                timeout=120)
        need(r.returncode == 0 and int(history(os.path.join(tmp, "elastic"))[-1]["rves_given_up"]) > 0,
             f"elastic: exit {r.returncode} {r.stderr[-300:]!r}")
    out = os.path.join(tmp, "full")
    p = subprocess.Popen(command(2, scene, out), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    while p.poll() is None and not os.path.exists(os.path.join(out, "history.csv")):
        time.sleep(0.02)
    shutil.rmtree(os.path.join(out, "macro"), ignore_errors=True)  # what rank 0 writes next fails
    open(os.path.join(out, "macro"), "w").close()
    error = p.communicate(timeout=120)[1]
    said = [line for line in error.split("\n") if line.startswith(scene)]
    need(p.returncode == 1 and len(said) == 1, f"rank 0 cannot write: exit {p.returncode} {error[-300:]!r}")


POOR = """
import os, resource, sys
if os.environ["OMPI_COMM_WORLD_RANK"] == sys.argv[1]:
    resource.setrlimit(resource.RLIMIT_DATA, (int(sys.argv[2]),) * 2)
os.execv(sys.argv[3], sys.argv[3:])
"""


def no_memory(tmp, scene):
    """A rank whose system gives it memory for some of its RVEs only: told in one line, 1, and nobody waits."""
    p = subprocess.Popen(command(1, scene, os.path.join(tmp, "one"), "mesh.box.cells=[1,1,1]", "region=",
                                 "output.costs=false"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    few = 0  # bytes that 8 points take
    while p.poll() is None:
        with open(f"/proc/{p.pid}/status") as status:
            few = max([few] + [1024 * int(line.split()[1]) for line in status if line.startswith("VmData")])
        time.sleep(0.005)
    wrap = write(tmp, POOR, "poor.py")
    for ranks, poor in ((1, 0), (2, 0), (3, 1), (3, 2)) if whole else ((3, 2),):
        # Of 1,024 points, some 0.1 MB each, those that 6 MB have room for.
        job = ["mpirun", "-n", str(ranks), sys.executable, wrap, str(poor), str(few + (6 << 20)),
               *command(1, scene, os.path.join(tmp, f"poor_{ranks}_{poor}"), "mesh.box.cells=[4,4,8]", "region=")]
        begin = time.time()
        r = run(*job, timeout=120)
        said = [line for line in r.stderr.split("\n") if line.startswith(scene)]
        told = "out of memory" if poor == 0 else f"rank {poor}: out of memory"
        need(r.returncode == 1 and len(said) == 1 and said[0].endswith(told) and time.time() - begin < 60,
             f"rank {poor} of {ranks} without memory: exit {r.returncode} {said} {r.stderr[-600:]!r}")


def silent(tmp, scene):
    """A rank that is stopped, not killed: named in one line, and the rest do not wait for it. Rank 0 is named by 1."""
    for ranks, stopped in ((3, 2), (3, 1), (2, 0)) if whole else ((3, 1),):
        out = os.path.join(tmp, f"silent_{stopped}")
        p = subprocess.Popen(command(ranks, scene, out, "solve.patience=1", "solve.crossings=100"),
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while p.poll() is None and not (os.path.exists(os.path.join(out, "history.csv")) and history(out)):
            time.sleep(0.02)
        begin = time.time()
        if need(p.poll() is None, f"over before a rank was stopped: exit {p.poll()}"):
            os.kill([int(n) for n in run("pgrep", "-P", str(p.pid)).stdout.split()][stopped], signal.SIGSTOP)
        error = p.communicate(timeout=60)[1]
        said = [line for line in error.split("\n") if line.startswith(scene)]
        need(p.returncode == 1 and len(said) == 1 and f": rank {stopped} has not answered for 1 s" in said[0],
             f"rank {stopped} of {ranks} stopped: exit {p.returncode} {said} {error[-300:]!r}")
        need(1 < time.time() - begin < 20, f"rank {stopped} stopped: told after {time.time() - begin} s")
