#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the scene tests share: running programs, reading results, counting faults."""
import contextlib
import csv
import json
import os
import signal
import subprocess
import time

here = os.path.dirname(os.path.abspath(__file__))
shipped = os.path.join(here, "..", "..", "apps", "scenes")
faults = []
SOFT_SAND = """
[material.s]
density = 2650
youngs_modulus = 10e9
poissons_ratio = 0.2
friction = 0.5
restitution = 0.3
damping = 0.3
"""
# Cells whose bonds break: what such scenes are made of.
ROCK = """
[material.rock]
density = "2500 kg/m^3"
contact = "overlap"
friction = 0.5
damping = 0.3
[material.rock.bond]
"""
BRITTLE = 'modulus = "10 GPa"\npoissons_ratio = 0.1425\ncriterion = "parallel"\ntension = "10 MPa"\nshear = "1 GPa"\n'


def pressed_cell(solid_fraction, friction):
    """Some hundred soft spheres in a cell of 6 mm, pressed to 0.5 MPa with this friction."""
    return SOFT_SAND + f"""
[packing]
kind = "random"
box = ["6 mm", "6 mm", "6 mm"]
radius = {{ distribution = "uniform", min = "0.4 mm", max = "0.6 mm" }}
solid_fraction = {solid_fraction}
[boundary]
kind = "periodic"
[preparation]
pressure = "0.5 MPa"
friction = {friction}
inertial_number = 1e-2
unbalanced_force = 1e-2
stress_change = 1e-2
"""


def run(*command, timeout=1800):
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout)


def need(condition, message):
    if not condition:
        faults.append(message)
        print("FAULT", message, flush=True)
        if os.environ.get("GRUS_ABORT"):  # as --abort of the other tests
            os._exit(1)
    return bool(condition)


def refused(words, work, kind):
    """An error of this kind and of no other, in one line that says all of `words`: what it says."""
    try:
        work()
    except Exception as e:
        need(type(e) is kind and all(w in str(e) for w in ([words] if isinstance(words, str) else words))
             and "\n" not in str(e), f"{type(e).__name__} '{e}' does not say {words}")
        return str(e)
    else:
        need(False, f"accepted: {words}")


def history(folder):
    with open(os.path.join(folder, "history.csv"), newline="") as f:
        rows = list(csv.DictReader(f))
    return rows


def column(folder, name):
    return [float(r[name]) for r in history(folder)]


def summary(folder):
    with open(os.path.join(folder, "summary.json")) as f:
        return json.load(f)


def write(folder, text, name="scene.toml"):
    path = os.path.join(folder, name)
    with open(path, "w") as f:
        f.write(text)
    return path


def without_wall(folder):
    return [{k: v for k, v in row.items() if k != "wall_s"} for row in history(folder)]


def program(binaries, name):
    path = os.path.join(binaries, name)
    return path if os.path.exists(path) else None


def kill_at_random(command_of, ready, times, draw, within):
    """Starts command_of(k) and kills it, with all that it has started, at a random instant less than `within` seconds
    after `ready()`; k = 0, 1, ... How often it was killed before its end."""
    for k in range(times):
        p = subprocess.Popen(command_of(k), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                             start_new_session=True)
        begin = time.time()
        while p.poll() is None and not ready() and time.time() - begin < 300:
            time.sleep(0.005)
        time.sleep(draw.uniform(0, within))
        if p.poll() is not None:
            return k
        p.kill()
        p.wait()
        for rank in session(p.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(rank, signal.SIGKILL)
        wait_for_session(p.pid)
    return times


def session(leader):
    """What still lives of the session that `leader` has led: mpirun gives each rank a process group of its own."""
    found = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat") as f:
                state, _, _, number = f.read().rpartition(")")[2].split()[:4]
        except OSError:  # ended meanwhile
            continue
        if int(number) == leader and state != "Z":
            found.append(int(name))
    return found


def wait_for_session(leader, timeout=120):
    begin = time.time()
    while session(leader) and time.time() - begin < timeout:
        time.sleep(0.01)


def interrupt_when(process, ready, sent, timeout=300):
    """Sends a signal once `ready()` and waits for all that the process, a session's leader, has started; False where it
    ended before."""
    begin = time.time()
    while process.poll() is None and time.time() - begin < timeout:
        if ready():
            process.send_signal(sent)
            process.wait()
            wait_for_session(process.pid)
            return True
        time.sleep(0.01)
    return False
