# SPDX-License-Identifier: LGPL-3.0-or-later
"""Made-up runs with known answers for the tests of studies and calibrations: as these read them, and as a program
writes them that stands in for grus-rve."""
import contextlib
import io
import os
import shutil
import sys

import numpy as np

from scene_tools import need

PROGRAM = r'''#!/usr/bin/python3 -SE
# axial_stress_Pa = a e + b e^2 + c seed at the strains e = 0, ..., end; a scene or --set say what they are.
import json, os, signal, sys, time
arguments, folder = sys.argv[2:], os.path.dirname(os.path.abspath(sys.argv[0]))
with open(sys.argv[1]) as f:
    scene = {key: json.loads(text) for key, sign, text in (line.partition(" = ") for line in f) if sign}
for k, word in enumerate(arguments):
    if word == "--set":
        key, _, text = arguments[k + 1].partition("=")
        scene[key] = json.loads(text) if text else None
with open(os.path.join(folder, "calls"), "a") as f:
    f.write(" ".join(sys.argv[2:]) + "\n")
of = lambda key, default=0.0: scene.get(key, default)
if of("refused_from", 1e300) <= of("a"):
    sys.exit(print("scene: a: too large", file=sys.stderr) or 2)
columns = ["axial_strain", "axial_stress_Pa", "void_ratio", "breakages", "grains", "time_step_s"]
if "--columns" in arguments:
    sys.exit(print(*columns))
if "--check" in arguments:
    time.sleep(of("hangs"))
    sys.exit(print(of("told", "a\n  run time 2.0 s to 1 min 20 s (of it)\n  preparation about 4.0 s")))
if "--resume" in arguments and of("lost_checkpoint"):
    sys.exit(print("checkpoint.h5: damaged", file=sys.stderr) or 2)
out = arguments[arguments.index("-o") + 1]
os.makedirs(out, exist_ok=True)
if of("interrupts"):
    if of("ends", ""):  # a file that is written after a while, as a checkpoint is
        signal.signal(signal.SIGTERM, lambda *_: time.sleep(0.3) or open(of("ends"), "w").close() or sys.exit(130))
    os.kill(os.getppid(), 2)
    time.sleep(60)  # until it is stopped
if of("seed") in of("fails", []):
    sys.exit(print(of("says", "no room"), file=sys.stderr) or 1)
rows, seed = of("rows", 10), of("seed")
strain = [of("end", 0.2) * k / rows for k in range(rows + 1)]
stress = [of("a") * e + of("b") * e * e + of("c") * seed for e in strain]
broken = of("broken", 2) + seed
with open(os.path.join(out, "history.csv"), "w") as f:
    print(*columns, sep=",", file=f)
    for e, s in zip(strain, stress):
        print(e, s, 0.8 - e, broken if e else 0, 100 + seed, 1e-6 * (1 + e), sep=",", file=f)
unstable = seed in of("unstable", [])
results = {"peak_axial_stress_Pa": max(stress)}
if broken:
    results["peak_before_breakage_Pa"] = of("strength") + of("c") * seed
with open(os.path.join(out, "summary.json"), "w") as f:
    json.dump({"status": 3 if unstable else 0, "ending": "unstable" if unstable else "finished", "results": results,
               "counts": {"steps": 1000 + 10 * seed, "grain_steps": 1e5, "breakages": broken},
               "seconds": {"cpu": of("cost", 1.0) + seed, "loading_wall": 3.0, "preparation_wall": 40.0},
               "errors": {"worst_energy_error": 1e-3 * (1 + seed)},
               "files": ["history.csv"] + (["grading.csv"] if of("graded") else [])}, f)
if of("graded"):
    with open(os.path.join(out, "grading.csv"), "w") as f:
        print("strain,diameter_m,passing,mass_kg", file=f)
        for e in (0.0, 0.1, 0.2):  # passing = (d / 1 mm)^(2 - 5 e)
            for d in (1e-4, 2e-4, 4e-4, 1e-3):
                print(e, d, (d / 1e-3) ** (2 - 5 * e), 0.25, sep=",", file=f)
sys.exit(3 if unstable else 0)
'''
COLUMNS = {"axial_strain": [0.0, 0.5, 1.0], "breakages": [0.0, 1.0, 3.0], "grains": [5.0, 6.0, 8.0]}


def flat(numbers):
    if isinstance(numbers, (list, tuple)):
        return np.concatenate([np.empty(0), *map(flat, numbers)])
    return np.ravel(np.asarray(numbers, float))


def near(found, wanted, what, tolerance=1e-12, floor=1e-300):
    """Numbers, in whatever they are packed, are those that are wanted."""
    found, wanted = flat(found), flat(wanted)
    good = found.shape == wanted.shape and np.allclose(found, wanted, tolerance, floor, equal_nan=True)
    need(good, f"{what}: {found.tolist()} instead of {wanted.tolist()}")


def run(status=0, cpu=1.0, energy=0.0, results=None, counts=None, grading=None, **columns):
    """As read_run gives it, at strains of 0, 0.5 and 1 where no others are given; a column that is a number is one
    that rises to it evenly."""
    rising = {k: [v * e for e in COLUMNS["axial_strain"]] for k, v in columns.items() if isinstance(v, (int, float))}
    return {
        "columns": COLUMNS | columns | rising, "grading": grading or {}, "summary": {
            "status": status, "ending": "unstable" if status else "finished", "counts": counts or {},
            "seconds": {"cpu": cpu, "loading_wall": 2 * cpu}, "errors": {"worst_energy_error": energy},
            "results": results or {}
        }
    }


def installation(folder, binaries):
    """The package of a build, beside the program above; imported from there, it runs that."""
    shutil.copytree(os.path.join(binaries, "..", "python"), os.path.join(folder, "python"),
                    ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    os.makedirs(os.path.join(folder, "bin"))
    with open(os.path.join(folder, "bin", "grus-rve"), "w") as f:
        f.write(PROGRAM)
    os.chmod(f.name, 0o755)
    sys.path.insert(0, os.path.join(folder, "python"))
    return os.path.join(folder, "bin")


def unpainted():
    """Figures are made and not painted, which takes most of the time of a report."""
    from matplotlib.figure import Figure
    Figure.savefig = lambda figure, file, **_: file.write(b"")


def drawn(draw, *arguments):
    """Label -> (x, y) of the curves of what draw(ax, ...) draws, the axes' texts, and all axes."""
    import matplotlib.pyplot as plt
    fig, ax = plt.subplots()
    draw(ax, *arguments)
    curves = {line.get_label(): (line.get_xdata(), line.get_ydata()) for a in fig.axes for line in a.get_lines()}
    texts = [t for a in fig.axes for t in (a.get_title(), a.get_xlabel(), a.get_ylabel()) if t]
    plt.close(fig)
    return curves, texts, fig


def all_drawn(plots, read):
    """read(draw, what else is asked) of each figure that plots() makes, in their order."""
    from grus import figures
    from grus.report import bvp_plots, rve_plots
    found = []

    def figure(draw, **more):
        found.append(read(draw, more))
        return "<figure>"
    modules, before = (bvp_plots, rve_plots), figures.figure
    for module in modules:
        module.figure = figure
    try:
        plots()
    finally:
        for module in modules:
            module.figure = before
    return found


def calls(programs):
    """What the program has been asked since the last time: a line each."""
    path = os.path.join(programs, "calls")
    if not os.path.exists(path):
        return []
    with open(path) as f:
        told = f.read().splitlines()
    os.remove(path)
    return told


def command(main, *arguments):
    """(exit status, what was said, what was said of errors) of a command's main() with arguments."""
    before, sys.argv = sys.argv, [main.__module__, *arguments]
    said, errors = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(errors):
            status = main()
    except SystemExit as e:
        status = e.code
    finally:
        sys.argv = before
    return status, said.getvalue(), errors.getvalue()
