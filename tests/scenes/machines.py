#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What machines do to runs: signals, time limits, logs, links where files are to be, checkpoints that somebody has
changed: machines.py stops|ranks|links|checkpoints BIN"""
import os
import pty
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import scene_tools
from checkpoint_bytes import Kept, draw_change, seal
from scene_tools import faults, need, run, summary, without_wall, write

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fuzz"))

case, binaries = sys.argv[1], os.path.abspath(sys.argv[2])
rve, bvp = (scene_tools.program(binaries, name) for name in ("grus-rve", "grus-bvp"))
study = os.path.join(binaries, "grus-study")
os.environ["OMPI_MCA_ess_singleton_isolated"] = "1"  # no daemon beside a rank that is alone

ROWS = """[material.sand]
density = 2650
youngs_modulus = "60 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
[packing]
kind = "random"
box = ["3 mm", "3 mm", "3 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.52
seed = 1
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
strain_rate = 25.0
final_strain = 0.045
[numerics]
max_overlap = 10.0
[output]
history_interval = 0.03
"""
STAMP = re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d  ")


def read(*path):
    with open(os.path.join(*path), "rb") as f:
        return f.read()


def wait_for(ready, process, timeout=60):
    begin = time.time()
    while not ready() and process.poll() is None and time.time() - begin < timeout:
        time.sleep(0.01)
    need(process.poll() is None and ready(), "ended, or hung, before it could be told anything")


def ignoring(*signals):
    return lambda: [signal.signal(s, signal.SIG_IGN) for s in signals]


def stops(tmp):
    """Signals that are ignored stay so, wishes are met, a time limit is kept, and no bit changes."""
    scene, whole = write(tmp, ROWS), os.path.join(tmp, "whole")
    begin = time.time()
    need(run(rve, scene, "-o", whole, "--quiet", "--threads", "1").returncode == 0, "the whole run")
    lasts = time.time() - begin
    # nohup: SIGHUP is not heard; SIGUSR1 and SIGUSR2 leave a checkpoint of that moment, and the run goes on.
    out = os.path.join(tmp, "nohup")
    p = subprocess.Popen([rve, scene, "-o", out, "--threads", "1"], stdout=subprocess.PIPE, text=True,
                         preexec_fn=ignoring(signal.SIGHUP))
    wait_for(lambda: os.path.exists(os.path.join(out, "history.csv")), p)
    checkpoint = os.path.join(out, "checkpoint.h5")
    for sent in (signal.SIGUSR1, signal.SIGUSR2):
        p.send_signal(signal.SIGHUP)
        if os.path.exists(checkpoint):
            os.remove(checkpoint)
        p.send_signal(sent)
        wait_for(lambda: os.path.exists(checkpoint), p)
    said = p.communicate()[0]
    need(p.returncode == 0 and said.count("checkpoint written at t = ") == 2,
         f"nohup and two wishes: exit {p.returncode} {said!r}")
    need(read(out, "history.csv") == read(whole, "history.csv"), "a checkpoint on the way has changed the rows")
    progress = [line for line in said.splitlines() if "ETA" in line]
    need(progress and all(STAMP.match(line) for line in progress), f"progress without the time: {progress[:3]}")
    # From that checkpoint: the same rows.
    r = run(rve, scene, "-o", out, "--quiet", "--threads", "1", "--resume")
    need(r.returncode == 0 and read(out, "history.csv") == read(whole, "history.csv"),
         f"from the checkpoint that was asked for: {r.returncode} {r.stderr!r}")
    # A limit of time: over before it is, with status, checkpoint and summary; the log goes on where it was.
    limit, out, log = 0.6 * lasts, os.path.join(tmp, "limit"), os.path.join(tmp, "limit", "run.log")

    def part(*resume):
        begin = time.time()
        limits = ("--max-time", f"{limit:.3f} s", "--log", log)
        return run(rve, scene, "-o", out, "--quiet", "--threads", "1", *limits, *resume), time.time() - begin

    r, took = part()
    while r.returncode == 0 and limit > 0.1 * lasts:  # the machine had more to do as the whole run was timed
        shutil.rmtree(out)
        limit *= 0.5
        r, took = part()
    k = 0
    while r.returncode == 75 and k < 20:
        need(
            took < limit + 1 and r.stderr == "" and summary(out)["status"] == 75
            and "--resume" in summary(out)["ending"] and os.path.exists(os.path.join(out, "checkpoint.h5")),
            f"limit {k}: {took:.2f} s of {limit:.2f} {r.stderr!r}")
        k += 1
        r, took = part("--resume")
    need(r.returncode == 0 and k > 0, f"after {k} parts: exit {r.returncode} {r.stderr!r}")
    need(read(out, "history.csv") == read(whole, "history.csv"), "rows differ after stops by the clock")
    lines = read(log).decode().splitlines()
    need(
        all(STAMP.match(line) for line in lines) and sum("out of time" in line for line in lines) == k
        and "finished" in lines[-1], f"log: {lines[-3:]}")
    for wrong in ("2 m", "-1 s", "0", "soon"):
        r = run(rve, scene, "-o", os.path.join(tmp, "no"), "--max-time", wrong)
        need(r.returncode == 2 and r.stderr.startswith("--max-time: ") and r.stderr.count("\n") == 1,
             f"--max-time {wrong}: exit {r.returncode} {r.stderr!r}")
    r = run(rve, scene, "-o", os.path.join(tmp, "no"), "--log", os.path.join(tmp, "nowhere", "x"))
    need(
        r.returncode == 2 and "--log" in r.stderr and r.stderr.count("\n") == 1
        and not os.path.exists(os.path.join(tmp, "no")), f"a log that cannot be: {r.stderr!r}")
    # A log goes on where it ended; a file that is none, such as those that the run reads, is left as it is.
    log, lengths, no = os.path.join(tmp, "own.log"), [], os.path.join(tmp, "no")
    for _ in range(2):
        r = run(rve, scene, "-o", os.path.join(tmp, "twice"), "--force", "--quiet", "--threads", "1", "--log", log,
                "--set", "loading.final_strain=0.001")
        need(r.returncode == 0, f"a log that is there: exit {r.returncode} {r.stderr!r}")
        lengths.append(len(read(log)))
    need(lengths[1] > 1.5 * lengths[0], f"a log that goes on: {lengths} bytes")
    packing = write(tmp, "0 0 0 1e-3\n", "packing.txt")
    case = '[study]\nscene = "scene.toml"\nquantities = ["kinetic_J"]\nat = [0.0]\n[[case]]\nname = "a"\n'
    logged = write(tmp, case, "logged.toml")
    for program, main, other in ((rve, scene, scene), (rve, scene, packing), (study, logged, scene)):
        kept = read(other)
        r = run(program, main, "-o", no, "--log", other)
        told = "--log: " in r.stderr and "is not a log of Grus" in r.stderr and r.stderr.count("\n") == 1
        need(r.returncode == 2 and told, f"--log {other}: exit {r.returncode} {r.stderr!r}")
        need(read(other) == kept and not os.path.exists(no), f"--log {other}: written to")
    # A terminal: one live line; under mpirun, which gives its ranks one whatever it writes to: lines.
    for environment, live in (({}, True), ({"OMPI_COMM_WORLD_SIZE": "2"}, False)):
        leader, follower = pty.openpty()
        p = subprocess.Popen(
            [rve, scene, "-o", whole, "--force", "--threads", "1", "--set", "loading.final_strain=0.03"],
            stdout=follower, env={**os.environ, "TERM": "xterm", **environment})
        os.close(follower)
        seen = b""
        while True:
            try:
                some = os.read(leader, 4096)
            except OSError:
                break
            seen += some
        need(
            p.wait() == 0 and (b"\033[K" in seen) == live
            and (STAMP.match(seen.decode().splitlines()[4]) is not None) != live, f"{environment}: {seen[-300:]!r}")
    # A study: SIGTERM and a limit are heard, runs that were stopped go on from their checkpoints.
    write(tmp, case + 'set = { "loading.final_strain" = 0.075 }\n', "study.toml")
    need(
        run(rve, scene, "-o", whole, "--quiet", "--threads", "1", "--force", "--set",
            "loading.final_strain=0.075").returncode == 0, "the longer run")
    out, log, begin = os.path.join(tmp, "study"), os.path.join(tmp, "study.log"), time.time()
    plan = (study, os.path.join(tmp, "study.toml"), "-o", out, "--threads", "1")
    need(run(study, "--help").returncode == 0, "--help of a study")  # what it takes to start
    limit, part = time.time() - begin + lasts, os.path.join(out, "runs", "a")
    for _ in range(20):  # a machine whose other work comes and goes takes longer or less than it just did
        shutil.rmtree(out, ignore_errors=True)
        begin = time.time()
        r = run(*plan, "--max-time", f"{limit:.3f} s", "--log", log)
        if r.returncode == 75 and os.path.exists(os.path.join(part, "summary.json")):
            break
        limit *= 0.7 if r.returncode == 0 else 1.25
    stopped = summary(part)
    need(
        r.returncode == 75 and r.stderr.count("\n") == 1 and stopped["status"] == 130
        and time.time() - begin < limit + 2,
        f"a study's limit: exit {r.returncode} {r.stderr!r} after {time.time() - begin:.1f} s")
    r = run(*plan)
    need(r.returncode == 0 and read(part, "history.csv") == read(whole, "history.csv"),
         f"a study that goes on: exit {r.returncode} {r.stderr!r}")
    longer = summary(part)["seconds"]["loading_wall"] > stopped["seconds"]["loading_wall"]
    need(longer, "a run of a study began anew instead of going on")
    lines = read(log).decode().splitlines()
    need("out of time" in lines[-1] and all(map(STAMP.match, lines)), f"log of a study: {lines[-3:]}")


BLOCK = """[mesh]
box = { size = [0.01, 0.01, 0.01], cells = [1, 1, 1] }
[rve]
scene = "cell.toml"
strain_per_step = 1e-7
[[boundary]]
where = "z=max"
displacement = [0, 0, "-0.1 mm"]
[[boundary]]
where = "z=min"
displacement = [0, 0, 0]
[solve]
kind = "quasi-static"
increments = 20
[output]
frames = 0
"""


def ranks(tmp):
    """The same under mpirun, of a macro problem."""
    if not bvp:
        return
    write(
        tmp, ROWS[:ROWS.index("[packing]")] +
        '[packing]\nkind = "simple-cubic"\nradius = { distribution = "constant", mean = "0.3 mm" }\n'
        'layers = [4, 4, 4]\n[boundary]\nkind = "periodic"\n'
        '[preparation]\npressure = "1 MPa"\n[loading]\nkind = "uniaxial-strain"\nstrain_rate = 500.0\n'
        'final_strain = 0.02\n',
        "cell.toml")
    scene, whole, out = write(tmp, BLOCK, "block.toml"), os.path.join(tmp, "whole"), os.path.join(tmp, "out")
    # A log that the first rank cannot open ends all of them.
    r = run("mpirun", "-n", "2", bvp, scene, "-o", out, "--log", scene, timeout=60)
    told = r.stderr.count("is not a log of Grus") == 1
    need(r.returncode == 2 and told, f"--log of two ranks: exit {r.returncode} {r.stderr[:300]!r}")
    r = run(bvp, scene, "-o", whole, "--quiet", "--threads", "1")
    need(r.returncode == 0, f"the whole run: {r.stderr!r}")
    checkpoint = os.path.join(out, "checkpoint.h5")
    with open(os.path.join(tmp, "said"), "w") as said:
        p = subprocess.Popen(["mpirun", "-n", "2", bvp, scene, "-o", out, "--threads", "1"], stdout=said,
                             stderr=subprocess.STDOUT, start_new_session=True)
        wait_for(lambda: os.path.exists(os.path.join(out, ".grus")), p)
        p.send_signal(signal.SIGUSR1)  # mpirun hands it on
        wait_for(lambda: os.path.exists(checkpoint), p)
        p.kill()
        p.wait()
        for rank in scene_tools.session(p.pid):
            os.kill(rank, signal.SIGKILL)
        scene_tools.wait_for_session(p.pid)
    text = read(tmp, "said").decode()
    need("\033" not in text and "\r" not in text, f"escape codes in mpirun's output: {text[-200:]!r}")
    for k in range(30):
        r = run("mpirun", "-n", "2", bvp, scene, "-o", out, "--quiet", "--threads", "1", "--resume", "--max-time",
                "4 s")
        if r.returncode != 75:
            break
        need(summary(out)["status"] == 75, f"summary: {summary(out)['status']}")
    need(r.returncode == 0 and without_wall(out) == without_wall(whole),
         f"after {k} stops: exit {r.returncode} {r.stderr[-300:]!r}")


def links(tmp):
    """What is written aside, appended to or locked is a file of the folder's own: a link put there leads nowhere."""
    scene, victim = write(tmp, ROWS.replace("final_strain = 0.045",
                                            "final_strain = 0.002")), write(tmp, "precious", "victim")
    need(run(rve, scene, "-o", os.path.join(tmp, "out"), "--quiet").returncode == 0, "the first run")
    out = os.path.join(tmp, "out")
    for name in ("summary.json.new", "history.csv.new", "checkpoint.h5.new"):
        for link in (os.symlink, os.link):
            link(victim, os.path.join(out, name))
            r = run(rve, scene, "-o", out, "--quiet", "--force", "--set", "output.checkpoint_interval=1e-9")
            need(r.returncode == 0 and read(victim) == b"precious" and not os.path.lexists(os.path.join(out, name)),
                 f"{name}, {link.__name__}: exit {r.returncode} {r.stderr!r} {read(victim)[:20]!r}")
    # A folder of frames that has become a link.
    framed, other = os.path.join(tmp, "framed"), tempfile.mkdtemp(dir=tmp)
    frames = [
        rve, scene, "-o", framed, "--quiet", "--set", "output.frames=2", "--set", "output.checkpoint_interval=1e-9"
    ]
    need(run(*frames).returncode == 0, "a run with frames")
    shutil.rmtree(os.path.join(framed, "grains"))
    os.symlink(other, os.path.join(framed, "grains"))
    for how in ("--force", "--resume"):
        r = run(*frames, how)
        need(r.returncode == 2 and "grains: is a link" in r.stderr and os.listdir(other) == [],
             f"grains is a link, {how}: exit {r.returncode} {r.stderr!r} {os.listdir(other)}")
    for program, arguments in ((rve, ("--force",)), (study, ())):
        for target in (victim, os.path.join(tmp, "made")):
            marked = tempfile.mkdtemp(dir=tmp)
            os.symlink(target, os.path.join(marked, ".grus"))
            source = scene if program == rve else write(
                tmp, '[study]\nscene = "scene.toml"\nquantities = ["kinetic_J"]\nat = [0.0]\n[[case]]\nname = "a"\n',
                "study.toml")
            r = run(program, source, "-o", marked, "--quiet", *arguments)
            need(
                r.returncode in (1, 2) and r.stderr.count("\n") == 1 and os.listdir(marked) == [".grus"]
                and not os.path.exists(os.path.join(tmp, "made")),
                f"a lock that is a link: exit {r.returncode} {r.stderr!r}")
    need(read(victim) == b"precious", "the lock was followed")
    # The Python tools write the same way.
    sys.path.insert(0, os.path.join(binaries, "..", "python"))
    from grus.files.writing import write_csv
    os.symlink(victim, os.path.join(tmp, "table.csv.new"))
    write_csv(os.path.join(tmp, "table.csv"), [["a"], [1]])
    need(
        read(victim) == b"precious" and read(tmp, "table.csv") == b"a\n1\n",
        "grus.files.writing.write_whole follows a link")


def lines_of(folder):
    path = os.path.join(folder, "history.csv")
    return read(path).count(b"\n") if os.path.exists(path) else 0


def checkpoints(tmp):
    """Values in real checkpoints are changed and the file is sealed again: refused in one line, or a run that ends; no
    crash, no hang. And a file that claims to be huge takes no memory."""
    import bases
    scenes = {
        "crushing": bases.RVE["walls"], "periodic": bases.RVE["triaxial"], "bonded": bases.RVE["beam"],
        "cleaving": bases.RVE["cleaving"]
    }
    write(tmp, bases.PACKING, "pack.txt")
    write(tmp, bases.CELL, "cell.toml")
    explicit = BLOCK[:BLOCK.index("[solve]")].replace(
        "strain_per_step = 1e-7\n", "") + '[solve]\nkind = "explicit-quasi-static"\n[output]\nframes = 0\n'
    newton = BLOCK.replace("strain_per_step = 1e-7",
                           "strain_per_step = 1e-5\nadaptivity = { share = 1e-4, error = 0.01 }").replace(
                               "increments = 20", "increments = 4")
    macro = {"newton": newton, "explicit": explicit} if bvp else {}
    draw, outcomes, count, whole = random.Random(20), {}, 0, {}
    for name, text in {**scenes, **macro}.items():
        program, scene, out = (bvp if name in macro else rve), write(tmp, text, name + ".toml"), os.path.join(tmp, name)
        interval = {"newton": 1e-9, "explicit": 0.004}.get(name,
                                                           0.02)  # s: each run writes one, none writes all the time
        rows = 6 if name == "cleaving" else 0  # late: what was cloven is there, and little is left to run
        for _ in range(4):  # a machine may be done before a checkpoint is due
            settings = ["--set", f"output.checkpoint_interval={interval}", "--threads", "1", "--quiet"]
            p = subprocess.Popen([program, scene, "-o", out, "--force", *settings], stderr=subprocess.PIPE, text=True)
            while p.poll() is None and not (os.path.exists(os.path.join(out, "checkpoint.h5"))
                                            and lines_of(out) >= rows):
                time.sleep(0.001)
            p.send_signal(signal.SIGTERM)
            errors = p.communicate()[1]
            if p.returncode != 0 or os.path.exists(os.path.join(out, "checkpoint.h5")):
                break
            interval /= 4
        need(p.returncode in (0, 130) and os.path.exists(os.path.join(out, "checkpoint.h5")),
             f"{name}: no checkpoint: exit {p.returncode} {errors!r}")
        kept, real = Kept(os.path.join(out, "checkpoint.h5")), read(out, "checkpoint.h5")
        whole[name] = real
        for k in range(6 if name in macro else 21):
            byte, value, about = draw_change(kept, draw)
            with open(os.path.join(out, "checkpoint.h5"), "wb") as f:
                f.write(kept.changed(byte, value, about) if k else real)
            try:
                r = subprocess.run([program, scene, "-o", out, "--resume", *settings], capture_output=True, text=True,
                                   timeout=20)
            except subprocess.TimeoutExpired:
                need(False, f"{name} {k}: {value!r} at {byte}: hangs")
                continue
            if k == 0:
                need(r.returncode == 0, f"{name}: the checkpoint as it was: exit {r.returncode} {r.stderr!r}")
                continue
            outcomes[r.returncode] = outcomes.get(r.returncode, 0) + 1
            count += 1
            need(
                r.returncode in (0, 2, 3) and r.stderr.count("\n") == (r.returncode != 0),
                f"{name} {k}: {value!r} at {byte}{' of what it tells' if about else ''}: exit {r.returncode} "
                f"{r.stderr[-300:]!r}"
            )
    need(count >= 80 and outcomes.get(2, 0) > count / 4, f"{count} changes: {outcomes}")
    print(f"{count} changed checkpoints, by exit status: {outcomes}")
    # Columns of 2 GB in a file of some kB.
    import h5py
    import numpy as np
    out = os.path.join(tmp, "crushing")
    with open(os.path.join(tmp, "crushing.h5"), "wb") as f:
        f.write(whole["crushing"])
    with h5py.File(os.path.join(tmp, "crushing.h5"), "r") as f:
        head = f["head"][:]
    for column in ("about", "offsets", "parts", "head"):
        path = os.path.join(out, "checkpoint.h5")
        with h5py.File(path, "w") as f:
            for name, kind in (("head", "u8"), ("about", "u1"), ("offsets", "u8"), ("parts", "u1")):
                if name == column:
                    f.create_dataset(name, shape=(1 << (31 if kind == "u1" else 28),), dtype=kind, chunks=(1 << 16,),
                                     compression="gzip", fillvalue=0)
                else:
                    f.create_dataset(name, data=head if name == "head" else np.zeros(2, kind))
        data = read(path)
        with open(path, "wb") as f:
            f.write(data + seal(data).to_bytes(8, "little"))
        limited = [
            "/usr/bin/env", "bash", "-c", 'ulimit -v 1500000; exec "$@"', "x", rve,
            os.path.join(tmp, "crushing.toml"), "-o", out, "--resume", *settings
        ]
        r = subprocess.run(limited, capture_output=True, text=True, timeout=20)
        need(r.returncode == 2 and r.stderr.count("\n") == 1,
             f"a huge column {column} in {len(data)} bytes: exit {r.returncode} {r.stderr!r}")


with tempfile.TemporaryDirectory() as tmp:
    {"stops": stops, "ranks": ranks, "links": links, "checkpoints": checkpoints}[case](tmp)
print(f"machines {case}: {len(faults)} faults")
sys.exit(1 if faults else 0)
