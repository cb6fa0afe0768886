#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grus beside LIGGGHTS, LAMMPS and Yade on the same work: the same grains, law and time step, one core each, in turn.

  peers.py GRUS_BENCH GRUS_RVE [--out results.csv] [--repeats 5] [--only spheres|cell|shapes|bonded]
           [--sizes 1000,10000,50000]

spheres   dense Hertz-Mindlin spheres in a box of walls, the top one coming down at 500/s. The loop's wall time is what
          each program says of it; the loop's CPU time is a whole run less a run without those steps, for all alike; the
          whole program's are those of its process, with its default output. Stress: of the sample when the loop ends.
cell      a periodic cell that Yade packs at 1 MPa, then ten increments of 1e-3, each relaxed to an unbalanced force of
          1e-3.
bonded    spheres held together by bonds that never break: parallel bonds beside Yade's JCFpm, which has no moments, and
          its CohFrict, which has; LAMMPS where it has the package BPM is not compared yet. CPU time of the loop.
shapes    216 superquadrics of LIGGGHTS (a build that has them: LIGGGHTS_SUPERQUADRIC=path), beside poly-ellipsoids.

All figures are medians. Peers that are not installed are left out and named (Debian: liggghts, lammps, yade). `noise`:
how much of the core other programs had."""
import argparse
import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from statistics import median

import peers_decks as decks

PEERS = {"LIGGGHTS": "liggghts", "LAMMPS": "lmp", "Yade": "yade"}
STEPS = {  # with the warm-up a multiple of the 200 rows that a run writes: each step is of the same length
    1000: 4000, 10000: 2000, 50000: 600}
CORE = "0"


class Run:
    """One process on one core: what it printed, its wall, CPU and memory."""

    def __init__(self, command, folder, core=CORE):
        busy = self.busy(core)
        with open(os.path.join(folder, "printed"), "w+") as out:
            start = time.monotonic()
            process = subprocess.Popen(["taskset", "-c", core] + command, cwd=folder, stdout=out,
                                       stderr=subprocess.STDOUT, env=dict(os.environ, OMP_NUM_THREADS="1", DISPLAY=""))
            _, status, used = os.wait4(process.pid, 0)
            self.wall = time.monotonic() - start
            process.returncode = os.waitstatus_to_exitcode(status)
            out.seek(0)
            self.text = out.read()
        if process.returncode:
            sys.exit(f"{command[0]}: exit {process.returncode}: {self.text[-800:]}")
        self.cpu, self.megabytes = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
        self.noise = max(0.0, (self.busy(core) - busy - self.cpu) / self.wall)

    @staticmethod
    def busy(core):
        for line in open("/proc/stat"):
            if line.startswith(f"cpu{core} "):
                v = list(map(int, line.split()[1:9]))
                return (sum(v) - v[3] - v[4]) / os.sysconf("SC_CLK_TCK")

    def number(self, pattern):
        return float(re.findall(pattern, self.text)[-1])


def grus_loop(packing, steps, folder, tools):
    run = Run([tools.bench, "--packing", packing, str(steps)], folder)
    return run, run.number(r"wall=(\S+)"), run.number(r"stress=(\S+)")


def grus_program(packing, steps, folder, tools):
    decks.grus(packing, steps, folder)
    shutil.rmtree(os.path.join(folder, "out"), ignore_errors=True)
    run = Run([tools.rve, "scene.toml", "-o", "out", "--quiet", "--threads", "1"], folder)
    taken = json.load(open(os.path.join(folder, "out", "summary.json")))["counts"]["steps"]
    if taken != steps + decks.WARM:
        sys.exit(f"grus-rve took {taken} steps instead of {steps + decks.WARM}")
    return run, None, None


def molecular(program):
    def run_it(packing, steps, folder, tools):
        (decks.liggghts if program == "liggghts" else decks.lammps)(packing, folder)
        run = Run([program, "-in", "run.in", "-var", "more", str(steps)], folder)
        return run, run.number(r"Loop time of (\S+) on"), run.number(r"(?m)^\s*\d+\s+(\S+)\s*\n(?:Loop)")
    return run_it


def yade(packing, steps, folder, tools):
    decks.yade(packing, steps, folder)
    run = Run(["yade", "-n", "-x", "-j1", "run.py"], folder)
    return run, run.number(r"RESULT (\S+)"), run.number(r"STRESS (\S+)")


def spheres(tools, table):
    codes = [("Grus, loop alone", grus_loop), ("Grus", grus_program)]
    codes += [(name, yade if program == "yade" else molecular(program)) for name, program in PEERS.items()
              if name in tools.there]
    for grains in tools.sizes:
        steps = STEPS.get(grains, max(100, 20000000 // grains))
        with tempfile.TemporaryDirectory() as folder:
            packing = os.path.join(folder, "packing.txt")
            subprocess.run([tools.bench, "--make-packing", str(grains), packing], check=True)
            _, placed = decks.read(packing)
            runs = {name: [] for name, _ in codes}
            for _ in range(tools.repeats):
                for name, code in codes:
                    own = os.path.join(folder, name.replace(" ", "_"))
                    os.makedirs(own, exist_ok=True)
                    none = code(packing, 0, own, tools)[0] if name != "Grus" else None
                    runs[name].append((none, *code(packing, steps, own, tools)))
            work = len(placed) * steps / 1e6
            loop_of = {name: median([loop for _, _, loop, _ in rows]) for name, rows in runs.items() if name != "Grus"}
            for name, rows in runs.items():
                wholes = [r for _, r, _, _ in rows]
                line = {
                    "work": f"dense spheres {grains}", "who": name, "program wall s": median(r.wall for r in wholes),
                    "program CPU s": median(r.cpu for r in wholes), "MB": median(r.megabytes for r in wholes),
                    "noise": max(r.noise for r in wholes)
                }
                if name != "Grus":
                    line["stress MPa"] = median([s for _, _, _, s in rows]) / 1e6
                    line["million grain-steps/s"] = work / loop_of[name]
                    line["million grain-steps/CPU-s"] = work / median([r.cpu - none.cpu for none, r, _, _ in rows])
                    line["Grus is, loop"] = loop_of[name] / loop_of["Grus, loop alone"]
                if name != "Grus, loop alone":
                    line["Grus is, program"] = line["program wall s"] / median([r.wall for _, r, _, _ in runs["Grus"]])
                table(line)


def cell(tools, table):
    if "Yade" not in tools.there:
        return
    for grains in (400, 1000):
        with tempfile.TemporaryDirectory() as folder:
            decks.yade_cell(grains, folder)
            yades = [Run(["yade", "-n", "-x", "-j1", "run.py"], folder) for _ in range(tools.repeats)]
            ours = [
                Run([tools.bench, "--cell", os.path.join(folder, "cell.txt"), "10"], folder)
                for _ in range(tools.repeats)
            ]
            yade_ms = median([r.number(r"RESULT (\S+)") for r in yades])
            name = f"increment of 1e-3, Yade's cell of {grains}"
            table({
                "work": name, "who": "Yade", "ms": yade_ms, "steps": yades[0].number(r"STEPS (\S+)"),
                "stress MPa": yades[0].number(r"STRESS (\S+)") / 1e6
            })
            for safety in re.findall(r"safety=(\S+)", ours[0].text):
                def of(key):
                    return [float(re.search(rf"safety={safety} .*{key}=(\S+)", r.text)[1]) for r in ours]

                table({
                    "work": name, "who": f"Grus, safety {safety}", "ms": median(of("ms")), "steps": of("steps")[0],
                    "stress MPa": of("stress")[0] / 1e6, "error": of("error")[0],
                    "Grus is, loop": yade_ms / median(of("ms"))
                })


def shapes(tools, table):
    program = os.environ.get("LIGGGHTS_SUPERQUADRIC")
    ours = [Run([tools.bench, "--shapes", "1000", "2000"], tempfile.gettempdir()) for _ in range(tools.repeats)]
    speed = median([r.number(r"psps=(\S+)") for r in ours]) / 1e6
    table({"work": "dense bodies", "who": "Grus, poly-ellipsoids", "million grain-steps/s": speed})
    if not program:
        return print(
            "superquadrics are left out: Debian's liggghts is built without them (LIGGGHTS_SUPERQUADRIC=a build that "
            "has them)"
        )
    with tempfile.TemporaryDirectory() as folder:
        decks.superquadrics(6, folder)
        runs = [Run([program, "-in", "run.in", "-var", "more", "1000"], folder) for _ in range(tools.repeats)]
        theirs = median([216 * 1000 / r.number(r"Loop time of (\S+) on") for r in runs]) / 1e6
        table({
            "work": "dense bodies", "who": "LIGGGHTS, superquadrics", "million grain-steps/s": theirs,
            "Grus is, loop": speed / theirs
        })


def bonded_of(program, law):
    def run_it(packing, steps, folder, tools):
        if program == "grus":
            decks.bonded_grus(packing, max(steps, 1), folder)
            shutil.rmtree(os.path.join(folder, "out"), ignore_errors=True)
            run = Run([tools.rve, "scene.toml", "-o", "out", "--quiet", "--threads", "1"], folder)
            told = json.load(open(os.path.join(folder, "out", "summary.json")))
            return run, told["cells"]["bonds_start"]
        decks.bonded_yade(packing, steps, folder, law)
        run = Run(["yade", "-n", "-x", "-j1", "run.py"], folder)
        return run, run.number(r"BONDS (\S+)")
    return run_it


def bonded(tools, table):
    codes = [("Grus, parallel bonds", bonded_of("grus", None))]
    if "Yade" in tools.there:
        codes += [("Yade, JCFpm", bonded_of("yade", "JCFpm")), ("Yade, CohFrict", bonded_of("yade", "moments"))]
    for grains in tools.sizes:
        steps = STEPS.get(grains, max(100, 20000000 // grains))
        with tempfile.TemporaryDirectory() as folder:
            packing = os.path.join(folder, "packing.txt")
            subprocess.run([tools.bench, "--make-packing", str(grains), packing], check=True)
            count, ours = len(decks.read(packing)[1]), None
            for name, code in codes:
                took = []
                for _ in range(tools.repeats):
                    none, run = code(packing, 0, folder, tools)[0], code(packing, steps, folder, tools)
                    took.append(run[0].cpu - none.cpu)
                speed = count * steps / median(took) / 1e6
                ours = ours or speed
                table({"work": f"bonded spheres {grains}", "who": name, "bonds": run[1],
                       "million grain-steps/CPU-s": speed, "Grus is, loop": ours / speed})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench"), parser.add_argument("rve"), parser.add_argument("--out"), parser.add_argument(
        "--repeats", type=int, default=5)
    parser.add_argument("--only", choices=["spheres", "cell", "shapes",
                                           "bonded"]), parser.add_argument("--sizes", default="1000,10000,50000")
    tools = parser.parse_args()
    tools.bench, tools.rve, tools.sizes = os.path.abspath(tools.bench), os.path.abspath(
        tools.rve), [int(n) for n in tools.sizes.split(",")]
    tools.there = [name for name, program in PEERS.items() if shutil.which(program)]
    for name in PEERS:
        if name not in tools.there:
            print(f"{name} is not installed and left out")
    lines = []

    def table(line):
        lines.append(line)
        print("  ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{v}" for k, v in line.items()), flush=True)
        if not tools.out:
            return
        keys = list(dict.fromkeys(k for line in lines for k in line))
        with open(tools.out, "w", newline="") as f:
            writer = csv.DictWriter(f, keys, delimiter=";")
            writer.writeheader()
            writer.writerows({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in line.items()} for line in lines)

    for work in (spheres, cell, shapes, bonded):
        if tools.only in (None, work.__name__):
            work(tools, table)


if __name__ == "__main__":
    main()
