#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves in its folder, what --force clears, what is told before the packing: leftovers.py BIN"""
import os
import sys
import tempfile
import time

import scene_tools
from scene_tools import BRITTLE, ROCK, column, faults, need, run, summary, write

binaries = os.path.abspath(sys.argv[1])
rve, report = scene_tools.program(binaries, "grus-rve"), os.path.join(binaries, "grus-report")
bvp = os.path.join(binaries, "grus-bvp")  # not there in builds of the DEM alone

MATERIAL = ("[material.sand]\ndensity = 2650\nyoungs_modulus = \"60 GPa\"\npoissons_ratio = 0.17\n"
            "friction = 0.5\nrestitution = 0.5\n")
BALL = MATERIAL + """[[grain]]
radius = "1 mm"
position = [0, 0, "1.2 mm"]
velocity = [0, 0, -1]
[[wall]]
point = [0, 0, 0]
normal = [0, 0, 1]
rigid = true
[loading]
kind = "free"
duration = "2 ms"
"""
PACKED = MATERIAL + """[packing]
kind = "random"
box = ["30 mm", "30 mm", "30 mm"]
radius = { distribution = "uniform", min = "0.2 mm", max = "0.4 mm" }
solid_fraction = 0.6
[boundary]
kind = "walls"
[loading]
kind = "uniaxial-strain"
strain_rate = 500.0
final_strain = 0.02
"""
CELLS = """
[numerics]
safety = 0.2
[packing]
kind = "voronoi"
box = ["2 mm", "2 mm", "2 mm"]
cells = 8""" + ROCK + BRITTLE + """[[clamp]]
where = "z=min"
[[clamp]]
where = "z=max"
velocity = ["0 m/s", "0 m/s", "10 mm/s"]
[loading]
kind = "free"
duration = "0.3 ms"
[output]
bursts = "1 us"
broken_bonds = true
frames = 2
contacts = true
gradings = 2
checkpoint_interval = 1e-9
"""


def all_of(folder):
    return sorted(os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names)


def leftovers(tmp):
    """--force takes away all that the run before has written, a killed one's included, and nothing of the user's;
    summary.json lists what the run has written."""
    out, ball, rock = os.path.join(tmp, "left"), write(tmp, BALL, "ball.toml"), write(tmp, CELLS, "rock.toml")
    r = run(rve, rock, "-o", out)
    made = all_of(out)
    broken, peak = column(out, "bonds_broken")[-1], max(column(out, "nominal_stress_Pa"))
    end = f"peak nominal stress {peak / 1e6:.4g} MPa, 8 -> 8 grains, {broken:.0f} bonds broken, "
    need(broken > 0 and end in r.stdout, f"the last line says {r.stdout}")
    frames = [f"{of}/{of}_{k:05}.hdf" for of in ("contacts", "grains") for k in (0, 1)]
    tables = ["broken_bonds.csv", "bursts.csv", "checkpoint.h5", "contacts.hdf.series", "grading.csv",
              "grains.hdf.series", "history.csv", "summary.json"]
    whole = sorted([".grus", *tables, *frames])
    need(r.returncode == 0 and made == whole, f"rock: exit {r.returncode} {r.stderr} wrote {made}")
    need(summary(out)["files"] == tables, f"summary.json lists {summary(out).get('files')}")
    need(run(report, out).returncode == 0 and "report.html" in all_of(out), "a report in the run's folder")
    mine = ("notes.txt", "grains/mine.txt", "grains/grains_of_mine.hdf", "contacts/00000.hdf", "costs.csv",
            "macro/mine.hdf")
    for name in mine:
        os.makedirs(os.path.dirname(os.path.join(out, name)), exist_ok=True)
        write(out, "precious", name)
    write(tmp, "precious", "precious.csv")
    with open(os.path.join(out, ".grus"), "a") as f:  # a marker that leads elsewhere
        f.write("../precious.csv\n" + os.path.join(tmp, "precious.csv") + "\n.\ngrains\n\n")
    write(out, "torn", "history.csv.new")  # of a run that was killed while it wrote
    r = run(rve, ball, "-o", out, "--quiet", "--force")
    left = sorted([".grus", "history.csv", "summary.json", *mine])
    need(r.returncode == 0 and all_of(out) == left, f"--force left {all_of(out)} {r.stderr}")
    need(summary(out)["files"] == ["history.csv", "summary.json"], f"then summary.json lists {summary(out)['files']}")
    need(os.path.exists(os.path.join(tmp, "precious.csv")), "--force went outside")
    need(all(open(os.path.join(out, name)).read() == "precious" for name in mine), "--force touched what is the user's")


def early(tmp):
    """A folder that cannot be made is told before the packing, and costs nothing."""
    blocked = write(tmp, "a file", "blocked")
    slow = write(tmp, PACKED, "packed.toml")
    begin = time.time()
    r = run(rve, slow, "-o", os.path.join(blocked, "deep", "out"), "--quiet", timeout=60)
    said = r.returncode == 1 and "cannot create the folder: Not a directory" in r.stderr and r.stderr.count("\n") == 1
    need(said and time.time() - begin < 3, f"in a file: {r.stderr!r} after {time.time() - begin:.1f} s")
    r = run(rve, slow, "-o", os.path.join(tmp, "x" * 300, "out"), "--quiet", timeout=60)
    said = r.returncode == 1 and "cannot create the folder: File name too long" in r.stderr
    need(said and r.stderr.count("\n") == 1, f"a long name: {r.stderr!r}")


def macro(tmp):
    """The same of a macro problem with all that it can write; a resumed run of other settings names them."""
    out, scene = os.path.join(tmp, "macro"), os.path.join(scene_tools.here, "macro", "impact.toml")
    base = [bvp, scene, "-o", out, "--quiet", "--threads", "1", "--set", "solve.duration=5 us"]
    settings = ["--set", "output.costs=true", "--set", "output.checkpoint_interval=1e-3"]
    r = run(*base, *settings)
    tables = ["checkpoint.h5", "costs.csv", "grains_top.hdf.series", "history.csv", "macro.hdf.series",
              "preparation.h5", "summary.json"]
    places = (("grains_top", "grains"), ("macro", "macro"))
    frames = [f"{where}/{kind}_{k:05}.hdf" for where, kind in places for k in range(3)]
    whole = sorted([".grus", *tables, *frames])
    need(r.returncode == 0 and all_of(out) == whole, f"macro: {r.stderr} wrote {all_of(out)}")
    need(summary(out)["files"] == tables, f"macro: summary.json lists {summary(out).get('files')}")
    changed = run(*base, *settings, "--resume", "--set", "solve.linear_viscosity=0.2", "--set", "title=Other")
    said = "another scene: solve.linear_viscosity was 0.1, is 0.2; set it back"
    need(changed.returncode == 2 and said in changed.stderr, f"macro: other settings: {changed.stderr!r}")
    need(run(*base, *settings, "--resume", "--set", "title=Other").returncode == 0, "macro: another title")
    r = run(*base, "--force", "--set", "output.frames=0")
    left = [".grus", "history.csv", "summary.json"]
    need(r.returncode == 0 and all_of(out) == left, f"macro: --force left {all_of(out)}")


with tempfile.TemporaryDirectory() as folder:
    leftovers(folder)
    if os.path.exists(bvp):
        macro(folder)
    early(folder)
print(f"leftovers: {len(faults)} faults")
sys.exit(1 if faults else 0)
