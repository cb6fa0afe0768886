#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ground at rest on an unstructured mesh: classes of stress, their preparation stopped and gone on with, what --check
says of the time: ground.py BIN"""
import json
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

import scene_tools
from scene_tools import faults, need, run, without_wall

bvp = scene_tools.program(os.path.abspath(sys.argv[1]), "grus-bvp")
summary = lambda folder: json.load(open(os.path.join(folder, "summary.json")))

CELL = """[material.sand]
density = 2650.0
youngs_modulus = "6 GPa"
poissons_ratio = 0.17
friction = 0.5
restitution = 0.5
damping = 0.2
[packing]
kind = "random"
box = ["2 mm", "2 mm", "2 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.3 mm" }
solid_fraction = 0.56
[boundary]
kind = "periodic"
[preparation]
pressure = "100 kPa"
friction = 0.2
strain_per_step = 1e-4
inertial_number = 1e-2
unbalanced_force = 5e-3
stress_change = 5e-3
window = 30
max_hold = 8000
"""
K0, SURCHARGE, GRAVITY, HEIGHT, WIDTH = 0.6, 2e5, 9.81, 20.0, 10.0
SCENE = f"""gravity = [0, -{GRAVITY}]
[mesh]
file = "bed.msh"
dimension = "plane-strain"
[initial_stress]
k0 = {K0}
surcharge = {SURCHARGE}
[rve]
scene = "cell.toml"
strain_per_step = 1e-4
inertial_number = 1e-2
unbalanced_force = 5e-3
stress_change = 5e-3
window = 30
max_hold = 8000
[[boundary]]
where = "y=min"
name = "base"
displacement = [0, 0]
[[boundary]]
where = "x=min"
displacement = [0, "free"]
[[boundary]]
where = "x=max"
displacement = [0, "free"]
[[boundary]]
where = "y=max"
name = "top"
pressure = {SURCHARGE}
history = "constant"
[solve]
kind = "quasi-static"
increments = 1
"""


def bed(path, columns=2, rows=3):
    """Quadrilaterals whose inner nodes are moved: no two Gauss points lie at one height."""
    lines, at = [], []
    for j in range(rows + 1):
        for i in range(columns + 1):
            inner = 0 < i < columns or 0 < j < rows
            x = WIDTH * i / columns + (0.18 * WIDTH / columns * math.sin(7 * j + i) if 0 < i < columns else 0)
            y = HEIGHT * j / rows + (0.14 * HEIGHT / rows * math.sin(3 * i + 5 * j + 1) if inner and 0 < j < rows
                    else 0)
            at.append((x, y))
    for k, (x, y) in enumerate(at):
        lines.append(f"{k + 1} {x!r} {y!r} 0")
    cells = []
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i + 1
            cells.append((a, a + 1, a + columns + 2, a + columns + 1))
    with open(path, "w") as f:
        f.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n%s\n$EndNodes\n$Elements\n%d\n%s\n$EndElements\n" % (
            len(at), "\n".join(lines), len(cells), "\n".join(f"{k + 1} 3 2 1 1 " + " ".join(map(str, c)) for k,
                    c in enumerate(cells))))
    depths = []
    g = 1 / math.sqrt(3)
    for c in cells:  # bilinear Gauss points of a quadrilateral
        for s in (-g, g):
            for t in (-g, g):
                shape = [(1 - s) * (1 - t) / 4, (1 + s) * (1 - t) / 4, (1 + s) * (1 + t) / 4, (1 - s) * (1 + t) / 4]
                depths.append(HEIGHT - sum(w * at[n - 1][1] for w, n in zip(shape, c)))
    return depths


def greedy(vertical, tolerance):
    """Classes by hand: from the smallest stress on, each as wide as the tolerance lets it."""
    count, worst, rest = 0, 0.0, sorted(vertical)
    while rest:
        a = rest[0]
        inside = [v for v in rest if (v - a) / (v + a) <= tolerance]
        count, worst, rest = count + 1, max(worst, (inside[-1] - a) / (inside[-1] + a)), rest[len(inside):]
    return count, worst


def main(tmp):
    scene, depths = os.path.join(tmp, "scene.toml"), bed(os.path.join(tmp, "bed.msh"))
    open(scene, "w").write(SCENE), open(os.path.join(tmp, "cell.toml"), "w").write(CELL)
    out = {}
    for tolerance in (0, 0.05):
        out[tolerance] = os.path.join(tmp, f"out{tolerance}")
        r = run(bvp, scene, "-o", out[tolerance], "--set", f"initial_stress.tolerance={tolerance}")
        need(r.returncode == 0, f"tolerance {tolerance}: exit {r.returncode}: {r.stderr}")
        need((f"stresses in {summary(out[tolerance])['counts']['starts']} classes" in r.stdout) == (tolerance > 0),
                f"tolerance {tolerance}: said {r.stdout[:600]}")
    if faults:
        return
    exact, shared = summary(out[0]), summary(out[0.05])
    need(exact["counts"]["starts"] == exact["counts"]["initial_stresses"] == len(depths),
            f"each point for itself: {exact['counts']}")
    need(exact["errors"]["initial_stress"]["worst"] == 0 and "classes" not in str(exact["notes"]),
            f"exact stresses: {exact['errors']}")
    # The weight is that of the cells: from what the base bears.
    last = {k: exact["last_row"][k] for k in exact["last_row"]}
    density = (last["reaction_base_y_N"] / WIDTH - SURCHARGE) / (GRAVITY * HEIGHT)
    need(1200 < density < 2000, f"bulk density {density} from the reaction of the base")
    count, worst = greedy([SURCHARGE + density * GRAVITY * d for d in depths], 0.05)
    need(shared["counts"]["starts"] == count < len(depths) / 2,
            f"{shared['counts']['starts']} classes, by hand {count}")
    need(shared["errors"]["initial_stress"]["tolerance"] == 0.05, "the tolerance that was asked for")
    need(abs(shared["errors"]["initial_stress"]["worst"] - worst) < 1e-3 and worst <= 0.05,
            f"deviation {shared['errors']['initial_stress']}, by hand {worst}")
    need(any("classes" in note for note in shared["notes"]), f"notes {shared['notes']}")
    # In balance all the same: the base bears weight and surcharge, whatever the cells began with.
    rest = shared["last_row"]
    need(abs(rest["reaction_base_y_N"] / last["reaction_base_y_N"] - 1) < exact["errors"]["residual_floor"],
            f"base {rest['reaction_base_y_N']} N, exact {last['reaction_base_y_N']} N")
    mean = SURCHARGE + 0.5 * density * GRAVITY * HEIGHT
    need(abs(rest["mean_stress_yy_Pa"] / -mean - 1) < 0.01, f"mean vertical stress {rest['mean_stress_yy_Pa']}, by "
            f"hand {-mean}")
    need(abs(rest["mean_stress_xx_Pa"] / last["mean_stress_xx_Pa"] - 1) < 0.05,
            f"lateral {rest['mean_stress_xx_Pa']}, exact {last['mean_stress_xx_Pa']}")
    # What --check says: the classes and a time of the right size.
    loads = ["boundary.3.pressure=250e3", "boundary.3.history=[[0, 0.8], [1, 1]]", "solve.increments=20"]
    sets = [a for load in loads for a in ("--set", load)]
    for threads, rounds in (("1", 24), ("23", 2)):  # of cells side by side; the last round has one
        r = run(bvp, scene, "--check", "--set", "initial_stress.tolerance=0.05", "--threads", threads, *sets)
        need(r.returncode == 0 and f"in {count} classes" in r.stdout and f"({count} starts of 1 packings" in r.stdout,
             f"--check: {r.stdout} {r.stderr}")
        span = r"(?:(\d+) min )?([\d.]+) s"
        told = re.search(
            rf"run: {span} to {span} \(.* 1 to 4 sweeps each, 24 RVEs of (\d+) starts, ([\d.e-]+) s an inc", r.stdout)
        need(told is not None, f"--check, run time: {r.stdout}")
        if told:  # 20 increments of 1 to 4 sweeps; one RVE of each start, or each of them, whose steps take some 30 us
            low, high = (float(told[k + 1]) + 60 * float(told[k] or 0) for k in (1, 3))
            one, most = float(told[6]), 20 * 4 * rounds * float(told[6])
            least = 20 * math.ceil(count / int(threads)) * one
            need(abs(high - most) < 0.06 + 0.01 * most and abs(low - least) < 0.06 + 0.01 * least and 1e-5 < one < 0.3
                 and int(told[5]) == count, f"--check, {threads} threads: {told.group()}")
    stopped(tmp, scene, out[0], exact)


def stopped(tmp, scene, whole, exact):
    """Interrupted, then killed while cells are prepared, and gone on with: the same rows; nothing is made again."""
    part = os.path.join(tmp, "part")
    kept = os.path.join(part, "preparation.h5")
    command = [bvp, scene, "-o", part, "--threads", "1", "--set", "initial_stress.tolerance=0", "--set",
            "output.checkpoint_interval=1e-6"]
    sizes = []
    for how, signalled in (((), signal.SIGINT), (("--resume",), signal.SIGKILL)):
        p = subprocess.Popen([*command, *how], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        before = os.path.getmtime(kept) if os.path.exists(kept) else None
        for _ in range(6000):
            if p.poll() is not None or (os.path.exists(kept) and os.path.getmtime(kept) != before):
                break
            time.sleep(0.005)
        p.send_signal(signalled)
        output, error = p.communicate()
        need(not os.path.exists(os.path.join(part, "checkpoint.h5")), f"{signalled}: came after the preparation")
        if signalled == signal.SIGINT:
            need(p.returncode == 130 and "--resume goes on from preparation.h5" in error,
                    f"interrupted: exit {p.returncode} {error!r}")
        sizes.append(os.path.getsize(kept))
    need(sizes[1] > sizes[0] > 0, f"preparation.h5 does not grow: {sizes}")
    r = run(*command, "--resume", "--set", "initial_stress.k0=0.5")
    need(r.returncode == 2 and "another scene" in r.stderr and r.stderr.count("\n") == 1,
            f"other settings: exit {r.returncode} {r.stderr!r}")
    r = run(*command, "--resume")
    need(r.returncode == 0, f"resumed: exit {r.returncode} {r.stderr}")
    need(without_wall(whole) == without_wall(part), "resumed in its preparation: other rows")
    # Gone on from its end, a run has nothing to add: its summary is that of the whole, the times apart.
    os.remove(os.path.join(part, "summary.json"))
    before = os.path.getmtime(kept)  # written after every few cells that are made
    r = run(*command, "--resume")
    again = summary(part) if r.returncode == 0 else {}
    need(r.returncode == 0 and os.path.getmtime(kept) == before, f"resumed at its end: exit {r.returncode}: {r.stderr}")
    for of in (again, exact):
        for key in ("seconds", "threads", "scene", "scene_file"):
            of.pop(key, None)
        of.get("last_row", {}).pop("wall_s", None)
    kept_files = set(again.pop("files", [])) - set(exact.pop("files", []))
    need(kept_files == {"checkpoint.h5", "preparation.h5"}, f"files of a run that was stopped: besides {kept_files}")
    need(again == exact, "a resumed run's summary: " + "; ".join(f"{k}: {again.get(k)} for {exact.get(k)}"
            for k in {*again, *exact} if again.get(k) != exact.get(k)))


with tempfile.TemporaryDirectory() as folder:
    main(folder)
print(f"ground: {len(faults)} faults")
sys.exit(1 if faults else 0)
